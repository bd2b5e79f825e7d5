"""An external load on the follower that changes over the turn: straight between the rows of a table, periodic."""

from dataclasses import dataclass
from functools import cached_property
from math import pi, radians

import numpy as np

from camopt.numerics import FloatArray, IntArray
from camopt.numerics.loading import LoadTable, tabulated_load
from camopt.numerics.piecewise import MotionTable
from camopt.numerics.state import Load


@dataclass(frozen=True)
class ExternalLoad:
    """Rows (cam angle, load) as given: deg from 0 to 360 in order, two at the same angle where the load jumps.

    ``unit`` is that of a load in N (N·mm). From the last row the load goes straight to the first of the next turn.
    """

    rows: tuple[tuple[float, float], ...]
    unit: float

    @cached_property
    def angles(self) -> tuple[float, ...]:
        """The cam angles of the rows, rad."""
        return tuple(radians(angle) for angle, _ in self.rows)

    @cached_property
    def loads(self) -> tuple[float, ...]:
        """The loads of the rows, N (N·mm)."""
        return tuple(load * self.unit for _, load in self.rows)

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

    def state(self, angles: FloatArray, motion: FloatArray, way: FloatArray) -> Load:
        """The load as curves take it, whatever the motion."""
        return Load(*self.at(angles))

    def tabulated(self, table: MotionTable, strokes: IntArray) -> LoadTable:
        """The load on the panels of a turn, which are cut where it has corners."""
        centre, slope = self.at(table.centre)
        return tabulated_load(centre, slope, self.largest, table.half_width, table.first_panel, table.group)
