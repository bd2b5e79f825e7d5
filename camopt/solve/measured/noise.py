"""The noise of measured points, and points that are none.

Outliers are sought against the curve through their neighbours (``numerics.neighbours``). What is off by little
tells the noise of 360 points to 5 %; the smoothing spline of the points that are left, to 1.5 %.
"""

from math import sqrt
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, IndexArray
from camopt.core.numerics.neighbours import NEIGHBOURS, NORMAL_MEDIAN, neighbour_deviations
from camopt.solve.measured.measured_points import FEWEST_MEASURED, TURN_DEG, MeasuredPoints, angle_from
from camopt.solve.measured.smoothing import smoothing_spline

EQUAL_STEP = 1.0 / sqrt(12.0)  # standard deviation of what rounding by a step of 1 leaves
FILES_PER_BAND_BREAK = 20.0  # files in which a normal error leaves the band
OUTLIER_OFF, NEIGHBOURS_OFF = (
    8.0,
    4.0,
)  # times the noise: what an outlier is off by at least, and its neighbours at most
EXPLAINED_SHARE = 0.1  # of what an outlier is off by: what its neighbours may be off by without it
MOST_SPLINE_NOISE = 1.25  # times the noise by neighbours: a spline that leaves more does not follow the lift
NEIGHBOUR_FREEDOM_SHARE = 1.0 / 3.0  # of the points: as many errors by themselves would tell the noise as well
LEAST_BAND = 1e-5  # of the range of the lifts: the least band
EQUAL_LIFTS = 1e-9  # of the range of the lifts: what points among equal ones are off by


class ErrorSize(NamedTuple):
    """The errors of points: their standard deviation, what their root mean square is at most, and the largest."""

    noise: float
    rms: float
    largest: float


def point_errors(points: MeasuredPoints) -> ErrorSize:
    """The errors of points without outliers, by what the smoothing spline leaves of them.

    The root mean square is below its limit in nineteen of twenty files. It differs from the noise, which n − f of
    the n errors tell, by as much as that of n·(n − f)/f errors from their standard deviation. Where the spline
    leaves too much (at corners, and where few points are in a stroke), neighbours tell the noise. It is at least
    that of rounding; points among equal ones do not count.
    """
    moving = points.pick_places(np.flatnonzero(_neighbour_deviations(points)).tolist())
    count, local = moving.rows.size, point_noise(points)
    if count < FEWEST_MEASURED:
        return ErrorSize(local, local, local)
    curve = smoothing_spline(moving)
    noise = sqrt(float(curve.residuals @ curve.residuals) / (count - curve.freedom))
    known = count * (count - curve.freedom) / curve.freedom
    if noise > MOST_SPLINE_NOISE * local:
        noise, known = local, NEIGHBOUR_FREEDOM_SHARE * count
    noise = max(noise, EQUAL_STEP * points.step)
    largest = np.abs(curve.residuals / np.sqrt(np.maximum(1.0 - curve.leverages, EQUAL_LIFTS))).max()
    return ErrorSize(noise, noise * rms_factor(known) * sqrt(count / points.rows.size), float(largest))


def point_noise(points: MeasuredPoints) -> float:
    """The standard deviation of the errors of the lifts, by what points are off the curve through neighbours by.

    What is off by over four times as much as the median says does not count, nor do points among equal ones: a base
    circle that was not measured. It is at least that of rounding.
    """
    off = _neighbour_deviations(points)
    moving = np.abs(off[off != 0.0])
    usual = moving[moving <= NEIGHBOURS_OFF * np.median(moving) / NORMAL_MEDIAN] if moving.size else np.zeros(1)
    return max(float(np.sqrt(np.mean(usual**2))), EQUAL_STEP * points.step)


def _neighbour_deviations(points: MeasuredPoints) -> FloatArray:
    """The deviations of points from the curve through their neighbours; 0 among equal ones."""
    off = neighbour_deviations(points.angles, points.lifts, TURN_DEG)
    return np.where(np.abs(off) > EQUAL_LIFTS * np.ptp(points.lifts), off, 0.0)


def band_factor(count: int) -> float:
    """The standard deviations of noise within which all normal errors of a file lie in 19 of 20 files."""
    return NormalDist().inv_cdf(1.0 - 1.0 / (2.0 * FILES_PER_BAND_BREAK * count))


def rms_factor(count: float) -> float:
    """The standard deviations that the root mean square of normal errors does not exceed in 19 of 20 files.

    By the cube root of χ², which is nearly normal (Wilson and Hilferty, The distribution of chi-square, 1931).
    """
    spread = 2.0 / (9.0 * count)
    return float((1.0 - spread + NormalDist().inv_cdf(1.0 - 1.0 / FILES_PER_BAND_BREAK) * sqrt(spread)) ** 1.5)


def find_outliers(points: MeasuredPoints, noise: float, least: float = 0.0) -> list[int]:
    """The places of points that are off where their neighbours agree without them.

    They are single, or two near each other. A jump of the acceleration or a corner is off in several points, and
    leaving out one or two does not help. What is off by less than ``least`` is none.
    """
    kept = np.arange(points.angles.size)
    while kept.size > 8 * NEIGHBOURS and (
        lost := _furthest_outlier(points, kept, noise, max(OUTLIER_OFF * noise, least))
    ):
        kept = np.setdiff1d(kept, lost)
    return list(map(int, np.setdiff1d(np.arange(points.angles.size), kept)))


def _furthest_outlier(points: MeasuredPoints, kept: IndexArray, noise: float, least: float) -> list[int]:
    """Of the points that are kept, the outlier that is furthest off, or two near each other, if there is one."""
    off = np.abs(neighbour_deviations(points.angles[kept], points.lifts[kept], TURN_DEG))
    candidates = [int(k) for k in np.argsort(-off) if off[k] > least]
    pairs = [
        [a, b] for a in candidates for b in candidates if 0 < _place_distance(a, b, off.size) <= 2 * NEIGHBOURS
    ]
    for lost in [[k] for k in candidates] + pairs:
        rest = np.delete(kept, lost)
        if _neighbours_agree(
            points, rest, int(kept[lost[0]]), max(EXPLAINED_SHARE * off[lost[0]], NEIGHBOURS_OFF * noise)
        ):
            return list(map(int, kept[lost]))
    return []


def _place_distance(one: int, other: int, size: int) -> int:
    """How many places two points are apart."""
    return min((one - other) % size, (other - one) % size)


def _neighbours_agree(points: MeasuredPoints, rest: IndexArray, place: int, most: float) -> bool:
    """Whether the points beside one that is left out are off by no more than something."""
    after = int(np.searchsorted(rest, place))
    around = rest[np.arange(after - 4 * NEIGHBOURS, after + 4 * NEIGHBOURS) % rest.size]
    angles = angle_from(points.angles[place] - TURN_DEG / 2.0, points.angles[around])
    middle = slice(3 * NEIGHBOURS, 5 * NEIGHBOURS)
    return bool(np.abs(neighbour_deviations(angles, points.lifts[around], TURN_DEG)[middle]).max() <= most)
