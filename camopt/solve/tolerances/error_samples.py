"""Random errors of many cams, and the largest error of the motion of each.

**Largest error.** The first order locates it: responses of the motion at many cam angles times the errors of the
cams, one matrix product for all cams. The exact error is computed there, and at the top of the parabola through
three neighbours. If the place is beside a joint of the motion, the joint is tried too. The result is the true error
of the cam at some angle, so it never exceeds the largest one. ``error_missed_by_search`` tells by a dense scan of
some cams how much it falls short.

**Random errors** come from scrambled Sobol points. A number has the distribution of its tolerance over its zone.
The errors of the profile and of the bore's axis have two normal parts, each with a third of the tolerance as
standard deviation. So at each place of the profile, and in each direction of the axis, 99.73 % of the cams are
within. Normal distributions are not truncated: some cams are outside of the tolerances, and no proof covers these.
Measured errors are drawn with equal probability.

Errors of one batch are correlated. A share s of the variance of a normal number belongs to the batch,

    z = √s·z_batch + √(1 − s)·z_own

and the error is the quantile Φ(z) of its own distribution. Two normal errors have the correlation √(s₁·s₂); for
other distributions it is slightly less.

Source: A. B. Owen, Scrambling Sobol' and Niederreiter-Xing points, J. Complexity 14 (1998).
"""

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import product
from math import ceil, radians
from typing import NamedTuple, TypeVar

import numpy as np
import scipy

from camopt.core.numerics import BoolArray, FloatArray, IntArray
from camopt.model.effects.error_response import RESPONSE_ORDERS
from camopt.model.motion.programme import JUMP_SIDE
from camopt.scene.problem.problem import Problem
from camopt.scene.problem.sample import sobol_points
from camopt.scene.problem.tolerance_zones import NumberErrors, tolerance_zones_of_numbers_and_angles
from camopt.scene.scene import Scene
from camopt.scene.tolerances import ANGLE_TOLERANCES, DEVIATIONS_AT_CPK_1, Tolerance, ToleranceZone
from camopt.solve.tolerances.errors import CamErrors, error_keys_at_contacts
from camopt.solve.tolerances.real_cam import RealCam
from camopt.solve.tolerances.response import motion_response

SCREEN_NODES = 480
"""Least number of cam angles at which the first order is computed."""
NODES_OF_A_WAVE = 12
"""Least number of cam angles in a wave of the profile's error."""
JOINT_NEARNESS = 2.0
"""A joint of the motion is tried if it is at most this many steps from the largest error."""
DWELL_SCREEN_NODES = 24
EXACT_CAMS_AT_ONCE = 2**14
"""Cams in a block whose exact errors stay in the cache of a processor."""
SCREENED_CAMS_AT_ONCE = 2**8
"""Cams in a block whose first-order errors at all cam angles stay in the cache."""
SAME_RESPONSE = 1e-12
"""Responses are equal if they differ by less, relative to the largest."""
THREADS = 2
SCANNED_CAMS = 50
"""Number of cams whose largest errors are compared with a dense scan."""
DENSE_FACTOR = 4
"""Factor of the number of cam angles in the dense scan."""
Work = TypeVar("Work")
ExactErrors = Callable[[CamErrors, FloatArray], FloatArray]
"""Computes the error of each cam, at the contact with its own place."""
OutwardMeasure = Callable[[FloatArray], FloatArray]
"""The measure of errors to maximise: the error, its magnitude, or its negative."""


class LargestError(NamedTuple):
    """Largest |error| of each cam, and the place on the cam [rad], both of shape (cams,)."""

    error: FloatArray
    place: FloatArray


class FirstOrderScreen(NamedTuple):
    """Cam angles of a turn, or of a part of it, with the first-order response of the motion."""

    places: FloatArray
    """Rising cam angles [rad]."""
    responses: FloatArray
    """Shape (errors, places); real and imaginary parts are separate errors."""


