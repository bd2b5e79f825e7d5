"""Motion errors: how far displacement, velocity and acceleration of a real cam may be from those asked.

To first order errors add up. At worst each is at the end of its zone that moves the motion the same way as the
others; errors that are independent of each other have the root of the sum of their squared deviations:

    worst = Σ c·t,    band = |Σ c·m| + 3·√(Σ c²·σ² + Σ c_i·c_k·cov_ik)

with the answer c of the motion (``tolerances.response``), the zone's end t, the mean m, the standard deviation σ,
and the covariance of two errors i ≠ k of one batch, √(s_i·s_k)·σ_i·σ_k of normal ones. The band is the root sum
square. If the sum is normal it holds 99.73 % of the cams at each cam angle: it nearly is if there are several
errors of one order. With one that is uniform 3σ is beyond the worst case, which takes its place. Where parts spread
beyond their zone (a Cpk below 1, measured errors), the furthest parts are the worst case that does so.

Source: Greenwood and Chase, Worst case tolerance analysis with nonlinear problems, J. Eng. Ind. 110, 1988.

The cams of ``camopt tolerance`` on disk: the worst ones, a batch, and one with chosen grades.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, inf, pi
from typing import Any, ClassVar, NamedTuple

import numpy as np

from camopt.core.mistakes import UnknownName, suggest_names
from camopt.core.numerics import FloatArray
from camopt.core.quantities.display import Drawable
from camopt.core.storage.publishing import Publication
from camopt.model.effects.error_response import RESPONSE_ORDERS
from camopt.model.effects.motion import motion_scale, motion_table_unit
from camopt.model.motion.programme import JUMP_SIDE
from camopt.scene.arguments import SceneSource, scene_from
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.scene.scene_file import write_scene
from camopt.scene.tolerances import moves_tool
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import NUMERIC, Cell, Result, Table, table_of, to_json_values
from camopt.solve.tolerances.allocation import Allocation
from camopt.solve.tolerances.batch import Batch
from camopt.solve.tolerances.dwells_and_passages import WorstWobble, worst_wobbles
from camopt.solve.tolerances.errors import BORE, BORE_DIRECTION, error_unit
from camopt.solve.tolerances.margins import Margin, ToleranceBox, margins_table, scene_of_cam
from camopt.solve.tolerances.plays_and_interference import Play, list_plays, lost_preload_sentence
from camopt.solve.tolerances.turn_errors import (
    BAND_NAME,
    MOTION_NAMES,
    Contribution,
    TurnErrors,
    no_tolerances_error,
    root_sum_square_magnitude,
    variances,
    worst_case_magnitude,
)
from camopt.solve.tolerances.worst_case import NO_ERROR, WorstCase, worst_search

FAR_BOUND = 1e-3
"""A bound that is further above the worst cam, relative, is told."""
IDLE_ERROR = 1e-9
"""An error that contributes less to the worst case, relative, is not told of the worst cam."""
DWELL_ANGLES = 33
"""Cam angles at which a dwell is looked at."""
ROOT_SUM_SQUARE_NOTE = (
    "The root sum square takes errors as independent{of_batch} and their sum as normal: 99.73 % of the cams are "
    "within it at each cam angle, fewer all over the turn: a batch of cams counts them."
)
DWELL_ARC_NOTE = (
    "A dwell is the arc of the cam on which it is touched there, not shaft angles: camopt timing has these."
)
BEYOND_ZONE_NOTE = (
    "Parts are beyond the tolerance of {keys}: the root sum square has them; worst case, proof and worst cam not."
)


class MotionError(NamedTuple):
    """How far one of displacement, velocity and acceleration may be off at worst, and by tolerances.

    Examples
    --------
    >>> scene = camopt.find_scene("bucket-valve").replace(**{"tolerances.profile": 0.01})
    >>> camopt.tolerance(scene).errors[0].worst
    0.01
    """

    name: str
    unit: str
    worst: float
    at_deg: float | None
    """The cam angle of the worst case; of an infinite one where it first is; None if it is so everywhere."""
    three_sigma: float
    """The largest root sum square, ``|mean|`` + 3σ; no more than the worst case, if no part is beyond its zone."""
    three_sigma_at_deg: float | None
    shares: dict[str, float]
    """What each tolerance contributes to the worst case, which is their sum; to an infinite one its own largest."""
    variances: dict[str, float]
    """The share of each tolerance in the variance at the angle of the band; adds up to 1.

    With those of its batch; below 0 of one that takes off what the others of it add.
    """


class DwellError(NamedTuple):
    """How far the follower may move in a dwell, at worst.

    Examples
    --------
    >>> scene = camopt.find_scene("two-pauses").replace(**{"tolerances.bore_eccentricity": 0.01})
    >>> len(camopt.tolerance(scene).dwells)
    2
    """

    start_deg: float
    end_deg: float
    """Below ``start_deg`` of one that goes on over the end of the turn."""
    change: float
    """Between any two places of contact on its arc, to first order, mm (deg)."""
    worst_case: WorstWobble
    """By exact contact: what no cam exceeds, proved, and a cam that nearly has it."""


@dataclass(frozen=True)
class MotionErrors(Result, Drawable):
    """How far the motion may be from the one that was asked, by the tolerances of a scene.

    Attributes
    ----------
    scene : Scene
        The cam, with its ``[tolerances]``.
    errors : tuple of MotionError
        Of displacement, velocity and acceleration of the tool, to first order.
    worst_case : WorstCase
        Of the displacement of the tool by exact contact: what no cam exceeds, proved, and a cam that nearly has it.
        ``worst_cases`` has those of velocity and acceleration too.
    reason : str
        Why an error is infinite; "" if none is.
    margins : tuple of Margin
        What tolerances of numbers leave of each limit, in the order of the limits.
    plays : tuple of Play
        Of two contacts what they are apart, and what is left of interference and preload; of a groove the backlash.
    beyond : tuple of str
        The tolerances whose parts spread beyond them: of a Cpk below 1, and measured ones. Of those no proof is.
    batch : Batch or None
        Cams that ``sample_cams`` drew, where the command asked for them.
    allocation : Allocation or None
        The grades that ``allocate`` chose, where the command asked for them.

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
        """Of displacement, velocity and acceleration of the tool by exact contact, each with a cam of its own.

        ``worst_case`` is the first. The others are found when they are asked for first, most often in a second and
        in 20 s at most. Where the acceleration that is asked jumps, a cam that is late or early has the jump for an
        error until it is there: its bound is the jump and what else is off.
        """
        turn = self._turn_errors
        if not turn.node_contributions:
            return self.worst_case, NO_ERROR, NO_ERROR
        return self.worst_case, worst_search(turn, 1).run(), worst_search(turn, 2).run()

    @cached_property
    def dwells(self) -> tuple[DwellError, ...]:
        """Those in the order of the turn, each with what no cam exceeds: proved when they are asked for first."""
        return tuple(_dwell_errors(self._turn_errors))

    @cached_property
    def _turn_errors(self) -> TurnErrors:
        return TurnErrors(self.scene, resolve_design(self.scene))

    def records(self) -> list[dict[str, Any]]:
        """A mapping for each of displacement, velocity and acceleration."""
        return [each._asdict() for each in self.errors]

    def table(self) -> Table:
        """The worst case, what each tolerance contributes to it, and the band, of each of the three."""
        rows = [
            self._row_of_field("worst case", "worst"),
            *({"": key, **{each.name: each.shares[key] for each in self.errors}} for key in self.errors[0].shares),
            self._row_of_field("at cam angle, deg", "at_deg"),
            self._row_of_field(BAND_NAME, "three_sigma"),
            self._row_of_field("at cam angle, deg", "three_sigma_at_deg"),
        ]
        named = dict(zip(MOTION_NAMES, self.worst_cases, strict=True))
        rows.append(
            {
                "": "no cam within exceeds, proved",
                **_proved_bounds({name: each.bound for name, each in named.items()}),
            }
        )
        rows.append({"": "worst cam, by exact contact", **{name: abs(each.error) for name, each in named.items()}})
        if self.dwells:
            rows.append({"": "change in a dwell", MOTION_NAMES[0]: max(each.change for each in self.dwells)})
            of_dwells = [each.worst_case for each in self.dwells]
            bound = {MOTION_NAMES[0]: max(each.bound for each in of_dwells)}
            rows.append({"": "no cam within moves more in it, proved", **_proved_bounds(bound)})
            rows.append(
                {
                    "": "worst cam in a dwell, by exact contact",
                    MOTION_NAMES[0]: max(each.change for each in of_dwells),
                }
            )
        units = {each.name: each.unit for each in self.errors}
        table = table_of(f"{self.scene.name}: errors of the motion", rows, ["", *MOTION_NAMES], units=units)
        told = (
            self.reason,
            *self._unproved_dwell_sentences,
            self.jumps,
            self._worst_cam_sentence,
            *self._rate_sentences,
            self._worst_wobble_sentence,
        )
        return replace(table, note=" ".join(filter(None, [*told, self._assumptions_note])))

    @property
    def _assumptions_note(self) -> str:
        """What the root sum square is of."""
        batches = [
            each.batch
            for key, each in self.scene.tolerances.number_and_angle_tolerances.items()
            if moves_tool(key) and each.batch
        ]
        said = ROOT_SUM_SQUARE_NOTE.format(
            of_batch=", but for those of one batch," if len(batches) > len({*batches}) else ""
        )
        return f"{said} {BEYOND_ZONE_NOTE.format(keys=', '.join(self.beyond))}" if self.beyond else said

    @property
    def _worst_cam_sentence(self) -> str:
        """The errors of the worst cam, and where it has its own."""
        worst = self.worst_case
        if not worst.errors:
            return "No tolerance moves the tool."
        shares, least = self.errors[0].shares, IDLE_ERROR * self.errors[0].worst
        said = self._errors_with_units(
            {key: each for key, each in worst.errors.items() if shares.get(key, least) >= least}
        )
        return (
            f"The worst cam, at {_degrees_text(worst.at_deg)}: {said}.{_gap_sentence(worst.gap, abs(worst.error))}"
        )

    @property
    def jumps(self) -> str:
        """What a jump of the acceleration is to a cam that is late; "" without any."""
        problem = resolve_design(self.scene)
        jumps = [each for each in problem.programme.tool.jumps if each.order > 1]
        if problem.programme.corners or not (jumps and self.worst_cases[-1].errors):
            return ""
        largest = max(jumps, key=lambda each: abs(each.size))
        size = with_unit(motion_scale(problem.setup, 2) * abs(largest.size), self.errors[-1].unit)
        where = f"Where the acceleration jumps, by up to {size} at {_degrees_text(degrees(largest.at))}"
        return f"{where}, a cam that is late or early has the whole jump for an error until it is there."

    @property
    def _rate_sentences(self) -> Iterator[str]:
        """The worst cams of velocity and acceleration; why no bound of them is proved."""
        for name, each in zip(MOTION_NAMES[1:], self.worst_cases[1:], strict=True):
            if each.unproved and each.unproved != self.worst_case.unproved:
                yield f"No bound of the {name} is proved: {each.unproved}."
            if each.errors and not (self.worst_case.unproved and each.unproved):
                above = _gap_sentence(each.gap, abs(each.error))
                errors = self._errors_with_units(each.errors)
                yield f"The worst cam of {name}, at {_degrees_text(each.at_deg)}: {errors}.{above}"

    @property
    def _unproved_dwell_sentences(self) -> Iterator[str]:
        """Why no bound of a dwell is proved."""
        for each in self.dwells:
            if each.worst_case.unproved:
                where = f"the dwell from {each.start_deg:.6g} to {each.end_deg:.6g} deg"
                yield f"No bound is proved of {where}: {each.worst_case.unproved}."

    @property
    def _worst_wobble_sentence(self) -> str:
        """What is off of the cam that wobbles the most: its profile at both places, and the axis of its bore."""
        worst = max((each.worst_case for each in self.dwells), key=lambda each: each.change, default=None)
        if worst is None or not worst.change:
            return ""
        highest, lowest = (
            self._errors_with_units({key: errors[key] for key in worst.at_lowest})
            for errors in (worst.errors, worst.at_lowest)
        )
        bore = self._errors_with_units(
            {key: each for key, each in worst.errors.items() if key in (BORE, BORE_DIRECTION)}
        )
        ends = (
            (f"highest at {_degrees_text(worst.highest_deg)}", highest),
            (f"lowest at {_degrees_text(worst.lowest_deg)}", lowest),
        )
        places = ", ".join(f"{place} with {errors}" if errors else place for place, errors in ends)
        above = _gap_sentence(worst.gap, worst.change)
        return f"The worst cam of a dwell: {'; '.join(filter(None, [places, bore]))}.{above} {DWELL_ARC_NOTE}"

    def _errors_with_units(self, errors: Mapping[str, float]) -> str:
        """Errors of a cam with their units."""
        return ", ".join(f"{key} {with_unit(each, error_unit(self.scene, key))}" for key, each in errors.items())

    def sections(self) -> Iterator[Table]:
        """The errors of the motion, what holds the follower, margins; then the batch and the allocation, if any."""
        yield self.table()
        yield from filter(None, (self.plays_table(), self.margins_table()))
        for each in filter(None, (self.batch, self.allocation)):
            yield from each.tables()

    def document(self) -> dict[str, Any]:
        """Errors, worst cases, dwells, plays and margins, a record each."""
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
            **{key: each.document() for key, each in parts.items() if each},
        }

    def margins_table(self) -> Table | None:
        """The limits with the worst cam's quantity, and whether every cam holds them; None without margins."""
        return margins_table(self.scene, self.margins) if self.margins else None

    def plays_table(self) -> Table | None:
        """What holds the follower from both sides; None of one that one side holds."""
        heads = ["", "nominal", "least", "most"]
        rows = [[each.what, *(with_unit(v, each.unit) for v in each[2:])] for each in self.plays]
        kinds = [Cell(head, NUMERIC if head else "") for head in heads]
        title, lost = f"{self.scene.name}: held from both sides", "".join(map(lost_preload_sentence, self.plays))
        return Table.from_texts(title, kinds, rows, lost) if rows else None

    def worst_motion(self, name: str = MOTION_NAMES[0]) -> Scene:
        """The scene of the cam whose displacement (velocity, acceleration) was found the furthest off.

        The errors of its numbers are those of one measured part (``values`` with one number) in place of their
        tolerances. The profile and the axis of the bore keep theirs: its worst case has them at their ends.

        Raises
        ------
        UnknownName
            If ``name`` is none of the three.
        """
        if name not in MOTION_NAMES:
            raise UnknownName(f"{name!r} is no motion; {suggest_names(str(name), MOTION_NAMES)}")
        worst = self.worst_case if name == MOTION_NAMES[0] else self.worst_cases[MOTION_NAMES.index(name)]
        own = {
            key: each
            for key, each in worst.errors.items()
            if key in self.scene.tolerances.number_and_angle_tolerances
        }
        return self.scene.replace(**{f"tolerances.{key}": {"values": [each]} for key, each in own.items()})

    def worst_cam(self, limit: str) -> Scene:
        """The scene of the worst cam that was found for a limit.

        Its numbers are off, and have no tolerances any more.

        Raises
        ------
        UnknownName
            If the scene has no such limit.
        """
        found = {each.limit: each for each in self.margins if each.sizes}
        if limit not in found:
            raise UnknownName(f"{limit!r} is no limit with a margin; {suggest_names(str(limit), found)}")
        return scene_of_cam(self.scene, found[limit].sizes)

    def _row_of_field(self, said: str, field: str) -> dict[str, Any]:
        """What each of the three has in a field; nothing where it has none."""
        values = {each.name: getattr(each, field) for each in self.errors}
        if field.endswith("_deg"):  # an angle, whatever the unit of the column
            values = {
                name: value if value is None else number_text(round(value, 9)) for name, value in values.items()
            }
        return {"": said, **{name: "" if value is None else value for name, value in values.items()}}


