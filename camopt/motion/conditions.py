"""Conditions on a motion: at one cam angle, or all along a range of them."""

from math import isfinite
from typing import NamedTuple

DERIVATIVE_NAMES = ("position", "velocity", "acceleration", "jerk")
"""Of y and its derivatives by the cam angle, by order."""
MISSED = (1e-6, 1e-6, 1e-5, 1e-3)
"""By what share of its largest value a motion, and each derivative, may miss what is asked: a solver does."""


class Condition(NamedTuple):
    """Bounds on the motion or one of its derivatives, at a cam angle or all along a range of them."""

    key: str
    """Of the scene that asks for it."""
    order: int
    start: float  # cam angles, rad
    end: float
    low: float  # mm (rad, or deg) by radᵏ; infinite where nothing is asked
    high: float

    def widened(self, share: float) -> "Condition":
        """The condition with a range that is wider by a share; one value stays as it is."""
        by = share * (self.high - self.low)
        return self._replace(low=self.low - by, high=self.high + by) if isfinite(by) else self
