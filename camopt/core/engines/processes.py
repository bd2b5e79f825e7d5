"""Processes of this machine, by loky, for work that is mostly Python.

Each process holds one end of a pipe to its parent. When the parent is gone for any reason, the pipe closes and the
process ends at once.
"""

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing import Pipe
from threading import Thread
from time import process_time
from typing import Any

from loky import ProcessPoolExecutor
from loky.backend import resource_tracker

from camopt.core.engines import Item, WorkResult
from camopt.core.engines.interrupts import hold_interrupts

ITEM_TRIES = 2  # tries of an item by itself, after its process died
THREAD_SETTINGS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""Environment variables that limit the threads of libraries, because the processes share the cores."""


class Processes:
    """Processes that each work on one item at a time.

    They start once the items left are expected to take ``start_seconds`` in this process, which works on the items
    before. A process needs more than a second to import camopt.
    """

    def __init__(self, workers: int, start_seconds: float = 0.0) -> None:
        self.workers, self.start_seconds = workers, start_seconds
        self._items_here, self._seconds_here = 0, 0.0
        self._alive_receiver, self._alive_sender = Pipe(duplex=False)  # closed when this process ends
        self._executor = self._make_process_pool()

    def results_in_order(
        self, work: Callable[[Sequence[Item]], WorkResult], items: Sequence[Item], sample: Sequence[Item] = ()
    ) -> Iterator[WorkResult]:
        """Yield the result of each item; see ``Engine``.

        Raises
        ------
        OSError
            If an item kills every process that works on it.
        """
        # this process works on the last item, and on a few that take little time
        while items and (
            min(self.workers, len(items)) <= 1
            or len(items) * self._seconds_here / max(self._items_here, 1) < self.start_seconds
        ):
            start = process_time()
            result = work((items[0],))
            self._items_here, self._seconds_here = self._items_here + 1, self._seconds_here + process_time() - start
            yield result
            items = items[1:]
        futures = [self._submit(work, item) for item in items]
        for number, item in enumerate(items):
            try:
                result = futures[number].result()
            except BrokenProcessPool:
                result = self._run_item_in_new_processes(work, item)
                later = zip(futures[number + 1 :], items[number + 1 :], strict=True)
                futures[number + 1 :] = [
                    future
                    if future.done() and not isinstance(future.exception(), BrokenProcessPool)
                    else self._submit(work, other)
                    for future, other in later
                ]
            yield result

    def kill_processes(self) -> None:
        """End all processes at once, even during an item."""
        self._executor.shutdown(kill_workers=True)
        self._alive_sender.close()
        self._alive_receiver.close()

    def _submit(self, work: Callable[[Sequence[Item]], WorkResult], item: Item) -> "Future[WorkResult]":
        """Start an item, in new processes if there are none."""
        resource_tracker.ensure_running()  # its start would release interrupts
        with hold_interrupts():  # the processes inherit this
            submitted: Future[WorkResult] = self._executor.submit(work, (item,))
        return submitted

    def _run_item_in_new_processes(self, work: Callable[[Sequence[Item]], WorkResult], item: Item) -> WorkResult:
        """Run one item in new processes, where no other item can kill them."""
        for _ in range(ITEM_TRIES):
            self._replace_process_pool()
            with suppress(BrokenProcessPool):
                return self._submit(work, item).result()
        self._replace_process_pool()
        raise OSError(f"a process was killed from outside {ITEM_TRIES} times; perhaps the memory is too small")

    def _replace_process_pool(self) -> None:
        self._executor.shutdown(kill_workers=True)
        self._executor = self._make_process_pool()

    def _make_process_pool(self) -> ProcessPoolExecutor:
        """Make the pool; its processes start with the first item."""
        threads = str(max(1, (os.cpu_count() or 1) // self.workers))
        environment = {name: threads for name in THREAD_SETTINGS if name not in os.environ}
        return ProcessPoolExecutor(
            self.workers, initializer=exit_after_parent, initargs=(self._alive_receiver,), env=environment
        )


def exit_after_parent(alive_receiver: Any) -> None:
    """End this process when its parent is gone; ignore interrupts and standard output, which are the parent's."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)

    def exit_when_pipe_closes() -> None:
        try:
            alive_receiver.recv()
        finally:
            os._exit(1)

    Thread(target=exit_when_pipe_closes, daemon=True).start()


@contextmanager
def processes(count: int, start_seconds: float = 0.0) -> Iterator[Processes]:
    """Yield an engine of ``count`` processes, which end with the block; see ``Processes``."""
    engine = Processes(count, start_seconds)
    try:
        yield engine
    finally:
        engine.kill_processes()
