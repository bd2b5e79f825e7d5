"""Clearances of a machine: the least over their angles, enclosed, and the slack of each phase, proved.

Both are branch and bound over boxes: ranges of the shaft's angle and of the shift of a phase, and for outlines a
pair of chords. A clearance gives its values, and bounds over boxes; the searches know no more of it.
"""

from abc import ABC, abstractmethod
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import degrees, inf, pi, radians
from typing import NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import UNIT_ROUNDOFF, BoolArray, FloatArray, IndexArray, IntArray
from camopt.core.numerics.budget import Budget
from camopt.core.numerics.turn_curve import TURN, TurnCurve, sum_curves
from camopt.scene.machine import Body, Clearance, Machine, Station
from camopt.solve.machine.outlines import (
    TINY,
    MovingOutline,
    offsets_between_segments,
    outline_distances,
)
from camopt.solve.machine.stations import ResolvedStation
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED

TOUCHING = 1e-9
"""Outlines that are this near touch [mm]; they break every clearance."""
CLEARANCE_GAP = 0.9e-9  # mm and relative: gap at which the least clearance is enclosed closely enough
SLACK_GAP = 1e-9  # relative gap at which a slack is enclosed closely enough
BOX_WORK = 4  # work of the bounds over a box
LEAST_WORK, SLACK_WORK = 1_000_000, 2_000_000  # of a least clearance, and of all slacks of a clearance
FIRST_ANGLES, FIRST_SHIFTS = 16, 8  # parts of the ranges with which a search begins


class PhaseSlack(NamedTuple):
    """By how much the phase of a station may move while the others stay and a clearance is held [deg].

    The clearance is held at every phase up to the first number of a pair, and broken at the second. The second is
    infinite if no such phase is known. A first number of 180 both earlier and later means any phase.
    """

    station: str
    earlier: tuple[float, float]
    later: tuple[float, float]


@dataclass(frozen=True)
class ClearanceResult:
    """The least clearance over its range of angles."""

    title: str
    between: tuple[str, ...]
    at_least: float
    """What is required [mm]; for a linear form, of its own unit."""
    lower: float
    """A proved lower bound of the least clearance [mm]."""
    upper: float
    """The clearance at ``angle``, to rounding, so an upper bound of the least one [mm]."""
    angle: float
    """Angle of the shaft at which the least clearance was found, from 0 to 360 [deg]."""
    verdict: str
    """held, broken or undecided."""
    slacks: tuple[PhaseSlack, ...]
    """The slack of each station of the clearance."""

    @property
    def displayed_upper_bound(self) -> float:
        """The least clearance for readers: 0 if it differs from 0 only by rounding."""
        return 0.0 if abs(self.upper) < TOUCHING else self.upper

    @property
    def displayed_lower_bound(self) -> float:
        """Its proved bound for readers: 0 if it differs from 0 only by rounding."""
        return 0.0 if abs(self.lower) < TOUCHING else self.lower


class LiftsOverBoxes(NamedTuple):
    """Lifts of the parts of a clearance over boxes, a row for each part (parts, N)."""

    middle: FloatArray  # lift in the middle of the box
    reach: FloatArray  # largest difference from it in the box
    slope: FloatArray  # middle of the range of the slope by the angle [1/rad]
    slope_reach: FloatArray  # half the width of that range


class ValuesOverBoxes(NamedTuple):
    """Clearances over boxes."""

    lower: FloatArray  # what no clearance in the box is below (N,)
    upper: FloatArray  # what the clearance in the middle of the box is not above (N,)
    rooms: FloatArray  # what the angle, the shift and the chords of both outlines add to the room between (4, N)


class LeastValue(NamedTuple):
    """The least value of a clearance, enclosed, and the angle of the upper bound."""

    lower: float
    upper: float
    angle: float  # [rad]


class Boxes(NamedTuple):
    """Boxes of a search."""

    task: IntArray  # the question that the box belongs to: which phase is shifted, and which way (N,)
    chords: IndexArray  # a chord of each outline (2, N)
    low: FloatArray  # least angle, and least magnitude of the shift [rad] (2, N)
    high: FloatArray  # largest ones


