"""Designs per second of sweeps in process, against the samples of a rival in C with as many threads."""

import os

import numpy as np
import pandas as pd
import pytest
from pytest_benchmark.fixture import BenchmarkFixture
from rival_c import MECHANISMS, NUMBERS, SAMPLES, SIZES, rival
from throughput import KEYS, Job, default_job, jobs
from timing import measured, ratio, rival_seconds, seconds

from camopt import evaluate_designs

STEPS, FEW = 160, 8
FINER = 16
THREADS = os.cpu_count() or 1
CURVATURES = ("pitch_curvature_min_per_mm", "pitch_curvature_max_per_mm")
ROUNDING = 1e-9
MISSED = 4e-3  # h²/8·f'' of samples h apart: f'' is up to a hundred, f being tan β or κ by its largest value


def against_the_rival(benchmark: BenchmarkFixture, job: Job, threads: int) -> None:
    """Record designs per second of camopt, and of the rival in both types of number."""
    swept = measured(benchmark, job.swept(threads), rounds=5)
    benchmark.extra_info |= {
        "designs": job.designs,
        "threads": threads,
        "designs_per_second": round(job.designs / seconds(benchmark)) if benchmark.enabled else None,
    }
    for number in NUMBERS:
        taken = rival_seconds(benchmark, job.sampled(rival(number), threads), rounds=5)
        benchmark.extra_info |= {
            f"{number}_rival": rival(number).name,
            f"{number}_rival_designs_per_second": round(job.designs / taken) if benchmark.enabled else None,
            f"{number}_ratio": ratio(taken, seconds(benchmark)),
        }
    assert swept.designs == job.designs
    assert swept.feasible > 0


def bench_default_sweep(benchmark: BenchmarkFixture) -> None:
    """The default sweep with a thread for each core."""
    against_the_rival(benchmark, default_job(), THREADS)


@pytest.mark.parametrize("mechanism", MECHANISMS)
def bench_mechanism(benchmark: BenchmarkFixture, mechanism: str) -> None:
    """A sweep of each mechanism on one thread."""
    against_the_rival(benchmark, jobs(STEPS)[mechanism], 1)


@pytest.mark.parametrize("mechanism", MECHANISMS)
def bench_agreement(benchmark: BenchmarkFixture, mechanism: str) -> None:
    """The rival is never beyond camopt's extremes, and gets nearer with the square of its samples."""
    job = jobs(FEW)[mechanism]
    flat = mechanism.endswith("flat")
    names = ("pressure_angle_max_deg", *(("profile_radius_min_mm",) if flat else CURVATURES))
    keys = {**KEYS, "size": "base_radius" if mechanism.startswith("disc") else "mean_radius"}
    frame = pd.DataFrame(dict(zip((f"{keys[name]}_mm" for name in SIZES), job.sizes.T, strict=True)))
    frame = frame.loc[:, frame.any()].assign(law="cycloidal")
    scene = job.scene.replace(outputs=list(names))
    own = measured(benchmark, lambda: evaluate_designs(scene, frame), rounds=1)[list(names)].to_numpy().T
    own[0] = np.tan(np.radians(own[0]))
    scale = np.array([np.ones(len(frame)), *[np.abs(own[1:]).max(axis=0)] * (len(own) - 1)])
    signs = np.array([1.0, -1.0, 1.0])[: len(own)]
    for samples in (SAMPLES, SAMPLES * FINER):
        (found,) = job.sampled(rival("double"), 1, samples)()
        gap = signs[:, None] * (own - found.T[: len(own)]) / scale
        benchmark.extra_info |= {f"error_of_{samples}_samples": float(gap.max())}
        assert gap.min() >= -ROUNDING
        assert gap.max() <= MISSED * (SAMPLES / samples) ** 2
