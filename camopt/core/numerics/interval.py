"""Interval arithmetic: formulas on ranges of numbers.

``Interval`` is an array of closed intervals. Formulas and numpy's functions take it in place of an array of
numbers. The result encloses every value of the formula over the box of its arguments (natural interval extension:
never too narrow, and exact in the limit of narrow boxes).

Rounding is included. Operators and functions widen the results of ``INTERVAL_RULES`` by ``INPUT_ROUNDOFF`` relative
to the ends, because a rule of arithmetic has at most three roundings. The last digits of functions in numpy's
libraries depend on the processor. They are taken to be right to four units in the last place (``LIBRARY_ERROR``),
and their rules widen the result by that. An end that is exactly 0 stays 0, because no result underflows. An input
is exact.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np

from camopt.core.numerics import INPUT_ROUNDOFF, UNIT_ROUNDOFF, FloatArray

LIBRARY_ERROR = 8.0 * UNIT_ROUNDOFF
"""Relative error of a library function: four units in the last place."""


def _interval_hull(*candidates: FloatArray) -> "Interval":
    low, high = reduce(np.minimum, candidates), reduce(np.maximum, candidates)
    unknown = np.isnan(low)
    if np.logical_or.reduce(unknown, axis=None):
        return Interval(np.where(unknown, -np.inf, low), np.where(unknown, np.inf, high))
    return Interval(low, high)


def _multiply_intervals(a: "Interval", b: "Interval") -> "Interval":
    if a is b:
        return _square_interval(a)
    if b.low is b.high:  # numbers
        return _interval_hull(a.low * b.low, a.high * b.low)
    if a.low is a.high:
        return _interval_hull(a.low * b.low, a.low * b.high)
    return _interval_hull(a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high)


def _square_interval(a: "Interval") -> "Interval":
    return Interval(a.least_magnitude**2, a.largest_magnitude**2)


def _divide_intervals(a: "Interval", b: "Interval") -> "Interval":
    """a/b. If b ranges from 0 up, the quotient keeps its lower bound: b is 0 only where a formula has no value."""
    through_zero = (b.low <= 0.0) & (b.high >= 0.0)
    if not np.logical_or.reduce(through_zero, axis=None):
        return _multiply_intervals(a, Interval(1.0 / b.high, 1.0 / b.low))
    least = np.where(through_zero & ((b.low < 0.0) | (b.high == 0.0)), -np.inf, 1.0 / b.high)
    return _multiply_intervals(a, Interval(least, np.where(through_zero, np.inf, 1.0 / b.low)))


def widen(x: "Interval", relative: float = INPUT_ROUNDOFF) -> "Interval":
    """Widen ranges by a rounding error relative to their ends."""
    return Interval(x.low - relative * np.abs(x.low), x.high + relative * np.abs(x.high))


def _power_of_interval(a: "Interval", exponent: "Interval") -> "Interval":
    """A base ≥ 0 to the power of a number."""
    low, high = np.maximum(a.low, 0.0) ** exponent.low, np.maximum(a.high, 0.0) ** exponent.low
    return widen(Interval(np.minimum(low, high), np.maximum(low, high)), LIBRARY_ERROR)


def _sine_or_cosine_rule(function: Any, crest_phase: float) -> Callable[["Interval"], "Interval"]:
    """Rule of a sine or cosine: the values at the ends, and ±1 if a crest or trough lies inside.

    A crest that rounding hides is so near an end that the function differs from 1 there by less than a rounding.
    """

    def rule(a: "Interval") -> "Interval":
        def contains_phase(phase: float) -> Any:
            return np.floor((a.high - phase) / (2 * np.pi)) >= np.ceil((a.low - phase) / (2 * np.pi))

        ends = widen(_interval_hull(function(a.low), function(a.high)), LIBRARY_ERROR)
        return Interval(
            np.where(contains_phase(crest_phase - np.pi), -1.0, ends.low),
            np.where(contains_phase(crest_phase), 1.0, ends.high),
        )

    return rule


def _arctan2_interval(y: "Interval", x: "Interval") -> "Interval":
    """Extremes are at corners, unless the box touches the negative x axis, where the angle jumps."""
    ends = widen(
        _interval_hull(*(np.arctan2(b, a) for b in (y.low, y.high) for a in (x.low, x.high))), LIBRARY_ERROR
    )
    jumps = (x.low < 0.0) & (y.low <= 0.0) & (y.high >= 0.0)
    return Interval(np.where(jumps, -np.pi, ends.low), np.where(jumps, np.pi, ends.high))


def _increasing_rule(function: Any) -> Callable[..., "Interval"]:
    """Rule of a function that rises with each of its arguments."""
    return lambda *a: Interval(function(*(x.low for x in a)), function(*(x.high for x in a)))


def _increasing_rule_with_library_error(function: Any) -> Callable[..., "Interval"]:
    """Rule of a library function that rises with its argument."""
    return lambda a: widen(_increasing_rule(function)(a), LIBRARY_ERROR)


INTERVAL_RULES: dict[np.ufunc, Callable[..., "Interval"]] = {
    np.add: lambda a, b: Interval(a.low + b.low, a.high + b.high),
    np.subtract: lambda a, b: Interval(a.low - b.high, a.high - b.low),
    np.multiply: _multiply_intervals,
    np.true_divide: _divide_intervals,
    np.negative: lambda a: Interval(-a.high, -a.low),
    np.square: _square_interval,
    np.absolute: lambda a: Interval(a.least_magnitude, a.largest_magnitude),
    np.sign: lambda a: _increasing_rule(np.sign)(a),
    np.power: _power_of_interval,
    np.sqrt: lambda a: _increasing_rule(np.sqrt)(Interval(np.maximum(a.low, 0.0), np.maximum(a.high, 0.0))),
    np.sin: _sine_or_cosine_rule(np.sin, np.pi / 2),
    np.cos: _sine_or_cosine_rule(np.cos, 0.0),
    np.arcsin: _increasing_rule_with_library_error(np.arcsin),
    np.arctan: _increasing_rule_with_library_error(np.arctan),
    np.degrees: _increasing_rule(np.degrees),
    np.cbrt: _increasing_rule_with_library_error(np.cbrt),
    np.arctan2: _arctan2_interval,
    np.maximum: _increasing_rule(np.maximum),
    np.minimum: _increasing_rule(np.minimum),
}


EXACT_RULES = {np.negative, np.absolute, np.sign, np.maximum, np.minimum}
"""Rules without rounding."""
UNBOUNDED_ERRSTATE: dict[str, Any] = {"divide": "ignore", "invalid": "ignore", "over": "ignore"}
"""Arguments of ``np.errstate`` for rules: results without bounds are infinite or NaN."""


@dataclass(eq=False, slots=True)  # not frozen, because making a frozen one takes as long as computing it
class Interval(np.lib.mixins.NDArrayOperatorsMixin):
    """Closed intervals [low, high]; the two arrays have one shape."""

    low: FloatArray
    high: FloatArray

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        rule = INTERVAL_RULES.get(ufunc)
        if method != "__call__" or kwargs or rule is None:
            return NotImplemented
        for x in inputs:
            if not isinstance(x, INTERVAL_OPERANDS):
                return NotImplemented
        with np.errstate(**UNBOUNDED_ERRSTATE):
            result = rule(*[x if isinstance(x, Interval) else as_interval(x) for x in inputs])
            return result if ufunc in EXACT_RULES else widen(result)

    def __getitem__(self, index: Any) -> "Interval":
        return Interval(self.low[index], self.high[index])

    def reshape(self, *shape: int) -> "Interval":
        return Interval(self.low.reshape(shape), self.high.reshape(shape))

    @property
    def size(self) -> int:
        return self.low.size

    @property
    def least_magnitude(self) -> FloatArray:
        """Smallest |x| in each interval."""
        return np.maximum(np.maximum(self.low, -self.high), 0.0)

    @property
    def largest_magnitude(self) -> FloatArray:
        """Largest |x| in each interval."""
        return np.maximum(-self.low, self.high)


INTERVAL_OPERANDS = (Interval, int, float, np.ndarray, np.generic)


def as_interval(x: Any) -> Interval:
    """A number or array as intervals of width 0."""
    if isinstance(x, Interval):
        return x
    value = np.asarray(x, dtype=float)
    return Interval(value, value)
