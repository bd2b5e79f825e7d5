"""What a Dask worker keeps: the work, once it has shown that it gives the bytes that it gives elsewhere.

Source: distributed, ``Worker._register_with_scheduler``: a worker that joins late runs its plugins before it takes
tasks.
"""

import pickle
from collections.abc import Callable
from time import monotonic
from typing import Any

import numpy as np
from distributed import WorkerPlugin, get_worker

from camopt.mistakes import BadInput, Mistake
from camopt.version import VERSION


def installed() -> dict[str, str]:
    """What decides which bytes come out: versions of what computes, and of the kernels."""
    import scipy

    from camopt.kernels.dispatchers import CACHE_FOLDER

    versions = {"camopt": VERSION, "numpy": np.__version__, "scipy": scipy.__version__}
    return versions | {"kernels": CACHE_FOLDER.name}


def digest(result: Any) -> str:
    """The digest of all that a result holds."""
    from joblib import hash

    return str(hash(result))


def unlike(worker: str, why: str) -> BadInput:
    """What is wrong with a worker that would give other bytes."""
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

    def __init__(self, name: str, work: Callable[[Any], Any], sample: Any, expected: str) -> None:
        self.name, self.pickled, self.expected = name, pickle.dumps((work, sample)), expected
        self.here = installed()
        self.work: Callable[[Any], Any] | None = None
        self.trouble: Exception | None = None

    async def setup(self, worker: Any) -> None:
        """Prepare in the thread of tasks: the worker is heard of meanwhile."""
        await worker.loop.asyncio_loop.run_in_executor(worker.executors["default"], self.prepare, worker.address)

    def prepare(self, address: str) -> None:
        """Do the sample. What is wrong is kept too: of a worker that joins late, the first task tells it."""
        try:
            there = installed()
            for name, version in self.here.items():
                if there[name] != version:
                    raise unlike(address, f"its {name} is {there[name]}, and here it is {version}")
            self.work, sample = pickle.loads(self.pickled)
            if sample and digest(self.work(sample)) != self.expected:
                raise unlike(address, "there the same designs have other last digits")
        except Exception as trouble:
            self.trouble = trouble
            raise


def run(name: str, items: Any) -> tuple[float, bytes]:
    """Work on some items, in a worker: seconds, and the pickled result."""
    ready: Any = get_worker().plugins[name]
    if ready.trouble:
        raise ready.trouble
    start = monotonic()
    result = ready.work(items)
    return monotonic() - start, pickle.dumps(result, protocol=pickle.HIGHEST_PROTOCOL)