def tolerance(scene: SceneSource) -> MotionErrors:
    """Find how far the motion of a real cam may be from the one asked, by its ``[tolerances]``.

    The profile is cut for the sizes of the scene, with errors along its normal; the follower is put together with
    errors of its own sizes. Errors are those of the tool: with a train they are what comes through it.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with sizes of its own, and ``[tolerances]``, or ``part.profile_tolerance``.

    Returns
    -------
    MotionErrors
        Worst cases, bands of independent errors, what each tolerance contributes, and changes in dwells. They leave
        out terms of second order, below 0.05 µm for errors of 10 µm; ``worst_cases`` leave out nothing, and bound
        the motion of all cams within the tolerances. An error is infinite where the motion that it changes jumps,
        or where it is the slope of a profile whose waves are not limited.

    Raises
    ------
    BadInput
        If the scene lacks a size, or has no tolerances.

    Examples
    --------
    >>> scene = camopt.find_scene("roller-1000rpm").replace(tolerances={"profile": 0.01, "waves": 20})
    >>> [round(each.worst, 4) for each in camopt.tolerance(scene).errors]
    [0.0134, 0.028, inf]
    """
    scene = scene_from(scene)
    scene = scene.toleranced
    turn = TurnErrors(scene, resolve_design(scene))
    margins = ToleranceBox.from_scene(scene, turn.problem).margins
    if not (turn.node_contributions or scene.tolerances.numbers):
        raise no_tolerances_error(turn.problem.file)
    worst_case = worst_search(turn).run() if turn.node_contributions else NO_ERROR
    errors = first_order_errors(turn)
    reason = " ".join(_infinite_error_reasons(turn, worst_case, errors[0].shares))
    beyond = tuple(each.key for each in turn.node_contributions if each.spreads_beyond_zone)
    return MotionErrors(scene, errors, worst_case, reason, margins, tuple(list_plays(turn)), beyond)


