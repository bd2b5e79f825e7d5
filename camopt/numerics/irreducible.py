"""An irreducible set of conditions that contradict each other: without any one of them they do not.

Source: Chinneck & Dravnieks, ORSA Journal on Computing 3 (1991), the deletion filter.
"""

from collections.abc import Callable, Sequence
from typing import TypeVar

T = TypeVar("T")


def irreducible(conditions: Sequence[T], feasible: Callable[[Sequence[T]], bool]) -> list[T]:
    """Those of contradictory conditions that are left when each that can be left out is left out."""
    kept = list(conditions)
    for each in conditions:
        others = [other for other in kept if other != each]
        if not feasible(others):
            kept = others
    return kept
