"""The motion of a stroke that keeps its law: a dwell, or a stretch at constant velocity."""

from typing import Any

import cvxpy as cp
import numpy as np
from scipy import sparse

from camopt.motion.stroke import Stroke
from camopt.motion.table import DWELL, RETURN, RISE
from camopt.numerics import FloatArray
from camopt.synthesis.demand import Demand
from camopt.synthesis.stroke_motion import Ranges, Sizes


class FixedMotion:
    """A straight line over the cam angle: what is linear in the motion holds along it if it does at both ends."""

    def __init__(self, demand: Demand, stroke: Stroke, ranges: Ranges, sizes: Sizes) -> None:
        self.low, self.change = stroke.low / demand.scale, (stroke.high - stroke.low) / demand.scale
        self.angle = stroke.angle
        self.velocity = self.change / stroke.angle
        self.constraints: list[cp.Constraint] = []
        for each in ranges.get(1, []):
            self.constraints += each.constraints(cp.Constant(self.velocity))
        kind = DWELL if stroke.kind == DWELL else RISE if self.change > 0.0 else RETURN
        ends = self.low if kind == DWELL else np.array([self.low, self.low + self.change])
        for floor in demand.floors:
            if floor.kinds & kind:
                along = floor.displacement * ends + floor.velocity * self.velocity
                self.constraints.append(cp.Constant(along) + sizes.in_floor(floor, demand.scale) >= 0.0)

    def end(self, order: int, last: bool) -> float:
        return (self.low + self.change * last, self.velocity, 0.0, 0.0)[order]

    def rests(self, rest: int, last: bool) -> None:
        """It does, or is no neighbour of a dwell that asks for it."""

    def lowest(self, x: float) -> float:
        return self.low + self.change * x

    def at(self, x: FloatArray) -> list[tuple[Any, FloatArray]]:
        """y to y''' at x of the unit stroke: of no coefficients."""
        rows = [self.low + self.change * x, np.full_like(x, self.velocity), *np.zeros((2, x.size))]
        return [(sparse.csr_array((x.size, 0)), row) for row in rows]

    def samples(self, order: int) -> FloatArray:
        return np.array([self.end(order, last) for last in (False, True)])

    def mirrors(self, other: Any) -> None:
        """A straight line mirrors another as it is."""

    def crosses(self, crossing: Any, jerk: Any) -> None:
        """A straight line has no force that turns round."""

    def opposes(self, other: Any, both: float) -> None:
        """A straight line opposes another as it is."""

    def variation(self) -> list[cp.Expression]:
        return []

    def square(self, order: int) -> list[cp.Expression]:
        return []

    def area(self) -> float:
        return (self.low + self.change / 2.0) * self.angle

    def left_over(self) -> list[cp.Expression]:
        """What it leaves is part of the constant (``residual.LeftOver``)."""
        return []
