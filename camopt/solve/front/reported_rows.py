"""The reported rows of a sweep: the front, the best design of each law with its active limits, the nearest miss."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from typing import NamedTuple

import numpy as np

from camopt.core.engines.progress import Progress
from camopt.core.numerics import IndexArray
from camopt.core.quantities import in_column_order
from camopt.model.effects import quantities_to_compute_by_effect, setup_effects
from camopt.model.mechanisms import Designs
from camopt.scene.problem.problem import Problem, with_rounding_relative_error
from camopt.scene.problem.rows import DesignRows, concatenate_rows, scatter_rows
from camopt.scene.problem.space import EDGE_OF_SPACE, DesignSpace
from camopt.scene.scene import Scene
from camopt.solve.front.blocks import BLOCK_SIZE, SpaceResult
from camopt.solve.front.pareto import best_row_of_each_law, thin_front
from camopt.solve.front.plan import SweepPlan, sweep_columns
from camopt.solve.tables.designs import Design, DesignsByLaw, joined_laws
from camopt.solve.verdicts.limit_verdicts import (
    evaluate_with_verdicts,
    excess_rank,
    index_of_least_excess,
    quantities_with_excess_bounds,
)

MOST_MISS_DESIGNS = 1 << 22  # most designs tried for the nearest miss, so that it takes little of a sweep's time


class ReportedRows(NamedTuple):
    """The rows that users compare, with the digits of ``evaluate``."""

    front: DesignRows
    """The front, refined and thinned as the scene says."""
    grid: DesignRows
    """The front of the grid."""
    best: DesignRows
    """The best design of each pair of laws, the best law first."""
    active_limits: list[str]
    """The limits that the next smaller cam of the space would exceed, for each of the best designs."""


def report_rows(plan: SweepPlan, space_result: SpaceResult, progress: Progress | None) -> ReportedRows:
    """The reported rows of a search."""
    space, search, objectives = plan.space, plan.scene.search, plan.problem.objectives
    rows = space_result.front
    if search.refine:
        from camopt.solve.front.refine import refine_front

        rows = refine_front(space, rows, progress)
    rows = rows if search.thin is None else thin_front(rows, objectives, search.thin)
    best = best_row_of_each_law(space_result.best, objectives)
    index, smaller = row_indices_and_next_smaller_cams(space, best)
    tables = [best, smaller, rows] + ([] if rows is space_result.front else [space_result.front])
    best, smaller, *fronts = with_reevaluated_columns(space, frozenset(plan.table_columns), *tables)
    return ReportedRows(fronts[0], fronts[-1], best, limits_violated_by_smaller_cams(best.count, index, smaller))


def best_design_of_each_law(scene: Scene, reported: ReportedRows) -> dict[str, Design]:
    """The best row of each pair of laws as a design, the best law first."""
    pairs = zip(reported.best.records(), reported.active_limits, strict=True)
    rows = ({**row, "held_by": limits} for row, limits in pairs)
    return DesignsByLaw((joined_laws(row["law_rise"], row["law_return"]), Design(row, scene)) for row in rows)


def with_reevaluated_columns(space: DesignSpace, names: frozenset[str], *tables: DesignRows) -> list[DesignRows]:
    """The tables with the columns that ``evaluate`` computes, so that equal designs have equal rows.

    Columns are in the order of the quantities, wherever the rows come from.
    """
    total = sum(rows.count for rows in tables)
    sizes = concatenate_rows(rows.select_columns(space.problem.size_quantity_names) for rows in tables)
    evaluated = scatter_rows(_reevaluate_by_motion(space, names, sizes), total)
    ends = np.cumsum([rows.count for rows in tables])
    if not evaluated.columns:
        return [*tables]
    results = []
    for rows, last in zip(tables, ends.tolist(), strict=True):
        columns = rows.columns | evaluated.slice_rows(slice(last - rows.count, last)).columns
        results.append(replace(rows, columns={name: columns[name] for name in in_column_order(columns)}))
    return results


def _reevaluate_by_motion(
    space: DesignSpace, names: frozenset[str], sizes: DesignRows
) -> Iterator[tuple[IndexArray, DesignRows]]:
    """The evaluated rows of designs with given sizes, block by block, with their places."""
    for problem, index, designs in space.designs_by_setting(sizes):
        for first in range(0, index.size, BLOCK_SIZE):
            block = slice(first, first + BLOCK_SIZE)
            yield index[block], reevaluate_designs(problem, designs.take(block), names)


def reevaluate_designs(problem: Problem, designs: Designs, names: frozenset[str]) -> DesignRows:
    """The quantities of designs with the digits of ``evaluate``.

    All quantities that ``evaluate`` encloses are enclosed here too, because they change the last digits of others.
    """
    setup = problem.setup
    planned, effects = (
        quantities_to_compute_by_effect(names | problem.evaluated_quantities, setup),
        setup_effects(setup),
    )
    enclosed = (quantities for effect, quantities in planned.items() if not effects[effect].exact)
    return evaluate_with_verdicts(
        with_rounding_relative_error(problem), designs, names.union(*enclosed)
    ).select_columns(names)


def row_indices_and_next_smaller_cams(space: DesignSpace, rows: DesignRows) -> tuple[IndexArray, DesignRows]:
    """The rows that are not at the edge of the space, with the next smaller size of the cam.

    In a sample the next smaller size is one per cent smaller.
    """
    name = space.problem.size_quantity_name
    sizes = [space.next_smaller_size(size) for size in rows.column(name).tolist()]
    inside = np.flatnonzero([size is not None for size in sizes])
    smaller = rows.take(inside)
    return inside, replace(smaller, columns=smaller.columns | {name: np.array([sizes[row] for row in inside])})


def limits_violated_by_smaller_cams(row_count: int, row_indices: IndexArray, smaller_cams: DesignRows) -> list[str]:
    """The active limits of rows: those that the next smaller cam exceeds, if there is such a cam."""
    active = [EDGE_OF_SPACE] * row_count
    for row, names in zip(row_indices, smaller_cams.column("violated"), strict=True):
        active[row] = str(names).replace(",", ", ")
    return active


def nearest_miss_of_space(plan: SweepPlan) -> Design | None:
    """The design with the least excess over its limits, with its quantities; in a large space, of some blocks."""
    space = plan.space
    best: tuple[tuple[float, float], Problem, Designs] | None = None
    step = max(len(space) // MOST_MISS_DESIGNS, 1)
    for problem, first, last in islice(space.blocks(plan.block_size), step // 2, None, step):
        designs = space.designs(np.arange(first, last))
        designs = designs.take(problem.setup.mechanism.can_assemble(designs, problem.programme))
        if not len(designs):
            continue
        excess = quantities_with_excess_bounds(problem, designs, frozenset()).outer
        i = index_of_least_excess(excess)
        key = excess_rank(excess[:, i])
        if best is None or key < best[0]:
            best = key, problem, designs.take([i])
    if best is None:
        return None
    _, problem, design = best
    (row,) = reevaluate_designs(problem, design, frozenset(sweep_columns(problem))).records()
    return Design(row, plan.scene)


def largest_relative_half_width(rows: DesignRows) -> float:
    """The largest relative half-width of an enclosure of any row."""
    return float(np.max(rows.columns.get("relative_half_width", 0.0), initial=0.0))
