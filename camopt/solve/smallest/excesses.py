"""Excesses of limits over boxes of designs, and the part of a box that they leave.

Two limits together bound a size more closely than each alone. With e_j ≤ 0 the constraints of a feasible cam, and
weights w_j ≥ 0, Σ w_j·e_j ≤ 0 holds too. Where a cam is held by several limits at once, the right weights cancel
the slopes by all angles and sizes but the cam's own, and the sum bounds that: they are the multipliers of the
linear programme that the constraints are at the middle of a box.

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

SIDE_ROUNDING = 1e-15  # relative, of an end of a side
UNBOUNDED_SLOPE = 1e300  # in place of a slope without bounds
EXCESS_ROUNDING = 1e-11  # relative: no excess above it is rounding
ARRAY_FIELDS = ("least", "most", "at", "rounding")


class Excesses(NamedTuple):
    """The excess of n boxes over the limits at m cam angles, relative: above 0 no design is feasible."""

    least: FloatArray
    """Over each box (m, n)."""
    most: FloatArray
    """Over each box (m, n)."""
    at: FloatArray
    """At one design of each box, no more than it is (m, n)."""
    slopes: Interval
    """By each of the d free sizes (d, m, n)."""
    rounding: FloatArray
    """Of the excess at one design (m, n)."""

    @classmethod
    def from_sloped_value(cls, excess: SlopedInterval, rows: int = 1) -> "Excesses":
        """The excess over one limit at ``rows`` cam angles, one after the other, for each box."""
        known = excess.value.low, excess.value.high, excess.at.low, excess.at.high - excess.at.low
        least, most, at, rounding = (x.reshape(rows, -1) for x in known)
        return cls(least, most, at, excess.slopes.reshape(-1, rows, at.shape[1]), rounding)

    @property
    def is_exceeded(self) -> Any:
        """Over which boxes some limit is exceeded (n,)."""
        return np.any(self.least > 0.0, axis=0)

    @property
    def is_within_rounding(self) -> Any:
        """Over which boxes no limit is seen to be exceeded by more than rounding (n,)."""
        return np.all(self.most <= np.fmin(self.rounding, EXCESS_ROUNDING), axis=0)


def chained_excesses(parts: list[Excesses]) -> Excesses:
    """Excesses of the same boxes, one after the other."""
    least, most, at, rounding = (np.concatenate([getattr(c, name) for c in parts]) for name in ARRAY_FIELDS)
    slopes = Interval(*(np.concatenate([getattr(c.slopes, end) for c in parts], axis=1) for end in ("low", "high")))
    return Excesses(least, most, at, slopes, rounding)


def widest_side(over: Excesses, span: Interval) -> Any:
    """The side across which the excess over the worst limit changes the most."""
    worst = np.argmax(np.nan_to_num(over.at, nan=-np.inf), axis=0)
    steepest = np.take_along_axis(over.slopes.largest_magnitude, worst[None, None, :], axis=1)[:, 0]
    width = span.high - span.low
    return np.argmax(np.where(np.isfinite(steepest), steepest, UNBOUNDED_SLOPE) * width, axis=0)


def feasible_span(over: Excesses, span: Interval) -> Interval:
    """The parts (d, n) of each side, seen from the point, in which every limit may be held.

    With e the excess at the point less what other sizes can take off it, G·t ≤ −e has to hold at the distance t.
    """
    moved = over.slopes * Interval(span.low[:, None], span.high[:, None])
    slack = SIDE_ROUNDING * (np.abs(over.at) + moved.largest_magnitude.sum(axis=0))
    low, high = span.low.copy(), span.high.copy()
    for k in range(len(low)):
        others = np.delete(moved.low, k, axis=0).sum(axis=0)
        rest = over.at + others - slack
        asked = rest > 0.0
        below, above = -rest / over.slopes.high[k], -rest / over.slopes.low[k]
        smaller = ~asked | ((over.slopes.high[k] > 0.0) & (below >= span.low[k]))
        larger = ~asked | ((over.slopes.low[k] < 0.0) & (above <= span.high[k]))
        most = np.where(larger, span.high[k], np.where(smaller, below, -np.inf))
        least = np.where(smaller, span.low[k], np.where(larger, above, np.inf))
        low[k], high[k] = least.max(axis=0), most.min(axis=0)
    return Interval(low, high)


def cut_boxes(
    over: Excesses, low: FloatArray, high: FloatArray, point: FloatArray
) -> tuple[FloatArray, FloatArray, Any]:
    """The ends (d, n) of boxes after cutting (``feasible_span``), rounded outwards, and which are empty (n,).

    The excesses are seen from a point of each box.
    """
    span = Interval(low - point, high - point)
    left, rounding = feasible_span(over, span), SIDE_ROUNDING * (np.abs(point) + span.largest_magnitude)
    low, high = np.maximum(low, point + left.low - rounding), np.minimum(high, point + left.high + rounding)
    return low, high, over.is_exceeded | np.any(low > high, axis=0)


def with_weighted_sum(over: Excesses, span: Interval, size: int) -> Excesses:
    """Excesses (m, n) and, after them, their sum with the weights that bound a size of the first box the most.

    The weights serve all boxes, those near the first one best. ``span`` is each box from its middle (d, n).
    """
    weights = _constraint_multipliers(over, span, size)
    some = np.flatnonzero(weights)
    if some.size < 2:
        return over
    ends = [
        np.tensordot(weights[some], end[:, some], (0, 1))[:, None] for end in (over.slopes.low, over.slopes.high)
    ]
    at = (weights[some] @ over.at[some])[None]
    rounding, bound = (weights[some] @ over.rounding[some])[None], np.full(at.shape, inf)
    at = at - SIDE_ROUNDING * (weights[some] @ np.abs(over.at[some]))
    return chained_excesses([over, Excesses(-bound, bound, at, Interval(*ends), rounding)])


def _constraint_multipliers(over: Excesses, span: Interval, size: int) -> FloatArray:
    """The multiplier of each constraint where the size is least over the first box, whatever its range there."""
    width = span.high[:, 0] - span.low[:, 0]
    width = np.where(width > 0.0, width, 1.0)
    rows = width * (over.slopes.low + over.slopes.high)[..., 0].T / 2.0
    scale = np.abs(rows).max(axis=1)  # near 1, for the residuals of the solver
    usable = np.flatnonzero(np.isfinite(scale) & (scale > 0.0) & np.isfinite(over.at[:, 0]))
    weights = np.zeros(scale.size)
    if usable.size:
        ends = np.array([span.low[:, 0], span.high[:, 0]]).T / width[:, None]
        ends[size] = -inf, inf
        by = scale[usable]
        found = scipy.optimize.linprog(
            np.arange(width.size) == size, rows[usable] / by[:, None], -over.at[usable, 0] / by, bounds=ends
        )
        if found.status == 0:
            weights[usable] = np.maximum(-found.ineqlin.marginals, 0.0) / by
    return weights
