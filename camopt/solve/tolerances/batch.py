"""A batch of random cams: the spread of their motion errors, and the share that holds the limits.

Each cam has its own errors, drawn by the distributions of ``[tolerances]`` (``tolerances.error_samples``). Every
number is computed for the cam itself, not by a linear model. Motion errors are those of the nominal profile, cut
and assembled with the errors (``tolerances.real_cam``). Quantities of limits are those of a cam designed for the
sizes with errors. The share that holds the limits has the interval of Clopper and Pearson for independent draws;
Sobol points are more even than these.

The share of the variance of a quantity q that a size x explains is S = Var(E[q | x]) / Var(q), from the means of q
over classes of x. To first order it is c²σ²/Σ c²σ², with the slope c = ∂q/∂x and the standard deviation σ.

Sources: C. J. Clopper, E. S. Pearson, The use of confidence or fiducial limits, Biometrika 26 (1934); E. Plischke,
E. Borgonovo, C. L. Smith, Global sensitivity measures from given data, Eur. J. Oper. Res. 226 (2013).
"""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
import scipy

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.quantities.display import Drawable
from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.model.effects import find_quantity
from camopt.model.effects.error_response import RESPONSE_ORDERS, SECOND_CONTACT_SUFFIX
from camopt.model.effects.motion import motion_error_quantity_names, motion_table_unit, motion_unit_factor
from camopt.model.effects.preload import INTERFERENCE_KEY
from camopt.scene.arguments import SceneSource, allow_positional_options, check_count, scene_from
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, resolve, resolve_design
from camopt.scene.problem.tolerance_zones import tolerance_zones_of_numbers_and_angles
from camopt.scene.scene import Scene
from camopt.scene.tolerances import does_error_move_tool
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import NUMERIC, Cell, Columns, Result, Table, table_of
from camopt.solve.tolerances.error_samples import (
    THREADS,
    LargestErrorSearch,
    count_cams,
    exceed_tolerances,
    real_error_parts_in_mm_and_deg,
    sample_errors,
    take_cams,
)
from camopt.solve.tolerances.errors import CamErrors, error_ranges_at_one_contact, error_unit
from camopt.solve.tolerances.margins import (
    OWN_SIZES_NOTE,
    LimitsByNumber,
    LimitValues,
    ToleranceBox,
    evaluate_limits,
    worst_design_index,
)
from camopt.solve.tolerances.plays_and_interference import separating_errors
from camopt.solve.tolerances.real_cam import RealCam
from camopt.solve.tolerances.turn_errors import (
    MOTION_NAMES,
    TurnErrors,
    no_tolerances_error,
    root_sum_square_range,
)

if TYPE_CHECKING:
    import pandas as pd

SAMPLES_TABLE = "samples"
DEFAULT_CAMS = 2**16
"""Default size of a batch."""
MOST_SAMPLED_CAMS = 2**24
LIMIT_DESIGNS_AT_ONCE = 2**16
MOST_VARIANCES = 6
"""Largest number of variance shares that the table shows for a limit."""
VARIANCE_CLASSES = 64
"""Number of classes of a size for the variance that it explains."""
CONFIDENCE = 0.95
UNIT_SIGNS = str.maketrans({"/": "_per_", "·": "_", "²": "2", "µ": "u"})
"""Replacements of signs of units in column names."""
THREE_SIGMA_TAIL = 0.00135
"""Share of a normal distribution beyond three standard deviations, on one side."""
ERROR_QUANTILES = (0.5, 0.95, 0.9973)
"""Shares of the cams whose largest errors are reported."""
DWELL_CHANGE = "change in a dwell"


class Share(NamedTuple):
    """A share of the cams of a batch, with its 95 % confidence interval.

    Examples
    --------
    >>> scene = camopt.find_scene("rocker-valve").replace(**{"tolerances.follower.arm_length": 0.05})
    >>> camopt.sample_cams(scene, cams=1024).held.share
    1.0
    """

    share: float
    low: float
    high: float


