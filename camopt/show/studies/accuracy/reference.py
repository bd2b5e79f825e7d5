"""The reference: extremes in 50 digits, by the formulas of curves on numbers of mpmath.

The motion is that of the table, whose polynomials are exact numbers; what these are off their laws is far below the
errors that are compared (``numerics.piecewise``). An extreme is looked for where doubles have it: the slope of the
curve has its root there, or the piece ends.
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
"""Relative: what the reference is right to, and more."""
SEARCH_WIDTH, PANEL_OVERLAP = 1e-3, 1e-9
"""Of half a panel: how far from its place in doubles an extreme is looked for, and which panels that is in."""
MOST_ROOT_STEPS = 200


def extreme_near(make: Any, kinds: int, goal: int, design: Designs, programme: Programme, where: float) -> Any:
    """The extreme of a curve of one design (in digits) near a cam angle (rad), as a number of mpmath."""
    made, table = make(design, programme), programme.table
    u = (where - table.centre) / table.half_width
    found = []
    for panel in np.flatnonzero(programme.panels_of(kinds) & (np.abs(u) <= 1.0 + PANEL_OVERLAP)):
        low, high = (
            arithmetic().mpf(float(end))
            for end in np.clip([u[panel] - SEARCH_WIDTH, u[panel] + SEARCH_WIDTH], -1.0, 1.0)
        )
        places = [low, high, *_stationary_points(made, table, panel, low, high)]
        found += [_value_and_slope(made, table, panel, place)[0] for place in places]
    if goal == LARGEST_MAGNITUDE:
        return max(map(abs, found))
    return min(found) if goal == LEAST else max(found)


def _stationary_points(made: Any, table: Any, panel: Any, low: Any, high: Any) -> list[Any]:
    """Where the slope of a curve changes its sign between two places of a panel: by the Illinois method."""
    before, after = (_value_and_slope(made, table, panel, place)[1] for place in (low, high))
    if before * after >= 0:
        return []
    for _ in range(MOST_ROOT_STEPS):
        place = (low * after - high * before) / (after - before)
        if not low < place < high or high - low < EQUAL_DIGITS:
            break
        slope = _value_and_slope(made, table, panel, place)[1]
        if slope * after > 0:
            high, after, before = place, slope, before / 2
        else:
            low, before, after = place, slope, after / 2
        if slope == 0:
            break
    return [(low * after - high * before) / (after - before)]


def _polynomial_value(series: list[Any], u: Any) -> Any:
    """A polynomial of powers at a place."""
    return reduce(lambda value, power: value * u + power, reversed(series))


def _value_and_slope(made: Any, table: Any, panel: Any, u: Any) -> tuple[Any, Any]:
    """Value and slope of a curve at a place of a panel."""
    number, half = arithmetic().mpf, arithmetic().mpf(float(table.half_width[panel]))
    series, rows = [number(float(c)) for c in table.coefficients[panel]], []
    for order in range(5):
        rows.append(Digits(_polynomial_value(series, u) / half**order))
        series = [k * c for k, c in enumerate(series)][1:]
    y, y1, y2, y3, y4 = rows
    value, slope = value_and_slope(made, ..., State(y, y1, y2, y3, None, y4))
    return as_number(value), as_number(slope)
