"""A Dask cluster: workers on many machines, which may join late and die.

Work travels once to each worker, which is ready when it has done a sample of it (``dask_worker``). A task is a few
items, a second or two of work. Dask gives a task whose worker dies to others.

Source: distributed, ``Scheduler._remove_worker``: a task is given up after ``allowed-failures`` dead workers.
"""

import pickle
import re
import signal
import warnings
from asyncio import gather
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from errno import ECHILD, ECONNREFUSED, ECONNRESET
from logging import CRITICAL, getLogger
from math import ceil
from multiprocessing import resource_tracker
from os import cpu_count
from tempfile import TemporaryDirectory
from time import monotonic
from typing import Any
from uuid import uuid4

import dask
from distributed import CancelledError, Client, Future, KilledWorker, LocalCluster
from distributed.comm.core import CommClosedError
from distributed.gc import disable_gc_diagnosis
from distributed.versions import VersionMismatchWarning

from camopt.engines import LOCAL, Item, Result
from camopt.engines.dask_worker import Ready, run_worker, unlike
from camopt.mistakes import BadInput, Mistake

TASK_SECONDS = 2.0  # of work in a task: little is lost with a worker
RATE = 200.0  # tasks a second of all workers, at most: the scheduler can do some times as many
BYTES = 1 << 26  # of a result, at most about
AHEAD = 4  # tasks for each thread that the reader has not had yet
TASKS_PER_THREAD = 4  # tasks for each thread, at least, so that all end together
CONNECTED, JOINED = 20.0, 60.0  # seconds to wait for a scheduler, and for a worker where it has none
END_SECONDS = 0.5  # seconds for a worker to end by itself
TRIM = "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_"
"""What Dask has each worker give back to the system as soon as it is free, and take anew for the next block."""
LOST_TIMEOUT = "distributed.deploy.lost-worker-timeout"
"""After which Dask gives up a process that died and has not come back; on a busy machine its 15 s are too few."""
LOGGERS = ("distributed", "distributed.client", "distributed.gc", "tornado.application", "asyncio")
SILENT = CRITICAL + 1
SCHEDULER = re.compile(r"([a-z]+://)?[^\s/]+:\d+")


def items_of_task(items: int, threads: int, seconds: float, size: float) -> int:
    """The number of items of a task, from the seconds and bytes of one item."""
    by_time = max(TASK_SECONDS, threads / RATE) / max(seconds, 1e-6)
    by_size = BYTES / max(size, 1.0)
    return max(1, int(min(by_time, by_size, ceil(items / (TASKS_PER_THREAD * threads)))))


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
        self, work: Callable[[Sequence[Item]], Result], items: Sequence[Item], sample: Sequence[Item] = ()
    ) -> Iterator[Result]:
        """The results of ``work`` for some items at a time, as ``Engine`` says.

        Raises
        ------
        BadInput
            If a worker is unlike this machine.
        ConnectionError
            If the scheduler is gone, or has no workers.
        ChildProcessError
            If a task ends every worker that has it.
        """
        if not items:
            return
        threads, count, expected = self.workers, 1, None
        if sample:
            start, expected = monotonic(), work(sample)
            seconds, size = monotonic() - start, len(pickle.dumps(expected))
            count = items_of_task(len(items), threads, seconds / len(sample), size / len(sample))
        ready = Ready(f"camopt-{uuid4().hex}", work, sample, expected)
        try:
            self._prepare(ready)
            yield from self._results(ready.name, (items[k : k + count] for k in range(0, len(items), count)))
        except OSError as trouble:  # as it is when a scheduler is gone, Dask says that a connection took too long
            if isinstance(trouble, CommClosedError) or self.client.status != "running":
                raise self.gone() from None
            raise
        finally:
            if self.client.status == "running":
                with suppress(OSError, ValueError):
                    self.client.unregister_worker_plugin(ready.name)

    def _results(self, name: str, tasks: Iterator[Sequence[Item]]) -> Iterator[Any]:
        """The results of tasks, in order; a limited number of tasks is with workers or waits to be read."""
        given: deque[Future[Any]] = deque()
        try:
            for items in tasks:
                given.append(self.client.submit(run_worker, name, items, pure=False))
                if len(given) >= AHEAD * self.workers:
                    yield self._result(given.popleft())
            while given:
                yield self._result(given.popleft())
        finally:
            if given and self.client.status == "running":
                with suppress(OSError):
                    self.client.cancel([*given])

    def _result(self, future: Future[Any]) -> Any:
        """The result of a task; an error of it is raised here."""
        try:
            while True:
                with suppress(TimeoutError):
                    return future.result(timeout=JOINED)
                if future.done():
                    return future.result()
                self._wait_for_a_worker()  # without any, nobody would ever do the task
        except CancelledError:
            raise self.gone() from None
        except KilledWorker:
            why = "all workers died that tried one task: they may lack memory; the cluster's logs say more"
            raise ChildProcessError(ECHILD, why, self.address) from None

    def _prepare(self, ready: Ready) -> None:
        """Have all workers made ready, and those that join later before they take a task."""
        self._wait_for_a_worker()
        try:
            self.client.register_plugin(ready)
        except ImportError as trouble:
            raise unlike(self.address, f"it cannot import {trouble.name}") from None
        except OSError:
            if self.client.status != "running":
                raise
            # a worker died; those that live are being made ready

    def _wait_for_a_worker(self) -> None:
        try:
            self.client.wait_for_workers(1, timeout=JOINED)
        except TimeoutError:
            raise self._trouble("the Dask scheduler has no workers") from None

    def _check_connected(self) -> None:
        if self.client.status != "running":
            raise self.gone()

    def _trouble(self, what: str) -> ConnectionError:
        return ConnectionError(ECONNRESET, what, self.address)

    def gone(self) -> ConnectionError:
        """The message when the scheduler does not answer, or the block of ``cluster`` has ended."""
        return self._trouble("no longer connected to the Dask scheduler")


