"""Times that can be compared: the rival in the same process, warmed up, the least of n runs."""

from collections.abc import Callable
from time import perf_counter
from typing import Any

from pytest_benchmark.fixture import BenchmarkFixture

ROUNDS = 7


def least_seconds(run: Callable[[], Any], rounds: int = ROUNDS, clock: Callable[[], float] = perf_counter) -> float:
    """The least time of n runs, after one that does not count."""
    run()
    times = []
    for _ in range(rounds):
        start = clock()
        run()
        times.append(clock() - start)
    return min(times)


def measured(benchmark: BenchmarkFixture, run: Callable[[], Any], rounds: int = ROUNDS) -> Any:
    """Time a call with pytest-benchmark, the first call (which may compile) apart; what the call returns."""
    return benchmark.pedantic(run, rounds=rounds, warmup_rounds=1)


def seconds(benchmark: BenchmarkFixture) -> float:
    """The least time that pytest-benchmark has measured; NaN where it was told to measure nothing."""
    return float(benchmark.stats.stats.min) if benchmark.stats else float("nan")


def rival_seconds(
    benchmark: BenchmarkFixture,
    run: Callable[[], Any],
    rounds: int = ROUNDS,
    clock: Callable[[], float] = perf_counter,
) -> float:
    """The least time of a rival; NaN where nothing is to be measured (``--benchmark-disable``)."""
    return least_seconds(run, rounds, clock) if benchmark.enabled else float("nan")


def ratio(rival: float, own: float) -> float:
    """How many times longer the rival takes."""
    return round(rival / own, 3)
