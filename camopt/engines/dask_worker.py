"""A Dask worker's side: it keeps the work once a sample has given the same bytes as elsewhere.

Source: distributed, ``Worker._register_with_scheduler``: a worker that joins late runs its plugins before it takes
tasks.
"""

import pickle
from _thread import LockType
from collections.abc import Callable
from threading import Lock
from typing import Any

import numpy as np
from dask.base import tokenize
from distributed import Reschedule, WorkerPlugin, get_worker

from camopt.kernels.version import version_of_kernels
from camopt.mistakes import BadInput, Mistake
from camopt.storage.version import VERSION


def installed() -> dict[str, str]:
    """The versions that decide the bytes of a result: libraries and kernels."""
    import scipy

    versions = {"camopt": VERSION, "numpy": np.__version__, "scipy": scipy.__version__}
    return versions | {"kernels": version_of_kernels()}


def digest(result: Any) -> str:
    """The digest of a whole result."""
    return str(tokenize(result, ensure_deterministic=True))


def unlike(worker: str, why: str) -> BadInput:
    """The reason why a worker would give other bytes; empty if it would not."""
    return BadInput([Mistake("camopt", "scheduler", worker, f"a worker like this machine: {why}")])


class Ready(WorkerPlugin):
    """Makes a worker ready: it does a sample, which compiles its kernels, and keeps the work.

    Parameters
    ----------
    name : str
        By which tasks find it.
    work : callable
        Takes some items.
    sample : sequence
        A few items.
    expected : str
        The digest of what work gives for them.
    """

    lock: LockType
    """In a worker."""

    def __init__(self, name: str, work: Callable[[Any], Any], sample: Any, expected: str) -> None:
        self.name, self.pickled, self.expected = name, pickle.dumps((work, sample)), expected
        self.here, self.address = installed(), ""
        self.work: Callable[[Any], Any] | None = None
        self.trouble: Exception | None = None

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state, lock=Lock())

    async def setup(self, worker: Any) -> None:
        """Prepare in the thread of tasks: the worker is heard of meanwhile."""
        self.address = worker.address
        await worker.loop.asyncio_loop.run_in_executor(worker.executors["default"], self.prepared)

    def prepared(self) -> Callable[[Any], Any]:
        """The work, after the sample, which is done once. A fault is reported to every caller."""
        with self.lock:
            if self.work is None and self.trouble is None:
                try:
                    self.work = self._prepare()
                except Exception as trouble:
                    self.trouble = trouble
        if self.work is None:
            assert self.trouble
            raise self.trouble
        return self.work

    def _prepare(self) -> Callable[[Any], Any]:
        there = installed()
        for name, version in self.here.items():
            if there[name] != version:
                raise unlike(self.address, f"its {name} is {there[name]}, and here it is {version}")
        work, sample = pickle.loads(self.pickled)
        if sample and digest(work(sample)) != self.expected:
            raise unlike(self.address, "there the same designs have other last digits")
        return work  # type: ignore[no-any-return]


def run_worker(name: str, items: Any) -> Any:
    """Work on some items, in a worker."""
    ready: Any = get_worker().plugins.get(name)
    if ready is None:
        raise Reschedule  # it will be here in a moment
    return ready.prepared()(items)
