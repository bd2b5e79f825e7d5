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
from camopt.problem.rows import Rows, joined
from camopt.problem.space import Block, Space
from camopt.smallest.result import Progress
from camopt.verdicts.judging import Effort, screened, settled


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
    for batch in in_order(space, partial(_batch, space, names, keep), workers, block):
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


def _batch(space: Space, names: tuple[str, ...], keep: str, block: Block) -> Batch:
    """Evaluate one block of a space."""
    problem, first, last = block
    designs = space.designs(np.arange(first, last))
    designs = designs.take(problem.setup.mechanism.exists(designs, problem.programme))
    if keep == "all":
        evaluated, effort = settled(problem, designs, frozenset(names))
    else:
        evaluated, _, effort = screened(problem, designs, frozenset(names))
    feasible = evaluated.take(evaluated.column("feasible").astype(bool))
    front = non_dominated(feasible, problem.scene.search)
    best = ranked(front, problem.scene.search).take(np.arange(min(front.count, 1)))
    reached = float(np.max(evaluated.columns["relative_half_width"], initial=0.0))
    return Batch(last - first, len(designs), feasible.count, effort, reached, evaluated, front, best)


def in_order(space: Space, work: Callable[[Block], Batch], workers: int, block: int) -> Iterator[Batch]:
    """Batches in the order of the space from a few threads, never far ahead of the reader.

    The first comes from this thread, so that an interrupt ends it while it compiles kernels.
    """
    blocks = space.blocks(block)
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
