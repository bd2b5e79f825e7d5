"""A batch of cams: how far the motions of those that are made are off, and how many hold the limits.

Each cam has errors of its own, drawn as ``[tolerances]`` says (``tolerances.error_samples``), and every number is
that of the cam itself, not of a linear model. The errors of its motion are those of the nominal profile, cut and
put together so (``tolerances.real_cam``); the quantities of limits are those of a cam that was designed so. The
share that holds the limits has the interval of Clopper and Pearson, which is that of independent draws: Sobol
points are more even than these.

How much of the variance of a quantity q a size x explains, is S = Var(E[q | x]) / Var(q), from the means of q over
classes of x. To first order it is c²σ²/Σ c²σ², with the slope c = ∂q/∂x and the standard deviation σ.

Sources: C. J. Clopper, E. S. Pearson, The use of confidence or fiducial limits, Biometrika 26 (1934); E. Plischke,
E. Borgonovo, C. L. Smith, Global sensitivity measures from given data, Eur. J. Oper. Res. 226 (2013).
"""

import os
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
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
from camopt.model.effects.motion import error_names, motion_scale, motion_table_unit
from camopt.model.mechanisms import Designs
from camopt.scene.arguments import SceneSource, check_count, options_by_keyword, scene_from
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, resolve, resolve_design
from camopt.scene.problem.tolerance_zones import number_and_angle_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import moves_tool
from camopt.solve.tables.cells import number_text, with_unit
from camopt.solve.tables.result import NUMERIC, Cell, Columns, Result, Table, table_of
from camopt.solve.tolerances.error_samples import (
    THREADS,
    LargestErrorSearch,
    count_cams,
    exceed_tolerances,
    real_error_parts,
    sample_errors,
)
from camopt.solve.tolerances.errors import CamErrors, error_keys, error_ranges, error_unit
from camopt.solve.tolerances.margins import (
    OWN_SIZES_NOTE,
    LimitsByNumber,
    LimitValues,
    ToleranceBox,
    evaluate_limits,
    worst_design,
)
from camopt.solve.tolerances.plays_and_interference import INTERFERENCE_KEY, separating_errors
from camopt.solve.tolerances.real_cam import RealCam
from camopt.solve.tolerances.response import SeparationRange
from camopt.solve.tolerances.turn_errors import (
    MOTION_NAMES,
    TurnErrors,
    no_tolerances_error,
    root_sum_square_magnitude,
)

if TYPE_CHECKING:
    import pandas as pd

SAMPLES_TABLE = "samples"
DEFAULT_CAMS = 2**16
"""Unless told."""
MOST_SAMPLED_CAMS = 2**24
LIMIT_DESIGNS_AT_ONCE = 2**16
MOST_VARIANCES = 6
"""Of the errors that explain how a quantity is spread, in the table."""
VARIANCE_CLASSES = 64
"""Of a size, for the variance that it explains."""
CONFIDENCE = 0.95
UNIT_SIGNS = str.maketrans({"/": "_per_", "·": "_", "²": "2", "µ": "u"})
"""What signs of units are in names of columns."""
THREE_SIGMA_TAIL = 0.00135
"""Of a normal distribution beyond three standard deviations, on one side."""
ERROR_QUANTILES = (0.5, 0.95, 0.9973)
"""Of the cams, whose largest errors are told."""
DWELL_CHANGE = "change in a dwell"


class Share(NamedTuple):
    """A share of the cams of a batch, with its interval of confidence of 95 %.

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
    """How the quantity of a limit is spread over the cams of a batch.

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
    """The cams that hold the limit."""
    low: float
    """Below which 0.135 % of the cams are."""
    median: float
    high: float
    """Above which 0.135 % of the cams are."""
    worst: float
    """Of all cams of the batch."""
    sizes: dict[str, float]
    """The numbers of that cam that have tolerances, by key of the scene, in its units."""
    variances: dict[str, float]
    """The share of the variance that each size explains, by key; 0 if the quantity is the same for all."""


