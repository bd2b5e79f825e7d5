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
from camopt.model.effects.error_response import RESPONSE_ORDERS
from camopt.model.motion.programme import JUMP_SIDE
from camopt.scene.problem.sample import sobol_points
from camopt.scene.problem.tolerance_zones import NumberErrors, number_and_angle_zones
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLE_TOLERANCES, DEVIATIONS_AT_CPK_1, Tolerance, ToleranceZone
from camopt.solve.tolerances.errors import CamErrors
from camopt.solve.tolerances.real_cam import RealCam
from camopt.solve.tolerances.response import motion_response

SCREEN_NODES = 480
"""Cam angles at which the first order is looked at, at least."""
NODES_OF_A_WAVE = 12
"""And in a wave of the profile's error."""
JOINT_NEARNESS = 2.0
"""How many steps between these a joint of the motion is away from the largest error that may be at it."""
DWELL_SCREEN_NODES = 24
EXACT_CAMS_AT_ONCE = 2**14
"""Cams: what is computed of them stays in the cache of a processor."""
SCREENED_CAMS_AT_ONCE = 2**8
"""Cams, likewise, of which the first order is looked at, at all cam angles."""
SAME_RESPONSE = 1e-12
"""Answers that are this near to each other, relative to the largest, are the same."""
THREADS = 2
SCANNED_CAMS = 50
"""Cams whose largest errors are compared with those of a dense scan."""
DENSE_FACTOR = 4
"""How many times as many cam angles that has."""
Work = TypeVar("Work")
ExactErrors = Callable[[CamErrors, FloatArray], FloatArray]
"""The errors of some cams, each where it is touched at a cam angle of its own."""
OutwardMeasure = Callable[[FloatArray], FloatArray]
"""What of errors is to be the largest: they, their magnitude, or what they are the other way."""


class LargestError(NamedTuple):
    """The largest |error| of each cam, and the place on the cam, rad; (n,) each."""

    error: FloatArray
    place: FloatArray


@dataclass(frozen=True)
class FirstOrderScreen:
    """Cam angles of a turn, or of a part of it, with the answers of the motion."""

    places: FloatArray
    """In their order, (m,)."""
    responses: FloatArray
    """(errors, m), of real and imaginary parts one after the other."""

    @cached_property
    def widest_step(self) -> float:
        """The largest step between places."""
        return float(np.diff(self.places).max())

    @property
    def is_constant(self) -> bool:
        """Whether errors are the same at all places."""
        return bool(np.ptp(self.responses, axis=1).max() <= SAME_RESPONSE * np.abs(self.responses).max())

    def first_order_peaks(self, off: CamErrors, outward: OutwardMeasure) -> list[LargestError]:
        """Where errors are the largest to first order: the place below, it, and the one above."""
        errors, beside, found = real_error_columns(off), np.array([[-1], [0], [1]]), []
        for first in range(0, len(errors), SCREENED_CAMS_AT_ONCE):
            values = outward(errors[first : first + SCREENED_CAMS_AT_ONCE] @ self.responses)
            index = np.clip(values.argmax(axis=1) + beside, 0, self.places.size - 1)
            found.append([np.take_along_axis(values, index.T, axis=1).T, self.places[index]])
        return [LargestError(*each) for each in zip(*np.concatenate(found, axis=2), strict=True)]


def real_error_columns(off: CamErrors) -> FloatArray:
    """The errors of cams as real numbers, (n, errors)."""
    found = [
        part for each in off.values() for part in ((each.real, each.imag) if np.iscomplexobj(each) else (each,))
    ]
    return np.column_stack(found)


