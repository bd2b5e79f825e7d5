"""What a convex programme asks of the motion of a stroke, whatever that is made of."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from camopt.motion.stroke import Stroke
from camopt.synthesis.demand import Demand, LinearConstraint

Ranges = dict[int, list[tuple[Any, Any]]]
"""Ranges of a stroke's derivatives, by order; all of a list hold."""


@dataclass(frozen=True)
class Sizes:
    """e, s₀ and the prime radius of the cam, in units of ``Demand.length``; those that oscillate have s₀ alone."""

    lead: Any
    height: Any
    prime: Any

    def in_floor(self, floor: LinearConstraint, unit: float) -> Any:
        """What sizes and constants add to a linear limit, whose lengths are in a unit."""
        parts = ((floor.lead, self.lead), (floor.height, self.height))
        return sum((weight * size for weight, size in parts if weight), start=floor.constant / unit)


class StrokeMotion(Protocol):
    """The motion of one stroke in units of the lift, by rad: its limits, and what others need of it."""

    limits: list[Any]

    def end(self, order: int, last: bool) -> Any:
        """y or a derivative at an end of the stroke, or None if it is not known there."""

    def at_rest(self, rest: int, last: bool) -> list[Any]:
        """What makes so many derivatives zero at an end, beside a dwell."""

    def lowest(self, x: float) -> Any:
        """y at x of the unit stroke, where the motion is lowest; of a bound, anything."""

    def mirrors(self, other: Any) -> list[Any]:
        """What makes another such motion its mirror image; nothing of a bound, which is one for all motions."""

    def variation(self) -> Any:
        """The variation of the jerk over the stroke, or no less than that."""

    def square(self, order: int) -> Any:
        """√∫ (y⁽ᵏ⁾)² dθ over the stroke, or no more than that."""

    def left_over(self) -> Any:
        """What it adds to the vibration at the start of each dwell, mm (dwells, 2); None if that is not known."""


MakeMotion = Callable[[Demand, Stroke, Ranges, Sizes], StrokeMotion]
