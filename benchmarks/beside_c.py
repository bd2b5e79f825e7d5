"""Sweeps of about a million designs in process, beside two rivals in C with as many threads, in turns.

    python benchmarks/beside_c.py

One rival takes 360 samples of each cam. The other computes each pitch curve once for all designs that share it, and
polishes the best of few samples to 1e-9. Ratios are those of the least of several times, and in brackets of the
medians: above 1 camopt is faster, though it proves its verdicts and finds the front, and C does neither. Rows are
those of all feasible designs, with every column, in memory.
"""

import os
from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np
from compiled import compile_early
from rival_c import MECHANISMS, rival
from throughput import Job, default_job, jobs, shared_curves

from camopt.core.engines.threads import Threads
from camopt.scene.problem.rows import DesignRows
from camopt.solve.front.blocks import gather_batches
from camopt.solve.front.plan import sweep_plan

STEPS, ROUNDS, WARM = 1000, 9, 3
THREADS = os.cpu_count() or 1


def in_turns(*works: Callable[[], Any]) -> list[list[float]]:
    """Seconds of some works, one after the other in each round."""
    times: list[list[float]] = [[] for _ in works]
    for number in range(WARM + ROUNDS):
        for work, taken in zip(works, times, strict=True):
            start = perf_counter()
            work()
            if number >= WARM:
                taken.append(perf_counter() - start)
    return times


def all_rows(job: Job, threads: int) -> list[DesignRows]:
    """The rows of all feasible designs."""
    plan, kept = sweep_plan(job.scene, "feasible"), list[DesignRows]()
    gather_batches(
        plan.space, plan.evaluate_in_batches(plan.part_blocks(), Threads(threads)), plan.block_size, kept.append
    )
    return kept


def told(name: str, job: Job, threads: int, work: Callable[[], Any]) -> str:
    """The row of a table."""
    rivals = [job.sampled(rival(number), threads) for number in ("double", "float")]
    ours, *theirs = in_turns(work, *rivals, job.polished(rival("double"), threads))
    ratios = (f"{min(each) / min(ours):.2f} ({np.median(each) / np.median(ours):.2f})" for each in theirs)
    curves = len(job.raw["search"]["law"]) * len(shared_curves(job.mechanism, job.sizes).sizes)
    return f"| {name} | {threads} | {job.designs:,} | {curves:,} | {1e3 * min(ours):.0f} | {' | '.join(ratios)} |"


def main() -> None:
    """Print the table."""
    print(
        "| sweep | threads | designs | curves | ms | C in doubles | C in floats | C, shared, to 1e-9 |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
        sep="\n",
    )
    default = default_job()
    for threads in dict.fromkeys((1, THREADS)):
        print(told("default: counts and front", default, threads, default.swept(threads)), flush=True)
        print(told("default: all rows", default, threads, lambda: all_rows(default, threads)), flush=True)  # noqa: B023
    for mechanism, job in jobs(STEPS).items():
        assert mechanism in MECHANISMS
        print(told(mechanism.replace("_", " "), job, 1, job.swept(1)), flush=True)


if __name__ == "__main__":
    compile_early()
    main()
