"""What a bound on a quantity implies, whatever else a cam is."""

from math import inf
from typing import NamedTuple


class LeastForce(NamedTuple):
    """A contact force that there has to be at every cam angle, if the cam turns at a speed."""

    omega: float
    """rad/s."""
    force: float
    """N, at the trace point."""


class Implied(NamedTuple):
    """What no design lacks that meets a bound."""

    least_size: float = 0.0
    """A base (mean) radius below which none does, mm."""
    most_size: float = inf
    """And one above which none does, mm."""
    force: LeastForce | None = None
    """The contact force without which none does."""