class Spread(NamedTuple):
    """Spread of the quantity of a limit over the cams of a batch.

    Examples
    --------
    >>> scene = camopt.find_scene("rocker-valve").replace(**{"tolerances.follower.arm_length": 0.05})
    >>> spread = camopt.sample_cams(scene, cams=1024).spreads[0]
    >>> spread.limit, round(spread.median, 2)
    ('pressure_angle', 24.49)
    """

    limit: str
    quantity: str
    held: Share
    """Share of the cams that hold the limit."""
    low: float
    """0.135 % of the cams have a smaller quantity."""
    median: float
    high: float
    """0.135 % of the cams have a larger quantity."""
    worst: float
    """Worst value in the batch."""
    sizes: dict[str, float]
    """Toleranced numbers of the worst cam, by key of the scene, in its units."""
    variances: dict[str, float]
    """Share of the variance that each size explains, by key; 0 if all cams have the same quantity."""


class ErrorSpread(NamedTuple):
    """Spread of the largest motion error over the cams of a batch.

    Examples
    --------
    >>> scene = camopt.find_scene("bucket-valve").replace(**{"tolerances.follower.offset": 0.02})
    >>> displacement = camopt.sample_cams(scene, cams=1024).errors[0]
    >>> displacement.name, round(displacement.worst, 9)
    ('displacement', 0.0)
    """

    name: str
    """``displacement``, ``velocity``, ``acceleration`` or ``change in a dwell``."""
    unit: str
    median: float
    """Largest ``|error|`` over the turn of half of the cams."""
    of_95: float
    """Largest ``|error|`` of 95 % of the cams."""
    of_99_73: float
    """Largest ``|error|`` of 99.73 % of the cams."""
    worst: float
    """Largest ``|error|`` in the batch."""
    at_deg: float | None
    """Cam angle of the worst error [deg]."""
    parts: dict[str, float]
    """Errors of the worst cam, by key of ``[tolerances]``, in mm or deg."""
    variances: dict[str, float]
    """Share of the variance that each tolerance explains, by key, at the cam angle of the largest root sum square.

    Empty if that is infinite, and for dwells.
    """
    missed: float | None
    """How much the error found falls short of the largest error of a cam, at most, from a dense scan of some cams.

    None for dwells.
    """
    held: Share | None
    """Share of the cams that hold the limit on this error; None without a limit."""


class SampleColumn(NamedTuple):
    """One value of each cam of a batch.

    Examples
    --------
    >>> scene = camopt.find_scene("bucket-valve").replace(**{"tolerances.profile": 0.01})
    >>> column = camopt.sample_cams(scene, cams=1024).samples["position_error_max_mm"]
    >>> column.unit, column.values.size
    ('mm', 1024)
    """

    unit: str
    sentence: str
    values: FloatArray


