"""Numbers with 50 digits, on which the formulas of curves run as on doubles."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from camopt.model.effects.peak import NumberKind

DECIMAL_DIGITS = 50


@cache
def fifty_digit_context() -> Any:
    """The mpmath context with 50 digits, independent of the global precision."""
    from mpmath import MPContext  # noqa: PLC0415, seldom needed

    context = MPContext()
    context.dps = DECIMAL_DIGITS
    return context


def fifty_digit_number_kind() -> NumberKind:
    """The kind of these numbers, for scales of quantities."""
    return NumberKind(fifty_digit_context().mpf, lambda: +fifty_digit_context().pi, fifty_digit_context().tan)


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


def as_fifty_digit_number(value: Any) -> Any:
    """A number of mpmath; a double is taken as exact."""
    return value.number if isinstance(value, Digits) else fifty_digit_context().mpf(float(np.asarray(value).item()))
