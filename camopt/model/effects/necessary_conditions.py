"""Necessary conditions that follow from a bound on a quantity, for any cam."""

from math import inf
from typing import NamedTuple


class LeastForce(NamedTuple):
    """A least contact force at every cam angle, at a given speed of the cam."""

    omega: float
    """rad/s."""
    force: float
    """N, at the trace point."""


class NecessaryConditions(NamedTuple):
    """Conditions that every design within a bound meets."""

    least_size: float = 0.0
    """A base (mean) radius below which none does, mm."""
    most_size: float = inf
    """And one above which none does, mm."""
    reach: float = inf
    """The reach along a flat face beyond which none does, mm."""
    force: LeastForce | None = None
    """The contact force without which none does."""
