"""Balls: real numbers with a rigorous error, at 200 bits, that the formulas run on as they run on numbers.

A ``Ball`` wraps python-flint's ``arb``, or an ``arb_series``, a Taylor series with such coefficients. Every
operation encloses all results that its operands allow.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import RLock
from typing import Any

import numpy as np
from flint import arb, arb_series, ctx

from camopt.core.numerics.taylor import series_quotient, series_root

PRECISION_BITS = 200
MOST_TERMS = 16  # of series at most
PRECISION_LOCK = RLock()


@contextmanager
def precisely(terms: int = MOST_TERMS) -> Iterator[None]:
    """Ball arithmetic at ``PRECISION_BITS`` within the block, then at the earlier precision; also a decorator.

    Series have up to so many terms. flint has one precision for the whole process, so that proofs in several
    threads wait for each other.
    """
    with PRECISION_LOCK, ctx.workprec(PRECISION_BITS):
        before, ctx.cap = ctx.cap, terms
        try:
            yield
        finally:
            ctx.cap = before


class NoSeries(ArithmeticError):
    """A function has a kink within the range of its argument, so that it has no series."""


def _root(a: Any) -> Any:
    """√a of a number ≥ 0 whose ball may reach below 0; NaN for a ball wholly below 0."""
    if isinstance(a, arb_series):
        return series_root(a)
    return arb(0).union(a.upper().sqrt()) if a.contains(0) else a.sqrt()


def _quotient(a: Any, b: Any) -> Any:
    return series_quotient(a, b) if isinstance(b, arb_series) else a / b


def _sign(a: Any) -> Any:
    """Of a series, which is that of its first term all along."""
    if not isinstance(a, arb_series):
        return a.sgn()
    if not (a[0] > 0 or a[0] < 0):
        raise NoSeries
    return a[0].sgn()


def _absolute(a: Any) -> Any:
    return a * _sign(a) if isinstance(a, arb_series) else abs(a)


BALL_RULES: dict[np.ufunc, Callable[..., Any]] = {
    np.add: lambda a, b: a + b,
    np.subtract: lambda a, b: a - b,
    np.multiply: lambda a, b: a * b,
    np.true_divide: _quotient,
    np.negative: lambda a: -a,
    np.square: lambda a: a * a,
    np.absolute: _absolute,
    np.sign: _sign,
    np.sqrt: _root,
    np.power: lambda a, b: a**b,
    np.sin: lambda a: a.sin(),
    np.cos: lambda a: a.cos(),
    np.arcsin: lambda a: a.asin(),
    np.arctan: lambda a: a.atan(),
    np.degrees: lambda a: a * 180 / arb.pi(),
    np.cbrt: lambda a: a.root(3),
    np.arctan2: lambda y, x: arb.atan2(y, x),
    np.maximum: lambda a, b: a.max(b),
    np.minimum: lambda a, b: a.min(b),
}


class Ball(np.lib.mixins.NDArrayOperatorsMixin):
    """One ball, or a series, with the operators and the indexing of an array of one number."""

    __slots__ = ("arb",)
    size = 1

    def __init__(self, value: Any) -> None:
        self.arb = value if type(value) is arb else _as_ball_or_series(value)

    # the operators that formulas are made of, without the way through numpy, which takes longer than the arithmetic
    def __add__(self, other: Any) -> "Ball":
        return Ball(self.arb + (other.arb if type(other) is Ball else _as_ball_or_series(other)))

    def __sub__(self, other: Any) -> "Ball":
        return Ball(self.arb - (other.arb if type(other) is Ball else _as_ball_or_series(other)))

    def __mul__(self, other: Any) -> "Ball":
        return Ball(self.arb * (other.arb if type(other) is Ball else _as_ball_or_series(other)))

    def __truediv__(self, other: Any) -> "Ball":
        return Ball(_quotient(self.arb, other.arb if type(other) is Ball else _as_ball_or_series(other)))

    def __radd__(self, other: Any) -> "Ball":
        return Ball(_as_ball_or_series(other) + self.arb)

    def __rsub__(self, other: Any) -> "Ball":
        return Ball(_as_ball_or_series(other) - self.arb)

    def __rmul__(self, other: Any) -> "Ball":
        return Ball(_as_ball_or_series(other) * self.arb)

    def __neg__(self) -> "Ball":
        return Ball(-self.arb)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if method != "__call__" or kwargs or ufunc not in BALL_RULES:
            return NotImplemented
        return Ball(BALL_RULES[ufunc](*(_as_ball_or_series(x) for x in inputs)))

    def __getitem__(self, index: Any) -> "Ball":
        return self


def as_arb(value: Any) -> arb:
    """A ball, or a number taken as exact."""
    found: arb = _as_ball_or_series(value)
    return found


def _as_ball_or_series(value: Any) -> Any:
    """As ``as_arb``; or a series."""
    if isinstance(value, (arb, arb_series)):
        return value
    if isinstance(value, Ball):
        return value.arb
    return arb(value if isinstance(value, float) else float(np.asarray(value).item()))


def ball_between(low: arb, high: arb) -> arb:
    """The ball from one number to another."""
    return arb((low + high) / 2, ((high - low) / 2).abs_upper())