@dataclass(frozen=True, eq=False)
class ClearanceForm(ABC):
    """A clearance as a function of the shaft's angle and of shifts of phases.

    Angles and shifts are in rad. Shifts have a row for each part of the clearance, a station or a fixed body. A
    shift adds to the phase of its station.
    """

    required: float  # what the clearance must be at least
    start: float  # start of its range of angles [rad]
    width: float  # width of that range [rad]
    curves: tuple[TurnCurve, ...]  # lift of each part over the angle; 0 for a fixed body
    weights: FloatArray  # largest change of the clearance for a lift of one unit, of each part
    size: float  # largest magnitude of a term of the clearance [mm]
    children: tuple[IndexArray, IndexArray]  # the halves of each chord, of both outlines

    @abstractmethod
    def values_at_lifts(self, lifts: FloatArray) -> FloatArray:
        """Clearances at lifts (parts, N)."""

    @abstractmethod
    def enclose_least_clearance(self, budget: Budget, threshold: float | None = None) -> LeastValue:
        """The least clearance over the range of angles, without shifts.

        With a ``threshold`` its bounds need only say whether it is below the level.
        """

    @abstractmethod
    def enclose_clearances_over_boxes(
        self, chords: IndexArray, angles: tuple[FloatArray, FloatArray], shifts: tuple[FloatArray, FloatArray]
    ) -> ValuesOverBoxes:
        """Bounds over boxes from the least to the largest angles (N,) and shifts (parts, N)."""

    def clearance_bounds_over_shifts(
        self, angles: FloatArray, shift_low: FloatArray, shift_high: FloatArray
    ) -> FloatArray:
        """Upper bounds of the clearance at angles (N,) over ranges of the shifts (parts, N)."""
        lifts = self.enclose_lifts_over_boxes((angles, angles), (shift_low, shift_high))
        return np.asarray(self.values_at_lifts(lifts.middle) + self.weights @ lifts.reach + self.rounding_bound)

    @cached_property
    def rounding_bound(self) -> float:
        """A bound of the rounding of values, and of what the lifts' jumps between panels add to their slopes."""
        rooms = []
        for curve in self.curves:
            steepest = (np.abs(polynomial.polyder(curve.series)).sum(axis=0) / curve.half_width).max()
            rooms.append(curve.error + jumps_at_panel_ends(curve).sum() + 16.0 * UNIT_ROUNDOFF * TURN * steepest)
        return float(self.weights @ rooms + 64.0 * UNIT_ROUNDOFF * self.size)

    def enclose_lifts_over_boxes(
        self, angles: tuple[FloatArray, FloatArray], shifts: tuple[FloatArray, FloatArray]
    ) -> LiftsOverBoxes:
        """The lifts of all parts over boxes."""
        rows = []
        for curve, low, high in zip(self.curves, angles[0] - shifts[1], angles[1] - shifts[0], strict=True):
            middle, lifts = curve.value(0.5 * (low + high)), curve.range_over(low, high)
            slopes = curve.derivative.range_over(low, high)
            reach = np.maximum(lifts.high - middle, middle - lifts.low)
            rows.append((middle, reach, 0.5 * (slopes.low + slopes.high), 0.5 * (slopes.high - slopes.low)))
        return LiftsOverBoxes(*np.array(rows).transpose(1, 0, 2))


@dataclass(frozen=True, eq=False)
class LinearClearance(ClearanceForm):
    """The sum of coefficients times lifts."""

    coefficients: FloatArray

    def values_at_lifts(self, lifts: FloatArray) -> FloatArray:
        return np.asarray(self.coefficients @ lifts)

    def enclose_least_clearance(self, budget: Budget, threshold: float | None = None) -> LeastValue:
        """The least clearance, exact from the sum of the curves."""
        curves = [curve * weight for curve, weight in zip(self.curves, self.coefficients.tolist(), strict=True)]
        found = sum_curves(curves).least(self.start, self.width)
        return LeastValue(found.value - found.room, found.value + found.room, found.angle)

    def enclose_clearances_over_boxes(
        self, chords: IndexArray, angles: tuple[FloatArray, FloatArray], shifts: tuple[FloatArray, FloatArray]
    ) -> ValuesOverBoxes:
        lifts = self.enclose_lifts_over_boxes(angles, shifts)
        value = self.values_at_lifts(lifts.middle)
        half_angle, half_shift = (0.5 * (high - low) for low, high in (angles, shifts))
        by_angle = half_angle * (np.abs(self.coefficients @ lifts.slope) + self.weights @ lifts.slope_reach)
        by_shift = self.weights @ (half_shift * (np.abs(lifts.slope) + lifts.slope_reach))
        room = np.minimum(by_angle + by_shift, self.weights @ lifts.reach) + self.rounding_bound
        rooms = np.array([by_angle, by_shift, 0.0 * value, 0.0 * value])
        return ValuesOverBoxes(value - room, value + self.rounding_bound, rooms)


