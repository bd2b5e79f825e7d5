"""The largest error of the motion of each of many cams, exact at its cam angle.

Where it is, the first order says: the answers of the motion at some cam angles times the errors of a cam, one
matrix product for all cams. There the exact error is computed, and at the top of the parabola through these of
three places; where that is beside a joint of the motion, at the joint too. What is found is the true error of the
cam at some angle, and so never more than its largest one; ``missed`` says by how much it is less on some of the
cams, by a dense scan of exact errors.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from math import ceil
from typing import NamedTuple, TypeVar

import numpy as np

from camopt.effects.answers import ORDERS
from camopt.motion.programme import JUMP_SIDE
from camopt.numerics import FloatArray, IntArray
from camopt.tolerances.recontact import Off, RealCams
from camopt.tolerances.two_contacts import responses_of

NODES = 480
"""Cam angles at which the first order is looked at, at least."""
OF_A_WAVE = 12
"""And in a wave of the profile's error."""
NEAR = 2.0
"""How many steps between these a joint of the motion is away from the largest error that may be at it."""
DWELL_NODES = 24
AT_ONCE = 2**14
"""Cams: what is computed of them stays in the cache of a processor."""
SCREENED = 2**8
"""Cams, likewise, of which the first order is looked at, at all cam angles."""
STILL = 1e-12
"""Answers that are this near to each other, relative to the largest, are the same."""
THREADS = 2
SCANNED = 50
"""Cams whose largest errors are compared with those of a dense scan."""
DENSE = 4
"""How many times as many cam angles that has."""
Work = TypeVar("Work")
Errors = Callable[[Off, FloatArray], FloatArray]
"""The errors of some cams, each where it is touched at a cam angle of its own."""
Outward = Callable[[FloatArray], FloatArray]
"""What of errors is to be the largest: they, their magnitude, or what they are the other way."""


class Largest(NamedTuple):
    """The largest |error| of each cam, and the place on the cam, rad; (n,) each."""

    error: FloatArray
    place: FloatArray


@dataclass(frozen=True)
class Screen:
    """Cam angles of a turn, or of a part of it, with the answers of the motion."""

    places: FloatArray
    """In their order, (m,)."""
    answers: FloatArray
    """(errors, m), of real and imaginary parts one after the other."""

    @cached_property
    def widest(self) -> float:
        """The largest step between places."""
        return float(np.diff(self.places).max())

    @property
    def still(self) -> bool:
        """Whether errors are the same at all places."""
        return bool(np.ptp(self.answers, axis=1).max() <= STILL * np.abs(self.answers).max())

    def tops(self, off: Off, outward: Outward) -> list[Largest]:
        """Where errors are the largest to first order: the place below, it, and the one above."""
        errors, beside, found = columns(off), np.array([[-1], [0], [1]]), []
        for first in range(0, len(errors), SCREENED):
            values = outward(errors[first : first + SCREENED] @ self.answers)
            index = np.clip(values.argmax(axis=1) + beside, 0, self.places.size - 1)
            found.append([np.take_along_axis(values, index.T, axis=1).T, self.places[index]])
        return [Largest(*each) for each in zip(*np.concatenate(found, axis=2), strict=True)]


def columns(off: Off) -> FloatArray:
    """The errors of cams as real numbers, (n, errors)."""
    found = [
        part for each in off.values() for part in ((each.real, each.imag) if np.iscomplexobj(each) else (each,))
    ]
    return np.column_stack(found)


