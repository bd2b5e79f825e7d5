"""Times of runs."""

import sys
from collections.abc import Callable
from math import inf
from time import perf_counter, thread_time
from typing import TypeVar

TimedResult = TypeVar("TimedResult")
THREAD_CLOCK = perf_counter if sys.platform == "win32" else thread_time
"""Seconds of this thread at work, so that other processes do not count. That of Windows has steps of 16 ms."""


def time_runs(work: Callable[[], TimedResult], runs: int, enough_seconds: float = inf) -> tuple[TimedResult, float]:
    """Result of some work and its shortest time of this thread over some runs [s]; the first of them may compile.

    After two runs, those after the first need not take longer than ``enough_seconds`` together.
    """
    times: list[float] = []
    while len(times) < min(runs, 2) or (len(times) < runs and sum(times[1:]) < enough_seconds):
        start = THREAD_CLOCK()
        result = work()
        times.append(THREAD_CLOCK() - start)
    return result, min(times)
