"""Motion errors of real cams: deviations of displacement, velocity and acceleration from the programmed motion.

To first order, errors add up. In the worst case every error is at the end of its tolerance zone that moves the tool
in the same direction as the others. The root sum square combines independent errors:

    worst case = Σ c·t,    root sum square = |Σ c·m| + 3·√(Σ c²·σ² + Σ c_i·c_k·cov_ik)

c is the response of the motion to an error (``tolerances.response``), t the end of its zone, m its mean, σ its
standard deviation. cov_ik is the covariance of two errors i ≠ k of one batch, √(s_i·s_k)·σ_i·σ_k for normal errors.

If the sum is normal, the root sum square contains 99.73 % of the cams at each cam angle. The sum is nearly normal
if several errors have a similar size. For a single uniform error 3σ exceeds the worst case; then the worst case is
reported instead. Parts may spread beyond their zone (a Cpk below 1, measured errors). Then this limit is the worst
case of the furthest parts.

Source: Greenwood and Chase, Worst case tolerance analysis with nonlinear problems, J. Eng. Ind. 110, 1988.

The module also writes the cams of ``camopt tolerance`` to disk: the worst ones, a batch, and the allocated one.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, inf, pi
from typing import Any, ClassVar, NamedTuple

import numpy as np

from camopt.core.mistakes import UnknownName, suggest_names
from camopt.core.numerics import FloatArray
from camopt.core.numerics.budget import Budget
from camopt.core.quantities.display import Drawable
from camopt.core.storage.publishing import Publication
from camopt.model.effects.error_response import RESPONSE_ORDERS
from camopt.model.effects.motion import motion_table_unit, motion_unit_factor
from camopt.model.motion.programme import JUMP_SIDE
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.problem.limits import ERROR_LIMITS
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.scene.scene_file import write_scene
from camopt.scene.tolerances import NUMBER_TABLES, does_error_move_tool
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import NUMERIC, Cell, Result, Table, table_of, to_json_values
from camopt.solve.tolerances.allocation import Allocation
from camopt.solve.tolerances.batch import Batch, row_of_field
from camopt.solve.tolerances.dwells_and_passages import MOTION_PROOF_WORK, WobbleSearch, WorstWobble
from camopt.solve.tolerances.errors import BORE, BORE_DIRECTION, error_unit
from camopt.solve.tolerances.margins import Margin, ToleranceBox, margins_table
from camopt.solve.tolerances.plays_and_interference import Play, list_plays, lost_preload_sentence
from camopt.solve.tolerances.turn_errors import (
    BAND_NAME,
    MOTION_NAMES,
    Contribution,
    TurnErrors,
    no_tolerances_error,
    root_sum_square_range,
    variance_by_tolerance,
    worst_case_range,
)
from camopt.solve.tolerances.worst_case import NO_ERROR, WorstCase, make_worst_cam_search

FAR_BOUND = 1e-3
"""A note reports the gap if the bound exceeds the worst cam by a larger share."""
IDLE_ERROR = 1e-9
"""The note on the worst cam leaves out errors with a smaller share of the worst case."""
DWELL_ANGLES = 33
"""Number of cam angles at which the change in a dwell is computed to first order."""
ROOT_SUM_SQUARE_NOTE = (
    "The root sum square assumes independent errors{of_batch} with a normal sum. It contains 99.73 % of the cams "
    "at each cam angle, but fewer over the whole turn; a batch of random cams shows how many."
)
DWELL_ARC_NOTE = "A dwell is here the arc of the cam that is touched in it. For shaft angles use camopt timing."
BEYOND_ZONE_NOTE = (
    "Parts spread beyond the tolerance of {keys}. The root sum square includes them; the worst case, the proven "
    "bound and the worst cam do not."
)


class MotionError(NamedTuple):
    """Error of the displacement, velocity or acceleration of the tool, to first order.

    Examples
    --------
    >>> scene = camopt.find_scene("bucket-valve").replace(**{"tolerances.profile": 0.01})
    >>> camopt.tolerance(scene).errors[0].worst
    0.01
    """

    name: str
    unit: str
    worst: float
    """Worst case over the turn, in ``unit``."""
    at_deg: float | None
    """Cam angle of the worst case [deg]; the first one of an infinite error, None if it is infinite everywhere."""
    three_sigma: float
    """Largest root sum square over the turn, ``|mean|`` + 3σ; at most the worst case of the furthest parts."""
    three_sigma_at_deg: float | None
    """Cam angle of the largest root sum square [deg]."""
    shares: dict[str, float]
    """Contribution of each tolerance to the worst case; they add up to it.

    Of an infinite worst case: the largest contribution of each tolerance over the turn.
    """
    variances: dict[str, float]
    """Share of each tolerance in the variance at ``three_sigma_at_deg``; the shares add up to 1.

    A share includes the covariance with errors of the same batch. It is negative if the error compensates the
    others.
    """


class DwellError(NamedTuple):
    """Largest movement of the follower in a dwell.

    Examples
    --------
    >>> scene = camopt.find_scene("two-pauses").replace(**{"tolerances.bore_eccentricity": 0.01})
    >>> len(camopt.tolerance(scene).dwells)
    2
    """

    start_deg: float
    end_deg: float
    """End of the dwell [deg]; less than ``start_deg`` if the dwell spans the end of the turn."""
    change: float
    """Largest change between any two places of contact on the arc of the dwell, to first order [mm or deg]."""
    worst_case: WorstWobble
    """Largest change by exact contact: the proven bound, and a cam that nearly reaches it."""


@dataclass(frozen=True)
class MotionErrors(Result, Drawable):
    """Errors of the motion that the tolerances of a scene permit.

    Attributes
    ----------
    scene : Scene
        The cam, with its ``[tolerances]``.
    errors : tuple of MotionError
        Errors of displacement, velocity and acceleration of the tool, to first order.
    worst_case : WorstCase
        Worst case of the tool's displacement by exact contact: the proven bound, and a cam that nearly reaches it.
        ``worst_cases`` also has velocity and acceleration.
    reason : str
        Why an error is infinite; "" if every error is finite.
    margins : tuple of Margin
        Margin that tolerances of numbers leave to each limit, in the order of the limits.
    plays : tuple of Play
        Two contacts: their distance, and the remaining interference and preload. A groove: the backlash.
    beyond : tuple of str
        Tolerances whose parts spread beyond them: those with a Cpk below 1, and measured ones. The proven bounds do
        not cover such parts.
    batch : Batch or None
        The cams from ``sample_cams``, if the command drew a batch.
    allocation : Allocation or None
        The grades from ``allocate``, if the command chose grades.

    Examples
    --------
    >>> scene = camopt.find_scene("roller-1000rpm").replace(tolerances={"follower.offset": 0.02})
    >>> found = camopt.tolerance(scene)
    >>> round(found.errors[0].worst, 5)
    0.01777
    """

    picture: ClassVar[str] = "pictures.tolerances"
    scene: Scene
    errors: tuple[MotionError, ...]
    worst_case: WorstCase
    reason: str
    margins: tuple[Margin, ...] = ()
    plays: tuple[Play, ...] = ()
    beyond: tuple[str, ...] = ()
    batch: Batch | None = None
    allocation: Allocation | None = None
    main_rows: ClassVar[str] = "errors"

    @cached_property
    def worst_cases(self) -> tuple[WorstCase, WorstCase, WorstCase]:
        """Worst cases of displacement, velocity and acceleration of the tool by exact contact, each of its own cam.

        ``worst_case`` is the first. The other two are computed at the first access, usually in a second, in 20 s at
        most. Where the programmed acceleration jumps, a late or early cam has the whole jump as its error until it
        reaches the jump. The bound is then the jump plus all other errors.
        """
        turn = self._turn_errors
        if not turn.node_contributions:
            return self.worst_case, NO_ERROR, NO_ERROR
        return (
            self.worst_case,
            make_worst_cam_search(turn, 1).find_worst_cam(),
            make_worst_cam_search(turn, 2).find_worst_cam(),
        )

    @cached_property
    def dwells(self) -> tuple[DwellError, ...]:
        """The dwells in the order of the turn, each with its proven bound; computed at the first access."""
        return tuple(_dwell_errors(self._turn_errors))

    @cached_property
    def _turn_errors(self) -> TurnErrors:
        return TurnErrors(self.scene, resolve_design(self.scene))

    def records(self) -> list[dict[str, Any]]:
        """One mapping for each of displacement, velocity and acceleration."""
        return [each._asdict() for each in self.errors]

    def table(self) -> Table:
        """Worst case with the contribution of each tolerance, root sum square and proven bound, a column each."""
        by_motion = dict(zip(MOTION_NAMES, self.worst_cases, strict=True))
        rows = [
            row_of_field("worst case", self.errors, "worst"),
            *({"": key, **{each.name: each.shares[key] for each in self.errors}} for key in self.errors[0].shares),
            row_of_field("at cam angle, deg", self.errors, "at_deg"),
            row_of_field(BAND_NAME, self.errors, "three_sigma"),
            row_of_field("at cam angle, deg", self.errors, "three_sigma_at_deg"),
            {
                "": "proven upper bound",
                **{name: each.bound for name, each in by_motion.items() if each.bound < inf},
            },
            {"": "worst cam found, exact contact", **{name: abs(each.error) for name, each in by_motion.items()}},
        ]
        if self.dwells:
            wobbles = [each.worst_case for each in self.dwells]
            bound = max(each.bound for each in wobbles)
            changes = {
                "change in a dwell": max(each.change for each in self.dwells),
                "change in a dwell, proven upper bound": bound if bound < inf else "",
                "change in a dwell, worst cam found": max(each.change for each in wobbles),
            }
            rows += [{"": head, MOTION_NAMES[0]: change} for head, change in changes.items()]
        units = {each.name: each.unit for each in self.errors}
        table = table_of(f"{self.scene.name}: errors of the motion", rows, ["", *MOTION_NAMES], units=units)
        sentences = (
            self.reason,
            *self._unproved_dwell_sentences,
            self.jumps,
            self._worst_cam_sentence,
            *self._velocity_acceleration_sentences,
            self._worst_wobble_sentence,
        )
        return replace(table, note=" ".join(filter(None, [*sentences, self._assumptions_note])))

    @property
    def _assumptions_note(self) -> str:
        """What the root sum square assumes, and the tolerances whose parts spread beyond them."""
        batches = [
            each.batch
            for key, each in self.scene.tolerances.number_and_angle_tolerances.items()
            if does_error_move_tool(key) and each.batch
        ]
        note = ROOT_SUM_SQUARE_NOTE.format(
            of_batch=" (except within a batch)" if len(batches) > len({*batches}) else ""
        )
        return f"{note} {BEYOND_ZONE_NOTE.format(keys=', '.join(self.beyond))}" if self.beyond else note

    @property
    def _worst_cam_sentence(self) -> str:
        """The errors of the worst cam of displacement, and its cam angle."""
        worst = self.worst_case
        if not worst.errors:
            return "No tolerance moves the tool."
        shares, least = self.errors[0].shares, IDLE_ERROR * self.errors[0].worst
        errors = self._errors_with_units(
            {key: error for key, error in worst.errors.items() if shares.get(key, least) >= least}
        )
        gap = _gap_sentence(worst.gap, abs(worst.error))
        return f"The worst cam, at {_degrees_text(worst.at_deg)}: {errors}.{gap}"

    @property
    def jumps(self) -> str:
        """What a jump of the acceleration means for a late or early cam, a sentence; "" without a jump."""
        problem = resolve_design(self.scene)
        jumps = [jump for jump in problem.programme.tool.jumps if jump.order > 1]
        if problem.programme.corners or not (jumps and self.worst_cases[-1].errors):
            return ""
        largest = max(jumps, key=lambda jump: abs(jump.size))
        size = with_unit(motion_unit_factor(problem.setup, 2) * abs(largest.size), self.errors[-1].unit)
        where = f"The acceleration jumps by up to {size} at {_degrees_text(degrees(largest.at))}"
        return f"{where}: a late or early cam has the whole jump as its error until it reaches that angle."

    @property
    def _velocity_acceleration_sentences(self) -> Iterator[str]:
        """The worst cams of velocity and acceleration, or why no bound of them is proved."""
        for name, worst in zip(MOTION_NAMES[1:], self.worst_cases[1:], strict=True):
            if worst.unproved and worst.unproved != self.worst_case.unproved:
                yield f"No bound of the {name} is proved: {worst.unproved}."
            if worst.errors and not (self.worst_case.unproved and worst.unproved):
                gap, errors = _gap_sentence(worst.gap, abs(worst.error)), self._errors_with_units(worst.errors)
                yield f"The worst cam of {name}, at {_degrees_text(worst.at_deg)}: {errors}.{gap}"

    @property
    def _unproved_dwell_sentences(self) -> Iterator[str]:
        for dwell in self.dwells:
            if dwell.worst_case.unproved:
                where = f"the dwell from {dwell.start_deg:.6g} to {dwell.end_deg:.6g} deg"
                yield f"No bound is proved for {where}: {dwell.worst_case.unproved}."

    @property
    def _worst_wobble_sentence(self) -> str:
        """The errors of the cam with the largest change in a dwell: profile at both places, axis of the bore."""
        worst = max((each.worst_case for each in self.dwells), key=lambda each: each.change, default=None)
        if worst is None or not worst.change:
            return ""
        highest, lowest = (
            self._errors_with_units({key: errors[key] for key in worst.at_lowest})
            for errors in (worst.errors, worst.at_lowest)
        )
        bore = self._errors_with_units(
            {key: error for key, error in worst.errors.items() if key in (BORE, BORE_DIRECTION)}
        )
        ends = (
            (f"highest at {_degrees_text(worst.highest_deg)}", highest),
            (f"lowest at {_degrees_text(worst.lowest_deg)}", lowest),
        )
        places = ", ".join(f"{place} with {errors}" if errors else place for place, errors in ends)
        gap = _gap_sentence(worst.gap, worst.change)
        return f"The worst cam of a dwell: {'; '.join(filter(None, [places, bore]))}.{gap} {DWELL_ARC_NOTE}"

    def _errors_with_units(self, errors: Mapping[str, float]) -> str:
        return ", ".join(f"{key} {with_unit(each, error_unit(self.scene, key))}" for key, each in errors.items())

    def sections(self) -> Iterator[Table]:
        """Tables of motion errors, plays and margins; then those of the batch and the allocation, if any."""
        yield self.table()
        yield from filter(None, (self.plays_table(), self.margins_table()))
        for part in filter(None, (self.batch, self.allocation)):
            yield from part.tables()

    def values_for_json(self) -> dict[str, Any]:
        """The result for ``--json``: errors, worst cases, dwells, plays and margins, one record each."""
        worst_cases = zip(self.errors, self.worst_cases, strict=True)
        parts = {"batch": self.batch, "allocation": self.allocation}
        return {
            "scene": self.scene.name,
            "errors": self.errors,
            "worst_case": self.worst_case,
            "worst_cases": [
                {"name": each.name, "unit": each.unit, **to_json_values(worst._asdict())}
                for each, worst in worst_cases
            ],
            "dwells": self.dwells,
            "reason": self.reason,
            "plays": self.plays,
            "margins": self.margins,
            **{key: each.values_for_json() for key, each in parts.items() if each},
        }

    def margins_table(self) -> Table | None:
        """The limits with the worst cam's value, and whether every cam holds them; None without margins."""
        return margins_table(self.scene, self.margins) if self.margins else None

    def plays_table(self) -> Table | None:
        """Distance, interference, preload and backlash of two contacts; None for a follower with one contact."""
        heads = ["", "nominal", "least", "most"]
        rows = [[each.what, *(with_unit(v, each.unit) for v in each[2:])] for each in self.plays]
        kinds = [Cell(head, NUMERIC if head else "") for head in heads]
        title, lost = f"{self.scene.name}: held from both sides", "".join(map(lost_preload_sentence, self.plays))
        return Table.from_texts(title, kinds, rows, lost) if rows else None

    def worst_motion(self, name: str = MOTION_NAMES[0]) -> Scene:
        """The scene of the cam with the largest error found of displacement, velocity or acceleration.

        Each tolerance of a number is replaced by the error of one measured part (``values`` with one number). The
        profile and the axis of the bore keep their tolerances: the worst case has both errors at the ends.

        Raises
        ------
        UnknownName
            If ``name`` is not ``displacement``, ``velocity`` or ``acceleration``.
        """
        if name not in MOTION_NAMES:
            raise UnknownName(f"{name!r} is not a motion; {suggest_names(str(name), MOTION_NAMES)}")
        worst = self.worst_case if name == MOTION_NAMES[0] else self.worst_cases[MOTION_NAMES.index(name)]
        numbers = {
            key: error
            for key, error in worst.errors.items()
            if key in self.scene.tolerances.number_and_angle_tolerances
        }
        return self.scene.replace(**{f"tolerances.{key}": {"values": [each]} for key, each in numbers.items()})

    def worst_cam(self, limit: str) -> Scene:
        """The scene of the worst cam found for a limit.

        Its numbers include the errors, and have no tolerances. Tolerances of the profile, the bore and angles stay.
        If none stays, limits on motion errors are removed.

        Raises
        ------
        UnknownName
            If the scene has no such limit.
        """
        margins = {each.limit: each for each in self.margins if each.sizes}
        if limit not in margins:
            raise UnknownName(f"{limit!r} is not a limit with a margin; {suggest_names(str(limit), margins)}")
        tables = self.scene.to_dict()
        kept = {key: each for key, each in tables["tolerances"].items() if key not in NUMBER_TABLES}
        limits = {f"limits.{key}": None for key in ERROR_LIMITS if not kept and key in tables.get("limits", {})}
        return self.scene.replace(**{"tolerances": kept, "search.robust": None, **limits, **margins[limit].sizes})


