"""A straight spring on the arm of an oscillating follower, replaced by a torsion spring at the pivot.

    k_θ = k·a²,    M₀ = F₀·a

for a spring at distance a from the pivot, square to its lever where the follower is lowest. After a swing φ the
moment of the straight spring is (F₀ + k·a·sin φ)·a·cos φ: about 1.5 % less for φ = 10 deg.
"""

from collections.abc import Mapping
from typing import Any

from camopt.core.quantities import NUMBERS, SPRING_AT
from camopt.scene.mapping import value_at_key

SPRING_NUMBERS = tuple(each.key for each in NUMBERS if each.motion_of == "spring")
"""Numbers of the spring; for a straight spring they are forces, for a torsion spring moments."""


def has_straight_spring(data: Mapping[str, Any]) -> bool:
    """Whether the spring of a scene is a straight one on an arm, so that its numbers are forces."""
    return any(value_at_key(data, key) is not None for key in (SPRING_AT, f"search.{SPRING_AT}"))