@dataclass(frozen=True)
class LargestErrorSearch:
    """How to find the largest errors of cams."""

    real_cam: RealCam
    keys: tuple[str, ...]
    """Of the errors that cams have, in their order."""

    def largest_motion_errors(self, off: CamErrors, order: int) -> LargestError:
        """The largest |error| of position, velocity or acceleration of each cam."""
        return _join_largest_errors(map_cam_blocks(off, lambda some: self._motion_errors_of_block(some, order)))

    def largest_dwell_changes(self, off: CamErrors) -> FloatArray:
        """By how much the tool of each cam moves at most while its follower rests on the arc of one dwell, (n,)."""
        return np.concatenate([*map_cam_blocks(off, self._dwell_changes_of_block)])

    @property
    def has_dwells(self) -> bool:
        """Whether the tool dwells."""
        return bool(self._dwell_screens)

    def missed_error(self, off: CamErrors, order: int) -> float:
        """By how much the largest |errors| found are less than those of a dense scan, at most, of some cams."""
        count = count_cams(off)
        some = take_cams(off, np.unique(np.linspace(0, count - 1, SCANNED_CAMS).astype(int)))
        found, places = self._motion_errors_of_block(some, order).error, self.nodes(DENSE_FACTOR * SCREEN_NODES)
        errors = self._exact_error_magnitude(order)

        def scan_cams(few: CamErrors) -> FloatArray:
            every = {key: np.repeat(each, places.size) for key, each in few.items()}
            found = errors(every, np.tile(places, count_cams(few))).reshape(-1, places.size)
            return np.asarray(found.max(axis=1))

        highest = np.concatenate([*map_cam_blocks(some, scan_cams, ceil(EXACT_CAMS_AT_ONCE / places.size))])
        return float(np.max(np.maximum(highest - found, 0.0)))

    def nodes(self, count: int) -> FloatArray:
        """Cam angles in the order of the turn, at least so many, with both sides of each joint, rad."""
        end = self.real_cam.problem.programme.strokes[-1].end
        waves = NODES_OF_A_WAVE * self.real_cam.waves * count // SCREEN_NODES
        even = np.linspace(0.0, end, 2 + max(count, waves))[1:-1]
        sides = np.mod(np.add.outer([-2.0 * JUMP_SIDE, 2.0 * JUMP_SIDE], self._joints).ravel(), end)
        return np.unique(np.concatenate([even, sides]))

    def _exact_error_magnitude(self, order: int) -> ExactErrors:
        return lambda off, places: np.abs(self.real_cam.motion_errors(off, places, order))

    def _motion_errors_of_block(self, off: CamErrors, order: int) -> LargestError:
        screen, errors = self._turn_screens[order], self._exact_error_magnitude(order)
        found = _climb_to_peak(errors, off, screen, np.abs)
        for place in self._jump_sides(order):
            found = _larger_errors(found, _largest_at_places(errors, off, np.full(found.place.size, place)))
        away = np.abs(found.place[:, None] - self._joints)
        some = np.flatnonzero(away.min(axis=1) <= JOINT_NEARNESS * screen.widest_step)
        near, joint = take_cams(off, some), self._joints[away[some].argmin(axis=1)]
        for side in (-JUMP_SIDE, JUMP_SIDE):
            found = _raise_some_errors(
                found, some, _largest_at_places(errors, near, self._contact_places(near, joint + side))
            )
        return found

    @cached_property
    def _joints(self) -> FloatArray:
        """Where pieces of the motion meet, rad: a slope of it may jump, there on the cam and at that cam angle."""
        programme = self.real_cam.problem.programme
        return np.unique([*programme.starts, *(jump.at for jump in programme.jumps)])

    def largest_error_angle(self, off: CamErrors, largest: LargestError, cam: int) -> float:
        """The cam angle at which a cam has its largest error, deg."""
        one = slice(cam, cam + 1)
        touched = self.real_cam.contact_angles(take_cams(off, one), largest.place[one])
        return float(np.degrees(self.real_cam.angles_in_turn(touched)[0]))

    def errors_at_angle(self, off: CamErrors, angle: float, order: int) -> FloatArray:
        """The errors of cams at one cam angle, rad."""
        parts = map_cam_blocks(off, lambda some: self._angle_errors_of_block(some, angle, order))
        return np.concatenate([*parts])

    def _angle_errors_of_block(self, off: CamErrors, angle: float, order: int) -> FloatArray:
        return self.real_cam.motion_errors(off, self._contact_places(off, np.full(count_cams(off), angle)), order)

    def _contact_places(self, off: CamErrors, angles: FloatArray) -> FloatArray:
        return self.real_cam.contact_places(off, angles)

    def _dwell_changes_of_block(self, off: CamErrors) -> FloatArray:
        def position(off: CamErrors, places: FloatArray) -> FloatArray:
            return self.real_cam.tool_positions(off, places)

        moved = np.zeros(count_cams(off))
        for screen in self._dwell_screens:
            if screen.is_constant:  # errors that do not turn with the cam
                continue
            high = _climb_to_peak(position, off, screen, np.positive)
            low = _climb_to_peak(lambda *at: -position(*at), off, screen, np.negative)
            moved = np.maximum(moved, high.error + low.error)
        return moved

    def _jump_sides(self, order: int) -> Iterator[float]:
        """Both sides of the jumps of a derivative, or a lower one: to first order it has an impulse there."""
        turn = self.real_cam.problem.programme.strokes[-1].end
        for jump in self.real_cam.problem.programme.jumps:
            if jump.order <= order:
                yield from (float(np.mod(jump.at + side * JUMP_SIDE, turn)) for side in (-1.0, 1.0))

    @cached_property
    def _turn_screens(self) -> list[FirstOrderScreen]:
        """One for each order."""
        places = self.nodes(SCREEN_NODES)
        answers = self._motion_responses(places)
        return [
            FirstOrderScreen(places, np.ascontiguousarray(answers[:, order])) for order in range(RESPONSE_ORDERS)
        ]

    @cached_property
    def _dwell_screens(self) -> list[FirstOrderScreen]:
        """One for each dwell of the tool."""
        found = []
        for stroke in self.real_cam.problem.programme.tool.dwells:
            count = max(DWELL_SCREEN_NODES, ceil(NODES_OF_A_WAVE * self.real_cam.waves * stroke.angle / 6.0))
            places = np.linspace(stroke.start, stroke.end - JUMP_SIDE, count)
            found.append(FirstOrderScreen(places, np.ascontiguousarray(self._motion_responses(places)[:, 0])))
        return found

    def _motion_responses(self, places: FloatArray) -> FloatArray:
        """Those of the motion to each error, (errors, orders, places)."""
        answers = motion_response(self.real_cam.problem, places)
        return np.array([row for key in self.keys for row in answers.response_rows(key, self.real_cam.waves)])


