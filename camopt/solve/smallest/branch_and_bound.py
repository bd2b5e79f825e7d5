"""The least feasible size over a box of designs, by bisection of boxes, many at once.

Every size that camopt takes is covered, up to the given end or to the largest of all. A box is dropped only if its
limits' own formulas, in interval arithmetic, show that it holds no feasible design, or if a feasible one is known
that is as small. What is left when the search is stopped bounds how much smaller a cam may be.

Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 11.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from camopt.core.numerics.clock import clock_seconds
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
    constraints_on_size,
    designs_in_boxes,
    enclose_limits,
    mean_constraints_on_size,
    representative_designs,
)
from camopt.solve.smallest.excesses import Excesses, cut_boxes, widest_side
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
    allowed_gap,
    crossing_memory,
    first_design_where,
    first_feasible_design,
    is_provably_feasible,
    largest_disc_sizes,
)
from camopt.solve.verdicts.feasible_filter import feasible_designs

BOX_BATCH = 512  # boxes examined together, at most, to stop in time
UNKNOWN_SIDE = -1  # which side to cut


def branch_and_bound(
    problem: Problem,
    bounds: SizeBounds,
    floor: float = 0.0,
    until: float = inf,
    *,
    discs: tuple[str, ...] = ("size",),
    start: Designs | None = None,
) -> SmallestCam:
    """Least feasible size over a box of designs.

    ``floor`` is a size that no feasible design is known to undercut; infinite if there is none. After ``until``
    (``clock.now``) the best so far is the answer, not proved. ``discs`` are the sizes, by field, the largest of
    which is meant, and ``start`` a feasible design, if one is known.
    """
    look = (
        GridOptimum(start)
        if start
        else search_coarse_grid(problem, bounds, GRID_VALUES if floor < inf else FEW_GRID_VALUES, until)
    )
    none = max(negligible_size(problem, bounds), floor if len(discs) == 1 else 0.0)
    most = (
        largest_possible_size(problem, bounds)
        if look.design is None
        else float(largest_disc_sizes(look.design, discs)[0])
    )
    if look.design is None and not look.motion_infeasible:
        most = _largest_assembled_size(problem, bounds, most)
    ends = {disc: (max(bounds[disc][0], none), min(bounds[disc][1], most)) for disc in discs}
    if look.design is not None and most <= floor + allowed_gap(look.design):
        return SmallestCam(look.design, floor, look.nearest, discs)
    if look.motion_infeasible or most <= floor or max(most - low for low, _ in ends.values()) <= 0.0:
        return SmallestCam(look.design, inf, look.nearest, discs)
    boxes = DesignBoxes.single_box(
        {**bounds, **ends}, size_scale(problem, bounds), problem.search_space.variables, discs
    )
    crossings = crossing_memory(problem)
    constraints: list[ProblemConstraint[AnyConstraint]] = [
        *constraints_on_size(problem),
        *mean_constraints_on_size(problem),
    ]
    search = BoxSearch(problem, constraints, crossings, look.design, until, discs)
    found = search.bisect(boxes, until)
    return SmallestCam(search.incumbent, max(found, floor), look.nearest, discs)


@dataclass
class BoxSearch(Bisection):
    """A search over sizes, and numbers that are free as they are."""

    most_boxes = 1_000_000

    problem: Problem
    constraints: Sequence[ProblemConstraint[AnyConstraint]]
    crossings: KnownCrossings | None
    """What shows that cams of a box cross themselves, if that is a limit."""
    incumbent: Designs | None
    """The smallest feasible design so far."""
    until: float = inf
    """When to stop (``clock.now``)."""
    discs: tuple[str, ...] = ("size",)
    """The sizes, by field, the largest of which is least."""

    def sizes_of(self, designs: Designs) -> Any:
        """The size of designs."""
        return largest_disc_sizes(designs, self.discs)

    def select_batch(self, boxes: DesignBoxes) -> tuple[DesignBoxes, DesignBoxes]:
        """The boxes to look at next, and the rest: the smallest cams, or the widest while none is feasible."""
        if len(boxes) <= BOX_BATCH:
            return boxes, boxes.take(slice(0, 0))
        low, high = boxes.least_sizes, boxes.largest_sizes
        order = np.argsort(low if self.incumbent is not None else low / high, kind="stable")
        return boxes.take(order[:BOX_BATCH]), boxes.take(order[BOX_BATCH:])

    def contract_boxes(self, boxes: DesignBoxes) -> DesignBoxes:
        """Those of some boxes that may hold a smaller cam and can be cut, with the side to cut."""
        boxes = self.without_crossings(boxes)
        self.improve_incumbent(boxes.take(boxes.side == UNKNOWN_SIDE))
        if self.incumbent is not None:
            least = self.sizes_of(self.incumbent)[0]
            boxes = self.drop_finished(boxes, boxes.least_sizes >= least - allowed_gap(self.incumbent)).cap_sizes(
                least
            )
        if not len(boxes):
            return boxes
        designs = boxes.as_designs(self.problem.design)
        seen = enclose_limits(self.problem, self.constraints, designs, list(boxes.free), self.discs)
        unseen = boxes.side == UNKNOWN_SIDE
        side = np.where(unseen, seen.side, boxes.side)
        settled = self.undecidable_boxes(seen, seen.within_rounding & unseen & ~seen.empty)
        boxes, kept = boxes.with_ends(seen.low, seen.high, side), ~seen.empty
        return self.drop_finished(boxes.take(kept), (boxes.is_narrow | settled)[kept])

    def undecidable_boxes(self, seen: BoxState, alike: Any) -> Any:
        """Of boxes whose designs hold all limits but for rounding, those where none does surely, nor in intervals.

        To cut such boxes tells no more: the bound is what a load is, or comes to.
        """
        problem = self.problem.without_deferred_limits
        index = np.flatnonzero(alike)
        alike[index[feasible_designs(problem, seen.inside.take(index))]] = False
        inside = seen.inside.take(alike)
        inside = inside.take(np.argsort(self.sizes_of(inside), kind="stable"))
        first = first_design_where(
            inside, lambda one: clock_seconds() < self.until and is_provably_feasible(problem, one, self.until)
        )
        if first is None:
            return alike
        if not self.problem.has_deferred_limits or is_provably_feasible(self.problem, first, self.until):
            self.incumbent = first
        return alike & (self.sizes_of(seen.inside) < self.sizes_of(first))

    def without_crossings(self, boxes: DesignBoxes) -> DesignBoxes:
        """The parts of boxes that are not shown to hold only cams that cross themselves, with the side to cut.

        Asked before any design of a box is looked at, which costs far more. Nothing tells which side to cut where
        the one design looked at is not seen to cross itself.
        """
        side = np.full(len(boxes), UNKNOWN_SIDE)
        if self.crossings is None or "size" not in boxes.free:
            return replace(boxes, side=side)
        designs, free = boxes.as_designs(self.problem.design), boxes.free
        possible = ~self.problem.setup.mechanism.cannot_assemble(designs, self.problem.programme)
        inside, exists = representative_designs(self.problem, designs, list(free), possible)
        low, high = (np.array([ends[n] for n in free]) for ends in (boxes.low, boxes.high))
        empty, index = np.zeros(len(boxes), dtype=bool), np.flatnonzero(exists)
        if index.size:
            point = np.array([inside.values[n][index] for n in free])
            span = Interval(low[:, index] - point, high[:, index] - point)
            with np.errstate(all="ignore"):
                over = Excesses.from_sloped_value(
                    self.crossings.excess(designs.take(index), inside.take(index), free)
                )
                side[index] = np.where(over.at[0] > 0.0, widest_side(over, span), UNKNOWN_SIDE)
                low[:, index], high[:, index], empty[index] = cut_boxes(over, low[:, index], high[:, index], point)
        left_low, left_high = (dict(zip(free, end, strict=True)) for end in (low, high))
        boxes = replace(boxes, low={**boxes.low, **left_low}, high={**boxes.high, **left_high}, side=side)
        return boxes.take(~empty)

    def improve_incumbent(self, boxes: DesignBoxes) -> None:
        """Make the least feasible of the middles of boxes, also at their least and largest size, the incumbent."""
        low, high = boxes.low, boxes.high
        for share in (0.0, 0.5, 1.0):
            points = designs_in_boxes(self.problem, low, high, share, self.discs)
            if share == 0.0:  # where the curvature of the base circle decides, but for rounding
                nudge = NUDGES[-1] * points.prime_radius
                points = points.with_values({d: np.minimum(points.sizes[d] + nudge, high[d]) for d in self.discs})
            points = points.take(
                self.sizes_of(points) < (inf if self.incumbent is None else self.sizes_of(self.incumbent))
            )
            points = points.take(np.argsort(self.sizes_of(points), kind="stable"))
            found = first_feasible_design(self.problem, points, self.crossings, self.until)
            self.incumbent = found or self.incumbent


class DiscSearch(BoxSearch):
    """A search for a size that one disc of a pair cannot be below, from the limits at its contact alone.

    It ends at the size of the incumbent, or where there is a smaller disc that these limits allow.
    """

    most_boxes = 20_000

    def improve_incumbent(self, boxes: DesignBoxes) -> None:
        """Nothing: other limits are not looked at."""

    def undecidable_boxes(self, seen: BoxState, alike: Any) -> Any:
        return np.zeros_like(alike)


def floor_of_disc(problem: Problem, bounds: SizeBounds, pair: Designs, disc: str, until: float = inf) -> float:
    """A size that one disc of a pair cannot be below, whatever the other is; up to that of a given pair."""
    second = disc == SECOND_SIZE
    others = pair.second if not second else [name.removeprefix("second_") for name in pair.second]
    ends = bounds | {name: (float(pair.sizes[name][0]),) * 2 for name in others}
    ends[disc] = max(bounds[disc][0], negligible_size(problem, bounds)), float(pair.sizes[disc][0])
    if ends[disc][0] >= ends[disc][1]:
        return ends[disc][0]
    constraints = constraints_on_size(problem, lambda limit: limit.constraints_at_contact(int(second)))
    search = DiscSearch(problem, constraints, None, pair, until, (disc,))
    return search.bisect(
        DesignBoxes.single_box(ends, size_scale(problem, bounds), problem.search_space.variables, (disc,)), until
    )


def _largest_assembled_size(problem: Problem, bounds: SizeBounds, most: float) -> float:
    """The largest size, to 1e-12, at which some design of a coarse grid of the other sizes can be assembled.

    A box across that border would hold a dead position, where tan β takes every value.
    """

    def exists(designs: Designs) -> Any:
        return problem.setup.mechanism.can_assemble(designs, problem.programme)

    grid = coarse_grid(problem, bounds, problem.programme.lift, GRID_VALUES)
    grid = grid.take(exists(grid))
    if not len(grid) or np.any(exists(replace(grid, size=np.full(len(grid), most)))):
        return most
    low, high = grid.size, np.full(len(grid), most)
    while np.any(high - low > 1e-13 * high):
        middle = (low + high) / 2
        held = exists(replace(grid, size=middle))
        low, high = np.where(held, middle, low), np.where(held, high, middle)
    return float(np.max(low)) * (1.0 - 1e-12)
