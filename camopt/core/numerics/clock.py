"""The clock of a search. It stops while kernels are compiled, because that happens once per machine."""

from collections.abc import Callable
from time import monotonic, perf_counter
from typing import TypeVar

from camopt.core.kernels.compile_clock import COMPILE_CLOCK

TimedResult = TypeVar("TimedResult")


def clock_seconds() -> float:
    """Seconds since a fixed moment, without time spent on compilation."""
    return monotonic() - COMPILE_CLOCK.seconds


def next_task_deadline(deadline: float, tasks_left: int) -> float:
    """Time at which the first of ``tasks_left`` equal tasks must stop to leave the others as much time."""
    start = clock_seconds()
    return start + max(deadline - start, 0.0) / tasks_left


def time_runs(work: Callable[[], TimedResult], runs: int) -> tuple[TimedResult, float]:
    """Result of some work and its shortest time over some runs [s], after a first run, which may compile."""
    result, times = work(), []
    for _ in range(runs):
        start = perf_counter()
        work()
        times.append(perf_counter() - start)
    return result, min(times)
