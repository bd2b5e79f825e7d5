"""Threads of this process: for kernels, which let others run beside them."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from itertools import islice
from threading import Event

from camopt.core.engines import Item, WorkResult
from camopt.core.kernels.compile_clock import READY_KERNELS


@dataclass(frozen=True)
class Threads:
    """Threads that each work on one item at a time."""

    workers: int

    def in_order(
        self, work: Callable[[Sequence[Item]], WorkResult], items: Sequence[Item], sample: Sequence[Item] = ()
    ) -> Iterator[WorkResult]:
        """What work gives for each item, as ``Engine`` says.

        While no kernel is ready, the first comes from this thread, so that an interrupt ends it while it compiles.
        """
        waiting = ((item,) for item in items)
        yield from map(work, islice(waiting, 0 if READY_KERNELS else 1))
        begin = Event()  # of all threads together: one at work would keep this one from beginning the next
        pool = ThreadPoolExecutor(self.workers, initializer=begin.wait)
        running, busy = deque[Future[WorkResult]](), True
        try:
            for some in islice(waiting, self.workers + 1):
                running.append(pool.submit(work, some))
            begin.set()
            while running:
                yield running.popleft().result()
                for some in islice(waiting, 1):
                    running.append(pool.submit(work, some))
            busy = False
        finally:
            begin.set()
            pool.shutdown(wait=busy, cancel_futures=True)  # threads without work end by themselves
