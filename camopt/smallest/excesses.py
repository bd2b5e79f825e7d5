"""Excesses of limits over boxes of designs, and the part of a box that they leave.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 8 (interval Newton).
"""

from typing import Any, NamedTuple

import numpy as np

from camopt.numerics import FloatArray
from camopt.numerics.interval import Interval
from camopt.numerics.sloped import Sloped

SIDE_ROUNDING = 1e-15  # relative, of an end of a side
HUGE_SLOPE = 1e300  # in place of a slope without bounds
EXCESS_ROUNDING = 1e-11  # relative: no excess above it is rounding


BY_BOX = ("least", "most", "at", "rounding")


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
    def of(cls, excess: Sloped, rows: int = 1) -> "Excesses":
        """The excess over one limit at ``rows`` cam angles, one after the other, for each box."""
        known = excess.value.low, excess.value.high, excess.at.low, excess.at.high - excess.at.low
        least, most, at, rounding = (x.reshape(rows, -1) for x in known)
        return cls(least, most, at, excess.slopes.reshaped(-1, rows, at.shape[1]), rounding)

    @property
    def surely(self) -> Any:
        """Over which boxes some limit is exceeded (n,)."""
        return np.any(self.least > 0.0, axis=0)

    @property
    def nowhere(self) -> Any:
        """Over which boxes no limit is seen to be exceeded by more than rounding (n,)."""
        return np.all(self.most <= np.fmin(self.rounding, EXCESS_ROUNDING), axis=0)


def chained_excesses(parts: list[Excesses]) -> Excesses:
    """Excesses of the same boxes, one after the other."""
    least, most, at, rounding = (np.concatenate([getattr(c, name) for c in parts]) for name in BY_BOX)
    slopes = Interval(*(np.concatenate([getattr(c.slopes, end) for c in parts], axis=1) for end in ("low", "high")))
    return Excesses(least, most, at, slopes, rounding)


def widest(over: Excesses, span: Interval) -> Any:
    """The side across which the excess over the worst limit changes the most."""
    worst = np.argmax(np.nan_to_num(over.at, nan=-np.inf), axis=0)
    steepest = np.take_along_axis(over.slopes.largest_magnitude, worst[None, None, :], axis=1)[:, 0]
    width = span.high - span.low
    return np.argmax(np.where(np.isfinite(steepest), steepest, HUGE_SLOPE) * width, axis=0)


def cut_off(over: Excesses, span: Interval) -> Interval:
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


def cut_by(
    over: Excesses, low: FloatArray, high: FloatArray, point: FloatArray
) -> tuple[FloatArray, FloatArray, Any]:
    """The ends (d, n) of boxes after cutting (``cut_off``), rounded outwards, and which are empty (n,).

    The excesses are seen from a point of each box.
    """
    span = Interval(low - point, high - point)
    left, rounding = cut_off(over, span), SIDE_ROUNDING * (np.abs(point) + span.largest_magnitude)
    low, high = np.maximum(low, point + left.low - rounding), np.minimum(high, point + left.high + rounding)
    return low, high, over.surely | np.any(low > high, axis=0)
