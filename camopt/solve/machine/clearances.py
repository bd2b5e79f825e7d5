"""Clearances of a machine: the least over their angles, enclosed, and the slack of each phase, proved.

Both are branch and bound over boxes: ranges of the shaft's angle and of the shift of a phase, and for outlines a
pair of chords. A clearance gives its values, and bounds over boxes; the searches know no more of it.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import degrees, inf, pi, radians
from typing import NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import UNIT_ROUNDOFF, FloatArray, IndexArray, IntArray
from camopt.core.numerics.budget import Budget
from camopt.core.numerics.turn_curve import TURN, TurnCurve, sum_curves
from camopt.scene.machine import Clearance, Machine
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
LEAST_GAP = 0.9e-9  # mm and relative: gap at which the least clearance is enclosed closely enough
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

    @property
    def is_any_phase(self) -> bool:
        """Whether the clearance is held at any phase of the station."""
        return min(self.earlier[0], self.later[0]) >= 180.0


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


class LiftsOverBoxes(NamedTuple):
    """Lifts of the parts of a clearance over boxes, a row for each part (parts, N)."""

    middle: FloatArray
    """Lift in the middle of the box."""
    reach: FloatArray
    """Largest difference from it in the box."""
    slope: FloatArray
    """Middle of the range of the slope by the angle [1/rad]."""
    slope_reach: FloatArray
    """Half the width of that range."""


class ValuesOverBoxes(NamedTuple):
    """Clearances over boxes (N,)."""

    lower: FloatArray
    """A bound that no clearance in the box is below."""
    upper: FloatArray
    """A bound that the clearance in the middle of the box is not above."""
    rooms: FloatArray
    """How much the angle, the shift, and the chords of both outlines add to the room below the value (4, N)."""


class LeastValue(NamedTuple):
    """The least value of a clearance, enclosed, and the angle [rad] of the upper bound."""

    lower: float
    upper: float
    angle: float


class Boxes(NamedTuple):
    """Boxes of a search (N)."""

    task: IntArray
    """The question that the box belongs to: which phase is shifted, and which way."""
    chords: IndexArray
    """A chord of each outline (2, N)."""
    low: FloatArray
    """Least angle, and least magnitude of the shift [rad] (2, N)."""
    high: FloatArray

    def select(self, mask: FloatArray) -> "Boxes":
        """Some of the boxes."""
        return Boxes(*(each[..., mask] for each in self))

    @property
    def middle(self) -> FloatArray:
        """Middles of angle and shift (2, N)."""
        return np.asarray(0.5 * (self.low + self.high))


@dataclass(frozen=True, eq=False)
class ClearanceForm(ABC):
    """A clearance as a function of the shaft's angle and of shifts of phases.

    Angles and shifts are in rad. Shifts have a row for each part of the clearance, a station or a fixed body. A
    shift adds to the phase of its station.
    """

    curves: tuple[TurnCurve, ...]
    """Lift of each part over the angle; 0 for a fixed body."""
    weights: FloatArray
    """Largest change of the clearance for a lift of one unit, of each part."""
    size: float
    """Largest magnitude of a term of the clearance [mm]."""

    def values(self, angles: FloatArray, shifts: FloatArray) -> FloatArray:
        """Clearances at angles (N,) with shifts (parts, N)."""
        return self.values_at_lifts(
            np.array([f.value(angles - s) for f, s in zip(self.curves, shifts, strict=True)])
        )

    def highest(self, angles: FloatArray, shift_low: FloatArray, shift_high: FloatArray) -> FloatArray:
        """Upper bounds of the clearance at angles (N,) over ranges of the shifts (parts, N)."""
        lifts = self.lifts_over(angles, angles, shift_low, shift_high)
        return self.values_at_lifts(lifts.middle) + self.weights @ lifts.reach + self.rounding

    @abstractmethod
    def least(self, start: float, width: float, budget: Budget) -> LeastValue:
        """The least clearance over a range of angles from ``start`` [rad], without shifts."""

    @abstractmethod
    def values_at_lifts(self, lifts: FloatArray) -> FloatArray:
        """Clearances at lifts (parts, N)."""

    @abstractmethod
    def enclose(
        self, chords: IndexArray, angles: tuple[FloatArray, FloatArray], shifts: tuple[FloatArray, FloatArray]
    ) -> ValuesOverBoxes:
        """Bounds over boxes from the least to the largest angles (N,) and shifts (parts, N)."""

    def halves_of_chords(self, side: int, chords: IndexArray) -> IndexArray:
        """The halves of chords of an outline (chords, 2)."""
        return np.stack([chords, chords], axis=1)

    @cached_property
    def rounding(self) -> float:
        """A bound of the rounding of values, and of what the lifts' jumps between panels add to their slopes."""
        rooms = []
        for curve in self.curves:
            first, last = (polynomial.polyval(end, curve.series) for end in (-1.0, 1.0))
            steepest = (np.abs(polynomial.polyder(curve.series)).sum(axis=0) / curve.half_width).max()
            jumps = np.abs(last - np.roll(first, -1)).sum()
            rooms.append(curve.error + jumps + 16.0 * UNIT_ROUNDOFF * TURN * steepest)
        return float(self.weights @ rooms + 64.0 * UNIT_ROUNDOFF * self.size)

    def lifts_over(
        self, angle_low: FloatArray, angle_high: FloatArray, shift_low: FloatArray, shift_high: FloatArray
    ) -> LiftsOverBoxes:
        """The lifts of all parts over boxes."""
        rows = []
        for curve, low, high in zip(self.curves, angle_low - shift_high, angle_high - shift_low, strict=True):
            middle, lifts = curve.value(0.5 * (low + high)), curve.range_over(low, high)
            slopes = curve.derivative.range_over(low, high)
            rows.append(
                (
                    middle,
                    np.maximum(lifts.high - middle, middle - lifts.low),
                    0.5 * (slopes.low + slopes.high),
                    0.5 * (slopes.high - slopes.low),
                )
            )
        return LiftsOverBoxes(*np.array(rows).transpose(1, 0, 2))