def real_error_columns(cams: CamErrors) -> FloatArray:
    """Errors of cams as real numbers, shape (cams, errors)."""
    return np.column_stack(
        [part for each in cams.values() for part in ((each.real, each.imag) if np.iscomplexobj(each) else (each,))]
    )


@dataclass(frozen=True)
class LargestErrorSearch:
    """Finds the largest errors of the motion of many cams."""

    real_cam: RealCam
    keys: tuple[str, ...]
    """Keys of the errors of the cams, in their order."""

    def largest_motion_errors(self, cams: CamErrors, order: int) -> LargestError:
        """Largest |error| of position, velocity or acceleration (order 0, 1, 2) of each cam over the turn."""
        blocks = map_cam_blocks(cams, lambda block: self._motion_errors_of_block(block, order))
        return LargestError(*(np.concatenate(each) for each in zip(*blocks, strict=True)))

    def largest_dwell_changes(self, cams: CamErrors) -> FloatArray:
        """Largest movement of each cam's tool while its follower rests on the arc of one dwell, shape (cams,)."""
        return np.concatenate([*map_cam_blocks(cams, self._dwell_changes_of_block)])

    def error_missed_by_search(self, cams: CamErrors, order: int) -> float:
        """Largest difference between a dense scan and the largest error found, over a sample of the cams."""
        sample = take_cams(cams, np.unique(np.linspace(0, count_cams(cams) - 1, SCANNED_CAMS).astype(int)))
        largest, places = (
            self._motion_errors_of_block(sample, order).error,
            self.cam_angles_with_joint_sides(DENSE_FACTOR * SCREEN_NODES),
        )
        exact = self._exact_error_magnitude_function(order)

        def largest_errors_of_dense_scan(block: CamErrors) -> FloatArray:
            repeated = {key: np.repeat(each, places.size) for key, each in block.items()}
            errors = exact(repeated, np.tile(places, count_cams(block))).reshape(-1, places.size)
            return np.asarray(errors.max(axis=1))

        highest = np.concatenate(
            [*map_cam_blocks(sample, largest_errors_of_dense_scan, ceil(EXACT_CAMS_AT_ONCE / places.size))]
        )
        return float(np.max(np.maximum(highest - largest, 0.0)))

    def cam_angles_with_joint_sides(self, count: int) -> FloatArray:
        """At least ``count`` cam angles in the order of the turn, with both sides of each joint [rad]."""
        end = self.real_cam.problem.programme.strokes[-1].end
        waves = NODES_OF_A_WAVE * self.real_cam.waves * count // SCREEN_NODES
        even = np.linspace(0.0, end, 2 + max(count, waves))[1:-1]
        sides = np.mod(np.add.outer([-2.0 * JUMP_SIDE, 2.0 * JUMP_SIDE], self._joints).ravel(), end)
        return np.unique(np.concatenate([even, sides]))

    def _exact_error_magnitude_function(self, order: int) -> ExactErrors:
        return lambda cams, places: np.abs(self.real_cam.motion_errors(cams, places, order))

    def _motion_errors_of_block(self, cams: CamErrors, order: int) -> LargestError:
        screen, exact = self._turn_screens_by_order[order], self._exact_error_magnitude_function(order)
        largest, programme = _largest_error_about_peak(exact, cams, screen, np.abs), self.real_cam.problem.programme
        jumps = [jump.at for jump in programme.jumps if jump.order <= order]  # there the derivative has an impulse
        for at, side in product(jumps, (-1.0, 1.0)):
            place = float(np.mod(at + side * JUMP_SIDE, programme.strokes[-1].end))
            at_jump = _exact_errors_at_places(exact, cams, np.full(largest.place.size, place))
            largest = _larger_errors(largest, at_jump)
        distance = np.abs(largest.place[:, None] - self._joints)
        index = np.flatnonzero(distance.min(axis=1) <= JOINT_NEARNESS * np.diff(screen.places).max())
        near, joint = take_cams(cams, index), self._joints[distance[index].argmin(axis=1)]
        at_joint = LargestError(largest.error[index], largest.place[index])
        for side in (-JUMP_SIDE, JUMP_SIDE):
            places = self.real_cam.contact_places(near, joint + side)
            at_joint = _larger_errors(at_joint, _exact_errors_at_places(exact, near, places))
        largest.error[index], largest.place[index] = at_joint
        return largest

    @cached_property
    def _joints(self) -> FloatArray:
        """Cam angles at which pieces of the motion meet [rad]: a derivative may jump there."""
        programme = self.real_cam.problem.programme
        return np.unique([*programme.piece_starts, *(jump.at for jump in programme.jumps)])

    def errors_at_angle(self, cams: CamErrors, angle: float, order: int) -> FloatArray:
        """Errors of cams at one cam angle (rad)."""

        def errors_of_block(block: CamErrors) -> FloatArray:
            places = self.real_cam.contact_places(block, np.full(count_cams(block), angle))
            return self.real_cam.motion_errors(block, places, order)

        return np.concatenate([*map_cam_blocks(cams, errors_of_block)])

    def _dwell_changes_of_block(self, cams: CamErrors) -> FloatArray:
        position, changes = self.real_cam.tool_positions, np.zeros(count_cams(cams))
        for screen in self._screens_by_dwell:
            spread = np.ptp(screen.responses, axis=1).max()
            if spread <= SAME_RESPONSE * np.abs(screen.responses).max():  # the errors do not turn with the cam
                continue
            high = _largest_error_about_peak(position, cams, screen, np.positive)
            low = _largest_error_about_peak(lambda *at: -position(*at), cams, screen, np.negative)
            changes = np.maximum(changes, high.error + low.error)
        return changes

    @cached_property
    def _turn_screens_by_order(self) -> list[FirstOrderScreen]:
        """One screen for each order."""
        places = self.cam_angles_with_joint_sides(SCREEN_NODES)
        responses = self._motion_responses(places)
        return [
            FirstOrderScreen(places, np.ascontiguousarray(responses[:, order])) for order in range(RESPONSE_ORDERS)
        ]

    @cached_property
    def _screens_by_dwell(self) -> list[FirstOrderScreen]:
        """One screen for each dwell of the tool."""
        screens = []
        for stroke in self.real_cam.problem.programme.tool.dwells:
            count = max(DWELL_SCREEN_NODES, ceil(NODES_OF_A_WAVE * self.real_cam.waves * stroke.angle / 6.0))
            places = np.linspace(stroke.start, stroke.end - JUMP_SIDE, count)
            screens.append(FirstOrderScreen(places, np.ascontiguousarray(self._motion_responses(places)[:, 0])))
        return screens

    def _motion_responses(self, places: FloatArray) -> FloatArray:
        """First-order response of the motion to each error, shape (errors, orders, places)."""
        response = motion_response(self.real_cam.problem, places)
        return np.array([row for key in self.keys for row in response.response_rows(key, self.real_cam.waves)])


