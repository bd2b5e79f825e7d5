"""Enclosures for proofs of errors: motion, contacts and trains over boxes of errors.

**Motion.** A cam touches with the place φ + a instead of φ, with a as small as the errors. Then

    y⁽ᵏ⁾(φ + a) − y⁽ᵏ⁾(φ) ∈ a·y⁽ᵏ⁺¹⁾([φ, φ + a]),    ∂/∂a = y⁽ᵏ⁺¹⁾(φ + a),    ∂/∂φ = y⁽ᵏ⁺¹⁾(φ + a) − y⁽ᵏ⁺¹⁾(φ)

with ranges of the derivatives over stretches of the turn (``numerics.stretches``). Where y'' jumps between
both angles, the change of y'' excludes the jump, which ``JumpRanges`` has.

**Contacts.** A contact touches with the place φ at the cam angle θ = φ + τ(φ). At the cam angle φ + b it touches
with the place φ + a, where

    a = b − τ(φ + a)

If b − τ(φ + A) lies within a range A, such an a exists in it (Brouwer). Its slopes follow from the equation. b is 0
for a given cam angle φ. For a second contact, b is τ of the first contact at φ.

**Trains.** The nominal position of the follower is s(θ), the real one s + δ. The train with errors is f* instead of
f:

    ε = Δ₀,    ε' = Δ₁·(s' + δ') + f'·δ',    ε'' = Δ₂·(s' + δ')² + f''·(2s' + δ')·δ' + Δ₁·(s'' + δ'') + f'·δ''

Δ_k is the derivative of f* at s + δ less that of f at s, which is as small as the errors:

    Δ_k = f*⁽ᵏ⁾(s + δ) − f⁽ᵏ⁾(s) ∈ f*⁽ᵏ⁺¹⁾·δ + Σ ∂f*⁽ᵏ⁾/∂p·δp

Over ranges it is enclosed by the mean value theorem; at a point the difference is computed directly.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 8.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import factorial
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import INPUT_ROUNDOFF, FloatArray, IntArray, Number
from camopt.core.numerics.interval import Interval, as_interval
from camopt.core.numerics.sloped_interval import (
    LinkageInterval,
    SlopedInterval,
    apply_chain_rule,
    as_sloped_interval,
    range_of,
    value_at_box_point,
)
from camopt.core.numerics.stretches import StretchRanges, motion_ranges_over_stretches
from camopt.core.numerics.taylor import Taylor
from camopt.model.motion.programme import Programme, find_jumps
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.variables import is_train_key
from camopt.solve.tolerances.errors import BORE, BORE_DIRECTION, Errors
from camopt.solve.tolerances.real_cam import ContactShiftSeries, RealCam, follower_errors, follower_offset_in_train

CONTRACTIONS = 2
"""Number of iterations that narrow the range of a place."""
FIRST_RANGE_FACTOR = 2.0
"""Factor of the first range for a place to its estimated distance."""
LAST_DERIVATIVE = 3
"""Highest order of the derivatives of a motion at a place."""


class PartMotion(NamedTuple):
    """The motion of the follower over parts of panels."""

    motion: list[SlopedInterval]
    """y, y', y'', y'''."""
    panel: IntArray
    low: FloatArray
    """Start of each part, from the centre of its panel [rad]."""
    high: FloatArray
    """End of each part [rad]."""
    middle: FloatArray
    jumps_at_contact: "JumpRanges"
    """Jumps between the place and the cam angle at which it touches."""
    jumps_at_second_contact: "JumpRanges"
    """Jumps between the place and that of the second contact."""

    @property
    def y(self) -> SlopedInterval:
        return self.motion[0]


class JumpRanges(NamedTuple):
    """Ranges of the jumps of y'' and y''' between two neighbouring angles."""

    y2_jump: Interval
    y3_jump: Interval


@dataclass(frozen=True)
class MotionAhead:
    """The motion at an angle ahead of φ, which depends on the errors and on φ."""

    programme: Programme
    place: PartMotion
    angle_ahead: SlopedInterval
    jumps: JumpRanges
    _derivative_changes: dict[int, SlopedInterval] = field(default_factory=dict)

    def derivative_change_to_ahead(self, order: int) -> SlopedInterval:
        """Change of a derivative from φ to the angle ahead; of y'' without its jumps."""
        if order not in self._derivative_changes:
            self._derivative_changes[order] = self._enclose_derivative_change(order)
        return self._derivative_changes[order]

    def _enclose_derivative_change(self, order: int) -> SlopedInterval:
        a, at_p = self.angle_ahead, value_at_box_point(self.angle_ahead)
        ahead, on_way, ahead_of_middle, from_middle = self._motion_ranges_ahead_and_on_way
        value = range_of(a) * on_way.ranges[order + 1]
        point = ahead_of_middle.ranges[order] - value_at_box_point(self.place.motion[order])
        if order == 2:
            value = _widen_range(value, self.programme.acceleration_jump_rounding)
            cut = from_middle.pieces & bool(find_jumps(self.programme, (2,)))
            rough = _widen_range(at_p * from_middle.ranges[3], self.programme.acceleration_jump_rounding)
            point = _select_ranges(cut, rough, point)
        still = _select_ranges((a.value.low == 0.0) & (a.value.high == 0.0), value * 0.0, value)
        point = _select_ranges((at_p.low == 0.0) & (at_p.high == 0.0), point * 0.0, point)
        by_place = range_of(a) * on_way.ranges[order + 2]  # slope of the change by φ
        if order == 1:
            by_place = _widen_range(by_place, self.programme.acceleration_jump_rounding)
        if order:
            far = ahead.ranges[order + 1] - range_of(self.place.motion[order + 1])
            by_place = _select_ranges(on_way.pieces, far, by_place)
        return apply_chain_rule(still, point, [(a, ahead.ranges[order + 1]), (self._cam_angle, by_place)])

    def derivative_ahead(self, order: int) -> Number:
        """A derivative of the motion at the angle ahead."""
        if order < LAST_DERIVATIVE:
            derivative = self.place.motion[order] + self.derivative_change_to_ahead(order)
            return derivative + self.jumps.y2_jump if order == 2 else derivative
        a, y3 = self.angle_ahead, self.place.motion[LAST_DERIVATIVE]
        slope, on_way, _, from_middle = (
            each.ranges[LAST_DERIVATIVE + 1] for each in self._motion_ranges_ahead_and_on_way
        )
        value = range_of(y3) + range_of(a) * on_way
        point = value_at_box_point(y3) + value_at_box_point(a) * from_middle
        return apply_chain_rule(value, point, [(a, slope), (self._cam_angle, slope)]) + self.jumps.y3_jump

    @property
    def _cam_angle(self) -> SlopedInterval:
        """The cam angle φ as the first variable: slope 1 by itself."""
        one = np.zeros(self.place.y.slopes.low.shape)
        one[0] = 1.0
        return replace(self.place.y, slopes=Interval(one, one))

    @cached_property
    def _motion_ranges_ahead_and_on_way(self) -> list[StretchRanges]:
        """Stretches at the angle ahead, and on the way to it; over whole parts, and from their middles."""
        place, table = self.place, self.programme.table
        whole = place.low, place.high, range_of(self.angle_ahead)
        middle = place.middle, place.middle, value_at_box_point(self.angle_ahead)
        ways = [(low, high, way) for low, high, a in (whole, middle) for way in (a, hull_with_zero(a))]
        columns = zip(*((low, high, way.low, way.high) for low, high, way in ways), strict=True)
        start, end, back, forward = (np.concatenate(each) for each in columns)
        panel = np.tile(place.panel, len(ways))
        rounding = INPUT_ROUNDOFF * table.half_width[panel]
        start, end = start + back - rounding * (back < 0.0), end + forward + rounding * (forward > 0.0)
        return motion_ranges_over_stretches(table, panel, start, end).split(len(ways))


class DwellAhead(MotionAhead):
    """The motion on the arc of a dwell, which is the same at every angle ahead."""

    def derivative_change_to_ahead(self, order: int) -> Number:
        return self.place.y * 0.0

    def derivative_ahead(self, order: int) -> Number:
        return self.place.motion[order]


def _widen_range(x: Interval, margin: float) -> Interval:
    return Interval(x.low - margin, x.high + margin)


def _select_ranges(chosen: Any, a: Interval, b: Interval) -> Interval:
    return Interval(np.where(chosen, a.low, b.low), np.where(chosen, a.high, b.high))


@dataclass(frozen=True)
class ContactAhead:
    """One contact of a follower over parts of the turn, at a place ahead of φ."""

    cam: RealCam
    number: int
    box: Errors
    """The variables of the boxes, in flat form."""
    errors: Errors
    """The errors in flat form, equal to ``box`` or taken at another cam angle; the bore as it is at φ."""
    place: PartMotion

    @property
    def motion_sign(self) -> float:
        """Sign of the contact's own motion relative to the follower's."""
        return -self.cam.second_motion_sign if self.number else 1.0

    def follower_shift(self, angle_ahead: SlopedInterval) -> Number:
        """Displacement that the contact gives the follower at the place ahead, less that of the motion at φ."""
        motion = self.motion_ahead(angle_ahead)
        return (
            motion.derivative_change_to_ahead(0)
            + self._contact_shift(motion).follower_shift.terms[0] * self.motion_sign
        )

    def errors_at_first_contact(self, first: MotionAhead, order: int) -> list[Any]:
        """Errors of the contact's own motion at the cam angle at which the first contact touches."""
        ahead = self.motion_ahead(self.enclose_angle_ahead(first.angle_ahead))
        motion, sign = self._contact_motion(ahead, order + 2), self.motion_sign
        return follower_errors(
            self.cam.contact_shift(self.number, self.errors, motion, order, ahead.angle_ahead),
            motion,
            lambda k: (first.derivative_change_to_ahead(k) - ahead.derivative_change_to_ahead(k)) * sign,
            (self.place.jumps_at_contact.y2_jump - self.place.jumps_at_second_contact.y2_jump) * sign,
            order,
        )

    def motion_ahead(self, angle_ahead: SlopedInterval) -> MotionAhead:
        return MotionAhead(self.cam.problem.programme, self.place, angle_ahead, self.place.jumps_at_second_contact)

    def enclose_angle_ahead(self, cam_angle: SlopedInterval) -> SlopedInterval:
        """Angle a from φ to the place that touches when the cam is turned ``cam_angle`` (b) beyond φ [rad]."""
        place = as_sloped_interval(0.0, cam_angle)
        guess = cam_angle - self._contact_shift(self.motion_ahead(place)).cam_turn.terms[0]
        most = FIRST_RANGE_FACTOR * (cam_angle.value.largest_magnitude + guess.value.largest_magnitude)
        place, inside = as_sloped_interval(Interval(-most, most), cam_angle), np.ones(most.shape, dtype=bool)
        for _ in range(CONTRACTIONS):  # each contracts the range by the ratio of the errors to the cam's size
            turn = self._contact_shift(self.motion_ahead(place)).cam_turn.terms[0]
            nearer = cam_angle - turn  # errors that both have in common nearly cancel
            inside &= (nearer.value.low >= place.value.low) & (nearer.value.high <= place.value.high)
            value, at = (_select_ranges(inside, each, as_interval(np.nan)) for each in (nearer.value, nearer.at))
            place = replace(place, value=value, at=at)
        keys, by_place = [*self.box], as_interval(turn.slopes[0])
        if BORE in keys and not self.cam.is_developed:  # the bore turns with the place
            x, y = (range_of(self.box[key]) for key in (BORE, BORE_DIRECTION))
            by_x, by_y = (turn.slopes[1 + keys.index(key)] for key in (BORE, BORE_DIRECTION))
            by_place = by_place + (by_y * x - by_x * y) * self.cam.problem.design.sense
        slope = 1.0 / (by_place + 1.0)
        return apply_chain_rule(place.value, place.at, [(cam_angle, slope), (turn, slope * -1.0)])

    def _contact_shift(self, ahead: MotionAhead) -> ContactShiftSeries:
        """m and τ of the contact at the place ahead, without their derivatives."""
        motion = self._contact_motion(ahead, 2)
        return self.cam.contact_shift(self.number, self.errors, motion, 0, ahead.angle_ahead)

    def _contact_motion(self, ahead: MotionAhead, count: int) -> list[Any]:
        """The contact's own motion at the place ahead."""
        motion = [ahead.derivative_ahead(order) * self.motion_sign for order in range(count)]
        lift = self.cam.contacts[self.number].programme.lift
        return [motion[0] + lift, *motion[1:]] if self.motion_sign < 0.0 else motion


class RestingContact(ContactAhead):
    """A contact that touches the arc of a dwell at any place ahead."""

    def motion_ahead(self, angle_ahead: SlopedInterval) -> MotionAhead:
        return DwellAhead(self.cam.problem.programme, self.place, angle_ahead, self.place.jumps_at_second_contact)


def highest_order_tool_error(
    problem: Problem,
    errors: Mapping[str, Any],
    follower_deltas: Sequence[Any],
    nominal_derivative: Callable[[int], Any],
) -> Number:
    """Error ε of the tool of the last order, from the follower's errors δ of all orders.

    ``nominal_derivative`` gives the derivatives of the follower's programmed motion.
    """
    deltas = [each.divide() if hasattr(each, "divide") else each for each in follower_deltas]
    order = len(deltas) - 1
    if problem.setup.train is None:
        return deltas[order]
    motion = [nominal_derivative(k) for k in range(order + 1)]
    links = _train_link_errors(errors, motion[0])
    if not links and (ratio := problem.setup.train.constant_ratio) is not None:
        return deltas[order] * ratio
    train = RealTrain(problem, links, deltas[0], motion[0], order)
    if order == 0:
        return train.train_derivative_change_by_errors(0)
    velocity = motion[1] + deltas[1]
    if order == 1:
        return train.train_derivative_change_by_errors(1) * velocity + train.nominal_derivative(1) * deltas[1]
    by_nominal_train = (
        train.nominal_derivative(2) * (motion[1] * 2.0 + deltas[1]) * deltas[1]
        + train.nominal_derivative(1) * deltas[2]
    )
    by_links = train.train_derivative_change_by_errors(1) * (motion[2] + deltas[2])
    return train.train_derivative_change_by_errors(2) * np.square(velocity) + by_links + by_nominal_train


def tool_position_difference(
    problem: Problem, errors: Mapping[str, Any], first_error: Number, second_error: Number, position: SlopedInterval
) -> Number:
    """f*(s + δ₁) − f*(s + δ₂) for a follower with the nominal position s, by the mean value theorem."""
    difference, start = first_error - second_error, position + second_error
    if problem.setup.train is None:
        return difference
    links = _train_link_errors(errors, position)
    if not links and (ratio := problem.setup.train.constant_ratio) is not None:
        return difference * ratio
    step, link_ranges, link_points = range_of(difference), _scaled_link_error_ranges(links), _link_midpoints(links)
    ends = [(value_at_box_point(each), link_points) for each in (start + difference, start)]
    (slopes, first_at, second_at), by_link = _train_derivatives(
        problem, [(range_of(start) + hull_with_zero(step), link_ranges), *ends], 3
    )
    by_links = [(each, by_link[key][1] * step) for key, each in links.items()]
    parts = [(difference, slopes[1]), (start, slopes[2] * step), *by_links]
    return apply_chain_rule(slopes[1] * step, first_at[0] - second_at[0], parts)


def _train_link_errors(errors: Mapping[str, Any], sloped_interval: SlopedInterval) -> dict[str, SlopedInterval]:
    return {
        key: each.divide() if hasattr(each, "divide") else each + sloped_interval * 0.0
        for key, each in errors.items()
        if is_train_key(key)
    }


@dataclass(frozen=True)
class RealTrain:
    """A train whose links may have errors, driven by a follower with an error of its position."""

    problem: Problem
    links: Mapping[str, SlopedInterval]
    error: SlopedInterval
    nominal_position: SlopedInterval
    order: int

    def train_derivative_change_by_errors(self, order: int) -> SlopedInterval:
        """Change Δ_k of the derivative of an order."""
        (between, _, nominal_at, real_at), by_link = self._derivatives_nominal_and_real
        parts = [
            (self.error, between[order + 1]),
            (self.nominal_position, self._derivative_change_range(order + 1)),
            *((each, by_link[key][order]) for key, each in self.links.items()),
        ]
        return apply_chain_rule(self._derivative_change_range(order), real_at[order] - nominal_at[order], parts)

    def nominal_derivative(self, order: int) -> SlopedInterval:
        """Derivative of f at the nominal position."""
        (_, nominal, nominal_at, _), _ = self._derivatives_nominal_and_real
        return apply_chain_rule(nominal[order], nominal_at[order], [(self.nominal_position, nominal[order + 1])])

    def _derivative_change_range(self, order: int) -> Interval:
        """Range of Δ_k, by the mean value theorem."""
        (between, *_), by_link = self._derivatives_nominal_and_real
        by_links = (by_link[key][order] * range_of(each) for key, each in self.links.items())
        return as_interval(sum(by_links, between[order + 1] * range_of(self.error)))

    @cached_property
    def _derivatives_nominal_and_real(self) -> "TrainDerivatives":
        """Derivatives of the train over four blocks.

        From the nominal to the real position, over the nominal position, at its point, and at the real point.
        """
        position, at, no_errors = (
            range_of(self.nominal_position),
            value_at_box_point(self.nominal_position),
            _scaled_link_error_ranges(self.links, 0.0),
        )
        from_nominal = {key: hull_with_zero(each) for key, each in _scaled_link_error_ranges(self.links).items()}
        real = at + value_at_box_point(self.error), _link_midpoints(self.links)
        between = position + hull_with_zero(range_of(self.error)), from_nominal
        blocks = [between, (position, no_errors), (at, no_errors), real]
        return _train_derivatives(self.problem, blocks, self.order + 3)


TrainDerivatives = tuple[list[list[Interval]], dict[str, list[Interval]]]
"""f, f', … over blocks of ranges, and the derivatives of ∂f/∂p over the first block, by key of each link."""


def _scaled_link_error_ranges(links: Mapping[str, SlopedInterval], share: float = 1.0) -> dict[str, Interval]:
    return {key: as_interval(range_of(each) * share) for key, each in links.items()}


def _link_midpoints(links: Mapping[str, SlopedInterval]) -> dict[str, Interval]:
    return {key: value_at_box_point(each) for key, each in links.items()}


def _train_derivatives(
    problem: Problem, blocks: Sequence[tuple[Interval, Mapping[str, Interval]]], count: int
) -> TrainDerivatives:
    """Derivatives of trains by the follower's position, over ranges of the position and of the links' errors."""
    keys, size = [*blocks[0][1]], blocks[0][0].size
    repeated = [blocks[0]] * (len(keys) - 1) + [*blocks]  # the first block once for each link
    place = _concatenate_ranges([each for each, _ in repeated])
    numbers: dict[str, Any] = {
        key: without_slopes(
            problem.nominal_numbers[key] + _concatenate_ranges([errors[key] for _, errors in repeated])
        )
        for key in keys
    }
    zero = without_slopes(as_interval(place * 0.0))
    position: Any = Taylor(
        [without_slopes(follower_offset_in_train(problem) + place), zero + 1.0, *[zero] * count][:count]
    )
    if keys:
        seeds = np.repeat(np.eye(len(keys), len(repeated)), size, axis=1)
        numbers = {key: Taylor([numbers[key], seed]) for key, seed in zip(keys, seeds, strict=True)}
        position = Taylor([position, position * 0.0])
    train = problem.trains_with_numbers(numbers) if numbers else problem.setup.train
    assert train is not None
    tool, first = train.tool_displacement(position), max(len(keys) - 1, 0)

    def block(series: Taylor, number: int) -> list[Interval]:
        part = slice(number * size, (number + 1) * size)
        return [range_of(each)[part] * float(factorial(k)) for k, each in enumerate(series.terms)]

    value, slope = tool.terms if keys else (tool, tool)
    by_link = {key: block(slope, number) for number, key in enumerate(keys)}
    return [block(value, first + number) for number in range(len(blocks))], by_link


def _concatenate_ranges(parts: Sequence[Interval]) -> Interval:
    return Interval(
        *(np.concatenate(each) for each in zip(*((part.low, part.high) for part in parts), strict=True))
    )


def hull_with_zero(x: Interval) -> Interval:
    """The smallest range that contains 0 and x."""
    return Interval(np.minimum(x.low, 0.0), np.maximum(x.high, 0.0))


def without_slopes(x: Interval) -> LinkageInterval:
    """Ranges without slopes, for the formulas of links."""
    zero = as_interval(np.zeros((1, x.size)))
    return LinkageInterval.from_sloped_interval(SlopedInterval(x, x, zero, zero), [])