@dataclass(frozen=True)
class Batch(Result, Drawable):
    """A batch of random cams with errors by the tolerances of a scene.

    Attributes
    ----------
    scene : Scene
        The nominal cam, with its ``[tolerances]``.
    cams, seed : int
        Number of cams, and of the draw.
    outside : int
        Number of cams with an error outside of its tolerance, as in the tails of a normal distribution.
    held : Share
        The yield: the share of the cams that hold all limits.
    errors : tuple of ErrorSpread
        Spread of the motion errors: displacement, velocity, acceleration, and the change in a dwell if there is
        one.
    spreads : tuple of Spread
        Spread of each limit that depends on a size or an interference; empty without tolerances of these.
    samples : dict of SampleColumn
        Values of each cam, by name of the column that ``write`` gives it: its errors, the largest errors of its
        motion, and the quantities of limits.
    within : float, optional
        Permitted error of the tool's position, mm (deg), if one was given.

    Examples
    --------
    >>> scene = camopt.find_scene("rocker-valve").replace(**{"tolerances.follower.arm_length": 0.05})
    >>> batch = camopt.sample_cams(scene, cams=4096)
    >>> batch.held.share, batch.held.high
    (1.0, 1.0)
    """

    picture: ClassVar[str] = "pictures.tolerances"
    scene: Scene
    cams: int
    seed: int
    outside: int
    held: Share
    errors: tuple[ErrorSpread, ...]
    spreads: tuple[Spread, ...]
    samples: Mapping[str, SampleColumn] = field(repr=False, compare=False)
    within: float | None = None
    main_rows: ClassVar[str] = "limits"

    @property
    def kept_tables(self) -> tuple[str, ...]:
        """Names of further tables."""
        return (SAMPLES_TABLE,)

    def to_pandas(self, name: str | None = None) -> "pd.DataFrame":
        """Rows of the batch as a DataFrame: "limits" (the default), "errors", or "samples" with a row for each cam.

        Raises
        ------
        UnknownName
            If the batch has no table with this name.
        """
        if name != SAMPLES_TABLE:
            return super().to_pandas(name)
        values = {column: each.values for column, each in self.samples.items()}
        return Columns(values, {column: each.unit for column, each in self.samples.items()}).to_pandas()

    def table(self) -> Table:
        """The spread of the motion errors."""
        rows = [
            row_of_field("half of the cams", self.errors, "median"),
            row_of_field("95 % of the cams", self.errors, "of_95"),
            row_of_field("99.73 % of the cams", self.errors, "of_99_73"),
            row_of_field("worst cam", self.errors, "worst"),
            row_of_field("at cam angle, deg", self.errors, "at_deg"),
        ]
        with_variances = [each for each in self.errors if each.variances]
        for key in dict.fromkeys(key for each in with_variances for key in each.variances):
            shares = {each.name: number_text(round(100.0 * each.variances[key], 9)) for each in with_variances}
            rows.append({"": f"variance by {key}, %", **shares})
        rows.append(row_of_field("missed by the search, at most", self.errors, "missed"))
        if held := {each.name: _percent_with_confidence(each.held) for each in self.errors if each.held}:
            rows.append({"": "limit held by", **held})
        units = {each.name: each.unit for each in self.errors}
        title = f"{self.scene.name}: largest errors of the motions of {self.cams:,} cams"
        limit = (
            f"The limit of the displacement is ±{with_unit(self.within, self.errors[0].unit)}. "
            if self.within
            else ""
        )
        variances = "Variances are at the cam angle of the largest root sum square."
        note = f"{self._cams_outside_tolerances_sentence} {limit}{variances}"
        return replace(table_of(title, rows, ["", *units], units=units), note=note)

    @property
    def _cams_outside_tolerances_sentence(self) -> str:
        """The number of cams outside of their tolerances, in a sentence."""
        if not self.outside:
            return "All cams are within the tolerances."
        few = "1 of the cams is" if self.outside == 1 else f"{self.outside:,} of the cams are"
        return (
            f"{few} outside of a tolerance (tails of normal distributions): the proven bounds do not cover these."
        )

    def limits_table(self) -> Table | None:
        """The share of cams that holds each limit, and the spread of its quantity."""
        if not self.spreads:
            return None
        setup = resolve(self.scene).setup
        heads = ["limit", "held by", "0.135 %", "median", "99.865 %", "worst", "by"]
        rows = [["all", _percent_with_confidence(self.held), *([""] * 5)]]
        for each in self.spreads:
            unit = find_quantity(each.quantity, setup).unit
            values = [number_text(to_shown_unit(value, unit)) for value in (each.low, each.median, each.high)]
            parts = sorted(each.variances.items(), key=lambda part: -part[1])[:MOST_VARIANCES]
            by = ", ".join(f"{key.removeprefix('follower.')} {100.0 * part:.0f} %" for key, part in parts)
            rows.append([each.limit, _percent_with_confidence(each.held), *values, with_unit(each.worst, unit), by])
        kinds = [Cell(head, NUMERIC if head in heads[1:6] else "") for head in heads]
        title = f"{self.scene.name}: {self.cams:,} cams drawn by the tolerances, each cut for its own sizes"
        return Table.from_texts(title, kinds, rows, f"In brackets with a confidence of 95 %. {OWN_SIZES_NOTE}")

    def sections(self) -> Iterator[Table]:
        """The tables of motion errors and of limits."""
        yield self.table()
        yield from filter(None, (self.limits_table(),))

    def values_for_json(self) -> dict[str, Any]:
        """The batch for ``--json``: counts, the yield, and one record for each error and each limit."""
        return {
            "cams": self.cams,
            "seed": self.seed,
            "outside": self.outside,
            "held": self.held,
            "errors": self.errors,
            "limits": self.spreads,
        }

    def records(self) -> list[dict[str, Any]]:
        """One mapping for each limit."""
        return [{**each._asdict(), "held": each.held._asdict()} for each in self.spreads]

    @property
    def bounds(self) -> dict[str, float]:
        """Bounds of limits, by column of ``samples``."""
        return {
            limit.shown_quantities[0]: limit.bound
            for limit in resolve_design(self.scene).limits[::-1]
            if limit.shown_quantities
        }

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the samples as a table (Parquet) with one row for each cam, which ``load`` reads.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        from camopt.solve.tables.table import write_columns  # noqa: PLC0415  it imports pyarrow

        write_columns(self.samples, self.scene, path)


