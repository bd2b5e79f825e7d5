"""The motion at an angle further on, by ranges with slopes: by how much y, y' and y'' differ there.

Where the cam touches at φ + a in place of φ, with a as small as the errors,

    y⁽ᵏ⁾(φ + a) − y⁽ᵏ⁾(φ) ∈ a·y⁽ᵏ⁺¹⁾([φ, φ + a]),    ∂/∂a = y⁽ᵏ⁺¹⁾(φ + a),    ∂/∂φ = y⁽ᵏ⁺¹⁾(φ + a) − y⁽ᵏ⁺¹⁾(φ)

with the ranges of the derivatives over stretches of the turn (``numerics.stretches``). Where y'' jumps between both
angles, that of y'' is without the jump, which ``Jumped`` has.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from camopt.motion.programme import Programme
from camopt.numerics import GIVEN, FloatArray, IntArray
from camopt.numerics.interval import Interval
from camopt.numerics.sloped import Sloped, at_point, by_chain, range_of
from camopt.numerics.stretches import Stretch, over_stretch
from camopt.tolerances.ranges import along_turn, from_0

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
            value, cut = _with(value, self.programme.unseen_jump), self._between_at.pieces
            rough = _with(at_p * self._between_at.ranges[3], self.programme.unseen_jump)
            point = _where(cut, rough, point)
        still = _where((a.value.low == 0.0) & (a.value.high == 0.0), value * 0.0, value)
        point = _where((at_p.low == 0.0) & (at_p.high == 0.0), point * 0.0, point)
        place = replace(self.at.y, slopes=along_turn(self.at.y))
        return by_chain(still, point, [(a, self._there.ranges[order + 1]), (place, last)])

    def motion(self, order: int) -> Any:
        """A derivative there."""
        if order < LAST:
            found = self.at.motion[order] + self.by(order)
            return found + self.jumped.by2 if order == 2 else found
        a, y3, slope = self.turned, self.at.motion[LAST], self._there.ranges[LAST + 1]
        value = range_of(y3) + range_of(a) * self._between.ranges[LAST + 1]
        point = at_point(y3) + at_point(a) * self._between_at.ranges[LAST + 1]
        place = replace(self.at.y, slopes=along_turn(self.at.y))
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
