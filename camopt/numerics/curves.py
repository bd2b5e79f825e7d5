"""Quantities as curves over the cam angle, and the formulas that a kernel compiles into itself.

A curve is a NamedTuple of arrays, one entry a design, such as ``TranslatingPressureAngle(lead, height)``. Its
formula gives, for design ``i`` and the motion (y, y', y'', y''' by the cam angle) at one cam angle, the pair
(value, slope by the cam angle). What evaluates curves (``evaluating``) is written once, for any curve: numba
compiles it anew for each NamedTuple type, so a formula costs what it would cost written inside the loop, and the
compiled result is cached on disk.
Names of curve types are unique in the package, because numba names machine code after them.

Uncompiled, the same formulas run on arrays and on intervals (``numerics.interval``).
"""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

from camopt.kernels.compile import chosen_by_type, inlined
from camopt.numerics import FloatArray

Formula = TypeVar("Formula", bound=Callable[..., tuple[Any, Any]])

FORMULAS: dict[type, Callable[..., tuple[Any, Any]]] = {}
LOADED: set[type] = set()


def curve(f: Any, i: Any, y: Any, y1: Any, y2: Any, y3: Any) -> tuple[Any, Any]:
    """Value and slope of curve ``f`` for design ``i``; uncompiled, and resolved by type inside kernels."""
    if isinstance(y3, tuple) and type(f) not in LOADED:
        y3 = y3[0]
    return FORMULAS[type(f)](f, i, y, y1, y2, y3)


@chosen_by_type(curve)
def _formula(f, i, y, y1, y2, y3):
    function = FORMULAS.get(f)
    if function is None or f in LOADED or y3 is not tuple:
        return function
    alone = inlined(function)
    return lambda f, i, y, y1, y2, y3: alone(f, i, y, y1, y2, y3[0])


def formula(owner: type, *, loaded: bool = False) -> Callable[[Formula], Formula]:
    """Register a function as the formula of the curve type ``owner``.

    An external load that changes over the turn comes along with y''', as (y''', load, slope of the load). A formula
    that is ``loaded`` gets all of it, to read or to hand on to the curves it is made of; any other y''' alone.
    """

    def register(function: Formula) -> Formula:
        FORMULAS[owner] = function
        if loaded:
            LOADED.add(owner)
        return function

    return register


class Linear(NamedTuple):
    """displacement·y + velocity·y' + acceleration·y'' + constant: peaks, support lines, a flat face's radius."""

    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    constant: FloatArray


@formula(Linear)
def linear(f, i, y, y1, y2, y3):
    value = f.constant[i] + f.displacement[i] * y + f.velocity[i] * y1 + f.acceleration[i] * y2
    return value, f.displacement[i] * y1 + f.velocity[i] * y2 + f.acceleration[i] * y3
