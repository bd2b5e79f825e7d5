"""The least feasible size over a box of designs, by bisection of boxes; all boxes of a level at once."""

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np

from camopt.effects import Case
from camopt.judging import excesses, judged, least_excess, run_effects
from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray
from camopt.numerics.interval import Interval
from camopt.question import Question
from camopt.search.answer import Bounds, Smallest, feasible, gap_of
from camopt.search.closed_form import NUDGES, negligible
from camopt.search.enclosure import constraints_of, examined, points_of
from camopt.search.zoom import nearest_miss

LARGEST_SIZE = 1e9  # mm
FIRST_BOXES = 32
VALUES, FEW_VALUES = 9, 4  # of a free size in the coarse grid; few where there is no feasible design to find
BLOCK = 512  # designs of the coarse grid
MOST_BOXES = 1_000_000
NARROW = 1e-3  # of a negligible size: a box this narrow that is not excluded stays undecided


def branch_and_bound(question: Question, programme: Programme, bounds: Bounds, floor: float = 0.0) -> Smallest:
    """Least feasible size over a box of designs, by bisection of boxes, all boxes of a level at once.

    ``floor`` is a size that no feasible design is known to undercut; infinite if there is none.
    """
    values = VALUES if floor < inf else FEW_VALUES
    incumbent, obstacle, nearest = first_feasible(question, programme, bounds, values)
    least, most = max(bounds["size"][0], floor), size_of(incumbent, _largest_size(question, bounds))
    hopeless = incumbent is None and _stopped_at_any_size(question, programme, obstacle, nearest)
    if hopeless or most <= least or most >= LARGEST_SIZE:  # nothing to search, or no size at all is feasible
        return Smallest(incumbent, size_of(incumbent, inf), obstacle, nearest)
    if incumbent is None:
        most = _last_assembled(question, programme, bounds, most)
        if most <= least:
            return Smallest(None, inf, obstacle, nearest)
    constraints = constraints_of(question)
    ends = {**bounds, "size": (least, most)}
    free = [name for name, (low, high) in ends.items() if high > low]
    cuts = np.linspace(least, most, FIRST_BOXES + 1)
    low = {n: np.full(FIRST_BOXES, a) for n, (a, _) in ends.items()} | {"size": cuts[:-1]}
    high = {n: np.full(FIRST_BOXES, b) for n, (_, b) in ends.items()} | {"size": cuts[1:]}
    boxes, undercut, narrowest = 0, inf, NARROW * negligible(question, programme, bounds)
    while low["size"].size and boxes < MOST_BOXES:
        boxes += low["size"].size
        incumbent = _better(question, programme, incumbent, low, high)
        narrow = np.all([high[n] - low[n] < narrowest for n in free], axis=0)
        excluded = low["size"] >= (inf if incumbent is None else size_of(incumbent, inf) - gap_of(incumbent))
        undercut = min(undercut, np.min(low["size"][excluded], initial=inf))
        high["size"] = np.minimum(high["size"], size_of(incumbent, inf))
        index = np.flatnonzero(~excluded)
        box = Designs(
            **{n: Interval(low[n][index], high[n][index]) for n in low},  # type: ignore[arg-type]
            sense=question.design.sense,
        )
        longest = np.zeros(low["size"].size, dtype=int)
        seen = examined(question, programme, constraints, box, free)
        excluded[index], longest[index] = seen.empty, seen.side
        for name in free:
            low[name][index], high[name][index] = seen.low[name], seen.high[name]
        undercut = min(undercut, np.min(low["size"][narrow & ~excluded], initial=inf))
        keep = ~(excluded | narrow)
        low, high, longest = _halved(low, high, free, longest, keep)
        while 0 < low["size"].size < FIRST_BOXES:  # a level of many boxes takes no longer than one of few
            low, high, longest = _halved(low, high, free, longest, np.ones(longest.size, dtype=bool))
    undercut = min(undercut, np.min(low["size"], initial=inf))
    return Smallest(incumbent, float(undercut), obstacle, nearest)


