"""The answer of the search for the smallest cam, and the tests that it uses."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from math import inf
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.clock import clock_seconds
from camopt.model.effects.self_crossing_boxes import KnownCrossings
from camopt.model.mechanisms.design import SECOND_SIZE, Designs, SizeBounds
from camopt.scene.problem.problem import Problem
from camopt.solve.verdicts.feasible_filter import feasible_designs
from camopt.solve.verdicts.limit_verdicts import LAST_DESIGNS_AT_ONCE, evaluate_rows

RELATIVE_GAP = 1e-9  # of the prime radius: a size is proved if the least feasible one is smaller by no more


def free_discs(bounds: SizeBounds) -> tuple[str, ...]:
    """The sizes, by field of designs, the largest of which is to be least: of a pair both, if both have a range."""
    low, high = bounds.get(SECOND_SIZE, (0.0, 0.0))
    return ("size", SECOND_SIZE) if low < high else ("size",)


def largest_disc_sizes(designs: Designs, discs: tuple[str, ...]) -> Any:
    """The largest of some sizes of each design."""
    return reduce(np.maximum, (designs.sizes[disc] for disc in discs))


@dataclass(frozen=True)
class SmallestCam:
    """The answer for one programme: the design, or why there is none."""

    design: Designs | None
    floor: float
    """A size that no feasible design of these bounds undercuts, mm; infinite if there is none."""
    nearest: Designs | None = None
    """Without a design: the one of those looked at that exceeds its limits the least."""
    discs: tuple[str, ...] = ("size",)
    """The sizes, by field, the largest of which is least."""
    second_disc_gap: float = 0.0
    """By how much the smaller disc of a pair may be smaller beside the larger one, mm."""
    every_cam: str = ""
    """Whether every cam within the tolerances holds the limits with the design, if they have to."""

    @property
    def size(self) -> float:
        """The size of the design; infinite if there is none."""
        return inf if self.design is None else float(largest_disc_sizes(self.design, self.discs)[0])

    @property
    def gap(self) -> float:
        """By how much a feasible design of these bounds may be smaller, mm; 0 where none exists at all."""
        return max(self.second_disc_gap, 0.0 if self.size <= self.floor else float(self.size - self.floor))

    @property
    def is_proved(self) -> bool:
        """Whether no feasible design of these bounds is smaller by more than ``allowed_gap``."""
        return self.gap <= (0.0 if self.design is None else allowed_gap(self.design))

    def with_larger_sizes(self, by: FloatArray) -> Designs:
        """The design with the sizes that are made least larger by some lengths, mm."""
        assert self.design is not None
        moved = self.design.take(np.zeros(by.size, dtype=int))
        return moved.with_values({disc: moved.sizes[disc] + by for disc in self.discs})


def allowed_gap(design: Designs) -> float:
    """How much smaller than a proved design the least feasible one may be, mm."""
    return RELATIVE_GAP * float(design.prime_radius[0])


def first_feasible_design(
    problem: Problem, designs: Designs, crossings: KnownCrossings | None, until: float = inf
) -> Designs | None:
    """The first of some designs that is feasible, if there is one that is found before ``until`` (``clock.now``).

    Limits that are asked last cost too much to ask them of all: they are asked of one design, then of twice as
    many, and so on. Where a design is found to cross itself, all others that do so there are left out.
    ``crossings``, what is known of them, is None where no limit is asked last.
    """
    designs = designs.take(feasible_designs(problem.without_deferred_limits, designs))
    if crossings is None:
        return designs.take([0]) if len(designs) else None
    count = 1
    while len(designs) and clock_seconds() <= until:
        designs = designs.take(~crossings.cross_at_known(designs))
        some, designs = designs.take(slice(0, count)), designs.take(slice(count, None))
        held = np.flatnonzero(feasible_designs(problem, some))
        if held.size:
            return some.take(held[:1])
        if len(some):
            crossings.learn_crossing(some.take([0]))
        count = min(2 * count, LAST_DESIGNS_AT_ONCE)
    return None


def is_provably_feasible(problem: Problem, design: Designs, until: float = inf) -> bool:
    """Whether a design is feasible, decided in intervals where doubles do not tell, before the time is over."""
    return all(
        evaluate_rows(own, each, frozenset(), until).column("feasible")[0]
        for own, each in problem.all_variants(design)
    )


def crossing_memory(problem: Problem) -> KnownCrossings | None:
    """A memory for cams that cross themselves, still empty; None if crossing is allowed."""
    return KnownCrossings(problem.setup, problem.programme) if problem.has_deferred_limits else None


def first_design_where(designs: Designs, holds: Callable[[Designs], bool]) -> Designs | None:
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
