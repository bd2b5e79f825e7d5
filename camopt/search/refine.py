"""Refinement: each row of a front moved off the grid, to an optimum of the continuous problem.

A row keeps its choices (laws, sizes from a list) and moves in the ranges of ``[search]``: the size of the cam falls
as far as the limits allow while no other objective becomes worse. Where a closed form gives that design it is
proved to be the smallest; elsewhere it is a local optimum. The ends of the front are added: the smallest cam of
each programme, which is that of ``optimise``, and the best of each other objective.
"""

from collections.abc import Iterator

import numpy as np

from camopt.effects import EFFECTS
from camopt.judging import judged
from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray
from camopt.quantities import QUANTITIES
from camopt.question import Question, exactly
from camopt.rows import Rows, joined
from camopt.search.answer import Bounds, Progress
from camopt.search.pareto import non_dominated, objectives, signs, thinned
from camopt.search.polish import Problem, by_closed_form, by_search
from camopt.search.smallest import smallest
from camopt.search.space import Space, boxes_of

BLOCK = 1024  # designs that move at once
SAME = 1e-9  # of each objective's range: rows nearer than that are one


def refined(space: Space, grid: Rows, progress: Progress | None = None) -> Rows:
    """The front of the continuous problem at the rows of a grid's front, with the column ``refined``.

    ``progress`` is called with (rows done, rows in all).
    """
    question = exactly(space.question)
    free = free_sizes(question)
    objective = lowered_objective(question, free)
    if objective is None or not grid.count:
        return _marked(grid, False)
    names = frozenset(grid.columns)
    parts, done = [], 0
    for programme, index, designs in space.designs_of(grid):
        problem = Problem(question, programme, free, objective)
        ends = list(_ends(problem, designs, objectives(grid, question.scene.search)[index]))
        for first in range(0, index.size, BLOCK):
            block = slice(first, first + BLOCK)
            moved, held = polished(problem, designs.take(block))
            parts.append(_marked(_rows(question, programme, moved.take(held), names), True))
            parts.append(_marked(grid.take(index[block][~held]), False))
            done += moved.size.size
            if progress:
                progress(done, grid.count)
        for end in ends:
            moved, held = polished(problem, end)
            parts.append(_marked(_rows(question, programme, moved.take(held), names), True))
    if objective == question.size_name:
        parts += [_marked(rows, True) for rows in _smallest_cams(space, question, names)]
    front = non_dominated(joined(parts), question.scene.search)
    return thinned(front, question.scene.search, SAME)


def polished(problem: Problem, designs: Designs) -> tuple[Designs, np.ndarray]:
    """Each design at its optimum under its own costs as ceilings; and which designs enclosures alone find feasible.

    One that they do not, so near a limit that only balls decide, stays as it is.
    """
    ceilings, held = problem.costs(designs)
    settled = ~held
    if problem.of_size:
        designs, proved = by_closed_form(problem, designs, ceilings)
        settled |= proved
    left = np.flatnonzero(~settled)
    if left.size:
        designs = designs.replaced(left, by_search(problem, designs.take(left), ceilings[left]))
    return designs, held


def free_sizes(question: Question) -> Bounds:
    """The sizes that a front moves in: those that ``[search]`` gives a range, and the cam's own if it varies."""
    search = question.scene.search
    free = {name: ends for name, ends in boxes_of(question)[0].items() if ends[1] > ends[0]}
    if search.base_radius is None and search.mean_radius is None:
        free.pop("size", None)
    return free


def lowered_objective(question: Question, free: Bounds) -> str | None:
    """The objective that polishing lowers: the cam's size, or else the first that the design decides."""
    names = [name for name in signs(question.scene.search) if not EFFECTS[QUANTITIES[name].effect].of_motion]
    if not free or not names:
        return None
    sized = "size" in free and question.size_name in question.scene.search.minimise
    return question.size_name if sized else names[0]


def _ends(problem: Problem, designs: Designs, costs: FloatArray) -> Iterator[Designs]:
    """The best design of each other objective that the design decides, whatever the rest, from the best row."""
    for column, name in enumerate(signs(problem.question.scene.search)):
        if name == problem.objective or EFFECTS[QUANTITIES[name].effect].of_motion:
            continue
        best = designs.take([int(np.argmin(costs[:, column]))])
        yield by_search(Problem(problem.question, problem.programme, problem.free, name), best, NO_CEILING)


NO_CEILING = np.array([[np.inf]])


def _smallest_cams(space: Space, question: Question, names: frozenset[str]) -> Iterator[Rows]:
    """The smallest cam of each programme, as ``optimise`` finds it."""
    for programme in space.programmes:
        answers = [smallest(question, programme, box).design for box in boxes_of(question)]
        designs = [design for design in answers if design is not None]
        if designs:
            yield _rows(question, programme, min(designs, key=lambda design: float(design.size[0])), names)


def _rows(question: Question, programme: Programme, designs: Designs, names: frozenset[str]) -> Rows:
    """The feasible ones of some designs, as rows."""
    rows = judged(question, programme, designs, names)
    return rows.take(rows.column("feasible").astype(bool)).only(names)


def _marked(rows: Rows, refined: bool) -> Rows:
    return Rows({**rows.columns, "refined": np.full(rows.count, refined)}, rows.count)
