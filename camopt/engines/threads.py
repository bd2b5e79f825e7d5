"""Threads of this process: for kernels, which let others run beside them. Those without work are kept for more."""

from collections import defaultdict, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from os import getpid
from threading import Event

from camopt.engines import Item, Result
from camopt.kernels.compiling import READY

IDLE: dict[tuple[int, int], list[ThreadPoolExecutor]] = defaultdict(list)
"""Threads without work, by their process, for a fork has none of them, and number.

To start them takes a hundredth of the default sweep, and their kernels make tables of their own at first.
"""


@dataclass(frozen=True)
class Threads:
    """Threads that each work on one item at a time."""

    workers: int

    def in_order(
        self, work: Callable[[Sequence[Item]], Result], items: Sequence[Item], sample: Sequence[Item] = ()
    ) -> Iterator[Result]:
        """What work gives for each item, as ``Engine`` says.

        While no kernel is ready, the first comes from this thread, so that an interrupt ends it while it compiles.
        """
        waiting = ((item,) for item in items)
        yield from map(work, islice(waiting, 0 if READY else 1))
        begin = Event()  # of all threads together: one at work would keep this one from beginning the next

        def begun(some: Sequence[Item]) -> Result:
            begin.wait()
            return work(some)

        with _pool(self.workers) as pool:
            try:
                running = deque(pool.submit(begun, some) for some in islice(waiting, self.workers + 1))
            finally:
                begin.set()
            while running:
                yield running.popleft().result()
                running.extend(pool.submit(work, some) for some in islice(waiting, 1))


@contextmanager
def _pool(workers: int) -> Iterator[ThreadPoolExecutor]:
    """Threads, kept ones if there are; kept again, unless an exception leaves them at work, which ends then."""
    idle = IDLE[getpid(), workers]
    try:
        pool = idle.pop()
    except IndexError:
        pool = ThreadPoolExecutor(workers)
    try:
        yield pool
    except BaseException:
        pool.shutdown(cancel_futures=True)
        raise
    idle.append(pool)
