"""A Dask worker's side: it keeps the work once a sample has given the same result as elsewhere, but for rounding.

Source: distributed, ``Worker._register_with_scheduler``: a worker that joins late runs its plugins before it takes
tasks.
"""

import pickle
from _thread import LockType
from collections.abc import Callable, Mapping
from dataclasses import is_dataclass
from threading import Lock
from typing import Any

import numpy as np
from distributed import Reschedule, WorkerPlugin, get_worker

from camopt.kernels.version import version_of_kernels
from camopt.mistakes import BadInput, Mistake
from camopt.storage.version import VERSION

AGREED = 1e-13  # by how much the numbers of two processors may differ, of the largest beside them or of 1


def installed() -> dict[str, str]:
    """The versions that decide the bytes of a result: libraries and kernels."""
    import scipy

    versions = {"camopt": VERSION, "numpy": np.__version__, "scipy": scipy.__version__}
    return versions | {"kernels": version_of_kernels()}


def is_alike(one: Any, other: Any) -> bool:
    """Whether two results are the same, but for what two processors round: rows, texts and counts are equal."""
    if type(one) is not type(other):
        return False
    if is_dataclass(one):
        one, other = vars(one), vars(other)
    if isinstance(one, Mapping):
        return one.keys() == other.keys() and all(is_alike(one[key], other[key]) for key in one)
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(is_alike, one, other))
    one, other = np.asarray(one), np.asarray(other)
    if one.dtype != other.dtype or one.shape != other.shape:
        return False
    if one.dtype.kind not in "fc":
        return bool(np.all(one == other))
    finite = np.isfinite(one)
    room = AGREED * float(np.max(np.abs(one[finite]), initial=1.0))
    near = np.abs(one[finite] - other[finite]) <= room
    return bool(near.all()) and np.array_equal(one[~finite], other[~finite], equal_nan=True)


def unlike(worker: str, why: str) -> BadInput:
    """The reason why a worker would give other results."""
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
    expected : object
        What work gives for them.
    """

    lock: LockType
    """In a worker."""

    def __init__(self, name: str, work: Callable[[Any], Any], sample: Any, expected: Any) -> None:
        self.name, self.pickled = name, pickle.dumps((work, sample, expected))
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
        work, sample, expected = pickle.loads(self.pickled)
        if sample and not is_alike(work(sample), expected):
            raise unlike(self.address, "there the same designs have other numbers")
        return work  # type: ignore[no-any-return]


def run_worker(name: str, items: Any) -> Any:
    """Work on some items, in a worker."""
    ready: Any = get_worker().plugins.get(name)
    if ready is None:
        raise Reschedule  # it will be here in a moment
    return ready.prepared()(items)