def count_cams(off: CamErrors) -> int:
    """How many cams there are."""
    return len(next(iter(off.values())))


def take_cams(off: CamErrors, index: IntArray | slice) -> CamErrors:
    """Some of the cams."""
    return {key: each[index] for key, each in off.items()}


def _climb_to_peak(
    errors: ExactErrors, off: CamErrors, screen: FirstOrderScreen, outward: OutwardMeasure
) -> LargestError:
    """The largest error of each cam, from what it is to first order at some places."""
    below, best, above = screen.first_order_peaks(off, outward)
    between = np.clip(_parabola_top(below, best, above), below.place, above.place)
    return _larger_errors(_largest_at_places(errors, off, best.place), _largest_at_places(errors, off, between))


def _largest_at_places(errors: ExactErrors, off: CamErrors, places: FloatArray) -> LargestError:
    return LargestError(errors(off, places), places)


def _parabola_top(below: LargestError, at: LargestError, above: LargestError) -> FloatArray:
    """Where the parabola through three values is largest; in the middle if it is no parabola."""
    a, b, c = below.place, at.place, above.place
    with np.errstate(all="ignore"):
        rise, fall = (at.error - below.error) / (b - a), (above.error - at.error) / (c - b)
        top = 0.5 * (a + b) - 0.5 * rise * (c - a) / (fall - rise)
    return np.where(np.isfinite(top), top, b)


def _larger_errors(one: LargestError, other: LargestError) -> LargestError:
    """The larger error of each cam; one that is no number is the largest."""
    second = ~(other.error <= one.error) & ~np.isnan(one.error)
    return LargestError(*(np.where(second, b, a) for a, b in zip(one, other, strict=True)))


def _raise_some_errors(found: LargestError, some: IntArray, other: LargestError) -> LargestError:
    """With the larger error of each of some cams."""
    error, place = (each.copy() for each in found)
    error[some], place[some] = _larger_errors(LargestError(error[some], place[some]), other)
    return LargestError(error, place)


def map_cam_blocks(
    off: CamErrors, work: Callable[[CamErrors], Work], at_once: int = EXACT_CAMS_AT_ONCE
) -> Iterator[Work]:
    """What work gives for some cams at a time, in their order."""
    count = count_cams(off)
    parts = [take_cams(off, slice(first, first + at_once)) for first in range(0, count, at_once)]
    with ThreadPoolExecutor(THREADS) as pool:
        yield from pool.map(work, parts)


def _join_largest_errors(parts: Iterator[LargestError]) -> LargestError:
    return LargestError(*(np.concatenate(each) for each in zip(*parts, strict=True)))


COMPLEX_PARTS = {"profile": ("cosine", "sine"), "bore_eccentricity": ("x", "y")}
"""What the two parts of an error are that is a complex number."""
BATCH_GRID = 256
"""Shares of batches, and of parts of a batch, for what errors of one batch have in common."""
OPEN_SHARE_RANGE = 2.0**-60, 1.0 - 2.0**-53
"""Shares that are not 0 or 1."""
SampledErrors = dict[str, FloatArray]


def single_key(key: str) -> Iterable[str]:
    return (key,)


