"""When tools pass a position, of all cams within tolerances: the earliest and the latest cam angle.

At worst the tool stands at y + upper or y + lower of its errors (``tolerances.turn``). It may have passed a level
outward as soon as the first of them is there, and surely has when the second one is; inward the other way round. No
velocity divides an error: where the tool is slow, an angle is as far off as the motion takes to make up for it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, pi
from typing import NamedTuple

import numpy as np

from camopt.numerics import FloatArray
from camopt.tolerances.turn import TurnErrors, worst_ends

STEPS, FINER, ZOOMS = 1440, 33, 8
"""Cam angles of a turn that are looked at, and how often, and with how many, between two of them."""


class PassedBetween(NamedTuple):
    """The cam angles between which all cams pass a level, rad: beyond the turn if need be; infinite if never."""

    earliest: float
    latest: float


@dataclass(frozen=True)
class Passing:
    """A level of the tool, and the turn of a cam with tolerances."""

    turn: TurnErrors
    level: float
    """mm (rad)."""

    def about(self, angle: float, *, outward: bool) -> PassedBetween:
        """When the cams pass that level which the nominal one passes at a cam angle, rad."""
        first, last = (1.0, -1.0) if outward else (-1.0, 1.0)
        return PassedBetween(self._until(angle, -1.0, first), self._until(angle, 1.0, last))

    def _until(self, angle: float, way: float, side: float) -> float:
        """How far backward or forward some cam still is at the level, at the upper or lower end of its error."""
        return until(angle, way, lambda angles: side * self._above(angles, side))

    def _above(self, angles: FloatArray, side: float) -> FloatArray:
        """How far above the level the tool is at an end of its error."""
        within = np.mod(angles, 2 * pi)
        ends = worst_ends(self.turn.at(within), 0)
        y = self.turn.problem.programme.tool.at(within)[0]
        return np.asarray(y + (ends.upper if side > 0.0 else ends.lower) - self.level)


def until(angle: float, way: float, above: Callable[[FloatArray], FloatArray]) -> float:
    """Up to which place, backward or forward from one, a value stays 0 or more; infinite if all over the turn."""
    near, far = 0.0, 2 * pi
    for count in (STEPS, *[FINER] * ZOOMS):
        steps = np.linspace(near, far, count)
        reached = above(angle + way * steps) >= 0.0
        reached[0] = True
        if reached.all():
            return way * inf if far == 2 * pi else angle + way * far
        first = int(np.argmin(reached))
        near, far = float(steps[first - 1]), float(steps[first])
    return angle + way * (near + far) / 2