@dataclass(frozen=True, eq=False)
class LinearForm(ClearanceForm):
    """The sum of coefficients times lifts."""

    coefficients: FloatArray = field(default_factory=lambda: np.zeros(0))

    def values_at_lifts(self, lifts: FloatArray) -> FloatArray:
        return np.asarray(self.coefficients @ lifts)

    def least(self, start: float, width: float, budget: Budget) -> LeastValue:
        """The least clearance, exact from the sum of the curves."""
        curves = [curve * weight for curve, weight in zip(self.curves, self.coefficients.tolist(), strict=True)]
        found = sum_curves(curves).least(start, width)
        return LeastValue(found.value - found.room, found.value + found.room, found.angle)

    def enclose(
        self, chords: IndexArray, angles: tuple[FloatArray, FloatArray], shifts: tuple[FloatArray, FloatArray]
    ) -> ValuesOverBoxes:
        lifts = self.lifts_over(*angles, *shifts)
        value = self.values_at_lifts(lifts.middle)
        half_angle, half_shift = (0.5 * (high - low) for low, high in (angles, shifts))
        by_angle = half_angle * (np.abs(self.coefficients @ lifts.slope) + self.weights @ lifts.slope_reach)
        by_shift = self.weights @ (half_shift * (np.abs(lifts.slope) + lifts.slope_reach))
        room = np.minimum(by_angle + by_shift, self.weights @ lifts.reach)
        none = np.zeros_like(value)
        rooms = np.array([by_angle, by_shift, none, none])
        return ValuesOverBoxes(value - room - self.rounding, value + self.rounding, rooms)


