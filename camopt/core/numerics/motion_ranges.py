"""The motion over parts of panels, as sloped intervals by the cam angle, for proofs.

A motion table has polynomials, and bounds of their errors (``numerics.piecewise``).
"""

from dataclasses import replace
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray, IntArray
from camopt.core.numerics.interval import Interval, widen
from camopt.core.numerics.panels import TABLE_DEGREE, fourth_derivative, value_and_three_derivatives
from camopt.core.numerics.sloped_interval import SlopedInterval, box_variables

STEEPEST = (TABLE_DEGREE - 3.0) ** 2
"""Largest slope of a polynomial of the jerk's degree on [−1, 1], divided by its largest value there (Markov)."""


def part_middles_and_angle_intervals(
    table: Any, panel: IntArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, SlopedInterval]:
    """Middles of parts of panels (from −1 to 1), and the cam angle over each part from the middle of its panel."""
    u, half = (low + high) / 2.0, table.half_width[panel]
    (angle,) = box_variables([Interval(low * half, high * half)], [u * half])
    return u, angle


def derivative_intervals_over_parts(
    table: Any, panel: IntArray, u: FloatArray, angle: SlopedInterval, derivative_count: int
) -> list[Any]:
    """The first ``derivative_count`` derivatives over parts of panels, y first, and the range of the next one.

    Each is known at ``u``, the middle of the part, and the next derivative bounds its change over the part.
    """
    middle = (*value_and_three_derivatives(table, panel, u), fourth_derivative(table, panel, u))
    error, most = [*table.error[panel].T], [*table.most[panel].T]
    steepest = STEEPEST / table.half_width[panel]
    error[4] = np.maximum(error[4], steepest * error[3])
    most[5] = most[5] + steepest * error[4]
    room = angle.span.largest_magnitude[0]
    distance, following = Interval(-room, room), Interval(-most[derivative_count + 1], most[derivative_count + 1])
    terms = list[Any]()
    for order in range(derivative_count, -1, -1):
        at_middle = widen(Interval(middle[order] - error[order], middle[order] + error[order]))
        mean_value = widen(at_middle + following * distance)
        value = Interval(
            np.maximum(mean_value.low, table.low[panel, order] - error[order]),
            np.minimum(mean_value.high, table.high[panel, order] + error[order]),
        )
        slopes = slopes_of_function_of_angle(angle, following)
        terms.append(
            value if order == derivative_count else replace(angle, value=value, at=at_middle, slopes=slopes)
        )
        following = value
    return terms[::-1]


def slopes_of_function_of_angle(angle: SlopedInterval, slope: Interval) -> Interval:
    """Slopes of a quantity that depends only on the cam angle."""
    low, high = np.zeros((2, *angle.slopes.low.shape))
    low[0], high[0] = slope.low, slope.high
    return Interval(low, high)
