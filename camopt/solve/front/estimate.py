"""An estimate of the time and disk space of a sweep, from a few of its blocks."""

import os
import shutil
from errno import ENOSPC
from pathlib import Path
from typing import NamedTuple

import numpy as np

from camopt.core.engines import Engine
from camopt.core.engines.threads import Threads
from camopt.core.numerics.clock import now
from camopt.solve.front.plan import TABLED, SweepPlan
from camopt.solve.front.store import Store, Tell, batch_bytes
from camopt.solve.tables.cells import duration

LEAST_BLOCKS = 512  # blocks: a sweep of fewer has ended before anyone wonders
BLOCKS_A_THREAD = 4  # blocks of the sample, a thread
TABLE_AND_BATCHES = 2  # what is kept is in both until the end


class Estimate(NamedTuple):
    """The estimated time and disk space of a sweep."""

    designs: int
    seconds: float
    table: float
    """Bytes of what is kept."""
    free: float
    """Bytes that are free on the disk."""

    @property
    def needed(self) -> float:
        """Bytes on the disk while it runs."""
        return TABLE_AND_BATCHES * self.table

    def __str__(self) -> str:
        time = f"{self.designs:,} designs take about {duration(self.seconds)}"
        if not self.table:
            return time
        return (
            f"{time} and {size_in_words(self.needed)} on the disk, of which {size_in_words(self.table)} remain; "
            f"{size_in_words(self.free)} are free"
        )


def estimated(plan: SweepPlan, numbers: range, own: Threads, workers: int, folder: Path) -> Estimate | None:
    """An estimate for blocks of a sweep by some workers, from some of them on a few threads; None for few.

    Neighbours of those that are timed come first: they find what a motion has to be known for.
    """
    if len(numbers) < LEAST_BLOCKS:
        return None
    places = np.linspace(0, len(numbers) - 2, BLOCKS_A_THREAD * own.workers + 2).astype(int)[1:-1]
    before, timed = ([numbers[place + step] for place in places.tolist()] for step in (0, 1))
    for _ in own.in_order(plan.evaluated, before):
        pass
    start = now()
    batches = [*own.in_order(plan.evaluated, timed)]
    seconds = (now() - start) * own.workers / workers
    share = len(numbers) / len(timed)
    tabled = batches if plan.keep in TABLED else []
    kept = sum(len(batch_bytes(batch, plan.row_quantities)) for batch in tabled)
    designs = plan.blocks.designs_before(numbers.stop) - plan.blocks.designs_before(numbers.start)
    return Estimate(designs, share * seconds, share * kept, shutil.disk_usage(folder).free)


def check_room(estimate: Estimate, folder: Path) -> None:
    """Raise an OSError before hours of work if the disk has no room for the sweep."""
    if estimate.needed > estimate.free:
        room = f"{size_in_words(estimate.needed)} are needed and {size_in_words(estimate.free)} are free"
        why = f"{os.strerror(ENOSPC)}: about {room}; to keep the Pareto front alone takes next to nothing"
        raise OSError(ENOSPC, why, os.fspath(folder))


def size_in_words(size: float) -> str:
    """A number of bytes in words."""
    power = min(max(len(f"{size:.0f}") - 1, 0) // 3, 4)
    return f"{size / 1000**power:.3g} {('B', 'kB', 'MB', 'GB', 'TB')[power]}"


def foresee(store: Store, own: Threads, engine: Engine, tell: Tell | None) -> None:
    """Tell what a long sweep will take; an OSError if there is no room for it. Threads of this process time it.

    Where some of it is on disk, it was told already, and the room that it takes is not free any more.
    """
    if not store.files():
        estimate = estimated(store.plan, store.numbers, own, engine.workers, store.folder)
        if estimate and tell:
            tell(str(estimate))
        if estimate:
            check_room(estimate, store.folder.parents[1])
