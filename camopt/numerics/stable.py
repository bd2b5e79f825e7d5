"""Elementary functions in forms that keep their digits."""

import numpy as np

from camopt.numerics import FloatArray


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


def difference_of_squares_root(a: FloatArray, b: FloatArray) -> FloatArray:
    """√(a² − b²) as √((a−b)(a+b)); 0 where |b| > a."""
    return np.sqrt(np.maximum((a - b) * (a + b), 0.0))
