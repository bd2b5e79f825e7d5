"""The noise of measured points, and points that are none: each against the curve through its neighbours.

``numerics.neighbours`` says what a point is off by.
"""

from math import sqrt
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from camopt.measured.reading import TURN, Points, apart
from camopt.numerics.neighbours import MEDIAN, SIDE, deviations

EQUAL_STEP = 1.0 / sqrt(12.0)  # standard deviation of what rounding by a step of 1 leaves
ONE_IN = 20.0  # files in which a normal error leaves the band
OUTLIER, QUIET = 8.0, 4.0  # times the noise: what an outlier is off by at least, and its neighbours at most
EXPLAINED = 0.1  # of what an outlier is off by: what its neighbours may be off by without it


def noise_of(points: Points) -> float:
    """The standard deviation of the errors of the lifts, by the median of what points are off by.

    At least that of rounding. Points among equal ones do not count: a base circle that was not measured.
    """
    off = deviations(points.angles, points.lifts, TURN)
    moving = np.abs(off[off != 0.0])
    measured = float(np.median(moving)) / MEDIAN if moving.size else 0.0
    return max(measured, EQUAL_STEP * points.step)


def band_factor(count: int) -> float:
    """How many standard deviations of the noise hold all normal errors of a file, but in one file of twenty."""
    return NormalDist().inv_cdf(1.0 - 1.0 / (2.0 * ONE_IN * count))


def rms_factor(count: int) -> float:
    """How many standard deviations the root mean square of normal errors is at most, but in one file of twenty.

    By the cube root of χ², which is nearly normal (Wilson and Hilferty, The distribution of chi-square, 1931).
    """
    spread = 2.0 / (9.0 * count)
    return float((1.0 - spread + NormalDist().inv_cdf(1.0 - 1.0 / ONE_IN) * sqrt(spread)) ** 1.5)


def outliers(points: Points, noise: float, least: float = 0.0) -> list[int]:
    """The places of points that are off where their neighbours agree without them.

    They are single, or two near each other. A jump of the acceleration or a corner is off in several points, and
    leaving out one or two does not help. What is off by less than ``least`` is none.
    """
    kept = np.arange(points.angles.size)
    while kept.size > 8 * SIDE and (lost := _worst(points, kept, noise, max(OUTLIER * noise, least))):
        kept = np.setdiff1d(kept, lost)
    return list(map(int, np.setdiff1d(np.arange(points.angles.size), kept)))


def _worst(points: Points, kept: NDArray[np.intp], noise: float, least: float) -> list[int]:
    """Of the points that are kept, the outlier that is furthest off, or two near each other, if there is one."""
    off = np.abs(deviations(points.angles[kept], points.lifts[kept], TURN))
    candidates = [int(k) for k in np.argsort(-off) if off[k] > least]
    pairs = [[a, b] for a in candidates for b in candidates if 0 < _steps(a, b, off.size) <= 2 * SIDE]
    for lost in [[k] for k in candidates] + pairs:
        rest = np.delete(kept, lost)
        if _agree_about(points, rest, int(kept[lost[0]]), max(EXPLAINED * off[lost[0]], QUIET * noise)):
            return list(map(int, kept[lost]))
    return []


def _steps(one: int, other: int, size: int) -> int:
    """How many places two points are apart."""
    return min((one - other) % size, (other - one) % size)


def _agree_about(points: Points, rest: NDArray[np.intp], place: int, most: float) -> bool:
    """Whether the points beside one that is left out are off by no more than something."""
    after = int(np.searchsorted(rest, place))
    around = rest[np.arange(after - 4 * SIDE, after + 4 * SIDE) % rest.size]
    angles = apart(points.angles[place] - TURN / 2.0, points.angles[around])
    middle = slice(3 * SIDE, 5 * SIDE)
    return bool(np.abs(deviations(angles, points.lifts[around], TURN)[middle]).max() <= most)
