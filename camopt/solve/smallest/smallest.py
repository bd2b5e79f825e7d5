"""The smallest cam: the least size that holds every limit, proved.

Closed forms and cutting planes come first: the smallest cam under the limits that are linear. If it holds the
others too, it is the answer. Otherwise curvature or a load decides, and feasibility need not be monotone in the
size: a branch-and-bound over boxes of designs, from there on. What is left when it ends is the least feasible size
to within ``allowed_gap``. Limits that are asked last come last here too: no cam that holds them is smaller than the
smallest one that holds all others, and most often that one does.

Of a pair whose discs both have a range the larger one is made least, and then the other beside it. The pair of like
discs comes first: where one of them cannot be smaller by the limits at its own contact, it is the answer.
"""

from dataclasses import replace
from math import inf

from camopt.core.numerics.clock import time_share
from camopt.model.mechanisms.design import SECOND_SIZE, Designs, SizeBounds
from camopt.scene.problem.problem import Problem, at_rounding_error
from camopt.solve.smallest.branch_and_bound import branch_and_bound, floor_of_disc
from camopt.solve.smallest.closed_form import NUDGES, closed_form_design, least_size, nudge_to_feasible
from camopt.solve.smallest.cutting_planes import LinearOptimum, cutting_plane_optimum
from camopt.solve.smallest.grid_search import (
    CLOSE_ZOOMS,
    NEAR_ZOOMS,
    largest_possible_size,
    search_coarse_grid,
    shrink_on_grids,
)
from camopt.solve.smallest.result import SmallestCam, free_discs
from camopt.solve.verdicts.feasible_filter import feasible_designs

EQUAL_DISCS = 1e-6  # relative: discs whose sizes differ by no more are as large as each other
MOST_SHRINKS = 40  # times that grids make an answer smaller


def solve_smallest_cam(problem: Problem, bounds: SizeBounds, until: float = inf) -> SmallestCam:
    """The design of least size within bounds that holds every limit of the problem.

    After ``until`` (``clock.now``) the best so far, not proved. Half of the time is kept for limits that come last.
    """
    problem, bounds = at_rounding_error(problem), _tighten_bounds(problem, bounds)
    answer = _solve_smallest(
        problem.without_deferred_limits, bounds, time_share(until, 2) if problem.has_deferred_limits else until
    )
    if (
        answer.design is not None
        and problem.has_deferred_limits
        and not feasible_designs(problem, answer.design)[0]
    ):
        answer = branch_and_bound(problem, bounds, min(answer.floor, answer.size), until, discs=answer.discs)
    return _shrink_other_disc(problem, bounds, answer, until) if len(answer.discs) > 1 else answer


def solve_small_cam(
    problem: Problem, bounds: SizeBounds, near: Designs | None = None, until: float = inf, *, closely: bool = False
) -> SmallestCam:
    """As ``solve_smallest_cam``, but what the linear limits do not decide is a small design without proof, found
    much sooner.

    Looked for near a given design, if there is one that can be moved to be feasible.
    """
    problem, bounds = at_rounding_error(problem), _tighten_bounds(problem, bounds)
    found = _solve_linear_limits(problem, bounds, until)
    discs = free_discs(bounds)
    if found.design is not None or found.floor == inf:
        return SmallestCam(found.design, found.floor, discs=discs)
    bounds = {**bounds, "size": (found.floor, bounds["size"][1])}
    zooms = CLOSE_ZOOMS if closely else NEAR_ZOOMS
    design = None if near is None else shrink_on_grids(problem, bounds, near, zooms, until)
    if design is None:
        look = search_coarse_grid(problem, bounds, until=until)
        if look.design is None:
            return SmallestCam(None, inf if look.motion_infeasible else found.floor, look.nearest, discs)
        design = shrink_on_grids(problem, bounds, look.design, zooms, until)
    return SmallestCam(design, found.floor, discs=discs)


def _solve_smallest(problem: Problem, bounds: SizeBounds, until: float) -> SmallestCam:
    found = _solve_linear_limits(problem, bounds, until)
    discs = free_discs(bounds)
    if found.design is not None:
        return SmallestCam(found.design, max(found.floor, *(bounds[disc][0] for disc in discs)), discs=discs)
    if len(discs) == 1 or found.floor == inf:
        return _shrink_unproved(
            problem, bounds, branch_and_bound(problem, bounds, found.floor, until, discs=discs), until
        )
    floor, start = found.floor, smallest_equal_pair(problem, bounds, time_share(until, 2))
    for disc in discs:
        if start is None:
            break
        less = start.with_values({disc: start.sizes[disc] * (1.0 - EQUAL_DISCS)})
        if not feasible_designs(problem, less)[0]:  # else it is not this disc that makes the pair so large
            floor = max(floor, floor_of_disc(problem, bounds, start, disc, time_share(until, 2)))
    return branch_and_bound(problem, bounds, floor, until, discs=discs, start=start)