class ErrorSpread(NamedTuple):
    """How the largest error of the motion is spread over the cams of a batch.

    Examples
    --------
    >>> scene = camopt.find_scene("bucket-valve").replace(**{"tolerances.follower.offset": 0.02})
    >>> displacement = camopt.sample_cams(scene, cams=1024).errors[0]
    >>> displacement.name, round(displacement.worst, 9)
    ('displacement', 0.0)
    """

    name: str
    """displacement, velocity, acceleration, or the change in a dwell."""
    unit: str
    median: float
    """Half of the cams have no larger ``|error|`` at any cam angle."""
    of_95: float
    """The same of 95 % of the cams."""
    of_99_73: float
    """And of 99.73 %."""
    worst: float
    """Of all cams of the batch."""
    at_deg: float | None
    """The cam angle at which that cam has it."""
    parts: dict[str, float]
    """The errors of that cam, by key of ``[tolerances]``, mm or deg."""
    variances: dict[str, float]
    """The share of the variance that each tolerance explains at the cam angle where the band of independent errors
    is the widest, by key; empty where that has no bound, and of dwells."""
    missed: float | None
    """By how much the largest error of a cam is larger than what was found: the most of some cams that were looked
    at closely; None of dwells."""
    held: Share | None
    """The cams that hold the limit on it; None if it has none."""


class SampleColumn(NamedTuple):
    """What the cams of a batch have of one thing.

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
    """A batch of cams whose errors are spread as the tolerances of a scene say.

    Attributes
    ----------
    scene : Scene
        The nominal cam, with its ``[tolerances]``.
    cams, seed : int
        How many, and which draw.
    outside : int
        How many of them have an error outside of its tolerance, as the ends of a normal distribution are.
    held : Share
        The yield: the share of the cams that hold all limits.
    errors : tuple of ErrorSpread
        Of the motion: displacement, velocity, acceleration, and the change in a dwell if there is one.
    spreads : tuple of Spread
        Of each limit that a size decides, or an interference; none without tolerances of these.
    samples : dict of Sampled
        What each cam has, by the name of the column that ``write`` gives it: its errors, the largest errors of its
        motion, and the quantities of limits.
    within : float, optional
        The largest error of the tool's position that counts as held, mm (deg), if one was given.

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
        """The samples."""
        return (SAMPLES_TABLE,)

    def to_pandas(self, name: str | None = None) -> "pd.DataFrame":
        """Rows of the batch as a DataFrame: "limits", the default, "errors", or "samples" with a row for each cam.

        Raises
        ------
        UnknownName
            For another name.
        """
        if name != SAMPLES_TABLE:
            return super().to_pandas(name)
        values = {column: each.values for column, each in self.samples.items()}
        return Columns(values, {column: each.unit for column, each in self.samples.items()}).to_pandas()

    def table(self) -> Table:
        """How far the motions of the cams are off."""
        rows = [
            self._error_row("half of the cams", lambda each: each.median),
            self._error_row("95 % of the cams", lambda each: each.of_95),
            self._error_row("99.73 % of the cams", lambda each: each.of_99_73),
            self._error_row("worst cam", lambda each: each.worst),
            self._error_row("at cam angle, deg", lambda each: _number_cell(each.at_deg)),
            *(
                self._error_row(f"variance by {key}, %", partial(_variance_percent, key=key))
                for key in self._variance_keys
            ),
            self._error_row("not found, at most", lambda each: each.missed),
        ]
        if any(each.held for each in self.errors):
            rows.append(
                self._error_row("limit held by", lambda each: each.held and _percent_with_confidence(each.held))
            )
        units = {each.name: each.unit for each in self.errors}
        title = f"{self.scene.name}: largest errors of the motions of {self.cams:,} cams"
        kept = (
            f"Of the displacement the limit is ±{with_unit(self.within, self.errors[0].unit)}. "
            if self.within
            else ""
        )
        note = f"{self._outside_sentence} {kept}Variances are those where the root sum square is the largest."
        return replace(table_of(title, rows, ["", *units], units=units), note=note)

    @property
    def _outside_sentence(self) -> str:
        """How many cams no proof is of."""
        if not self.outside:
            return "All cams are within the tolerances."
        few = "1 of the cams is" if self.outside == 1 else f"{self.outside:,} of the cams are"
        return f"{few} outside of a tolerance, as ends of normal distributions are: no proof is of these."

    def _error_row(self, head: str, value: Callable[[ErrorSpread], float | str | None]) -> dict[str, Any]:
        """A row of the table; nothing where there is no value."""
        values = {each.name: value(each) for each in self.errors}
        return {"": head, **{name: "" if each is None else each for name, each in values.items()}}

    @property
    def _variance_keys(self) -> list[str]:
        """The keys of tolerances that explain a part of the variance."""
        return [*dict.fromkeys(key for each in self.errors for key in each.variances)]

    def limits_table(self) -> Table | None:
        """The share of cams that holds each limit, and how its quantity is spread."""
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
        """How far the motions are off, and the yield of each limit."""
        yield self.table()
        yield from filter(None, (self.limits_table(),))

    def document(self) -> dict[str, Any]:
        """Counts, the yield, and a record for each error and each limit."""
        return {
            "cams": self.cams,
            "seed": self.seed,
            "outside": self.outside,
            "held": self.held,
            "errors": self.errors,
            "limits": self.spreads,
        }

    def records(self) -> list[dict[str, Any]]:
        """A mapping for each limit."""
        return [{**each._asdict(), "held": each.held._asdict()} for each in self.spreads]

    @property
    def bounds(self) -> dict[str, float]:
        """The limits on what the cams have, by column."""
        return {
            limit.shown_quantities[0]: limit.bound
            for limit in resolve_design(self.scene).limits[::-1]
            if limit.shown_quantities
        }

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write what each cam has as a table (Parquet), a row a cam, which ``load`` reads.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        from camopt.solve.tables.table import write_columns  # noqa: PLC0415  it imports pyarrow

        write_columns(self.samples, self.scene, path)


