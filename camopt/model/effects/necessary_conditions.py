"""Necessary conditions on any cam that follow from a bound on a quantity."""

from math import inf
from typing import NamedTuple


class LeastForce(NamedTuple):
    """A least contact force at every cam angle, at a speed of the cam."""

    omega: float
    """Speed of the cam [rad/s]."""
    force: float
    """Force at the trace point [N]."""


class NecessaryConditions(NamedTuple):
    """Conditions that every design within a bound meets."""

    least_size: float = 0.0
    """Least base or mean radius [mm]."""
    most_size: float = inf
    """Largest base or mean radius [mm]."""
    reach: float = inf
    """Largest reach along a flat face [mm]."""
    force: LeastForce | None = None
    """Least contact force."""
