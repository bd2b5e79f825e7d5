"""An external load on the follower that changes over the turn: straight between the rows of a table, periodic."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import pi, radians

import numpy as np

from camopt.numerics import FloatArray


@dataclass(frozen=True)
class ExternalLoad:
    """Rows (cam angle, load): rad from 0 to 2π in order, two at the same angle where the load jumps; N (N·mm).

    From the last row it goes straight to the first of the next turn. Hashable.
    """

    angles: tuple[float, ...]
    loads: tuple[float, ...]

    @classmethod
    def from_rows(cls, rows: Sequence[tuple[float, float]], unit: float) -> "ExternalLoad":
        """From rows (cam angle in deg, load); ``unit`` of a load in N (N·mm)."""
        return cls(tuple(radians(angle) for angle, _ in rows), tuple(load * unit for _, load in rows))

    @property
    def largest(self) -> float:
        """The largest magnitude."""
        return max(map(abs, self.loads))

    @property
    def highest(self) -> float:
        """The largest load, with its sign."""
        return max(self.loads)

    @cached_property
    def _ends(self) -> tuple[FloatArray, FloatArray]:
        """The rows with the last one of the turn before, and the first of the next."""
        angles = (self.angles[-1] - 2 * pi, *self.angles, self.angles[0] + 2 * pi)
        return np.array(angles), np.array((self.loads[-1], *self.loads, self.loads[0]))

    def at(self, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The load and its slope by the cam angle, from the right where they jump."""
        corners, loads = self._ends
        left = np.clip(np.searchsorted(corners, angles, side="right") - 1, 0, len(corners) - 2)
        slope = (loads[left + 1] - loads[left]) / (corners[left + 1] - corners[left])
        return loads[left] + slope * (angles - corners[left]), slope