def tolerance(scene: SceneSource) -> MotionErrors:
    """Errors of the motion of real cams within the ``[tolerances]`` of a scene.

    The profile is cut for the sizes of the scene, with errors along its normal. The follower is assembled with
    errors of its sizes. Errors are those of the tool: a train transmits the errors of its follower.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with all sizes, and ``[tolerances]`` or ``part.profile_tolerance``.

    Returns
    -------
    MotionErrors
        Worst cases, root sum squares, contributions of each tolerance, and changes in dwells, to first order. The
        neglected terms of second order are below 0.05 µm for errors of 10 µm. ``worst_cases`` neglect nothing, and
        bound the errors of all cams within the tolerances. An error is infinite where the motion that it changes
        jumps. It is also infinite if it depends on the slope of a profile whose waves are not limited.

    Raises
    ------
    BadInput
        If a size is missing, or the scene has no tolerances.

    Examples
    --------
    >>> scene = camopt.find_scene("roller-1000rpm").replace(tolerances={"profile": 0.01, "waves": 20})
    >>> [round(each.worst, 4) for each in camopt.tolerance(scene).errors]
    [0.0134, 0.028, inf]
    """
    scene = scene_from(scene)
    scene = scene.with_profile_tolerance_moved
    turn = TurnErrors(scene, resolve_design(scene))
    margins = ToleranceBox.from_scene(scene, turn.problem).margins
    if not (turn.node_contributions or scene.tolerances.numbers):
        raise no_tolerances_error(turn.problem.file)
    worst_case = make_worst_cam_search(turn).find_worst_cam() if turn.node_contributions else NO_ERROR
    errors = first_order_errors(turn)
    reason = " ".join(_infinite_or_unproved_reasons(turn, worst_case, errors[0].shares))
    beyond = tuple(each.key for each in turn.node_contributions if any(side.any() for side in each.beyond_zone))
    return MotionErrors(scene, errors, worst_case, reason, margins, tuple(list_plays(turn)), beyond)