@dataclass(frozen=True, eq=False)
class OutlineGap(ClearanceForm):
    """The distance of two outlines.

    Bounds over boxes are those of a pair of chords, which must not be one inside of the other.
    """

    outlines: tuple[MovingOutline, ...] = ()

    def values_at_lifts(self, lifts: FloatArray) -> FloatArray:
        return outline_distances(*self.outlines, *lifts)

    def least(self, start: float, width: float, budget: Budget) -> LeastValue:
        """The least distance, by branch and bound.

        Outlines that are apart at the start and never touch stay outside of each other.
        """
        ends = np.array([start, start + width])
        at_ends = self.values(ends, np.zeros((2, 2)))
        best, angle = min(zip(at_ends.tolist(), ends.tolist(), strict=True))
        boxes, floor, below = first_boxes(1, start, width, 0.0), best, 0.0
        while boxes.task.size and best > 0.0 and not budget.is_spent:
            budget.spend(BOX_WORK * boxes.task.size)
            found = enclose_boxes(self, np.zeros((1, 2)), boxes)
            nearest = int(np.argmin(found.upper))
            if found.upper[nearest] < best:
                best, angle = float(found.upper[nearest]), float(boxes.middle[0, nearest])
            is_open = found.lower < best - LEAST_GAP * max(best, 1.0)
            floor = min(floor, found.lower[~is_open].min(initial=inf))
            below = found.lower[is_open].min(initial=inf)
            boxes = halve_boxes(self, boxes.select(is_open), found.rooms[:, is_open])
        return LeastValue(float(min(floor, below, best)), best, angle)

    def halves_of_chords(self, side: int, chords: IndexArray) -> IndexArray:
        return self.outlines[side].tree.children[chords]

    def enclose(
        self, chords: IndexArray, angles: tuple[FloatArray, FloatArray], shifts: tuple[FloatArray, FloatArray]
    ) -> ValuesOverBoxes:
        lifts = self.lifts_over(*angles, *shifts)
        half_angle, half_shift = (0.5 * (high - low) for low, high in (angles, shifts))
        trees = [outline.tree for outline in self.outlines]
        covers, speeds = (
            np.array([getattr(tree, name)[chord] for tree, chord in zip(trees, chords, strict=True)])
            for name in ("cover", "speed")
        )
        ends = [
            outline.moved_points(points[chord], lift)
            for outline, tree, chord, lift in zip(self.outlines, trees, chords, lifts.middle, strict=True)
            for points in (tree.start, tree.end)
        ]
        offset = offsets_between_segments(*ends)
        distance = np.abs(offset)
        normal = (offset / np.maximum(distance, TINY)).conj()
        # places of the four ends along the normal, and the ranges of their slopes by the angle
        places = [(normal * point).real for point in ends]
        slopes, reaches = [], []
        for number, point in enumerate(ends):
            side = number // 2
            velocity = (normal * self.outlines[side].velocities(point)).real
            slope, slope_reach = lifts.slope[side], lifts.slope_reach[side]
            turned = abs(self.outlines[side].turn) * speeds[side] * lifts.reach[side]
            slopes.append(velocity * slope)
            reaches.append(np.abs(velocity) * slope_reach + turned * (np.abs(slope) + slope_reach))
        separation, by_angle, by_shift = (
            np.full_like(distance, inf),
            np.zeros_like(distance),
            np.zeros_like(distance),
        )
        for one in (0, 1):
            for two in (2, 3):
                angle_room = half_angle * (np.abs(slopes[one] - slopes[two]) + reaches[one] + reaches[two])
                shift_room = half_shift[0] * (np.abs(slopes[one]) + reaches[one])
                shift_room += half_shift[1] * (np.abs(slopes[two]) + reaches[two])
                separation = np.minimum(separation, places[one] - places[two] - angle_room - shift_room)
                by_angle, by_shift = np.maximum(by_angle, angle_room), np.maximum(by_shift, shift_room)
        way = (speeds * lifts.reach).sum(axis=0)
        steepest = speeds * (np.abs(lifts.slope) + lifts.slope_reach)
        is_close = separation > distance - way
        rooms = np.array(
            [
                np.where(is_close, by_angle, half_angle * steepest.sum(axis=0)),
                np.where(is_close, by_shift, (half_shift * steepest).sum(axis=0)),
                *covers,
            ]
        )
        constant = sum(outline.radius for outline in self.outlines)
        lower = np.maximum(separation, distance - way) - covers.sum(axis=0) - constant - self.rounding
        upper = distance + covers.sum(axis=0) - constant + self.rounding
        return ValuesOverBoxes(np.maximum(lower, 0.0), np.maximum(upper, 0.0), rooms)


def first_boxes(tasks: int, start: float, width: float, largest_shift: float) -> Boxes:
    """The boxes with which a search begins: parts of both ranges for each task."""
    counts = (tasks, FIRST_ANGLES, FIRST_SHIFTS if largest_shift else 1)
    task, *parts = np.indices(counts).reshape(3, -1)
    scale = np.array([[width / counts[1]], [largest_shift / counts[2]]])
    origin = np.array([[start], [0.0]])
    low, high = (np.array(parts) * scale, (np.array(parts) + 1) * scale)
    return Boxes(task, np.zeros((2, task.size), dtype=np.intp), low + origin, high + origin)


def enclose_boxes(form: ClearanceForm, directions: FloatArray, boxes: Boxes) -> ValuesOverBoxes:
    """Bounds over boxes, whose tasks shift the parts in some directions (tasks, parts)."""
    low, high = (directions[boxes.task].T * each[1] for each in (boxes.low, boxes.high))
    shifts = np.minimum(low, high), np.maximum(low, high)
    return form.enclose(boxes.chords, (boxes.low[0], boxes.high[0]), shifts)


def halve_boxes(form: ClearanceForm, boxes: Boxes, rooms: FloatArray) -> Boxes:
    """Boxes cut in two along what adds most to the room below their values."""
    rooms[1] = np.where(boxes.high[1] > boxes.low[1], np.maximum(rooms[1], form.rounding), 0.0)
    widest, middle = np.argmax(rooms, axis=0), boxes.middle
    halves = [tuple(each.copy() for each in boxes) for _ in range(2)]
    for row in (0, 1):
        here = widest == row
        halves[0][3][row, here] = halves[1][2][row, here] = middle[row, here]
        here = widest == 2 + row
        children = form.halves_of_chords(row, boxes.chords[row, here])
        for half in (0, 1):
            halves[half][1][row, here] = children[:, half]
    return Boxes(*(np.concatenate(pair, axis=-1) for pair in zip(*halves, strict=True)))


