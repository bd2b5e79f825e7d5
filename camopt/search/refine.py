"""Refinement: each row of a front moved off the grid, to an optimum of the continuous problem.

A row keeps its choices (laws, sizes from a list) and moves in the ranges of ``[search]``: the size of the cam falls
as far as the limits allow while no other objective becomes worse. Where a closed form gives that design it is
proved to be the smallest; elsewhere it is a local optimum. The ends of the front are added: the smallest cam of
each programme, which is that of ``optimise``, and the best of each other objective. Where the design decides one
objective beside the size, the front of a programme is a curve, and even levels of that objective fill it.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from camopt.effects import EFFECTS
from camopt.judging import judged
from camopt.mechanisms import Designs, chained
from camopt.mechanisms.design import Bounds
from camopt.numerics import FloatArray
from camopt.quantities import QUANTITIES
from camopt.question import Question, exactly
from camopt.rows import Rows, joined
from camopt.search.answer import Progress
from camopt.search.clock import now
from camopt.search.optimise import SECONDS, share
from camopt.search.pareto import non_dominated, signs, thinned
from camopt.search.polish import PatternSearch, by_search, polished
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
    question, names, search = exactly(space.question), frozenset(grid.columns), space.question.scene.search
    free = free_sizes(question)
    decided = [name for name in decided_objectives(question) if name != question.size_name or "size" in free]
    if not free or not decided or not grid.count:
        return _marked(grid, False)
    sized = "size" in free and question.size_name in search.minimise
    objective = question.size_name if sized else decided[0]
    cams = _smallest_cams(space, names) if sized else ()
    start = non_dominated(joined([grid, *cams]), search)
    groups = list(space.designs_of(start))
    parts, done, total = [], 0, start.count + LEVELS * len(groups)

    def at_optima(problem: PatternSearch, designs: Designs, ceilings: FloatArray) -> Iterator[Designs]:
        nonlocal done
        for first in range(0, max(len(designs), 1), BLOCK):
            block = slice(first, first + BLOCK)
            yield polished(problem, designs.take(block), ceilings[block])
            done = min(done + BLOCK, total)
            if progress:
                progress(done, total)

    for each, index, designs in groups:
        problem = PatternSearch(exactly(each), free, objective)
        _, held = problem.costs(designs)
        parts.append(_marked(start.take(index[~held]), False))  # so near a limit that only balls decide
        designs = chained([designs.take(held), *_ends(problem, designs.take(held), decided)])
        designs = chained(at_optima(problem, designs, problem.costs(designs)[0]))
        designs = chained([designs, *at_optima(problem, *_levels(problem, designs, decided))])
        parts.append(_marked(_rows(problem.question, designs, names), True))
    return thinned(non_dominated(joined(parts), search), search, SAME)


def free_sizes(question: Question) -> Bounds:
    """The sizes that a front moves in: those that ``[search]`` gives a range, and the cam's own if it varies."""
    search = question.scene.search
    free = {name: ends for name, ends in boxes_of(question)[0].items() if ends[1] > ends[0]}
    if search.base_radius is None and search.mean_radius is None:
        free.pop("size", None)
    return free


def decided_objectives(question: Question) -> list[str]:
    """The objectives that depend on the design, not on the motion alone."""
    effects = {name: EFFECTS[QUANTITIES[name].effect] for name in signs(question.scene.search)}
    return [name for name, effect in effects.items() if not effect.of_motion(question.subject)]


def _smallest_cams(space: Space, names: frozenset[str]) -> Iterator[Rows]:
    """The smallest cam of each motion, as ``optimise`` finds it in its time."""
    end, questions = now() + SECONDS, [exactly(question) for question in space.questions]
    for done, question in enumerate(questions):
        until, boxes = share(end, len(questions) - done), boxes_of(question)
        answers = [smallest(question, box, share(until, len(boxes) - k)).design for k, box in enumerate(boxes)]
        cams = [design for design in answers if design is not None]
        if cams:
            yield _rows(question, min(cams, key=lambda design: float(design.size[0])), names)


def _ends(problem: PatternSearch, designs: Designs, decided: list[str]) -> Iterator[Designs]:
    """The best design of each objective, whatever it costs in the others, found from the best of some designs.

    The smallest cam needs no search.
    """
    costs, _ = problem.costs(designs)
    for name in decided if len(designs) else ():
        if name != problem.question.size_name or not problem.of_size:
            best = designs.take([int(np.argmin(costs[:, problem.column(name)]))])
            alone = replace(problem, objective=name)
            yield by_search(alone, best, np.full((1, costs.shape[1]), np.inf))


def _levels(problem: PatternSearch, designs: Designs, decided: list[str]) -> tuple[Designs, FloatArray]:
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


def _rows(question: Question, designs: Designs, names: frozenset[str]) -> Rows:
    """The feasible ones of some designs, as rows."""
    rows = judged(question, designs, names).only(names)
    return rows.take(rows.column("feasible").astype(bool))


def _marked(rows: Rows, refined: bool) -> Rows:
    return Rows({**rows.columns, "refined": np.full(rows.count, refined)}, rows.count)
