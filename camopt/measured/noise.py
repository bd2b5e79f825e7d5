"""The noise of measured points, and points that are none: each against the curve through its neighbours.

A point is compared with the quintic polynomial through the three nearest angles on either side, which a cam that is
measured in steps of a few degrees follows to far less than any gauge shows. For equal steps that is the sixth
difference. What a point of independent errors σ is off by has the standard deviation σ·√(1 + Σ wⱼ²), with the
weights wⱼ of the neighbours.
"""

from math import sqrt
from statistics import NormalDist

import numpy as np

from camopt.measured.reading import TURN, Points
from camopt.numerics import FloatArray

SIDE = 3  # neighbours on either side
MEDIAN = NormalDist().inv_cdf(0.75)  # of |x|, for a normal x of deviation 1
EQUAL_STEP = 1.0 / sqrt(12.0)  # standard deviation of what rounding by a step of 1 leaves
ONE_IN = 20.0  # files in which a normal error leaves the band
OUTLIER, QUIET = 8.0, 4.0  # times the noise: what an outlier is off by at least, and its neighbours at most
EXPLAINED = 0.1  # of what an outlier is off by: what its neighbours may be off by without it


def noise_of(points: Points) -> float:
    """The standard deviation of the errors of the lifts, by the median of what points are off by.

    At least that of rounding. Points among equal ones do not count: a base circle that was not measured.
    """
    off = _deviations(points.angles, points.lifts)
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
    """The places of single points that are off where their neighbours agree without them, the worst first.

    What is off by less than ``least`` is none.

    A jump of the acceleration or a corner is off in several points, and leaving out one does not help.
    """
    found: list[int] = []
    kept = np.arange(points.angles.size)
    while kept.size > 4 * SIDE:
        off = np.abs(_deviations(points.angles[kept], points.lifts[kept]))
        for place in np.argsort(-off)[:SIDE]:
            if off[place] <= max(OUTLIER * noise, least):
                return found
            near = np.delete(np.arange(place - SIDE, place + SIDE + 1), SIDE) % kept.size
            rest = np.delete(kept, place)
            without = np.abs(_deviations(points.angles[rest], points.lifts[rest]))
            beside = np.where(near > place, near - 1, near)
            if without[beside].max() <= max(EXPLAINED * off[place], QUIET * noise):
                found.append(int(kept[place]))
                kept = rest
                break
        else:
            return found
    return found


def _deviations(angles: FloatArray, lifts: FloatArray) -> FloatArray:
    """What each point is off the polynomial through its neighbours by, over √(1 + Σ wⱼ²)."""
    places = np.arange(angles.size)[:, None] + np.delete(np.arange(-SIDE, SIDE + 1), SIDE)
    turned = angles[places % angles.size] + TURN * (places // angles.size)
    apart = turned - angles[:, None]
    weights = np.ones_like(apart)
    with np.errstate(divide="ignore", invalid="ignore"):
        for j in range(2 * SIDE):
            for k in range(2 * SIDE):
                if k != j:
                    weights[:, j] *= apart[:, k] / (apart[:, k] - apart[:, j])
        off = lifts - (weights * lifts[places % angles.size]).sum(axis=1)
        off /= np.sqrt(1.0 + (weights**2).sum(axis=1))
    return np.where(np.isfinite(off), off, 0.0)  # of points at one angle nothing is told