@dataclass(frozen=True, eq=False)
class OutlineClearance(ClearanceForm):
    """The distance of two outlines.

    Bounds over boxes are those of a pair of chords, which must not be one inside of the other.
    """

    outlines: tuple[MovingOutline, MovingOutline]

    def values_at_lifts(self, lifts: FloatArray) -> FloatArray:
        return outline_distances(*self.outlines, lifts[0], lifts[1])

    def enclose_least_clearance(self, budget: Budget, threshold: float | None = None) -> LeastValue:
        """The least distance, by branch and bound.

        Outlines that are apart at the start and never touch stay outside of each other.
        """
        ends = np.array([self.start, self.start + self.width])
        values = self.values_at_lifts(np.array([curve.value(ends) for curve in self.curves]))
        best, angle = min(zip(values.tolist(), ends.tolist(), strict=True))
        boxes, floor, below = first_boxes(self, 1, 0.0), best, 0.0
        closest, enough = (0.0, inf) if threshold is None else (threshold, threshold)
        while boxes.task.size and best > closest and not budget.is_spent:
            budget.spend(BOX_WORK * boxes.task.size)
            found = enclose_boxes(self, np.zeros((1, 2)), boxes)
            nearest = int(np.argmin(found.upper))
            if found.upper[nearest] < best:
                best = float(found.upper[nearest])
                angle = 0.5 * float(boxes.low[0, nearest] + boxes.high[0, nearest])
            is_open = found.lower < min(best - CLEARANCE_GAP * max(best, 1.0), enough)
            floor = min(floor, found.lower[~is_open].min(initial=inf))
            below = found.lower[is_open].min(initial=inf)
            boxes = halve_boxes(self, boxes, found.rooms, is_open)
        return LeastValue(float(min(floor, below, best)), best, angle)

    def enclose_clearances_over_boxes(
        self, chords: IndexArray, angles: tuple[FloatArray, FloatArray], shifts: tuple[FloatArray, FloatArray]
    ) -> ValuesOverBoxes:
        """Bounds from the separation along the normal in the middle of a box, or else from the ways of both.

        Along a direction that stays, the separation of two chords is nowhere above their distance.
        """
        lifts = self.enclose_lifts_over_boxes(angles, shifts)
        half_angle, half_shift = (0.5 * (high - low) for low, high in (angles, shifts))
        pairs = [*zip(self.outlines, [outline.chord_tree for outline in self.outlines], chords, strict=True)]
        covers = [tree.cover[chord] for _, tree, chord in pairs]
        speeds = np.array([tree.speed[chord] for _, tree, chord in pairs])
        ends = [
            outline.moved_points(points[chord], lift)
            for (outline, tree, chord), lift in zip(pairs, lifts.middle, strict=True)
            for points in (tree.start, tree.end)
        ]
        offset = offsets_between_segments(*ends)
        distance = np.abs(offset)
        normal = (offset / np.maximum(distance, TINY)).conj()
        slopes, reaches = [], []  # ranges of the velocities of the four ends along the normal, by the angle
        for end, side in zip(ends, (0, 0, 1, 1), strict=True):
            velocity = (normal * self.outlines[side].velocities_by_lift(end)).real
            bend = abs(self.outlines[side].turn) * speeds[side] * lifts.reach[side]
            slopes.append(velocity * lifts.slope[side])
            steepest = np.abs(lifts.slope[side]) + lifts.slope_reach[side]
            reaches.append(np.abs(velocity) * lifts.slope_reach[side] + bend * steepest)
        rooms, separation = np.array([0.0 * distance, 0.0 * distance]), np.full_like(distance, inf)
        for one, two in product((0, 1), (2, 3)):
            by_angle = half_angle * (np.abs(slopes[one] - slopes[two]) + reaches[one] + reaches[two])
            by_shift = half_shift[0] * (np.abs(slopes[one]) + reaches[one])
            by_shift += half_shift[1] * (np.abs(slopes[two]) + reaches[two])
            separation = np.minimum(separation, (normal * (ends[one] - ends[two])).real - by_angle - by_shift)
            rooms = np.maximum(rooms, [by_angle, by_shift])
        nearest = distance - (speeds * lifts.reach).sum(axis=0)
        ways = speeds * (np.abs(lifts.slope) + lifts.slope_reach)
        by_ways = [half_angle * ways.sum(axis=0), (half_shift * ways).sum(axis=0)]
        rooms = np.where(separation > nearest, rooms, by_ways)
        constant = self.outlines[0].radius + self.outlines[1].radius
        lower = np.maximum(separation, nearest) - sum(covers) - constant - self.rounding_bound
        upper = distance + sum(covers) - constant + self.rounding_bound
        return ValuesOverBoxes(np.maximum(lower, 0.0), np.maximum(upper, 0.0), np.array([*rooms, *covers]))


