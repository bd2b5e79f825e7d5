"""A straight spring on the arm of an oscillating follower, which acts as a spring about its pivot.

    k_θ = k·a²,    M₀ = F₀·a

for a spring that stands square to its lever, a from the pivot, where the follower is lowest. Away from there the
moment of the straight spring is (F₀ + k·a·sin φ)·a·cos φ: over a swing φ of 10 deg it is about 1.5 % less.
"""

from collections.abc import Mapping
from typing import Any

from camopt.core.quantities import NUMBERS, SPRING_AT
from camopt.scene.mapping import value_at_key

SPRING_NUMBERS = tuple(each.key for each in NUMBERS if each.motion_of == "spring")
"""Numbers of the spring, whose moment is a force on its lever if it is a straight one."""


def has_straight_spring(data: Mapping[str, Any]) -> bool:
    """Whether the spring in the tables of a scene is a straight one on an arm, whose numbers are no moments."""
    return _number_or_choice(data, SPRING_AT) is not None


def _number_or_choice(data: Mapping[str, Any], key: str) -> Any:
    """A value in its table or in ``[search]``."""
    own = value_at_key(data, key)
    return value_at_key(data, f"search.{key}") if own is None else own