def sample_errors(
    scene: Scene, nominal: NumberErrors, cams: int, seed: int, each_of: Callable[[str], Iterable[str]] = single_key
) -> SampledErrors:
    """The errors of cams, by key of ``[tolerances]``, in mm or rad, of numbers in their units; those with two parts
    are complex. ``each_of`` says which errors a tolerance is of, where it is of several."""
    made, given = dict(_error_makers(scene, nominal)), scene.tolerances.number_and_angle_tolerances
    of = {part: key for key in made for part in each_of(key)}
    makers = {part: made[key] for part, key in of.items()}
    batches = sorted({each.batch for each in given.values() if each.batch is not None})
    count = sum(each for each, _ in makers.values())
    points = sobol_points(count + len(batches), cams, seed).T
    own, common = iter(points[:count]), dict(zip(batches, points[count:], strict=True))
    found = SampledErrors()
    for key, (parts, make) in makers.items():
        shares = [next(own) for _ in range(parts)]
        if of[key] in given and (batch := given[of[key]].batch) is not None:
            shares = [_correlate_with_batch(shares[0], common[batch], given[of[key]].shared)]
        found[key] = make(*shares)
    return found


ErrorMaker = tuple[int, Callable[..., FloatArray]]
"""How many points an error takes, and the error by the shares of all cams that are below it."""


def _error_makers(scene: Scene, nominal: NumberErrors) -> Iterator[tuple[str, ErrorMaker]]:
    given = scene.tolerances
    for key, zone in number_and_angle_zones(scene, nominal).items():
        yield (
            key,
            (
                1,
                partial(
                    _tolerance_quantile,
                    given.number_and_angle_tolerances[key],
                    zone,
                    radians(1.0) if key in ANGLE_TOLERANCES else 1.0,
                ),
            ),
        )
    if given.profile:
        yield (
            "profile",
            _complex_error_maker(given.profile)
            if given.waves
            else (1, partial(_normal_quantile, _symmetric_zone(given.profile))),
        )
    if given.bore_eccentricity:
        yield "bore_eccentricity", _complex_error_maker(given.bore_eccentricity)


def _correlate_with_batch(own: FloatArray, common: FloatArray, shared: float) -> FloatArray:
    """Shares of normal numbers of which a part of the variance is that of the batch."""
    first, second = (scipy.special.ndtri(np.clip(each, *OPEN_SHARE_RANGE)) for each in (common, own))
    return np.asarray(scipy.special.ndtr(np.sqrt(shared) * first + np.sqrt(1.0 - shared) * second))


def batch_mean_errors(given: Tolerance, zone: ToleranceZone, unit: float = 1.0) -> FloatArray:
    """The mean error of the parts of a batch, at even shares of batches, less that of all: (m,)."""
    z = scipy.special.ndtri((np.arange(BATCH_GRID) + 0.5) / BATCH_GRID)
    z = z / np.std(z)
    own = scipy.special.ndtr(np.sqrt(given.shared) * z[:, None] + np.sqrt(1.0 - given.shared) * z)
    means = _tolerance_quantile(given, zone, unit, own).mean(axis=1)
    return np.asarray(means - means.mean())


def _symmetric_zone(size: float) -> ToleranceZone:
    return ToleranceZone(-size, size, size / DEVIATIONS_AT_CPK_1)


def _complex_error_maker(size: float) -> ErrorMaker:
    of = partial(_normal_quantile, _symmetric_zone(size))
    return 2, lambda real, imaginary: np.asarray(of(real) + 1j * of(imaginary))


def _tolerance_quantile(given: Tolerance, zone: ToleranceZone, unit: float, share: FloatArray) -> FloatArray:
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
    return _normal_quantile(zone, share)


def _normal_quantile(zone: ToleranceZone, share: FloatArray) -> FloatArray:
    return np.asarray(zone.mean + zone.deviation * scipy.special.ndtri(np.clip(share, *OPEN_SHARE_RANGE)))


def exceed_tolerances(errors: CamErrors, ends: Mapping[str, tuple[float, float]]) -> BoolArray:
    """Whether cams have an error outside of its tolerance, by the ends of each (``touching.error_ranges``)."""
    found = np.zeros(next(iter(errors.values())).size, dtype=bool)
    for key, value in errors.items():
        low, high = ends[key]
        found |= np.abs(value) > high if np.iscomplexobj(value) else (value < low) | (value > high)
    return found


def real_error_parts(errors: CamErrors) -> SampledErrors:
    """The errors as real numbers, by key and part, as ``bore_eccentricity.x``; mm, or deg of angles."""
    found: SampledErrors = {}
    for key, value in errors.items():
        if np.iscomplexobj(value):
            names = COMPLEX_PARTS[key.partition(" ")[0]]
            found |= {f"{key}.{part}": each for part, each in zip(names, (value.real, value.imag), strict=True)}
        else:
            found[key] = np.degrees(value) if key in ANGLE_TOLERANCES else value
    return found
