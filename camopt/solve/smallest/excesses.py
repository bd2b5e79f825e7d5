"""Excesses over limits in boxes of designs, and the part of each box that may be feasible.

Two limits together bound a size more closely than each alone. A feasible cam has e_j ≤ 0 for every constraint, so
Σ w_j·e_j ≤ 0 for any weights w_j ≥ 0. If several limits are active at once, the right weights cancel the slopes by
all angles and sizes except the cam's own size, and the sum bounds that size. These weights are the multipliers of a
linear programme: the constraints linearised at the middle of a box.

Sources: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 8 (interval Newton);
A. Neumaier, Interval Methods for Systems of Equations, ch. 5 (preconditioning).
"""

from math import inf
from typing import Any, NamedTuple

import numpy as np
import scipy

from camopt.core.numerics import FloatArray
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.sloped_interval import SlopedInterval

SIDE_ROUNDING = 1e-15  # relative rounding of an end of a side
UNBOUNDED_SLOPE = 1e300  # stands for a slope without bounds
EXCESS_ROUNDING = 1e-11  # relative: an excess above it is not rounding
ARRAY_FIELDS = ("least", "most", "at", "rounding")


class Excesses(NamedTuple):
    """The relative excess of n boxes over the limits at m cam angles; above 0 the limit is exceeded."""

    least: FloatArray
    """Lower bound over each box (m, n)."""
    most: FloatArray
    """Upper bound over each box (m, n)."""
    at: FloatArray
    """Lower bound at one design of each box (m, n)."""
    slopes: Interval
    """Slopes by each of the d free variables (d, m, n)."""
    rounding: FloatArray
    """Rounding of the excess at the one design (m, n)."""

    @classmethod
    def from_sloped_value(cls, excess: SlopedInterval, angle_count: int = 1) -> "Excesses":
        """The excess over one limit at ``angle_count`` cam angles, one after the other, for each box."""
        columns = excess.value.low, excess.value.high, excess.at.low, excess.at.high - excess.at.low
        least, most, at, rounding = (x.reshape(angle_count, -1) for x in columns)
        return cls(least, most, at, excess.slopes.reshape(-1, angle_count, at.shape[1]), rounding)


def concatenate_excesses(parts: list[Excesses]) -> Excesses:
    """Excesses of the same boxes, one after the other."""
    least, most, at, rounding = (np.concatenate([getattr(c, name) for c in parts]) for name in ARRAY_FIELDS)
    slopes = Interval(*(np.concatenate([getattr(c.slopes, end) for c in parts], axis=1) for end in ("low", "high")))
    return Excesses(least, most, at, slopes, rounding)


def choose_cut_side(excesses: Excesses, span: Interval) -> Any:
    """The side across which the excess over the worst limit changes the most."""
    worst = np.argmax(np.nan_to_num(excesses.at, nan=-np.inf), axis=0)
    steepest = np.take_along_axis(excesses.slopes.largest_magnitude, worst[None, None, :], axis=1)[:, 0]
    return np.argmax(np.where(np.isfinite(steepest), steepest, UNBOUNDED_SLOPE) * (span.high - span.low), axis=0)


def feasible_span(excesses: Excesses, span: Interval) -> Interval:
    """The part (d, n) of each side, relative to the point, in which every limit may be met.

    Let e be the excess at the point, less the most that the other variables can take off it. A feasible design at
    the distance t along the side has G·t ≤ −e.
    """
    changes = excesses.slopes * Interval(span.low[:, None], span.high[:, None])
    slack = SIDE_ROUNDING * (np.abs(excesses.at) + changes.largest_magnitude.sum(axis=0))
    low, high = span.low.copy(), span.high.copy()
    for k in range(len(low)):
        rest = excesses.at + np.delete(changes.low, k, axis=0).sum(axis=0) - slack
        is_cut = rest > 0.0
        below, above = -rest / excesses.slopes.high[k], -rest / excesses.slopes.low[k]
        smaller = ~is_cut | ((excesses.slopes.high[k] > 0.0) & (below >= span.low[k]))
        larger = ~is_cut | ((excesses.slopes.low[k] < 0.0) & (above <= span.high[k]))
        most = np.where(larger, span.high[k], np.where(smaller, below, -np.inf))
        least = np.where(smaller, span.low[k], np.where(larger, above, np.inf))
        low[k], high[k] = least.max(axis=0), most.min(axis=0)
    return Interval(low, high)


def feasible_box_ends_and_empty_boxes(
    excesses: Excesses, low: FloatArray, high: FloatArray, point: FloatArray
) -> tuple[FloatArray, FloatArray, Any]:
    """The ends (d, n) of boxes cut to ``feasible_span``, rounded outwards, and which boxes are empty (n,).

    The excesses are expanded about one point of each box.
    """
    span = Interval(low - point, high - point)
    part, rounding = feasible_span(excesses, span), SIDE_ROUNDING * (np.abs(point) + span.largest_magnitude)
    low, high = np.maximum(low, point + part.low - rounding), np.minimum(high, point + part.high + rounding)
    return low, high, np.any(excesses.least > 0.0, axis=0) | np.any(low > high, axis=0)


def append_weighted_sum(excesses: Excesses, multipliers: FloatArray) -> Excesses:
    """Excesses (m, n), followed by their sum weighted with multipliers (m,), which bounds a size.

    The multipliers of one box are valid for all boxes, and best for those near it.
    """
    active = np.flatnonzero(multipliers)
    if active.size < 2:
        return excesses
    weights = multipliers[active]
    ends = [
        np.tensordot(weights, end[:, active], (0, 1))[:, None]
        for end in (excesses.slopes.low, excesses.slopes.high)
    ]
    at = (weights @ excesses.at[active])[None]
    rounding, bound = (weights @ excesses.rounding[active])[None], np.full(at.shape, inf)
    at = at - SIDE_ROUNDING * (weights @ np.abs(excesses.at[active]))
    return concatenate_excesses([excesses, Excesses(-bound, bound, at, Interval(*ends), rounding)])


def solve_linear_programme(excesses: Excesses, span: Interval, size_index: int) -> tuple[FloatArray, FloatArray]:
    """The least size in the first box under the constraints linearised at its middle: multipliers and optimum.

    Without a solution, all multipliers are 0, and the optimum is the least size in the middle. The optimum (d,) and
    ``span``, each box (d, n), are relative to the middle.
    """
    width = span.high[:, 0] - span.low[:, 0]
    width = np.where(width > 0.0, width, 1.0)
    rows = width * (excesses.slopes.low + excesses.slopes.high)[..., 0].T / 2.0
    scale = np.abs(rows).max(axis=1)  # near 1, for the residuals of the solver
    usable = np.flatnonzero(np.isfinite(scale) & (scale > 0.0) & np.isfinite(excesses.at[:, 0]))
    weights, optimum = np.zeros(scale.size), np.where(np.arange(width.size) == size_index, span.low[:, 0], 0.0)
    if usable.size:
        ends = np.array([span.low[:, 0], span.high[:, 0]]).T / width[:, None]
        ends[size_index] = -inf, inf
        scale = scale[usable]
        solution = scipy.optimize.linprog(
            np.arange(width.size) == size_index,
            rows[usable] / scale[:, None],
            -excesses.at[usable, 0] / scale,
            bounds=ends,
        )
        if solution.status == 0:
            weights[usable] = np.maximum(-solution.ineqlin.marginals, 0.0) / scale
            optimum = solution.x * width
    return weights, optimum
