"""Deviations of points from the curve through their neighbours: their noise.

A point is compared with the quintic polynomial through the three nearest angles on either side, which a cam that is
measured in steps of a few degrees follows to far less than any gauge shows. For equal steps that is the sixth
difference. What a point of independent errors σ is off by has the standard deviation σ·√(1 + Σ wⱼ²), with the
weights wⱼ of the neighbours.
"""

from collections.abc import Sequence
from math import factorial
from statistics import NormalDist

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from camopt.core.numerics import FloatArray

NEIGHBOURS = 3  # neighbours on either side
NORMAL_MEDIAN = NormalDist().inv_cdf(0.75)  # of |x|, for a normal x of deviation 1


def neighbour_deviations(angles: FloatArray, lifts: FloatArray, turn: float) -> FloatArray:
    """The deviation of each point from the polynomial through its neighbours, over √(1 + Σ wⱼ²/mⱼ).

    The lift at an angle that has m points is their mean. After a ``turn`` the points are the same again.
    """
    turned, group, counts = np.unique(angles, return_inverse=True, return_counts=True)
    means = np.bincount(group, lifts) / counts
    places = np.arange(turned.size)[:, None] + np.delete(np.arange(-NEIGHBOURS, NEIGHBOURS + 1), NEIGHBOURS)
    beside = places % turned.size
    apart = turned[beside] + turn * (places // turned.size) - turned[:, None]
    weights = np.ones_like(apart)
    for j in range(2 * NEIGHBOURS):
        for k in range(2 * NEIGHBOURS):
            if k != j:
                weights[:, j] *= apart[:, k] / (apart[:, k] - apart[:, j])
    predicted = (weights * means[beside]).sum(axis=1)
    spread = np.sqrt(1.0 + (weights**2 / counts[beside]).sum(axis=1))
    return np.asarray((lifts - predicted[group]) / spread[group])


def table_noise(x: Sequence[float], s: Sequence[float]) -> float:
    """The standard deviation of the errors of s, from the median deviation of points between others."""
    off = neighbour_deviations(np.array(x, dtype=float), np.array(s, dtype=float), 2.0)
    return (
        float(np.median(np.abs(off[NEIGHBOURS:-NEIGHBOURS]))) / NORMAL_MEDIAN
    )  # those at the ends have no neighbours beyond


def noise_share(x: Sequence[float], s: Sequence[float], order: int) -> float:
    """How much of the root mean square of a derivative by divided differences is noise of the points, 0 to about 1.

    Errors σ make a difference Σ wⱼ·sⱼ deviate by σ·√(Σ wⱼ²): of points h apart by √6·σ/h² for the second derivative
    and by √20·σ/h³ for the third.
    """
    places, heights = (sliding_window_view(np.array(v, dtype=float), order + 1) for v in (x, s))
    apart = places[:, :, None] - places[:, None, :] + np.eye(order + 1)
    weights = factorial(order) / apart.prod(axis=2)
    largest = float(np.sqrt(np.mean((weights * heights).sum(axis=1) ** 2)))
    expected = table_noise(x, s) * float(np.sqrt(np.mean((weights**2).sum(axis=1))))
    return expected / largest if largest else 0.0