@dataclass(frozen=True)
class LargestErrors:
    """How to find the largest errors of cams."""

    cams: RealCams
    keys: tuple[str, ...]
    """Of the errors that cams have, in their order."""

    def of_motion(self, off: Off, order: int) -> Largest:
        """The largest |error| of position, velocity or acceleration of each cam."""
        return _joined(each_of(off, lambda some: self._of_motion(some, order)))

    def of_dwells(self, off: Off) -> FloatArray:
        """By how much the tool of each cam moves at most while its follower rests on the arc of one dwell, (n,)."""
        return np.concatenate([*each_of(off, self._of_dwells)])

    @property
    def has_dwells(self) -> bool:
        """Whether the tool dwells."""
        return bool(self._dwells)

    def missed(self, off: Off, order: int) -> float:
        """By how much the largest |errors| found are less than those of a dense scan, at most, of some cams."""
        count = count_of(off)
        some = taken(off, np.unique(np.linspace(0, count - 1, SCANNED).astype(int)))
        found, places = self._of_motion(some, order).error, self.nodes(DENSE * NODES)
        errors = self._exact(order)

        def scanned(few: Off) -> FloatArray:
            every = {key: np.repeat(each, places.size) for key, each in few.items()}
            found = errors(every, np.tile(places, count_of(few))).reshape(-1, places.size)
            return np.asarray(found.max(axis=1))

        highest = np.concatenate([*each_of(some, scanned, ceil(AT_ONCE / places.size))])
        return float(np.max(np.maximum(highest - found, 0.0)))

    def nodes(self, count: int) -> FloatArray:
        """Cam angles in the order of the turn, at least so many, with both sides of each joint, rad."""
        end = self.cams.problem.programme.strokes[-1].end
        waves = OF_A_WAVE * self.cams.waves * count // NODES
        even = np.linspace(0.0, end, 2 + max(count, waves))[1:-1]
        sides = np.mod(np.add.outer([-2.0 * JUMP_SIDE, 2.0 * JUMP_SIDE], self._joints).ravel(), end)
        return np.unique(np.concatenate([even, sides]))

    def _exact(self, order: int) -> Errors:
        return lambda off, places: np.abs(self.cams.errors(off, places, order))

    def _of_motion(self, off: Off, order: int) -> Largest:
        screen, errors = self._screens[order], self._exact(order)
        found = _climbed(errors, off, screen, np.abs)
        for place in self._beside_jumps(order):
            found = _larger(found, _at(errors, off, np.full(found.place.size, place)))
        away = np.abs(found.place[:, None] - self._joints)
        some = np.flatnonzero(away.min(axis=1) <= NEAR * screen.widest)
        near, joint = taken(off, some), self._joints[away[some].argmin(axis=1)]
        return _raised(found, some, _at(errors, near, self._touched(near, joint)))

    @cached_property
    def _joints(self) -> FloatArray:
        """Where pieces of the motion meet, rad: a slope of it may jump, there on the cam and at that cam angle."""
        programme = self.cams.problem.programme
        return np.unique([*programme.starts, *(jump.at for jump in programme.jumps)])

    def angle(self, off: Off, largest: Largest, cam: int) -> float:
        """The cam angle at which a cam has its largest error, deg."""
        one = slice(cam, cam + 1)
        touched = self.cams.angle(taken(off, one), largest.place[one])
        return float(np.degrees(self.cams.within(touched)[0]))

    def at(self, off: Off, angle: float, order: int) -> FloatArray:
        """The errors of cams at one cam angle, rad."""
        parts = each_of(off, lambda some: self._at_angle(some, angle, order))
        return np.concatenate([*parts])

    def _at_angle(self, off: Off, angle: float, order: int) -> FloatArray:
        return self.cams.errors(off, self._touched(off, np.full(count_of(off), angle)), order)

    def _touched(self, off: Off, angles: FloatArray) -> FloatArray:
        return self.cams.touched(off, angles)

    def _of_dwells(self, off: Off) -> FloatArray:
        def position(off: Off, places: FloatArray) -> FloatArray:
            return self.cams.motion(off, places, 0).by_angle(0)

        moved = np.zeros(count_of(off))
        for screen in self._dwells:
            if screen.still:  # errors that do not turn with the cam
                continue
            high = _climbed(position, off, screen, np.positive)
            low = _climbed(lambda *at: -position(*at), off, screen, np.negative)
            moved = np.maximum(moved, high.error + low.error)
        return moved

    def _beside_jumps(self, order: int) -> Iterator[float]:
        """Both sides of the jumps of a derivative, or a lower one: to first order it has an impulse there."""
        turn = self.cams.problem.programme.strokes[-1].end
        for jump in self.cams.problem.programme.jumps:
            if jump.order <= order:
                yield from (float(np.mod(jump.at + side * JUMP_SIDE, turn)) for side in (-1.0, 1.0))

    @cached_property
    def _screens(self) -> list[Screen]:
        """One for each order."""
        places = self.nodes(NODES)
        answers = self._answers(places)
        return [Screen(places, np.ascontiguousarray(answers[:, order])) for order in range(ORDERS)]

    @cached_property
    def _dwells(self) -> list[Screen]:
        """One for each dwell of the tool."""
        found = []
        for stroke in self.cams.problem.programme.tool.dwells:
            count = max(DWELL_NODES, ceil(OF_A_WAVE * self.cams.waves * stroke.angle / 6.0))
            places = np.linspace(stroke.start, stroke.end - JUMP_SIDE, count)
            found.append(Screen(places, np.ascontiguousarray(self._answers(places)[:, 0])))
        return found

    def _answers(self, places: FloatArray) -> FloatArray:
        """Those of the motion to each error, (errors, orders, places)."""
        answers = responses_of(self.cams.problem, places)
        return np.array([row for key in self.keys for row in answers.rows(key, self.cams.waves)])


