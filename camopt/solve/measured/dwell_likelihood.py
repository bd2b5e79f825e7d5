"""Likelihood of a dwell against a motion without one, from the points about a flat stretch.

With a dwell the motion rests between two cam angles and leaves each end as an m-fold integral of white noise, whose
first m − 1 derivatives are 0 there. Its orders m and sizes, one on each side, are those that explain the points
best: y ∝ x³ at a jump of the jerk, y ∝ x⁵ where the law is flatter. Two motions have no dwell: one whose dwell has
no length, as where a rise and a return of laws for dwells meet; and one that is free, a polynomial with such
integrals on both sides, as at the nose of a valve or on a ramp. Each parameter more costs ln(n)/2 (Schwarz).

Sources: Wahba, Spline Models for Observational Data, 1990, ch. 1 (smoothing splines as integrals of white noise);
Schwarz, Estimating the dimension of a model, Annals of Statistics 6, 1978.
"""

from math import comb, inf, log
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray

INTEGRAL_ORDERS = (2, 3, 4, 5)
INTEGRAL_SIZES = np.exp(np.arange(-5.0, 3.1, 0.6))
"""Standard deviations of an integral at the end of its window, over the largest lift there."""
LEVELS = np.linspace(-4.0, 4.0, 33)
"""Levels of the dwell that are tried, in standard deviations of their mean."""
EDGES, MOST_BINS = 25, 40
"""Ends of a dwell that are tried on each side; means of neighbouring points on each side, at most."""


class DwellReading(NamedTuple):
    """A dwell and its ``gain``: how much likelier the points are with it than without, as a logarithm."""

    start: float
    end: float
    gain: float


class FlatWindow(NamedTuple):
    """Points about a flat stretch by angle, deg, with the angles between which each end of a dwell may be."""

    angles: FloatArray
    lifts: FloatArray
    starts: tuple[float, float]
    ends: tuple[float, float]


def read_dwell(window: FlatWindow, noise: float, drop: float, sure: float) -> DwellReading:
    """The likeliest dwell of a window, or the shortest that is nearly as likely if its gain is at least ``sure``.

    The logarithm of its likelihood is then at most ``drop`` below the largest.
    """
    angles, lifts, variances = _mean_points(window, noise)
    starts, ends = (np.linspace(*limits, EDGES) for limits in (window.starts, window.ends))
    inside = (angles >= starts[0]) & (angles <= ends[-1])
    level = float(np.median(lifts[inside])) if inside.any() else float(lifts.mean())
    whitened = np.column_stack([np.ones_like(lifts), lifts - level]) / np.sqrt(variances)[:, None]
    levels = LEVELS * noise * 2.0 / np.sqrt(max(1, inside.sum()))
    before = np.searchsorted(angles, starts)
    after = np.searchsorted(angles, ends, "right")
    left = [
        _side_likelihood(starts[k] - angles[:n], variances[:n], whitened[:n], levels) for k, n in enumerate(before)
    ]
    right = [
        _side_likelihood(angles[n:] - ends[k], variances[n:], whitened[n:], levels) for k, n in enumerate(after)
    ]
    off = (whitened[:, 1] - np.multiply.outer(levels, whitened[:, 0])) ** 2
    sums = np.concatenate([np.zeros((levels.size, 1)), np.cumsum(off, axis=1)], axis=1)
    within = (sums[:, after][:, None, :] - sums[:, before][:, :, None]) / 2.0
    likely = (np.array(left).T[:, :, None] + np.array(right).T[:, None, :] - within).max(axis=0)
    lengths = ends[None, :] - starts[:, None]
    rests = np.where(lengths > 0.0, likely, -inf)
    gain = inf
    if window.starts == window.ends:
        without = max(float(np.diag(likely).max()), _free_likelihood(angles, variances, whitened[:, 1]))
        gain = float(rests.max()) - log(angles.size) / 2.0 - without
    least = rests.max() - (drop if gain >= sure else 0.0)
    k, j = np.unravel_index(np.argmin(np.where(rests >= least, lengths, inf)), lengths.shape)
    return DwellReading(float(starts[k]), float(ends[j]), gain)