@contextmanager
def connected(scheduler: str, workers: int | None) -> Iterator[Cluster]:
    """The cluster of a scheduler, or one of processes of this machine that lives as long as the block."""
    mistakes = []
    if scheduler != LOCAL and not SCHEDULER.fullmatch(scheduler):
        allowed = f'the address of a Dask scheduler, such as tcp://host:8786, or "{LOCAL}"'
        mistakes.append(Mistake("camopt", "scheduler", scheduler, allowed))
    if scheduler != LOCAL and workers is not None:
        why = f'belongs to the scheduler "{LOCAL}"; a cluster has the workers that it has'
        mistakes.append(Mistake("camopt", "workers", workers, why, bare=True))
    if mistakes:
        raise BadInput(mistakes)
    with _quiet(), ExitStack() as stack:
        local = scheduler == LOCAL
        address = stack.enter_context(_processes(workers or cpu_count() or 1)) if local else scheduler
        found = Cluster(stack.enter_context(_client(address)), scheduler)
        disable_gc_diagnosis(force=True)  # an interrupt within it would be lost
        yield found


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence Dask's messages about its own parts."""
    levels = {name: getLogger(name).level for name in LOGGERS}
    try:
        for name in levels:
            getLogger(name).setLevel(SILENT)
        yield
    finally:
        for name, level in levels.items():
            getLogger(name).setLevel(level)


def _client(address: str) -> Client:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", VersionMismatchWarning)  # what matters of it is compared by workers
            return Client(address, timeout=CONNECTED, set_as_default=False, name="camopt")
    except OSError:
        raise ConnectionError(ECONNREFUSED, "no Dask scheduler answers", address) from None


@contextmanager
def _processes(count: int) -> Iterator[str]:
    """The address of a scheduler in this process with workers that are processes, and end with it."""
    with (
        TemporaryDirectory(prefix="camopt-", ignore_cleanup_errors=True) as folder,
        dask.config.set({TRIM: None, LOST_TIMEOUT: JOINED}),
    ):
        with _no_interrupts():  # of threads that begin here, and of processes that begin in these
            made = LocalCluster(
                n_workers=0,
                threads_per_worker=1,
                dashboard_address=None,
                scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},  # not a port that others may have
                silence_logs=SILENT,
                local_directory=folder,
                memory_limit=1.0 / count,
            )
        with made:
            made.scale(count)
            try:
                yield made.scheduler_address
            finally:
                made.sync(_end, [*made.workers.values()])


async def _end(workers: list[Any]) -> None:
    """End worker processes, with what they are at: nobody waits for it any more."""
    await gather(*(worker.close(timeout=END_SECONDS) for worker in workers), return_exceptions=True)


@contextmanager
def _no_interrupts() -> Iterator[None]:
    """Interrupts wait until the end of the block, where a system can make them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # which would let them in again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
