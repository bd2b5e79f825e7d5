"""Sweeps through a train of each stage, against the same space of the follower without one, on one thread.

Each run asks for a lift that is new by a billionth, so that motions are tabulated in it: what a train adds, it adds
for each motion. The rival's known laws are tabulated once, for all its lifts.
"""

from collections.abc import Callable, Iterator
from itertools import count
from time import process_time
from typing import Any

import pytest
from pytest_benchmark.fixture import BenchmarkFixture
from throughput import ARM, DISC
from timing import measured, ratio, rival_seconds, seconds

from camopt import Scene, Sweep, cam_points, sweep

ROLLER = {"motion": "translating", "contact": "roller", "roller_radius": 8}
SWINGING = {**ARM, "arm_length": 100.0, "centre_distance": 120.0}
FOUR_BAR = {"stage": "four-bar", "crank": 110, "coupler": 200, "rocker": 100, "ground": 220, "angle": 70}
LOADS = {"mass": 1.2, "spring_rate": 0.4, "preload": 35, "load": [[0, 0], [20, 25], [90, 25], [100, 0]]}
TRAINS: dict[str, tuple[dict[str, Any], float, list[dict[str, Any]]]] = {
    "rocker": (ROLLER, 20, [{"stage": "rocker", "input_arm": 30, "output_arm": 45, "output_angle": -15}]),
    "bell-crank": (
        SWINGING,
        40,
        [{"stage": "bell-crank", "crank": 160, "coupler": 220, "offset": -150, "angle": -110}],
    ),
    "slider-crank": (SWINGING, 15, [{"stage": "slider-crank", "crank": 80, "coupler": 220, "angle": -120}]),
    "four-bar": (SWINGING, 15, [FOUR_BAR]),
    "ratio": (ROLLER, 25, [{"stage": "ratio", "ratio": 1.5}]),
    "incline": (ROLLER, 12, [{"stage": "incline", "angle": 35}]),
    "two stages": (
        SWINGING,
        30,
        [FOUR_BAR, {"stage": "slider-crank", "crank": 110, "coupler": 260, "angle": -100}],
    ),
    "loaded rocker": (ROLLER, 20, [{"stage": "rocker", "input_arm": 30, "output_arm": 45, **LOADS}]),
}
LAWS = ["cycloidal", "modified-sine", "poly345"]
STEPS = {"800 designs": 16, "80,000 designs": 163}
"""In each of two sizes of a roller cam: the shipped scenes have some 800 designs."""
NEW = 1e-9
ROUNDS = 15


def _scene(follower: dict[str, Any], lift: float, steps: int, **keys: Any) -> Scene:
    """A rise and a return with a choice of laws, and two free sizes."""
    moving = {"lift": lift, "law": LAWS[0]}
    turn = [("rise", 120, moving), ("dwell", 50, {}), ("return", 110, moving), ("dwell", 80, {})]
    other = "offset" if follower["motion"] == "translating" else "roller_radius"
    ends = {"base_radius": (50.0, 90.0), "offset": (-20.0, 20.0), "roller_radius": (5.0, 15.0)}
    free = {
        key: {"start": ends[key][0], "stop": ends[key][1], "step": (ends[key][1] - ends[key][0]) / steps}
        for key in ("base_radius", other)
    }
    return Scene.from_dict(
        {
            "cam": {**DISC, "base_radius": 60.0},
            "follower": follower,
            "motion": [{"segment": kind, "angle": angle, **rest} for kind, angle, rest in turn],
            "limits": {"curvature_radius": 1.0, "pressure_angle": 30.0, **keys.pop("limits", {})},
            "search": {"law": LAWS, "minimise": ["base_radius_mm"], **free},
            **keys,
        }
    )


def _swept(scenes: Iterator[Scene]) -> Callable[[], Sweep]:
    return lambda: sweep(next(scenes), workers=1)


@pytest.mark.benchmark(timer=process_time)
@pytest.mark.parametrize("steps", STEPS.values(), ids=STEPS)
@pytest.mark.parametrize("name", TRAINS)
def bench_train(benchmark: BenchmarkFixture, name: str, steps: int) -> None:
    """The rate of designs through a train, as a share of that without one; by CPU time."""
    follower, lift, train = TRAINS[name]
    limits, carrying = {}, follower
    if name.startswith("loaded"):
        limits = {"normal_force": 1e5}
        carrying = {**follower, "dynamics": LOADS}
        follower = {**follower, "dynamics": {"mass": 0.1}}
    own = (_scene(follower, lift * (1 + NEW * k), steps, train=train, limits=limits) for k in count())
    points = cam_points(next(own))
    travel = max(next(points[key] for key in points if key.startswith("displacement")))
    rival = (_scene(carrying, travel * (1 + NEW * k), steps, limits=limits) for k in count())
    found = measured(benchmark, _swept(own), rounds=ROUNDS)
    taken = rival_seconds(benchmark, _swept(rival), ROUNDS, process_time)
    benchmark.extra_info |= {"designs": found.designs, "ratio": ratio(taken, seconds(benchmark))}
    assert found.designs == len(LAWS) * (steps + 1) ** 2
    assert found.feasible > 0
