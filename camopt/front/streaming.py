"""Every design of a space through the kernels, block by block: what is seen of them is gathered in their order."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import islice
from typing import NamedTuple, TypeVar

from camopt.front.asked import Asked
from camopt.front.blocks import Batch
from camopt.front.pareto import Archive, best_of_laws
from camopt.problem.rows import Rows, joined
from camopt.problem.space import Space
from camopt.smallest.result import Progress, report_progress
from camopt.verdicts.judging import Effort

NONE = Rows({}, 0)  # where there are no blocks
Item = TypeVar("Item")
Result = TypeVar("Result")


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


def gathered(
    space: Space,
    batches: Iterable[Batch],
    block: int,
    write: Callable[[Rows], None],
    progress: Progress | None = None,
) -> Seen:
    """What batches give together that cover a space in its order. ``write`` takes the rows that they keep.

    ``progress`` is called with (designs done, designs in all). Rows are the same however the space was cut.
    """
    designs, existing, feasible, effort, reached = 0, 0, 0, Effort(), 0.0
    search, total, best = space.problem.scene.search, len(space), NONE
    archive = Archive(search, block)
    for batch in batches:
        designs += batch.designs
        existing += batch.existing
        feasible += batch.feasible
        effort = effort.plus(batch.effort)
        reached = max(reached, batch.reached)
        archive.add(batch.front)
        best = batch.best if best is NONE else best_of_laws(joined([best, batch.best]), search)
        write(batch.kept)
        report_progress(progress, designs, total)
    front = NONE if best is NONE else archive.front()
    return Seen(front, best, effort, reached, designs, existing, feasible)


Engine = Callable[[Asked, range], Iterator[Batch]]
"""What evaluates the blocks of some numbers and gives their batches in order."""


def threads(workers: int) -> Engine:
    """A few threads of this process."""
    return lambda asked, numbers: in_order(asked.blocks.batch, numbers, workers)


def in_order(work: Callable[[Item], Result], items: Iterable[Item], workers: int) -> Iterator[Result]:
    """What work gives for items, in their order, by a few threads that are never far ahead of the reader.

    The first comes from this thread, so that an interrupt ends it while it compiles kernels.
    """
    waiting = iter(items)
    yield from map(work, islice(waiting, 1))
    with ThreadPoolExecutor(workers) as pool:
        running: deque[Future[Result]] = deque()
        try:
            for item in islice(waiting, workers + 1):
                running.append(pool.submit(work, item))
            while running:
                yield running.popleft().result()
                for item in islice(waiting, 1):
                    running.append(pool.submit(work, item))
        finally:
            pool.shutdown(cancel_futures=True)
