"""The least feasible size over a box of designs, by branch and bound on many boxes at once.

The search covers every size up to the end of the range, or up to the largest size that camopt accepts. It drops a
box in two cases only. Either interval arithmetic on the formulas of the limits proves that the box holds no
feasible design, or a feasible design is known that is as small. When the search stops, the boxes that remain bound
how much smaller a cam may be.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from camopt.core.numerics import Number
from camopt.core.numerics.budget import UNLIMITED, Budget
from camopt.core.numerics.interval import Interval
from camopt.model.effects.self_crossing_boxes import KnownCrossings
from camopt.model.mechanisms.design import SECOND_SIZE, Designs, SizeBounds
from camopt.scene.problem.constraints import AnyConstraint
from camopt.scene.problem.problem import Problem
from camopt.solve.smallest.boxes import Bisection, DesignBoxes
from camopt.solve.smallest.closed_form import NUDGES, negligible_size
from camopt.solve.smallest.enclosure import (
    BoxState,
    ProblemConstraint,
    assemblable_design_of_each_box,
    enclose_limits,
    middle_designs_at_size_share,
    size_constraints_with_error_variants,
    size_dependent_mean_constraints,
)
from camopt.solve.smallest.excesses import Excesses, choose_cut_side, feasible_box_ends_and_empty_boxes
from camopt.solve.smallest.grid_search import (
    FEW_GRID_VALUES,
    GRID_VALUES,
    GridOptimum,
    coarse_grid,
    largest_possible_size,
    search_coarse_grid,
    size_scale,
)
from camopt.solve.smallest.result import (
    SmallestCam,
    allowed_proof_gap,
    bisect_first_design_where,
    empty_known_crossings,
    first_feasible_design,
    is_provably_feasible,
    largest_base_radii,
)
from camopt.solve.verdicts.feasible_filter import feasible_designs

BOX_BATCH = 512  # boxes examined together, at most, so that the search can stop
UNKNOWN_SIDE = -1  # the side to cut is not known yet


def branch_and_bound(
    problem: Problem,
    bounds: SizeBounds,
    floor: float = 0.0,
    budget: Budget = UNLIMITED,
    *,
    discs: tuple[str, ...] = ("size",),
    start: Designs | None = None,
) -> SmallestCam:
    """The smallest feasible design of a box.

    ``floor`` is a proved lower bound of the size, infinite if no design is feasible. Once the
    budget is spent, the answer is the best so far, not proved. ``discs`` are the fields of the sizes whose maximum
    is minimised. ``start`` is a feasible design, if one is known.
    """
    grid_optimum = (
        GridOptimum(start)
        if start
        else search_coarse_grid(problem, bounds, GRID_VALUES if floor < inf else FEW_GRID_VALUES, budget)
    )
    least = max(negligible_size(problem, bounds), floor if len(discs) == 1 else 0.0)
    most = (
        largest_possible_size(problem, bounds)
        if grid_optimum.design is None
        else float(largest_base_radii(grid_optimum.design, discs)[0])
    )
    if grid_optimum.design is None and not grid_optimum.motion_infeasible:
        most = _largest_assemblable_size(problem, bounds, most)
    ends = {disc: (max(bounds[disc][0], least), min(bounds[disc][1], most)) for disc in discs}
    if grid_optimum.design is not None and most <= floor + allowed_proof_gap(grid_optimum.design):
        return SmallestCam(grid_optimum.design, floor, grid_optimum.nearest, discs)
    if grid_optimum.motion_infeasible or most <= floor or max(most - low for low, _ in ends.values()) <= 0.0:
        return SmallestCam(grid_optimum.design, inf, grid_optimum.nearest, discs)
    boxes = DesignBoxes.single_box(
        {**bounds, **ends}, size_scale(problem, bounds), problem.search_space.variables, discs
    )
    search = BoxSearch(
        problem,
        [*size_constraints_with_error_variants(problem), *size_dependent_mean_constraints(problem)],
        empty_known_crossings(problem),
        grid_optimum.design,
        budget,
        discs,
    )
    bound = search.size_bound_by_bisection(boxes)
    return SmallestCam(search.incumbent, max(bound, floor), grid_optimum.nearest, discs)


@dataclass
class BoxSearch(Bisection):
    """Branch and bound over sizes, and over numbers of the cam that are free like sizes."""

    most_boxes = 1_000_000

    problem: Problem
    constraints: Sequence[ProblemConstraint[AnyConstraint]]
    crossings: KnownCrossings | None
    """Places where cams cross themselves, which prove boxes empty; None if crossing is not a limit."""
    incumbent: Designs | None
    """The smallest feasible design so far."""
    budget: Budget = UNLIMITED
    discs: tuple[str, ...] = ("size",)
    """The fields of the sizes whose maximum is minimised."""

    def design_sizes(self, designs: Designs) -> Number:
        """Size of each design [mm]."""
        return largest_base_radii(designs, self.discs)

    def select_batch(self, boxes: DesignBoxes) -> tuple[DesignBoxes, DesignBoxes]:
        """The boxes to examine next, and the rest: first the smallest, or without an incumbent the widest."""
        if len(boxes) <= BOX_BATCH:
            return boxes, boxes.take(slice(0, 0))
        low, high = boxes.least_sizes, boxes.largest_sizes
        order = np.argsort(low if self.incumbent is not None else low / high, kind="stable")
        return boxes.take(order[:BOX_BATCH]), boxes.take(order[BOX_BATCH:])

    def contract_boxes_and_improve_incumbent(self, boxes: DesignBoxes) -> DesignBoxes:
        """The boxes that may hold a smaller cam and can be cut, made narrower, with the side to cut."""
        boxes = self.cut_self_crossing_parts(boxes)
        self.improve_incumbent(boxes.take(boxes.side == UNKNOWN_SIDE))
        if self.incumbent is not None:
            least = self.design_sizes(self.incumbent)[0]
            boxes = self.drop_finished_and_lower_floor(
                boxes, boxes.least_sizes >= least - allowed_proof_gap(self.incumbent)
            ).cap_sizes(least)
        if not len(boxes):
            return boxes
        designs = boxes.as_interval_designs(self.problem.design)
        state = enclose_limits(self.problem, self.constraints, designs, list(boxes.free), self.discs)
        unknown = boxes.side == UNKNOWN_SIDE
        side = np.where(unknown, state.side, boxes.side)
        undecidable = self.boxes_undecided_by_rounding(state, state.within_rounding & unknown & ~state.empty)
        boxes, kept = boxes.with_ends_and_cut_side(state.low, state.high, side), ~state.empty
        return self.drop_finished_and_lower_floor(boxes.take(kept), (boxes.too_narrow_to_cut | undecidable)[kept])

    def boxes_undecided_by_rounding(self, state: BoxState, within_rounding: Any) -> Any:
        """The boxes ``within_rounding`` in which neither doubles nor intervals prove a design feasible.

        In these boxes a limit equals its bound to rounding, as a constant load may. Cutting them decides nothing.
        """
        problem, undecided = self.problem.without_deferred_limits, within_rounding
        index = np.flatnonzero(undecided)
        undecided[index[feasible_designs(problem, state.inside.take(index))]] = False
        inside = state.inside.take(undecided)
        inside = inside.take(np.argsort(self.design_sizes(inside), kind="stable"))
        first = bisect_first_design_where(
            inside,
            lambda design: not self.budget.is_spent and is_provably_feasible(problem, design, self.budget),
        )
        if first is None:
            return undecided
        if not self.problem.has_deferred_limits or is_provably_feasible(self.problem, first, self.budget):
            self.incumbent = first
        return undecided & (self.design_sizes(state.inside) < self.design_sizes(first))

    def cut_self_crossing_parts(self, boxes: DesignBoxes) -> DesignBoxes:
        """The boxes without parts in which every cam is proved to cross itself, with the side to cut.

        This comes before any design of a box is evaluated, which costs far more. The side stays unknown if the
        representative design of a box does not cross itself at a known place.
        """
        side = np.full(len(boxes), UNKNOWN_SIDE)
        if self.crossings is None or "size" not in boxes.free:
            return replace(boxes, side=side)
        designs, free = boxes.as_interval_designs(self.problem.design), boxes.free
        possible = ~self.problem.setup.mechanism.cannot_assemble(designs, self.problem.programme)
        inside, exists = assemblable_design_of_each_box(self.problem, designs, list(free), possible)
        low, high = (np.array([ends[n] for n in free]) for ends in (boxes.low, boxes.high))
        empty, index = np.zeros(len(boxes), dtype=bool), np.flatnonzero(exists)
        if index.size:
            point = np.array([inside.values[n][index] for n in free])
            span = Interval(low[:, index] - point, high[:, index] - point)
            with np.errstate(all="ignore"):
                over = Excesses.from_sloped_value(
                    self.crossings.crossing_excess(designs.take(index), inside.take(index), free)
                )
                side[index] = np.where(over.at[0] > 0.0, choose_cut_side(over, span), UNKNOWN_SIDE)
                low[:, index], high[:, index], empty[index] = feasible_box_ends_and_empty_boxes(
                    over, low[:, index], high[:, index], point
                )
        new_low, new_high = (dict(zip(free, end, strict=True)) for end in (low, high))
        boxes = replace(boxes, low={**boxes.low, **new_low}, high={**boxes.high, **new_high}, side=side)
        return boxes.take(~empty)

    def improve_incumbent(self, boxes: DesignBoxes) -> None:
        """Try the middle of each box at its least, middle and largest size; keep the smallest feasible design."""
        low, high = boxes.low, boxes.high
        for share in (0.0, 0.5, 1.0):
            points = middle_designs_at_size_share(self.problem, low, high, share, self.discs)
            if share == 0.0:  # the curvature of the base circle may decide to within rounding
                nudge = NUDGES[-1] * points.prime_radius
                points = points.with_values({d: np.minimum(points.sizes[d] + nudge, high[d]) for d in self.discs})
            points = points.take(
                self.design_sizes(points) < (inf if self.incumbent is None else self.design_sizes(self.incumbent))
            )
            points = points.take(np.argsort(self.design_sizes(points), kind="stable"))
            self.incumbent = (
                first_feasible_design(self.problem, points, self.crossings, self.budget) or self.incumbent
            )


class DiscSearch(BoxSearch):
    """Branch and bound for a lower bound of one disc of a pair, from the limits at its contact alone.

    The bound is at most the size of the incumbent.
    """

    most_boxes = 20_000

    def improve_incumbent(self, boxes: DesignBoxes) -> None:
        """Does nothing: a feasible design needs the other limits too."""

    def boxes_undecided_by_rounding(self, state: BoxState, within_rounding: Any) -> Any:
        return np.zeros_like(within_rounding)


def disc_size_lower_bound(problem: Problem, bounds: SizeBounds, pair: Designs, disc: str, budget: Budget) -> float:
    """Lower bound of one disc of a pair, whatever the other disc is [mm]; at most its size in ``pair``."""
    second = disc == SECOND_SIZE
    others = pair.second if not second else [name.removeprefix("second_") for name in pair.second]
    ends = bounds | {name: (float(pair.sizes[name][0]),) * 2 for name in others}
    ends[disc] = max(bounds[disc][0], negligible_size(problem, bounds)), float(pair.sizes[disc][0])
    if ends[disc][0] >= ends[disc][1]:
        return ends[disc][0]
    constraints = size_constraints_with_error_variants(
        problem, lambda limit: limit.constraints_at_contact(int(second))
    )
    search = DiscSearch(problem, constraints, None, pair, budget, (disc,))
    return search.size_bound_by_bisection(
        DesignBoxes.single_box(ends, size_scale(problem, bounds), problem.search_space.variables, (disc,))
    )


def _largest_assemblable_size(problem: Problem, bounds: SizeBounds, largest_size: float) -> float:
    """Largest size at which some design of a coarse grid of the other sizes can be assembled [mm], to 1e-12.

    A box across that border would hold a dead position, where tan β takes every value.
    """

    def can_assemble(designs: Designs) -> Any:
        return problem.setup.mechanism.can_assemble(designs, problem.programme)

    grid = coarse_grid(problem, bounds, GRID_VALUES)
    grid = grid.take(can_assemble(grid))
    if not len(grid) or np.any(can_assemble(replace(grid, size=np.full(len(grid), largest_size)))):
        return largest_size
    low, high = grid.size, np.full(len(grid), largest_size)
    while np.any(high - low > 1e-13 * high):
        middle = (low + high) / 2
        exists = can_assemble(replace(grid, size=middle))
        low, high = np.where(exists, middle, low), np.where(exists, high, middle)
    return float(np.max(low)) * (1.0 - 1e-12)
