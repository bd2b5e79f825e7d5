"""A Dask cluster: workers on many machines, which may join late and die; Dask gives their tasks to others."""

import pickle
import warnings
from asyncio import gather
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from errno import ECHILD, ECONNREFUSED, ECONNRESET
from functools import lru_cache
from logging import CRITICAL, getLogger
from math import ceil
from os import cpu_count
from time import monotonic
from typing import Any

import dask
import numpy as np
import scipy
from distributed import CancelledError, Client, Future, KilledWorker, LocalCluster, get_worker
from distributed.gc import disable_gc_diagnosis
from distributed.versions import VersionMismatchWarning

from camopt.core.engines import LOCAL, Item, WorkResult
from camopt.core.engines.interrupts import hold_interrupts
from camopt.core.mistakes import BadInput, Mistake
from camopt.core.storage.version import version_of_rows

TASK_SECONDS, TASK_BYTES = 2.0, 1 << 26  # of work and of its result, at most about
TASKS_AHEAD, LEAST_TASKS = (
    4,
    4,
)  # tasks for each thread: with workers or unread at a time, at most; in all, at least
CONNECT_SECONDS, WORKER_SECONDS = 20.0, 60.0  # seconds to wait for a scheduler, and for a worker where it has none
END_SECONDS, SILENT_LEVEL = 0.5, CRITICAL + 1  # for a worker to end by itself; a level of messages
SETTINGS = {
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,  # else blocks take twice as long
    "distributed.deploy.lost-worker-timeout": WORKER_SECONDS,  # its 15 s are too few on a busy machine
}
unpickle_work = lru_cache(maxsize=2)(pickle.loads)  # work keeps pitch curves from one task to the next
LOGGERS = ("distributed", "distributed.client", "distributed.gc", "tornado.application", "asyncio")


def result_versions() -> str:
    """The versions on which a result depends."""
    return f"camopt {version_of_rows()}, numpy {np.__version__}, scipy {scipy.__version__}"


def run_items(work: bytes, expected: str, items: Sequence[Any]) -> Any:
    """Work on some items, in a worker with the same versions."""
    if (own := result_versions()) != expected:
        why = f"a worker like this machine, which has {expected}; it has {own}"
        raise BadInput([Mistake("camopt", "scheduler", get_worker().address, why)])
    return unpickle_work(work)(items)


@dataclass(frozen=True)
class Cluster:
    """The workers of a scheduler, including those that join later."""

    client: Client
    address: str

    @property
    def workers(self) -> int:
        """The threads of all present workers; at least one, for a worker that is still to come."""
        self._check_connected()
        threads: dict[str, int] = self.client.nthreads()
        return max(1, sum(threads.values()))

    def in_order(
        self, work: Callable[[Sequence[Item]], WorkResult], items: Sequence[Item], sample: Sequence[Item] = ()
    ) -> Iterator[WorkResult]:
        """The results of ``work`` for some items at a time, as ``Engine`` says."""
        pickled, here, futures = pickle.dumps(work), result_versions(), deque[Future[WorkResult]]()
        try:
            count = self._items_of_task(work, len(items), sample) if sample else 1
            for first in range(0, len(items), count):
                some = items[first : first + count]
                futures.append(self.client.submit(run_items, pickled, here, some, pure=False))
                if len(futures) >= TASKS_AHEAD * self.workers:
                    yield self._result(futures.popleft())
            while futures:
                yield self._result(futures.popleft())
        except KilledWorker:
            why = "all workers died that tried one task: they may lack memory; the cluster's logs say more"
            raise ChildProcessError(ECHILD, why, self.address) from None
        except (Exception, CancelledError):
            self._check_connected()  # Dask has other words for it
            raise

    def _items_of_task(self, work: Callable[[Any], Any], items: int, sample: Sequence[Any]) -> int:
        """The number of items of a task, from the seconds and bytes of a sample."""
        start, result = monotonic(), work(sample)
        seconds, size = max(1e-6, monotonic() - start), len(pickle.dumps(result))
        by_sample = len(sample) * min(TASK_SECONDS / seconds, TASK_BYTES / size)
        return max(1, min(int(by_sample), ceil(items / (LEAST_TASKS * self.workers))))

    def _result(self, future: "Future[Any]") -> Any:
        """The result of a task; an error of it is raised here."""
        while True:
            try:
                return future.result(timeout=WORKER_SECONDS)
            except TimeoutError:
                if future.status == "error":
                    raise
            try:
                self.client.wait_for_workers(
                    1, timeout=WORKER_SECONDS
                )  # without any, nobody would ever do the task
            except TimeoutError:
                raise ConnectionError(ECONNRESET, "the Dask scheduler has no workers", self.address) from None

    def _check_connected(self) -> None:
        if self.client.status != "running":
            raise ConnectionError(ECONNRESET, "no longer connected to the Dask scheduler", self.address) from None


@contextmanager
def connect_cluster(scheduler: str, workers: int | None) -> Iterator[Cluster]:
    """The cluster of a scheduler, or one of processes of this machine that lives as long as the block."""
    with ExitStack() as stack:
        for logger in map(getLogger, LOGGERS):  # Dask's messages about its own parts
            stack.callback(logger.setLevel, logger.level)
            logger.setLevel(SILENT_LEVEL)
        local = scheduler == LOCAL
        address = stack.enter_context(_local_cluster(workers or cpu_count() or 1)) if local else scheduler
        try:
            with warnings.catch_warnings(
                action="ignore", category=VersionMismatchWarning
            ):  # tasks compare versions
                client = Client(address, timeout=CONNECT_SECONDS, set_as_default=False, name="camopt")
        except OSError:
            raise ConnectionError(ECONNREFUSED, "no Dask scheduler answers", address) from None
        disable_gc_diagnosis(force=True)  # an interrupt within it would be lost
        yield Cluster(stack.enter_context(client), scheduler)


@contextmanager
def _local_cluster(count: int) -> Iterator[str]:
    """The address of a scheduler in this process with workers that are processes, and end with it."""
    own_port = {"dashboard_address": "127.0.0.1:0"}  # not one that others may have
    settings = {"threads_per_worker": 1, "memory_limit": 1.0 / count, "silence_logs": SILENT_LEVEL}
    with dask.config.set(SETTINGS):
        with hold_interrupts():  # of threads and processes that begin here
            made = LocalCluster(n_workers=0, dashboard_address=None, scheduler_kwargs=own_port, **settings)
        with made:
            made.scale(count)
            try:
                yield made.scheduler_address
            finally:  # nobody waits any more for what workers are at
                ends = [worker.close for worker in made.workers.values()]
                made.sync(lambda: gather(*(end(timeout=END_SECONDS) for end in ends), return_exceptions=True))
