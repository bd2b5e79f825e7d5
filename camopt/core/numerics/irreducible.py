"""An irreducible set of contradictory conditions: without any one of them, the others can be met.

Source: Chinneck & Dravnieks, ORSA Journal on Computing 3 (1991), the deletion filter.
"""

from collections.abc import Callable, Sequence
from typing import TypeVar

Requirement = TypeVar("Requirement")


def irreducible_set(
    conditions: Sequence[Requirement], feasible: Callable[[Sequence[Requirement]], bool]
) -> list[Requirement]:
    """Drop conditions as long as the others are still contradictory."""
    remaining = list(conditions)
    for condition in conditions:
        others = [other for other in remaining if other != condition]
        if not feasible(others):
            remaining = others
    return remaining