@allow_positional_options
def sample_cams(
    scene: SceneSource, cams: int = DEFAULT_CAMS, *, seed: int = 0, within: float | None = None
) -> Batch:
    """Draw random cams by the tolerances of a scene: their motion errors, and the share that holds the limits.

    The motion is that of the nominal profile with all errors of a cam, by exact contact of its follower. For
    limits, each cam has the programmed motion and its own sizes. Two contacts have the interference that all errors
    of the cam give, at the cam angle where it is worst. ``margins`` of ``tolerance`` tell what every cam holds.
    Self-crossing of the profile is not checked.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with all sizes and ``[tolerances]``. Its limits count if sizes of the follower have tolerances.
    cams : int, default 65,536
        Number of cams, at most 16,777,216; Sobol points are most even for a power of 2.
    seed : int, default 0
        Number of the draw.
    within : float, optional
        Permitted error of the tool's position, mm (deg); by default the scene's limit ``position_error``, if any.

    Returns
    -------
    Batch
        Spread of the motion errors, the yield with its interval, and the spread of the quantity of each limit.

    Raises
    ------
    BadInput
        If a size is missing, the scene has no tolerances, or an argument is out of range.

    References
    ----------
    A. B. Owen, Scrambling Sobol' and Niederreiter-Xing points, J. Complexity 14 (1998).

    Examples
    --------
    >>> tolerances = {"follower.offset": {"plus": 0.5, "minus": 0.5}}
    >>> scene = camopt.find_scene("bucket-valve").replace(tolerances=tolerances, **{"limits.face_reach": 13.2})
    >>> round(camopt.sample_cams(scene, cams=2**14).held.share, 2)
    0.8
    """
    scene = scene_from(scene)
    check_count("seed", seed, 0)
    if within is not None and not (isinstance(within, int | float) and isfinite(within) and within > 0.0):
        raise BadInput([Mistake("camopt", "within", within, "a distance above 0, mm (deg)")])
    if not isinstance(cams, int) or not 1 <= cams <= MOST_SAMPLED_CAMS:
        raise BadInput([Mistake("camopt", "cams", cams, f"a whole number from 1 to {MOST_SAMPLED_CAMS:,}")])
    scene = scene.with_profile_tolerance_moved
    problem = resolve_design(scene)
    sampled = sample_errors(scene, problem, cams, seed)
    if not sampled:
        raise no_tolerances_error(problem.file)
    moving, error_bounds = _tool_moving_errors(sampled), _motion_error_bounds(problem)
    error_bounds |= {} if within is None else {motion_error_quantity_names(problem.setup)[0]: within}
    held, samples = np.ones(cams, dtype=bool), dict(_error_columns(scene, sampled))
    errors = [*_largest_errors(TurnErrors(scene, problem), moving, error_bounds)] if moving else []
    samples |= {column: SampleColumn(each.unit, sentence, values) for column, sentence, values, each in errors}
    spreads = tuple[Spread, ...]()
    if results := _limit_results(scene, problem, sampled):
        held = np.all(results.excess <= 0.0, axis=0)
        spreads = tuple(_limit_spreads(*results))
        for limit, values in zip(results.limits, results.values, strict=True):
            quantity = find_quantity(limit.shown_quantities[0], limit.setup)
            samples[quantity.name] = SampleColumn(quantity.unit, quantity.sentence, values)
    for column, _, values, _ in errors:
        held &= values <= error_bounds.get(column, inf)
    ends = {
        key: (zone.lower, zone.upper)
        for key, zone in tolerance_zones_of_numbers_and_angles(scene, problem.nominal_numbers).items()
    } | error_ranges_at_one_contact(scene, problem)
    ends = {key: ends[key.removesuffix(SECOND_CONTACT_SUFFIX)] for key in sampled}
    outside = int(np.count_nonzero(exceed_tolerances(sampled, ends)))
    share = share_with_confidence(int(np.count_nonzero(held)), cams)
    error_spreads = tuple(spread for *_, spread in errors)
    return Batch(scene, cams, seed, outside, share, error_spreads, spreads, samples, within)


