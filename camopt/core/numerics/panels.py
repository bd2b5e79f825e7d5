"""Polynomials on panels, for kernels: values, and jets over a panel, a group of panels or a part of a panel.

A table has ``coefficients`` (P, TABLE_DEGREE + 1) in powers of u ∈ [−1, 1] and ``half_width`` (P,). Its rows are P
panels and groups of panels. For each row it has ``low``, ``high`` and ``error`` of y and four derivatives by the
cam angle, and the largest magnitudes ``most`` of y and six derivatives.
"""

import numpy as np

from camopt.core.kernels.marks import inline_in_kernels_by_overload
from camopt.core.numerics.jet import Jet, smaller

TABLE_DEGREE = 12  # high enough that truncating trigonometric laws errs less than rounding, even in the jerk


@inline_in_kernels_by_overload
def value_and_three_derivatives(table, panel, u):
    """(y, y', y'', y''') by the cam angle at u of a panel, by Horner's scheme."""
    y = table.coefficients[panel, TABLE_DEGREE]
    d1 = d2 = d3 = 0.0
    for k in range(TABLE_DEGREE - 1, -1, -1):
        d3 = d3 * u + d2
        d2 = d2 * u + d1
        d1 = d1 * u + y
        y = y * u + table.coefficients[panel, k]
    h = table.half_width[panel]
    return y, d1 / h, 2.0 * d2 / (h * h), 6.0 * d3 / (h * h * h)


@inline_in_kernels_by_overload
def fourth_derivative(table, panel, u):
    """y'''' by the cam angle at u of a panel."""
    value = 0.0
    for k in range(TABLE_DEGREE, 3, -1):
        value = value * u + k * (k - 1.0) * (k - 2.0) * (k - 3.0) * table.coefficients[panel, k]
    return value / np.square(np.square(table.half_width[panel]))


@inline_in_kernels_by_overload
def displacement_jets_over_row(table, row):
    """Jets of y and three derivatives over a panel or group."""
    low, high, most, error = table.low[row], table.high[row], table.most[row], table.error[row]
    return (
        Jet(low[0], high[0], error[0], most[1], most[2], most[3]),
        Jet(low[1], high[1], error[1], most[2], most[3], most[4]),
        Jet(low[2], high[2], error[2], most[3], most[4], most[5]),
        Jet(low[3], high[3], error[3], most[4], most[5], most[6]),
    )


@inline_in_kernels_by_overload
def fourth_derivative_jet_over_row(table, row):
    """Jet of y'''' over a panel or group."""
    low, high, most, error = table.low[row], table.high[row], table.most[row], table.error[row]
    return Jet(low[4], high[4], error[4], most[5], most[6], np.inf)


@inline_in_kernels_by_overload
def fourth_derivative_jet_over_part(table, panel, u, half_length):
    """Jet of y'''' over the part [u − r, u + r] of a panel."""
    most, y4 = table.most[panel], fourth_derivative(table, panel, u)
    room = half_length * table.half_width[panel] * most[5]
    return Jet(y4 - room, y4 + room, table.error[panel][4], most[5], most[6], np.inf)


@inline_in_kernels_by_overload
def displacement_jets_over_part(table, panel, u, half_length):
    """Jets of y and three derivatives over the part [u − r, u + r] of a panel, by the mean value theorem."""
    y, y1, y2, y3 = value_and_three_derivatives(table, panel, u)
    most, error, h = table.most[panel], table.error[panel], table.half_width[panel]
    w = half_length * h
    d3 = smaller(abs(y3) + w * most[4], most[3])
    d2 = smaller(abs(y2) + w * d3, most[2])
    d1 = smaller(abs(y1) + w * d2, most[1])
    return (
        Jet(y - w * d1, y + w * d1, error[0], d1, d2, d3),
        Jet(y1 - w * d2, y1 + w * d2, error[1], d2, d3, most[4]),
        Jet(y2 - w * d3, y2 + w * d3, error[2], d3, most[4], most[5]),
        Jet(y3 - w * most[4], y3 + w * most[4], error[3], most[4], most[5], most[6]),
    )