def _degrees_text(deg: float) -> str:
    return f"{number_text(round(deg, 9))} deg"


def _proved_bounds(bounds: dict[str, float]) -> dict[str, float]:
    """Those that are proved: the others have no cell."""
    return {name: each for name, each in bounds.items() if each < inf}


def _gap_sentence(gap: float, found: float) -> str:
    """By how much a bound is above the worst cam, where that is much."""
    above = gap / found if found else 0.0
    return f" The bound is {100.0 * above:.2g} % above it." if FAR_BOUND < above < inf else ""


def first_order_errors(turn: TurnErrors) -> tuple[MotionError, ...]:
    """Those of displacement, velocity and acceleration, to first order."""
    return tuple(_motion_error(turn, order) for order in range(RESPONSE_ORDERS))


def _motion_error(turn: TurnErrors, order: int) -> MotionError:
    """The largest error of an order."""
    if not turn.node_contributions:
        return MotionError(
            MOTION_NAMES[order], motion_table_unit(turn.problem.setup, order), 0.0, None, 0.0, None, {}, {}
        )
    if unbounded := turn.unbounded_tolerances(order):
        return _infinite_error(turn, order, unbounded)
    unit, worst_at, band_at = (
        motion_scale(turn.problem.setup, order),
        turn.angle_of_largest_total(worst_case_magnitude, order),
        turn.angle_of_largest_total(root_sum_square_magnitude, order),
    )
    at_worst, at_band = (turn.contributions_at(np.array([place])) for place in (worst_at, band_at))
    ends = np.array([[each.upper[order, 0], -each.lower[order, 0]] for each in at_worst])
    shares = unit * ends[:, ends.sum(axis=0).argmax()]
    parts = variances(at_band, order)[:, 0]
    return MotionError(
        MOTION_NAMES[order],
        motion_table_unit(turn.problem.setup, order),
        float(shares.sum()),
        degrees(worst_at),
        unit * float(root_sum_square_magnitude(at_band, order)[0]),
        degrees(band_at),
        _values_by_key(at_worst, shares),
        _values_by_key(at_band, parts / (parts.sum() or 1.0)),
    )