def yield_of_cams(scene: Scene, problem: Problem, cams: int) -> Share | None:
    """Share of cams that hold the limits, as in ``sample_cams``; None if no limit depends on the tolerances."""
    sampled = sample_errors(scene, problem, cams, 0)
    results, moving = _limit_results(scene, problem, sampled), _tool_moving_errors(sampled)
    error_bounds = _motion_error_bounds(problem) if moving else {}
    if not (results or error_bounds):
        return None
    held = np.all(results.excess <= 0.0, axis=0) if results else np.ones(cams, dtype=bool)
    cam, columns = RealCam(problem, scene.tolerances.waves or 0), motion_error_quantity_names(problem.setup)
    search = LargestErrorSearch(cam, tuple(moving))
    for column, bound in error_bounds.items():
        order = columns.index(column)
        errors = (
            search.largest_motion_errors(moving, order).error
            if order < RESPONSE_ORDERS
            else search.largest_dwell_changes(moving)
        )
        held &= errors <= bound / motion_unit_factor(problem.setup, order % RESPONSE_ORDERS)
    return share_with_confidence(int(np.count_nonzero(held)), cams)


class _LimitResults(NamedTuple):
    """Excess over each limit, and its quantity, of cams: shape (limits, cams)."""

    limits: list[Limit]
    excess: FloatArray
    values: FloatArray
    numbers: dict[str, FloatArray]
    """Numbers of each cam, by key of the scene."""
    errors: CamErrors
    """Errors that explain the variance of the quantities."""
    interference: FloatArray | None = None
    """Interference at which two contacts of each cam are worst, shape (limits, cams)."""


def _tool_moving_errors(sampled: CamErrors) -> CamErrors:
    return {
        key: each for key, each in sampled.items() if does_error_move_tool(key.removesuffix(SECOND_CONTACT_SUFFIX))
    }


def _motion_error_bounds(problem: Problem) -> dict[str, float]:
    """Bounds of limits on motion errors, by column."""
    return {limit.shown_quantities[0]: limit.bound for limit in problem.limits if limit.is_on_motion_error}


def _limit_results(scene: Scene, problem: Problem, sampled: CamErrors) -> _LimitResults | None:
    """Excesses and quantities of limits; None if no limit depends on the errors.

    Two contacts have their worst interference over the turn, from the mounting and all errors.
    """
    box = ToleranceBox.from_scene(scene, problem)
    variables = {key: each for key, each in box.variables.items() if each.varies_by_design and key in sampled}
    numbers = {key: box.problem.nominal_numbers[key] + sampled[key] for key in variables}
    waves, nodes = scene.tolerances.waves or 0, TurnErrors(scene, problem).nodes
    interference = (
        None
        if box.interference is None
        else box.interference.sampled_interference_range(problem, sampled, waves, nodes)
    )
    if not numbers and interference is None:
        return None
    limits = [
        limit
        for limit in box.problem.without_deferred_limits.limits
        if limit.shown_quantities and not (limit.is_decided_by_motion_alone or limit.is_on_motion_error)
    ]
    designs = box.problem.design.take(np.zeros(count_cams(sampled), dtype=int))
    designs = designs.with_values({each.field: numbers[key] for key, each in variables.items()})
    errors = {key: sampled[key] for key in numbers}
    if interference is None:
        ((excess, values),) = _evaluate_in_blocks(
            len(designs), lambda block: [evaluate_limits(box.problem, limits, designs.take(block))]
        )
        return _LimitResults(limits, excess, values, numbers, errors)
    by_number = LimitsByNumber(box.problem, limits, INTERFERENCE_KEY)
    (low_excess, low), (high_excess, high) = _evaluate_in_blocks(
        len(designs),
        lambda block: [
            *by_number.evaluate_limits_by_number(designs.take(block), (end[block] for end in interference))
        ],
    )
    if not numbers and np.array_equal(low, high, equal_nan=True):  # no limit depends on the interference
        return None
    side = np.array([find_quantity(limit.shown_quantities[0], limit.setup).limit_sign for limit in limits]).reshape(
        -1, 1
    )
    tight = ~(side * low >= side * high)
    values, worst = (np.where(tight, *ends) for ends in ((high, low), (interference.high, interference.low)))
    errors |= separating_errors(sampled)
    return _LimitResults(limits, np.maximum(low_excess, high_excess), values, numbers, errors, worst)


