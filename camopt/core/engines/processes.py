"""Processes of this machine, by loky: for work that is mostly Python.

A process ends at once when its end of a pipe says that the process that started it is gone, however that came to
pass.
"""

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing import Pipe
from threading import Thread
from typing import Any

from loky import ProcessPoolExecutor
from loky.backend import resource_tracker

from camopt.core.engines import Item, WorkResult
from camopt.core.engines.interrupts import hold_interrupts

ITEM_TRIES = 2  # for an item alone, each of which ends with a dead process
THREAD_SETTINGS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""Environment variables by which a library limits its threads; processes share the cores."""


class Processes:
    """Processes that each work on one item at a time."""

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._ears, self._mouth = Pipe(duplex=False)  # the other end says that this process lives
        self._executor = self._start()

    def in_order(
        self, work: Callable[[Sequence[Item]], WorkResult], items: Sequence[Item], sample: Sequence[Item] = ()
    ) -> Iterator[WorkResult]:
        """The result of each item, as ``Engine`` says; this process works itself on one item, or as one worker.

        Raises
        ------
        OSError
            If an item ends every process that works on it.
        """
        if min(self.workers, len(items)) <= 1:
            yield from (work((item,)) for item in items)
            return
        futures = [self._submit(work, item) for item in items]
        for number, item in enumerate(items):
            try:
                result = futures[number].result()
            except BrokenProcessPool:
                result = self._result_alone(work, item)
                rest = zip(futures[number + 1 :], items[number + 1 :], strict=True)
                futures[number + 1 :] = [
                    future if has_result(future) else self._submit(work, other) for future, other in rest
                ]
            yield result

    def end(self) -> None:
        """End all processes at once, even in the middle of an item."""
        self._executor.shutdown(kill_workers=True)
        self._mouth.close()
        self._ears.close()

    def _submit(self, work: Callable[[Sequence[Item]], WorkResult], item: Item) -> "Future[WorkResult]":
        """Begin with an item, in new processes if there are none."""
        resource_tracker.ensure_running()  # its start lets interrupts in again
        with hold_interrupts():  # processes inherit this
            submitted: Future[WorkResult] = self._executor.submit(work, (item,))
        return submitted

    def _result_alone(self, work: Callable[[Sequence[Item]], WorkResult], item: Item) -> WorkResult:
        """The result of an item in new processes, where nothing else can end them."""
        for _ in range(ITEM_TRIES):
            self._restart()
            with suppress(BrokenProcessPool):
                return self._submit(work, item).result()
        self._restart()
        raise OSError(f"a process was ended from outside, for want of memory perhaps, {ITEM_TRIES} times")

    def _restart(self) -> None:
        self._executor.shutdown(kill_workers=True)
        self._executor = self._start()

    def _start(self) -> ProcessPoolExecutor:
        """Processes, which begin with the first item."""
        threads = str(max(1, (os.cpu_count() or 1) // self.workers))
        environment = {name: threads for name in THREAD_SETTINGS if name not in os.environ}
        return ProcessPoolExecutor(
            self.workers, initializer=exit_after_parent, initargs=(self._ears,), env=environment
        )


def has_result(future: "Future[Any]") -> bool:
    """Whether an item is done: its process did not die of it or beside it."""
    return future.done() and not isinstance(future.exception(), BrokenProcessPool)


def exit_after_parent(ears: Any) -> None:
    """Have this process end when its parent is gone. Interrupts and standard output are the parent's alone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)

    def wait() -> None:
        try:
            ears.recv()
        finally:
            os._exit(1)

    Thread(target=wait, daemon=True).start()


@contextmanager
def processes(count: int) -> Iterator[Processes]:
    """An engine of ``count`` processes, which end with the block."""
    engine = Processes(count)
    try:
        yield engine
    finally:
        engine.end()