def jumps_at_panel_ends(curve: TurnCurve) -> FloatArray:
    """The size of a curve's jump at the end of each panel."""
    first, last = (polynomial.polyval(end, curve.series) for end in (-1.0, 1.0))
    return np.asarray(np.abs(np.roll(first, -1) - last))


def first_boxes(form: ClearanceForm, task_count: int, largest_shift: float) -> Boxes:
    """The boxes with which a search begins: parts of the ranges of angle and shift for each task."""
    counts = (task_count, FIRST_ANGLES, FIRST_SHIFTS if largest_shift else 1)
    task, *parts = np.indices(counts).reshape(3, -1)
    scale = np.array([[form.width / counts[1]], [largest_shift / counts[2]]])
    low, high = (np.array(parts) * scale, (np.array(parts) + 1) * scale)
    origin = np.array([[form.start], [0.0]])
    return Boxes(task, np.zeros((2, task.size), dtype=np.intp), low + origin, high + origin)


def enclose_boxes(form: ClearanceForm, directions: FloatArray, boxes: Boxes) -> ValuesOverBoxes:
    """Bounds over boxes, whose tasks shift the parts in some directions (tasks, parts)."""
    low, high = (directions[boxes.task].T * each[1] for each in (boxes.low, boxes.high))
    shifts = np.minimum(low, high), np.maximum(low, high)
    return form.enclose_clearances_over_boxes(boxes.chords, (boxes.low[0], boxes.high[0]), shifts)


def halve_boxes(form: ClearanceForm, boxes: Boxes, gap_contributions: FloatArray, is_open: BoolArray) -> Boxes:
    """The open boxes, cut in two along what adds most to the room below their values."""
    gap_contributions[1] = np.where(
        boxes.high[1] > boxes.low[1], np.maximum(gap_contributions[1], form.rounding_bound), 0.0
    )
    widest, middle = np.argmax(gap_contributions, axis=0)[is_open], (0.5 * (boxes.low + boxes.high))[:, is_open]
    first, second = (Boxes._make(each[..., is_open] for each in boxes) for _ in range(2))
    for row in (0, 1):
        here = widest == row
        first.high[row, here] = second.low[row, here] = middle[row, here]
        here = widest == 2 + row
        first.chords[row, here], second.chords[row, here] = form.children[row][first.chords[row, here]].T
    return Boxes._make(np.concatenate(pair, axis=-1) for pair in zip(first, second, strict=True))


