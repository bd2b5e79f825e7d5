"""Quantities as curves over the cam angle, and the formulas that a kernel compiles into itself.

A curve is a NamedTuple of arrays, one entry a design, such as ``TranslatingPressureAngle(lead, height)``. Its
formula gives, for design ``i`` and the state of the follower at one cam angle (``numerics.state``), the pair
(value, slope by the cam angle). What evaluates curves (``evaluating``) is written once, for any curve: numba
compiles it anew for each NamedTuple type, so a formula costs what it would cost written inside the loop, and the
compiled result is cached on disk.
Names of curve types are unique in the package, because numba names machine code after them.

Uncompiled, the same formulas run on arrays and on intervals (``numerics.interval``).
"""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

from camopt.kernels.compile import chosen_by_type
from camopt.numerics import FloatArray
from camopt.numerics.state import State

CurveFormula = TypeVar("CurveFormula", bound=Callable[..., tuple[Any, Any]])

COMPILED: dict[type, Callable[..., tuple[Any, Any]]] = {}
WITH_LOAD: set[type] = set()


def curve(f: Any, i: Any, at: State) -> tuple[Any, Any]:
    """Value and slope of curve ``f`` for design ``i``; uncompiled, and resolved by type inside kernels."""
    return COMPILED[type(f)](f, i, at)


@chosen_by_type(curve)
def _formula(f, i, at):
    return COMPILED.get(f)


def formula(owner: type, *, loaded: bool = False) -> Callable[[CurveFormula], CurveFormula]:
    """Register a function as the formula of the curve type ``owner``.

    One that reads an external load that changes over the turn, or hands it on to a curve that does, is ``loaded``.
    """

    def register(function: CurveFormula) -> CurveFormula:
        COMPILED[owner] = function
        if loaded:
            WITH_LOAD.add(owner)
        return function

    return register


class Linear(NamedTuple):
    """displacement·y + velocity·y' + acceleration·y'' + constant: peaks, support lines, a flat face's radius."""

    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    constant: FloatArray


@formula(Linear)
def linear(f, i, at):
    value = f.constant[i] + f.displacement[i] * at.y + f.velocity[i] * at.y1 + f.acceleration[i] * at.y2
    return value, f.displacement[i] * at.y1 + f.velocity[i] * at.y2 + f.acceleration[i] * at.y3