def _stopped_at_any_size(question: Question, programme: Programme, obstacle: str, nearest: Designs | None) -> bool:
    """Whether one of the limits that stop every design looked at does so whatever the size.

    It depends on the motion alone, or a corner of the motion makes it infinite.
    """
    if nearest is None:
        return False
    columns = run_effects(Case(question.subject, programme, nearest), question.needed).columns
    for limit in question.limits:
        if limit.name in obstacle.split(", ") and limit.needs:
            infinite = programme.corners and np.isinf(limit.excess(columns, nearest)[0])
            if limit.of_motion or infinite:
                return True
    return False


def size_of(design: Designs | None, otherwise: float) -> float:
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
    grid = _coarse_grid(question, programme, bounds, VALUES)
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
    """The least feasible of the incumbent and of the middles of boxes, also at their least and largest size."""
    for share in (0.0, 0.5, 1.0):
        points = points_of(question, low, high, share)
        if share == 0.0:  # where the curvature of the base circle decides, but for rounding
            points = replace(points, size=np.minimum(points.size + NUDGES[-1] * points.prime_radius, high["size"]))
        points = points.take(points.size < size_of(incumbent, inf))
        points = points.take(feasible(question, programme, points))
        if len(points):
            incumbent = points.take(np.argmin(points.size, keepdims=True))
    return incumbent


def first_feasible(
    question: Question, programme: Programme, bounds: Bounds, values: int = VALUES
) -> tuple[Designs | None, str, Designs | None]:
    """The smallest feasible design of a coarse grid, with so many values of each free size but the cam's.

    Without one: the limits that stop all designs, or else the nearest one; and the nearest one.
    """
    points = _coarse_grid(question, programme, bounds, values)
    points = points.take(np.argsort(points.size, kind="stable"))
    for first in range(0, len(points), BLOCK):
        block = points.take(slice(first, first + BLOCK))
        held = np.flatnonzero(feasible(question, programme, block))
        if held.size:
            return block.take(held[:1]), "", None
    points = points.take(question.subject.mechanism.exists(points, programme))
    if not len(points):
        return None, "assembly", None
    excess = excesses(question.limits, judged(question, programme, points, frozenset()).columns, points)
    nearest = least_excess(excess)
    stopped = np.all(excess > 0.0, axis=1)
    if not stopped.any():
        stopped = excess[:, nearest] > 0.0
    names = [limit.name for limit, stops in zip(question.limits, stopped, strict=True) if stops]
    return None, ", ".join(names), nearest_miss(question, programme, bounds, points.take([nearest]))


def _coarse_grid(question: Question, programme: Programme, bounds: Bounds, values: int) -> Designs:
    """Sizes even near the least and geometric beyond, at a few values of each other free size."""
    low, high = bounds["size"][0], _largest_size(question, bounds)
    lengths = [*(b for n, (_, b) in bounds.items() if n != "size"), low]
    scale = max([abs(length) for length in lengths] + [programme.lift])
    near, far = np.linspace(low, min(high, low + 20 * scale), 400), np.geomspace(scale, max(high, scale), 400)
    sizes = np.unique(np.concatenate([near, far]))
    sizes = sizes[(sizes >= low) & (sizes <= high) & (sizes > 0.0)]
    others = {n: np.linspace(a, b, values if b > a else 1) for n, (a, b) in bounds.items() if n != "size"}
    mesh = np.meshgrid(*others.values(), sizes, indexing="ij")
    fields = dict(zip([*others, "size"], (m.ravel() for m in mesh), strict=True))
    return Designs(**fields, sense=question.design.sense)


def _halved(
    low: dict[str, FloatArray], high: dict[str, FloatArray], free: list[str], side: Any, keep: Any
) -> tuple[dict[str, FloatArray], dict[str, FloatArray], Any]:
    """The boxes to keep, each cut in two across the given side; and that side of each."""
    low, high, side = {n: v[keep] for n, v in low.items()}, {n: v[keep] for n, v in high.items()}, side[keep]
    below, above = dict(high), dict(low)
    for k, name in enumerate(free):
        middle = (low[name] + high[name]) / 2
        below[name] = np.where(side == k, middle, high[name])
        above[name] = np.where(side == k, middle, low[name])
    lows = {n: np.concatenate([low[n], above[n]]) for n in low}
    highs = {n: np.concatenate([below[n], high[n]]) for n in high}
    return lows, highs, np.concatenate([side, side])
