"""Boxes of designs: the proof that a box holds no feasible design, and the part of a box that may hold one.

Every feasible design holds a limit at every cam angle. The formula of the limit at one angle, run on a box together
with its slopes by the sizes (``numerics.sloped``), bounds the excess of all designs of the box. If that is above 0,
the box is empty; if it is above 0 at one end of a size, that end is cut off.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 8 (interval Newton).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any, Generic, NamedTuple, TypeVar, cast

import numpy as np

from camopt.core.numerics import LARGEST, LEAST, FloatArray
from camopt.core.numerics.curves import Linear, value_of
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.loading import TrainLoadTable
from camopt.core.numerics.sloped import as_quotient, as_sloped
from camopt.core.numerics.state import State, TrainForces
from camopt.model.effects import Case
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms import Designs
from camopt.model.motion.programme import Programme, peak
from camopt.scene.problem.claims import AnyClaim, Claim, MeanClaim
from camopt.scene.problem.limit import Limit
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.zones import Off, moved
from camopt.solve.smallest.excesses import Excesses, chained_excesses, combined, cut_by, widest
from camopt.solve.verdicts.claim_boxes import excess_of
from camopt.solve.verdicts.mean_boxes import mean_excess
from camopt.solve.verdicts.sloped_designs import sloped_boxes

Kind = TypeVar("Kind", bound=AnyClaim, covariant=True)


class Asked(NamedTuple, Generic[Kind]):
    """A claim on designs, with the problem of their motion."""

    problem: Problem
    claim: Kind


def claims_on_size(
    problem: Problem, of: Callable[[Limit], Sequence[Claim]] = lambda limit: limit.claims
) -> list[Asked[Claim]]:
    """The claims of the limits that depend on the sizes of the cam, or on numbers that it brings.

    Those of all cams that have to hold them, with the motion that each has by its train.
    """
    return [
        Asked(own, at(of_designs(claim), off))
        for own, off in ((problem, {}), *problem.others)
        for limit in own.limits
        if not limit.is_of_motion
        for claim in of(limit)
    ]


def at(claim: Claim, off: Off) -> Claim:
    """What a claim says of the design that is off by so much."""
    if not off:
        return claim
    made, factor, unit = claim.curve, claim.factor, claim.unit
    return claim._replace(
        curve=lambda designs, programme: made(moved(designs, off), programme),
        factor=lambda designs: factor(moved(designs, off)),
        unit=lambda designs: unit(moved(designs, off)),
    )


def of_designs(claim: Claim) -> Claim:
    """A claim whose curve is that of designs."""
    return claim._replace(curve=curve_of_designs(claim.curve, claim.kinds))


def curve_of_designs(made: Any, strokes: int) -> Any:
    """A curve as that of designs: what strokes have of a derivative of the motion at most is the same for all."""
    return partial(_level, derivative=made, strokes=strokes) if isinstance(made, Derivative) else made


def _level(designs: Designs, programme: Programme, derivative: Derivative, strokes: int) -> Linear:
    """The largest magnitude of a derivative of the motion, as a curve."""
    most, none = peak(derivative.of(programme), derivative.order, strokes), np.zeros(len(designs))
    return Linear(none, none, none, none + most)


def means_on_size(problem: Problem) -> list[Asked[MeanClaim]]:
    """The claims on means of the limits that depend on the size of the cam."""
    means = (limit.mean for limit in problem.limits if not limit.is_of_motion)
    return [Asked(problem, mean) for mean in means if mean is not None]


def designs_at(
    problem: Problem,
    low: dict[str, FloatArray],
    high: dict[str, FloatArray],
    share: float,
    discs: Sequence[str] = ("size",),
) -> Designs:
    """One design of each box: its middle, but at a given share of the way from least to largest size."""
    middle = {name: (low[name] + high[name]) / 2 for name in low}
    sizes = {disc: low[disc] + share * (high[disc] - low[disc]) for disc in discs}
    return problem.design.with_values({**middle, **sizes})


class Examined(NamedTuple):
    """The results of n boxes."""

    empty: Any
    """Which hold no feasible design (n,)."""
    level: Any
    """Of which no design is seen to exceed a limit by more than rounding (n,)."""
    inside: Designs
    """One design of each."""
    side: Any
    """The free size to cut next (n,)."""
    low: dict[str, FloatArray]
    high: dict[str, FloatArray]
    """The ends between which the feasible designs lie, (n,) of each free size."""


def examined(
    problem: Problem,
    claims: Sequence[Asked[AnyClaim]],
    box: Designs,
    free: list[str],
    discs: Sequence[str] = ("size",),
) -> Examined:
    """The limits over boxes, each at the cam angles where it is worst for one design of the box.

    The side to cut is the one across which the excess over the worst limit changes the most; the longest, where no
    assembled design of the box is at hand.
    """
    empty = problem.setup.mechanism.impossible(box, problem.programme)
    inside, exists = representatives(problem, box, free, ~empty)
    intervals: dict[str, Any] = box.values
    low, high = (np.array([getattr(intervals[n], end) for n in free]) for end in ("low", "high"))
    side, index, level = np.argmax(high - low, axis=0), np.flatnonzero(exists), exists.copy()
    present = [each for each in claims if each.problem.programme.has(each.claim.kinds)]
    if index.size and present:
        point = np.array([inside.values[n][index] for n in free])
        span = Interval(low[:, index] - point, high[:, index] - point)
        with np.errstate(all="ignore"):
            over = _excesses(present, box.take(index), inside.take(index), free)
            together = over
            for disc in set(discs).intersection(free) if len(free) > 1 else ():
                together = combined(together, span, free.index(disc))
            level[index] = over.nowhere
            side[index] = widest(over, span)
            low[:, index], high[:, index], empty[index] = cut_by(together, low[:, index], high[:, index], point)
    ends = (dict(zip(free, end, strict=True)) for end in (low, high))
    return Examined(empty, level, inside, side, *ends)


def present_claims(problem: Problem, claims: Sequence[Claim]) -> list[Claim]:
    """Those of some claims whose strokes the motion has."""
    return [each for each in claims if problem.programme.has(each.kinds)]


def _excesses(claims: Sequence[Asked[AnyClaim]], box: Designs, inside: Designs, free: list[str]) -> Excesses:
    """The limits on both sides of the cam angles where one design of each box exceeds them the most.

    Those on means are over the whole turn.
    """
    count, found, cases = len(inside), [], dict[int, Case]()
    for problem, claim in claims:
        if isinstance(claim, MeanClaim):
            found.append(Excesses.of(mean_excess(problem, claim, box, inside, free)))
            continue
        goals = [(claim.kinds, LARGEST if side > 0.0 else LEAST) for side in claim.sides]
        case = cases.setdefault(id(problem), Case(problem.setup, problem.programme, inside))
        angles = problem.programme.one_sided(case.extremes(claim.curve, goals).where, claim.kinds).ravel()
        rows = angles.size // count
        designs, like = sloped_boxes(box, inside, free, rows)
        state = rounded(problem.programme.state(angles), problem.programme)
        value = value_of(claim.curve(designs, problem.programme), ..., state)
        sides = np.tile(np.repeat(claim.sides, count), 2)
        excess = as_sloped(excess_of(claim, sides, as_quotient(value), designs), like)
        found.append(Excesses.of(excess, rows))
    return chained_excesses(found)


def rounded(state: State, programme: Programme) -> State:
    """A state at cam angles with the rounding of their laws, and of what a train brings."""
    table = programme.table
    errors = table.error.max(axis=0)[:4]
    y, y1, y2, y3 = (Interval(x - e, x + e) for x, e in zip(state[:4], errors, strict=True))
    load = state.load
    if isinstance(table.load, TrainLoadTable):
        off = [error for force in table.load for error in force.error[:, :2].max(axis=0)]
        load = TrainForces(*(Interval(x - e, x + e) for x, e in zip(cast(TrainForces, load), off, strict=True)))
    return State(y, y1, y2, y3, load)


def representatives(problem: Problem, box: Designs, free: list[str], wanted: Any) -> tuple[Designs, Any]:
    """A design of each wanted box that can be assembled, and whether one is found.

    Tried in turn: the middle; the largest size with the offset nearest to zero; the least size; every corner.
    """
    intervals: dict[str, Any] = box.values
    low = {name: interval.low for name, interval in intervals.items()}
    high = {name: interval.high for name, interval in intervals.items()}
    chosen = designs_at(problem, low, high, 0.5)
    nearest = np.minimum(np.maximum(low["offset"], 0.0), high["offset"])
    largest = replace(designs_at(problem, low, high, 1.0), offset=nearest)
    exists = wanted & problem.setup.mechanism.exists(chosen, problem.programme)
    ends = product(*((low[name], high[name]) for name in free))
    corners = (chosen.with_values(dict(zip(free, corner, strict=True))) for corner in ends)
    for other in (largest, designs_at(problem, low, high, 0.0), *corners):
        if not np.any(wanted & ~exists):
            break
        better = wanted & ~exists & problem.setup.mechanism.exists(other, problem.programme)
        values = {name: np.where(better, other.values[name], a) for name, a in chosen.values.items()}
        chosen, exists = chosen.with_values(values), exists | better
    return chosen, exists
