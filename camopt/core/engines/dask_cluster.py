"""A Dask cluster: workers on many machines. They may join late or die; Dask then gives their tasks to others."""

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
from distributed.comm.core import CommClosedError
from distributed.gc import disable_gc_diagnosis
from distributed.versions import VersionMismatchWarning

from camopt.core.engines import LOCAL, Item, WorkResult
from camopt.core.engines.interrupts import hold_interrupts
from camopt.core.mistakes import BadInput, Mistake
from camopt.core.storage.version import camopt_and_kernel_version

TASK_SECONDS, TASK_BYTES = 2.0, 1 << 26  # rough largest duration of a task, and size of its result
TASKS_AHEAD, LEAST_TASKS = 4, 4  # tasks per thread: most that are submitted and unread; fewest in all
CONNECT_SECONDS, WORKER_SECONDS = 20.0, 60.0  # seconds to wait for a scheduler, and for its first worker
END_SECONDS, SILENT_LEVEL = 0.5, CRITICAL + 1  # seconds for a worker to end; level above all messages
SETTINGS = {
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,  # without this, blocks take twice as long
    "distributed.deploy.lost-worker-timeout": WORKER_SECONDS,  # the default of 15 s is too short on a busy machine
}
unpickle_work = lru_cache(maxsize=2)(pickle.loads)  # cached: work keeps pitch curves from one task to the next
LOGGERS = ("distributed", "distributed.client", "distributed.gc", "tornado.application", "asyncio")


def versions_of_camopt_numpy_and_scipy() -> str:
    """Versions on which a result depends."""
    return f"camopt {camopt_and_kernel_version()}, numpy {np.__version__}, scipy {scipy.__version__}"


def run_items_if_versions_match(work: bytes, expected_versions: str, items: Sequence[Any]) -> Any:
    """Work on some items in a worker.

    Raises
    ------
    BadInput
        If the worker has other versions than the machine that sent the work.
    """
    if (versions := versions_of_camopt_numpy_and_scipy()) != expected_versions:
        why = f"a worker with the same versions as this machine, {expected_versions}; it has {versions}"
        raise BadInput([Mistake("camopt", "scheduler", get_worker().address, why)])
    return unpickle_work(work)(items)


@dataclass(frozen=True)
class Cluster:
    """The workers of a scheduler, including those that join later."""

    client: Client
    address: str

    @property
    def workers(self) -> int:
        """Number of threads of all present workers; at least one, because workers may still join."""
        with self._translate_dask_errors():
            self._check_connected()
            threads: dict[str, int] = self.client.nthreads()
        return max(1, sum(threads.values()))

    def results_in_order(
        self, work: Callable[[Sequence[Item]], WorkResult], items: Sequence[Item], sample: Sequence[Item] = ()
    ) -> Iterator[WorkResult]:
        """Yield the results of ``work`` for a few items at a time; see ``Engine``."""
        pickled, versions, futures = (
            pickle.dumps(work),
            versions_of_camopt_numpy_and_scipy(),
            deque[Future[WorkResult]](),
        )
        with self._translate_dask_errors():
            count = self._items_per_task(work, len(items), sample) if sample else 1
            for first in range(0, len(items), count):
                task = items[first : first + count]
                futures.append(self.client.submit(run_items_if_versions_match, pickled, versions, task, pure=False))
                if len(futures) >= TASKS_AHEAD * self.workers:
                    yield self._wait_for_result(futures.popleft())
            while futures:
                yield self._wait_for_result(futures.popleft())

    def _items_per_task(self, work: Callable[[Any], Any], item_count: int, sample: Sequence[Any]) -> int:
        """Number of items in a task, from the seconds and bytes that a sample takes."""
        start, result = monotonic(), work(sample)
        seconds, size = max(1e-6, monotonic() - start), len(pickle.dumps(result))
        by_sample = len(sample) * min(TASK_SECONDS / seconds, TASK_BYTES / size)
        return max(1, min(int(by_sample), ceil(item_count / (LEAST_TASKS * self.workers))))

    def _wait_for_result(self, future: "Future[Any]") -> Any:
        """Wait for the result of a task; its error is raised here."""
        while True:
            try:
                return future.result(timeout=WORKER_SECONDS)
            except TimeoutError:
                if future.status == "error":
                    raise
            try:
                self.client.wait_for_workers(1, timeout=WORKER_SECONDS)  # without workers the task would never end
            except TimeoutError:
                raise ConnectionError(ECONNRESET, "the Dask scheduler has no workers", self.address) from None

    @contextmanager
    def _translate_dask_errors(self) -> Iterator[None]:
        """Raise an error with the scheduler's address if it is lost, or if a task killed every worker."""
        try:
            yield
        except KilledWorker:
            why = "one task killed every worker that tried it: they may lack memory; see the cluster's logs"
            raise ChildProcessError(ECHILD, why, self.address) from None
        except (Exception, CancelledError) as trouble:
            self._check_connected(trouble)  # else Dask's own message is shown
            raise

    def _check_connected(self, trouble: BaseException | None = None) -> None:
        # Dask may raise trouble before the client's status changes
        if self.client.status != "running" or isinstance(trouble, CommClosedError | CancelledError):
            raise ConnectionError(ECONNRESET, "the Dask scheduler was lost or restarted", self.address) from None


@contextmanager
def connect_cluster(scheduler: str, workers: int | None) -> Iterator[Cluster]:
    """Connect to the cluster of a scheduler, or to a local one, which ends with the block."""
    with ExitStack() as stack:
        for logger in map(getLogger, LOGGERS):  # hide Dask's messages about its own parts
            stack.callback(logger.setLevel, logger.level)
            logger.setLevel(SILENT_LEVEL)
        local = scheduler == LOCAL
        address = stack.enter_context(_local_scheduler_address(workers or cpu_count() or 1)) if local else scheduler
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
def _local_scheduler_address(worker_count: int) -> Iterator[str]:
    """Start a scheduler in this process with ``worker_count`` worker processes, and yield its address."""
    free_port = {"dashboard_address": "127.0.0.1:0"}
    settings = {"threads_per_worker": 1, "memory_limit": 1.0 / worker_count, "silence_logs": SILENT_LEVEL}
    with dask.config.set(SETTINGS):
        with hold_interrupts():  # threads and processes that start here get none
            cluster = LocalCluster(n_workers=0, dashboard_address=None, scheduler_kwargs=free_port, **settings)
        with cluster:
            cluster.scale(worker_count)
            try:
                yield cluster.scheduler_address
            finally:  # the workers' unfinished tasks are not needed
                ends = [worker.close for worker in cluster.workers.values()]
                cluster.sync(lambda: gather(*(end(timeout=END_SECONDS) for end in ends), return_exceptions=True))
