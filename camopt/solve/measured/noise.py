"""The noise of measured points, and points that are none.

Outliers are sought against the curve through their neighbours (``numerics.neighbours``). What is off by little
tells the noise of 360 points to 5 %; the smoothing spline of the points that are left, to 1.5 %.
"""

from math import sqrt
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, IndexArray
from camopt.core.numerics.neighbours import MEDIAN, REACH, deviations
from camopt.solve.measured.reading import FEWEST_MEASURED, FULL_TURN, MeasuredPoints, angle_from
from camopt.solve.measured.smoothing import smoothed

EQUAL_STEP = 1.0 / sqrt(12.0)  # standard deviation of what rounding by a step of 1 leaves
ONE_IN = 20.0  # files in which a normal error leaves the band
OUTLIER_OFF, NEIGHBOURS_OFF = (
    8.0,
    4.0,
)  # times the noise: what an outlier is off by at least, and its neighbours at most
EXPLAINED = 0.1  # of what an outlier is off by: what its neighbours may be off by without it
FOLLOWED = 1.25  # times the noise by neighbours: a spline that leaves more does not follow the lift
NEIGHBOURS_KNOW = 1.0 / 3.0  # of the points: as many errors by themselves would tell the noise as well
LEAST_BAND = 1e-5  # of the range of the lifts: the least band
EQUAL_LIFTS = 1e-9  # of the range of the lifts: what points among equal ones are off by


class ErrorSize(NamedTuple):
    """The errors of points: their standard deviation, what their root mean square is at most, and the largest."""

    noise: float
    rms: float
    largest: float


def errors_of(points: MeasuredPoints) -> ErrorSize:
    """The errors of points without outliers, by what the smoothing spline leaves of them.

    The root mean square is below its limit in nineteen of twenty files. It differs from the noise, which n − f of
    the n errors tell, by as much as that of n·(n − f)/f errors from their standard deviation. Where the spline
    leaves too much (at corners, and where few points are in a stroke), neighbours tell the noise. It is at least
    that of rounding; points among equal ones do not count.
    """
    moving = points.only(np.flatnonzero(_off(points)).tolist())
    count, local = moving.rows.size, noise_of(points)
    if count < FEWEST_MEASURED:
        return ErrorSize(local, local, local)
    curve = smoothed(moving)
    noise = sqrt(float(curve.off @ curve.off) / (count - curve.freedom))
    known = count * (count - curve.freedom) / curve.freedom
    if noise > FOLLOWED * local:
        noise, known = local, NEIGHBOURS_KNOW * count
    noise = max(noise, EQUAL_STEP * points.step)
    largest = np.abs(curve.off / np.sqrt(np.maximum(1.0 - curve.drawn, EQUAL_LIFTS))).max()
    return ErrorSize(noise, noise * rms_factor(known) * sqrt(count / points.rows.size), float(largest))


def noise_of(points: MeasuredPoints) -> float:
    """The standard deviation of the errors of the lifts, by what points are off the curve through neighbours by.

    What is off by over four times as much as the median says does not count, nor do points among equal ones: a base
    circle that was not measured. It is at least that of rounding.
    """
    off = _off(points)
    moving = np.abs(off[off != 0.0])
    usual = moving[moving <= NEIGHBOURS_OFF * np.median(moving) / MEDIAN] if moving.size else np.zeros(1)
    return max(float(np.sqrt(np.mean(usual**2))), EQUAL_STEP * points.step)


def _off(points: MeasuredPoints) -> FloatArray:
    """The deviations of points from the curve through their neighbours; 0 among equal ones."""
    off = deviations(points.angles, points.lifts, FULL_TURN)
    return np.where(np.abs(off) > EQUAL_LIFTS * np.ptp(points.lifts), off, 0.0)


def band_factor(count: int) -> float:
    """The standard deviations of noise within which all normal errors of a file lie in 19 of 20 files."""
    return NormalDist().inv_cdf(1.0 - 1.0 / (2.0 * ONE_IN * count))


def rms_factor(count: float) -> float:
    """The standard deviations that the root mean square of normal errors does not exceed in 19 of 20 files.

    By the cube root of χ², which is nearly normal (Wilson and Hilferty, The distribution of chi-square, 1931).
    """
    spread = 2.0 / (9.0 * count)
    return float((1.0 - spread + NormalDist().inv_cdf(1.0 - 1.0 / ONE_IN) * sqrt(spread)) ** 1.5)


def outliers(points: MeasuredPoints, noise: float, least: float = 0.0) -> list[int]:
    """The places of points that are off where their neighbours agree without them.

    They are single, or two near each other. A jump of the acceleration or a corner is off in several points, and
    leaving out one or two does not help. What is off by less than ``least`` is none.
    """
    kept = np.arange(points.angles.size)
    while kept.size > 8 * REACH and (lost := _worst(points, kept, noise, max(OUTLIER_OFF * noise, least))):
        kept = np.setdiff1d(kept, lost)
    return list(map(int, np.setdiff1d(np.arange(points.angles.size), kept)))


def _worst(points: MeasuredPoints, kept: IndexArray, noise: float, least: float) -> list[int]:
    """Of the points that are kept, the outlier that is furthest off, or two near each other, if there is one."""
    off = np.abs(deviations(points.angles[kept], points.lifts[kept], FULL_TURN))
    candidates = [int(k) for k in np.argsort(-off) if off[k] > least]
    pairs = [[a, b] for a in candidates for b in candidates if 0 < _steps(a, b, off.size) <= 2 * REACH]
    for lost in [[k] for k in candidates] + pairs:
        rest = np.delete(kept, lost)
        if _agree_about(points, rest, int(kept[lost[0]]), max(EXPLAINED * off[lost[0]], NEIGHBOURS_OFF * noise)):
            return list(map(int, kept[lost]))
    return []


def _steps(one: int, other: int, size: int) -> int:
    """How many places two points are apart."""
    return min((one - other) % size, (other - one) % size)


def _agree_about(points: MeasuredPoints, rest: IndexArray, place: int, most: float) -> bool:
    """Whether the points beside one that is left out are off by no more than something."""
    after = int(np.searchsorted(rest, place))
    around = rest[np.arange(after - 4 * REACH, after + 4 * REACH) % rest.size]
    angles = angle_from(points.angles[place] - FULL_TURN / 2.0, points.angles[around])
    middle = slice(3 * REACH, 5 * REACH)
    return bool(np.abs(deviations(angles, points.lifts[around], FULL_TURN)[middle]).max() <= most)
