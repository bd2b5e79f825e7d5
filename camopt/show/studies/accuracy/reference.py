"""The reference: extremes with 50 digits, by the formulas of curves on numbers of mpmath.

The motion is that of the table, with its polynomials as exact numbers. Their difference from the laws is far below
the compared errors (``numerics.piecewise``). The extreme is searched near its cam angle in doubles: at a root of
the slope, or at the end of a piece.
"""

from functools import reduce
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST_MAGNITUDE, LEAST
from camopt.core.numerics.curves import value_and_slope
from camopt.core.numerics.state import State
from camopt.model.mechanisms import Designs
from camopt.model.motion.programme import Programme
from camopt.show.studies.accuracy.digits import Digits, arithmetic, as_number

EQUAL_DIGITS = 1e-25
"""Relative error that the reference stays below."""
SEARCH_WIDTH, PANEL_OVERLAP = 1e-3, 1e-9
"""In halves of a panel: search width around the place in doubles, and overlap of panels."""
MOST_ROOT_STEPS = 200


def extreme_near(
    make_curve: Any, kinds: int, goal: int, design: Designs, programme: Programme, cam_angle: float
) -> Any:
    """The extreme of a curve of one design near a cam angle [rad], as a number of mpmath."""
    curve, table = make_curve(design, programme), programme.table
    u = (cam_angle - table.centre) / table.half_width
    values = []
    for panel in np.flatnonzero(programme.panels_with_kinds(kinds) & (np.abs(u) <= 1.0 + PANEL_OVERLAP)):
        low, high = (
            arithmetic().mpf(float(end))
            for end in np.clip([u[panel] - SEARCH_WIDTH, u[panel] + SEARCH_WIDTH], -1.0, 1.0)
        )
        places = [low, high, *_root_of_slope(curve, table, panel, low, high)]
        values += [_value_and_slope(curve, table, panel, place)[0] for place in places]
    if goal == LARGEST_MAGNITUDE:
        return max(map(abs, values))
    return min(values) if goal == LEAST else max(values)


def _root_of_slope(curve: Any, table: Any, panel: Any, low: Any, high: Any) -> list[Any]:
    """The root of the slope of a curve between two places of a panel, by the Illinois method; empty without one."""
    before, after = (_value_and_slope(curve, table, panel, place)[1] for place in (low, high))
    if before * after >= 0:
        return []
    for _ in range(MOST_ROOT_STEPS):
        place = (low * after - high * before) / (after - before)
        if not low < place < high or high - low < EQUAL_DIGITS:
            break
        slope = _value_and_slope(curve, table, panel, place)[1]
        if slope * after > 0:
            high, after, before = place, slope, before / 2
        else:
            low, before, after = place, slope, after / 2
        if slope == 0:
            break
    return [(low * after - high * before) / (after - before)]


def _polynomial_value(series: list[Any], u: Any) -> Any:
    """Value of a polynomial, by Horner's rule."""
    return reduce(lambda value, power: value * u + power, reversed(series))


def _value_and_slope(curve: Any, table: Any, panel: Any, u: Any) -> tuple[Any, Any]:
    """Value and slope of a curve at a place u of a panel."""
    number, half = arithmetic().mpf, arithmetic().mpf(float(table.half_width[panel]))
    series, rows = [number(float(c)) for c in table.coefficients[panel]], []
    for order in range(5):
        rows.append(Digits(_polynomial_value(series, u) / half**order))
        series = [k * c for k, c in enumerate(series)][1:]
    y, y1, y2, y3, y4 = rows
    value, slope = value_and_slope(curve, ..., State(y, y1, y2, y3, None, y4))
    return as_number(value), as_number(slope)