def count_of(off: Off) -> int:
    """How many cams there are."""
    return len(next(iter(off.values())))


def taken(off: Off, index: IntArray | slice) -> Off:
    """Some of the cams."""
    return {key: each[index] for key, each in off.items()}


def _climbed(errors: Errors, off: Off, screen: Screen, outward: Outward) -> Largest:
    """The largest error of each cam, from what it is to first order at some places."""
    below, best, above = screen.tops(off, outward)
    between = np.clip(_top(below, best, above), below.place, above.place)
    return _larger(_at(errors, off, best.place), _at(errors, off, between))


def _at(errors: Errors, off: Off, places: FloatArray) -> Largest:
    return Largest(errors(off, places), places)


def _top(below: Largest, at: Largest, above: Largest) -> FloatArray:
    """Where the parabola through three values is largest; in the middle if it is no parabola."""
    a, b, c = below.place, at.place, above.place
    with np.errstate(all="ignore"):
        rise, fall = (at.error - below.error) / (b - a), (above.error - at.error) / (c - b)
        top = 0.5 * (a + b) - 0.5 * rise * (c - a) / (fall - rise)
    return np.where(np.isfinite(top), top, b)


def _larger(one: Largest, other: Largest) -> Largest:
    """The larger error of each cam; one that is no number is the largest."""
    second = ~(other.error <= one.error) & ~np.isnan(one.error)
    return Largest(*(np.where(second, b, a) for a, b in zip(one, other, strict=True)))


def _raised(found: Largest, some: IntArray, other: Largest) -> Largest:
    """With the larger error of each of some cams."""
    error, place = (each.copy() for each in found)
    error[some], place[some] = _larger(Largest(error[some], place[some]), other)
    return Largest(error, place)


def each_of(off: Off, work: Callable[[Off], Work], at_once: int = AT_ONCE) -> Iterator[Work]:
    """What work gives for some cams at a time, in their order."""
    count = count_of(off)
    parts = [taken(off, slice(first, first + at_once)) for first in range(0, count, at_once)]
    with ThreadPoolExecutor(THREADS) as pool:
        yield from pool.map(work, parts)


def _joined(parts: Iterator[Largest]) -> Largest:
    return Largest(*(np.concatenate(each) for each in zip(*parts, strict=True)))
