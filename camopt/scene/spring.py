"""A straight spring on the arm of an oscillating follower, which acts as a spring about its pivot.

    k_θ = k·a²,    M₀ = F₀·a

for a spring that stands square to its lever, a from the pivot, where the follower is lowest. Away from there the
moment of the straight spring is (F₀ + k·a·sin φ)·a·cos φ: over a swing φ of 10 deg it is about 1.5 % less.
"""

from collections.abc import Mapping
from typing import Any

from camopt.core.quantities import NUMBERS, SPRING_AT
from camopt.scene.mapping import at

OF_SPRING = tuple(each.key for each in NUMBERS if each.of == "spring")
"""Numbers of the spring, whose moment is a force on its lever if it is a straight one."""


def is_straight(data: Mapping[str, Any]) -> bool:
    """Whether the spring in the tables of a scene is a straight one on an arm, whose numbers are no moments."""
    return _given(data, SPRING_AT) is not None


def _given(data: Mapping[str, Any], key: str) -> Any:
    """A value in its table or in ``[search]``."""
    own = at(data, key)
    return at(data, f"search.{key}") if own is None else own
