"""Elementary functions in forms that keep their digits."""

from typing import Any

import numpy as np

from camopt.numerics import FloatArray
from camopt.numerics.interval import Interval, as_interval


def angle_minus_sine(t: FloatArray) -> FloatArray:
    """t − sin t without cancellation, for any t ≥ 0.

    Below 0.5 by the alternating series t³/3! − t⁵/5! + …, whose ninth term is under 1e-21 of the first.
    """
    t = np.asarray(t, dtype=float)
    small = np.minimum(t, 0.5)
    square = small * small
    term = small * square / 6.0
    total = np.zeros_like(small)
    for k in range(9):
        total = total + term
        term = -term * square / ((2 * k + 4) * (2 * k + 5))
    return np.where(t < 0.5, total, t - np.sin(t))


def difference_of_squares_root(a: Any, b: Any) -> Any:
    """√(a² − b²) as √((a−b)(a+b)), for a ≥ 0; 0 where |b| > a.

    For intervals it rises with a and falls with |b|, so its ends are exact: by the product it would not know
    that both factors hold the same b.
    """
    if isinstance(a, Interval) or isinstance(b, Interval):
        a, b = as_interval(a), as_interval(b)
        low = difference_of_squares_root(a.low, b.largest_magnitude)
        return Interval(low, difference_of_squares_root(a.high, b.least_magnitude))
    return np.sqrt(np.maximum((a - b) * (a + b), 0.0))
