"""Intervals with slopes: the range of a formula over boxes of its arguments, and its partial derivatives.

A ``SlopedInterval`` has the range of a quantity over a box, its value at one point of the box, and intervals of its
partial derivatives over the box. Formulas run on it as on numbers, and each operation carries the derivatives along
by the chain rule. By the mean value theorem

    f(x) ∈ f(p) + Σ F_k·(x_k − p_k),    F_k ∋ ∂f/∂x_k over the box

which narrows the range of interval arithmetic: its excess width falls with the square of the box's width. A
quotient whose denominator may be 0 in the box stays a quotient (``Quotient``).

Rounding is included: every operation widens the range, the slopes and the value at the point by its rounding error.
A number as input is widened by ``INPUT_ROUNDOFF``, an Interval is not.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 6.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import reduce
from typing import Any, ClassVar

import numpy as np

from camopt.core.numerics import INPUT_ROUNDOFF, FloatArray, Number
from camopt.core.numerics.interval import (
    INTERVAL_OPERANDS,
    INTERVAL_RULES,
    UNBOUNDED_ERRSTATE,
    Interval,
    as_interval,
    widen,
)

ADD, MULTIPLY, NEGATE = (INTERVAL_RULES[ufunc] for ufunc in (np.add, np.multiply, np.negative))


@dataclass(eq=False)  # not frozen, as Interval is not
class SlopedInterval(np.lib.mixins.NDArrayOperatorsMixin):
    """A quantity over n boxes of d variables."""

    value: Interval
    """Range over each box (n,)."""
    at: Interval
    """Value at the point of each box (n,)."""
    slopes: Interval
    """Partial derivatives (d, n)."""
    span: Interval
    """The box relative to the point (d, n)."""
    keeps_quotients: ClassVar[bool] = True

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if method != "__call__" or kwargs or any(isinstance(x, Quotient) for x in inputs):
            return NotImplemented
        if ufunc not in PARTIALS or not all(isinstance(x, SLOPED_OPERANDS) for x in inputs):
            return NotImplemented
        if ufunc is np.true_divide and isinstance(inputs[1], SlopedInterval) and self.keeps_quotients:
            touching = inputs[1].value.low <= 0.0
            if np.any(touching):
                a, b = as_sloped_interval(inputs[0], inputs[1]), inputs[1]
                whole, one = Quotient(a, b).divide(), as_sloped_interval(1.0, b)
                return Quotient(_select_sloped(touching, a, whole), _select_sloped(touching, b, one))
        enter = as_interval if ufunc is np.power else _as_rounded_interval  # an exponent is exact
        entered = [x if isinstance(x, SlopedInterval) else enter(x) for x in inputs]
        ranges, points = ([of(x) for x in entered] for of in (range_of, value_at_box_point))
        with np.errstate(**UNBOUNDED_ERRSTATE):
            value, at = (INTERVAL_RULES[ufunc](*each) for each in (ranges, points))
            return apply_chain_rule(value, at, list(zip(inputs, PARTIALS[ufunc](value, *ranges), strict=True)))

    def quantity_over_same_boxes(self, value: Interval, at: Interval, slopes: Interval) -> "SlopedInterval":
        """Another quantity over the same boxes."""
        return SlopedInterval(value, at, slopes, self.span)

    def __getitem__(self, index: Any) -> "SlopedInterval":
        return SlopedInterval(self.value[index], self.at[index], self.slopes[:, index], self.span[:, index])

    @property
    def size(self) -> int:
        return self.value.size


SLOPED_OPERANDS = (SlopedInterval, *INTERVAL_OPERANDS)


@dataclass(eq=False)
class LinkageInterval(SlopedInterval):
    """A sloped interval of a linkage: denominators may have either sign, and radicands must be positive."""

    radicands: list[SlopedInterval] = field(default_factory=list)
    """All radicands of square roots: where one is below 0, the linkage cannot be assembled."""
    keeps_quotients: ClassVar[bool] = False

    @classmethod
    def from_sloped_interval(cls, number: SlopedInterval, radicands: list[SlopedInterval]) -> "LinkageInterval":
        """A number of a linkage over boxes; all its numbers share the list of radicands."""
        return cls(number.value, number.at, number.slopes, number.span, radicands)

    @property
    def sloped_interval(self) -> SlopedInterval:
        """The number without the list of radicands."""
        return SlopedInterval(self.value, self.at, self.slopes, self.span)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if ufunc is np.sqrt:
            self.radicands.append(self.sloped_interval)
        return super().__array_ufunc__(ufunc, method, *inputs, **kwargs)

    def quantity_over_same_boxes(self, value: Interval, at: Interval, slopes: Interval) -> SlopedInterval:
        """Another number of the linkage."""
        return LinkageInterval(value, at, slopes, self.span, self.radicands)


def range_of(x: Any) -> Interval:
    """Range of a number, an array, an Interval or a SlopedInterval."""
    return x.value if isinstance(x, SlopedInterval) else _as_rounded_interval(x)


def value_at_box_point(x: Any) -> Interval:
    """Value at the point of a number, an array, an Interval or a SlopedInterval."""
    return x.at if isinstance(x, SlopedInterval) else _as_rounded_interval(x)


def _as_rounded_interval(x: Any) -> Interval:
    """A number or array as an interval, widened by its rounding error."""
    return x if isinstance(x, Interval) else widen(as_interval(x))


def apply_chain_rule(
    value: Interval, at: Interval, operands_and_partials: Sequence[tuple[Any, Any]]
) -> SlopedInterval:
    """A function of some operands, from its range, its value at the point, and pairs (operand, partial derivative).

    The inputs may have the relative error ``INPUT_ROUNDOFF``, as after one operation.
    """
    sloped = [
        (operand, partial) for operand, partial in operands_and_partials if isinstance(operand, SlopedInterval)
    ]
    like = sloped[0][0]
    shape = like.span.low.shape[1:]
    with np.errstate(**UNBOUNDED_ERRSTATE):
        slopes = reduce(
            lambda a, b: widen(ADD(a, b)), [_scale_slopes(partial, operand.slopes) for operand, partial in sloped]
        )
        at = at if at.low.shape == shape else ADD(at, as_interval(np.zeros(shape)))
        return narrow_by_mean_value(value, at, slopes, like)


def narrow_by_mean_value(
    value: Interval, at: Interval, slopes: Interval, template: SlopedInterval
) -> SlopedInterval:
    """A quantity from its range, its value at the point and its slopes, which narrow the range."""
    span, at, value = template.span, widen(at), widen(value)
    with np.errstate(**UNBOUNDED_ERRSTATE):  # for products of infinite slopes and spans around 0
        least = np.minimum(slopes.low * span.high, slopes.high * span.low)
        most = np.maximum(slopes.low * span.low, slopes.high * span.high)
        rounding = INPUT_ROUNDOFF * np.add.reduce(np.maximum(-least, most))
        low = np.fmax(
            value.low, at.low + np.add.reduce(least) - rounding
        )  # fmax ignores NaN, so unknown slopes narrow nothing
        high = np.fmin(value.high, at.high + np.add.reduce(most) + rounding)
    return template.quantity_over_same_boxes(Interval(np.minimum(low, high), np.maximum(low, high)), at, slopes)


def _scale_slopes(partial: Any, slopes: Interval) -> Interval:
    """Slopes times a partial derivative, which is 1 or −1 for sums and differences."""
    if isinstance(partial, float) and partial in (1.0, -1.0):
        return slopes if partial > 0.0 else NEGATE(slopes)
    return widen(MULTIPLY(as_interval(partial), slopes))


def box_variables(box: Sequence[Interval], point: Sequence[FloatArray]) -> list[SlopedInterval]:
    """The variables of boxes as sloped intervals, with points in the boxes."""
    span = Interval(
        np.array([side.low - p for side, p in zip(box, point, strict=True)]),
        np.array([side.high - p for side, p in zip(box, point, strict=True)]),
    )
    ones = np.eye(len(box))[:, :, None] + np.zeros(span.low.shape)
    return [
        SlopedInterval(x, as_interval(p), as_interval(one), span)
        for x, p, one in zip(box, point, ones, strict=True)
    ]


def _maximum_partial(a: Interval, b: Interval) -> Interval:
    """Range of ∂max(a, b)/∂a: 1 where a is larger, 0 where b is."""
    return Interval(np.where(a.low > b.high, 1.0, 0.0), np.where(a.high < b.low, 0.0, 1.0))


def _sign_derivative(a: Interval) -> Interval:
    """Range of the derivative of sgn(a)."""
    constant = (a.low > 0.0) | (a.high < 0.0) | (a.low == a.high)
    return Interval(np.zeros_like(a.low), np.where(constant, 0.0, np.inf))


def _arctan2_partials(value: Interval, y: Interval, x: Interval) -> tuple[Interval, ...]:
    square = y * y + x * x
    return x / square, -y / square


PARTIALS: dict[np.ufunc, Callable[..., tuple[Any, ...]]] = {
    np.add: lambda v, a, b: (1.0, 1.0),
    np.subtract: lambda v, a, b: (1.0, -1.0),
    np.multiply: lambda v, a, b: (b, a),
    np.true_divide: lambda v, a, b: (inverse := 1.0 / b, -v * inverse),
    np.negative: lambda v, a: (-1.0,),
    np.square: lambda v, a: (2.0 * a,),
    np.power: lambda v, a, exponent: (exponent * INTERVAL_RULES[np.power](a, exponent - 1.0), 0.0),
    np.sqrt: lambda v, a: (0.5 / v,),
    np.sin: lambda v, a: (np.cos(a),),
    np.cos: lambda v, a: (-np.sin(a),),
    np.arcsin: lambda v, a: (1.0 / np.sqrt((1.0 - a) * (1.0 + a)),),
    np.arctan2: _arctan2_partials,
    np.maximum: lambda v, a, b: (_maximum_partial(a, b), _maximum_partial(b, a)),
    np.minimum: lambda v, a, b: (_maximum_partial(b, a), _maximum_partial(a, b)),
    np.absolute: lambda v, a: (np.sign(a),),
    np.sign: lambda v, a: (_sign_derivative(a),),
}
"""Partial derivatives of each operation, from the Intervals of its value and its operands."""


@dataclass(frozen=True, eq=False)
class Quotient(np.lib.mixins.NDArrayOperatorsMixin):
    """above/below, where the range of ``below`` may reach 0 or less.

    If a design can be assembled, is not undercut and does not jam, every denominator in a formula is positive. Then
    above/below ≤ b is the same as above ≤ b·below, which has no pole.
    """

    above: Any
    below: Any

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if method != "__call__" or kwargs:
            return NotImplemented
        if ufunc in FRACTIONS:
            return Quotient(*FRACTIONS[ufunc](*(as_quotient(x) for x in inputs)))
        return ufunc(*(x.divide() if isinstance(x, Quotient) else x for x in inputs))

    def __getitem__(self, index: Any) -> "Quotient":
        return Quotient(*(part if np.isscalar(part) else part[index] for part in (self.above, self.below)))

    def divide(self) -> SlopedInterval:
        """The quotient as a sloped interval, without bounds where the denominator may be 0."""
        above, below = as_sloped_interval(self.above, self.below), as_sloped_interval(self.below, self.above)
        value, at = above.value / below.value, above.at / below.at
        partials = PARTIALS[np.true_divide](value, above.value, below.value)
        return apply_chain_rule(value, at, list(zip((above, below), partials, strict=True)))


def as_quotient(x: Any) -> Quotient:
    return x if isinstance(x, Quotient) else Quotient(x, 1.0)


def as_sloped_interval(x: Any, template: SlopedInterval) -> SlopedInterval:
    """A constant as a sloped interval with zero slopes, over the boxes of ``template``."""
    if isinstance(x, SlopedInterval):
        return x
    value = _as_rounded_interval(x) + as_interval(np.zeros(template.value.low.shape))
    return template.quantity_over_same_boxes(value, value, 0.0 * as_interval(np.ones(template.slopes.low.shape)))


def choose_form_or_hull(one: SlopedInterval, other: SlopedInterval, use_one: Any, use_other: Any) -> SlopedInterval:
    """Enclosure of a quantity by box: ``one`` where ``use_one``, ``other`` where ``use_other``, else the hull."""

    def choose_ends(a: Interval, b: Interval) -> Interval:
        low, high = np.minimum(a.low, b.low), np.maximum(a.high, b.high)
        return Interval(
            np.where(use_one, a.low, np.where(use_other, b.low, low)),
            np.where(use_one, a.high, np.where(use_other, b.high, high)),
        )

    value, at, slopes = (choose_ends(getattr(one, n), getattr(other, n)) for n in ("value", "at", "slopes"))
    return one.quantity_over_same_boxes(value, at, slopes)


def _fraction_power(a: Quotient, exponent: Quotient) -> tuple[Number, Number]:
    """A positive fraction to the power of a number."""
    over, under = (a.above, a.below) if exponent.above > 0.0 else (a.below, a.above)
    size = abs(exponent.above)
    return np.power(over, size), np.power(under, size)


def _select_sloped(condition: Any, a: SlopedInterval, b: SlopedInterval) -> SlopedInterval:
    def choose_ends(x: Interval, y: Interval) -> Interval:
        return Interval(np.where(condition, x.low, y.low), np.where(condition, x.high, y.high))

    return SlopedInterval(
        choose_ends(a.value, b.value), choose_ends(a.at, b.at), choose_ends(a.slopes, b.slopes), a.span
    )


FRACTIONS: dict[np.ufunc, Callable[..., tuple[Any, Any]]] = {
    np.add: lambda a, b: (a.above * b.below + b.above * a.below, a.below * b.below),
    np.subtract: lambda a, b: (a.above * b.below - b.above * a.below, a.below * b.below),
    np.multiply: lambda a, b: (a.above * b.above, a.below * b.below),
    np.true_divide: lambda a, b: (a.above * b.below, a.below * b.above),
    np.negative: lambda a: (-a.above, a.below),
    np.square: lambda a: (np.square(a.above), np.square(a.below)),
    np.sqrt: lambda a: (np.sqrt(a.above), np.sqrt(a.below)),
    np.power: _fraction_power,
    np.absolute: lambda a: (np.absolute(a.above), a.below),
}
"""Operations on fractions, as (above, below)."""
