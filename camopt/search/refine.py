"""Refinement: each row of a front moved off the grid, to an optimum of the continuous problem.

A row keeps its choices (laws, sizes from a list) and moves in the ranges of ``[search]``: the size of the cam falls
as far as the limits allow while no other objective becomes worse. Where a closed form gives that design it is
proved to be the smallest; elsewhere it is a local optimum. The ends of the front are added: the smallest cam of
each programme, which is that of ``optimise``, and the best of each other objective. Where the design decides one
objective beside the size, the front of a programme is a curve, and even levels of that objective fill it.
"""

from collections.abc import Iterator

import numpy as np

from camopt.effects import EFFECTS
from camopt.judging import judged
from camopt.mechanisms import Designs, chained
from camopt.numerics import FloatArray
from camopt.quantities import QUANTITIES
from camopt.question import Question, exactly
from camopt.rows import Rows, joined
from camopt.search.answer import Bounds, Progress
from camopt.search.pareto import non_dominated, signs, thinned
from camopt.search.polish import Problem, by_search, polished
from camopt.search.smallest import smallest
from camopt.search.space import Space, boxes_of

BLOCK = 1024  # designs that move at once
LEVELS = 1000  # that fill a curve
SAME = 1e-9  # of each objective's range: rows nearer than that are one


def refined(space: Space, grid: Rows, progress: Progress | None = None) -> Rows:
    """The front of the continuous problem, from the rows of a grid's front, with the column ``refined``.

    No row of the grid's front is better than all of its rows. ``progress`` is called with (designs done, designs
    in all).
    """
    question, names = exactly(space.question), frozenset(grid.columns)
    free, decided = free_sizes(question), decided_objectives(question)
    if not free or not decided or not grid.count:
        return _marked(grid, False)
    objective = question.size_name if "size" in free and question.size_name in decided else decided[0]
    groups = {programme: (index, designs) for programme, index, designs in space.designs_of(grid)}
    nothing = np.array([], dtype=np.int64), question.design.take(slice(0))
    parts, done, total = [], 0, grid.count + LEVELS * len(groups)
    for programme in space.programmes:
        problem = Problem(question, programme, free, objective)
        index, designs = groups.get(programme, nothing)
        ceilings, held = problem.costs(designs)
        parts.append(_marked(grid.take(index[~held]), False))  # so near a limit that only balls decide
        found = [designs.take(slice(0)), *_ends(problem, designs, decided)]
        for block in _blocks(problem, designs.take(held), ceilings[held]):
            found.append(block)
            done += len(block)
            if progress:
                progress(done, total)
        for block in _blocks(problem, *_levels(problem, chained(found), decided)):
            found.append(block)
            done += len(block)
            if progress:
                progress(done, total)
        rows = judged(question, programme, chained(found), names).only(names)
        parts.append(_marked(rows.take(rows.column("feasible").astype(bool)), True))
    front = non_dominated(joined(parts), question.scene.search)
    return thinned(front, question.scene.search, SAME)


def free_sizes(question: Question) -> Bounds:
    """The sizes that a front moves in: those that ``[search]`` gives a range, and the cam's own if it varies."""
    search = question.scene.search
    free = {name: ends for name, ends in boxes_of(question)[0].items() if ends[1] > ends[0]}
    if search.base_radius is None and search.mean_radius is None:
        free.pop("size", None)
    return free


def decided_objectives(question: Question) -> list[str]:
    """The objectives that depend on the design, not on the motion alone."""
    return [name for name in signs(question.scene.search) if not EFFECTS[QUANTITIES[name].effect].of_motion]


def _blocks(problem: Problem, designs: Designs, ceilings: FloatArray) -> Iterator[Designs]:
    """Designs at their optima, a block at a time."""
    for first in range(0, len(designs), BLOCK):
        block = slice(first, first + BLOCK)
        yield polished(problem, designs.take(block), ceilings[block])


def _ends(problem: Problem, designs: Designs, decided: list[str]) -> Iterator[Designs]:
    """The smallest cam of a programme if its size is lowered; and the best of each other objective at its optimum.

    The best is looked for from the best row of the grid, whatever it costs in the others.
    """
    question, programme = problem.question, problem.programme
    if problem.of_size:
        answers = [smallest(question, programme, box).design for box in boxes_of(question)]
        cams = [design for design in answers if design is not None]
        yield from sorted(cams, key=lambda design: float(design.size[0]))[:1]
    if not len(designs):
        return
    costs, _ = problem.costs(designs)
    for name in decided:
        if name != question.size_name or not problem.of_size:
            alone = Problem(question, programme, problem.free, name)
            row = designs.take([int(np.argmin(costs[:, problem.column(name)]))])
            best = by_search(alone, row, np.full((1, costs.shape[1]), np.inf))
            ceilings, held = problem.costs(best)
            yield polished(problem, best.take(held), ceilings[held])


def _levels(problem: Problem, designs: Designs, decided: list[str]) -> tuple[Designs, FloatArray]:
    """Starts and ceilings that fill a curve: even levels of the other objective, each from the design below it."""
    costs, _ = problem.costs(designs)
    others = [problem.column(name) for name in decided if name != problem.objective]
    if len(others) != 1 or len(designs) < 2 or not np.isfinite(costs[:, others]).all():
        return designs.take(slice(0)), costs[:0]
    (other,) = others
    order = np.argsort(costs[:, other], kind="stable")
    known = costs[order, other]
    levels = np.linspace(known[0], known[-1], LEVELS)
    start = order[np.searchsorted(known, levels, side="right") - 1]
    ceilings = costs[start]
    ceilings[:, other] = levels
    return designs.take(start), ceilings


def _marked(rows: Rows, refined: bool) -> Rows:
    return Rows({**rows.columns, "refined": np.full(rows.count, refined)}, rows.count)
