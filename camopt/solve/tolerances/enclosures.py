"""What proofs of errors run on: the motion near a place, and contacts near one, over boxes of errors.

Where the cam touches at φ + a in place of φ, with a as small as the errors,

    y⁽ᵏ⁾(φ + a) − y⁽ᵏ⁾(φ) ∈ a·y⁽ᵏ⁺¹⁾([φ, φ + a]),    ∂/∂a = y⁽ᵏ⁺¹⁾(φ + a),    ∂/∂φ = y⁽ᵏ⁺¹⁾(φ + a) − y⁽ᵏ⁺¹⁾(φ)

with the ranges of the derivatives over stretches of the turn (``numerics.stretches``). Where y'' jumps between both
angles, that of y'' is without the jump, which ``JumpRanges`` has.

A contact touches at θ = φ + turned(φ). The place φ + a that it touches at the cam angle φ + b is that of which

    a = b − turned(φ + a)

Where b − turned(φ + A) is within a range A, there is such an a in it (Brouwer); its slopes are those of the
equation. b is 0 at a given cam angle φ, and of a second contact what the first one has turned where it touches φ.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 8.

What the errors of a follower are at the tool, through a train whose links may be off too.

A follower that should stand at s(θ) stands at s + δ, and its train is f* in place of f:

    ε = Δ₀,    ε' = Δ₁·(s' + δ') + f'·δ',    ε'' = Δ₂·(s' + δ')² + f''·(2s' + δ')·δ' + Δ₁·(s'' + δ'') + f'·δ''

with f* and its derivatives at s + δ less those of f at s, which are small as the errors are:

    Δ_k = f*⁽ᵏ⁾(s + δ) − f⁽ᵏ⁾(s) ∈ f*⁽ᵏ⁺¹⁾·δ + Σ ∂f*⁽ᵏ⁾/∂p·δp

on the ranges between both (the mean value theorem), and at a point as they are.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import factorial
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import INPUT_ROUNDOFF, FloatArray, IntArray
from camopt.core.numerics.interval import Interval, as_interval
from camopt.core.numerics.sloped_interval import (
    LinkageInterval,
    SlopedInterval,
    apply_chain_rule,
    as_sloped_interval,
    range_of,
    value_at_point,
)
from camopt.core.numerics.stretches import StretchRanges, stretch_ranges
from camopt.core.numerics.taylor import Taylor
from camopt.model.motion.programme import Programme, find_jumps
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.variables import is_train_key
from camopt.solve.tolerances.errors import BORE, BORE_DIRECTION, Errors
from camopt.solve.tolerances.real_cam import ContactShiftSeries, RealCam, follower_errors, follower_start

CONTRACTIONS = 2
"""How often the place is found closer."""
FIRST_RANGE_FACTOR = 2.0
"""Of what is looked at first for it, to where it seems to be."""
LAST_DERIVATIVE = 3
"""The order of the last derivative of a motion that a place has."""


class PartMotion(NamedTuple):
    """The motion of the follower over parts of panels."""

    motion: list[SlopedInterval]
    """y, y', y'', y'''."""
    panel: IntArray
    low: FloatArray
    """Where they begin, and end, from the centre of their panel, rad."""
    high: FloatArray
    middle: FloatArray
    jumps_at_contact: "JumpRanges"
    """What jumps make of the motion at the cam angle at which the place touches."""
    jumps_at_second_contact: "JumpRanges"
    """And where a further contact touches then."""

    @property
    def y(self) -> SlopedInterval:
        return self.motion[0]

    @property
    def y1(self) -> SlopedInterval:
        return self.motion[1]


class JumpRanges(NamedTuple):
    """By how much y'' and y''' may differ a little further on, by jumps between both angles."""

    y2_jump: Interval
    y3_jump: Interval


@dataclass(frozen=True)
class MotionAhead:
    """The motion at an angle further on, which changes with the errors and with φ."""

    programme: Programme
    place: PartMotion
    angle_ahead: SlopedInterval
    jumps: JumpRanges
    _derivative_changes: dict[int, SlopedInterval] = field(default_factory=dict)

    def derivative_change(self, order: int) -> Any:
        """By how much a derivative differs there; of y'' but for its jumps."""
        if order not in self._derivative_changes:
            self._derivative_changes[order] = self._enclose_derivative_change(order)
        return self._derivative_changes[order]

    def _enclose_derivative_change(self, order: int) -> SlopedInterval:
        a, at_p, last = self.angle_ahead, value_at_point(self.angle_ahead), self._change_slope(order)
        value = range_of(a) * self._stretch_on_way.ranges[order + 1]
        point = self._stretch_ahead_of_middle.ranges[order] - value_at_point(self.place.motion[order])
        if order == 2:
            value = _widen_range(value, self.programme.unseen_jump)
            cut = self._stretch_on_way_from_middle.pieces & bool(find_jumps(self.programme, (2,)))
            rough = _widen_range(at_p * self._stretch_on_way_from_middle.ranges[3], self.programme.unseen_jump)
            point = _select_ranges(cut, rough, point)
        still = _select_ranges((a.value.low == 0.0) & (a.value.high == 0.0), value * 0.0, value)
        point = _select_ranges((at_p.low == 0.0) & (at_p.high == 0.0), point * 0.0, point)
        place = replace(self.place.y, slopes=_slopes_by_turn(self.place.y))
        return apply_chain_rule(still, point, [(a, self._stretch_ahead.ranges[order + 1]), (place, last)])

    def derivative_ahead(self, order: int) -> Any:
        """A derivative there."""
        if order < LAST_DERIVATIVE:
            found = self.place.motion[order] + self.derivative_change(order)
            return found + self.jumps.y2_jump if order == 2 else found
        a, y3, slope = (
            self.angle_ahead,
            self.place.motion[LAST_DERIVATIVE],
            self._stretch_ahead.ranges[LAST_DERIVATIVE + 1],
        )
        value = range_of(y3) + range_of(a) * self._stretch_on_way.ranges[LAST_DERIVATIVE + 1]
        point = (
            value_at_point(y3) + value_at_point(a) * self._stretch_on_way_from_middle.ranges[LAST_DERIVATIVE + 1]
        )
        place = replace(self.place.y, slopes=_slopes_by_turn(self.place.y))
        return apply_chain_rule(value, point, [(a, slope), (place, slope)]) + self.jumps.y3_jump

    def _change_slope(self, order: int) -> Interval:
        """By how much the next derivative differs: the slope by φ."""
        near: Interval = range_of(self.angle_ahead) * self._stretch_on_way.ranges[order + 2]
        if order == 0:
            return near
        far = self._stretch_ahead.ranges[order + 1] - range_of(self.place.motion[order + 1])
        if order == 1:
            near = _widen_range(near, self.programme.unseen_jump)
        return _select_ranges(self._stretch_on_way.pieces, far, near)

    @property
    def _stretch_ahead(self) -> StretchRanges:
        return self._motion_stretches[0]

    @property
    def _stretch_on_way(self) -> StretchRanges:
        return self._motion_stretches[1]

    @property
    def _stretch_ahead_of_middle(self) -> StretchRanges:
        return self._motion_stretches[2]

    @property
    def _stretch_on_way_from_middle(self) -> StretchRanges:
        return self._motion_stretches[3]

    @cached_property
    def _motion_stretches(self) -> list[StretchRanges]:
        """Where the motion is further on, and all on the way there; over parts, and from their middles."""
        place, table = self.place, self.programme.table
        whole = place.low, place.high, range_of(self.angle_ahead)
        middle = place.middle, place.middle, value_at_point(self.angle_ahead)
        ways = [(low, high, way) for low, high, a in (whole, middle) for way in (a, range_from_zero(a))]
        every = zip(*((low, high, way.low, way.high) for low, high, way in ways), strict=True)
        start, end, back, on = (np.concatenate(each) for each in every)
        panel = np.tile(place.panel, len(ways))
        room = INPUT_ROUNDOFF * table.half_width[panel]
        start, end = start + back - room * (back < 0.0), end + on + room * (on > 0.0)
        return stretch_ranges(table, panel, start, end).split(len(ways))


class DwellAhead(MotionAhead):
    """The motion on the arc of a dwell, wherever it is further on."""

    def derivative_change(self, order: int) -> Any:
        return self.place.y * 0.0

    def derivative_ahead(self, order: int) -> Any:
        return self.place.motion[order]


def _widen_range(x: Interval, room: float) -> Interval:
    return Interval(x.low - room, x.high + room)


def _select_ranges(chosen: Any, a: Interval, b: Interval) -> Interval:
    return Interval(np.where(chosen, a.low, b.low), np.where(chosen, a.high, b.high))


def _blank_unknown(known: Any, value: Interval) -> Interval:
    return Interval(np.where(known, value.low, np.nan), np.where(known, value.high, np.nan))


def _slopes_by_turn(like: SlopedInterval) -> Interval:
    """The slopes of the cam angle itself, which is the first of the variables."""
    one = np.zeros(like.slopes.low.shape)
    one[0] = 1.0
    return Interval(one, one)


@dataclass(frozen=True)
class ContactAhead:
    """One contact of a follower over parts of the turn, at places that are ahead."""

    cam: RealCam
    number: int
    box: Errors
    """The numbers that boxes are of, flat."""
    errors: Errors
    """The same, or what they are at another cam angle; the bore is in the ground where nothing is ahead."""
    place: PartMotion

    @property
    def motion_sign(self) -> float:
        """What its own motion is to that of the follower."""
        return -self.cam.second_motion_sign if self.number else 1.0

    @property
    def contact_problem(self) -> Problem:
        """That of the contact."""
        return self.cam.contacts[self.number]

    def follower_shift(self, ahead: SlopedInterval) -> Any:
        """How much further it would move the follower than the motion has it where nothing is ahead."""
        there = self.motion_ahead(ahead)
        return (
            there.derivative_change(0)
            + self._contact_shift(there, self._contact_motion(there, 2), 0).follower_shift.terms[0]
            * self.motion_sign
        )

    def errors_at_first_contact(self, further: MotionAhead, order: int) -> list[Any]:
        """Its errors, in its own motion, at the cam angle that the first contact has where it touches."""
        there = self.motion_ahead(self.angle_ahead(further.angle_ahead))
        motion = self._contact_motion(there, order + 2)

        def differs(k: int) -> Any:
            return (further.derivative_change(k) - there.derivative_change(k)) * self.motion_sign

        jumped = (
            self.place.jumps_at_contact.y2_jump - self.place.jumps_at_second_contact.y2_jump
        ) * self.motion_sign
        return follower_errors(self._contact_shift(there, motion, order), motion, differs, jumped, order)

    def motion_ahead(self, ahead: SlopedInterval) -> MotionAhead:
        """The motion there."""
        return MotionAhead(self.cam.problem.programme, self.place, ahead, self.place.jumps_at_second_contact)

    def angle_ahead(self, turned: SlopedInterval) -> SlopedInterval:
        """How far ahead it touches where the cam is turned on by so much."""
        there = as_sloped_interval(0.0, turned)
        guess = turned - self._cam_turn(there)
        most = FIRST_RANGE_FACTOR * (turned.value.largest_magnitude + guess.value.largest_magnitude)
        there, inside = as_sloped_interval(Interval(-most, most), turned), np.ones(most.shape, dtype=bool)
        for _ in range(CONTRACTIONS):  # a contraction by the share that errors are of the cam
            of = self._cam_turn(there)
            found = turned - of  # of errors that both have in common little is left
            inside &= (found.value.low >= there.value.low) & (found.value.high <= there.value.high)
            there = replace(there, value=_blank_unknown(inside, found.value), at=_blank_unknown(inside, found.at))
        slope = 1.0 / (self._turn_slope_by_place(of) + 1.0)
        return apply_chain_rule(there.value, there.at, [(turned, slope), (of, slope * -1.0)])

    def _cam_turn(self, ahead: SlopedInterval) -> Any:
        there = self.motion_ahead(ahead)
        return self._contact_shift(there, self._contact_motion(there, 2), 0).cam_turn.terms[0]

    def _contact_shift(self, there: MotionAhead, motion: list[Any], order: int) -> ContactShiftSeries:
        """Where its follower rests."""
        errors, design = (
            self.cam.errors_of_contact(self.number, self.errors, there.angle_ahead),
            self.contact_problem.design,
        )
        return self.cam.contact_shift(self.number, design, errors, motion, order)

    def _contact_motion(self, there: MotionAhead, count: int) -> list[Any]:
        """Its own motion at a place."""
        found = [there.derivative_ahead(order) * self.motion_sign for order in range(count)]
        return [found[0] + self.contact_problem.programme.lift, *found[1:]] if self.motion_sign < 0.0 else found

    def _turn_slope_by_place(self, of: SlopedInterval) -> Interval:
        """The slope of where the cam touches by the place: the bore turns with it."""
        keys, found = [*self.box], as_interval(of.slopes[0])
        if BORE in keys and not self.cam.is_developed:
            x, y = (range_of(self.box[key]) for key in (BORE, BORE_DIRECTION))
            by_x, by_y = (of.slopes[1 + keys.index(key)] for key in (BORE, BORE_DIRECTION))
            found = found + (by_y * x - by_x * y) * self.cam.problem.design.sense
        return found


class RestingContact(ContactAhead):
    """A contact that touches the arc of a dwell, wherever it is ahead."""

    def motion_ahead(self, ahead: SlopedInterval) -> MotionAhead:
        return DwellAhead(self.cam.problem.programme, self.place, ahead, self.place.jumps_at_second_contact)


LinkRanges = Mapping[str, Interval]
"""By how much links are off, by key of the scene."""


def error_through_train(
    problem: Problem, errors: Mapping[str, Any], errors_of_follower: Sequence[Any], asked: Callable[[int], Any]
) -> Any:
    """The error of the tool of the last order, from those of a follower up to it, and its motion that is asked."""
    found = [each.divide() if hasattr(each, "divide") else each for each in errors_of_follower]
    order = len(found) - 1
    if problem.setup.train is None:
        return found[order]
    motion = [asked(k) for k in range(order + 1)]
    links = _link_errors(problem, errors, motion[0])
    if (ratio := _constant_ratio(problem, links)) is not None:
        return found[order] * ratio
    off = RealTrain(problem, links, found[0], motion[0], order)
    if order == 0:
        return off.derivative_change(0)
    speed = motion[1] + found[1]
    if order == 1:
        return off.derivative_change(1) * speed + off.nominal_derivative(1) * found[1]
    bent = (
        off.nominal_derivative(2) * (motion[1] * 2.0 + found[1]) * found[1] + off.nominal_derivative(1) * found[2]
    )
    return off.derivative_change(2) * np.square(speed) + off.derivative_change(1) * (motion[2] + found[2]) + bent


def difference_through_train(
    problem: Problem, errors: Mapping[str, Any], first: Any, second: Any, stands: SlopedInterval
) -> Any:
    """f*(s + δ₁) − f*(s + δ₂), of a follower that should stand at s: by the mean value theorem."""
    further, start = first - second, stands + second
    if problem.setup.train is None:
        return further
    links = _link_errors(problem, errors, stands)
    if (ratio := _constant_ratio(problem, links)) is not None:
        return further * ratio
    apart, off, off_at = range_of(further), _link_ranges(links), _link_points(links)
    ends = [(value_at_point(each), off_at) for each in (start + further, start)]
    (slopes, first_at, second_at), by_link = _train_derivatives(
        problem, [(range_of(start) + range_from_zero(apart), off), *ends], 3
    )
    by_links = [(each, by_link[key][1] * apart) for key, each in links.items()]
    parts = [(further, slopes[1]), (start, slopes[2] * apart), *by_links]
    return apply_chain_rule(slopes[1] * apart, first_at[0] - second_at[0], parts)


def _link_errors(problem: Problem, errors: Mapping[str, Any], like: SlopedInterval) -> dict[str, SlopedInterval]:
    """By how much links are off."""
    return {key: without_kept_quotient(each, like) for key, each in errors.items() if is_train_key(key)}


def _constant_ratio(problem: Problem, links: Mapping[str, SlopedInterval]) -> float | None:
    """That of a train whose links are not off, if it has one."""
    train = problem.setup.train
    assert train is not None
    return None if links else train.constant_ratio


@dataclass(frozen=True)
class RealTrain:
    """A train whose links may be off, of a follower that is off by an error from where it stands."""

    problem: Problem
    links: Mapping[str, SlopedInterval]
    error: SlopedInterval
    nominal_position: SlopedInterval
    order: int

    def derivative_change(self, order: int) -> SlopedInterval:
        """Δ_k."""
        (between, _, asked_at, real_at), by_link = self._derivative_blocks
        parts = [(self.error, between[order + 1]), (self.nominal_position, self._change_range(order + 1))]
        parts += [(each, by_link[key][order]) for key, each in self.links.items()]
        return apply_chain_rule(self._change_range(order), real_at[order] - asked_at[order], parts)

    def nominal_derivative(self, order: int) -> SlopedInterval:
        """The derivative of f where the follower should stand."""
        (_, asked, asked_at, _), _ = self._derivative_blocks
        return apply_chain_rule(asked[order], asked_at[order], [(self.nominal_position, asked[order + 1])])

    def _change_range(self, order: int) -> Interval:
        """By how much a derivative differs, on ranges."""
        (between, *_), by_link = self._derivative_blocks
        found = between[order + 1] * range_of(self.error)
        for key, each in self.links.items():
            found = found + by_link[key][order] * range_of(each)
        return as_interval(found)

    @cached_property
    def _derivative_blocks(self) -> "TrainDerivatives":
        """From where the follower should stand to where it does; where it should, and that and where it does at
        the point; with links."""
        stands, at, none = (
            range_of(self.nominal_position),
            value_at_point(self.nominal_position),
            _link_ranges(self.links, 0.0),
        )
        from_asked = {key: range_from_zero(each) for key, each in _link_ranges(self.links).items()}
        real = at + value_at_point(self.error), _link_points(self.links)
        blocks = [(stands + range_from_zero(range_of(self.error)), from_asked), (stands, none), (at, none), real]
        return _train_derivatives(self.problem, blocks, self.order + 3)


TrainDerivatives = tuple[list[list[Interval]], dict[str, list[Interval]]]
"""f, f', … of some blocks of ranges, and those of ∂f/∂p of the first block, by the key of each link."""


def _link_ranges(links: Mapping[str, SlopedInterval], share: float = 1.0) -> dict[str, Interval]:
    return {key: as_interval(range_of(each) * share) for key, each in links.items()}


def _link_points(links: Mapping[str, SlopedInterval]) -> dict[str, Interval]:
    return {key: value_at_point(each) for key, each in links.items()}


def _train_derivatives(
    problem: Problem, blocks: Sequence[tuple[Interval, LinkRanges]], count: int
) -> TrainDerivatives:
    """The derivatives of trains by where their follower stands, on ranges of it and of what links are off by."""
    keys, size = [*blocks[0][1]], blocks[0][0].size
    every = [blocks[0]] * (len(keys) - 1) + [*blocks]  # the first one for each link
    place = _join_ranges([each for each, _ in every])
    made: dict[str, Any] = {
        key: without_slopes(problem.nominal_numbers[key] + _join_ranges([off[key] for _, off in every]))
        for key in keys
    }
    none = without_slopes(as_interval(place * 0.0))
    stands: Any = Taylor([without_slopes(follower_start(problem) + place), none + 1.0, *[none] * count][:count])
    if keys:
        seeds = np.repeat(np.eye(len(keys), len(every)), size, axis=1)
        made = {key: Taylor([made[key], seed]) for key, seed in zip(keys, seeds, strict=True)}
        stands = Taylor([stands, stands * 0.0])
    train = problem.trains_with_numbers(made) if made else problem.setup.train
    assert train is not None
    found, first = train.tool(stands), max(len(keys) - 1, 0)

    def block(series: Taylor, number: int) -> list[Interval]:
        part = slice(number * size, (number + 1) * size)
        return [range_of(each)[part] * float(factorial(k)) for k, each in enumerate(series.terms)]

    value, slope = found.terms if keys else (found, found)
    by_link = {key: block(slope, number) for number, key in enumerate(keys)}
    return [block(value, first + number) for number in range(len(blocks))], by_link


def _join_ranges(parts: Sequence[Interval]) -> Interval:
    """Ranges one after the other."""
    return Interval(
        *(np.concatenate(each) for each in zip(*((part.low, part.high) for part in parts), strict=True))
    )


def range_from_zero(x: Interval) -> Interval:
    """All from 0 to a range."""
    return Interval(np.minimum(x.low, 0.0), np.maximum(x.high, 0.0))


def without_slopes(x: Interval) -> LinkageInterval:
    """Ranges without slopes, for the formulas of links."""
    none = as_interval(np.zeros((1, x.size)))
    return LinkageInterval.from_interval(SlopedInterval(x, x, none, none), [])


def without_kept_quotient(x: Any, like: SlopedInterval) -> Any:
    """A number over boxes as what has no kept quotient."""
    return x.divide() if hasattr(x, "divide") else x + like * 0.0
