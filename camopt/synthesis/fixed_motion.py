"""The motion of a stroke that keeps its law: a dwell, or a stretch at constant velocity."""

from typing import Any

import numpy as np

from camopt.motion.stroke import Stroke
from camopt.motion.table import DWELL, RETURN, RISE
from camopt.numerics import FloatArray
from camopt.synthesis.demand import Demand
from camopt.synthesis.rows import ConvexRows, LinearSum, LinearTerm
from camopt.synthesis.stroke_motion import Ranges, Sizes


class FixedMotion:
    """A straight line over the cam angle: what is linear in the motion holds along it if it does at both ends."""

    def __init__(self, demand: Demand, stroke: Stroke, ranges: Ranges, sizes: Sizes) -> None:
        self.low, self.change = stroke.low / demand.scale, (stroke.high - stroke.low) / demand.scale
        self.angle = stroke.angle
        self.velocity = self.change / stroke.angle
        self.rows = ConvexRows()
        for each in ranges.get(1, []):
            self.rows.at_least((self.velocity, 1.0), (-each.low, each.unit))
            self.rows.at_least((-self.velocity, 1.0), (each.high, each.unit))
        kind = DWELL if stroke.kind == DWELL else RISE if self.change > 0.0 else RETURN
        ends = self.low if kind == DWELL else np.array([self.low, self.low + self.change])
        for floor in demand.floors:
            if floor.kinds & kind:
                along = floor.displacement * ends + floor.velocity * self.velocity
                self.rows.at_least((along, 1.0), *sizes.in_floor(floor, demand.scale))

    def _at(self, order: int, last: bool) -> float:
        return (self.low + self.change * last, self.velocity, 0.0, 0.0)[order]

    def end(self, order: int, last: bool) -> list[LinearTerm]:
        return [(self._at(order, last), 1.0)]

    def rests(self, rest: int, last: bool) -> None:
        """It does, or is no neighbour of a dwell that asks for it."""

    def lowest(self, x: float) -> list[LinearTerm]:
        return [(self.low + self.change * x, 1.0)]

    def at(self, x: FloatArray) -> list[LinearSum]:
        rows = [self.low + self.change * x, np.full_like(x, self.velocity), *np.zeros((2, x.size))]
        return [[(row, 1.0)] for row in rows]

    def samples(self, order: int) -> FloatArray:
        return np.array([self._at(order, last) for last in (False, True)])

    def mirrors(self, other: Any) -> None:
        """A straight line mirrors another as it is."""

    def crosses(self, crossing: Any, jerk: Any) -> None:
        """A straight line has no force that turns round."""

    def opposes(self, other: Any, both: float) -> None:
        """A straight line opposes another as it is."""

    def variation(self) -> list[LinearSum]:
        return []

    def square(self, order: int) -> list[LinearSum]:
        return []

    def area(self) -> list[LinearTerm]:
        return [((self.low + self.change / 2.0) * self.angle, 1.0)]

    def left_over(self) -> list[LinearSum]:
        """What it leaves is part of the constant (``residual.LeftOver``)."""
        return []