def count_cams(cams: CamErrors) -> int:
    return len(next(iter(cams.values())))


def take_cams(cams: CamErrors, index: IntArray | slice) -> CamErrors:
    """The cams of an index or a slice."""
    return {key: each[index] for key, each in cams.items()}


def _largest_error_about_peak(
    exact: ExactErrors, cams: CamErrors, screen: FirstOrderScreen, outward: OutwardMeasure
) -> LargestError:
    """Largest error of each cam, at the first-order peak or at the top of the parabola about it."""
    errors, beside, blocks = real_error_columns(cams), np.array([[-1], [0], [1]]), []
    for first in range(0, len(errors), SCREENED_CAMS_AT_ONCE):  # the peak, and the places before and after it
        values = outward(errors[first : first + SCREENED_CAMS_AT_ONCE] @ screen.responses)
        index = np.clip(values.argmax(axis=1) + beside, 0, screen.places.size - 1)
        blocks.append([np.take_along_axis(values, index.T, axis=1).T, screen.places[index]])
    below, best, above = (LargestError(*each) for each in zip(*np.concatenate(blocks, axis=2), strict=True))
    between = np.clip(_place_of_parabola_top(below, best, above), below.place, above.place)
    return _larger_errors(
        _exact_errors_at_places(exact, cams, best.place), _exact_errors_at_places(exact, cams, between)
    )


