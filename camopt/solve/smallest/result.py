"""The smallest cam that a search found, and the tests of feasibility that all searches share."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from math import inf

import numpy as np

from camopt.core.numerics import FloatArray, Number
from camopt.core.numerics.budget import Budget
from camopt.model.effects.self_crossing_boxes import KnownCrossings
from camopt.model.mechanisms.design import SECOND_SIZE, Designs, SizeBounds
from camopt.scene.problem.problem import Problem
from camopt.solve.verdicts.feasible_filter import feasible_designs
from camopt.solve.verdicts.limit_verdicts import DEFERRED_WORK, LAST_DESIGNS_AT_ONCE, evaluate_with_verdicts

RELATIVE_GAP = 1e-9  # of the prime radius: a size is proved if the least feasible one is smaller by no more


def minimised_disc_fields(bounds: SizeBounds) -> tuple[str, ...]:
    """The fields of the sizes whose maximum is minimised: both discs of a pair if both have a range, else one."""
    low, high = bounds.get(SECOND_SIZE, (0.0, 0.0))
    return ("size", SECOND_SIZE) if low < high else ("size",)


def largest_base_radii(designs: Designs, discs: tuple[str, ...]) -> Number:
    """Size of the largest disc of each design [mm]."""
    return reduce(np.maximum, (designs.sizes[disc] for disc in discs))


@dataclass(frozen=True)
class SmallestCam:
    """The smallest design for one programme with its lower bound, or the nearest miss."""

    design: Designs | None
    floor: float
    """Proved lower bound of the size of feasible designs, mm; infinite if there are none."""
    nearest: Designs | None = None
    """If there is no design: the tried one that exceeds its limits the least."""
    discs: tuple[str, ...] = ("size",)
    """The fields of the sizes whose maximum is minimised."""
    second_disc_gap: float = 0.0
    """By how much the smaller disc of a pair may be smaller beside the larger one, mm."""
    every_cam: str = ""
    """The verdict on every cam within the tolerances of the design; empty if the problem is not robust."""

    @property
    def size(self) -> float:
        """Size of the design [mm]; infinite if there is none."""
        return inf if self.design is None else float(largest_base_radii(self.design, self.discs)[0])

    @property
    def gap(self) -> float:
        """By how much a feasible design may be smaller [mm]; 0 if it is proved that none exists."""
        return max(self.second_disc_gap, 0.0 if self.size <= self.floor else float(self.size - self.floor))

    @property
    def is_proved(self) -> bool:
        """Whether it is proved that no feasible design is smaller by more than ``allowed_proof_gap``."""
        return self.gap <= (0.0 if self.design is None else allowed_proof_gap(self.design))

    def with_larger_sizes(self, size_increments: FloatArray) -> Designs:
        """The design with its minimised sizes increased by each of some lengths, mm."""
        assert self.design is not None
        copies = self.design.take(np.zeros(size_increments.size, dtype=int))
        return copies.with_values({disc: copies.sizes[disc] + size_increments for disc in self.discs})


def allowed_proof_gap(design: Designs) -> float:
    """Largest gap between a size and its lower bound at which the design counts as proved the smallest [mm]."""
    return RELATIVE_GAP * float(design.prime_radius[0])


def first_feasible_design(
    problem: Problem, designs: Designs, crossings: KnownCrossings | None, budget: Budget
) -> Designs | None:
    """The first feasible one of some designs, or None if none is found within the budget.

    Deferred limits cost too much to evaluate for all designs. camopt evaluates them for one design, then for twice
    as many, and so on. Once a design crosses itself, all others that cross at the same place are dropped.
    ``crossings`` remembers these places; it is None if no limit is deferred.
    """
    budget.spend(problem.evaluation_work(len(designs)))
    designs = designs.take(feasible_designs(problem.without_deferred_limits, designs))
    if crossings is None:
        return designs.take([0]) if len(designs) else None
    count = 1
    while len(designs) and not budget.is_spent:
        designs = designs.take(~crossings.designs_crossing_at_known_angles(designs))
        block, designs = designs.take(slice(0, count)), designs.take(slice(count, None))
        budget.spend(DEFERRED_WORK * len(block))
        held = np.flatnonzero(feasible_designs(problem, block))
        if held.size:
            return block.take(held[:1])
        if len(block):
            crossings.learn_crossing(block.take([0]))
        count = min(2 * count, LAST_DESIGNS_AT_ONCE)
    return None


def is_provably_feasible(problem: Problem, design: Designs, budget: Budget) -> bool:
    """Whether a design is proved feasible within the budget, by intervals where doubles do not decide."""
    return all(
        evaluate_with_verdicts(own, each, frozenset(), budget).column("feasible")[0]
        for own, each in problem.nominal_and_error_variants(design)
    )


def empty_known_crossings(problem: Problem) -> KnownCrossings | None:
    """An empty memory of places where cams cross themselves; None if no limit is deferred."""
    return KnownCrossings(problem.setup, problem.programme) if problem.has_deferred_limits else None


def bisect_first_design_where(designs: Designs, holds: Callable[[Designs], bool]) -> Designs | None:
    """The first design that meets a costly condition, by bisection; assumes that all after it meet it too."""
    first, low, high = None, 0, len(designs) - 1
    middle = 0
    while low <= high:
        design = designs.take([middle])
        if holds(design):
            first, high = design, middle - 1
        else:
            low = middle + 1
        middle = (low + high) // 2
    return first