def row_of_field(head: str, errors: Sequence[Any], field_name: str) -> dict[str, Any]:
    """One row of a table of motion errors: a field of each of them, "" where it is None."""
    values = {each.name: getattr(each, field_name) for each in errors}
    if field_name.endswith("_deg"):  # an angle, whatever the unit of the column
        values = {name: value if value is None else number_text(round(value, 9)) for name, value in values.items()}
    return {"": head, **{name: "" if value is None else value for name, value in values.items()}}


def _error_columns(scene: Scene, cams: CamErrors) -> Iterator[tuple[str, SampleColumn]]:
    """Errors of cams as columns, by name."""
    for key, values in real_error_parts_in_mm_and_deg(cams).items():
        unit = error_unit(scene, key)
        name = f"{key.replace('.', '_')}_off_{unit.translate(UNIT_SIGNS)}"
        yield name, SampleColumn(unit, f"Error within tolerances.{key}.", values)


def _largest_errors(
    turn: TurnErrors, cams: CamErrors, bounds: Mapping[str, float]
) -> Iterator[tuple[str, str, FloatArray, ErrorSpread]]:
    """Largest errors of displacement, velocity and acceleration, and the change in a dwell.

    Each with its column, its meaning, the value of each cam, and the spread of these. A value is infinite where a
    follower does not touch its cam.
    """
    setup = turn.problem.setup
    columns = motion_error_quantity_names(setup)
    search = LargestErrorSearch(RealCam(turn.problem, turn.scene.tolerances.waves or 0), tuple(cams))
    for order, name in enumerate(MOTION_NAMES):
        unit, largest = motion_unit_factor(setup, order), search.largest_motion_errors(cams, order)
        variances = {}
        if not turn.angles_of_unbounded_tolerances(order):
            angle = turn.angle_of_largest_total(root_sum_square_range, order)
            errors = search.errors_at_angle(cams, angle, order)
            variances = {key: _variance_share_explained_by_error(errors, each) for key, each in cams.items()}
        values = unit * np.where(np.isnan(largest.error), inf, largest.error)
        worst = np.array([_worst_cam_index(largest.error)])
        places = search.real_cam.contact_angles(take_cams(cams, worst), largest.place[worst])
        at_deg = float(np.degrees(search.real_cam.angles_in_turn(places)[0]))
        missed = unit * search.error_missed_by_search(cams, order)
        head = name, motion_table_unit(setup, order)
        spread = _spread_of_errors(*head, values, cams, bounds.get(columns[order]), at_deg, variances, missed)
        yield columns[order], f"Largest error of the {name}.", values, spread
    if turn.problem.programme.tool.dwells:
        change = search.largest_dwell_changes(cams)
        values = motion_unit_factor(setup, 0) * np.where(np.isnan(change), inf, change)
        head = DWELL_CHANGE, motion_table_unit(setup, 0)
        spread = _spread_of_errors(*head, values, cams, bounds.get(columns[-1]), None, {}, None)
        yield columns[-1], "Largest change in a dwell.", values, spread