def _degrees_text(deg: float) -> str:
    return f"{number_text(round(deg, 9))} deg"


def _gap_sentence(gap: float, error: float) -> str:
    """How much larger the bound is than the error of the worst cam; "" if it is hardly larger."""
    share = gap / error if error else 0.0
    return f" The proven bound is {100.0 * share:.2g} % larger." if FAR_BOUND < share < inf else ""


def first_order_errors(turn: TurnErrors) -> tuple[MotionError, ...]:
    """Errors of displacement, velocity and acceleration, to first order."""
    return tuple(_first_order_motion_error(turn, order) for order in range(RESPONSE_ORDERS))


def _first_order_motion_error(turn: TurnErrors, order: int) -> MotionError:
    setup, unit = turn.problem.setup, motion_unit_factor(turn.problem.setup, order)
    head = MOTION_NAMES[order], motion_table_unit(setup, order)
    if not turn.node_contributions:
        return MotionError(*head, 0.0, None, 0.0, None, {}, {})
    if unbounded := turn.angles_of_unbounded_tolerances(order):
        at = next((degrees(angle) for angle in unbounded.values() if angle is not None), None)
        infinite = {
            each.key: unit * float(worst_case_range([each], order).magnitude.max())
            for each in turn.node_contributions
        } | dict.fromkeys(unbounded, inf)
        causes = {key: float(key in unbounded) / len(unbounded) for key in infinite}
        return MotionError(*head, inf, at, inf, at, infinite, causes)
    worst_at, band_at = (
        turn.angle_of_largest_total(total, order) for total in (worst_case_range, root_sum_square_range)
    )
    at_worst, at_band = (turn.contributions_at(np.array([place])) for place in (worst_at, band_at))
    ends = np.array([[each.upper[order, 0], -each.lower[order, 0]] for each in at_worst])
    shares = unit * ends[:, ends.sum(axis=0).argmax()]
    parts = variance_by_tolerance(at_band, order)[:, 0]
    return MotionError(
        *head,
        float(shares.sum()),
        degrees(worst_at),
        unit * float(root_sum_square_range(at_band, order).magnitude[0]),
        degrees(band_at),
        _values_by_contribution_key(at_worst, shares),
        _values_by_contribution_key(at_band, parts / (parts.sum() or 1.0)),
    )