@options_by_keyword
def sample_cams(
    scene: SceneSource, cams: int = DEFAULT_CAMS, *, seed: int = 0, within: float | None = None
) -> Batch:
    """Draw cams whose errors are spread as the tolerances of a scene say: their motions, and which hold the limits.

    The motion is that of the nominal profile with all errors of a cam, where its follower comes to rest on it. For
    limits, each cam has the motion that is asked, with sizes of its own; two contacts have the interference that
    all of its errors give, where it is the worst over the turn: see ``margins`` of ``tolerance`` for what all of
    them hold. The profile's self-crossing is not looked at.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with sizes of its own and ``[tolerances]``; its limits count if sizes of the follower have some.
    cams : int, default 65,536
        How many, at most 16,777,216; Sobol points are the most even for a power of 2.
    seed : int, default 0
        Which of all such draws.
    within : float, optional
        The largest error of the tool's position that counts as held, mm (deg); else that of the scene's limit
        ``position_error``, if it has one.

    Returns
    -------
    Batch
        How far motions are off, the yield with its interval, and how the quantity of each limit is spread.

    Raises
    ------
    BadInput
        If the scene lacks a size, or has no tolerances, or for a number of cams that is none.

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
    scene = scene.toleranced
    problem = resolve_design(scene)
    some = _SampledCams.from_tolerances(scene, problem, cams, seed)
    off, moving, on_errors = some.errors, some.tool_moving_errors, some.error_bounds
    if not off:
        raise no_tolerances_error(problem.file)
    held, samples = np.ones(cams, dtype=bool), dict(_error_columns(scene, off))
    largest, spreads = (
        [*_largest_error_columns(TurnErrors(scene, problem), moving)] if moving else [],
        tuple[Spread, ...](),
    )
    samples |= {each.column: SampleColumn(each.unit, each.sentence, each.values) for each in largest}
    if found := some.limit_results:
        held = np.all(found.excess <= 0.0, axis=0)
        spreads = tuple(_limit_spreads(*found))
        for limit, each in zip(found.limits, found.values, strict=True):
            known = find_quantity(limit.shown_quantities[0], limit.setup)
            samples[known.name] = SampleColumn(known.unit, known.sentence, each)
    on_errors |= {} if within is None else {error_names(problem.setup)[0]: within}
    for each in largest:
        held &= each.values <= on_errors.get(each.column, inf)
    errors = tuple(
        _spread_of_errors(each, real_error_parts(moving), on_errors.get(each.column)) for each in largest
    )
    ends = {
        key: (zone.lower, zone.upper)
        for key, zone in number_and_angle_zones(scene, problem.nominal_numbers).items()
    }
    ends |= error_ranges(scene, problem)
    outside = int(
        np.count_nonzero(
            exceed_tolerances(off, {key: ends[key.removesuffix(SECOND_CONTACT_SUFFIX)] for key in off})
        )
    )
    of_all = share_with_confidence(int(np.count_nonzero(held)), cams)
    return Batch(scene, cams, seed, outside, of_all, errors, spreads, samples, within)


def yield_of_cams(scene: Scene, problem: Problem, cams: int) -> Share | None:
    """The share of cams that holds the limits, as of ``sample_cams``; None if no limit is looked at."""
    some, held = _SampledCams.from_tolerances(scene, problem, cams, 0), np.ones(cams, dtype=bool)
    if not (some.limit_results or (some.tool_moving_errors and some.error_bounds)):
        return None
    if some.limit_results:
        held = np.all(some.limit_results.excess <= 0.0, axis=0)
    found, columns = some.largest_error_search, error_names(problem.setup)
    for column, bound in some.error_bounds.items() if some.tool_moving_errors else ():
        order = columns.index(column)
        errors = (
            found.largest_motion_errors(some.tool_moving_errors, order).error
            if order < RESPONSE_ORDERS
            else found.largest_dwell_changes(some.tool_moving_errors)
        )
        held &= errors <= bound / motion_scale(problem.setup, order % RESPONSE_ORDERS)
    return share_with_confidence(int(np.count_nonzero(held)), cams)


class _LimitResults(NamedTuple):
    """What cams have of limits: of the quantity of each, (limits, cams)."""

    limits: list[Limit]
    excess: FloatArray
    values: FloatArray
    numbers: dict[str, FloatArray]
    """Of each cam, by key of the scene."""
    errors: CamErrors
    """Which explain how these are spread."""
    interference: FloatArray | None = None
    """With which two contacts of each cam are the worst, (limits, cams)."""


@dataclass(frozen=True)
class _SampledCams:
    """Cams that are drawn."""

    scene: Scene
    problem: Problem
    errors: CamErrors

    @classmethod
    def from_tolerances(cls, scene: Scene, problem: Problem, cams: int, seed: int) -> "_SampledCams":
        return cls(
            scene, problem, sample_errors(scene, problem.nominal_numbers, cams, seed, partial(error_keys, problem))
        )

    @cached_property
    def tool_moving_errors(self) -> CamErrors:
        """The errors that move the tool."""
        return {
            key: each for key, each in self.errors.items() if moves_tool(key.removesuffix(SECOND_CONTACT_SUFFIX))
        }

    @cached_property
    def error_bounds(self) -> dict[str, float]:
        """The bounds of limits on errors, by column."""
        return {limit.shown_quantities[0]: limit.bound for limit in self.problem.limits if limit.is_on_motion_error}

    @cached_property
    def largest_error_search(self) -> LargestErrorSearch:
        """How the largest errors of their motions are found."""
        return LargestErrorSearch(
            RealCam(self.problem, self.scene.tolerances.waves or 0), tuple(self.tool_moving_errors)
        )

    @cached_property
    def limit_results(self) -> _LimitResults | None:
        """What they have of limits; None without errors of numbers that limits are about.

        Two contacts have the interference that is the worst over the turn, of its mounting and of all errors.
        """
        box = ToleranceBox.from_scene(self.scene, self.problem)
        of = {key: each for key, each in box.variables.items() if each.varies_by_design and key in self.errors}
        numbers = {key: box.problem.nominal_numbers[key] + self.errors[key] for key in of}
        waves, nodes = self.scene.tolerances.waves or 0, TurnErrors(self.scene, self.problem).nodes
        between = (
            None
            if box.interference is None
            else box.interference.sampled_interference_range(self.problem, self.errors, waves, nodes)
        )
        if not numbers and between is None:
            return None
        limits = [
            limit
            for limit in box.problem.without_deferred_limits.limits
            if limit.shown_quantities and not (limit.is_of_motion or limit.is_on_motion_error)
        ]
        every = box.problem.design.take(np.zeros(count_cams(self.errors), dtype=int))
        every = every.with_values({each.field: numbers[key] for key, each in of.items()})
        errors = {key: self.errors[key] for key in numbers}
        if between is None:
            return _LimitResults(limits, *evaluate_limits_in_blocks(box.problem, limits, every), numbers, errors)
        (excess, low), (other, high) = evaluate_limits_at_ends(
            LimitsByNumber(box.problem, limits, INTERFERENCE_KEY), every, between
        )
        if not numbers and np.array_equal(low, high, equal_nan=True):  # no limit is on what holds two contacts
            return None
        side = np.array([find_quantity(limit.shown_quantities[0], limit.setup).side for limit in limits]).reshape(
            -1, 1
        )
        tight = ~(side * low >= side * high)
        values, worst = (np.where(tight, *ends) for ends in ((high, low), (between.high, between.low)))
        errors |= separating_errors(self.errors)
        return _LimitResults(limits, np.maximum(excess, other), values, numbers, errors, worst)


def _number_cell(value: float | None) -> str | None:
    """A number that has not the unit of its column."""
    return None if value is None else number_text(round(value, 9))


def _variance_percent(spread: ErrorSpread, key: str) -> str | None:
    """The share of the variance that a tolerance explains, in %."""
    return _number_cell(100.0 * spread.variances[key]) if spread.variances else None


def _error_columns(scene: Scene, off: CamErrors) -> Iterator[tuple[str, SampleColumn]]:
    """The errors of cams as columns."""
    for key, values in real_error_parts(off).items():
        unit = error_unit(scene, key)
        name = f"{key.replace('.', '_')}_off_{unit.translate(UNIT_SIGNS)}"
        yield name, SampleColumn(unit, f"What is off by tolerances.{key}.", values)


class LargestErrorColumn(NamedTuple):
    """The largest error of the motion of each cam."""

    name: str
    column: str
    unit: str
    values: FloatArray
    """(n,), infinite where a follower finds no place on its cam."""
    at_deg: float | None
    variances: dict[str, float]
    missed: float | None

    @property
    def sentence(self) -> str:
        """What it is."""
        return "Largest change in a dwell." if self.name == DWELL_CHANGE else f"Largest error of the {self.name}."


def _largest_error_columns(turn: TurnErrors, off: CamErrors) -> Iterator[LargestErrorColumn]:
    """Those of displacement, velocity, acceleration, and the change in a dwell."""
    setup = turn.problem.setup
    columns = error_names(setup)
    found = LargestErrorSearch(RealCam(turn.problem, turn.scene.tolerances.waves or 0), tuple(off))
    for order, name in enumerate(MOTION_NAMES):
        unit, largest = motion_scale(setup, order), found.largest_motion_errors(off, order)
        known = not turn.unbounded_tolerances(order)
        signed = (
            found.errors_at_angle(off, turn.angle_of_largest_total(root_sum_square_magnitude, order), order)
            if known
            else None
        )
        yield LargestErrorColumn(
            name,
            columns[order],
            motion_table_unit(setup, order),
            unit * np.where(np.isnan(largest.error), inf, largest.error),
            found.largest_error_angle(off, largest, _worst_cam_index(largest.error)),
            {} if signed is None else {key: _variance_share(signed, each) for key, each in off.items()},
            unit * found.missed_error(off, order),
        )
    if found.has_dwells:
        change = found.largest_dwell_changes(off)
        values = motion_scale(setup, 0) * np.where(np.isnan(change), inf, change)
        yield LargestErrorColumn(DWELL_CHANGE, columns[-1], motion_table_unit(setup, 0), values, None, {}, None)


def _spread_of_errors(of: LargestErrorColumn, parts: CamErrors, bound: float | None) -> ErrorSpread:
    """How one of them is spread."""
    median, most, nearly_all = (float(each) for each in np.quantile(of.values, ERROR_QUANTILES, method="higher"))
    worst = _worst_cam_index(of.values)
    own = {key: float(each[worst]) for key, each in parts.items()}
    held = (
        None if bound is None else share_with_confidence(int(np.count_nonzero(of.values <= bound)), of.values.size)
    )
    ends = median, most, nearly_all, float(of.values[worst])
    return ErrorSpread(of.name, of.unit, *ends, of.at_deg, own, of.variances, of.missed, held)


def _worst_cam_index(errors: FloatArray) -> int:
    """Which cam is the worst; one whose follower finds no place before others."""
    return int(np.where(np.isnan(errors), inf, errors).argmax())


def _variance_share(values: FloatArray, errors: FloatArray) -> float:
    """The share of the variance that an error explains, with all of its parts."""
    return sum(
        variance_explained_by_part(values, part)
        for part in ((errors.real, errors.imag) if np.iscomplexobj(errors) else (errors,))
    )


def evaluate_limits_in_blocks(problem: Problem, limits: list[Limit], designs: Designs) -> LimitValues:
    """As ``limited``, some designs at a time."""
    (found,) = _evaluate_in_blocks(
        len(designs), lambda some: [evaluate_limits(problem, limits, designs.take(some))]
    )
    return found


def evaluate_limits_at_ends(
    limits: LimitsByNumber, designs: Designs, between: SeparationRange
) -> list[LimitValues]:
    """What designs have of limits at both ends of what is between them, some designs at a time."""
    return _evaluate_in_blocks(
        len(designs),
        lambda some: [*limits.evaluate_numbers(designs.take(some), (between.low[some], between.high[some]))],
    )


def _evaluate_in_blocks(count: int, work: Callable[[slice], list[LimitValues]]) -> list[LimitValues]:
    parts = [slice(first, first + LIMIT_DESIGNS_AT_ONCE) for first in range(0, count, LIMIT_DESIGNS_AT_ONCE)]
    with ThreadPoolExecutor(THREADS) as pool:
        found = [*pool.map(work, parts)]
    return [
        LimitValues(*(np.concatenate(each, axis=1) for each in zip(*one, strict=True)))
        for one in zip(*found, strict=True)
    ]


def share_with_confidence(count: int, cams: int) -> Share:
    """A share with the interval of Clopper and Pearson."""
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
    """How the quantity of each limit is spread."""
    cams = values.shape[1]
    for row, (limit, over, each) in enumerate(zip(limits, excess, values, strict=True)):
        sizes = numbers if interference is None else {**numbers, INTERFERENCE_KEY: interference[row]}
        worst = worst_design(limit, over, each)
        held = share_with_confidence(int(np.count_nonzero(over <= 0.0)), cams)
        low, median, high = (
            float(value) for value in np.quantile(each, [THREE_SIGMA_TAIL, 0.5, 1.0 - THREE_SIGMA_TAIL])
        )
        own = {key: float(size[worst]) for key, size in sizes.items()}
        parts = {key: _variance_share(each, error) for key, error in errors.items()}
        yield Spread(limit.name, limit.shown_quantities[0], held, low, median, high, float(each[worst]), own, parts)


def variance_explained_by_part(values: FloatArray, size: FloatArray) -> float:
    """The share of the variance of values that a size explains, from the means over classes of it."""
    count = min(VARIANCE_CLASSES, max(values.size // VARIANCE_CLASSES, 1))
    spread = float(np.var(values)) if np.all(np.isfinite(values)) else 0.0
    if spread <= (1e-12 * float(np.max(np.abs(values)))) ** 2:
        return 0.0
    classes = np.array_split(values[np.argsort(size, kind="stable")], count)
    means, weights = (np.array([f(each) for each in classes]) for f in (np.mean, np.size))
    middle = np.average(means, weights=weights)
    return float(np.average(np.square(means - middle), weights=weights) / spread)


def _percent_with_confidence(held: Share) -> str:
    """A share in per cent, with its interval."""
    low, high = 100.0 * held.low, 100.0 * held.high
    return f"{100.0 * held.share:.6g} % [{low:.4f}, {high:.4f}]"
