"""The smallest cam of one law and one train: the least size that meets every limit, with its proof.

1. Closed forms or cutting planes give the smallest cam under the limits that are linear. If this cam meets the
   other limits too, it is the answer.
2. Otherwise curvature or a load decides, and feasibility need not be monotone in the size. Branch and bound over
   boxes of designs starts from that size, and ends at the least feasible size to within ``allowed_proof_gap``.
3. Deferred limits, which are costly, come last. No cam that meets them is smaller than the smallest cam that meets
   all others, and most often that cam meets them too.

If both discs of a pair have a range, camopt minimises the larger disc, then the smaller one beside it. It first
tries the pair of equal discs. This pair is the answer if the limits at one disc's own contact keep that disc from
being smaller.
"""

from dataclasses import replace
from math import inf

from camopt.core.numerics.budget import UNLIMITED, Budget
from camopt.model.mechanisms.design import SECOND_SIZE, Designs, SizeBounds
from camopt.scene.problem.problem import Problem, with_rounding_relative_error
from camopt.solve.smallest.branch_and_bound import branch_and_bound, disc_size_lower_bound
from camopt.solve.smallest.closed_form import NUDGES, closed_form_design, nudge_to_feasible, size_lower_bound
from camopt.solve.smallest.cutting_planes import LINEAR_WORK, LinearOptimum, cutting_plane_optimum
from camopt.solve.smallest.grid_search import (
    CLOSE_ZOOMS,
    GRID_VALUES,
    NEAR_ZOOMS,
    largest_possible_size,
    search_coarse_grid,
    shrink_on_grids,
)
from camopt.solve.smallest.result import SmallestCam, minimised_disc_fields
from camopt.solve.verdicts.feasible_filter import feasible_designs

EQUAL_DISCS = 1e-6  # relative: discs whose sizes differ by no more count as equal
MOST_SHRINKS = 40  # rounds of grids that make an answer smaller


def solve_smallest_cam(problem: Problem, bounds: SizeBounds, budget: Budget = UNLIMITED) -> SmallestCam:
    """The smallest design within bounds that meets every limit of the problem.

    Once the budget is spent, it is the best so far, not proved. Deferred limits get half of the budget.
    """
    problem, bounds = with_rounding_relative_error(problem), _tighten_size_range(problem, bounds)
    answer = _solve_without_deferred_limits(
        problem.without_deferred_limits,
        bounds,
        budget.share(2) if problem.has_deferred_limits else budget,
    )
    if (
        answer.design is not None
        and problem.has_deferred_limits
        and not feasible_designs(problem, answer.design)[0]
    ):
        answer = branch_and_bound(problem, bounds, min(answer.floor, answer.size), budget, discs=answer.discs)
    return _shrink_smaller_disc(problem, bounds, answer, budget) if len(answer.discs) > 1 else answer


def solve_small_cam_unproved(
    problem: Problem,
    bounds: SizeBounds,
    nearby_design: Designs | None = None,
    budget: Budget = UNLIMITED,
    *,
    with_fine_grids: bool = False,
) -> SmallestCam:
    """A small design within bounds that meets every limit: much sooner than ``solve_smallest_cam``, without proof.

    If the linear limits alone decide, it is the smallest one. Otherwise grids search near ``nearby_design``, if
    there is one and it can be made feasible, else around the best design of a coarse grid.
    """
    problem, bounds = with_rounding_relative_error(problem), _tighten_size_range(problem, bounds)
    linear = _solve_linear_limits(problem, bounds, budget)
    discs = minimised_disc_fields(bounds)
    if linear.design is not None or linear.floor == inf:
        return SmallestCam(linear.design, linear.floor, discs=discs)
    bounds = {**bounds, "size": (linear.floor, bounds["size"][1])}
    zooms = CLOSE_ZOOMS if with_fine_grids else NEAR_ZOOMS
    design = None if nearby_design is None else shrink_on_grids(problem, bounds, nearby_design, zooms, budget)
    if design is None:
        grid_optimum = search_coarse_grid(problem, bounds, GRID_VALUES, budget)
        if grid_optimum.design is None:
            return SmallestCam(
                None, inf if grid_optimum.motion_infeasible else linear.floor, grid_optimum.nearest, discs
            )
        design = shrink_on_grids(problem, bounds, grid_optimum.design, zooms, budget)
    return SmallestCam(design, linear.floor, discs=discs)