def _values_by_contribution_key(contributions: list[Contribution], values: FloatArray) -> dict[str, float]:
    return {each.key: float(value) for each, value in zip(contributions, values, strict=True)}


def _dwell_errors(turn: TurnErrors) -> Iterator[DwellError]:
    """The dwells of the motion, in the order of the turn."""
    unit, dwells = motion_unit_factor(turn.problem.setup, 0), turn.problem.programme.tool.dwells
    search, budget = make_worst_cam_search(turn), Budget(MOTION_PROOF_WORK)
    for number, stroke in enumerate(dwells):
        worst_case = WobbleSearch(search, stroke).find_worst_wobble(budget.share(len(dwells) - number))
        contributions = turn.contributions_at(np.linspace(stroke.start, stroke.end - JUMP_SIDE, DWELL_ANGLES))
        change = unit * sum(each.change() for each in contributions)
        over = 2.0 * pi if stroke.end > turn.problem.programme.strokes[-1].end else 0.0
        yield DwellError(degrees(stroke.start), degrees(stroke.end - over), change, worst_case)


def _infinite_or_unproved_reasons(
    turn: TurnErrors, worst_case: WorstCase, shares: dict[str, float]
) -> Iterator[str]:
    """Why errors are infinite or unproved, one sentence each."""
    corners = turn.problem.programme.corners
    if worst_case.unproved:
        where = f" at {degrees(corners[0].at):.6g} deg" if corners else ""
        largest = max(shares, key=shares.__getitem__)
        smaller = "" if corners else f" {largest} has the largest share: tighten it first."
        yield f"No bound of the displacement is proved: {worst_case.unproved}{where}.{smaller}"
    if turn.impulses:
        order = min(turn.impulses.values()).order
        name = MOTION_NAMES[order]
        yield (
            f"The {name} of the motion jumps at {turn.impulse_angles_text(order)}. An error that moves the jump "
            f"has an infinite {name} there to first order; on a real cam it is a short, steep ramp."
        )
    if turn.scene.tolerances.profile and turn.scene.tolerances.waves is None:
        yield "The slope of the profile's error has no bound without tolerances.waves: set it, such as waves = 20."


