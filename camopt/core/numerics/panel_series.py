"""Sums, products, integrals and extremes of polynomials on the panels of a turn.

A series is an array (powers, panels), or (powers, settings, panels): a polynomial in u ∈ [−1, 1] on each panel of a
programme. Sums, products and integrals of series are series, so nothing here is sampled.
"""

from math import inf

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import FloatArray, Number
from camopt.core.numerics.piecewise import MotionTable, halve_bernstein, powers_to_bernstein_matrix
from camopt.core.numerics.stable_functions import matrix_product

WORK_ERROR = 2.0**-46  # of the largest magnitude: more than the rounding of a halving at degree 30, so halving ends


def derivative_polynomials_by_panel(table: MotionTable, order: int) -> FloatArray:
    """A derivative of y by the cam angle, as a series."""
    return np.asarray(polynomial.polyder(table.coefficients.T, order) / table.half_width**order)


def sum_series(*terms: FloatArray) -> FloatArray:
    shape = np.broadcast_shapes(*(term.shape[1:] for term in terms))
    total = np.zeros((max(len(term) for term in terms), *shape))
    for term in terms:
        total[: len(term)] += term
    return total


def multiply_series(a: FloatArray, b: FloatArray) -> FloatArray:
    product = np.zeros((len(a) + len(b) - 1, *np.broadcast_shapes(a.shape[1:], b.shape[1:])))
    for power, row in enumerate(b):
        product[power : power + len(a)] += row * a
    return product


def integrate_series(half_width: FloatArray, series: FloatArray) -> FloatArray:
    """Integral over the cam angle from the start of the turn, as a series on panels of these half-widths."""
    integral = polynomial.polyint(series) * half_width
    integral[0] -= polynomial.polyval(-1.0, integral)
    integral[0, ..., 1:] += np.cumsum(polynomial.polyval(1.0, integral), axis=-1)[..., :-1]
    return np.asarray(integral)


def turn_integral(half_width: FloatArray, series: FloatArray) -> Number:
    """Integral over the whole turn, (settings,) if the series has settings; only even powers contribute."""
    even = series[::2]
    return matrix_product(matrix_product(2.0 / np.arange(1, 2 * len(even), 2), even), half_width)[()]


def largest_value_of_series(series: FloatArray) -> Number:
    """Largest value of a series, (settings,) if it has settings, to WORK_ERROR of its largest magnitude.

    Bernstein coefficients enclose a polynomial; the first and the last are its values at the ends. Parts of panels
    that may exceed the largest value so far are halved.
    """
    panels, degree = series.shape[-1], len(series) - 1
    parts = matrix_product(powers_to_bernstein_matrix(degree), series.reshape(len(series), -1))
    owner = np.arange(parts.shape[1]) // panels
    best = np.full(owner.size // panels, -inf)
    room = WORK_ERROR * np.abs(parts).max(axis=0).reshape(-1, panels).max(axis=1)
    while owner.size:
        np.maximum.at(best, owner, parts[[0, -1]].max(axis=0))
        above = parts.max(axis=0) > (best + room)[owner]
        owner = np.tile(owner[above], 2)
        parts = np.concatenate(halve_bernstein(parts[:, above]), axis=1)
    return best.reshape(series.shape[1:-1])[()]
