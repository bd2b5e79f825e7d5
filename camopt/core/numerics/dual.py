"""Dual numbers: a value with its slope by the cam angle, which formulas carry along by the chain rule.

Value and slope may be of any number type: floats, arrays, jets, intervals, balls, or dual numbers themselves, which
then have the next derivative. A formula that runs on the value alone gives the same value.

Source: Griewank and Walther, Evaluating Derivatives, ch. 3 (forward mode).
"""

import operator
from types import NoneType
from typing import Any, NamedTuple

import numpy as np

from camopt.core.kernels.marks import chosen_by_type, inline_in_kernels_by_overload
from camopt.core.numerics.jet import Jet, power_of_number
from camopt.core.numerics.number_type import OTHER, OWN, OperationRules, register_number_operations
from camopt.core.numerics.state import Load, State, TrainForces

PLAIN_KINDS = (float, np.ndarray, Jet)
"""Number types whose operators do not take dual numbers."""


class Dual(NamedTuple):
    """A number with its slope by the cam angle [1/rad]."""

    value: Any
    slope: Any


def as_dual_constant(x: Any) -> Any:
    """A constant as a dual number with slope 0, unless it is a plain number."""
    return x if isinstance(x, PLAIN_KINDS) else Dual(x, 0.0)


chosen_by_type(as_dual_constant)(lambda x: lambda x: x)


def constant_like(constant: Any, template: Any) -> Any:
    """A constant in the form in which it combines with ``template``."""
    return as_dual_constant(constant_like(constant, template.value)) if type(template) is Dual else constant


def _divide_duals(a, b):
    value = a.value / b.value
    return Dual(value, (a.slope - value * b.slope) / b.value)


def _divide_number_by_dual(a, b):
    value = a / b.value
    return Dual(value, -(value * b.slope) / b.value)


def _dual_root(a):
    value = np.sqrt(a.value)
    return Dual(value, 0.5 * a.slope / value)


def _dual_power(a, b):
    value = power_of_number(a.value, b)
    return Dual(value, b * value * a.slope / a.value)


def _larger_of_dual_and_number(a, b):
    """The larger of a and a number; where they are equal, with the mean of both slopes."""
    return Dual(np.maximum(a.value, b), 0.5 * (1.0 + np.sign(a.value - b)) * a.slope)


DUAL_RULES: OperationRules = {
    operator.add: {
        (OWN, OWN): lambda a, b: Dual(a.value + b.value, a.slope + b.slope),
        (OWN, OTHER): lambda a, b: Dual(a.value + b, a.slope),
        (OTHER, OWN): lambda a, b: Dual(a + b.value, b.slope),
    },
    operator.sub: {
        (OWN, OWN): lambda a, b: Dual(a.value - b.value, a.slope - b.slope),
        (OWN, OTHER): lambda a, b: Dual(a.value - b, a.slope),
        (OTHER, OWN): lambda a, b: Dual(a - b.value, -b.slope),
    },
    operator.mul: {
        (OWN, OWN): lambda a, b: Dual(a.value * b.value, a.slope * b.value + a.value * b.slope),
        (OWN, OTHER): lambda a, b: Dual(a.value * b, a.slope * b),
        (OTHER, OWN): lambda a, b: Dual(a * b.value, a * b.slope),
    },
    operator.truediv: {
        (OWN, OWN): _divide_duals,
        (OWN, OTHER): lambda a, b: Dual(a.value / b, a.slope / b),
        (OTHER, OWN): _divide_number_by_dual,
    },
    operator.pow: {(OWN, OTHER): _dual_power},
    operator.neg: {(OWN,): lambda a: Dual(-a.value, -a.slope)},
    np.sqrt: {(OWN,): _dual_root},
    np.square: {(OWN,): lambda a: Dual(np.square(a.value), 2.0 * a.value * a.slope)},
    np.absolute: {(OWN,): lambda a: Dual(np.absolute(a.value), np.sign(a.value) * a.slope)},
    np.maximum: {(OWN, OTHER): _larger_of_dual_and_number},
    np.sign: {(OWN,): lambda a: as_dual_constant(np.sign(a.value))},
}
"""Rules of each operation for operands that are dual numbers or others. A sign is a constant."""


register_number_operations(Dual, DUAL_RULES, lambda rule, operands: rule(*operands), (object,))


def dual_load(load: Any) -> Any:
    """A load with dual numbers as values; None without a load."""
    if load is None:
        return None
    return _dual_forces(load) if isinstance(load, TrainForces) else Load(Dual(load.value, load.slope), load.slope)


def _dual_forces(load):
    carried = Dual(load.carried, load.carried_slope)
    return TrainForces(Dual(load.value, load.slope), load.slope, carried, load.carried_slope)


@chosen_by_type(dual_load)
def _choose_dual_load_for_kernels(load):
    if load is NoneType:
        return lambda load: None
    return _dual_forces if load is TrainForces else lambda load: Load(Dual(load.value, load.slope), load.slope)


@inline_in_kernels_by_overload
def dual_state(at):
    """The state of the follower in dual numbers."""
    y, y1, y2 = Dual(at.y, at.y1), Dual(at.y1, at.y2), Dual(at.y2, at.y3)
    return State(y, y1, y2, Dual(at.y3, at.y4), dual_load(at.load), 0.0)


def state_without_slopes(at: State, y: Any) -> State:
    """The state without slopes, if the displacement ``y`` is a dual number; else the state."""
    return _drop_state_slopes(at, y) if type(y) is Dual else at


def _drop_state_slopes(at, y):
    return State(at.y.value, at.y1.value, at.y2.value, at.y3.value, load_from_dual_load(at.load), at.y3.slope)


@chosen_by_type(state_without_slopes)
def _choose_state_without_slopes_for_kernels(at, y):
    return _drop_state_slopes if y is Dual else lambda at, y: at


def load_from_dual_load(load: Any) -> Any:
    """The load without slopes, from a load in dual numbers."""
    if load is None:
        return None
    return _drop_force_slopes(load) if isinstance(load, TrainForces) else Load(load.value.value, load.value.slope)


def _drop_force_slopes(load):
    return TrainForces(load.value.value, load.value.slope, load.carried.value, load.carried.slope)


@chosen_by_type(load_from_dual_load)
def _choose_load_from_dual_for_kernels(load):
    if load is NoneType:
        return lambda load: None
    return _drop_force_slopes if load is TrainForces else lambda load: Load(load.value.value, load.value.slope)


def dual_or_value_from_pair(pair: Any, y: Any) -> Any:
    """A pair of value and slope as a dual number if the displacement ``y`` is one; else the value."""
    return Dual(*pair) if type(y) is Dual else pair[0]


@chosen_by_type(dual_or_value_from_pair)
def _choose_dual_or_value_for_kernels(pair, y):
    return (lambda pair, y: Dual(pair[0], pair[1])) if y is Dual else lambda pair, y: pair[0]