def _exact_errors_at_places(exact: ExactErrors, cams: CamErrors, places: FloatArray) -> LargestError:
    return LargestError(exact(cams, places), places)


def _place_of_parabola_top(below: LargestError, at: LargestError, above: LargestError) -> FloatArray:
    """Place of the largest value of the parabola through three points; the middle one if there is no parabola."""
    a, b, c = below.place, at.place, above.place
    with np.errstate(all="ignore"):
        rise, fall = (at.error - below.error) / (b - a), (above.error - at.error) / (c - b)
        top = 0.5 * (a + b) - 0.5 * rise * (c - a) / (fall - rise)
    return np.where(np.isfinite(top), top, b)


def _larger_errors(one: LargestError, other: LargestError) -> LargestError:
    """The larger error of each cam; NaN counts as the largest."""
    second = ~(other.error <= one.error) & ~np.isnan(one.error)
    return LargestError(*(np.where(second, b, a) for a, b in zip(one, other, strict=True)))


def map_cam_blocks(
    cams: CamErrors, evaluate_block: Callable[[CamErrors], Work], block_size: int = EXACT_CAMS_AT_ONCE
) -> Iterator[Work]:
    """Results of a function for blocks of cams, in their order."""
    blocks = [take_cams(cams, slice(first, first + block_size)) for first in range(0, count_cams(cams), block_size)]
    with ThreadPoolExecutor(THREADS) as pool:
        yield from pool.map(evaluate_block, blocks)


COMPLEX_PARTS = {"profile": ("cosine", "sine"), "bore_eccentricity": ("x", "y")}
"""Names of the real and imaginary part of a complex error."""
BATCH_GRID = 256
"""Number of quantiles of batches, and of parts of a batch, for the mean errors of batches."""
OPEN_SHARE_RANGE = 2.0**-60, 1.0 - 2.0**-53
"""Least and largest share that is not 0 or 1."""
SampledErrors = dict[str, FloatArray]


def sample_errors(scene: Scene, problem: Problem, cams: int, seed: int) -> SampledErrors:
    """Random errors of cams by key of ``[tolerances]``: mm or rad, numbers in their own units.

    Errors with two parts are complex.
    """
    makers = dict(_error_samplers(scene, problem.nominal_numbers))
    tolerances = scene.tolerances.number_and_angle_tolerances
    tolerance_keys = {key: tolerance for tolerance in makers for key in error_keys_at_contacts(problem, tolerance)}
    batches = sorted({each.batch for each in tolerances.values() if each.batch is not None})
    count = sum(makers[tolerance][0] for tolerance in tolerance_keys.values())
    points = sobol_points(count + len(batches), cams, seed).T
    rows, batch_rows = iter(points[:count]), dict(zip(batches, points[count:], strict=True))
    errors = SampledErrors()
    for key, tolerance in tolerance_keys.items():
        parts, make = makers[tolerance]
        shares = [next(rows) for _ in range(parts)]
        if tolerance in tolerances and (batch := tolerances[tolerance].batch) is not None:
            shares = [_correlate_with_batch(shares[0], batch_rows[batch], tolerances[tolerance].shared)]
        errors[key] = make(*shares)
    return errors


ErrorMaker = tuple[int, Callable[..., FloatArray]]
"""Number of parts of an error, and a function that gives the error from the share of each part for all cams."""


def _error_samplers(scene: Scene, nominal: NumberErrors) -> Iterator[tuple[str, ErrorMaker]]:
    tolerances = scene.tolerances
    for key, zone in tolerance_zones_of_numbers_and_angles(scene, nominal).items():
        unit = radians(1.0) if key in ANGLE_TOLERANCES else 1.0
        yield key, (1, partial(_tolerance_quantile, tolerances.number_and_angle_tolerances[key], zone, unit))
    if tolerances.profile:
        yield (
            "profile",
            _vector_error_sampler(tolerances.profile)
            if tolerances.waves
            else (1, partial(_normal_quantile, _symmetric_zone(tolerances.profile))),
        )
    if tolerances.bore_eccentricity:
        yield "bore_eccentricity", _vector_error_sampler(tolerances.bore_eccentricity)


