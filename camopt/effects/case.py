"""What an effect is, and the case it works on."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camopt.mechanisms.design import Designs, Mechanism
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray
from camopt.numerics.extremes import extremes, turns_far

REFINEMENTS = (1, 8, 64, 512)  # times the usual number of panels
MARGIN = 1e-4  # of the tolerance, spent on following a maximum: its cam angle, too, is then that good
LARGEST_TURN = 0.25  # tangent of the angle that the normal may turn within a panel


@dataclass(frozen=True)
class Subject:
    """What all designs of a question share: the mechanism and the speed. Lengths in mm, ω in rad/s."""

    mechanism: Mechanism
    angular: bool
    """Whether the follower oscillates, so that its displacement is an angle."""
    pointed: bool
    """Whether the follower is a knife edge."""
    omega: float | None
    shaft_radius: float | None
    tolerance: float = 1e-9


@dataclass(frozen=True)
class Case:
    """A block of designs that share a programme."""

    subject: Subject
    programme: Programme
    designs: Designs

    @cached_property
    def resolution(self) -> list[tuple[int, NDArray[np.intp]]]:
        """Which designs need which refinement of the motion table.

        Where the pitch curve's normal turns far within a panel (s₀ → 0, sin ψ → 0: near a cusp) its curvature
        has peaks narrower than a panel; those few designs are given finer tables until it does not.
        """
        groups = []
        index = np.arange(len(self.designs))
        for refinement in REFINEMENTS:
            some = self.designs.take(index)
            far = np.zeros(len(some), dtype=bool)
            if refinement != REFINEMENTS[-1]:
                pressure = self.subject.mechanism.pressure(some, self.programme)
                turns_far(pressure, len(some), self.programme.table(refinement), LARGEST_TURN, far)
            groups.append((refinement, index[~far]))
            index = index[far]
            if not index.size:
                break
        return groups

    def extremes(
        self, curve: Callable[[Designs, Programme], Any], questions: list[tuple[int, int]]
    ) -> tuple[FloatArray, FloatArray]:
        """Extremes of one of the mechanism's curves: (values, cam angles in rad), each (questions, designs)."""
        asked = np.array(questions, dtype=np.int64)
        value = np.empty((len(questions), len(self.designs)))
        where = np.empty_like(value)
        for refinement, index in self.resolution:
            some = self.designs.take(index)
            v, w = np.empty((len(questions), index.size)), np.empty((len(questions), index.size))
            table = self.programme.table(refinement)
            extremes(curve(some, self.programme), len(some), table, asked, self.subject.tolerance * MARGIN, v, w)
            value[:, index], where[:, index] = v, w
        return value, where


@dataclass(frozen=True)
class Effect:
    """A discipline that computes quantities: what it offers for a subject, and how."""

    name: str
    offers: Callable[[Subject], tuple[str, ...]]
    run: Callable[[Case, frozenset[str]], dict[str, Any]]
    """From a case and the wanted names to columns: arrays (designs,), or one value for all of them."""
