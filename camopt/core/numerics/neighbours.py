"""Noise of measured points, from their deviations from the curve through their neighbours.

A point is compared with the quintic polynomial through the three nearest angles on either side. A cam that is
measured in steps of a few degrees follows it far more closely than any gauge shows. For equal steps the deviation
is the sixth difference. If the points have independent errors σ, the deviation has the standard deviation σ·√(1 + Σ
wⱼ²), with the weights wⱼ of the neighbours.
"""

from collections.abc import Sequence
from math import factorial
from statistics import NormalDist

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from camopt.core.numerics import FloatArray

NEIGHBOURS = 3  # neighbours on either side
NORMAL_MEDIAN = NormalDist().inv_cdf(0.75)  # median of |x| for a normal x with standard deviation 1


def scaled_deviations_from_neighbours(angles: FloatArray, lifts: FloatArray, turn: float) -> FloatArray:
    """Deviation of each point from the polynomial through its neighbours, divided by √(1 + Σ wⱼ²/mⱼ).

    The lift at an angle with m points is their mean. The points repeat after a ``turn``.
    """
    distinct, group, counts = np.unique(angles, return_inverse=True, return_counts=True)
    means = np.bincount(group, lifts) / counts
    places = np.arange(distinct.size)[:, None] + np.delete(np.arange(-NEIGHBOURS, NEIGHBOURS + 1), NEIGHBOURS)
    neighbours = places % distinct.size
    distance = distinct[neighbours] + turn * (places // distinct.size) - distinct[:, None]
    weights = np.ones_like(distance)
    for j in range(2 * NEIGHBOURS):
        for k in range(2 * NEIGHBOURS):
            if k != j:
                weights[:, j] *= distance[:, k] / (distance[:, k] - distance[:, j])
    predicted = (weights * means[neighbours]).sum(axis=1)
    spread = np.sqrt(1.0 + (weights**2 / counts[neighbours]).sum(axis=1))
    return np.asarray((lifts - predicted[group]) / spread[group])


def noise_standard_deviation(positions: Sequence[float], measured_values: Sequence[float]) -> float:
    """Standard deviation of the errors of s, from the median deviation of the inner points."""
    deviations = scaled_deviations_from_neighbours(
        np.array(positions, dtype=float), np.array(measured_values, dtype=float), 2.0
    )
    inner = deviations[NEIGHBOURS:-NEIGHBOURS]  # points near the ends lack neighbours on one side
    return float(np.median(np.abs(inner))) / NORMAL_MEDIAN


def derivative_noise_share(
    positions: Sequence[float], measured_values: Sequence[float], derivative_order: int
) -> float:
    """Share of noise in the root mean square of a derivative by divided differences, 0 to about 1.

    Errors σ change a difference Σ wⱼ·sⱼ by σ·√(Σ wⱼ²). For steps of h this is √6·σ/h² for the second derivative and
    √20·σ/h³ for the third.
    """
    places, heights = (
        sliding_window_view(np.array(v, dtype=float), derivative_order + 1) for v in (positions, measured_values)
    )
    distances = places[:, :, None] - places[:, None, :] + np.eye(derivative_order + 1)
    weights = factorial(derivative_order) / distances.prod(axis=2)
    largest = float(np.sqrt(np.mean((weights * heights).sum(axis=1) ** 2)))
    expected = noise_standard_deviation(positions, measured_values) * float(
        np.sqrt(np.mean((weights**2).sum(axis=1)))
    )
    return expected / largest if largest else 0.0