def _solve_without_deferred_limits(problem: Problem, bounds: SizeBounds, budget: Budget) -> SmallestCam:
    linear = _solve_linear_limits(problem, bounds, budget)
    discs = minimised_disc_fields(bounds)
    if linear.design is not None:
        return SmallestCam(linear.design, max(linear.floor, *(bounds[disc][0] for disc in discs)), discs=discs)
    if len(discs) == 1 or linear.floor == inf:
        return _shrink_unproved_on_grids(
            problem, bounds, branch_and_bound(problem, bounds, linear.floor, budget, discs=discs), budget
        )
    floor, start = linear.floor, smallest_pair_of_equal_discs(problem, bounds, budget.share(2))
    for disc in discs:
        if start is None:
            break
        smaller = start.with_values({disc: start.sizes[disc] * (1.0 - EQUAL_DISCS)})
        if not feasible_designs(problem, smaller)[0]:  # else this disc is not the one that makes the pair so large
            floor = max(floor, disc_size_lower_bound(problem, bounds, start, disc, budget.share(2)))
    return branch_and_bound(problem, bounds, floor, budget, discs=discs, start=start)


def _shrink_unproved_on_grids(
    problem: Problem, bounds: SizeBounds, answer: SmallestCam, budget: Budget
) -> SmallestCam:
    """The answer made smaller by grids, if some limit has no formula that boxes can enclose."""
    enclosed = all(
        each.constraints
        or each.mean_constraint
        or each.single_design_decider
        or each.is_decided_by_motion_alone
        or each.is_on_base_circle
        for each in problem.limits
    )
    if answer.design is None or answer.is_proved or enclosed:
        return answer
    design = answer.design
    for _ in range(MOST_SHRINKS):  # grids follow a narrow valley slowly
        smaller = shrink_on_grids(problem, bounds, design, CLOSE_ZOOMS, budget)
        if smaller is None or smaller.size[0] >= design.size[0]:
            break
        is_converged = smaller.size[0] >= design.size[0] * (1.0 - EQUAL_DISCS)
        design = smaller
        if is_converged:
            break
    return answer if design is answer.design else replace(answer, design=design)


def smallest_pair_of_equal_discs(problem: Problem, bounds: SizeBounds, budget: Budget) -> Designs | None:
    """The smallest pair with equal discs; None if there is none, or if the two ranges do not overlap."""
    low, high = (pick(bounds[name][k] for name in ("size", SECOND_SIZE)) for k, pick in enumerate((max, min)))
    if low > high:
        return None
    others = {name: size for name, size in problem.design.second.items() if name != SECOND_SIZE}
    equal = replace(problem, design=replace(problem.design, second=others))
    kept = {name: ends for name, ends in bounds.items() if name != SECOND_SIZE}
    design = _solve_without_deferred_limits(equal, {**kept, "size": (low, high)}, budget).design
    return None if design is None else design.with_values({SECOND_SIZE: design.size})


def _shrink_smaller_disc(problem: Problem, bounds: SizeBounds, answer: SmallestCam, budget: Budget) -> SmallestCam:
    """The smallest pair, with the smaller disc minimised beside the larger one by its own sizes alone.

    If the discs are equal, each is tried.
    """
    start = answer.design
    if start is None:
        return answer
    sizes = {disc: float(start.sizes[disc][0]) for disc in answer.discs}
    smaller = [disc for disc, size in sizes.items() if size <= min(sizes.values()) + EQUAL_DISCS * answer.size]
    pairs = []
    for done, disc in enumerate(smaller):
        own = start.second if disc == SECOND_SIZE else [name.removeprefix("second_") for name in start.second]
        ends = {name: (float(value[0]), float(value[0])) for name, value in start.values.items()}
        ends |= {name: bounds[name] for name in own}
        end = budget.share(len(smaller) - done)
        pairs.append(branch_and_bound(problem, ends, 0.0, end, discs=(disc,), start=start))
    best = min(pairs, key=lambda pair: pair.size)
    return replace(answer, design=best.design, second_disc_gap=best.gap)


def _tighten_size_range(problem: Problem, bounds: SizeBounds) -> SizeBounds:
    """The bounds cut to the least and largest size that may be feasible; an empty range becomes one of its ends."""
    low, high = bounds["size"]
    most = max(min([high, *(limit.most_size for limit in problem.limits)]), low)
    tight = {
        **bounds,
        "size": (min(size_lower_bound(problem, bounds), largest_possible_size(problem, bounds)), most),
    }
    if len(minimised_disc_fields(bounds)) > 1:
        low, high = bounds[SECOND_SIZE]
        tight[SECOND_SIZE] = min(max(low, *(limit.least_base_radius for limit in problem.limits)), high), high
    return tight


def _solve_linear_limits(problem: Problem, bounds: SizeBounds, budget: Budget) -> LinearOptimum:
    budget.spend(LINEAR_WORK * problem.evaluation_work(1))
    start = closed_form_design(problem, bounds)
    if start is None:
        return cutting_plane_optimum(problem, bounds, budget) or LinearOptimum(None, bounds["size"][0])
    floor = float(start.size[0]) * (1.0 - NUDGES[-1])
    return (
        LinearOptimum(None, inf)
        if floor > bounds["size"][1]
        else LinearOptimum(nudge_to_feasible(problem, start, bounds), floor)
    )