def _shrink_unproved(problem: Problem, bounds: SizeBounds, answer: SmallestCam, until: float) -> SmallestCam:
    """An answer made smaller by grids where some limit is told by no curve: boxes have only tried designs of it."""
    told = all(
        each.constraints or each.mean_constraint or each.decider or each.is_of_motion or each.is_on_base_circle
        for each in problem.limits
    )
    if answer.design is None or answer.is_proved or told:
        return answer
    design = answer.design
    for _ in range(MOST_SHRINKS):  # where two quantities are alike, grids follow their valley slowly
        smaller = shrink_on_grids(problem, bounds, design, CLOSE_ZOOMS, until)
        if smaller is None or smaller.size[0] >= design.size[0]:
            break
        little = smaller.size[0] >= design.size[0] * (1.0 - EQUAL_DISCS)
        design = smaller
        if little:
            break
    return answer if design is answer.design else replace(answer, design=design)


def smallest_equal_pair(problem: Problem, bounds: SizeBounds, until: float) -> Designs | None:
    """The smallest pair whose discs are as large as each other, where both have a range."""
    both = tuple(pick(bounds[name][k] for name in ("size", SECOND_SIZE)) for k, pick in enumerate((max, min)))
    if both[0] > both[1]:
        return None
    others = {name: size for name, size in problem.design.second.items() if name != SECOND_SIZE}
    alike = replace(problem, design=replace(problem.design, second=others))
    kept = {name: ends for name, ends in bounds.items() if name != SECOND_SIZE}
    found = _solve_smallest(alike, {**kept, "size": (both[0], both[1])}, until).design
    return None if found is None else found.with_values({SECOND_SIZE: found.size})


def _shrink_other_disc(problem: Problem, bounds: SizeBounds, answer: SmallestCam, until: float) -> SmallestCam:
    """The smallest pair with the other disc as small as it can be beside the larger one, by its own sizes alone.

    Where both are as large, each is tried.
    """
    if answer.design is None:
        return answer
    sizes = {disc: float(answer.design.sizes[disc][0]) for disc in answer.discs}
    other = [disc for disc, size in sizes.items() if size <= min(sizes.values()) + EQUAL_DISCS * answer.size]
    found = [_shrink_disc(problem, bounds, answer.design, disc, time_share(until, len(other))) for disc in other]
    best = min(found, key=lambda each: each.size)
    return replace(answer, design=best.design, second_disc_gap=best.gap)


def _shrink_disc(problem: Problem, bounds: SizeBounds, design: Designs, disc: str, until: float) -> SmallestCam:
    """The least of one disc of a pair, by those of its sizes that the other has not."""
    own = design.second if disc == SECOND_SIZE else [name.removeprefix("second_") for name in design.second]
    ends = {name: (float(value[0]), float(value[0])) for name, value in design.values.items()}
    ends |= {name: bounds[name] for name in own}
    return branch_and_bound(problem, ends, 0.0, until, discs=(disc,), start=design)


def _tighten_bounds(problem: Problem, bounds: SizeBounds) -> SizeBounds:
    """The bounds between the least and the largest size that may be feasible; of an empty range one end alone."""
    low, high = bounds["size"]
    most = max(min([high, *(limit.most_size for limit in problem.limits)]), low)
    found = {**bounds, "size": (min(least_size(problem, bounds), largest_possible_size(problem, bounds)), most)}
    if len(free_discs(bounds)) > 1:
        low, high = bounds[SECOND_SIZE]
        found[SECOND_SIZE] = min(max(low, *(limit.least_base_radius for limit in problem.limits)), high), high
    return found


def _solve_linear_limits(problem: Problem, bounds: SizeBounds, until: float = inf) -> LinearOptimum:
    start = closed_form_design(problem, bounds)
    if start is None:
        return cutting_plane_optimum(problem, bounds, until) or LinearOptimum(None, bounds["size"][0])
    floor = float(start.size[0]) * (1.0 - NUDGES[-1])
    return (
        LinearOptimum(None, inf)
        if floor > bounds["size"][1]
        else LinearOptimum(nudge_to_feasible(problem, start, bounds), floor)
    )
