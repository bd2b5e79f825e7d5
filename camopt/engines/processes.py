"""Processes of this machine: for work that is mostly Python.

Each reads its work from a pipe. It ends when that is closed, as it is when the process that holds its other end is
gone, however that came to pass: none outlives the process that started it.
"""

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from subprocess import PIPE, Popen
from threading import Lock, local
from typing import Any

from camopt.engines import Item, Result

ITEM_TRIES = 2  # for an item, each of which ends with a dead process
ALONE = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""What tells libraries how many threads they may have: those of a process share its part of the machine."""
APART: dict[str, Any] = (
    {"start_new_session": True}
    if os.name == "posix"
    else {"creationflags": getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)}
)
"""Of a process: an interrupt from a terminal is for the one that started it."""
PROGRAM = """
import pickle, sys
sys.path[:] = pickle.load(sys.stdin.buffer)
from camopt.engines.process_worker import work
work()
"""


class Processes:
    """Processes that each work on one item at a time. A thread waits for each."""

    def __init__(self, workers: int) -> None:
        self.workers, self._own, self._lock = workers, local(), Lock()
        self._threads, self._started, self._ended = ThreadPoolExecutor(workers), list[Popen[bytes]](), False

    def in_order(
        self, work: Callable[[Sequence[Item]], Result], items: Sequence[Item], sample: Sequence[Item] = ()
    ) -> Iterator[Result]:
        """What work gives for each item, as ``Engine`` says. One item, or one process, is this process's own."""
        if min(self.workers, len(items)) <= 1:
            yield from (work((item,)) for item in items)
            return
        running: list[Future[Result]] = [self._threads.submit(self._done, work, item) for item in items]
        for future in running:
            yield future.result()

    def end(self) -> None:
        """End all processes at once, even in the middle of an item."""
        with self._lock:
            self._ended = True
        for process in self._started:
            process.kill()
        self._threads.shutdown(cancel_futures=True)
        for process in self._started:
            process.communicate()

    def _done(self, work: Callable[[Sequence[Item]], Result], item: Item) -> Result:
        """The result of an item from the process of this thread, or from a new one if that dies."""
        for _ in range(ITEM_TRIES):
            process = self._process()
            try:
                send(process.stdin, (work, (item,)))
                result, error = pickle.load(process.stdout)  # type: ignore[arg-type]
            except (EOFError, OSError, pickle.UnpicklingError):
                process.kill()
                self._own.process = None
                continue
            if error:
                raise error[0] from RuntimeError(error[1])  # where it was, as text
            return result  # type: ignore[no-any-return]
        how = f"its end had the code {process.wait()}"
        raise OSError(f"a process was ended from outside, for want of memory perhaps, {ITEM_TRIES} times; {how}")

    def _process(self) -> Popen[bytes]:
        """The process of this thread."""
        if getattr(self._own, "process", None) is None:
            threads = str(max(1, (os.cpu_count() or 1) // self.workers))
            environment = dict.fromkeys(ALONE, threads) | os.environ
            with self._lock:
                if self._ended:
                    raise RuntimeError("the processes have ended")
                self._own.process = Popen(
                    [sys.executable, "-c", PROGRAM],
                    stdin=PIPE,
                    stdout=PIPE,
                    env=environment,
                    **APART,
                )
                self._started.append(self._own.process)
            send(self._own.process.stdin, sys.path)
        return self._own.process  # type: ignore[no-any-return]


def send(pipe: Any, what: Any) -> None:
    """Write to another process."""
    pickle.dump(what, pipe)
    pipe.flush()


@contextmanager
def processes(count: int) -> Iterator[Processes]:
    """An engine of ``count`` processes, which end with the block."""
    engine = Processes(count)
    try:
        yield engine
    finally:
        engine.end()
