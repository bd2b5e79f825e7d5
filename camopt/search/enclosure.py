"""Boxes of designs, and the proof that one holds no feasible design.

A limit is exceeded throughout a box if it is at one cam angle, by the limit's own formula in interval arithmetic.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product
from math import radians, tan
from typing import Any

import numpy as np

from camopt.effects import Case
from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.motion.table import DWELL, RETURN, RISE, TURN
from camopt.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, FloatArray
from camopt.numerics.curves import curve
from camopt.numerics.interval import Interval, chained
from camopt.question import Question

MARGIN = 1e-11  # relative: far above the rounding of an interval, far below any tolerance


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
        for top in () if limit.of_motion else limit.ceilings:
            found.append(Constraint(top.curve, top.kinds, top.goal, _ceiling(top.bound, top.goal)))
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


def _ceiling(bound: float, goal: int) -> Callable[[Interval, Designs], FloatArray]:
    def floor(value: Interval, designs: Designs) -> FloatArray:
        least = value.least_magnitude if goal == LARGEST_MAGNITUDE else value.low
        return (least - bound) / (bound or 1.0)

    return floor


def _radius(bound: float) -> Callable[[Interval, Designs], FloatArray]:
    return lambda value, designs: (bound - value.high) / np.maximum(np.abs(value.high), 1.0)


def _curvature(bound: float, goal: int) -> Callable[[Interval, Designs], FloatArray]:
    def floor(value: Interval, designs: Designs) -> FloatArray:
        least = value.least_magnitude if goal == LARGEST_MAGNITUDE else value.low
        return least * (designs.roller_radius.low + bound) - 1.0  # type: ignore[attr-defined, no-any-return]

    return floor


def points_of(question: Question, low: dict[str, FloatArray], high: dict[str, FloatArray], share: float) -> Designs:
    """One design of each box: its middle, but at a given share of the way from least to largest size."""
    middle = {name: (low[name] + high[name]) / 2 for name in low}
    size = low["size"] + share * (high["size"] - low["size"])
    return Designs(**{**middle, "size": size}, sense=question.design.sense)


def examined(
    question: Question, programme: Programme, constraints: list[Constraint], box: Designs, free: list[str]
) -> tuple[Any, Any]:
    """Which boxes hold no feasible design, and the side of each that is best cut.

    A box is excluded if none of its designs can be assembled, or if some limit is exceeded throughout it at one cam
    angle: where the limit is worst for one design of the box. The side to cut is the one whose length loosens the
    bound of the worst limit the most; the longest, where no assembled design of the box is at hand.
    """
    excluded = question.subject.mechanism.impossible(box, programme)
    inside, exists = _representatives(question, programme, box, free, ~excluded)
    intervals: dict[str, Any] = box.sizes
    side = np.argmax([intervals[n].high - intervals[n].low for n in free], axis=0)
    index = np.flatnonzero(exists)
    inside, box = inside.take(index), box.take(index)
    if not index.size:
        return excluded, side
    case, boxes = Case(question.subject, programme, inside), _variants(box, inside, free)
    worst = np.full(index.size, -np.inf)
    for constraint in constraints:
        where = case.extremes(constraint.curve, [(constraint.kinds, constraint.goal)]).where[0]
        both = programme.beside(where, constraint.kinds).ravel()
        if not both.size:  # no such stroke
            continue
        motion = programme.state(np.tile(both, len(boxes) // both.size))
        value, _ = curve(constraint.curve(boxes, programme), ..., *motion)
        floors = constraint.floor(value, boxes).reshape(-1, 2, index.size)
        whole, here, *alone = floors
        excluded[index] |= np.any(whole > MARGIN, axis=0)
        for way in (0, 1) if alone else ():
            loosest = np.argmin([each[way] for each in alone], axis=0)
            side[index] = np.where(here[way] > worst, loosest, side[index])
            worst = np.maximum(worst, here[way])
    return excluded, side


def _variants(box: Designs, inside: Designs, free: list[str]) -> Designs:
    """Boxes, a design inside each, and that design with each free side of its box, if there are several.

    Each comes twice, for the two sides of a cam angle. One array of all: formulas in intervals cost by the call.
    """
    boxes: dict[str, Any] = box.sizes
    points: dict[str, Any] = {n: Interval(v, v) for n, v in inside.sizes.items()}
    sides = [{**points, n: boxes[n]} for n in free] if len(free) > 1 else []
    each = [sizes for sizes in (boxes, points, *sides) for _ in range(2)]
    sizes: dict[str, Any] = {n: chained([part[n] for part in each]) for n in boxes}
    return Designs(**sizes, sense=box.sense)


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
