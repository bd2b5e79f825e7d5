"""Largest value of a quantity over all cams within tolerances: a proven bound, and a cam that nearly reaches it.

A quantity f(φ, x) is a formula of the cam angle φ and of all errors x, run on ranges with slopes. Over a part of
the turn, with the slopes g by the errors over their whole box, and any errors p,

    f(φ, x) ≤ f(φ, p) + max g·(x − p)

p is the corner to which the slopes point. There the second term nearly vanishes, and the first one is a curve over
the turn. So mostly the turn is divided, where the bound is highest. An error is divided only where the sign of its
slope is unknown, however small the part. f(φ, p) in the middle of a part is the value of a real cam: the largest
one is the witness.

Errors with a direction are vectors with two coordinates and a length up to ε. Their p is ε·n, along the middle n of
the slopes, and the second term is at most ε·(|g| − g·n).

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 6 and 11.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from itertools import product
from math import inf, pi
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import INPUT_ROUNDOFF, BoolArray, FloatArray, IntArray, Number
from camopt.core.numerics.budget import Budget
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.motion_ranges import slopes_of_function_of_angle
from camopt.core.numerics.sloped_interval import Quotient, SlopedInterval, as_sloped_interval, box_variables
from camopt.core.numerics.stretches import motion_ranges_over_parts
from camopt.model.motion.programme import Jump
from camopt.scene.problem.problem import Problem
from camopt.solve.tolerances.enclosures import LAST_DERIVATIVE, JumpRanges, PartMotion
from camopt.solve.tolerances.errors import direction_key, direction_keys, is_direction, polar_from_flat_errors
from camopt.solve.verdicts.constraint_boxes import (
    CONSTRAINT_PART_CUTS,
    LEAST_PART_SHARE,
    PART_WORK,
    ROUND_PARTS,
    BoxParts,
    NumberRanges,
)

PARTS_AT_ONCE, MOST_ROUNDS = 128, 400
"""Number of parts that are divided at once, the highest bounds first, and the largest number of rounds."""
NARROW_ANGLE = 0.5
"""Largest angle [rad] between the slopes and their middle with which a vector is taken along the slopes."""
LENGTH_ROUNDING = 1e-9
"""Relative allowance for rounding of the lengths of vectors."""
ErrorValues = dict[str, float]
BoundedQuantity = Callable[[Mapping[str, SlopedInterval], PartMotion], Number]
"""Computes a quantity over boxes, from flat errors and the motion over parts of the turn."""
JumpCase = tuple[bool | None, bool | None]
"""Whether a jump within reach of a place lies between it and its cam angle, and between it and the second contact's
place; None if both are possible."""


class ProvedBound(NamedTuple):
    """Upper bound of a quantity over all cams, with a witness."""

    high: float
    """Proven upper bound; infinite if none is known."""
    witness_value: float = -inf
    """Value that the best cam found reaches at least."""
    witness: ErrorValues | None = None
    """Errors of that cam in polar form, with the other variables of the quantity."""


def missing_bound_reason(upper_bound: float, budget: Budget) -> str:
    """Why a proof with a budget has no bound; "" if it has one."""
    return (
        ""
        if upper_bound < inf
        else "the proof takes too much work"
        if budget.is_spent
        else "the tolerances are too large for it"
    )


def coordinate_box(number_ranges: NumberRanges) -> dict[str, tuple[float, float]]:
    """Range of each coordinate of the errors; both coordinates of errors with a direction."""
    box = dict[str, tuple[float, float]]()
    for key, (low, high) in number_ranges.items():
        if not is_direction(key):
            box |= (
                dict.fromkeys((key, direction_key(key)), (-high, high))
                if direction_key(key) in number_ranges
                else {key: (low, high)}
            )
    return box


def whole_panel_parts(
    problem: Problem, box: NumberRanges, panels: IntArray | None = None, sides: Sequence[float] = (1.0, -1.0)
) -> BoxParts:
    """Parts that are whole panels (by default all) with the whole box, one for each side of a quantity."""
    numbers = np.arange(problem.programme.table.half_width.size) if panels is None else panels
    panel, side = (each.ravel() for each in np.meshgrid(numbers, np.array(sides), indexing="ij"))
    low, high = (np.repeat(each[:, None], panel.size, axis=1) for each in np.array([(-1.0, 1.0), *box.values()]).T)
    return BoxParts(panel, side, low, high, np.where(high > low, high - low, 1.0)[:, :1])


@dataclass(frozen=True)
class BoundSearch:
    """Search for the largest value of a quantity over all cams."""

    problem: Problem
    quantity: BoundedQuantity
    error_ranges: NumberRanges
    """Range of each error in polar form."""
    box: NumberRanges
    """Range of each coordinate of the errors (``coordinate_box``), and of the other variables of the quantity."""
    cut_variables: frozenset[str] = frozenset()
    """Variables that are no errors: they are divided as the turn is."""
    jumps: tuple[Jump, ...] = ()
    """Jumps of y'' and y'''."""
    reach: float = 0.0
    """Largest angle by which any cam is late or early [rad]."""
    jump_case: JumpCase = (None, None)

    def prove_upper_bound(
        self, parts: BoxParts, reached_value: float, gap: float, budget: Budget, sufficient_bound: float = inf
    ) -> ProvedBound:
        """Bound of the quantity over parts, where some cam reaches ``reached_value``.

        Ends at the relative gap, when the budget is spent, or when a cam exceeds ``sufficient_bound``.
        """
        if budget.is_spent:
            return ProvedBound(inf, reached_value)
        pool, settled, best = (
            self.bound_parts(parts, (parts.low + parts.high) / 2.0),
            -inf,
            ProvedBound(inf, reached_value),
        )
        enclosed = pool
        for _ in range(MOST_ROUNDS):
            budget.spend(PART_WORK * (ROUND_PARTS + enclosed.high.size))
            best = max(best, enclosed.best_witness, key=lambda each: each.witness_value)
            is_open = ~pool.is_thin & ~(
                pool.high <= max(best.witness_value + gap * abs(best.witness_value), settled)
            )
            settled = max(settled, pool.high[~is_open].max(initial=-inf))
            pool = pool.take_parts(np.flatnonzero(is_open))
            if not pool.high.size or budget.is_spent or best.witness_value > sufficient_bound:
                break
            order = np.argsort(-pool.high, kind="stable")
            first, rest = pool.take_parts(order[:PARTS_AT_ONCE]), pool.take_parts(order[PARTS_AT_ONCE:])
            enclosed = self.bound_parts(*first.divided_parts_and_corners)
            pool = rest.join_parts(enclosed)
        return best._replace(high=float(max(settled, pool.high.max(initial=-inf))))

    def bound_parts(self, parts: BoxParts, target_errors: FloatArray) -> "EnclosedParts":
        """Bounds of parts, from errors p near the given ones; errors with a known sign of slope keep one end."""
        rows, size = self._box_rows_of_angle_and_other_bisected_variables, parts.size
        at = self._nearest_errors(parts, target_errors)
        low, high = at.copy(), at.copy()
        low[rows], high[rows] = parts.low[rows], parts.high[rows]
        with np.errstate(all="ignore"):
            both = self.enclose_quantity_times_side(_join_parts(parts, replace(parts, low=low, high=high)))
            whole, at_errors = both[:size], both[size:]
            change = whole.slopes * whole.span
            middle = whole.at.high + self._largest_gain(parts, whole.slopes, (parts.low + parts.high) / 2.0)
            middle += change[rows].high.sum(axis=0) + INPUT_ROUNDOFF * change.largest_magnitude.sum(axis=0)
            gain = self._largest_gain(parts, whole.slopes, at)
            top = np.fmin(np.fmin(whole.value.high, middle), at_errors.value.high + gain * (1.0 + INPUT_ROUNDOFF))
            steep = whole.slopes.largest_magnitude
            for pair, _ in self._vector_rows_and_lengths:
                steep[pair] = whole.slopes[pair].high - whole.slopes[pair].low
            thin = ~_can_be_cut(parts, steep)
            parts = self._narrow_errors_by_slopes(parts, whole.slopes)
            corner = self._error_corners_along_slopes(parts, whole.slopes)
        top = np.where(gain > -inf, np.where(np.isnan(top), inf, top), -inf)
        lower = np.where(top > -inf, np.nan_to_num(at_errors.at.low, nan=-inf), -inf)
        at[rows] = (parts.low[rows] + parts.high[rows]) / 2.0
        most = int(lower.argmax()) if size else 0
        best = (
            ProvedBound(inf, float(lower[most]), self.polar_cam_errors(at[1:, most])) if size else ProvedBound(inf)
        )
        return EnclosedParts(parts, top, thin, corner, steep, best)

    def enclose_quantity_times_side(self, parts: BoxParts) -> SlopedInterval:
        """The quantity over parts, times their side."""
        middle, table = (parts.low + parts.high) / 2.0, self.problem.programme.table
        half = table.half_width[parts.panel]
        low, high, centre = (each * half for each in (parts.low[0], parts.high[0], middle[0]))
        sides = [Interval(low, high), *map(Interval, parts.low[1:], parts.high[1:])]
        angle, *numbers = box_variables(sides, [centre, *middle[1:]])
        ranges = motion_ranges_over_parts(table, parts.panel, middle[0], angle.span.high[0])
        values = zip(ranges.middle[: LAST_DERIVATIVE + 1], ranges.whole, ranges.whole[1:], strict=False)
        motion = [
            replace(angle, value=whole, at=at, slopes=slopes_of_function_of_angle(angle, slope))
            for at, whole, slope in values
        ]
        angles = table.centre[parts.panel] + centre
        jumps = (self._jump_ranges(parts.panel, angles, passed) for passed in self.jump_case)
        part_motion = PartMotion(motion, parts.panel, low, high, centre, *jumps)
        value = self.quantity(dict(zip(self.box, numbers, strict=True)), part_motion)
        value = value.divide() if isinstance(value, Quotient) else value
        return as_sloped_interval(value * parts.side, angle)

    def _narrow_errors_by_slopes(self, parts: BoxParts, slopes: Interval) -> BoxParts:
        """Parts with one end of each error in which the quantity is monotone; vectors near the worst direction."""
        low, high = slopes.low.copy(), slopes.high.copy()
        for both, _ in self._vector_rows_and_lengths:
            low[both], high[both] = -1.0, 1.0  # keeps both ends
        reduced = parts.reduce_monotone_variables_to_ends(Interval(low, high))
        low, high = reduced.low.copy(), reduced.high.copy()
        # the worst vector has the largest length, and points along its slopes
        for both, longest in self._vector_rows_and_lengths:
            (along, across), ahead = _slopes_along_direction(slopes, both)
            spread, way = np.arctan2(across.largest_magnitude, along.low), np.arctan2(*ahead[::-1])
            for row, turn in zip(both, (0.0, 0.5 * pi), strict=True):
                ends = np.cos(Interval(way - spread - turn, way + spread - turn))
                low[row] = np.where(
                    spread < NARROW_ANGLE, np.maximum(low[row], longest * (ends.low - LENGTH_ROUNDING)), low[row]
                )
                high[row] = np.where(
                    spread < NARROW_ANGLE,
                    np.minimum(high[row], longest * (ends.high + LENGTH_ROUNDING)),
                    high[row],
                )
            high[both] = np.maximum(low[both], high[both])  # an empty range becomes a single value
        return replace(reduced, low=low, high=high)

    @cached_property
    def _box_rows_of_angle_and_other_bisected_variables(self) -> list[int]:
        """Rows of the turn and of variables that are no errors."""
        return [0, *(1 + k for k, name in enumerate(self.box) if name in self.cut_variables)]

    def _nearest_errors(self, parts: BoxParts, target_errors: FloatArray) -> FloatArray:
        """Errors within parts that are nearest to the given ones."""
        errors = np.clip(target_errors, parts.low, parts.high)
        for both, longest in self._vector_rows_and_lengths:
            errors[both] = _furthest_vector(parts, both, target_errors[both] / longest, longest)
        return errors

    def _error_corners_along_slopes(self, parts: BoxParts, slopes: Interval) -> FloatArray:
        """Errors to which the slopes point."""
        corner = np.where(slopes.low + slopes.high > 0.0, parts.high, parts.low)
        for both, longest in self._vector_rows_and_lengths:
            _, way = _slopes_along_direction(slopes, both)
            corner[both] = _furthest_vector(parts, both, way, longest)
        return corner

    def _largest_gain(self, parts: BoxParts, slopes: Interval, point_errors: FloatArray) -> FloatArray:
        """Largest increase of the quantity from errors at a point to any errors of a part: max g·(x − p)."""
        gains = (slopes * Interval(parts.low - point_errors, parts.high - point_errors)).high
        gains[self._box_rows_of_angle_and_other_bisected_variables] = 0.0
        for both, longest in self._vector_rows_and_lengths:
            low, high, x, y = parts.low[both], parts.high[both], slopes[both[0]], slopes[both[1]]
            ends = [np.array(g) for g in product((x.low, x.high), (y.low, y.high))]
            anywhere = [
                longest * (1.0 + LENGTH_ROUNDING) * np.hypot(*g) - (g * point_errors[both]).sum(axis=0)
                for g in ends
            ]
            (along, across), way = _slopes_along_direction(slopes, both)
            change = Interval(low - point_errors[both], high - point_errors[both])
            x, y = (change[0] * way[0] + change[1] * way[1]), change[1] * way[0] - change[0] * way[1]
            margin = longest * (1.0 + LENGTH_ROUNDING) - (way * point_errors[both]).sum(axis=0)
            by_direction = along * Interval(x.low, np.clip(margin, x.low, x.high)) + across * y
            outside = np.hypot(*np.clip(0.0, low, high)) > longest * (1.0 + LENGTH_ROUNDING)
            most = reduce(np.fmin, [np.max(anywhere, axis=0), gains[both].sum(axis=0), by_direction.high])
            gains[both[0]] = np.where(outside, -inf, most)
            gains[both[1]] = 0.0
        return np.asarray(gains.sum(axis=0))

    @cached_property
    def _vector_rows_and_lengths(self) -> list[tuple[list[int], float]]:
        """Rows of both coordinates of each vector, and its largest length."""
        rows = {name: 1 + number for number, name in enumerate(self.box)}
        return [
            ([rows[key], rows[way]], self.error_ranges[key][1])
            for key, way in direction_keys(self.error_ranges).items()
        ]

    def polar_cam_errors(self, error_coordinates: FloatArray) -> ErrorValues:
        """Errors of a cam in polar form, from the coordinates of its errors."""
        flat = dict(zip(self.box, map(float, error_coordinates), strict=True))
        polar = {key: float(each) for key, each in polar_from_flat_errors(flat, self.error_ranges).items()}
        lengths = {
            key: min(polar[key] * (1.0 + 2.0 * LENGTH_ROUNDING), self.error_ranges[key][1])
            for key in direction_keys(self.error_ranges)
        }
        return flat | polar | lengths

    def _jump_ranges(self, panel: IntArray, angles: FloatArray, passed: bool | None) -> JumpRanges:
        """Ranges of the jumps of y'' and y''' that can be errors of a cam, for each part near a jump.

        A place at a jump is on the same side of it as its panel.
        """
        ranges, centre = np.zeros((2, 2, panel.size)), self.problem.programme.table.centre[panel]
        near = self._is_within_reach_by_jump_angle(angles)
        known = (sum(near.values(), np.zeros(panel.size)) == 1) & (passed is not None)
        for jump in self.jumps:
            size = np.where(near[jump.at], np.sign(self._angle_to_jump(jump.at, centre)) * jump.size, 0.0)
            hull = np.array([np.minimum(size, 0.0), np.maximum(size, 0.0)])
            ranges[jump.order - 2] += np.where(known, size * bool(passed), hull)
        return JumpRanges(*(Interval(*each) for each in ranges))

    def is_part_near_jump(self, parts: BoxParts) -> BoolArray:
        """Whether each part is within reach of a jump."""
        table, middle = self.problem.programme.table, 0.5 * (parts.low[0] + parts.high[0])
        angles = table.centre[parts.panel] + middle * table.half_width[parts.panel]
        near = self._is_within_reach_by_jump_angle(angles)
        return np.asarray(sum(near.values(), np.zeros(angles.size)) > 0.0)

    def _is_within_reach_by_jump_angle(self, angles: FloatArray) -> dict[float, BoolArray]:
        """Whether each jump is within reach of cam angles, by the angle of the jump."""
        reach = (1.0 + LENGTH_ROUNDING) * self.reach if self.reach else -1.0
        return {jump.at: np.abs(self._angle_to_jump(jump.at, angles)) <= reach for jump in self.jumps}

    def _angle_to_jump(self, jump_angle: float, angles: FloatArray) -> FloatArray:
        """Angle from cam angles to a jump, within half a turn [rad]."""
        turn = self.problem.programme.strokes[-1].end
        return np.asarray(np.mod(jump_angle - angles + 0.5 * turn, turn) - 0.5 * turn)

    def split_at_reach_of_jumps(self, parts: BoxParts) -> BoxParts:
        """Parts split so that each is either within reach of a jump or not."""
        table = self.problem.programme.table
        for jump in self.jumps:
            for side in (-1.0, 1.0):
                ahead = self._angle_to_jump(jump.at, table.centre[parts.panel])
                parts = parts.split_at_panel_place((ahead + side * self.reach) / table.half_width[parts.panel])
        return parts


def _slopes_along_direction(
    slopes: Interval, vector_rows: list[int]
) -> tuple[tuple[Interval, Interval], FloatArray]:
    """Slopes of a vector along and across their middle direction, and this direction."""
    x, y = slopes[vector_rows[0]], slopes[vector_rows[1]]
    angle = np.arctan2(y.low + y.high, x.low + x.high)
    way = np.array([np.cos(angle), np.sin(angle)])
    return (x * way[0] + y * way[1], y * way[0] - x * way[1]), way


def _furthest_vector(parts: BoxParts, rows: list[int], direction: FloatArray, longest: float) -> FloatArray:
    """The vector of two rows of parts, nearly up to ``longest``, that reaches nearly furthest in a direction."""
    low, high, largest_length = parts.low[rows], parts.high[rows], longest * (1.0 - LENGTH_ROUNDING)
    nearest, far = np.clip(0.0, low, high), np.clip(direction * largest_length, low, high)
    step = far - nearest
    a, b, c = (
        (step * step).sum(axis=0),
        (nearest * step).sum(axis=0),
        (nearest * nearest).sum(axis=0) - largest_length**2,
    )
    share = (np.sqrt(np.maximum(b * b - a * c, 0.0)) - b) / np.where(a > 0.0, a, 1.0)
    return np.asarray(nearest + np.clip(share, 0.0, 1.0) * step)


def _join_parts(a: BoxParts, b: BoxParts) -> BoxParts:
    panel, side = np.concatenate([a.panel, b.panel]), np.concatenate([a.side, b.side])
    return replace(a, panel=panel, side=side, low=np.hstack([a.low, b.low]), high=np.hstack([a.high, b.high]))


def _can_be_cut(parts: BoxParts, steepness: FloatArray) -> BoolArray:
    """Whether each part has a variable that can be divided."""
    width = parts.high - parts.low
    return np.asarray((~(steepness * width <= 0.0) & (width > LEAST_PART_SHARE * parts.whole)).any(axis=0))


class EnclosedParts(NamedTuple):
    """Parts with their bounds."""

    parts: BoxParts
    high: FloatArray
    is_thin: BoolArray
    """Whether each part had nothing left to divide."""
    corner: FloatArray
    """The errors to which the slopes point, in the rows after that of the place on the panel."""
    steepness: FloatArray
    """Change of the unknown part of the quantity with each variable."""
    best_witness: ProvedBound
    """The best cam of the parts."""

    @property
    def divided_parts_and_corners(self) -> tuple[BoxParts, FloatArray]:
        """The parts divided along their steepest variable, or whole if that is impossible; and their corners."""
        wide = _can_be_cut(self.parts, self.steepness)
        divisible, whole = self.take_parts(np.flatnonzero(wide)), self.take_parts(np.flatnonzero(~wide))
        parts = divisible.parts.cut_across_steepest_variable(divisible.steepness) if wide.any() else divisible.parts
        return _join_parts(parts, whole.parts), np.hstack(
            [np.tile(divisible.corner, CONSTRAINT_PART_CUTS), whole.corner]
        )

    def take_parts(self, index: IntArray) -> "EnclosedParts":
        return self._replace(
            parts=self.parts.take(index),
            high=self.high[index],
            is_thin=self.is_thin[index],
            corner=self.corner[:, index],
            steepness=self.steepness[:, index],
        )

    def join_parts(self, other: "EnclosedParts") -> "EnclosedParts":
        high, thin, corner, steepness = (
            np.concatenate(each, axis=-1) for each in zip(self[1:5], other[1:5], strict=True)
        )
        return EnclosedParts(
            _join_parts(self.parts, other.parts), high, thin, corner, steepness, other.best_witness
        )
