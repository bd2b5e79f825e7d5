"""Curves: functions of the cam angle, and their formulas, which kernels compile into themselves.

A curve is a NamedTuple of arrays, with one entry a design, and of other curves, such as
``jamming_ratio(pressure_tangent, friction_intercept, friction_slope)``. Its formula is a plain function with the
same parameters. It gives the value for one design, from the follower's state at one cam angle (``numerics.state``)
and the design's entries. With dual numbers (``numerics.dual``) it also gives the slope by the cam angle.

The code that evaluates curves (``curve_kernels``) is written once. Numba compiles it for each type of curve, so a
formula runs as fast as if it were written inside the loop, and the machine code is kept on disk. Names of curve
types are unique in the package, because numba names machine code after them.

Uncompiled, the same formulas run on arrays and on intervals (``numerics.interval``).
"""

from collections import namedtuple
from collections.abc import Callable
from inspect import Parameter, signature
from typing import Any, NamedTuple, TypeVar

import numpy as np

from camopt.core.kernels.marks import chosen_by_type, inline_in_kernels, inline_in_kernels_by_overload
from camopt.core.numerics import Curve, FloatArray, Number
from camopt.core.numerics.dual import constant_like, dual_or_value_from_pair, dual_state, state_without_slopes
from camopt.core.numerics.state import State
from camopt.core.numerics.trigonometry import cosine_and_sine_of_sum

DerivativeFormula = TypeVar("DerivativeFormula", bound=Callable[..., tuple[Any, Any, Any, Any]])
CurveFormula = TypeVar("CurveFormula", bound=Callable[..., Any])

CURVE_FORMULAS: dict[type, Callable[..., Any]] = {}
KERNEL_FORMULAS: dict[type, Callable[..., Any]] = {}
DERIVATIVE_FORMULAS: dict[type, Callable[..., tuple[Any, Any, Any, Any]]] = {}
LOADED_CURVES: set[type] = set()


def curve_value(curve: Curve, design: Any, state: State) -> Number:
    """Value of a curve for one design, or for several, in a state, in the number type of the state."""
    return CURVE_FORMULAS[type(curve)](curve, design, state)


@chosen_by_type(curve_value)
def _choose_formula_for_kernels(curve, design, state):
    return KERNEL_FORMULAS.get(curve)


@inline_in_kernels_by_overload
def value_and_slope(curve, design, state):
    """Value and slope of a curve for one design."""
    return curve_value(curve, design, dual_state(state))


def curve_or_number_value(curve: Curve, design: Any, state: State) -> Number:
    """A field's value in a formula: that of a curve, or the number of a design."""
    if type(curve) in CURVE_FORMULAS:
        return CURVE_FORMULAS[type(curve)](curve, design, state)
    return constant_like(curve[design], state.y)


@chosen_by_type(curve_or_number_value)
def _choose_field_value_for_kernels(curve, design, state):
    return KERNEL_FORMULAS.get(curve, lambda curve, design, state: curve[design])


def curve_type_from_formula(function: Callable[..., Any] | None = None, *, reads_load: bool = False) -> Any:
    """Make a curve type from a formula: a NamedTuple of its parameters other than the state.

    A parameter with a default is a table that all designs share. A formula is ``reads_load`` if it, or a curve in
    it, reads an external load that changes over the turn.
    """
    if function is None:
        return lambda function: curve_type_from_formula(function, reads_load=reads_load)
    _, *fields = signature(function).parameters.values()
    make: Any = namedtuple
    owner = make(function.__name__, [field.name for field in fields], module=function.__module__)
    owner.__doc__ = function.__doc__
    parts = [
        f"curve.{x.name}" if x.default is not Parameter.empty else f"part(curve.{x.name}, design, state)"
        for x in fields
    ]
    text = f"lambda curve, design, state: formula(state, {', '.join(parts)})"
    curve_formula(owner, reads_load=reads_load)(eval(text, {"formula": function, "part": curve_or_number_value}))
    KERNEL_FORMULAS[owner] = eval(text, {"formula": inline_in_kernels(function), "part": curve_or_number_value})
    return owner


def curve_formula(curve_type: type, *, reads_load: bool = False) -> Callable[[CurveFormula], CurveFormula]:
    """Register the formula of a curve type: a function of the curve, a design and the state."""

    def register(function: CurveFormula) -> CurveFormula:
        CURVE_FORMULAS[curve_type] = KERNEL_FORMULAS[curve_type] = function
        if reads_load:
            LOADED_CURVES.add(curve_type)
        return function

    return register


def value_and_slope_formula(
    curve_type: type, *, reads_load: bool = False
) -> Callable[[CurveFormula], CurveFormula]:
    """Register a formula that returns both value and slope."""

    def register(function: CurveFormula) -> CurveFormula:
        pair = inline_in_kernels(function)
        curve_formula(curve_type, reads_load=reads_load)(
            lambda curve, design, state: dual_or_value_from_pair(
                pair(curve, design, state_without_slopes(state, state.y)), state.y
            )
        )
        return function

    return register


def curve_derivatives(curve: Curve, design: Any, state: State) -> tuple[Any, Any, Any, Any]:
    """Value of a curve for one design, and three derivatives by the cam angle; the last one needs y''''."""
    return DERIVATIVE_FORMULAS[type(curve)](curve, design, state)


@chosen_by_type(curve_derivatives)
def _choose_curve_derivatives_for_kernels(curve, design, state):
    return DERIVATIVE_FORMULAS.get(curve)


def derivative_formula(curve_type: type) -> Callable[[DerivativeFormula], DerivativeFormula]:
    """Register the formula of ``curve_derivatives`` for a curve type."""

    def register(function: DerivativeFormula) -> DerivativeFormula:
        DERIVATIVE_FORMULAS[curve_type] = function
        return function

    return register


@inline_in_kernels
def quotient_derivatives(w, s):
    """w/s with three derivatives, from those of w and s."""
    t = w[0] / s[0]
    t1 = (w[1] - t * s[1]) / s[0]
    t2 = (w[2] - 2.0 * t1 * s[1] - t * s[2]) / s[0]
    return t, t1, t2, (w[3] - 3.0 * t2 * s[1] - 3.0 * t1 * s[2] - t * s[3]) / s[0]


@inline_in_kernels
def cosine_and_sine_derivatives_of_sum(cosine, sine, at):
    """Cosine and sine of an angle plus y, each with three derivatives."""
    c, s = cosine_and_sine_of_sum(cosine, sine, at.y)
    c1, s1, square = -s * at.y1, c * at.y1, np.square(at.y1)
    c2, s2 = -s * at.y2 - c * square, c * at.y2 - s * square
    c3 = -s * at.y3 - 3.0 * c * at.y1 * at.y2 + s * at.y1 * square
    return (c, c1, c2, c3), (s, s1, s2, c * at.y3 - 3.0 * s * at.y1 * at.y2 - c * at.y1 * square)


class Linear(NamedTuple):
    """displacement·y + velocity·y' + acceleration·y'' + constant, for peaks, support lines and flat faces."""

    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    constant: FloatArray


@value_and_slope_formula(Linear)
def linear_value_and_slope(curve, design, state):
    displacement, velocity = curve.displacement[design], curve.velocity[design]
    acceleration = curve.acceleration[design]
    value = curve.constant[design] + displacement * state.y + velocity * state.y1 + acceleration * state.y2
    return value, displacement * state.y1 + velocity * state.y2 + acceleration * state.y3
