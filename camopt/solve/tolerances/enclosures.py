"""What proofs of errors run on: the motion near a place, and contacts near one, over boxes of errors.

Where the cam touches at φ + a in place of φ, with a as small as the errors,

    y⁽ᵏ⁾(φ + a) − y⁽ᵏ⁾(φ) ∈ a·y⁽ᵏ⁺¹⁾([φ, φ + a]),    ∂/∂a = y⁽ᵏ⁺¹⁾(φ + a),    ∂/∂φ = y⁽ᵏ⁺¹⁾(φ + a) − y⁽ᵏ⁺¹⁾(φ)

with the ranges of the derivatives over stretches of the turn (``numerics.stretches``). Where y'' jumps between both
angles, that of y'' is without the jump, which ``Jumped`` has.

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

from camopt.core.numerics import GIVEN, FloatArray, IntArray
from camopt.core.numerics.interval import Interval, as_interval
from camopt.core.numerics.sloped import Placed, Sloped, as_sloped, at_point, by_chain, range_of
from camopt.core.numerics.stretches import Stretch, over_stretch
from camopt.core.numerics.taylor import Taylor
from camopt.model.motion.programme import Programme, jumps_of
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.variables import is_of_train
from camopt.solve.tolerances.errors import BORE, BORE_WAY, Errors
from camopt.solve.tolerances.real_cam import Moved, RealCam, errors_of, follower_start

FINER = 2
"""How often the place is found closer."""
ROOM = 2.0
"""Of what is looked at first for it, to where it seems to be."""
LAST = 3
"""The order of the last derivative of a motion that a place has."""


class Place(NamedTuple):
    """The motion of the follower over parts of panels."""

    motion: list[Sloped]
    """y, y', y'', y'''."""
    panel: IntArray
    low: FloatArray
    """Where they begin, and end, from the centre of their panel, rad."""
    high: FloatArray
    middle: FloatArray
    jumped: "Jumped"
    """What jumps make of the motion at the cam angle at which the place touches."""
    ahead: "Jumped"
    """And where a further contact touches then."""

    @property
    def y(self) -> Sloped:
        return self.motion[0]

    @property
    def y1(self) -> Sloped:
        return self.motion[1]


class Jumped(NamedTuple):
    """By how much y'' and y''' may differ a little further on, by jumps between both angles."""

    by2: Interval
    by3: Interval


@dataclass(frozen=True)
class FurtherOn:
    """The motion at an angle further on, which changes with the errors and with φ."""

    programme: Programme
    at: Place
    turned: Sloped
    jumped: Jumped
    _known: dict[int, Sloped] = field(default_factory=dict)

    def by(self, order: int) -> Any:
        """By how much a derivative differs there; of y'' but for its jumps."""
        if order not in self._known:
            self._known[order] = self._by(order)
        return self._known[order]

    def _by(self, order: int) -> Sloped:
        a, at_p, last = self.turned, at_point(self.turned), self._last(order)
        value = range_of(a) * self._between.ranges[order + 1]
        point = self._there_at.ranges[order] - at_point(self.at.motion[order])
        if order == 2:
            value = _with(value, self.programme.unseen_jump)
            cut = self._between_at.pieces & bool(jumps_of(self.programme, (2,)))
            rough = _with(at_p * self._between_at.ranges[3], self.programme.unseen_jump)
            point = _where(cut, rough, point)
        still = _where((a.value.low == 0.0) & (a.value.high == 0.0), value * 0.0, value)
        point = _where((at_p.low == 0.0) & (at_p.high == 0.0), point * 0.0, point)
        place = replace(self.at.y, slopes=_along_turn(self.at.y))
        return by_chain(still, point, [(a, self._there.ranges[order + 1]), (place, last)])

    def motion(self, order: int) -> Any:
        """A derivative there."""
        if order < LAST:
            found = self.at.motion[order] + self.by(order)
            return found + self.jumped.by2 if order == 2 else found
        a, y3, slope = self.turned, self.at.motion[LAST], self._there.ranges[LAST + 1]
        value = range_of(y3) + range_of(a) * self._between.ranges[LAST + 1]
        point = at_point(y3) + at_point(a) * self._between_at.ranges[LAST + 1]
        place = replace(self.at.y, slopes=_along_turn(self.at.y))
        return by_chain(value, point, [(a, slope), (place, slope)]) + self.jumped.by3

    def _last(self, order: int) -> Interval:
        """By how much the next derivative differs: the slope by φ."""
        near: Interval = range_of(self.turned) * self._between.ranges[order + 2]
        if order == 0:
            return near
        far = self._there.ranges[order + 1] - range_of(self.at.motion[order + 1])
        if order == 1:
            near = _with(near, self.programme.unseen_jump)
        return _where(self._between.pieces, far, near)

    @property
    def _there(self) -> Stretch:
        return self._stretches[0]

    @property
    def _between(self) -> Stretch:
        return self._stretches[1]

    @property
    def _there_at(self) -> Stretch:
        return self._stretches[2]

    @property
    def _between_at(self) -> Stretch:
        return self._stretches[3]

    @cached_property
    def _stretches(self) -> list[Stretch]:
        """Where the motion is further on, and all on the way there; over parts, and from their middles."""
        place, table = self.at, self.programme.table
        whole = place.low, place.high, range_of(self.turned)
        middle = place.middle, place.middle, at_point(self.turned)
        ways = [(low, high, way) for low, high, a in (whole, middle) for way in (a, from_0(a))]
        every = zip(*((low, high, way.low, way.high) for low, high, way in ways), strict=True)
        start, end, back, on = (np.concatenate(each) for each in every)
        panel = np.tile(place.panel, len(ways))
        room = GIVEN * table.half_width[panel]
        start, end = start + back - room * (back < 0.0), end + on + room * (on > 0.0)
        return over_stretch(table, panel, start, end).split(len(ways))


class StillOn(FurtherOn):
    """The motion on the arc of a dwell, wherever it is further on."""

    def by(self, order: int) -> Any:
        return self.at.y * 0.0

    def motion(self, order: int) -> Any:
        return self.at.motion[order]


def _with(x: Interval, room: float) -> Interval:
    return Interval(x.low - room, x.high + room)


def _where(chosen: Any, a: Interval, b: Interval) -> Interval:
    return Interval(np.where(chosen, a.low, b.low), np.where(chosen, a.high, b.high))


def _known(known: Any, value: Interval) -> Interval:
    return Interval(np.where(known, value.low, np.nan), np.where(known, value.high, np.nan))


def _along_turn(like: Sloped) -> Interval:
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
    at: Place

    @property
    def sign(self) -> float:
        """What its own motion is to that of the follower."""
        return -self.cam.back if self.number else 1.0

    @property
    def contact(self) -> Problem:
        """That of the contact."""
        return self.cam.contacts[self.number]

    def moved(self, ahead: Sloped) -> Any:
        """How much further it would move the follower than the motion has it where nothing is ahead."""
        there = self.further(ahead)
        return there.by(0) + self._moved(there, self._motion(there, 2), 0).moved.terms[0] * self.sign

    def errors_at(self, further: FurtherOn, order: int) -> list[Any]:
        """Its errors, in its own motion, at the cam angle that the first contact has where it touches."""
        there = self.further(self.ahead(further.turned))
        motion = self._motion(there, order + 2)

        def differs(k: int) -> Any:
            return (further.by(k) - there.by(k)) * self.sign

        jumped = (self.at.jumped.by2 - self.at.ahead.by2) * self.sign
        return errors_of(self._moved(there, motion, order), motion, differs, jumped, order)

    def further(self, ahead: Sloped) -> FurtherOn:
        """The motion there."""
        return FurtherOn(self.cam.problem.programme, self.at, ahead, self.at.ahead)

    def ahead(self, turned: Sloped) -> Sloped:
        """How far ahead it touches where the cam is turned on by so much."""
        there = as_sloped(0.0, turned)
        guess = turned - self._turned(there)
        most = ROOM * (turned.value.largest_magnitude + guess.value.largest_magnitude)
        there, inside = as_sloped(Interval(-most, most), turned), np.ones(most.shape, dtype=bool)
        for _ in range(FINER):  # a contraction by the share that errors are of the cam
            of = self._turned(there)
            found = turned - of  # of errors that both have in common little is left
            inside &= (found.value.low >= there.value.low) & (found.value.high <= there.value.high)
            there = replace(there, value=_known(inside, found.value), at=_known(inside, found.at))
        slope = 1.0 / (self._by_place(of) + 1.0)
        return by_chain(there.value, there.at, [(turned, slope), (of, slope * -1.0)])

    def _turned(self, ahead: Sloped) -> Any:
        there = self.further(ahead)
        return self._moved(there, self._motion(there, 2), 0).turned.terms[0]

    def _moved(self, there: FurtherOn, motion: list[Any], order: int) -> Moved:
        """Where its follower rests."""
        errors, design = self.cam.own(self.number, self.errors, there.turned), self.contact.design
        return self.cam.rest(self.number, design, errors, motion, order)

    def _motion(self, there: FurtherOn, count: int) -> list[Any]:
        """Its own motion at a place."""
        found = [there.motion(order) * self.sign for order in range(count)]
        return [found[0] + self.contact.programme.lift, *found[1:]] if self.sign < 0.0 else found

    def _by_place(self, of: Sloped) -> Interval:
        """The slope of where the cam touches by the place: the bore turns with it."""
        keys, found = [*self.box], as_interval(of.slopes[0])
        if BORE in keys and not self.cam.developed:
            x, y = (range_of(self.box[key]) for key in (BORE, BORE_WAY))
            by_x, by_y = (of.slopes[1 + keys.index(key)] for key in (BORE, BORE_WAY))
            found = found + (by_y * x - by_x * y) * self.cam.problem.design.sense
        return found


class RestingContact(ContactAhead):
    """A contact that touches the arc of a dwell, wherever it is ahead."""

    def further(self, ahead: Sloped) -> FurtherOn:
        return StillOn(self.cam.problem.programme, self.at, ahead, self.at.ahead)


Off = Mapping[str, Interval]
"""By how much links are off, by key of the scene."""


def through(
    problem: Problem, errors: Mapping[str, Any], errors_of_follower: Sequence[Any], asked: Callable[[int], Any]
) -> Any:
    """The error of the tool of the last order, from those of a follower up to it, and its motion that is asked."""
    found = [each.divided() if hasattr(each, "divided") else each for each in errors_of_follower]
    order = len(found) - 1
    if problem.setup.train is None:
        return found[order]
    motion = [asked(k) for k in range(order + 1)]
    links = _links(problem, errors, motion[0])
    if (ratio := _constant_ratio(problem, links)) is not None:
        return found[order] * ratio
    off = OffTrain(problem, links, found[0], motion[0], order)
    if order == 0:
        return off.differs(0)
    speed = motion[1] + found[1]
    if order == 1:
        return off.differs(1) * speed + off.slope(1) * found[1]
    bent = off.slope(2) * (motion[1] * 2.0 + found[1]) * found[1] + off.slope(1) * found[2]
    return off.differs(2) * np.square(speed) + off.differs(1) * (motion[2] + found[2]) + bent


def between(problem: Problem, errors: Mapping[str, Any], first: Any, second: Any, stands: Sloped) -> Any:
    """f*(s + δ₁) − f*(s + δ₂), of a follower that should stand at s: by the mean value theorem."""
    further, start = first - second, stands + second
    if problem.setup.train is None:
        return further
    links = _links(problem, errors, stands)
    if (ratio := _constant_ratio(problem, links)) is not None:
        return further * ratio
    apart, off, off_at = range_of(further), _ranges(links), _points(links)
    ends = [(at_point(each), off_at) for each in (start + further, start)]
    (slopes, first_at, second_at), by_link = _derivatives(
        problem, [(range_of(start) + from_0(apart), off), *ends], 3
    )
    by_links = [(each, by_link[key][1] * apart) for key, each in links.items()]
    parts = [(further, slopes[1]), (start, slopes[2] * apart), *by_links]
    return by_chain(slopes[1] * apart, first_at[0] - second_at[0], parts)


def _links(problem: Problem, errors: Mapping[str, Any], like: Sloped) -> dict[str, Sloped]:
    """By how much links are off."""
    return {key: plain(each, like) for key, each in errors.items() if is_of_train(key)}


def _constant_ratio(problem: Problem, links: Mapping[str, Sloped]) -> float | None:
    """That of a train whose links are not off, if it has one."""
    train = problem.setup.train
    assert train is not None
    return None if links else train.constant_ratio


@dataclass(frozen=True)
class OffTrain:
    """A train whose links may be off, of a follower that is off by an error from where it stands."""

    problem: Problem
    links: Mapping[str, Sloped]
    error: Sloped
    stands: Sloped
    order: int

    def differs(self, order: int) -> Sloped:
        """Δ_k."""
        (between, _, asked_at, real_at), by_link = self._towers
        parts = [(self.error, between[order + 1]), (self.stands, self._near(order + 1))]
        parts += [(each, by_link[key][order]) for key, each in self.links.items()]
        return by_chain(self._near(order), real_at[order] - asked_at[order], parts)

    def slope(self, order: int) -> Sloped:
        """The derivative of f where the follower should stand."""
        (_, asked, asked_at, _), _ = self._towers
        return by_chain(asked[order], asked_at[order], [(self.stands, asked[order + 1])])

    def _near(self, order: int) -> Interval:
        """By how much a derivative differs, on ranges."""
        (between, *_), by_link = self._towers
        found = between[order + 1] * range_of(self.error)
        for key, each in self.links.items():
            found = found + by_link[key][order] * range_of(each)
        return as_interval(found)

    @cached_property
    def _towers(self) -> "Towers":
        """From where the follower should stand to where it does; where it should, and that and where it does at
        the point; with links."""
        stands, at, none = range_of(self.stands), at_point(self.stands), _ranges(self.links, 0.0)
        from_asked = {key: from_0(each) for key, each in _ranges(self.links).items()}
        real = at + at_point(self.error), _points(self.links)
        blocks = [(stands + from_0(range_of(self.error)), from_asked), (stands, none), (at, none), real]
        return _derivatives(self.problem, blocks, self.order + 3)


Towers = tuple[list[list[Interval]], dict[str, list[Interval]]]
"""f, f', … of some blocks of ranges, and those of ∂f/∂p of the first block, by the key of each link."""


def _ranges(links: Mapping[str, Sloped], share: float = 1.0) -> dict[str, Interval]:
    return {key: as_interval(range_of(each) * share) for key, each in links.items()}


def _points(links: Mapping[str, Sloped]) -> dict[str, Interval]:
    return {key: at_point(each) for key, each in links.items()}


def _derivatives(problem: Problem, blocks: Sequence[tuple[Interval, Off]], count: int) -> Towers:
    """The derivatives of trains by where their follower stands, on ranges of it and of what links are off by."""
    keys, size = [*blocks[0][1]], blocks[0][0].size
    every = [blocks[0]] * (len(keys) - 1) + [*blocks]  # the first one for each link
    place = _joined([each for each, _ in every])
    made: dict[str, Any] = {
        key: still(problem.nominal[key] + _joined([off[key] for _, off in every])) for key in keys
    }
    none = still(as_interval(place * 0.0))
    stands: Any = Taylor([still(follower_start(problem) + place), none + 1.0, *[none] * count][:count])
    if keys:
        seeds = np.repeat(np.eye(len(keys), len(every)), size, axis=1)
        made = {key: Taylor([made[key], seed]) for key, seed in zip(keys, seeds, strict=True)}
        stands = Taylor([stands, stands * 0.0])
    train = problem.trains(made) if made else problem.setup.train
    assert train is not None
    found, first = train.tool(stands), max(len(keys) - 1, 0)

    def block(series: Taylor, number: int) -> list[Interval]:
        part = slice(number * size, (number + 1) * size)
        return [range_of(each)[part] * float(factorial(k)) for k, each in enumerate(series.terms)]

    value, slope = found.terms if keys else (found, found)
    by_link = {key: block(slope, number) for number, key in enumerate(keys)}
    return [block(value, first + number) for number in range(len(blocks))], by_link


def _joined(parts: Sequence[Interval]) -> Interval:
    """Ranges one after the other."""
    return Interval(
        *(np.concatenate(each) for each in zip(*((part.low, part.high) for part in parts), strict=True))
    )


def from_0(x: Interval) -> Interval:
    """All from 0 to a range."""
    return Interval(np.minimum(x.low, 0.0), np.maximum(x.high, 0.0))


def still(x: Interval) -> Placed:
    """Ranges without slopes, for the formulas of links."""
    none = as_interval(np.zeros((1, x.size)))
    return Placed.of(Sloped(x, x, none, none), [])


def plain(x: Any, like: Sloped) -> Any:
    """A number over boxes as what has no kept quotient."""
    return x.divided() if hasattr(x, "divided") else x + like * 0.0
