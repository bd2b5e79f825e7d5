"""Work over a turn: sums, products, integrals and extremes of panel polynomials.

A series is an array (powers, panels): on each panel of a programme a polynomial in u ∈ [−1, 1]. What is made of the
motion by sums, products and integrals is one again, so that nothing here is sampled.
"""

from functools import cache
from math import comb, inf

import numpy as np
from numpy.polynomial import polynomial

from camopt.numerics import FloatArray
from camopt.numerics.piecewise import MotionTable, bernstein

WORK_ERROR = 2.0**-46  # of the largest magnitude: above the rounding of a halving of degree 30, so that it ends


def derivative(table: MotionTable, order: int) -> FloatArray:
    """A derivative of y by cam angle."""
    return np.asarray(polynomial.polyder(table.coefficients.T, order) / table.half_width**order)


def added(*terms: FloatArray) -> FloatArray:
    """The sum of series of any degrees."""
    total = np.zeros((max(len(term) for term in terms), terms[0].shape[1]))
    for term in terms:
        total[: len(term)] += term
    return total


def product(a: FloatArray, b: FloatArray) -> FloatArray:
    found = np.zeros((len(a) + len(b) - 1, a.shape[1]))
    for power, row in enumerate(b):
        found[power : power + len(a)] += row * a
    return found


def integral(half_width: FloatArray, series: FloatArray) -> FloatArray:
    """The integral over the cam angle from the start of the turn, as a series on panels of these half-widths."""
    found = polynomial.polyint(series) * half_width
    found[0] -= polynomial.polyval(-1.0, found)
    found[0, 1:] += np.cumsum(polynomial.polyval(1.0, found))[:-1]
    return np.asarray(found)


def total(half_width: FloatArray, series: FloatArray) -> float:
    """The integral over the whole turn; only even powers contribute."""
    even = series[::2]
    return float(np.sum(2.0 / np.arange(1, 2 * len(even), 2) @ even * half_width))


def largest_of_series(series: FloatArray) -> float:
    """The largest value of a series, to WORK_ERROR of its largest magnitude.

    Bernstein coefficients enclose a polynomial, and the first and the last are its values at the ends. Parts of
    panels that may hold more than the largest value seen are halved.
    """
    parts, halving = bernstein(len(series) - 1) @ series, _halving(len(series) - 1)
    room, best = WORK_ERROR * np.abs(parts).max(), -inf
    while parts.size:
        best = max(best, float(parts[[0, -1]].max()))
        parts = parts[:, parts.max(axis=0) > best + room]
        parts = np.concatenate([halving @ parts, (halving @ parts[::-1])[::-1]], axis=1)
    return best


@cache
def _halving(degree: int) -> FloatArray:
    """Matrix from Bernstein coefficients to those of the first half (de Casteljau)."""
    return np.array([[comb(i, k) * 0.5**i for k in range(degree + 1)] for i in range(degree + 1)])