def _spread_of_errors(
    name: str,
    unit: str,
    values: FloatArray,
    cams: CamErrors,
    bound: float | None,
    at_deg: float | None,
    variances: dict[str, float],
    missed: float | None,
) -> ErrorSpread:
    """Spread of one motion error, with the errors of its worst cam."""
    median, of_95, of_99_73 = (float(each) for each in np.quantile(values, ERROR_QUANTILES, method="higher"))
    worst = _worst_cam_index(values)
    errors = {key: float(each[worst]) for key, each in real_error_parts_in_mm_and_deg(cams).items()}
    held = None if bound is None else share_with_confidence(int(np.count_nonzero(values <= bound)), values.size)
    ends = median, of_95, of_99_73, float(values[worst])
    return ErrorSpread(name, unit, *ends, at_deg, errors, variances, missed, held)


def _worst_cam_index(errors: FloatArray) -> int:
    """Index of the worst cam; a cam whose follower does not touch it comes first."""
    return int(np.where(np.isnan(errors), inf, errors).argmax())


def _variance_share_explained_by_error(values: FloatArray, errors: FloatArray) -> float:
    """Share of the variance of ``values`` that an error explains, from the means over classes of the error."""
    if np.iscomplexobj(errors):
        return sum(_variance_share_explained_by_error(values, part) for part in (errors.real, errors.imag))
    count = min(VARIANCE_CLASSES, max(values.size // VARIANCE_CLASSES, 1))
    spread = float(np.var(values)) if np.all(np.isfinite(values)) else 0.0
    if spread <= (1e-12 * float(np.max(np.abs(values)))) ** 2:
        return 0.0
    classes = np.array_split(values[np.argsort(errors, kind="stable")], count)
    means, weights = (np.array([f(each) for each in classes]) for f in (np.mean, np.size))
    return float(np.average(np.square(means - np.average(means, weights=weights)), weights=weights) / spread)


def _evaluate_in_blocks(count: int, evaluate_block: Callable[[slice], list[LimitValues]]) -> list[LimitValues]:
    blocks = [slice(first, first + LIMIT_DESIGNS_AT_ONCE) for first in range(0, count, LIMIT_DESIGNS_AT_ONCE)]
    with ThreadPoolExecutor(THREADS) as pool:
        results = [*pool.map(evaluate_block, blocks)]
    return [
        LimitValues(*(np.concatenate(each, axis=1) for each in zip(*values, strict=True)))
        for values in zip(*results, strict=True)
    ]


def share_with_confidence(count: int, cams: int) -> Share:
    """Share of ``count`` in ``cams``, with the 95 % interval of Clopper and Pearson."""
    tail = (1.0 - CONFIDENCE) / 2.0
    low = float(scipy.special.betaincinv(count, cams - count + 1, tail)) if count else 0.0
    high = float(scipy.special.betaincinv(count + 1, cams - count, 1.0 - tail)) if count < cams else 1.0
    return Share(count / cams, low, high)


def _limit_spreads(
    limits: list[Limit],
    excess: FloatArray,
    values: FloatArray,
    numbers: dict[str, FloatArray],
    errors: CamErrors,
    interference: FloatArray | None,
) -> Iterator[Spread]:
    for row, (limit, over, column) in enumerate(zip(limits, excess, values, strict=True)):
        sizes = numbers if interference is None else {**numbers, INTERFERENCE_KEY: interference[row]}
        worst = worst_design_index(limit, over, column)
        held = share_with_confidence(int(np.count_nonzero(over <= 0.0)), column.size)
        low, median, high = (
            float(value) for value in np.quantile(column, [THREE_SIGMA_TAIL, 0.5, 1.0 - THREE_SIGMA_TAIL])
        )
        ends = low, median, high, float(column[worst])
        worst_sizes = {key: float(size[worst]) for key, size in sizes.items()}
        parts = {key: _variance_share_explained_by_error(column, error) for key, error in errors.items()}
        yield Spread(limit.name, limit.shown_quantities[0], held, *ends, worst_sizes, parts)


def _percent_with_confidence(held: Share) -> str:
    low, high = 100.0 * held.low, 100.0 * held.high
    return f"{100.0 * held.share:.6g} % [{low:.4f}, {high:.4f}]"
