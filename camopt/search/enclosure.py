"""Boxes of designs: the proof that a box holds no feasible design, and the part of a box that may hold one.

Every feasible design holds a limit at every cam angle. The formula of the limit at one angle, run on a box together
with its slopes by the sizes (``numerics.sloped``), bounds the excess of all designs of the box. If that is above 0,
the box is empty; if it is above 0 at one end of a size, that end is cut off.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 8 (interval Newton).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product
from math import radians, tan
from typing import Any, NamedTuple

import numpy as np

from camopt.effects import Case
from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.motion.table import DWELL, RETURN, RISE, TURN
from camopt.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, FloatArray
from camopt.numerics.curves import curve
from camopt.numerics.interval import Interval
from camopt.numerics.sloped import Quotient, Sloped, as_quotient, as_sloped, at_point, variables
from camopt.question import Question

ROUNDING = 1e-15  # relative, of an end of a side
LARGE = 1e300  # in place of a slope without bounds
MARGIN = 1e-11  # relative: far above the rounding of an interval, far below any tolerance
WAYS = {LARGEST: (1.0,), LEAST: (-1.0,), LARGEST_MAGNITUDE: (1.0, -1.0)}


@dataclass(frozen=True)
class Constraint:
    """A limit as a curve over the turn: its largest value (magnitude, −least) times a weight is bounded."""

    curve: Callable[[Designs, Programme], Any]
    kinds: int
    goal: int
    bound: float
    weight: Callable[[Designs], Any] = lambda designs: 1.0
    unit: Callable[[Designs], Any] = lambda designs: 1.0
    """What a value is compared with where the bound is 0."""

    def excess(self, way: FloatArray, found: Quotient, designs: Designs) -> Any:
        """What is above 0 where the limit is exceeded, relative to the terms of the limit."""
        value, allowed = way * found.above * self.weight(designs), self.bound * found.below
        scale = np.abs(at_point(value)) + np.abs(at_point(allowed))
        return (value - allowed) / (scale if self.bound else scale + at_point(self.unit(designs)))


def constraints_of(question: Question) -> list[Constraint]:
    """The limits that depend on the size of the cam."""
    mechanism = question.subject.mechanism
    found = []
    for limit in question.limits:
        for top in () if limit.of_motion else limit.ceilings:
            found.append(Constraint(top.curve, top.kinds, top.goal, top.bound))
        if limit.name in ("pressure_angle", "pressure_angle_return"):
            kinds = RETURN if limit.name.endswith("return") else RISE | DWELL
            found.append(Constraint(mechanism.pressure, kinds, LARGEST_MAGNITUDE, tan(radians(limit.bound))))
        elif limit.name == "face_reach" and mechanism.reach:
            found.append(Constraint(mechanism.reach, TURN, LARGEST_MAGNITUDE, limit.bound))
        elif limit.name in ("curvature_radius", "undercut"):
            if mechanism.profile_radius:
                found.append(Constraint(mechanism.profile_radius, TURN, LEAST, -limit.bound, unit=_size))
            elif mechanism.curvature:
                goal = LARGEST_MAGNITUDE if mechanism.grooved else LARGEST
                found.append(Constraint(mechanism.curvature, TURN, goal, 1.0, _radius(limit.bound)))
    return found


def _radius(bound: float) -> Callable[[Designs], Any]:
    return lambda designs: designs.roller_radius + bound


def _size(designs: Designs) -> Any:
    return designs.size


def points_of(question: Question, low: dict[str, FloatArray], high: dict[str, FloatArray], share: float) -> Designs:
    """One design of each box: its middle, but at a given share of the way from least to largest size."""
    middle = {name: (low[name] + high[name]) / 2 for name in low}
    size = low["size"] + share * (high["size"] - low["size"])
    return Designs(**{**middle, "size": size}, sense=question.design.sense)


class Claims(NamedTuple):
    """The excess of n boxes over the limits at m cam angles, relative: above 0 no design is feasible."""

    least: FloatArray
    """Over each box (m, n)."""
    most: FloatArray
    """Over each box (m, n)."""
    at: FloatArray
    """At one design of each box (m, n)."""
    slopes: Interval
    """By each of the d free sizes (d, m, n)."""

    @classmethod
    def of(cls, excess: Sloped, rows: int = 1) -> "Claims":
        """That of one limit at so many cam angles, one after the other, for each box."""
        least, most, at = (x.reshape(rows, -1) for x in (excess.value.low, excess.value.high, excess.at))
        return cls(least, most, at, excess.slopes.reshaped(-1, rows, at.shape[1]))


class Examined(NamedTuple):
    """What is known of n boxes."""

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
    question: Question, programme: Programme, constraints: list[Constraint], box: Designs, free: list[str]
) -> Examined:
    """What the limits say of boxes, each at the cam angles where they are worst for one design of the box.

    The side to cut is the one across which the excess over the worst limit changes the most; the longest, where no
    assembled design of the box is at hand.
    """
    empty = question.subject.mechanism.impossible(box, programme)
    inside, exists = _representatives(question, programme, box, free, ~empty)
    intervals: dict[str, Any] = box.sizes
    low, high = (np.array([getattr(intervals[n], end) for n in free]) for end in ("low", "high"))
    side, index, level = np.argmax(high - low, axis=0), np.flatnonzero(exists), exists.copy()
    present = [each for each in constraints if np.any(programme.table.kind & each.kinds)]
    if index.size and present:
        point = np.array([inside.sizes[n][index] for n in free])
        span = Interval(low[:, index] - point, high[:, index] - point)
        with np.errstate(all="ignore"):
            claims = _claims(question, programme, present, box.take(index), inside.take(index), free)
            empty[index] |= np.any(claims.least > MARGIN, axis=0)
            level[index] = np.all(claims.most <= MARGIN, axis=0)
            side[index] = widest(claims, span)
            left = cut_off(claims, span)
        rounding = ROUNDING * (np.abs(point) + span.largest_magnitude)
        low[:, index] = np.maximum(low[:, index], point + left.low - rounding)
        high[:, index] = np.minimum(high[:, index], point + left.high + rounding)
    empty |= np.any(low > high, axis=0)
    ends = (dict(zip(free, end, strict=True)) for end in (low, high))
    return Examined(empty, level, inside, side, *ends)


def _claims(
    question: Question,
    programme: Programme,
    constraints: list[Constraint],
    box: Designs,
    inside: Designs,
    free: list[str],
) -> Claims:
    """The limits on both sides of the cam angles where one design of each box exceeds them the most."""
    case, count, found = Case(question.subject, programme, inside), len(inside), []
    for constraint in constraints:
        ways = WAYS[constraint.goal]
        goals = [(constraint.kinds, LARGEST if way > 0.0 else LEAST) for way in ways]
        angles = programme.beside(case.extremes(constraint.curve, goals).where, constraint.kinds).ravel()
        rows = angles.size // count
        designs, like = _sloped(box, inside, free, rows)
        value, _ = curve(constraint.curve(designs, programme), ..., *programme.state(angles))
        excess = as_sloped(constraint.excess(np.tile(np.repeat(ways, count), 2), as_quotient(value), designs), like)
        found.append(Claims.of(excess, rows))
    return chained_claims(found)


def chained_claims(parts: list[Claims]) -> Claims:
    """Claims on the same boxes, one after the other."""
    least, most, at = (np.concatenate([claim[k] for claim in parts]) for k in range(3))
    slopes = Interval(*(np.concatenate([getattr(c.slopes, end) for c in parts], axis=1) for end in ("low", "high")))
    return Claims(least, most, at, slopes)


def _sloped(box: Designs, inside: Designs, free: list[str], rows: int) -> tuple[Designs, Sloped]:
    """Boxes as designs of Sloped sizes, so many times one after the other; and one of these."""
    intervals: dict[str, Any] = box.sizes
    ends = [Interval(*(np.tile(getattr(intervals[n], end), rows) for end in ("low", "high"))) for n in free]
    sizes = dict(zip(free, variables(ends, [np.tile(inside.sizes[n], rows) for n in free]), strict=True))
    fixed = {n: np.tile(v, rows) for n, v in inside.sizes.items() if n not in free}
    return Designs(**{**fixed, **sizes}, sense=box.sense), sizes[free[0]]  # type: ignore[arg-type]


def widest(claims: Claims, span: Interval) -> Any:
    """The side across which the excess over the worst limit changes the most."""
    worst = np.argmax(np.nan_to_num(claims.at, nan=-np.inf), axis=0)
    steepest = np.take_along_axis(claims.slopes.largest_magnitude, worst[None, None, :], axis=1)[:, 0]
    width = span.high - span.low
    return np.argmax(np.where(np.isfinite(steepest), steepest, LARGE) * width, axis=0)


def cut_off(claims: Claims, span: Interval) -> Interval:
    """The parts (d, n) of each side, seen from the point, in which every limit may be held.

    With e the excess at the point less what other sizes can take off it, G·t ≤ −e has to hold at the distance t.
    """
    moved = claims.slopes * Interval(span.low[:, None], span.high[:, None])
    slack = MARGIN * (1.0 + np.abs(claims.at) + moved.largest_magnitude.sum(axis=0))
    low, high = span.low.copy(), span.high.copy()
    for k in range(len(low)):
        others = np.delete(moved.low, k, axis=0).sum(axis=0)
        rest = claims.at + others - slack
        asked = rest > 0.0
        below, above = -rest / claims.slopes.high[k], -rest / claims.slopes.low[k]
        smaller = ~asked | ((claims.slopes.high[k] > 0.0) & (below >= span.low[k]))
        larger = ~asked | ((claims.slopes.low[k] < 0.0) & (above <= span.high[k]))
        most = np.where(larger, span.high[k], np.where(smaller, below, -np.inf))
        least = np.where(smaller, span.low[k], np.where(larger, above, np.inf))
        low[k], high[k] = least.max(axis=0), most.min(axis=0)
    return Interval(low, high)


def _representatives(
    question: Question, programme: Programme, box: Designs, free: list[str], wanted: Any
) -> tuple[Designs, Any]:
    """A design of each wanted box that can be assembled, and whether one is found.

    Tried in turn: the middle; the largest size with the offset nearest to zero; the least size; every corner.
    """
    intervals: dict[str, Any] = box.sizes
    low = {name: interval.low for name, interval in intervals.items()}
    high = {name: interval.high for name, interval in intervals.items()}
    chosen = points_of(question, low, high, 0.5)
    nearest = np.minimum(np.maximum(low["offset"], 0.0), high["offset"])
    largest = replace(points_of(question, low, high, 1.0), offset=nearest)
    exists = wanted & question.subject.mechanism.exists(chosen, programme)
    ends = product(*((low[name], high[name]) for name in free))
    corners = (replace(chosen, **dict(zip(free, corner, strict=True))) for corner in ends)
    for other in (largest, points_of(question, low, high, 0.0), *corners):
        better = wanted & ~exists & question.subject.mechanism.exists(other, programme)
        sizes = {name: np.where(better, other.sizes[name], a) for name, a in chosen.sizes.items()}
        chosen, exists = Designs(**sizes, sense=chosen.sense), exists | better
    return chosen, exists
