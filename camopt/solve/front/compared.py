"""Rows that people compare: the front, the best of each law with what binds it, and the nearest miss."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from typing import NamedTuple

import numpy as np

from camopt.core.engines.progress import Progress
from camopt.core.numerics import IndexArray
from camopt.core.quantities import in_order
from camopt.model.effects import effects_needed, effects_of
from camopt.model.mechanisms import Designs
from camopt.scene.problem.problem import Problem, exactly
from camopt.scene.problem.rows import Rows, concatenate_rows, scattered
from camopt.scene.problem.space import EDGE_OF_SPACE, Space
from camopt.scene.scene import Scene
from camopt.solve.front.blocks import BLOCK, Seen
from camopt.solve.front.pareto import best_of_laws, thinned
from camopt.solve.front.plan import SweepPlan, column_names
from camopt.solve.tables.designs import ByLaw, Design, joined_laws
from camopt.solve.verdicts.judging import bound_excesses, by_excess, evaluate_rows, least_excess

MOST_LOOKED_AT = 1 << 22  # designs for the nearest miss: to find nothing does not take twice as long


class Compared(NamedTuple):
    """The rows that people compare, with the digits of ``evaluate``."""

    front: Rows
    """As the scene asks for it, refined and thinned."""
    grid: Rows
    """The front of the grid."""
    best: Rows
    """The best design of each pair of laws, the best law first."""
    held: list[str]
    """What the next smaller cam of the space would exceed, of each of these."""


def compared_rows(plan: SweepPlan, found: Seen, progress: Progress | None) -> Compared:
    """What people compare of a search."""
    space, search, objectives = plan.space, plan.scene.search, plan.problem.objectives
    rows = found.front
    if search.refine:
        from camopt.solve.front.refine import refined

        rows = refined(space, rows, progress)
    rows = rows if search.thin is None else thinned(rows, objectives, search.thin)
    best = best_of_laws(found.best, objectives)
    index, smaller = next_smaller_cams(space, best)
    tables = [best, smaller, rows] if rows is found.front else [best, smaller, rows, found.front]
    best, smaller, *fronts = to_compare(space, frozenset(plan.names), *tables)
    return Compared(fronts[0], fronts[-1], best, binding_limits(best.count, index, smaller))


def best_of_each_law(scene: Scene, compared: Compared) -> dict[str, Design]:
    """The best row of each pair of laws as a design, the best law first."""
    told = ({**row, "held_by": by} for row, by in zip(compared.best.records(), compared.held, strict=True))
    return ByLaw((joined_laws(row["law_rise"], row["law_return"]), Design(row, scene)) for row in told)


def to_compare(space: Space, names: frozenset[str], *tables: Rows) -> list[Rows]:
    """Rows that people compare, with columns that ``evaluate`` gives them: equal designs have equal rows.

    Columns are in the order of the quantities, wherever the rows come from.
    """
    total = sum(rows.count for rows in tables)
    sizes = concatenate_rows(rows.only(space.problem.sizes) for rows in tables)
    found, ends = scattered(_evaluated(space, names, sizes), total), np.cumsum([rows.count for rows in tables])
    if not found.columns:
        return [*tables]
    parts = (slice(last - rows.count, last) for rows, last in zip(tables, ends.tolist(), strict=True))
    return [_renewed(rows, found.part(some)) for rows, some in zip(tables, parts, strict=True)]


def _evaluated(space: Space, names: frozenset[str], sizes: Rows) -> Iterator[tuple[IndexArray, Rows]]:
    """The rows of designs of which the sizes are given, some at a time, with their places."""
    for problem, index, designs in space.designs_apart(sizes):
        for first in range(0, index.size, BLOCK):
            some = slice(first, first + BLOCK)
            yield index[some], as_evaluated(problem, designs.take(some), names)


def _renewed(rows: Rows, found: Rows) -> Rows:
    """Rows with the columns that were found, in the order of the quantities."""
    columns = rows.columns | found.columns
    return replace(rows, columns={name: columns[name] for name in in_order(columns)})


def as_evaluated(problem: Problem, designs: Designs, names: frozenset[str]) -> Rows:
    """Quantities of designs as ``evaluate`` gives them: what else it encloses shows in their last digits."""
    setup = problem.setup
    asked, effects = effects_needed(names | problem.wanted, setup), effects_of(setup)
    enclosed = (of_effect for effect, of_effect in asked.items() if not effects[effect].exact)
    return evaluate_rows(exactly(problem), designs, names.union(*enclosed)).only(names)


def next_smaller_cams(space: Space, rows: Rows) -> tuple[IndexArray, Rows]:
    """The rows that are not at the edge of the space, and their designs with the next smaller size of the cam.

    Of a sample, with one that is one per cent smaller.
    """
    name = space.problem.size_name
    sizes = [space.next_smaller(size) for size in rows.column(name).tolist()]
    inside = np.flatnonzero([size is not None for size in sizes])
    smaller = rows.take(inside)
    return inside, replace(smaller, columns=smaller.columns | {name: np.array([sizes[row] for row in inside])})


def binding_limits(count: int, index: IndexArray, smaller: Rows) -> list[str]:
    """The limits that bind rows: those that the next smaller cam exceeds, if there is one."""
    held = [EDGE_OF_SPACE] * count
    for row, names in zip(index, smaller.column("violated"), strict=True):
        held[row] = str(names).replace(",", ", ")
    return held


def nearest_miss_of_space(plan: SweepPlan) -> Design | None:
    """The design of the space that misses its limits the least, with its quantities; of many, of some blocks."""
    space = plan.space
    best: tuple[tuple[float, float], Problem, Designs] | None = None
    step = max(len(space) // MOST_LOOKED_AT, 1)
    for problem, first, last in islice(space.blocks(plan.block), step // 2, None, step):
        designs = space.designs(np.arange(first, last))
        designs = designs.take(problem.setup.mechanism.exists(designs, problem.programme))
        if not len(designs):
            continue
        excess = bound_excesses(problem, designs, frozenset()).outer
        i = least_excess(excess)
        key = by_excess(excess[:, i])
        if best is None or key < best[0]:
            best = key, problem, designs.take([i])
    if best is None:
        return None
    _, problem, design = best
    (row,) = as_evaluated(problem, design, frozenset(column_names(problem))).records()
    return Design(row, plan.scene)


def half_width_of(rows: Rows) -> float:
    """The largest relative half-width of an enclosure of any of some rows."""
    return float(np.max(rows.columns.get("relative_half_width", 0.0), initial=0.0))