def _infinite_error(turn: TurnErrors, order: int, unbounded: dict[str, float | None]) -> MotionError:
    """An error that is infinite, by some of the tolerances."""
    at = next((degrees(place) for place in unbounded.values() if place is not None), None)
    alone = {
        each.key: motion_scale(turn.problem.setup, order) * float(worst_case_magnitude([each], order).max())
        for each in turn.node_contributions
    }
    shares = alone | dict.fromkeys(unbounded, inf)
    parts = {key: float(key in unbounded) / len(unbounded) for key in shares}
    return MotionError(
        MOTION_NAMES[order], motion_table_unit(turn.problem.setup, order), inf, at, inf, at, shares, parts
    )


def _values_by_key(found: list[Contribution], values: FloatArray) -> dict[str, float]:
    return {each.key: float(value) for each, value in zip(found, values, strict=True)}


def _dwell_errors(turn: TurnErrors) -> Iterator[DwellError]:
    """How far the follower may move in each dwell of the motion that is asked."""
    unit = motion_scale(turn.problem.setup, 0)
    for stroke, worst_case in worst_wobbles(turn):
        found = turn.contributions_at(np.linspace(stroke.start, stroke.end - JUMP_SIDE, DWELL_ANGLES))
        change = unit * sum(each.change() for each in found)
        over = 2.0 * pi if stroke.end > turn.problem.programme.strokes[-1].end else 0.0
        yield DwellError(degrees(stroke.start), degrees(stroke.end - over), change, worst_case)


