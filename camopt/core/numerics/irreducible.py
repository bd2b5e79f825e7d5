"""An irreducible set of conditions that contradict each other: without any one of them they do not.

Source: Chinneck & Dravnieks, ORSA Journal on Computing 3 (1991), the deletion filter.
"""

from collections.abc import Callable, Sequence
from typing import TypeVar

Requirement = TypeVar("Requirement")


def irreducible_set(
    conditions: Sequence[Requirement], feasible: Callable[[Sequence[Requirement]], bool]
) -> list[Requirement]:
    """A smallest contradictory set: conditions are left out while the others still contradict each other."""
    kept = list(conditions)
    for each in conditions:
        others = [other for other in kept if other != each]
        if not feasible(others):
            kept = others
    return kept
