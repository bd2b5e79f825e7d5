"""The largest error of the motion of each of many cams, exact at its cam angle.

Where it is, the first order says: the answers of the motion at some cam angles times the errors of a cam, one
matrix product for all cams. There the exact error is computed, and at the top of the parabola through these of
three places; where that is beside a joint of the motion, at the joint too. What is found is the true error of the
cam at some angle, and so never more than its largest one; ``missed`` says by how much it is less on some of the
cams, by a dense scan of exact errors.

Errors of cams, drawn as ``[tolerances]`` says by scrambled Sobol points.

A number has the distribution of its tolerance over its zone. The profile and the axis of the bore, whose tolerances
are a zone to either side and a distance, have two normal parts each with a third of it as standard deviation: at
each place of the profile, and in each direction of the axis, 99.73 % of the cams are within. Nothing is cut off a
normal distribution: some cams are outside of the tolerances, and no proof is of these. Measured errors are drawn as
they are, each as often as the others.

Errors of one batch go together: the share s of the variance of a normal number is that of the batch,

    z = √s·z_batch + √(1 − s)·z_own

and the error is where a share Φ(z) of its own distribution is below. Two normal errors have the correlation
√(s₁·s₂); of others it is a little less.

Source: A. B. Owen, Scrambling Sobol' and Niederreiter-Xing points, J. Complexity 14 (1998).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, partial
from math import ceil, radians
from typing import NamedTuple, TypeVar

import numpy as np
import scipy

from camopt.core.numerics import BoolArray, FloatArray, IntArray
from camopt.model.effects.answers import ORDERS
from camopt.model.motion.programme import JUMP_SIDE
from camopt.scene.problem.sample import sobol
from camopt.scene.problem.zones import Off, error_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLES, WITHIN, Tolerance, Zone
from camopt.solve.tolerances.errors import CutErrors
from camopt.solve.tolerances.real_cam import RealCam
from camopt.solve.tolerances.response import responses_of

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
Errors = Callable[[CutErrors, FloatArray], FloatArray]
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

    def tops(self, off: CutErrors, outward: Outward) -> list[Largest]:
        """Where errors are the largest to first order: the place below, it, and the one above."""
        errors, beside, found = columns(off), np.array([[-1], [0], [1]]), []
        for first in range(0, len(errors), SCREENED):
            values = outward(errors[first : first + SCREENED] @ self.answers)
            index = np.clip(values.argmax(axis=1) + beside, 0, self.places.size - 1)
            found.append([np.take_along_axis(values, index.T, axis=1).T, self.places[index]])
        return [Largest(*each) for each in zip(*np.concatenate(found, axis=2), strict=True)]


def columns(off: CutErrors) -> FloatArray:
    """The errors of cams as real numbers, (n, errors)."""
    found = [
        part for each in off.values() for part in ((each.real, each.imag) if np.iscomplexobj(each) else (each,))
    ]
    return np.column_stack(found)


@dataclass(frozen=True)
class LargestErrors:
    """How to find the largest errors of cams."""

    cams: RealCam
    keys: tuple[str, ...]
    """Of the errors that cams have, in their order."""

    def of_motion(self, off: CutErrors, order: int) -> Largest:
        """The largest |error| of position, velocity or acceleration of each cam."""
        return _joined(each_of(off, lambda some: self._of_motion(some, order)))

    def of_dwells(self, off: CutErrors) -> FloatArray:
        """By how much the tool of each cam moves at most while its follower rests on the arc of one dwell, (n,)."""
        return np.concatenate([*each_of(off, self._of_dwells)])

    @property
    def has_dwells(self) -> bool:
        """Whether the tool dwells."""
        return bool(self._dwells)

    def missed(self, off: CutErrors, order: int) -> float:
        """By how much the largest |errors| found are less than those of a dense scan, at most, of some cams."""
        count = count_of(off)
        some = taken(off, np.unique(np.linspace(0, count - 1, SCANNED).astype(int)))
        found, places = self._of_motion(some, order).error, self.nodes(DENSE * NODES)
        errors = self._exact(order)

        def scanned(few: CutErrors) -> FloatArray:
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

    def _of_motion(self, off: CutErrors, order: int) -> Largest:
        screen, errors = self._screens[order], self._exact(order)
        found = _climbed(errors, off, screen, np.abs)
        for place in self._beside_jumps(order):
            found = _larger(found, _at(errors, off, np.full(found.place.size, place)))
        away = np.abs(found.place[:, None] - self._joints)
        some = np.flatnonzero(away.min(axis=1) <= NEAR * screen.widest)
        near, joint = taken(off, some), self._joints[away[some].argmin(axis=1)]
        for side in (-JUMP_SIDE, JUMP_SIDE):
            found = _raised(found, some, _at(errors, near, self._touched(near, joint + side)))
        return found

    @cached_property
    def _joints(self) -> FloatArray:
        """Where pieces of the motion meet, rad: a slope of it may jump, there on the cam and at that cam angle."""
        programme = self.cams.problem.programme
        return np.unique([*programme.starts, *(jump.at for jump in programme.jumps)])

    def angle(self, off: CutErrors, largest: Largest, cam: int) -> float:
        """The cam angle at which a cam has its largest error, deg."""
        one = slice(cam, cam + 1)
        touched = self.cams.angle(taken(off, one), largest.place[one])
        return float(np.degrees(self.cams.within(touched)[0]))

    def at(self, off: CutErrors, angle: float, order: int) -> FloatArray:
        """The errors of cams at one cam angle, rad."""
        parts = each_of(off, lambda some: self._at_angle(some, angle, order))
        return np.concatenate([*parts])

    def _at_angle(self, off: CutErrors, angle: float, order: int) -> FloatArray:
        return self.cams.errors(off, self._touched(off, np.full(count_of(off), angle)), order)

    def _touched(self, off: CutErrors, angles: FloatArray) -> FloatArray:
        return self.cams.touched(off, angles)

    def _of_dwells(self, off: CutErrors) -> FloatArray:
        def position(off: CutErrors, places: FloatArray) -> FloatArray:
            return self.cams.position(off, places)

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


def count_of(off: CutErrors) -> int:
    """How many cams there are."""
    return len(next(iter(off.values())))


def taken(off: CutErrors, index: IntArray | slice) -> CutErrors:
    """Some of the cams."""
    return {key: each[index] for key, each in off.items()}


def _climbed(errors: Errors, off: CutErrors, screen: Screen, outward: Outward) -> Largest:
    """The largest error of each cam, from what it is to first order at some places."""
    below, best, above = screen.tops(off, outward)
    between = np.clip(_top(below, best, above), below.place, above.place)
    return _larger(_at(errors, off, best.place), _at(errors, off, between))


def _at(errors: Errors, off: CutErrors, places: FloatArray) -> Largest:
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


def each_of(off: CutErrors, work: Callable[[CutErrors], Work], at_once: int = AT_ONCE) -> Iterator[Work]:
    """What work gives for some cams at a time, in their order."""
    count = count_of(off)
    parts = [taken(off, slice(first, first + at_once)) for first in range(0, count, at_once)]
    with ThreadPoolExecutor(THREADS) as pool:
        yield from pool.map(work, parts)


def _joined(parts: Iterator[Largest]) -> Largest:
    return Largest(*(np.concatenate(each) for each in zip(*parts, strict=True)))


PARTS = {"profile": ("cosine", "sine"), "bore_eccentricity": ("x", "y")}
"""What the two parts of an error are that is a complex number."""
GRID = 256
"""Shares of batches, and of parts of a batch, for what errors of one batch have in common."""
INSIDE = 2.0**-60, 1.0 - 2.0**-53
"""Shares that are not 0 or 1."""
Drawn = dict[str, FloatArray]


def itself(key: str) -> Iterable[str]:
    return (key,)


def drawn(
    scene: Scene, nominal: Off, cams: int, seed: int, each_of: Callable[[str], Iterable[str]] = itself
) -> Drawn:
    """The errors of cams, by key of ``[tolerances]``, in mm or rad, of numbers in their units; those with two parts
    are complex. ``each_of`` says which errors a tolerance is of, where it is of several."""
    made, given = dict(_makers(scene, nominal)), scene.tolerances.spread
    of = {part: key for key in made for part in each_of(key)}
    makers = {part: made[key] for part, key in of.items()}
    batches = sorted({each.batch for each in given.values() if each.batch is not None})
    count = sum(each for each, _ in makers.values())
    points = sobol(count + len(batches), cams, seed).T
    own, common = iter(points[:count]), dict(zip(batches, points[count:], strict=True))
    found = Drawn()
    for key, (parts, make) in makers.items():
        shares = [next(own) for _ in range(parts)]
        if of[key] in given and (batch := given[of[key]].batch) is not None:
            shares = [_in_batch(shares[0], common[batch], given[of[key]].shared)]
        found[key] = make(*shares)
    return found


Maker = tuple[int, Callable[..., FloatArray]]
"""How many points an error takes, and the error by the shares of all cams that are below it."""


def _makers(scene: Scene, nominal: Off) -> Iterator[tuple[str, Maker]]:
    given = scene.tolerances
    for key, zone in error_zones(scene, nominal).items():
        yield key, (1, partial(_quantile, given.spread[key], zone, radians(1.0) if key in ANGLES else 1.0))
    if given.profile:
        yield "profile", _of_parts(given.profile) if given.waves else (1, partial(_normal, _either(given.profile)))
    if given.bore_eccentricity:
        yield "bore_eccentricity", _of_parts(given.bore_eccentricity)


def _in_batch(own: FloatArray, common: FloatArray, shared: float) -> FloatArray:
    """Shares of normal numbers of which a part of the variance is that of the batch."""
    first, second = (scipy.special.ndtri(np.clip(each, *INSIDE)) for each in (common, own))
    return np.asarray(scipy.special.ndtr(np.sqrt(shared) * first + np.sqrt(1.0 - shared) * second))


def shared_part(given: Tolerance, zone: Zone, unit: float = 1.0) -> FloatArray:
    """The mean error of the parts of a batch, at even shares of batches, less that of all: (m,)."""
    z = scipy.special.ndtri((np.arange(GRID) + 0.5) / GRID)
    z = z / np.std(z)
    own = scipy.special.ndtr(np.sqrt(given.shared) * z[:, None] + np.sqrt(1.0 - given.shared) * z)
    means = _quantile(given, zone, unit, own).mean(axis=1)
    return np.asarray(means - means.mean())


def _either(size: float) -> Zone:
    return Zone(-size, size, size / WITHIN)


def _of_parts(size: float) -> Maker:
    of = partial(_normal, _either(size))
    return 2, lambda real, imaginary: np.asarray(of(real) + 1j * of(imaginary))


def _quantile(given: Tolerance, zone: Zone, unit: float, share: FloatArray) -> FloatArray:
    """Where a share of the parts is below, of the distribution of a tolerance over its zone."""
    if given.values is not None:
        values = unit * np.sort(given.values)
        return np.asarray(values[np.minimum((share * values.size).astype(int), values.size - 1)])
    if given.distribution == "uniform":
        return np.asarray(zone.lower + share * (zone.upper - zone.lower))
    if given.distribution == "triangular":
        half = (zone.upper - zone.lower) / 2.0
        nearest = np.sqrt(2.0 * np.minimum(share, 1.0 - share))
        return np.asarray(zone.mean + np.sign(share - 0.5) * half * (1.0 - nearest))
    return _normal(zone, share)


def _normal(zone: Zone, share: FloatArray) -> FloatArray:
    return np.asarray(zone.mean + zone.deviation * scipy.special.ndtri(np.clip(share, *INSIDE)))


def beyond(errors: CutErrors, ends: Mapping[str, tuple[float, float]]) -> BoolArray:
    """Whether cams have an error outside of its tolerance, by the ends of each (``touching.error_ends``)."""
    found = np.zeros(next(iter(errors.values())).size, dtype=bool)
    for key, value in errors.items():
        low, high = ends[key]
        found |= np.abs(value) > high if np.iscomplexobj(value) else (value < low) | (value > high)
    return found


def parts_of(errors: CutErrors) -> Drawn:
    """The errors as real numbers, by key and part, as ``bore_eccentricity.x``; mm, or deg of angles."""
    found: Drawn = {}
    for key, value in errors.items():
        if np.iscomplexobj(value):
            names = PARTS[key.partition(" ")[0]]
            found |= {f"{key}.{part}": each for part, each in zip(names, (value.real, value.imag), strict=True)}
        else:
            found[key] = np.degrees(value) if key in ANGLES else value
    return found
