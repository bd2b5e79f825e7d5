"""A batch of cams: how far the motions of those that are made are off, and how many hold the limits.

Each cam has errors of its own, drawn as ``[tolerances]`` says (``tolerances.drawn_cams``), and every number is that
of the cam itself, not of a linear model. The errors of its motion are those of the nominal profile, cut and put
together so (``tolerances.real_cam``); the quantities of limits are those of a cam that was designed so. The share
that holds the limits has the interval of Clopper and Pearson, which is that of independent draws: Sobol
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
from camopt.core.quantities.shown import Drawn
from camopt.core.quantities.unit_systems import shown
from camopt.model.effects import quantity_of
from camopt.model.effects.answers import ORDERS, SECOND
from camopt.model.effects.motion import error_names, scale, unit_of
from camopt.model.mechanisms import Designs
from camopt.scene.arguments import SceneSource, check_count, options_by_keyword, scene_from
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem, resolve, resolve_design
from camopt.scene.problem.zones import error_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import moves_tool
from camopt.solve.tables.cells import number, with_unit
from camopt.solve.tables.result import NUMERIC, Cell, Columns, Result, Table, table_of
from camopt.solve.tolerances.drawn_cams import THREADS, LargestErrors, beyond, count_of, drawn, parts_of
from camopt.solve.tolerances.errors import CutErrors, error_ends, error_unit, errors_of
from camopt.solve.tolerances.held import INTERFERENCE, moving_apart
from camopt.solve.tolerances.margins import OWN_SIZES, Box, Limited, LimitedBy, limited, worst_of
from camopt.solve.tolerances.real_cam import RealCam
from camopt.solve.tolerances.response import Between
from camopt.solve.tolerances.turn import NAMES, TurnErrors, band, no_tolerances

if TYPE_CHECKING:
    import pandas as pd

SAMPLES = "samples"
CAMS = 2**16
"""Unless told."""
MOST_CAMS = 2**24
AT_ONCE = 2**16
MOST_PARTS = 6
"""Of the errors that explain how a quantity is spread, in the table."""
CLASSES = 64
"""Of a size, for the variance that it explains."""
CONFIDENCE = 0.95
IN_NAMES = str.maketrans({"/": "_per_", "·": "_", "²": "2", "µ": "u"})
"""What signs of units are in names of columns."""
TAIL = 0.00135
"""Of a normal distribution beyond three standard deviations, on one side."""
SHARES = (0.5, 0.95, 0.9973)
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


class Sampled(NamedTuple):
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
class Batch(Result, Drawn):
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
    samples: Mapping[str, Sampled] = field(repr=False, compare=False)
    within: float | None = None
    main_rows: ClassVar[str] = "limits"

    @property
    def kept_tables(self) -> tuple[str, ...]:
        """The samples."""
        return (SAMPLES,)

    def to_pandas(self, name: str | None = None) -> "pd.DataFrame":
        """Rows of the batch as a DataFrame: "limits", the default, "errors", or "samples" with a row for each cam.

        Raises
        ------
        UnknownName
            For another name.
        """
        if name != SAMPLES:
            return super().to_pandas(name)
        values = {column: each.values for column, each in self.samples.items()}
        return Columns(values, {column: each.unit for column, each in self.samples.items()}).to_pandas()

    def table(self) -> Table:
        """How far the motions of the cams are off."""
        rows = [
            self._row("half of the cams", lambda each: each.median),
            self._row("95 % of the cams", lambda each: each.of_95),
            self._row("99.73 % of the cams", lambda each: each.of_99_73),
            self._row("worst cam", lambda each: each.worst),
            self._row("at cam angle, deg", lambda each: _plain(each.at_deg)),
            *(self._row(f"variance by {key}, %", partial(_variance, key=key)) for key in self._spread_by),
            self._row("not found, at most", lambda each: each.missed),
        ]
        if any(each.held for each in self.errors):
            rows.append(self._row("limit held by", lambda each: each.held and _percent(each.held)))
        units = {each.name: each.unit for each in self.errors}
        title = f"{self.scene.name}: largest errors of the motions of {self.cams:,} cams"
        kept = (
            f"Of the displacement the limit is ±{with_unit(self.within, self.errors[0].unit)}. "
            if self.within
            else ""
        )
        note = f"{self._outside} {kept}Variances are those where the root sum square is the largest."
        return replace(table_of(title, rows, ["", *units], units=units), note=note)

    @property
    def _outside(self) -> str:
        """How many cams no proof is of."""
        if not self.outside:
            return "All cams are within the tolerances."
        few = "1 of the cams is" if self.outside == 1 else f"{self.outside:,} of the cams are"
        return f"{few} outside of a tolerance, as ends of normal distributions are: no proof is of these."

    def _row(self, head: str, value: Callable[[ErrorSpread], float | str | None]) -> dict[str, Any]:
        """A row of the table; nothing where there is no value."""
        values = {each.name: value(each) for each in self.errors}
        return {"": head, **{name: "" if each is None else each for name, each in values.items()}}

    @property
    def _spread_by(self) -> list[str]:
        """The keys of tolerances that explain a part of the variance."""
        return [*dict.fromkeys(key for each in self.errors for key in each.variances)]

    def limits_table(self) -> Table | None:
        """The share of cams that holds each limit, and how its quantity is spread."""
        if not self.spreads:
            return None
        setup = resolve(self.scene).setup
        heads = ["limit", "held by", "0.135 %", "median", "99.865 %", "worst", "by"]
        rows = [["all", _percent(self.held), *([""] * 5)]]
        for each in self.spreads:
            unit = quantity_of(each.quantity, setup).unit
            values = [number(shown(value, unit)) for value in (each.low, each.median, each.high)]
            parts = sorted(each.variances.items(), key=lambda part: -part[1])[:MOST_PARTS]
            by = ", ".join(f"{key.removeprefix('follower.')} {100.0 * part:.0f} %" for key, part in parts)
            rows.append([each.limit, _percent(each.held), *values, with_unit(each.worst, unit), by])
        kinds = [Cell(head, NUMERIC if head in heads[1:6] else "") for head in heads]
        title = f"{self.scene.name}: {self.cams:,} cams drawn by the tolerances, each cut for its own sizes"
        return Table.of(title, kinds, rows, f"In brackets with a confidence of 95 %. {OWN_SIZES}")

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
        return {limit.shown[0]: limit.bound for limit in resolve_design(self.scene).limits[::-1] if limit.shown}

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
def sample_cams(scene: SceneSource, cams: int = CAMS, *, seed: int = 0, within: float | None = None) -> Batch:
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
    if not isinstance(cams, int) or not 1 <= cams <= MOST_CAMS:
        raise BadInput([Mistake("camopt", "cams", cams, f"a whole number from 1 to {MOST_CAMS:,}")])
    scene = scene.toleranced
    problem = resolve_design(scene)
    some = _Drawn.of(scene, problem, cams, seed)
    off, moving, on_errors = some.off, some.moving, some.on_errors
    if not off:
        raise no_tolerances(problem.file)
    held, samples = np.ones(cams, dtype=bool), dict(_errors_sampled(scene, off))
    largest, spreads = [*_largest(TurnErrors(scene, problem), moving)] if moving else [], tuple[Spread, ...]()
    samples |= {each.column: Sampled(each.unit, each.sentence, each.values) for each in largest}
    if found := some.by_limits:
        held = np.all(found.excess <= 0.0, axis=0)
        spreads = tuple(_spreads(*found))
        for limit, each in zip(found.limits, found.values, strict=True):
            known = quantity_of(limit.shown[0], limit.setup)
            samples[known.name] = Sampled(known.unit, known.sentence, each)
    on_errors |= {} if within is None else {error_names(problem.setup)[0]: within}
    for each in largest:
        held &= each.values <= on_errors.get(each.column, inf)
    errors = tuple(_error(each, parts_of(moving), on_errors.get(each.column)) for each in largest)
    ends = {key: (zone.lower, zone.upper) for key, zone in error_zones(scene, problem.nominal).items()}
    ends |= error_ends(scene, problem)
    outside = int(np.count_nonzero(beyond(off, {key: ends[key.removesuffix(SECOND)] for key in off})))
    of_all = share_of(int(np.count_nonzero(held)), cams)
    return Batch(scene, cams, seed, outside, of_all, errors, spreads, samples, within)


def yield_of(scene: Scene, problem: Problem, cams: int) -> Share | None:
    """The share of cams that holds the limits, as of ``sample_cams``; None if no limit is looked at."""
    some, held = _Drawn.of(scene, problem, cams, 0), np.ones(cams, dtype=bool)
    if not (some.by_limits or (some.moving and some.on_errors)):
        return None
    if some.by_limits:
        held = np.all(some.by_limits.excess <= 0.0, axis=0)
    found, columns = some.largest, error_names(problem.setup)
    for column, bound in some.on_errors.items() if some.moving else ():
        order = columns.index(column)
        errors = found.of_motion(some.moving, order).error if order < ORDERS else found.of_dwells(some.moving)
        held &= errors <= bound / scale(problem.setup, order % ORDERS)
    return share_of(int(np.count_nonzero(held)), cams)


class _ByLimits(NamedTuple):
    """What cams have of limits: of the quantity of each, (limits, cams)."""

    limits: list[Limit]
    excess: FloatArray
    values: FloatArray
    numbers: dict[str, FloatArray]
    """Of each cam, by key of the scene."""
    errors: CutErrors
    """Which explain how these are spread."""
    interference: FloatArray | None = None
    """With which two contacts of each cam are the worst, (limits, cams)."""


@dataclass(frozen=True)
class _Drawn:
    """Cams that are drawn."""

    scene: Scene
    problem: Problem
    off: CutErrors

    @classmethod
    def of(cls, scene: Scene, problem: Problem, cams: int, seed: int) -> "_Drawn":
        return cls(scene, problem, drawn(scene, problem.nominal, cams, seed, partial(errors_of, problem)))

    @cached_property
    def moving(self) -> CutErrors:
        """The errors that move the tool."""
        return {key: each for key, each in self.off.items() if moves_tool(key.removesuffix(SECOND))}

    @cached_property
    def on_errors(self) -> dict[str, float]:
        """The bounds of limits on errors, by column."""
        return {limit.shown[0]: limit.bound for limit in self.problem.limits if limit.of_errors}

    @cached_property
    def largest(self) -> LargestErrors:
        """How the largest errors of their motions are found."""
        return LargestErrors(RealCam(self.problem, self.scene.tolerances.waves or 0), tuple(self.moving))

    @cached_property
    def by_limits(self) -> _ByLimits | None:
        """What they have of limits; None without errors of numbers that limits are about.

        Two contacts have the interference that is the worst over the turn, of its mounting and of all errors.
        """
        box = Box.of(self.scene, self.problem)
        of = {key: each for key, each in box.variables.items() if each.is_ranged and key in self.off}
        numbers = {key: box.problem.nominal[key] + self.off[key] for key in of}
        waves, nodes = self.scene.tolerances.waves or 0, TurnErrors(self.scene, self.problem).nodes
        between = None if box.apart is None else box.apart.of_drawn(self.problem, self.off, waves, nodes)
        if not numbers and between is None:
            return None
        limits = [
            limit
            for limit in box.problem.without_last.limits
            if limit.shown and not (limit.is_of_motion or limit.of_errors)
        ]
        every = box.problem.design.take(np.zeros(count_of(self.off), dtype=int))
        every = every.with_values({each.field: numbers[key] for key, each in of.items()})
        errors = {key: self.off[key] for key in numbers}
        if between is None:
            return _ByLimits(limits, *evaluated(box.problem, limits, every), numbers, errors)
        (excess, low), (other, high) = at_ends(LimitedBy(box.problem, limits, INTERFERENCE), every, between)
        if not numbers and np.array_equal(low, high, equal_nan=True):  # no limit is on what holds two contacts
            return None
        side = np.array([quantity_of(limit.shown[0], limit.setup).side for limit in limits]).reshape(-1, 1)
        tight = ~(side * low >= side * high)
        values, worst = (np.where(tight, *ends) for ends in ((high, low), (between.high, between.low)))
        errors |= moving_apart(self.off)
        return _ByLimits(limits, np.maximum(excess, other), values, numbers, errors, worst)


def _plain(value: float | None) -> str | None:
    """A number that has not the unit of its column."""
    return None if value is None else number(round(value, 9))


def _variance(spread: ErrorSpread, key: str) -> str | None:
    """The share of the variance that a tolerance explains, in %."""
    return _plain(100.0 * spread.variances[key]) if spread.variances else None


def _errors_sampled(scene: Scene, off: CutErrors) -> Iterator[tuple[str, Sampled]]:
    """The errors of cams as columns."""
    for key, values in parts_of(off).items():
        unit = error_unit(scene, key)
        name = f"{key.replace('.', '_')}_off_{unit.translate(IN_NAMES)}"
        yield name, Sampled(unit, f"What is off by tolerances.{key}.", values)


class LargestOfEach(NamedTuple):
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


def _largest(turn: TurnErrors, off: CutErrors) -> Iterator[LargestOfEach]:
    """Those of displacement, velocity, acceleration, and the change in a dwell."""
    setup = turn.problem.setup
    columns = error_names(setup)
    found = LargestErrors(RealCam(turn.problem, turn.scene.tolerances.waves or 0), tuple(off))
    for order, name in enumerate(NAMES):
        unit, largest = scale(setup, order), found.of_motion(off, order)
        known = not turn.unbounded(order)
        signed = found.at(off, turn.highest(band, order), order) if known else None
        yield LargestOfEach(
            name,
            columns[order],
            unit_of(setup, order),
            unit * np.where(np.isnan(largest.error), inf, largest.error),
            found.angle(off, largest, _worst(largest.error)),
            {} if signed is None else {key: _explained_by(signed, each) for key, each in off.items()},
            unit * found.missed(off, order),
        )
    if found.has_dwells:
        change = found.of_dwells(off)
        values = scale(setup, 0) * np.where(np.isnan(change), inf, change)
        yield LargestOfEach(DWELL_CHANGE, columns[-1], unit_of(setup, 0), values, None, {}, None)


def _error(of: LargestOfEach, parts: CutErrors, bound: float | None) -> ErrorSpread:
    """How one of them is spread."""
    median, most, nearly_all = (float(each) for each in np.quantile(of.values, SHARES, method="higher"))
    worst = _worst(of.values)
    own = {key: float(each[worst]) for key, each in parts.items()}
    held = None if bound is None else share_of(int(np.count_nonzero(of.values <= bound)), of.values.size)
    ends = median, most, nearly_all, float(of.values[worst])
    return ErrorSpread(of.name, of.unit, *ends, of.at_deg, own, of.variances, of.missed, held)


def _worst(errors: FloatArray) -> int:
    """Which cam is the worst; one whose follower finds no place before others."""
    return int(np.where(np.isnan(errors), inf, errors).argmax())


def _explained_by(values: FloatArray, errors: FloatArray) -> float:
    """The share of the variance that an error explains, with all of its parts."""
    return sum(
        explained(values, part) for part in ((errors.real, errors.imag) if np.iscomplexobj(errors) else (errors,))
    )


def evaluated(problem: Problem, limits: list[Limit], designs: Designs) -> Limited:
    """As ``limited``, some designs at a time."""
    (found,) = _in_parts(len(designs), lambda some: [limited(problem, limits, designs.take(some))])
    return found


def at_ends(limits: LimitedBy, designs: Designs, between: Between) -> list[Limited]:
    """What designs have of limits at both ends of what is between them, some designs at a time."""
    return _in_parts(
        len(designs), lambda some: [*limits.at(designs.take(some), (between.low[some], between.high[some]))]
    )


def _in_parts(count: int, work: Callable[[slice], list[Limited]]) -> list[Limited]:
    parts = [slice(first, first + AT_ONCE) for first in range(0, count, AT_ONCE)]
    with ThreadPoolExecutor(THREADS) as pool:
        found = [*pool.map(work, parts)]
    return [
        Limited(*(np.concatenate(each, axis=1) for each in zip(*one, strict=True)))
        for one in zip(*found, strict=True)
    ]


def share_of(count: int, cams: int) -> Share:
    """A share with the interval of Clopper and Pearson."""
    tail = (1.0 - CONFIDENCE) / 2.0
    low = float(scipy.special.betaincinv(count, cams - count + 1, tail)) if count else 0.0
    high = float(scipy.special.betaincinv(count + 1, cams - count, 1.0 - tail)) if count < cams else 1.0
    return Share(count / cams, low, high)


def _spreads(
    limits: list[Limit],
    excess: FloatArray,
    values: FloatArray,
    numbers: dict[str, FloatArray],
    errors: CutErrors,
    interference: FloatArray | None,
) -> Iterator[Spread]:
    """How the quantity of each limit is spread."""
    cams = values.shape[1]
    for row, (limit, over, each) in enumerate(zip(limits, excess, values, strict=True)):
        sizes = numbers if interference is None else {**numbers, INTERFERENCE: interference[row]}
        worst = worst_of(limit, over, each)
        held = share_of(int(np.count_nonzero(over <= 0.0)), cams)
        low, median, high = (float(value) for value in np.quantile(each, [TAIL, 0.5, 1.0 - TAIL]))
        own = {key: float(size[worst]) for key, size in sizes.items()}
        parts = {key: _explained_by(each, error) for key, error in errors.items()}
        yield Spread(limit.name, limit.shown[0], held, low, median, high, float(each[worst]), own, parts)


def explained(values: FloatArray, size: FloatArray) -> float:
    """The share of the variance of values that a size explains, from the means over classes of it."""
    count = min(CLASSES, max(values.size // CLASSES, 1))
    spread = float(np.var(values)) if np.all(np.isfinite(values)) else 0.0
    if spread <= (1e-12 * float(np.max(np.abs(values)))) ** 2:
        return 0.0
    classes = np.array_split(values[np.argsort(size, kind="stable")], count)
    means, weights = (np.array([f(each) for each in classes]) for f in (np.mean, np.size))
    middle = np.average(means, weights=weights)
    return float(np.average(np.square(means - middle), weights=weights) / spread)


def _percent(held: Share) -> str:
    """A share in per cent, with its interval."""
    low, high = 100.0 * held.low, 100.0 * held.high
    return f"{100.0 * held.share:.6g} % [{low:.4f}, {high:.4f}]"
