"""The derivative of a B-spline as a matrix of its coefficients.

Source: de Boor, A Practical Guide to Splines, ch. X.
"""

from typing import Any

import numpy as np
import scipy  # its sparse matrices when they are used

from camopt.core.numerics import FloatArray


def derivative_matrix(knots: FloatArray, degree: int, order: int) -> Any:
    """From the coefficients of a spline to those of a derivative, which has the inner ones of its knots."""
    matrix = scipy.sparse.eye_array(knots.size - degree - 1, format="csr")
    for level in range(degree, degree - order, -1):
        knots = knots[1:-1]
        widths = knots[level:] - knots[:-level]
        per = level * np.divide(1.0, widths, out=np.zeros_like(widths), where=widths > 0.0)
        matrix = scipy.sparse.diags_array(per, format="csr") @ (matrix[1:] - matrix[:-1])
    return matrix