def held_and_violating_shifts(form: ClearanceForm, directions: FloatArray, budget: Budget) -> FloatArray:
    """The shifts up to which a clearance is held, and at which it is broken, for each direction (tasks, 2) [rad].

    The search ends at half a turn. The second shift is infinite if none is known.
    """
    tasks = len(directions)
    proved, broken, is_done = np.zeros(tasks), np.full(tasks, inf), np.zeros(tasks, dtype=bool)
    boxes = first_boxes(form, tasks, pi)
    while not is_done.all() and not budget.is_spent:
        budget.spend(BOX_WORK * boxes.task.size)
        found = enclose_boxes(form, directions, boxes)
        violates = found.upper < form.required
        np.minimum.at(broken, boxes.task[violates], 0.5 * (boxes.low + boxes.high)[1, violates])
        found.rooms[1, violates] = inf  # these are halved in the shift: at their middle no angle holds it
        is_open = (found.lower < form.required) & (boxes.low[1] < broken[boxes.task])
        front = np.minimum(broken, pi)
        np.minimum.at(front, boxes.task[is_open], boxes.low[1, is_open])
        proved = np.where(is_done, proved, front)
        is_done |= (1.0 - SLACK_GAP) * np.minimum(broken, pi) <= proved
        boxes = halve_boxes(form, boxes, found.rooms, is_open & ~is_done[boxes.task])
    return np.array([proved, broken]).T


def clearance_form(machine: Machine, stations: Sequence[ResolvedStation], clearance: Clearance) -> ClearanceForm:
    """A clearance of a machine as a function of the angle and of the shifts of phases."""
    start, width = radians(clearance.angles[0] % 360.0), radians(clearance.angles[1] - clearance.angles[0])
    lifts = {station.name: station.lift for station in stations}
    curves = tuple(lifts.get(name, TurnCurve.constant(0.0)) for name in clearance.between)
    strokes = np.array([float(np.abs(curve.series).sum(axis=0).max()) for curve in curves])
    common = (start, width, curves)
    if clearance.along is not None:
        weights, whole = np.abs(clearance.along), np.zeros((1, 2), dtype=np.intp)
        size, along = float(weights @ strokes), np.array(clearance.along)
        return LinearClearance(clearance.at_least, *common, weights, size, (whole, whole), along)
    tables: dict[str, Station | Body] = {each.name: each for each in machine.station}
    tables |= {each.name: each for each in machine.body}
    one, two = (MovingOutline.from_table(tables[name]) for name in clearance.between)
    weights = np.array([one.chord_tree.speed[0], two.chord_tree.speed[0]])
    sizes = (np.abs(each.points).max() + abs(each.pivot) + each.radius for each in (one, two))
    size = float(weights @ strokes + sum(sizes))
    children = one.chord_tree.children, two.chord_tree.children
    return OutlineClearance(max(clearance.at_least, TOUCHING), *common, weights, size, children, (one, two))


def clearances_of_machine(machine: Machine, stations: Sequence[ResolvedStation]) -> tuple[ClearanceResult, ...]:
    """The least of each clearance of a machine, and the slacks of its phases."""
    return tuple(
        _clearance_result(clearance, clearance_form(machine, stations, clearance), {each.name for each in stations})
        for clearance in machine.clear
    )


def _clearance_result(clearance: Clearance, form: ClearanceForm, station_names: Collection[str]) -> ClearanceResult:
    least = form.enclose_least_clearance(Budget(LEAST_WORK))
    verdict = HELD if least.lower >= form.required else BROKEN if least.upper < form.required else UNDECIDED
    rows = [row for row, name in enumerate(clearance.between) if name in station_names]
    ends = np.tile([0.0, 0.0 if verdict == BROKEN else inf], (2 * len(rows), 1))
    if verdict == HELD:
        directions = np.array([way * (np.arange(len(form.curves)) == row) for row in rows for way in (-1.0, 1.0)])
        ends = np.degrees(held_and_violating_shifts(form, directions, Budget(SLACK_WORK)))
    pairs: list[tuple[float, float]] = [(float(proved), float(broken)) for proved, broken in ends]
    return ClearanceResult(
        title=clearance.title,
        between=clearance.between,
        at_least=clearance.at_least,
        lower=least.lower,
        upper=least.upper,
        angle=degrees(least.angle) % 360.0,
        verdict=verdict,
        slacks=tuple(
            PhaseSlack(clearance.between[row], *both)
            for row, both in zip(rows, zip(pairs[::2], pairs[1::2], strict=True), strict=True)
        ),
    )
