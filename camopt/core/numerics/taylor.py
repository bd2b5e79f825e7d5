"""Truncated Taylor series of arrays or intervals: functions of one variable with their derivatives.

One formula gives the value, the velocity, the acceleration and so on. With intervals, the last term over a stretch
is the remainder of the series about its middle.

Source: Griewank and Walther, Evaluating Derivatives, ch. 13 (Taylor arithmetic).
"""

from collections.abc import Callable, Sequence
from functools import reduce, singledispatch
from math import factorial
from operator import add, mul
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import Number


class Taylor:
    """The truncated series f + f'·t + f''/2·t² + …; its terms are numbers, arrays of one shape, or intervals."""

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        known = method == "__call__" and not kwargs and ufunc in TAYLOR_RULES
        return TAYLOR_RULES[ufunc](*inputs) if known else NotImplemented

    def __init__(self, terms: Sequence[Any]) -> None:
        self.terms = tuple(terms)

    def derivative(self, order: int) -> Number:
        """The derivative of some order at the centre of the series."""
        return self.terms[order] * factorial(order)

    @property
    def slope(self) -> "Taylor":
        """The series of the derivative, shorter by a term."""
        return Taylor([k * term for k, term in enumerate(self.terms) if k])

    def integral(self, constant_term: Any) -> "Taylor":
        """The series with this derivative and the given value, longer by a term."""
        return Taylor([constant_term, *(term / (k + 1) for k, term in enumerate(self.terms))])

    def __neg__(self) -> "Taylor":
        return Taylor([-term for term in self.terms])

    def __add__(self, other: Any) -> "Taylor":
        if isinstance(other, Taylor):
            return Taylor([a + b for a, b in zip(self.terms, other.terms, strict=True)])
        return Taylor([self.terms[0] + other, *self.terms[1:]])

    __radd__ = __add__

    def __sub__(self, other: Any) -> "Taylor":
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> "Taylor":
        return self.__neg__().__add__(other)

    def __mul__(self, other: Any) -> "Taylor":
        if not isinstance(other, Taylor):
            return Taylor([term * other for term in self.terms])
        a, b = self.terms, other.terms
        return Taylor([_sum_of_products(a[: k + 1], b[k::-1]) for k in range(min(len(a), len(b)))])

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> "Taylor":
        if not isinstance(other, Taylor):
            return Taylor([term / other for term in self.terms])
        quotient: list[Any] = []
        for k, term in enumerate(self.terms[: len(other.terms)]):
            rest = term - _sum_of_products(quotient, other.terms[k:0:-1]) if k else term
            quotient.append(rest / other.terms[0])
        return Taylor(quotient)

    def __rtruediv__(self, other: Any) -> "Taylor":
        return Taylor((self * 0.0 + other).terms).__truediv__(self)

    def __abs__(self) -> "Taylor":
        return self.__mul__(np.sign(self.terms[0]))

    def root(self) -> "Taylor":
        """The square root."""
        root = [np.sqrt(self.terms[0])]
        for k, term in enumerate(self.terms[1:]):
            rest = term - _sum_of_products(root[1:], root[:0:-1]) if k else term
            root.append(rest / (root[0] * 2.0))
        return Taylor(root)


def _constant_series(x: Any, template: Any) -> Taylor:
    """A constant as a series of the length of ``template``; a series as it is."""
    return x if isinstance(x, Taylor) else template * 0.0 + x


def _sum_of_products(a: Sequence[Any], b: Sequence[Any]) -> Number:
    """a₀·b₀ + a₁·b₁ + …, with at least one product."""
    return reduce(add, map(mul, a, b))


Series = Any
"""A ``Taylor``, or a library's series that registers the following functions (``tests/support/balls``)."""


class Direction(NamedTuple):
    """Cosine and sine of an angle."""

    cosine: Series
    sine: Series


@singledispatch
def series_root(series: Series) -> Series:
    """The square root."""
    return series.root()


@singledispatch
def series_quotient(a: Series, b: Series) -> Series:
    """a/b."""
    return a / b


@singledispatch
def series_derivative(series: Series) -> Series:
    """The series of the derivative, shorter by a term."""
    return series.slope


@singledispatch
def cosine_and_sine_series(angle: Series) -> Direction:
    """Cosine and sine, from c' = −s·α' and s' = c·α'."""
    rates = angle.slope.terms
    cosine, sine = [np.cos(angle.terms[0])], [np.sin(angle.terms[0])]
    for k in range(1, len(angle.terms)):
        c, s = (_sum_of_products(terms, rates[k - 1 :: -1]) / k for terms in (cosine, sine))
        cosine.append(-s)
        sine.append(c)
    return Direction(Taylor(cosine), Taylor(sine))


@cosine_and_sine_series.register(np.ndarray)
def _direction_of_number(angle: Any) -> Direction:
    return Direction(np.cos(angle), np.sin(angle))


@singledispatch
def vector_angle(x: Series, y: Series) -> Series:
    """Angle of a vector, from its derivative (x·y' − y·x')/(x² + y²)."""
    shortened = (Taylor(series.terms[:-1]) for series in (x, y))
    rate = (x * y.slope - y * x.slope) / reduce(add, (series * series for series in shortened))
    return rate.integral(np.arctan2(y.terms[0], x.terms[0]))


TAYLOR_RULES: dict[np.ufunc, Callable[..., Taylor]] = {
    np.add: lambda a, b: a + b if isinstance(a, Taylor) else b + a,
    np.subtract: lambda a, b: a - b if isinstance(a, Taylor) else -b + a,
    np.multiply: lambda a, b: a * b if isinstance(a, Taylor) else b * a,
    np.true_divide: lambda a, b: a / b if isinstance(a, Taylor) else b.__rtruediv__(a),
    np.negative: lambda a: -a,
    np.square: lambda a: a * a,
    np.sqrt: Taylor.root,
    np.sin: lambda a: cosine_and_sine_series(a).sine,
    np.cos: lambda a: cosine_and_sine_series(a).cosine,
    np.arcsin: lambda a: vector_angle((1.0 - a * a).root(), a),
    np.arctan2: lambda y, x: vector_angle(_constant_series(x, y), _constant_series(y, x)),
    np.sign: lambda a: np.sign(a.terms[0]),
}
"""Rules of numpy's functions for arguments with a series among them."""