def _mean_points(window: FlatWindow, noise: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The points, or means of neighbouring ones if they are many: angles, lifts and variances."""
    beside = max(np.sum(window.angles < window.starts[1]), np.sum(window.angles > window.ends[0]))
    group = np.arange(window.angles.size) // max(1, -(-int(beside) // MOST_BINS))
    counts = np.bincount(group)
    angles, lifts = (np.bincount(group, values) / counts for values in (window.angles, window.lifts))
    return angles, lifts, noise**2 / counts


def noise_integral(x: FloatArray, order: int) -> FloatArray:
    """The covariance of a multiple integral of white noise from 0, over its largest variance."""
    low, apart = np.minimum.outer(x, x), np.abs(np.subtract.outer(x, x))
    powers = range(order)
    whole = sum(comb(order - 1, k) * apart ** (order - 1 - k) * low ** (order + k) / (order + k) for k in powers)
    return np.asarray(whole * (2 * order - 1) / x.max() ** (2 * order - 1))


def _whiten_columns(
    x: FloatArray, variances: FloatArray, columns: FloatArray, order: int
) -> tuple[FloatArray, FloatArray]:
    """The logarithm of the determinant of the covariance, in units of the errors, and the columns by its root.

    Both are for each size. The columns are rows of the factor of a larger matrix, which has them below.
    """
    count, largest = x.size, np.abs(columns[:, -1] * np.sqrt(variances)).max()
    integral = noise_integral(x, order) / np.sqrt(np.multiply.outer(variances, variances))
    whole = np.zeros((INTEGRAL_SIZES.size, count + columns.shape[1], count + columns.shape[1]))
    whole[:, :count, :count] = np.eye(count) + np.multiply.outer((INTEGRAL_SIZES * largest) ** 2, integral)
    whole[:, count:, :count] = columns.T
    whole[:, count:, count:] = np.diag(1.0 + (1 + columns.shape[1]) * (columns**2).sum(axis=0))
    root = np.linalg.cholesky(whole)
    diagonal = np.diagonal(root, axis1=1, axis2=2)[:, :count]
    return 2.0 * np.log(diagonal).sum(axis=1), root[:, count:, :count]


def _side_likelihood(x: FloatArray, variances: FloatArray, whitened: FloatArray, levels: FloatArray) -> FloatArray:
    """The logarithm of the likelihood of the points beside a dwell, by its level, for the best order and size."""
    if not x.size:
        return np.zeros_like(levels)
    likelihoods = []
    for order in INTEGRAL_ORDERS:
        size, parts = _whiten_columns(x, variances, whitened, order)
        square = parts @ parts.swapaxes(1, 2)
        off = square[:, 1, 1] + levels[:, None] * (levels[:, None] * square[:, 0, 0] - 2.0 * square[:, 0, 1])
        likelihoods.append((-(off + size) / 2.0).max(axis=1))
    return np.asarray(np.max(likelihoods, axis=0))


def _free_likelihood(angles: FloatArray, variances: FloatArray, lifts: FloatArray) -> float:
    """The same of a free motion, less the price of the parameters that it has beside a level."""
    away = (angles - (angles[0] + angles[-1]) / 2.0) / (angles[-1] - angles[0])
    likelihoods = []
    for order in INTEGRAL_ORDERS[1:]:
        powers = away[:, None] ** np.arange(order) / np.sqrt(variances)[:, None]
        columns = np.column_stack([powers, lifts])
        logs, squares = [], []
        for part in (away < 0.0, away >= 0.0):
            size, parts = _whiten_columns(np.abs(away[part]), variances[part], columns[part], order)
            logs.append(size)
            squares.append(parts @ parts.swapaxes(1, 2))
        logs_, square = np.add.outer(*logs), squares[0][:, None] + squares[1][None, :]
        normal, mixed = square[..., :-1, :-1], square[..., :-1, -1]
        explained = np.einsum("abj,abjk,abk->ab", mixed, np.linalg.pinv(normal, hermitian=True), mixed)
        likely = -(square[..., -1, -1] - explained + logs_) / 2.0
        likelihoods.append(float(likely.max()) - (order - 2) * log(angles.size) / 2.0)
    return max(likelihoods)
