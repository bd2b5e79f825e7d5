"""The estimated time and disk space of a sweep, from a few of its blocks."""

import os
import shutil
from errno import ENOSPC
from pathlib import Path
from time import monotonic
from typing import NamedTuple

import numpy as np

from camopt.core.engines import Engine
from camopt.core.engines.threads import Threads
from camopt.solve.front.plan import TABLED_KEEPS, SweepPlan
from camopt.solve.front.store import MessageSink, Store, batch_bytes
from camopt.solve.tables.cells import duration_text

LEAST_BLOCKS = 512  # a sweep of fewer blocks ends too soon to need an estimate
BLOCKS_A_THREAD = 4  # timed blocks per thread
TABLE_AND_BATCHES = 2  # kept rows are both in the table and in batches until the end


class SweepEstimate(NamedTuple):
    """The estimated time and disk space of a sweep."""

    designs: int
    seconds: float
    table_bytes: float
    """Bytes of the rows that are kept."""
    free_bytes: float
    """Free bytes on the disk."""

    @property
    def needed_bytes(self) -> float:
        """Bytes on the disk while the sweep runs."""
        return TABLE_AND_BATCHES * self.table_bytes

    def __str__(self) -> str:
        time = f"{self.designs:,} designs take about {duration_text(self.seconds)}"
        if not self.table_bytes:
            return time
        return (
            f"{time}; they need {bytes_in_words(self.needed_bytes)} of disk during the sweep "
            f"and {bytes_in_words(self.table_bytes)} after it; "
            f"{bytes_in_words(self.free_bytes)} are free"
        )


def estimate_sweep(
    plan: SweepPlan, block_numbers: range, threads: Threads, workers: int, folder: Path
) -> SweepEstimate | None:
    """The estimate for blocks of a sweep by ``workers``, from a few blocks on threads; None for too few blocks.

    The neighbour of each timed block is evaluated first, because it fills the caches of its motion.
    """
    if len(block_numbers) < LEAST_BLOCKS:
        return None
    places = np.linspace(0, len(block_numbers) - 2, BLOCKS_A_THREAD * threads.workers + 2).astype(int)[1:-1]
    neighbours, timed = ([block_numbers[place + step] for place in places.tolist()] for step in (0, 1))
    for _ in threads.results_in_order(plan.evaluate_blocks, neighbours):
        pass
    start = monotonic()
    batches = [*threads.results_in_order(plan.evaluate_blocks, timed)]
    seconds = (monotonic() - start) * threads.workers / workers
    share = len(block_numbers) / len(timed)
    tabled = batches if plan.keep in TABLED_KEEPS else []
    kept = sum(len(batch_bytes(batch, plan.searched_row_quantities)) for batch in tabled)
    designs = plan.blocks.design_count_before_block(block_numbers.stop) - plan.blocks.design_count_before_block(
        block_numbers.start
    )
    return SweepEstimate(designs, share * seconds, share * kept, shutil.disk_usage(folder).free)


def check_disk_room(estimate: SweepEstimate, folder: Path) -> None:
    """Raise an OSError before hours of work if the disk has no room for the sweep."""
    if estimate.needed_bytes > estimate.free_bytes:
        room = (
            f"{bytes_in_words(estimate.needed_bytes)} are needed and {bytes_in_words(estimate.free_bytes)} are free"
        )
        why = f'{os.strerror(ENOSPC)}: about {room}; keep="pareto" keeps the Pareto front alone, in little room'
        raise OSError(ENOSPC, why, os.fspath(folder))


def bytes_in_words(byte_count: float) -> str:
    """A number of bytes in words."""
    power = min(max(len(f"{byte_count:.0f}") - 1, 0) // 3, 4)
    return f"{byte_count / 1000**power:.3g} {('B', 'kB', 'MB', 'GB', 'TB')[power]}"


def announce_estimate(store: Store, threads: Threads, engine: Engine, tell: MessageSink | None) -> None:
    """Tell the time and space that a long sweep will take; an OSError if the disk lacks the room.

    Threads of this process time a few blocks. A sweep that resumes gets no estimate: it had one at its start, and
    part of its room is taken already.
    """
    if not store.block_ranges_and_batch_files():
        estimate = estimate_sweep(store.plan, store.numbers, threads, engine.workers, store.folder)
        if estimate and tell:
            tell(str(estimate))
        if estimate:
            check_disk_room(estimate, store.folder.parents[1])