def _infinite_error_reasons(turn: TurnErrors, worst_case: WorstCase, shares: dict[str, float]) -> Iterator[str]:
    """Why errors are infinite, a sentence each."""
    corners = turn.problem.programme.corners
    if worst_case.unproved:
        where = f" at {degrees(corners[0].at):.6g} deg" if corners else ""
        largest = max(shares, key=shares.__getitem__)
        smaller = "" if corners else f" {largest} has the largest share: make it smaller first."
        yield f"No bound of the displacement is proved: {worst_case.unproved}{where}.{smaller}"
    if turn.impulses:
        order = min(turn.impulses.values()).order
        what = MOTION_NAMES[order]
        yield (
            f"The {what} of the motion jumps at {turn.impulse_angles_text(order)}: where an error moves the jump, "
            f"its own {what} is an impulse to first order; in truth it is a short, steep ramp."
        )
    if turn.scene.tolerances.profile and turn.scene.tolerances.waves is None:
        yield "The slope of the profile's error has no bound without tolerances.waves: give it, such as waves = 20."


WORST_FILE, ALLOCATED_FILE, CAMS_FILE, HISTOGRAM_FILE = (
    "worst-{}.toml",
    "allocated.toml",
    "cams.parquet",
    "cams.svg",
)
CAM_FILES = (WORST_FILE.format("*"), ALLOCATED_FILE, CAMS_FILE, HISTOGRAM_FILE)
"""The scenes of the worst motions, of the worst cam of each limit and of the grades; what each cam of a batch has,
and its picture."""


def write_cams(result: MotionErrors, unit: Publication) -> None:
    """Write the cams of the worst motions, the worst cam of each limit, the allocated cam, and a batch's table."""
    motions = dict(zip(MOTION_NAMES, ("motion", "motion-velocity", "motion-acceleration"), strict=True))
    for (name, file), each in zip(motions.items(), result.worst_cases, strict=True):
        if each.errors:
            write_scene(unit.path(WORST_FILE.format(file)), result.worst_motion(name))
    for margin in result.margins:
        if margin.quantity and margin.worst != margin.nominal:
            write_scene(unit.path(WORST_FILE.format(margin.limit)), result.worst_cam(margin.limit))
    if result.allocation:
        write_scene(unit.path(ALLOCATED_FILE), result.allocation.scene)
    if result.batch:
        result.batch.write(unit.path(CAMS_FILE))