def first_violations(
    form: ClearanceForm, required: float, start: float, width: float, directions: FloatArray, budget: Budget
) -> FloatArray:
    """The shifts up to which a clearance is held, and at which it is broken, for each direction (tasks, 2) [rad].

    The search ends at half a turn. The second shift is infinite if none is known.
    """
    tasks = len(directions)
    proved, broken = np.full(tasks, pi), np.full(tasks, inf)
    boxes, is_done = first_boxes(tasks, start, width, pi), np.zeros(tasks, dtype=bool)
    while boxes.task.size and not budget.is_spent:
        budget.spend(BOX_WORK * boxes.task.size)
        found = enclose_boxes(form, directions, boxes)
        violates = found.upper < required
        np.minimum.at(broken, boxes.task[violates], boxes.middle[1, violates])
        is_open = (found.lower < required) & (boxes.low[1] < broken[boxes.task])
        front = np.minimum(broken, pi)
        np.minimum.at(front, boxes.task[is_open], boxes.low[1, is_open])
        proved = np.where(is_done, proved, front)
        is_done |= (1.0 - SLACK_GAP) * broken <= proved
        is_open &= ~is_done[boxes.task]
        boxes = halve_boxes(form, boxes.select(is_open), found.rooms[:, is_open])
    return np.array([proved, broken]).T


def clearance_form(machine: Machine, stations: Sequence[ResolvedStation], clearance: Clearance) -> ClearanceForm:
    """A clearance of a machine as a function of the angle and of the shifts of phases."""
    curves = {station.name: station.lift for station in stations}
    parts = tuple(curves.get(name, TurnCurve.constant(0.0)) for name in clearance.between)
    strokes = np.array([float(np.abs(curve.series).sum(axis=0).max()) for curve in parts])
    if clearance.along is not None:
        weights = np.abs(clearance.along)
        return LinearForm(parts, weights, float(weights @ strokes), np.array(clearance.along))
    tables = {each.name: each for each in (*machine.station, *machine.body)}
    outlines = tuple(MovingOutline.from_table(tables[name]) for name in clearance.between)
    weights = np.array([outline.tree.speed[0] for outline in outlines])
    size = sum(np.abs(each.points).max() + abs(each.pivot) + each.radius for each in outlines) + weights @ strokes
    return OutlineGap(parts, weights, float(size), outlines)


def required_clearance(clearance: Clearance) -> float:
    """What a clearance must be at least: outlines must not touch."""
    return clearance.at_least if clearance.along is not None else max(clearance.at_least, TOUCHING)


def clearances_of_machine(machine: Machine, stations: Sequence[ResolvedStation]) -> tuple[ClearanceResult, ...]:
    """The least of each clearance of a machine, and the slacks of its phases."""
    return tuple(_clearance_result(machine, stations, clearance) for clearance in machine.clear)


def _clearance_result(
    machine: Machine, stations: Sequence[ResolvedStation], clearance: Clearance
) -> ClearanceResult:
    form, required = clearance_form(machine, stations, clearance), required_clearance(clearance)
    start, width = radians(clearance.angles[0]), radians(clearance.angles[1] - clearance.angles[0])
    least = form.least(start, width, Budget(LEAST_WORK))
    verdict = HELD if least.lower >= required else BROKEN if least.upper < required else UNDECIDED
    moving = {each.name for each in machine.station}
    rows = [row for row, name in enumerate(clearance.between) if name in moving]
    if verdict == HELD:
        directions = np.array([sign * (np.arange(len(form.curves)) == row) for row in rows for sign in (-1.0, 1.0)])
        ends = np.degrees(first_violations(form, required, start, width, directions, Budget(SLACK_WORK)))
    else:
        ends = np.tile([0.0, 0.0 if verdict == BROKEN else inf], (2 * len(rows), 1))
    pairs = [(float(proved), float(broken)) for proved, broken in ends]
    slacks = tuple(PhaseSlack(clearance.between[row], pairs[2 * k], pairs[2 * k + 1]) for k, row in enumerate(rows))
    return ClearanceResult(
        title=clearance.title,
        between=clearance.between,
        at_least=clearance.at_least,
        lower=least.lower,
        upper=least.upper,
        angle=degrees(least.angle) % 360.0,
        verdict=verdict,
        slacks=slacks,
    )
