"""The interference of cams within tolerances with two contacts of their follower: of the mounting, and of errors.

It is δ₀ + s (``tolerances.two_contacts``), where s changes over the turn: of a cam with some sizes s is that of
these, with whatever other errors make of it, at the cam angle at which it is the most, or the least.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees

import numpy as np

from camopt.numerics import FloatArray
from camopt.problem.problem import Problem
from camopt.scene.scene import Scene
from camopt.scene.tolerances import Zone
from camopt.tolerances.turn import TurnErrors
from camopt.tolerances.two_contacts import AnswerApart, Between, answers_apart

NO_INTERFERENCE = 1e-12
"""What is in place of one below 0: what a clearance does no preload tells."""
NO_ZONE = Zone(0.0, 0.0, 0.0)


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
