"""The smallest cam: the least size that holds every limit, proved.

Closed forms and cutting planes come first: the smallest cam under the limits that are linear. If it holds the
others too, it is the answer. Otherwise curvature or a load decides, and feasibility need not be monotone in the
size: a branch-and-bound over boxes of designs, from there on. What is left when it ends is the least feasible
size to within ``gap_of``. Limits that are asked last come last here too: no cam that holds them is smaller than the
smallest one that holds all others, and most often that one does.
"""

from math import inf

from camopt.mechanisms import Designs
from camopt.mechanisms.design import SizeBounds
from camopt.numerics.clock import share
from camopt.problem.problem import Problem, exactly
from camopt.smallest.branch_and_bound import branch_and_bound
from camopt.smallest.closed_form import NUDGES, closed_form, least_size, nudged
from camopt.smallest.cutting_planes import Cut, by_cutting_planes
from camopt.smallest.first_look import first_look, largest_size
from camopt.smallest.grid_refinement import CLOSE, NEAR, shrink_on_grids
from camopt.smallest.result import Smallest, feasible


def smallest(problem: Problem, bounds: SizeBounds, until: float = inf) -> Smallest:
    """The design of least size within bounds that holds every limit of the problem.

    After ``until`` (``clock.now``) the best so far, not proved. Half of the time is kept for limits that come last.
    """
    problem, bounds = exactly(problem), _worth_a_look(problem, bounds)
    answer = _smallest(problem.without_last, bounds, share(until, 2) if problem.has_last else until)
    if answer.design is None or not problem.has_last or feasible(problem, answer.design)[0]:
        return answer
    return branch_and_bound(problem, bounds, min(answer.floor, answer.size), until)


def small(
    problem: Problem, bounds: SizeBounds, near: Designs | None = None, until: float = inf, *, closely: bool = False
) -> Smallest:
    """As ``smallest``, but what the linear limits do not decide is a small design without proof, found much sooner.

    Looked for near a given design, if there is one that can be moved to be feasible.
    """
    problem, bounds = exactly(problem), _worth_a_look(problem, bounds)
    found = _by_linear_limits(problem, bounds, until)
    if found.design is not None or found.floor == inf:
        return Smallest(found.design, found.floor)
    bounds = {**bounds, "size": (found.floor, bounds["size"][1])}
    zooms = CLOSE if closely else NEAR
    design = None if near is None else shrink_on_grids(problem, bounds, near, zooms, until)
    if design is None:
        look = first_look(problem, bounds, until=until)
        if look.design is None:
            return Smallest(None, inf if look.hopeless else found.floor, look.nearest)
        design = shrink_on_grids(problem, bounds, look.design, zooms, until)
    return Smallest(design, found.floor)


def _smallest(problem: Problem, bounds: SizeBounds, until: float) -> Smallest:
    found = _by_linear_limits(problem, bounds, until)
    if found.design is not None:
        return Smallest(found.design, found.floor)
    return branch_and_bound(problem, bounds, found.floor, until)


def _worth_a_look(problem: Problem, bounds: SizeBounds) -> SizeBounds:
    """The bounds between the least and the largest size that may be feasible; of an empty range one end alone."""
    low, high = bounds["size"]
    most = max(min([high, *(limit.most_size for limit in problem.limits)]), low)
    return {**bounds, "size": (min(least_size(problem, bounds), largest_size(problem, bounds)), most)}


def _by_linear_limits(problem: Problem, bounds: SizeBounds, until: float = inf) -> Cut:
    start = closed_form(problem, bounds)
    if start is None:
        return by_cutting_planes(problem, bounds, until) or Cut(None, bounds["size"][0])
    floor = float(start.size[0]) * (1.0 - NUDGES[-1])
    return Cut(None, inf) if floor > bounds["size"][1] else Cut(nudged(problem, start, bounds), floor)
