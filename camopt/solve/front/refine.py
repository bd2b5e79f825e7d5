"""Refinement: each row of a front moves off the grid, to an optimum of the continuous problem.

A row keeps its laws and listed values, and moves within the ranges of ``[search]``. The size of the cam falls as
far as the limits allow while no other objective gets worse. If a closed form gives that design, it is proved to be
the smallest; otherwise it is a local optimum.

The ends of the front are added: the smallest cam of each programme, as from ``optimise``, and the best design for
each other objective. If the designs vary one objective besides the size, the front of a programme is a curve, and
even levels of that objective fill it. If they vary more, each row moves for each objective in turn: the rows stay
spread, and their number stays about the same.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from camopt.core.engines.progress import Progress, report_progress
from camopt.core.numerics import FloatArray
from camopt.core.numerics.budget import Budget
from camopt.model.effects import require_effect
from camopt.model.mechanisms.design import Designs, SizeBounds, concatenate_designs
from camopt.scene.problem.problem import Problem, with_rounding_relative_error
from camopt.scene.problem.rows import DesignRows, concatenate_rows
from camopt.scene.problem.space import DesignSpace, search_boxes
from camopt.solve.front.pareto import non_dominated, thin_front
from camopt.solve.front.pattern_search import PatternSearch, polish_designs, search_by_pattern
from camopt.solve.smallest.optimise import OPTIMISE_WORK
from camopt.solve.smallest.smallest import solve_smallest_cam
from camopt.solve.verdicts.limit_verdicts import evaluate_with_verdicts

MOVED_AT_ONCE = 1024  # designs that move together
CURVE_LEVELS = 1000  # even levels that fill a curve
EQUAL_ROWS = 1e-9  # relative to each objective's range: nearer rows count as one


def refine_front(space: DesignSpace, grid: DesignRows, progress: Progress | None) -> DesignRows:
    """The front of the continuous problem, from the rows of a grid's front, with the column ``refined``.

    No row of the grid's front dominates a row of it. ``progress`` is called with (designs done, designs in all).
    """
    problem, names = with_rounding_relative_error(space.problem), frozenset(grid.columns)
    free = free_ranges(problem)
    decided = [
        name
        for name in objectives_of_free_variables(problem)
        if name != problem.size_quantity_name or "size" in free
    ]
    if not free or not decided or not grid.count:
        return _with_refined_column(grid, False)
    sized = "size" in free and problem.objectives.get(problem.size_quantity_name, 0.0) > 0.0
    objective = problem.size_quantity_name if sized else decided[0]
    cams = _feasible_smallest_cams_by_motion(space, names) if sized else ()
    start = non_dominated(concatenate_rows([grid, *cams]), problem.objectives)
    groups = list(space.designs_of_rows(start))
    parts, done, total = [], 0, start.count + CURVE_LEVELS * len(groups)

    def polish_in_blocks(pattern: PatternSearch, designs: Designs, cost_ceilings: FloatArray) -> Iterator[Designs]:
        nonlocal done
        for first in range(0, max(len(designs), 1), MOVED_AT_ONCE):
            block = slice(first, first + MOVED_AT_ONCE)
            yield polish_designs(pattern, designs.take(block), cost_ceilings[block])
            done = min(done + MOVED_AT_ONCE, total)
            report_progress(progress, done, total)

    for group_problem, index, designs in groups:
        pattern = PatternSearch(with_rounding_relative_error(group_problem), free, objective)
        _, held = pattern.worst_costs_and_feasibility(designs)
        # rows so near a limit that only intervals decide stay as they are
        parts.append(_with_refined_column(start.take(index[~held]), False))
        designs = concatenate_designs(
            [designs.take(held), *_best_designs_by_objective(pattern, designs.take(held), decided)]
        )
        ceilings = pattern.worst_costs_and_feasibility(designs)[0]
        designs = concatenate_designs(
            block
            for search in _searches_by_objective(pattern, decided)
            for block in polish_in_blocks(search, designs, ceilings)
        )
        designs = concatenate_designs(
            [designs, *polish_in_blocks(pattern, *_starts_and_ceilings_of_even_levels(pattern, designs, decided))]
        )
        parts.append(_with_refined_column(_feasible_rows(pattern.problem, designs, names), True))
    return thin_front(non_dominated(concatenate_rows(parts), problem.objectives), problem.objectives, EQUAL_ROWS)


def free_ranges(problem: Problem) -> SizeBounds:
    """The ranges in which a front moves: those of ``[search]``, and for the cam's own size also a list."""
    free = {name: ends for name, ends in search_boxes(problem)[0].items() if ends[1] > ends[0]}
    if "size" not in problem.search_space.variables:
        free.pop("size", None)
    return free


