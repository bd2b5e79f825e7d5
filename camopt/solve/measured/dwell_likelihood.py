"""Likelihood of a dwell against a motion without one, from the points about a flat stretch.

With a dwell, the motion rests between two cam angles. It leaves each end as an m-fold integral of white noise,
whose first m − 1 derivatives are 0 there. Each side has the order m and the size that explain the points best: y ∝
x³ at a jump of the jerk, y ∝ x⁵ for a flatter law. Two motions have no dwell. One has a dwell of no length, as
between a rise and a return of laws for dwells. The other is free: a polynomial with such integrals on both sides,
as at the nose of a valve cam or on a ramp. Each further parameter costs ln(n)/2 (Schwarz).

Sources: Wahba, Spline Models for Observational Data, 1990, ch. 1 (smoothing splines as integrals of white noise);
Schwarz, Estimating the dimension of a model, Annals of Statistics 6, 1978.
"""

from math import comb, inf, log
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray

INTEGRAL_ORDERS = (2, 3, 4, 5)
INTEGRAL_SIZES = np.exp(np.arange(-5.0, 3.1, 0.6))
"""Standard deviations of an integral at the end of its window, as shares of the largest lift there."""
LEVELS = np.linspace(-4.0, 4.0, 33)
"""Trial levels of the dwell, in standard deviations of their mean."""
EDGES, MOST_BINS = 25, 40
"""Number of trial ends of a dwell on each side, and most means of neighbouring points on each side."""


class DwellReading(NamedTuple):
    """A dwell and its ``gain``: the log-likelihood of the points with it, less that without it."""

    start: float
    end: float
    gain: float


class FlatWindow(NamedTuple):
    """Points about a flat stretch by angle [deg], and the ranges of angles for the two ends of a dwell."""

    angles: FloatArray
    lifts: FloatArray
    starts: tuple[float, float]
    ends: tuple[float, float]


def likeliest_dwell(window: FlatWindow, noise: float, likelihood_drop: float, certain_gain: float) -> DwellReading:
    """The likeliest dwell of a window, or a shorter one of nearly equal likelihood.

    The shorter one is at most ``likelihood_drop`` below the largest log-likelihood. It is taken if the gain of the
    dwell is at least ``certain_gain``.
    """
    angles, lifts, variances = _binned_angles_lifts_variances(window, noise)
    starts, ends = (np.linspace(*limits, EDGES) for limits in (window.starts, window.ends))
    inside = (angles >= starts[0]) & (angles <= ends[-1])
    level = float(np.median(lifts[inside])) if inside.any() else float(lifts.mean())
    whitened = np.column_stack([np.ones_like(lifts), lifts - level]) / np.sqrt(variances)[:, None]
    levels = LEVELS * noise * 2.0 / np.sqrt(max(1, inside.sum()))
    before = np.searchsorted(angles, starts)
    after = np.searchsorted(angles, ends, "right")
    left = [
        _log_likelihood_of_points_beside_dwell(
            starts[k] - angles[:count], variances[:count], whitened[:count], levels
        )
        for k, count in enumerate(before)
    ]
    right = [
        _log_likelihood_of_points_beside_dwell(
            angles[count:] - ends[k], variances[count:], whitened[count:], levels
        )
        for k, count in enumerate(after)
    ]
    squares = (whitened[:, 1] - np.multiply.outer(levels, whitened[:, 0])) ** 2
    sums = np.concatenate([np.zeros((levels.size, 1)), np.cumsum(squares, axis=1)], axis=1)
    within = (sums[:, after][:, None, :] - sums[:, before][:, :, None]) / 2.0
    likelihood = (np.array(left).T[:, :, None] + np.array(right).T[:, None, :] - within).max(axis=0)
    lengths = ends[None, :] - starts[:, None]
    dwell_likelihood = np.where(lengths > 0.0, likelihood, -inf)
    gain = inf
    if window.starts == window.ends:
        without = max(
            float(np.diag(likelihood).max()), _log_likelihood_without_dwell(angles, variances, whitened[:, 1])
        )
        gain = float(dwell_likelihood.max()) - log(angles.size) / 2.0 - without
    lowest = dwell_likelihood.max() - (likelihood_drop if gain >= certain_gain else 0.0)
    k, j = np.unravel_index(np.argmin(np.where(dwell_likelihood >= lowest, lengths, inf)), lengths.shape)
    return DwellReading(float(starts[k]), float(ends[j]), gain)


