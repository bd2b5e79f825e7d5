"""The answer of the search for the smallest cam, and the tests that it uses."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from math import inf
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.clock import now
from camopt.model.effects.crossing_boxes import KnownCrossings
from camopt.model.mechanisms.design import SECOND_SIZE, Designs, SizeBounds
from camopt.scene.problem.problem import Problem
from camopt.solve.verdicts.judging import LAST_AT_ONCE, evaluate_rows
from camopt.solve.verdicts.screening import feasible

GAP = 1e-9  # of the prime radius: a size is proved if the least feasible one is smaller by no more


def discs_of(bounds: SizeBounds) -> tuple[str, ...]:
    """The sizes, by field of designs, the largest of which is to be least: of a pair both, if both have a range."""
    low, high = bounds.get(SECOND_SIZE, (0.0, 0.0))
    return ("size", SECOND_SIZE) if low < high else ("size",)


def size_of(designs: Designs, discs: tuple[str, ...]) -> Any:
    """The largest of some sizes of each design."""
    return reduce(np.maximum, (designs.sizes[disc] for disc in discs))


@dataclass(frozen=True)
class Smallest:
    """The answer for one programme: the design, or why there is none."""

    design: Designs | None
    floor: float
    """A size that no feasible design of these bounds undercuts, mm; infinite if there is none."""
    nearest: Designs | None = None
    """Without a design: the one of those looked at that exceeds its limits the least."""
    discs: tuple[str, ...] = ("size",)
    """The sizes, by field, the largest of which is least."""
    beside: float = 0.0
    """By how much the smaller disc of a pair may be smaller beside the larger one, mm."""
    every_cam: str = ""
    """Whether every cam within the tolerances holds the limits with the design, if they have to."""

    @property
    def size(self) -> float:
        """The size of the design; infinite if there is none."""
        return inf if self.design is None else float(size_of(self.design, self.discs)[0])

    @property
    def gap(self) -> float:
        """By how much a feasible design of these bounds may be smaller, mm; 0 where none exists at all."""
        return max(self.beside, 0.0 if self.size <= self.floor else float(self.size - self.floor))

    @property
    def proved(self) -> bool:
        """Whether no feasible design of these bounds is smaller by more than ``gap_of``."""
        return self.gap <= (0.0 if self.design is None else gap_of(self.design))

    def moved(self, by: FloatArray) -> Designs:
        """The design with the sizes that are made least larger by some lengths, mm."""
        assert self.design is not None
        moved = self.design.take(np.zeros(by.size, dtype=int))
        return moved.with_values({disc: moved.sizes[disc] + by for disc in self.discs})


def gap_of(design: Designs) -> float:
    """How much smaller than a proved design the least feasible one may be, mm."""
    return GAP * float(design.prime_radius[0])


def first_feasible(
    problem: Problem, designs: Designs, crossings: KnownCrossings | None, until: float = inf
) -> Designs | None:
    """The first of some designs that is feasible, if there is one that is found before ``until`` (``clock.now``).

    Limits that are asked last cost too much to ask them of all: they are asked of one design, then of twice as
    many, and so on. Where a design is found to cross itself, all others that do so there are left out.
    ``crossings``, what is known of them, is None where no limit is asked last.
    """
    designs = designs.take(feasible(problem.without_last, designs))
    if crossings is None:
        return designs.take([0]) if len(designs) else None
    count = 1
    while len(designs) and now() <= until:
        designs = designs.take(~crossings.shown(designs))
        some, designs = designs.take(slice(0, count)), designs.take(slice(count, None))
        held = np.flatnonzero(feasible(problem, some))
        if held.size:
            return some.take(held[:1])
        if len(some):
            crossings.learn(some.take([0]))
        count = min(2 * count, LAST_AT_ONCE)
    return None


def proved_feasible(problem: Problem, design: Designs, until: float = inf) -> bool:
    """Whether a design is feasible, decided in intervals where doubles do not tell, before the time is over."""
    return all(
        evaluate_rows(own, each, frozenset(), until).column("feasible")[0] for own, each in problem.every(design)
    )


def known_crossings(problem: Problem) -> KnownCrossings | None:
    """A memory for cams that cross themselves, still empty; None if crossing is allowed."""
    return KnownCrossings(problem.setup, problem.programme) if problem.has_last else None


def first_that(designs: Designs, holds: Callable[[Designs], bool]) -> Designs | None:
    """The first design that meets a costly condition, by bisection, assuming that all after it meet it too."""
    found, low, high = None, 0, len(designs) - 1
    middle = 0
    while low <= high:
        one = designs.take([middle])
        if holds(one):
            found, high = one, middle - 1
        else:
            low = middle + 1
        middle = (low + high) // 2
    return found
