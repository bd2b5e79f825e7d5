"""The smallest cam: the least size that holds every limit, proved.

Closed forms first. For a follower with a trace point the limits on the pressure angle are lines in (e, s₀):

    e + T·s₀ ≥ max (y' − T·y),    −e + T·s₀ ≥ max (−y' − T·y)

so the smallest prime radius √(s₀² + e²) is the point of a convex polygon nearest to the origin; a flat face's
radius and a cylindrical cam's pressure angle are linear in the size. If that cam holds all other limits too, it
is the answer. Otherwise curvature decides, and feasibility need not be monotone in the size: a branch-and-bound
over boxes of designs discards a box when one of the limits is exceeded throughout it, at one cam angle, by the
limit's own formula in interval arithmetic. What is left when it ends is the least feasible size to within GAP.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations
from math import inf, radians, tan
from typing import Any

import numpy as np

from camopt.effects import Case
from camopt.evaluation import Question, excesses, judged
from camopt.mechanisms import Designs, translating, translating_flat
from camopt.motion.programme import Programme, span
from camopt.motion.table import DWELL, RETURN, RISE, TURN
from camopt.numerics import FloatArray
from camopt.numerics.curves import curve
from camopt.numerics.extremes import LARGEST, LARGEST_MAGNITUDE, LEAST
from camopt.numerics.interval import Interval

GAP = 1e-7  # mm: the size found exceeds the least feasible size by no more
MARGIN = 1e-11  # relative: far above the rounding of an interval, far below any tolerance
LARGEST_SIZE = 1e9  # mm
FIRST_BOXES = 32
MOST_BOXES = 1_000_000
NARROW = 1e-3 * GAP  # a box this narrow that is not excluded stays undecided

Bounds = dict[str, tuple[float, float]]
"""Closed intervals of the sizes of a design, by field of Designs; equal ends where a size is fixed."""


@dataclass(frozen=True)
class Smallest:
    """The answer for one programme: the design, or why there is none."""

    design: Designs | None
    proved: bool
    """Whether no feasible design of these bounds is smaller by more than GAP."""
    obstacle: str = ""
    """Without a design: the limits that stop it."""
    nearest: Designs | None = None
    """Without a design: the one of a coarse grid that exceeds its limits the least."""


@dataclass(frozen=True)
class Constraint:
    """A limit as a curve over the turn, with a lower bound of its relative excess over a box of designs."""

    curve: Callable[[Designs, Programme], Any]
    kinds: int
    goal: int
    floor: Callable[[Interval, Designs], FloatArray]


def constraints_of(question: Question) -> list[Constraint]:
    """The limits that depend on the size of the cam."""
    mechanism = question.subject.mechanism
    found = []
    for limit in question.limits:
        if limit.name in ("pressure_angle", "pressure_angle_return"):
            kinds = RETURN if limit.name.endswith("return") else RISE | DWELL
            bound = tan(radians(limit.bound))
            found.append(Constraint(mechanism.pressure, kinds, LARGEST_MAGNITUDE, _magnitude(bound)))
        elif limit.name == "face_reach" and mechanism.reach:
            found.append(Constraint(mechanism.reach, TURN, LARGEST_MAGNITUDE, _magnitude(limit.bound)))
        elif limit.name in ("curvature_radius", "undercut"):
            if mechanism.profile_radius:
                found.append(Constraint(mechanism.profile_radius, TURN, LEAST, _radius(limit.bound)))
            elif mechanism.curvature:
                goal = LARGEST_MAGNITUDE if mechanism.grooved else LARGEST
                found.append(Constraint(mechanism.curvature, TURN, goal, _curvature(limit.bound, goal)))
    return found


def _magnitude(bound: float) -> Callable[[Interval, Designs], FloatArray]:
    return lambda value, designs: value.least_magnitude / bound - 1.0


def _radius(bound: float) -> Callable[[Interval, Designs], FloatArray]:
    return lambda value, designs: (bound - value.high) / np.maximum(np.abs(value.high), 1.0)


def _curvature(bound: float, goal: int) -> Callable[[Interval, Designs], FloatArray]:
    def floor(value: Interval, designs: Designs) -> FloatArray:
        least = value.least_magnitude if goal == LARGEST_MAGNITUDE else value.low
        return least * (designs.roller_radius.low + bound) - 1.0  # type: ignore[attr-defined, no-any-return]

    return floor


def smallest(question: Question, programme: Programme, bounds: Bounds) -> Smallest:
    """The design of least size within bounds that holds every limit of the question."""
    bounds = {**bounds, "size": (_least_size(question, programme, bounds), bounds["size"][1])}
    start = _closed_form(question, programme, bounds)
    if start is not None:
        start = _nudged(question, programme, start, bounds["size"][1])
        if start is not None:
            return Smallest(start, proved=True)
    return _branch_and_bound(question, programme, bounds)


def _least_size(question: Question, programme: Programme, bounds: Bounds) -> float:
    """A lower bound of the size that needs no search: the given one, the shaft's radius, and the base circle.

    A disc cam that dwells at its lowest is an arc of the base circle there, which has to hold the curvature.
    """
    least = max(bounds["size"][0], question.subject.shaft_radius or 0.0, GAP)
    rests = any(stroke.kind == DWELL and stroke.low == 0.0 for stroke in programme.strokes)
    if rests and not question.subject.mechanism.grooved:
        least = max([least, *(lim.bound for lim in question.limits if lim.name == "curvature_radius")])
    return least


def feasible(question: Question, programme: Programme, designs: Designs) -> Any:
    """Which designs can be assembled and hold every limit."""
    held = question.subject.mechanism.exists(designs, programme) & (designs.size > 0.0)
    held[held] = judged(question, programme, designs.take(held), frozenset()).column("feasible")
    return held


def _nudged(question: Question, programme: Programme, design: Designs, most: float) -> Designs | None:
    """The design made larger by a few units in the last place, until rounding leaves it feasible."""
    for step in (0.0, 1e-15, 4e-15, 1.6e-14, 6.4e-14, 2.6e-13, 1e-12, 4e-12):
        larger = replace(design, size=design.size + step * design.prime_radius)
        if larger.size[0] <= most and feasible(question, programme, larger)[0]:
            return larger
    return None


def _closed_form(question: Question, programme: Programme, bounds: Bounds) -> Designs | None:
    """A design that no feasible one undercuts in size, from the linear limits; None if there is no such form."""
    mechanism, limits = question.subject.mechanism, {lim.name: lim.bound for lim in question.limits}
    slopes = [
        (tan(radians(limits[name])), kinds)
        for name, kinds in (("pressure_angle", RISE | DWELL), ("pressure_angle_return", RETURN))
        if name in limits and any(s.kind & kinds for s in programme.strokes)
    ]
    low, high = bounds["size"]
    middle = {name: a for name, (a, b) in bounds.items() if a == b}
    if mechanism is translating.MECHANISM:
        roller = bounds["roller_radius"][1]
        lead, prime = _nearest_in_polygon(question, programme, bounds["offset"], slopes, low + roller)
        size = max(prime - roller, low)
        middle |= {"offset": lead * question.design.sense, "roller_radius": roller}
    elif mechanism is translating_flat.MECHANISM:
        radius = max(limits.get("curvature_radius", 0.0), limits.get("undercut", 0.0))
        size = max(low, radius - span(programme, (1, 0, 1), TURN)[0])
        middle.setdefault("offset", question.design.offset[0])
    elif mechanism.grooved and not question.subject.angular and slopes:
        steepest = [max(map(abs, span(programme, (0, 1), kinds))) / tangent for tangent, kinds in slopes]
        size = max(low, *steepest)
        middle.setdefault("roller_radius", bounds["roller_radius"][1])
    else:
        return None
    if not 0.0 < size <= high:
        return None
    fields = {name: np.array([middle.get(name, bounds[name][0])]) for name in bounds}
    return Designs(**{**fields, "size": np.array([size])}, sense=question.design.sense)


def _nearest_in_polygon(
    question: Question,
    programme: Programme,
    offset: tuple[float, float],
    slopes: list[tuple[float, int]],
    least: float,
) -> tuple[float, float]:
    """The lead e and prime radius of the smallest cam that holds the pressure angle, within the offsets.

    s₀(e) is the largest of a few lines, so R_p² = e² + s₀² is convex in e: its least value lies at e = 0, at the
    projection of the origin on a line, where two lines cross, or at an end of the interval.
    """
    ends = sorted(question.design.sense * e for e in offset)
    lines = []  # s₀ ≥ a + b·e
    for tangent, kinds in slopes:
        lines.append((span(programme, (-tangent, 1), kinds)[1] / tangent, -1 / tangent))
        lines.append((-span(programme, (tangent, 1), kinds)[0] / tangent, 1 / tangent))
    candidates = [0.0, *(-a * b / (1 + b * b) for a, b in lines)]
    candidates += [(a2 - a1) / (b1 - b2) for (a1, b1), (a2, b2) in combinations(lines, 2) if b1 != b2]
    leads = np.clip(np.array([*ends, *candidates]), ends[0], ends[1])
    heights = np.max([np.zeros_like(leads), *(a + b * leads for a, b in lines)], axis=0)
    primes = np.maximum(np.hypot(leads, heights), least)
    best = np.lexsort((np.abs(leads), primes))[0]
    return float(leads[best]), float(primes[best])


def _branch_and_bound(question: Question, programme: Programme, bounds: Bounds) -> Smallest:
    """Least feasible size over a box of designs, by bisection of boxes, all boxes of a level at once."""
    incumbent, obstacle, nearest = _first_feasible(question, programme, bounds)
    least, most = bounds["size"][0], _size_of(incumbent, _largest_size(question, bounds))
    if most <= least or most >= LARGEST_SIZE:  # nothing left to search, or no size at all is feasible
        return Smallest(incumbent, True, obstacle, nearest)
    if incumbent is None:
        most = _last_assembled(question, programme, bounds, most)
    constraints = constraints_of(question)
    ends = {**bounds, "size": (least, most)}
    free = [name for name, (low, high) in ends.items() if high > low]
    cuts = np.linspace(least, most, FIRST_BOXES + 1)
    low = {n: np.full(FIRST_BOXES, a) for n, (a, _) in ends.items()} | {"size": cuts[:-1]}
    high = {n: np.full(FIRST_BOXES, b) for n, (_, b) in ends.items()} | {"size": cuts[1:]}
    boxes, proved = 0, True
    while low["size"].size and boxes < MOST_BOXES:
        boxes += low["size"].size
        incumbent = _better(question, programme, incumbent, low, high)
        narrow = np.all([high[n] - low[n] < NARROW for n in free], axis=0)
        excluded = low["size"] >= _size_of(incumbent, inf) - GAP
        index = np.flatnonzero(~excluded)
        box = Designs(
            **{n: Interval(low[n][index], high[n][index]) for n in low},  # type: ignore[arg-type]
            sense=question.design.sense,
        )
        longest = np.zeros(low["size"].size, dtype=int)
        excluded[index], longest[index] = _examined(question, programme, constraints, box, free)
        proved &= not np.any(narrow & ~excluded)
        keep = ~(excluded | narrow)
        low, high = _halved(low, high, free, longest, keep)
    return Smallest(incumbent, proved and boxes < MOST_BOXES, obstacle, nearest)


def _size_of(design: Designs | None, otherwise: float) -> float:
    return otherwise if design is None else float(design.size[0])


def _largest_size(question: Question, bounds: Bounds) -> float:
    """The largest size worth a look: the given one, or what the triangle of an oscillating follower allows."""
    reach = bounds["centre_distance"][1] + bounds["arm_length"][1] + max(bounds["face_offset"][1], 0.0)
    triangle = question.subject.angular and not question.subject.mechanism.grooved
    return min(bounds["size"][1], reach if triangle else inf, LARGEST_SIZE)


def _last_assembled(question: Question, programme: Programme, bounds: Bounds, most: float) -> float:
    """The largest size, to 1e-12, at which some design of a coarse grid of the other sizes can be assembled.

    A box across that border would hold a dead position, where tan β takes every value.
    """
    grid = _coarse_grid(question, programme, bounds)
    grid = grid.take(question.subject.mechanism.exists(grid, programme))
    if not len(grid):
        return most
    design = grid.take(np.argmax(grid.size, keepdims=True))
    low, high = float(design.size[0]), most
    while high - low > 1e-13 * high:
        middle = (low + high) / 2
        held = question.subject.mechanism.exists(replace(design, size=np.array([middle])), programme)[0]
        low, high = (middle, high) if held else (low, middle)
    return low * (1.0 - 1e-12)


def _better(
    question: Question,
    programme: Programme,
    incumbent: Designs | None,
    low: dict[str, FloatArray],
    high: dict[str, FloatArray],
) -> Designs | None:
    """The least feasible of the incumbent, the middles of boxes, and their middles at the largest size."""
    for share in (0.5, 1.0):
        points = _points(question, low, high, share)
        points = points.take(points.size < _size_of(incumbent, inf))
        points = points.take(feasible(question, programme, points))
        if len(points):
            incumbent = points.take(np.argmin(points.size, keepdims=True))
    return incumbent


def _points(question: Question, low: dict[str, FloatArray], high: dict[str, FloatArray], share: float) -> Designs:
    """One design of each box: its middle, but at a given share of the way from least to largest size."""
    middle = {name: (low[name] + high[name]) / 2 for name in low}
    size = low["size"] + share * (high["size"] - low["size"])
    return Designs(**{**middle, "size": size}, sense=question.design.sense)


def _first_feasible(
    question: Question, programme: Programme, bounds: Bounds
) -> tuple[Designs | None, str, Designs | None]:
    """The smallest feasible design of a coarse grid.

    Without one: the limits that stop all designs, or else the nearest one; and the nearest one.
    """
    points = _coarse_grid(question, programme, bounds)
    found = points.take(feasible(question, programme, points))
    if len(found):
        return found.take(np.argmin(found.size, keepdims=True)), "", None
    points = points.take(question.subject.mechanism.exists(points, programme))
    if not len(points):
        return None, "assembly", None
    excess = excesses(question.limits, judged(question, programme, points, frozenset()).columns, points)
    nearest = np.argmin(excess.max(axis=0), keepdims=True)
    stopped = np.all(excess > 0.0, axis=1)
    if not stopped.any():
        stopped = excess[:, nearest[0]] > 0.0
    names = [limit.name for limit, stops in zip(question.limits, stopped, strict=True) if stops]
    return None, ", ".join(names), points.take(nearest)


def _coarse_grid(question: Question, programme: Programme, bounds: Bounds) -> Designs:
    """Sizes even near the least and geometric beyond, at a few values of each other free size."""
    low, high = bounds["size"][0], _largest_size(question, bounds)
    lengths = [*(b for n, (_, b) in bounds.items() if n != "size"), low]
    scale = max([abs(length) for length in lengths] + [programme.lift])
    near, far = np.linspace(low, min(high, low + 20 * scale), 400), np.geomspace(scale, max(high, scale), 400)
    sizes = np.unique(np.concatenate([near, far]))
    sizes = sizes[(sizes >= low) & (sizes <= high) & (sizes > 0.0)]
    others = {n: np.linspace(a, b, 9 if b > a else 1) for n, (a, b) in bounds.items() if n != "size"}
    mesh = np.meshgrid(*others.values(), sizes, indexing="ij")
    fields = dict(zip([*others, "size"], (m.ravel() for m in mesh), strict=True))
    return Designs(**fields, sense=question.design.sense)


def _examined(
    question: Question, programme: Programme, constraints: list[Constraint], box: Designs, free: list[str]
) -> tuple[Any, Any]:
    """Which boxes hold no feasible design, and the side of each that is best cut.

    A box is excluded if some limit is exceeded throughout it at one cam angle: where the limit is worst for one
    design of the box. The side to cut is the one whose length loosens the bound of the worst limit the most.
    """
    inside, exists = _representatives(question, programme, box)
    excluded, side = ~exists, np.zeros(exists.shape, dtype=int)
    index = np.flatnonzero(exists)
    inside, box = inside.take(index), box.take(index)
    case = Case(question.subject, programme, inside)
    points: dict[str, Any] = {n: Interval(v, v) for n, v in inside.sizes.items()}
    worst = np.full(index.size, -np.inf)
    for constraint in constraints:
        _, where = case.extremes(constraint.curve, [(constraint.kinds, constraint.goal)])
        for offset in (-1e-9, 1e-9):  # both one-sided values where the worst angle is a jump
            motion = programme.at(np.mod(where[0] + offset, 2 * np.pi))

            def floor(designs: Designs, constraint: Constraint = constraint, motion: FloatArray = motion) -> Any:
                value, _ = curve(constraint.curve(designs, programme), ..., *motion)
                return constraint.floor(value, designs)

            excluded[index] |= floor(box) > MARGIN
            alone = [replace(box, **{**points, n: getattr(box, n)}) for n in free]
            here = floor(replace(box, **points))
            loosest = np.argmin([floor(designs) for designs in alone], axis=0)
            side[index] = np.where(here > worst, loosest, side[index])
            worst = np.maximum(worst, here)
    return excluded, side


def _representatives(question: Question, programme: Programme, box: Designs) -> tuple[Designs, Any]:
    """A design of each box that can be assembled, and whether there is one.

    Tried in turn: the middle; the largest size with the offset nearest to zero; the least size.
    """
    intervals: dict[str, Any] = box.sizes
    low = {name: interval.low for name, interval in intervals.items()}
    high = {name: interval.high for name, interval in intervals.items()}
    chosen = _points(question, low, high, 0.5)
    nearest = np.minimum(np.maximum(low["offset"], 0.0), high["offset"])
    largest = replace(_points(question, low, high, 1.0), offset=nearest)
    exists = question.subject.mechanism.exists(chosen, programme)
    for other in (largest, _points(question, low, high, 0.0)):
        better = ~exists & question.subject.mechanism.exists(other, programme)
        sizes = {name: np.where(better, other.sizes[name], a) for name, a in chosen.sizes.items()}
        chosen, exists = Designs(**sizes, sense=chosen.sense), exists | better
    return chosen, exists


def _halved(
    low: dict[str, FloatArray], high: dict[str, FloatArray], free: list[str], side: Any, keep: Any
) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
    """The boxes to keep, each cut in two across the given side."""
    low, high, side = {n: v[keep] for n, v in low.items()}, {n: v[keep] for n, v in high.items()}, side[keep]
    below, above = dict(high), dict(low)
    for k, name in enumerate(free):
        middle = (low[name] + high[name]) / 2
        below[name] = np.where(side == k, middle, high[name])
        above[name] = np.where(side == k, middle, low[name])
    lows = {n: np.concatenate([low[n], above[n]]) for n in low}
    highs = {n: np.concatenate([below[n], high[n]]) for n in high}
    return lows, highs
