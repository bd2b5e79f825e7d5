"""The motion over parts of panels, as ranges with slopes by the cam angle: what formulas run on in proofs.

Of the motion a table has polynomials, and bounds of what these and their values are off (``numerics.piecewise``).
"""

from dataclasses import replace
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray, IntArray
from camopt.core.numerics.interval import Interval, widen
from camopt.core.numerics.panels import TABLE_DEGREE, derivatives, fourth_derivative
from camopt.core.numerics.sloped_interval import SlopedInterval, box_variables

STEEPEST = (TABLE_DEGREE - 3.0) ** 2
"""How steep a polynomial of the degree of the jerk is on [−1, 1] at most, by its largest value there (Markov)."""


def angle_over(table: Any, panel: IntArray, low: FloatArray, high: FloatArray) -> tuple[FloatArray, SlopedInterval]:
    """The middles of parts of panels (from −1 to 1), and the cam angle over each, from the middle of its panel."""
    u, half = (low + high) / 2.0, table.half_width[panel]
    (angle,) = box_variables([Interval(low * half, high * half)], [u * half])
    return u, angle


def derivatives_over(table: Any, panel: IntArray, u: FloatArray, angle: SlopedInterval, count: int) -> list[Any]:
    """Some derivatives of a table over parts of panels, the value first, and the range of the next one.

    ``u`` is the middle of each part. Each is known there, and changes by no more than the next one lets it.
    """
    middle = (*derivatives(table, panel, u), fourth_derivative(table, panel, u))
    error, most = [*table.error[panel].T], [*table.most[panel].T]
    steepest = STEEPEST / table.half_width[panel]
    error[4] = np.maximum(error[4], steepest * error[3])
    most[5] = most[5] + steepest * error[4]
    room = angle.span.largest_magnitude[0]
    by, beyond = Interval(-room, room), Interval(-most[count + 1], most[count + 1])
    found = list[Any]()
    for order in range(count, -1, -1):
        known = widen(Interval(middle[order] - error[order], middle[order] + error[order]))
        moved = widen(known + beyond * by)
        value = Interval(
            np.maximum(moved.low, table.low[panel, order] - error[order]),
            np.minimum(moved.high, table.high[panel, order] + error[order]),
        )
        slopes = slopes_by_angle(angle, beyond)
        found.append(value if order == count else replace(angle, value=value, at=known, slopes=slopes))
        beyond = value
    return found[::-1]


def slopes_by_angle(angle: SlopedInterval, slope: Interval) -> Interval:
    """Slopes of what depends on the cam angle alone."""
    low, high = np.zeros((2, *angle.slopes.low.shape))
    low[0], high[0] = slope.low, slope.high
    return Interval(low, high)
