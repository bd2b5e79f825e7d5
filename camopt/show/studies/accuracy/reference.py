"""The reference: extremes with 50 digits, by the formulas of curves on numbers of mpmath.

The motion is that of the table, with its polynomials as exact numbers. Their difference from the laws is far below
the compared errors (``numerics.piecewise``). The extreme is searched near its cam angle in doubles: at a root of
the slope, or at the end of a piece.
"""

from collections.abc import Callable
from functools import cache, partial, reduce
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST_MAGNITUDE, LEAST, Curve, Number
from camopt.core.numerics.curves import value_and_slope
from camopt.core.numerics.state import State
from camopt.model.mechanisms import Designs
from camopt.model.motion.programme import Programme

DECIMAL_DIGITS = 50
EQUAL_DIGITS = 1e-25
"""Relative error that the reference stays below."""
SEARCH_WIDTH, PANEL_OVERLAP = 1e-3, 1e-9
"""In halves of a panel: search width around the place in doubles, and overlap of panels."""
MOST_ROOT_STEPS = 200


@cache
def fifty_digit_context() -> Any:
    """The mpmath context with 50 digits, independent of the global precision."""
    from mpmath import MPContext  # noqa: PLC0415, seldom needed

    context = MPContext()
    context.dps = DECIMAL_DIGITS
    return context


UFUNC_RULES: dict[np.ufunc, Callable[..., Any]] = {
    np.add: lambda a, b: a + b,
    np.subtract: lambda a, b: a - b,
    np.multiply: lambda a, b: a * b,
    np.true_divide: lambda a, b: a / b,
    np.power: lambda a, b: a**b,
    np.maximum: max,
    np.minimum: min,
    np.negative: lambda a: -a,
    np.square: lambda a: a * a,
    np.absolute: abs,
    np.sign: lambda a: fifty_digit_context().sign(a),
    np.sqrt: lambda a: fifty_digit_context().sqrt(a),
    np.sin: lambda a: fifty_digit_context().sin(a),
    np.cos: lambda a: fifty_digit_context().cos(a),
    np.arcsin: lambda a: fifty_digit_context().asin(a),
    np.arctan: lambda a: fifty_digit_context().atan(a),
    np.arctan2: lambda y, x: fifty_digit_context().atan2(y, x),
    np.cbrt: lambda a: fifty_digit_context().cbrt(a),
    np.degrees: lambda a: fifty_digit_context().degrees(a),
}


class Digits(np.lib.mixins.NDArrayOperatorsMixin):
    """A number with 50 digits that behaves as an array of one number."""

    __slots__ = ("number",)
    size = 1

    def __init__(self, number: Any) -> None:
        self.number = number

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if method != "__call__" or kwargs or ufunc not in UFUNC_RULES:
            return NotImplemented
        return Digits(UFUNC_RULES[ufunc](*map(as_fifty_digit_number, inputs)))

    def __getitem__(self, index: Any) -> "Digits":
        return self


def as_fifty_digit_number(value: Any) -> Number:
    """A number of mpmath; a double is taken as exact."""
    return value.number if isinstance(value, Digits) else fifty_digit_context().mpf(float(np.asarray(value).item()))


def fifty_digit_extreme_near(
    make_curve: Any, stroke_kinds: int, goal: int, design: Designs, programme: Programme, cam_angle: float
) -> Number:
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


def _root_of_slope(value_and_slope_at: Any, low: Number, high: Number) -> list[Number]:
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


def _panel_motion_polynomials(table: Any, panel: Any) -> list[list[Number]]:
    """Polynomials of a panel: displacement and its four derivatives by cam angle, as exact numbers."""
    number, half = fifty_digit_context().mpf, fifty_digit_context().mpf(float(table.half_width[panel]))
    orders = [[number(float(c)) for c in table.coefficients[panel]]]
    for _ in range(4):
        orders.append([k * c / half for k, c in enumerate(orders[-1])][1:])
    return orders


def _value_and_slope(curve: Curve, motion: list[list[Number]], u: Number) -> tuple[Number, Number]:
    """Value and slope of a curve at a place u of a panel."""
    # by Horner's rule
    y, y1, y2, y3, y4 = (Digits(reduce(lambda x, power: x * u + power, reversed(series))) for series in motion)
    value, slope = value_and_slope(curve, ..., State(y, y1, y2, y3, None, y4))
    return as_fifty_digit_number(value), as_fifty_digit_number(slope)
