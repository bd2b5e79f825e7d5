"""What an effect is, and the case it works on."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from camopt.mechanisms.design import Designs, Mechanism
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray
from camopt.numerics.extremes import extremes


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


class Extremes(NamedTuple):
    """Answers (questions, designs): values, their cam angles in rad, and half-widths of their enclosures."""

    value: FloatArray
    where: FloatArray
    width: FloatArray


class Bounded(NamedTuple):
    """A quantity with its enclosure: the true value lies between ``value`` and ``value + outward``.

    Up to rounding it is beyond ``value`` on the side of ``outward`` only. Relative errors refer to ``scale``.
    """

    value: Any
    outward: Any
    scale: Any


@dataclass(frozen=True)
class Case:
    """A block of designs that share a programme."""

    subject: Subject
    programme: Programme
    designs: Designs

    def extremes(
        self,
        curve: Callable[[Designs, Programme], Any],
        questions: list[tuple[int, int]],
        *,
        located: bool = False,
    ) -> Extremes:
        """Extremes of one of the mechanism's curves, for questions (kinds of stroke, goal).

        Cam angles are as exact as values only if ``located``.
        """
        asked, count = np.array(questions, dtype=np.int64), len(self.designs)
        value, where, width = np.empty((3, len(questions), count))
        tolerance = self.subject.tolerance
        location = tolerance if located else np.inf
        extremes(
            curve(self.designs, self.programme), count, self.programme.table, asked, tolerance, location,
            value, where, width,
        )  # fmt: skip
        return Extremes(value, where, width)


@dataclass(frozen=True)
class Effect:
    """A discipline that computes quantities: what it offers for a subject, and how."""

    name: str
    offers: Callable[[Subject], tuple[str, ...]]
    run: Callable[[Case, frozenset[str]], dict[str, Any]]
    """From a case and the wanted names to columns: arrays (designs,) or one value for all, Bounded if inexact."""
