"""The derivative of a B-spline as a matrix on its coefficients.

Source: de Boor, A Practical Guide to Splines, ch. X.
"""

from typing import Any

import numpy as np
import scipy  # loads sparse matrices at their first use

from camopt.core.numerics import FloatArray


def derivative_matrix(knots: FloatArray, degree: int, order: int) -> Any:
    """Matrix from a spline's coefficients to those of a derivative, whose knots are the inner ones."""
    matrix = scipy.sparse.eye_array(knots.size - degree - 1, format="csr")
    for level in range(degree, degree - order, -1):
        knots = knots[1:-1]
        widths = knots[level:] - knots[:-level]
        per = level * np.divide(1.0, widths, out=np.zeros_like(widths), where=widths > 0.0)
        matrix = scipy.sparse.diags_array(per, format="csr") @ (matrix[1:] - matrix[:-1])
    return matrix
