"""The reference: extremes with 50 digits, by the formulas of curves on numbers of mpmath.

The motion is that of the table, with its polynomials as exact numbers. Their difference from the laws is far below
the compared errors (``numerics.piecewise``). The extreme is searched near its cam angle in doubles: at a root of
the slope, or at the end of a piece.
"""

from functools import cache, partial, reduce
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST_MAGNITUDE, LEAST
from camopt.core.numerics.curves import value_and_slope
from camopt.core.numerics.state import State
from camopt.model.mechanisms import Designs
from camopt.model.motion.programme import Programme
from camopt.show.studies.accuracy.digits import Digits, as_fifty_digit_number, fifty_digit_context

EQUAL_DIGITS = 1e-25
"""Relative error that the reference stays below."""
SEARCH_WIDTH, PANEL_OVERLAP = 1e-3, 1e-9
"""In halves of a panel: search width around the place in doubles, and overlap of panels."""
MOST_ROOT_STEPS = 200


def fifty_digit_extreme_near(
    make_curve: Any, stroke_kinds: int, goal: int, design: Designs, programme: Programme, cam_angle: float
) -> Any:
    """The extreme of a curve of one design near a cam angle [rad], as a number of mpmath."""
    curve, table = make_curve(design, programme), programme.table
    u = (cam_angle - table.centre) / table.half_width
    values = []
    for panel in np.flatnonzero(programme.panels_with_kinds(stroke_kinds) & (np.abs(u) <= 1.0 + PANEL_OVERLAP)):
        low, high = (
            fifty_digit_context().mpf(float(end))
            for end in np.clip([u[panel] - SEARCH_WIDTH, u[panel] + SEARCH_WIDTH], -1.0, 1.0)
        )
        value_and_slope_at = cache(partial(_value_and_slope, curve, _panel_motion_polynomials(table, panel)))
        places = [low, high, *_root_of_slope(value_and_slope_at, low, high)]
        values += [value_and_slope_at(place)[0] for place in places]
    if goal == LARGEST_MAGNITUDE:
        return max(map(abs, values))
    return min(values) if goal == LEAST else max(values)


def _root_of_slope(value_and_slope_at: Any, low: Any, high: Any) -> list[Any]:
    """The root of the slope of a curve between two places, by the Illinois method; empty without one."""
    (far, far_slope), (place, slope) = ((end, value_and_slope_at(end)[1]) for end in (low, high))
    if far_slope * slope >= 0:
        return []
    for _ in range(MOST_ROOT_STEPS):
        last, last_slope = place, slope
        place -= slope * (place - far) / (slope - far_slope)
        slope = value_and_slope_at(place)[1]
        if slope == 0 or abs(place - last) < EQUAL_DIGITS:
            break
        if slope * last_slope < 0:
            far, far_slope = last, last_slope
        else:  # the far end stays a second time
            far_slope /= 2
    return [place]


def _panel_motion_polynomials(table: Any, panel: Any) -> list[list[Any]]:
    """Polynomials of a panel: displacement and its four derivatives by cam angle, as exact numbers."""
    number, half = fifty_digit_context().mpf, fifty_digit_context().mpf(float(table.half_width[panel]))
    orders = [[number(float(c)) for c in table.coefficients[panel]]]
    for _ in range(4):
        orders.append([k * c / half for k, c in enumerate(orders[-1])][1:])
    return orders


def _polynomial_value(series: list[Any], u: Any) -> Digits:
    """Value of a polynomial, by Horner's rule."""
    return Digits(reduce(lambda value, power: value * u + power, reversed(series)))


def _value_and_slope(curve: Any, motion: list[list[Any]], u: Any) -> tuple[Any, Any]:
    """Value and slope of a curve at a place u of a panel."""
    y, y1, y2, y3, y4 = (_polynomial_value(series, u) for series in motion)
    value, slope = value_and_slope(curve, ..., State(y, y1, y2, y3, None, y4))
    return as_fifty_digit_number(value), as_fifty_digit_number(slope)