def _binned_angles_lifts_variances(window: FlatWindow, noise: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Angles, lifts and variances of the points, or of means of neighbouring points if there are many."""
    side_count = max(np.sum(window.angles < window.starts[1]), np.sum(window.angles > window.ends[0]))
    group = np.arange(window.angles.size) // max(1, -(-int(side_count) // MOST_BINS))
    counts = np.bincount(group)
    angles, lifts = (np.bincount(group, values) / counts for values in (window.angles, window.lifts))
    return angles, lifts, noise**2 / counts


def integrated_noise_covariance(positions: FloatArray, order: int) -> FloatArray:
    """Covariance of a multiple integral of white noise from 0, over its largest variance."""
    nearer, distances = np.minimum.outer(positions, positions), np.abs(np.subtract.outer(positions, positions))
    powers = range(order)
    covariance = sum(
        comb(order - 1, k) * distances ** (order - 1 - k) * nearer ** (order + k) / (order + k) for k in powers
    )
    return np.asarray(covariance * (2 * order - 1) / positions.max() ** (2 * order - 1))


def _log_determinants_and_whitened_columns(
    positions: FloatArray, variances: FloatArray, columns: FloatArray, order: int
) -> tuple[FloatArray, FloatArray]:
    """Log-determinant of the covariance in units of the errors, and the columns divided by its root.

    Both are for each size. The columns are rows of the factor of a larger matrix that has them below.
    """
    count, largest = positions.size, np.abs(columns[:, -1] * np.sqrt(variances)).max()
    integral = integrated_noise_covariance(positions, order) / np.sqrt(np.multiply.outer(variances, variances))
    matrices = np.zeros((INTEGRAL_SIZES.size, count + columns.shape[1], count + columns.shape[1]))
    matrices[:, :count, :count] = np.eye(count) + np.multiply.outer((INTEGRAL_SIZES * largest) ** 2, integral)
    matrices[:, count:, :count] = columns.T
    matrices[:, count:, count:] = np.diag(1.0 + (1 + columns.shape[1]) * (columns**2).sum(axis=0))
    root = np.linalg.cholesky(matrices)
    return 2.0 * np.log(np.diagonal(root, axis1=1, axis2=2)[:, :count]).sum(axis=1), root[:, count:, :count]


def _log_likelihood_of_points_beside_dwell(
    angles_from_dwell: FloatArray, variances: FloatArray, whitened: FloatArray, levels: FloatArray
) -> FloatArray:
    """Log-likelihood of the points beside a dwell by its level, for the best order and size."""
    if not angles_from_dwell.size:
        return np.zeros_like(levels)
    likelihoods = []
    for order in INTEGRAL_ORDERS:
        size, whitened_columns = _log_determinants_and_whitened_columns(
            angles_from_dwell, variances, whitened, order
        )
        square = whitened_columns @ whitened_columns.swapaxes(1, 2)
        squares = square[:, 1, 1] + levels[:, None] * (levels[:, None] * square[:, 0, 0] - 2.0 * square[:, 0, 1])
        likelihoods.append((-(squares + size) / 2.0).max(axis=1))
    return np.asarray(np.max(likelihoods, axis=0))


def _log_likelihood_without_dwell(angles: FloatArray, variances: FloatArray, lifts: FloatArray) -> float:
    """Log-likelihood of a free motion, less the cost of its parameters beyond a level."""
    offsets = (angles - (angles[0] + angles[-1]) / 2.0) / (angles[-1] - angles[0])
    likelihoods = []
    for order in INTEGRAL_ORDERS[1:]:
        columns = np.column_stack([offsets[:, None] ** np.arange(order) / np.sqrt(variances)[:, None], lifts])
        logs, squares = [], []
        for part in (offsets < 0.0, offsets >= 0.0):
            size, whitened_columns = _log_determinants_and_whitened_columns(
                np.abs(offsets[part]), variances[part], columns[part], order
            )
            logs.append(size)
            squares.append(whitened_columns @ whitened_columns.swapaxes(1, 2))
        logs_, square = np.add.outer(*logs), squares[0][:, None] + squares[1][None, :]
        normal, mixed = square[..., :-1, :-1], square[..., :-1, -1]
        explained = np.einsum("abj,abjk,abk->ab", mixed, np.linalg.pinv(normal, hermitian=True), mixed)
        likelihood = -(square[..., -1, -1] - explained + logs_) / 2.0
        likelihoods.append(float(likelihood.max()) - (order - 2) * log(angles.size) / 2.0)
    return max(likelihoods)