def objectives_of_free_variables(problem: Problem) -> list[str]:
    """The objectives that free variables change; others depend on the motion and listed numbers alone."""
    free = [n for n in problem.search_space.numbers if n.key in problem.setup.free and n.is_searched_continuously]
    listed = {number.quantity for number in problem.search_space.numbers if number not in free}
    names = [name for name in problem.objectives if name not in listed]
    return [name for name in names if free or not require_effect(name, problem.setup).is_of_motion(problem.setup)]


def _feasible_smallest_cams_by_motion(space: DesignSpace, names: frozenset[str]) -> Iterator[DesignRows]:
    """The smallest cam of each motion and each choice of listed values, within the work of ``optimise``."""
    end, problems = Budget(OPTIMISE_WORK), [with_rounding_relative_error(problem) for problem in space.problems]
    for done, problem in enumerate(problems):
        until, boxes = end.share(len(problems) - done), search_boxes(problem)
        answers = [
            solve_smallest_cam(problem, box, until.share(len(boxes) - k)).design for k, box in enumerate(boxes)
        ]
        cams = [design for design in answers if design is not None]
        if cams:
            yield _feasible_rows(problem, concatenate_designs(cams), names)


def _searches_by_objective(pattern: PatternSearch, objective_names: list[str]) -> list[PatternSearch]:
    """The searches for each design: for its objective, and with three objectives or more, for each one in turn.

    The front of two objectives is a curve that levels fill. With more, a single objective would move all designs
    to the same corner.
    """
    others = [name for name in objective_names if name != pattern.objective]
    return [pattern, *(replace(pattern, objective=name) for name in others if len(others) > 1)]


def _best_designs_by_objective(
    pattern: PatternSearch, designs: Designs, objective_names: list[str]
) -> Iterator[Designs]:
    """The best design for each objective alone, by a search from the best of some designs.

    The smallest cam is known already, and needs no search.
    """
    costs, _ = pattern.worst_costs_and_feasibility(designs)
    for name in objective_names if len(designs) else ():
        if name != pattern.problem.size_quantity_name or not pattern.minimises_size:
            best = designs.take([int(np.argmin(costs[:, pattern.objective_index(name)]))])
            yield search_by_pattern(replace(pattern, objective=name), best, np.full((1, costs.shape[1]), np.inf))


def _starts_and_ceilings_of_even_levels(
    pattern: PatternSearch, designs: Designs, objective_names: list[str]
) -> tuple[Designs, FloatArray]:
    """Starts and ceilings that fill a curve: even levels of the other objective, each from the design below it."""
    costs, _ = pattern.worst_costs_and_feasibility(designs)
    others = [pattern.objective_index(name) for name in objective_names if name != pattern.objective]
    if len(others) != 1 or len(designs) < 2 or not np.isfinite(costs[:, others]).all():
        return designs.take(slice(0)), costs[:0]
    (other,) = others
    order = np.argsort(costs[:, other], kind="stable")
    sorted_costs = costs[order, other]
    levels = np.linspace(sorted_costs[0], sorted_costs[-1], CURVE_LEVELS)
    start = order[np.searchsorted(sorted_costs, levels, side="right") - 1]
    ceilings = costs[start]
    ceilings[:, other] = levels
    return designs.take(start), ceilings


def _feasible_rows(problem: Problem, designs: Designs, names: frozenset[str]) -> DesignRows:
    rows = evaluate_with_verdicts(problem, designs, names).select_columns(names)
    return rows.take(rows.column("feasible").astype(bool))


def _with_refined_column(rows: DesignRows, refined: bool) -> DesignRows:
    return DesignRows({**rows.columns, "refined": np.full(rows.count, refined)}, rows.count)