WORST_FILE, ALLOCATED_FILE, CAMS_FILE, HISTOGRAM_FILE = (
    "worst-{}.toml",
    "allocated.toml",
    "cams.parquet",
    "cams.svg",
)
CAM_FILES = (WORST_FILE.format("*"), ALLOCATED_FILE, CAMS_FILE, HISTOGRAM_FILE)
"""Scenes of the worst motions, of the worst cam of each limit, and of the allocation; the table of a batch, and its
picture."""


def write_worst_cams_and_batch(result: MotionErrors, unit: Publication) -> None:
    """Write the scenes of the worst motions, worst cams of limits and the allocation, and the table of a batch."""
    motions = dict(zip(MOTION_NAMES, ("motion", "motion-velocity", "motion-acceleration"), strict=True))
    for (name, file), worst in zip(motions.items(), result.worst_cases, strict=True):
        if worst.errors:
            write_scene(unit.staged_path(WORST_FILE.format(file)), result.worst_motion(name))
    for margin in result.margins:
        if margin.quantity and margin.worst != margin.nominal:
            write_scene(unit.staged_path(WORST_FILE.format(margin.limit)), result.worst_cam(margin.limit))
    if result.allocation:
        write_scene(unit.staged_path(ALLOCATED_FILE), result.allocation.scene)
    if result.batch:
        result.batch.write(unit.staged_path(CAMS_FILE))
