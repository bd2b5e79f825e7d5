"""Engines run work on many items in parallel: in threads or processes of this machine, or on a Dask cluster.

An engine gives consecutive items to a free worker. It yields the results in the order of the items, and runs only a
few items ahead of the reader. Results do not depend on the engine. ``progress`` reports how far the work is.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol, TypeVar

from camopt.core.mistakes import BadInput, Mistake

Item = TypeVar("Item")
WorkResult = TypeVar("WorkResult")
LOCAL = "local"
SCHEDULER = re.compile(r"([a-z]+://)?[^\s/]+:\d+")


class Engine(Protocol):
    """An engine, which works on items in parallel."""

    @property
    def workers(self) -> int:
        """Number of items that are worked on at a time; on a cluster, it changes with the workers."""

    def results_in_order(
        self, work: Callable[[Sequence[Item]], WorkResult], items: Sequence[Item], sample: Sequence[Item] = ()
    ) -> Iterator[WorkResult]:
        """Yield the results of ``work`` for all items, a few items at a time, in order.

        Parameters
        ----------
        work : callable
            Takes a few consecutive items. For workers that are processes, it is pickled once for each worker.
        items : sequence
            The items.
        sample : sequence
            A few items that a cluster times to decide how many make a task.
        """


@contextmanager
def cluster(scheduler: str = LOCAL, workers: int | None = None) -> Iterator[Engine]:
    """Connect to a Dask cluster, an engine for ``sweep`` and ``frontier`` within the block.

    Workers may join later or die. Each needs the same camopt, numpy, scipy, numba and Python as this machine.

    Parameters
    ----------
    scheduler : str, default "local"
        Address of a Dask scheduler, such as "tcp://host:8786". "local" starts a cluster of processes on this
        machine, which ends with the block; a script that uses it needs ``if __name__ == "__main__":``.
    workers : int, optional
        Processes of a local cluster; one per core by default.

    Yields
    ------
    Engine
        For the argument ``engine`` of other functions.

    Raises
    ------
    BadInput
        If Dask is not installed, ``scheduler`` is no such address, or a worker has other versions.
    OSError
        If no scheduler answers, it has no workers, or one task kills every worker that tries it.

    References
    ----------
    M. Rocklin, Dask: parallel computation with blocked algorithms and task scheduling, SciPy (2015).

    Examples
    --------
    >>> search = {"base_radius": [60, 90, 120], "law": ["cycloidal"]}
    >>> scene = camopt.find_scene("roller-1000rpm").replace(search=search)
    >>> with camopt.cluster("local", workers=1) as engine:
    ...     swept = camopt.sweep(scene, engine=engine)
    >>> swept.designs, swept.feasible
    (3, 1)
    """
    mistakes = []
    if scheduler != LOCAL and not SCHEDULER.fullmatch(scheduler):
        allowed = f'the address of a Dask scheduler, such as tcp://host:8786, or "{LOCAL}"'
        mistakes.append(Mistake("camopt", "scheduler", scheduler, allowed))
    if scheduler != LOCAL and workers is not None:
        why = f'is only for the scheduler "{LOCAL}"; another cluster has its own workers'
        mistakes.append(Mistake("camopt", "workers", workers, why, bare=True))
    if mistakes:
        raise BadInput(mistakes)
    try:
        from camopt.core.engines.dask_cluster import connect_cluster
    except ModuleNotFoundError as missing:
        if missing.name not in ("dask", "distributed"):
            raise
        why = 'needs Dask; pip install "camopt[cluster]" adds it'
        raise BadInput([Mistake("camopt", "scheduler", scheduler, why, bare=True)]) from None
    with connect_cluster(scheduler, workers) as engine:
        yield engine
