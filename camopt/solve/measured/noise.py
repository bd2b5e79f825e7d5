"""Noise and outliers of measured points.

Outliers are points far from the curve through their neighbours (``numerics.neighbours``). The other points give the
noise: these deviations to 5 % for 360 points, and the smoothing spline to 1.5 %.
"""

from math import sqrt
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, IndexArray
from camopt.core.numerics.neighbours import NEIGHBOURS, NORMAL_MEDIAN, scaled_deviations_from_neighbours
from camopt.solve.measured.measured_points import FEWEST_MEASURED, TURN_DEG, MeasuredPoints, forward_angle_deg
from camopt.solve.measured.smoothing import smoothing_residuals_and_leverages

EQUAL_STEP = 1.0 / sqrt(12.0)  # standard deviation of rounding errors for a step of 1
FILES_PER_BAND_BREAK = 20.0  # number of files with one normal error outside the band
OUTLIER_OFF, NEIGHBOURS_OFF = (
    8.0,
    4.0,
)  # least deviation of an outlier, and largest of its neighbours, in standard deviations of the noise
EXPLAINED_SHARE = 0.1  # largest deviation of an outlier's neighbours without it, as a share of its own
MOST_SPLINE_NOISE = 1.25  # spline noise over neighbour noise: above it, the spline misses the lift
NEIGHBOUR_FREEDOM_SHARE = 1.0 / 3.0  # independent errors of equal accuracy, per point
LEAST_BAND = 1e-5  # least band, as a share of the range of the lifts
EQUAL_LIFTS = 1e-9  # lifts that differ by a smaller share of their range are equal


class ErrorSize(NamedTuple):
    """Errors of points: standard deviation, upper bound of the root mean square, and the largest error."""

    noise: float
    rms: float
    largest: float


def estimate_point_errors(points: MeasuredPoints) -> ErrorSize:
    """Errors of points without outliers, from the residuals of the smoothing spline.

    The root mean square is below its bound in nineteen of twenty files. The noise comes from n − f of the n errors,
    so the two differ as if n·(n − f)/f errors were known. The spline's noise is too large at corners, and with few
    points in a stroke; then the deviations from neighbours give the noise. The noise is at least that of rounding.
    Points among equal ones do not count.
    """
    moving = points.pick_places(np.flatnonzero(_neighbour_deviations(points)).tolist())
    count, neighbour_noise = moving.rows.size, noise_from_neighbours(points)
    if count < FEWEST_MEASURED:
        return ErrorSize(neighbour_noise, neighbour_noise, neighbour_noise)
    curve = smoothing_residuals_and_leverages(moving)
    noise = sqrt(float(curve.residuals @ curve.residuals) / (count - curve.freedom))
    known_errors = count * (count - curve.freedom) / curve.freedom
    if noise > MOST_SPLINE_NOISE * neighbour_noise:
        noise, known_errors = neighbour_noise, NEIGHBOUR_FREEDOM_SHARE * count
    noise = max(noise, EQUAL_STEP * points.step)
    largest = np.abs(curve.residuals / np.sqrt(np.maximum(1.0 - curve.leverages, EQUAL_LIFTS))).max()
    return ErrorSize(
        noise, noise * noise_rms_bound_factor(known_errors) * sqrt(count / points.rows.size), float(largest)
    )


def noise_from_neighbours(points: MeasuredPoints) -> float:
    """Standard deviation of the errors of the lifts, from deviations from the curve through neighbours.

    Deviations above four times the noise by their median do not count, nor do points among equal ones, such as a
    base circle that was not measured. The noise is at least that of rounding.
    """
    deviations = _neighbour_deviations(points)
    moving = np.abs(deviations[deviations != 0.0])
    counted = moving[moving <= NEIGHBOURS_OFF * np.median(moving) / NORMAL_MEDIAN] if moving.size else np.zeros(1)
    return max(float(np.sqrt(np.mean(counted**2))), EQUAL_STEP * points.step)


def _neighbour_deviations(points: MeasuredPoints) -> FloatArray:
    """Deviations of points from the curve through their neighbours; 0 among equal ones."""
    deviations = scaled_deviations_from_neighbours(points.angles, points.lifts, TURN_DEG)
    return np.where(np.abs(deviations) > EQUAL_LIFTS * np.ptp(points.lifts), deviations, 0.0)


def noise_band_factor(point_count: int) -> float:
    """Band that contains all normal errors in 19 of 20 files, in standard deviations of the noise."""
    return NormalDist().inv_cdf(1.0 - 1.0 / (2.0 * FILES_PER_BAND_BREAK * point_count))


def noise_rms_bound_factor(error_count: float) -> float:
    """Bound of the root mean square of normal errors in 19 of 20 files, in standard deviations.

    By the cube root of χ², which is nearly normal (Wilson and Hilferty, The distribution of chi-square, 1931).
    """
    spread = 2.0 / (9.0 * error_count)
    return float((1.0 - spread + NormalDist().inv_cdf(1.0 - 1.0 / FILES_PER_BAND_BREAK) * sqrt(spread)) ** 1.5)


def find_outliers(points: MeasuredPoints, noise: float, least_deviation: float = 0.0) -> list[int]:
    """Places of single points, or of two near points, that deviate while their neighbours agree without them.

    A jump of the acceleration or a corner makes several points deviate, and leaving out one or two does not help.
    Deviations below ``least_deviation`` are no outliers.
    """
    kept = np.arange(points.angles.size)
    while kept.size > 8 * NEIGHBOURS and (
        outliers := _furthest_outlier_places(points, kept, noise, max(OUTLIER_OFF * noise, least_deviation))
    ):
        kept = np.setdiff1d(kept, outliers)
    return list(map(int, np.setdiff1d(np.arange(points.angles.size), kept)))


def _furthest_outlier_places(
    points: MeasuredPoints, kept_places: IndexArray, noise: float, least_deviation: float
) -> list[int]:
    """The furthest outlier among the remaining points, or two near outliers; empty if there is none."""
    deviations = np.abs(
        scaled_deviations_from_neighbours(points.angles[kept_places], points.lifts[kept_places], TURN_DEG)
    )
    candidates = [int(place) for place in np.argsort(-deviations) if deviations[place] > least_deviation]
    pairs = [
        [first, second]
        for first in candidates
        for second in candidates
        if 0 < min((first - second) % deviations.size, (second - first) % deviations.size) <= 2 * NEIGHBOURS
    ]
    for outliers in [[place] for place in candidates] + pairs:
        rest, place = np.delete(kept_places, outliers), int(kept_places[outliers[0]])
        after = int(np.searchsorted(rest, place))
        around = rest[np.arange(after - 4 * NEIGHBOURS, after + 4 * NEIGHBOURS) % rest.size]
        angles = forward_angle_deg(points.angles[place] - TURN_DEG / 2.0, points.angles[around])
        near = scaled_deviations_from_neighbours(angles, points.lifts[around], TURN_DEG)
        # the points near the omitted ones agree without them
        largest = max(EXPLAINED_SHARE * deviations[outliers[0]], NEIGHBOURS_OFF * noise)
        if np.abs(near[3 * NEIGHBOURS : 5 * NEIGHBOURS]).max() <= largest:
            return list(map(int, kept_places[outliers]))
    return []