def _correlate_with_batch(shares: FloatArray, batch_shares: FloatArray, shared_variance: float) -> FloatArray:
    """Shares of normal numbers, with the part ``shared_variance`` of their variance from the batch."""
    first, second = (scipy.special.ndtri(np.clip(each, *OPEN_SHARE_RANGE)) for each in (batch_shares, shares))
    return np.asarray(
        scipy.special.ndtr(np.sqrt(shared_variance) * first + np.sqrt(1.0 - shared_variance) * second)
    )


def batch_mean_errors_at_quantiles(tolerance: Tolerance, zone: ToleranceZone, unit: float) -> FloatArray:
    """Mean error of the parts of a batch less the mean of all batches, at evenly spaced quantiles of batches."""
    z = scipy.special.ndtri((np.arange(BATCH_GRID) + 0.5) / BATCH_GRID)
    z = z / np.std(z)
    shares = scipy.special.ndtr(np.sqrt(tolerance.shared) * z[:, None] + np.sqrt(1.0 - tolerance.shared) * z)
    means = _tolerance_quantile(tolerance, zone, unit, shares).mean(axis=1)
    return np.asarray(means - means.mean())


def _symmetric_zone(size: float) -> ToleranceZone:
    return ToleranceZone(-size, size, size / DEVIATIONS_AT_CPK_1)


def _vector_error_sampler(size: float) -> ErrorMaker:
    quantile = partial(_normal_quantile, _symmetric_zone(size))
    return 2, lambda real, imaginary: np.asarray(quantile(real) + 1j * quantile(imaginary))


def _tolerance_quantile(tolerance: Tolerance, zone: ToleranceZone, unit: float, share: FloatArray) -> FloatArray:
    """Quantile of the distribution of a tolerance over its zone: the error below which a share of the parts is."""
    if tolerance.values is not None:
        values = unit * np.sort(tolerance.values)
        return np.asarray(values[np.minimum((share * values.size).astype(int), values.size - 1)])
    if tolerance.distribution == "uniform":
        return np.asarray(zone.lower + share * (zone.upper - zone.lower))
    if tolerance.distribution == "triangular":
        half = (zone.upper - zone.lower) / 2.0
        nearest = np.sqrt(2.0 * np.minimum(share, 1.0 - share))
        return np.asarray(zone.mean + np.sign(share - 0.5) * half * (1.0 - nearest))
    return _normal_quantile(zone, share)


def _normal_quantile(zone: ToleranceZone, share: FloatArray) -> FloatArray:
    return np.asarray(zone.mean + zone.deviation * scipy.special.ndtri(np.clip(share, *OPEN_SHARE_RANGE)))


def exceed_tolerances(errors: CamErrors, error_ranges: Mapping[str, tuple[float, float]]) -> BoolArray:
    """Whether each cam has an error outside of the ranges ``error_ranges`` (``errors.error_ranges``)."""
    outside = np.zeros(next(iter(errors.values())).size, dtype=bool)
    for key, value in errors.items():
        low, high = error_ranges[key]
        outside |= np.abs(value) > high if np.iscomplexobj(value) else (value < low) | (value > high)
    return outside


def real_error_parts_in_mm_and_deg(errors: CamErrors) -> SampledErrors:
    """Errors as real numbers by key and part, as ``bore_eccentricity.x``: mm, angles in deg."""
    real: SampledErrors = {}
    for key, value in errors.items():
        if np.iscomplexobj(value):
            names = COMPLEX_PARTS[key.partition(" ")[0]]
            real |= {f"{key}.{part}": each for part, each in zip(names, (value.real, value.imag), strict=True)}
        else:
            real[key] = np.degrees(value) if key in ANGLE_TOLERANCES else value
    return real
