"""Quantities that a scene defines, by an expression over other quantities or by a Python function.

A value that is not a finite number counts as infinite. Interval arithmetic over the enclosures of the other
quantities, with a margin for the rounding of each operation, gives the enclosure of an expression. If none of these
quantities has a width, the value is exact to rounding. The value of a Python function has no enclosure.

Source: Moore, Kearfott and Cloud, Introduction to Interval Analysis, ch. 5.
"""

from collections.abc import Callable, Mapping
from functools import partial, reduce
from typing import Any

import numpy as np

from camopt.core.numerics.interval import UNBOUNDED_ERRSTATE, Interval, as_interval
from camopt.core.quantities.expression import DOUBLE_RULES, ExpressionRules
from camopt.core.quantities.own_quantity import OWN_EFFECT, OwnQuantity
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock

OPERATION_ROUNDING = 4.0 * np.finfo(float).eps
"""Relative rounding error of each operation."""
LARGEST_EXPONENT = 1024.0
"""Largest whole exponent of a negative base."""


def expression_effect(quantity: OwnQuantity, runs_last: bool) -> Effect:
    """The effect that computes a quantity that the scene defines."""
    return Effect(
        f"{OWN_EFFECT}.{quantity.name}",
        lambda setup: (quantity.name,),
        partial(_expression_column, quantity),
        input_quantities=lambda setup: quantity.quantities_read,
        last=runs_last,
    )


def _expression_column(
    quantity: OwnQuantity, case: EvaluationBlock, wanted_quantities: frozenset[str]
) -> dict[str, Any]:
    columns: Mapping[str, Any] = {name: case.columns[name] for name in quantity.quantities_read}
    count = len(case.designs)
    if quantity.function_call:
        columns = {
            name: np.broadcast_to(np.asarray(column, dtype=float), (count,)) for name, column in columns.items()
        }
    with np.errstate(all="ignore"):
        value = np.asarray(quantity.tree.evaluate(columns), dtype=float) + np.zeros(count)
    value = np.where(np.isfinite(value), value, np.inf)
    if quantity.function_call or not any(name in case.outward for name in columns):
        return {quantity.name: value}
    enclosure = expression_range(
        quantity, {n: column_enclosure(column, case.outward.get(n, 0.0)) for n, column in columns.items()}
    )
    with np.errstate(**UNBOUNDED_ERRSTATE):
        width = np.maximum(enclosure.high - value, value - enclosure.low)
        scale = np.fmax(np.abs(value), largest_term_magnitude(quantity.tree, columns))
    return {quantity.name: EnclosedValue(value, np.where(np.isfinite(value), width, 0.0), scale)}


def largest_term_magnitude(tree: Any, columns: Mapping[str, Any]) -> Any:
    """Largest magnitude of the terms of an expression, the scale of its error if they cancel."""
    match tree.rule:
        case "+" | "-" | "min" | "max":
            return reduce(np.maximum, (largest_term_magnitude(part, columns) for part in tree.parts))
        case "neg" | "abs":
            return largest_term_magnitude(tree.parts[0], columns)
        case "*":
            return largest_term_magnitude(tree.parts[0], columns) * largest_term_magnitude(tree.parts[1], columns)
        case "/":
            return largest_term_magnitude(tree.parts[0], columns) / np.abs(tree.parts[1].evaluate(columns))
        case "**":
            power = largest_term_magnitude(tree.parts[0], columns) ** tree.parts[1].evaluate(columns)
            return np.fmax(np.abs(tree.evaluate(columns)), power)
    return np.abs(tree.evaluate(columns))


def expression_range(quantity: OwnQuantity, ranges: Mapping[str, Interval]) -> Interval:
    """Range of the quantity over ranges of the quantities that it reads."""
    with np.errstate(**UNBOUNDED_ERRSTATE):
        return as_interval(quantity.tree.evaluate(ranges, RANGE_RULES))


def column_enclosure(column: Any, outward_width: Any) -> Interval:
    """The enclosure of a column as intervals."""
    far = column + np.where(np.isfinite(column), outward_width, 0.0)
    return Interval(np.minimum(column, far), np.maximum(column, far))


# ----------------------------------------------------------------------------------- expressions over intervals


def _range_power(a: Interval, exponent: Interval) -> Interval:
    """A base to a power; only whole exponents take a negative base."""
    number = float(exponent.low.flat[0]) if exponent.low.size else 0.0
    same = np.all(exponent.low == number) and np.all(exponent.high == number)
    if same and number == np.floor(number) and abs(number) <= LARGEST_EXPONENT:
        return _range_whole_power(a, int(number))
    low, high = np.maximum(a.low, 0.0), np.maximum(a.high, 0.0)
    ends = [base**by for base in (low, high) for by in (exponent.low, exponent.high)]
    return Interval(reduce(np.fmin, ends), reduce(np.fmax, ends))


def _range_whole_power(base: Interval, exponent: int) -> Interval:
    if exponent < 0:
        return as_interval(1.0 / _range_whole_power(base, -exponent))
    if exponent % 2:
        return Interval(base.low**exponent, base.high**exponent)
    return Interval(base.least_magnitude**exponent, base.largest_magnitude**exponent)


def _range_tangent(a: Interval) -> Interval:
    """The tangent, which rises between its poles; unbounded across a pole."""
    turn = [np.floor(end / np.pi + 0.5) for end in (a.low, a.high)]
    across = ~(turn[0] == turn[1])
    return Interval(np.where(across, -np.inf, np.tan(a.low)), np.where(across, np.inf, np.tan(a.high)))


def _clip_range_to_plus_minus_one(a: Interval) -> Interval:
    return Interval(np.clip(a.low, -1.0, 1.0), np.clip(a.high, -1.0, 1.0))


def _range_of_falling_function(function: Callable[[Any], Any], a: Interval) -> Interval:
    return Interval(function(a.high), function(a.low))


RANGE_OVERRIDES: ExpressionRules = {
    "**": _range_power,
    "tan": _range_tangent,
    "asin": lambda a: np.arcsin(_clip_range_to_plus_minus_one(a)),
    "acos": lambda a: _range_of_falling_function(np.arccos, _clip_range_to_plus_minus_one(a)),
    "radians": lambda a: Interval(np.radians(a.low), np.radians(a.high)),
}
"""Rules of operations that numpy does not give for intervals, or only with wider results."""


def _rule_with_rounding_margin(rule: Callable[..., Any]) -> Callable[..., Interval]:
    """A rule with a margin for rounding; nan bounds become infinite."""

    def rounded_rule(*parts: Any) -> Interval:
        value = rule(*map(as_interval, parts))
        margin = OPERATION_ROUNDING * value.largest_magnitude
        low, high = value.low - margin, value.high + margin
        return Interval(np.where(np.isnan(low), -np.inf, low), np.where(np.isnan(high), np.inf, high))

    return rounded_rule


RANGE_RULES: ExpressionRules = {
    name: _rule_with_rounding_margin(RANGE_OVERRIDES.get(name, rule)) for name, rule in DOUBLE_RULES.items()
}
"""Operators and functions on ranges."""
