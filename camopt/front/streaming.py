"""Every design of a space through the kernels, block by block, on a few threads."""

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import islice
from typing import NamedTuple

import numpy as np

from camopt.front.pareto import Archive, non_dominated, ranked
from camopt.front.shared_curves import CurveNumbers, SharedCurves, curve_numbers
from camopt.problem.rows import Rows, joined
from camopt.problem.space import Block, Space
from camopt.smallest.result import Progress
from camopt.verdicts.judging import Effort, settled
from camopt.verdicts.screening import screened, screened_beyond_pitch

Work = tuple[Block, SharedCurves | None]


class Seen(NamedTuple):
    """What was seen of a space: counts, the front, and rows that hold the best one of each law."""

    front: Rows
    best: Rows
    effort: Effort
    reached: float
    """The largest relative half-width of an enclosure of any row."""
    evaluated: int
    """Designs, those that cannot be assembled among them."""
    existing: int | None = None
    """Designs that can be assembled; None if they were not counted."""
    feasible: int | None = None
    """Designs; None if they were not counted."""
    boxes: int = 0
    """Boxes of designs that were bounded."""
    decided: int = 0
    """Designs in boxes that were dropped."""


@dataclass(frozen=True)
class Batch:
    """What one block gave: rows for the designs file, and rows that may be on the Pareto front."""

    designs: int
    existing: int
    feasible: int
    effort: Effort
    reached: float
    kept: Rows
    front: Rows
    best: Rows
    """Its best feasible row, or none."""


def streamed(
    space: Space,
    names: tuple[str, ...],
    keep: str,
    workers: int,
    block: int,
    progress: Progress | None,
    write: Callable[[Rows], None],
) -> Seen:
    """Evaluate all designs. ``write`` takes rows of each block: all that can be assembled, or are feasible."""
    designs, existing, feasible, effort, reached = 0, 0, 0, Effort(), 0.0
    archive, firsts = Archive(space.problem.scene.search, block), []
    sharing = None if keep == "all" else curve_numbers(space)
    blocks = _blocks(space, frozenset(names), sharing, block)
    for batch in in_order(blocks, partial(_batch, space, frozenset(names), keep), workers):
        designs += batch.designs
        existing += batch.existing
        feasible += batch.feasible
        effort = effort.plus(batch.effort)
        reached = max(reached, batch.reached)
        archive.add(batch.front)
        firsts.append(batch.best)
        write(batch.kept)
        if progress:
            progress(designs, len(space))
    return Seen(archive.front(), joined(firsts), effort, reached, designs, existing, feasible)


def _blocks(space: Space, names: frozenset[str], sharing: CurveNumbers | None, size: int) -> Iterator[Work]:
    """The space in order, each block with the pitch curves of its motion, if designs share them."""
    curves: dict[int, SharedCurves | None] = {}
    for block in space.blocks(size):
        problem, *_ = block
        if id(problem) not in curves:
            curves = {id(problem): None if sharing is None else SharedCurves(space, problem, sharing, names)}
        yield block, curves[id(problem)]


def _batch(space: Space, names: frozenset[str], keep: str, work: Work) -> Batch:
    """Evaluate one block of a space."""
    (problem, first, last), curves = work
    if curves:
        existing, candidates = curves.candidates(first, last)
        evaluated, _, effort = screened_beyond_pitch(candidates, names)
    else:
        designs = space.designs(np.arange(first, last))
        designs = designs.take(problem.setup.mechanism.exists(designs, problem.programme))
        existing = len(designs)
        if keep == "all":
            evaluated, effort = settled(problem, designs, names)
        else:
            evaluated, _, effort = screened(problem, designs, names)
    feasible = evaluated.take(evaluated.column("feasible").astype(bool))
    front = non_dominated(feasible, problem.scene.search)
    best = ranked(front, problem.scene.search).take(np.arange(min(front.count, 1)))
    reached = float(np.max(evaluated.columns["relative_half_width"], initial=0.0))
    return Batch(last - first, existing, feasible.count, effort, reached, evaluated, front, best)


def in_order(blocks: Iterator[Work], work: Callable[[Work], Batch], workers: int) -> Iterator[Batch]:
    """Batches in the order of the space from a few threads, never far ahead of the reader.

    The first comes from this thread, so that an interrupt ends it while it compiles kernels.
    """
    yield from map(work, islice(blocks, 1))
    with ThreadPoolExecutor(workers) as pool:
        running: deque[Future[Batch]] = deque()
        try:
            for item in islice(blocks, workers + 1):
                running.append(pool.submit(work, item))
            while running:
                yield running.popleft().result()
                for item in islice(blocks, 1):
                    running.append(pool.submit(work, item))
        finally:
            pool.shutdown(cancel_futures=True)
