"""The B-splines of a row of knots as matrices: from coefficients to values, and to coefficients of the derivative.

Source: de Boor, A Practical Guide to Splines, ch. IX and X.
"""

from typing import Any

import numpy as np
from scipy import sparse

from camopt.numerics import FloatArray


def basis_matrix(knots: FloatArray, degree: int, x: FloatArray) -> Any:
    """The value at each x of each B-spline (x.size, knots.size − degree − 1): degree + 1 of them in a row.

    x are from the first to the last knot, of which there are degree + 1 each; at a knot the span after it counts.
    """
    count = knots.size - degree - 1
    span = np.clip(np.searchsorted(knots, x, side="right") - 1, degree, count - 1)
    values = np.ones((1, x.size))
    for level in range(1, degree + 1):
        left = span + np.arange(1 - level, 1)[:, None]
        start, end = knots[left], knots[left + level]
        rising, falling = ((part / (end - start) * values) for part in (x - start, end - x))
        values = np.concatenate([falling, np.zeros((1, x.size))])
        values[1:] += rising
    columns = span[:, None] + np.arange(-degree, 1)
    starts = (degree + 1) * np.arange(x.size + 1)
    return sparse.csr_array((values.T.ravel(), columns.ravel(), starts), shape=(x.size, count))


def derivative_matrix(knots: FloatArray, degree: int, order: int) -> Any:
    """From the coefficients of a spline to those of a derivative, which has the inner ones of its knots."""
    matrix = sparse.eye_array(knots.size - degree - 1, format="csr")
    for level in range(degree, degree - order, -1):
        knots = knots[1:-1]
        widths = knots[level:] - knots[:-level]
        per = level * np.divide(1.0, widths, out=np.zeros_like(widths), where=widths > 0.0)
        matrix = sparse.diags_array(per, format="csr") @ (matrix[1:] - matrix[:-1])
    return matrix
