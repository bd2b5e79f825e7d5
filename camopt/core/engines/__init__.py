"""Engines work on many items: in threads or processes of this machine, or on a Dask cluster; and their progress.

An engine gives work a few items that follow each other, on whatever of its workers is free, and yields what comes
of them in the order of the items, never far ahead of the reader. Results do not depend on the engine.
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
        """The number of items worked on at a time, as known now."""
        ...

    def in_order(
        self, work: Callable[[Sequence[Item]], WorkResult], items: Sequence[Item], sample: Sequence[Item] = ()
    ) -> Iterator[WorkResult]:
        """The results of ``work`` for all items, some items at a time, in order.

        Parameters
        ----------
        work : callable
            Takes a few items that follow each other. Where workers are processes it is pickled, once for each.
        items : sequence
            The items.
        sample : sequence
            A few items, of which a cluster learns how many make a task.
        """
        ...


@contextmanager
def cluster(scheduler: str = LOCAL, workers: int | None = None) -> Iterator[Engine]:
    """Connect to a Dask cluster, an engine for ``sweep`` and ``frontier`` within the block.

    Workers may join later, and die. Each needs the same camopt, numpy, scipy, numba and Python as this machine.

    Parameters
    ----------
    scheduler : str, default "local"
        The address of a Dask scheduler, such as "tcp://host:8786". "local" starts a cluster of processes on this
        machine, which ends with the block; a script that does so needs ``if __name__ == "__main__":``.
    workers : int, optional
        Processes of a local cluster; one per core by default.

    Yields
    ------
    Engine
        For the argument ``engine`` of other functions.

    Raises
    ------
    BadInput
        If Dask is not installed, for another ``scheduler``, or if a worker has other versions than this machine.
    OSError
        If no scheduler answers, or it has no workers; if one task ends all workers that try it.

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
        why = f'belongs to the scheduler "{LOCAL}"; a cluster has the workers that it has'
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
