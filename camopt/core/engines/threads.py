"""Threads of this process, for compiled kernels, which release Python's lock."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from itertools import islice
from threading import Event

from camopt.core.engines import Item, WorkResult
from camopt.core.kernels.compile_notice import READY_KERNELS


@dataclass(frozen=True)
class Threads:
    """Threads that each work on one item at a time."""

    workers: int

    def results_in_order(
        self, work: Callable[[Sequence[Item]], WorkResult], items: Sequence[Item], sample: Sequence[Item] = ()
    ) -> Iterator[WorkResult]:
        """Yield the result of each item; see ``Engine``.

        If no kernel is compiled yet, this thread does the first item, so that an interrupt can end the compilation.
        """
        tasks = ((item,) for item in items)
        yield from map(work, islice(tasks, 0 if READY_KERNELS else 1))
        begin = Event()  # all threads begin together: a thread at work would delay the start of the next
        pool = ThreadPoolExecutor(self.workers, initializer=begin.wait)
        running, busy = deque[Future[WorkResult]](), True
        try:
            for task in islice(tasks, self.workers + 1):
                running.append(pool.submit(work, task))
            begin.set()
            while running:
                yield running.popleft().result()
                for task in islice(tasks, 1):
                    running.append(pool.submit(work, task))
            busy = False
        finally:
            begin.set()
            pool.shutdown(wait=busy, cancel_futures=True)  # threads without work end by themselves
