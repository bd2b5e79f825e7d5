"""The interference of cams within tolerances with two contacts of their follower: of the mounting, and of errors.

It is δ₀ + s (``tolerances.two_contacts``), where s changes over the turn: of a cam with some sizes s is that of
these, with whatever other errors make of it, at the cam angle at which it is the most, or the least.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees

import numpy as np

from camopt.effects.answers import SECOND
from camopt.numerics import FloatArray
from camopt.problem.problem import Problem
from camopt.scene.scene import Scene
from camopt.scene.tolerances import Zone, moves_tool
from camopt.tolerances.largest import columns, each_of
from camopt.tolerances.recontact import Off
from camopt.tolerances.turn import TurnErrors
from camopt.tolerances.two_contacts import BASES, AnswerApart, Between, PairResponses, answers_apart

INTERFERENCE, NO_INTERFERENCE = "drive.interference", 1e-12
"""The second is in place of one below 0: what a clearance does no preload tells."""
AT_ONCE = 2**8
"""Cams: what is computed of them at all cam angles stays in the cache of a processor."""
NO_ZONE = Zone(0.0, 0.0, 0.0)


def moving_apart(off: Off) -> Off:
    """Those of some errors that may hold two contacts further apart."""
    return {key: each for key, each in off.items() if key in BASES or moves_tool(key.removesuffix(SECOND))}


@dataclass(frozen=True)
class Interference:
    """That of all cams within the tolerances, in the unit of its key."""

    nominal: float
    mounted: Zone
    """By how much the mounting alone is off."""
    answers: tuple[AnswerApart, ...]
    unit: float

    @classmethod
    def of(cls, scene: Scene, problem: Problem, nominal: float, mounted: Zone | None) -> "Interference":
        answers = answers_apart(scene, problem, TurnErrors(scene, problem).nodes)
        return cls(nominal, mounted or NO_ZONE, (*answers,), degrees(1.0) if problem.setup.angular else 1.0)

    @property
    def zone(self) -> Zone:
        """By how much that of any cam may be off."""
        low, high = (float(end[0]) - self.nominal for end in self.within({}))
        return Zone(low, high, 0.0)

    def within(self, off: Mapping[str, FloatArray]) -> Between:
        """Between which values it is of cams (n,) whose sizes are off by so much, by their keys."""
        none = np.zeros((1, 1))  # of one cam, where no size is said
        low, high = (sum((each.of(off.get(each.key), end) for each in self.answers), none) for end in (0, 1))
        ends = (
            self.nominal + self.mounted.lower + self.unit * low.min(axis=-1),
            self.nominal + self.mounted.upper + self.unit * high.max(axis=-1),
        )
        return Between(*np.maximum(ends, min(NO_INTERFERENCE, self.nominal)))

    def of_drawn(self, problem: Problem, off: Off, waves: int, angles: FloatArray) -> Between | None:
        """Its least and its most over the turn, of cams with errors (n,); None where none of them is of it."""
        moving = moving_apart(off)
        mounted = self.nominal + off.get(INTERFERENCE, 0.0)
        if not moving:
            return None
        answers = PairResponses(problem, angles)
        rows = np.array([row for key in moving for row in answers.rows_apart(key, waves)])

        def ends(some: Off) -> list[FloatArray]:
            apart = columns(some) @ rows
            return [apart.min(axis=1), apart.max(axis=1)]

        found = np.hstack([*each_of(moving, ends, AT_ONCE)])
        low, high = np.maximum(mounted + self.unit * found, min(NO_INTERFERENCE, self.nominal))
        return Between(low, high)
