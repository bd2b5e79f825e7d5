"""The motion of a stroke that keeps its law: a dwell, or a stretch at constant velocity."""

from typing import Any

import cvxpy as cp
import numpy as np

from camopt.motion.stroke import Stroke
from camopt.motion.table import DWELL, RETURN, RISE
from camopt.numerics import FloatArray
from camopt.synthesis.demand import Demand
from camopt.synthesis.stroke_motion import Ranges, Sizes


class FixedMotion:
    """A straight line over the cam angle: what is linear in the motion holds along it if it does at both ends."""

    def __init__(self, demand: Demand, stroke: Stroke, ranges: Ranges, sizes: Sizes) -> None:
        self.low, self.change = stroke.low / demand.scale, (stroke.high - stroke.low) / demand.scale
        self.velocity = self.change / stroke.angle
        self.rests = stroke.kind == DWELL
        self.limits = [
            limit for low, high in ranges.get(1, []) for limit in (self.velocity >= low, self.velocity <= high)
        ]
        kind = DWELL if self.rests else RISE if self.change > 0.0 else RETURN
        for floor in demand.floors:
            if floor.kinds & kind:
                sized = sizes.in_floor(floor, demand.scale)
                along = floor.velocity * self.velocity + sized
                ends = [self.low] if self.rests else [self.low, self.low + self.change]
                self.limits += [floor.displacement * y + along >= 0 for y in ends]

    def end(self, order: int, last: bool) -> float:
        return (self.low + self.change * last, self.velocity, 0.0, 0.0)[order]

    def at_rest(self, rest: int, last: bool) -> list[Any]:
        return []

    def lowest(self, x: float) -> float:
        return self.low + self.change * x

    def at(self, x: FloatArray) -> list[Any]:
        rows = [self.low + self.change * x, np.full_like(x, self.velocity), *np.zeros((2, x.size))]
        return [cp.Constant(row) for row in rows]

    def samples(self, order: int) -> FloatArray:
        return np.array([self.end(order, last) for last in (False, True)])

    def mirrors(self, other: Any) -> list[Any]:
        return []

    def variation(self) -> Any:
        return cp.Constant(0.0)

    def square(self, order: int) -> Any:
        return cp.Constant(0.0)

    def left_over(self) -> Any:
        """What it leaves is part of the constant (``residual.LeftOver``)."""
        return cp.Constant(0.0)
