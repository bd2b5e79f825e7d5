"""The price list: ns for each design, mechanism by mechanism, at several relative errors and proved in balls.

``python benchmarks/prices.py`` prints a Markdown table: pressure angle on rise, return and dwell, and both extremes
of curvature (of the radius and the reach for flat faces), of 4096 random cams with cycloidal rises and returns.
"""

from collections.abc import Iterator
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from camopt import Scene
from camopt.effects import Case
from camopt.mechanisms import Designs
from camopt.motion.table import ALL_STROKES, DWELL, RETURN, RISE
from camopt.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST
from camopt.problem.problem import Problem, resolve
from camopt.verdicts.certify import certify_limits

DESIGNS, PROVED, RUNS = 4096, 20, 5
ERRORS = (1e-3, 1e-6, 1e-9, 1e-12)
DISC, DRUM = {"form": "disc", "base_radius": 45}, {"form": "cylindrical", "mean_radius": 60}
ARM = {"motion": "oscillating", "arm_length": 90, "centre_distance": 110}
ROLLER = {"contact": "roller", "roller_radius": 8}
SCENES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "disc, translating knife": (DISC, {"motion": "translating", "contact": "knife", "offset": 5}),
    "disc, translating roller": (DISC, {"motion": "translating", **ROLLER, "offset": 5}),
    "disc, translating spherical": (DISC, {"motion": "translating", "contact": "spherical", "face_radius": 40}),
    "disc, translating flat": (DISC, {"motion": "translating", "contact": "flat"}),
    "disc, oscillating roller": (DISC, {**ARM, **ROLLER}),
    "disc, oscillating flat": (
        DISC,
        {"motion": "oscillating", "contact": "flat", "centre_distance": 120, "face_offset": 5},
    ),
    "cylindrical, translating": (DRUM, {"motion": "translating", **ROLLER}),
    "cylindrical, oscillating": (DRUM, {"motion": "oscillating", **ROLLER, "arm_length": 90}),
}
MOTION = [
    {"segment": "rise", "angle": 120, "lift": 20, "law": "cycloidal"},
    {"segment": "dwell", "angle": 50},
    {"segment": "return", "angle": 110, "lift": 20, "law": "cycloidal"},
    {"segment": "dwell", "angle": 80},
]


def random_designs(problem: Problem) -> Designs:
    """The scene's design with sizes varied by a tenth; those that can be assembled."""
    rng = np.random.default_rng(0)
    shares = {name: rng.uniform(0.95, 1.1, 2 * DESIGNS) for name in ("size", "roller_radius")}
    sizes = {name: value * shares.get(name, np.ones(2 * DESIGNS)) for name, value in problem.design.sizes.items()}
    designs = Designs(**sizes, sense=problem.design.sense)
    return designs.take(problem.setup.mechanism.exists(designs, problem.programme)).take(slice(DESIGNS))


def nanoseconds(problem: Problem, designs: Designs, error: float) -> float:
    """The least time for each design of all its geometric extremes."""
    mechanism = problem.setup.mechanism
    both = [(ALL_STROKES, LARGEST), (ALL_STROKES, LEAST)]
    asked = [(mechanism.pressure, [(kind, LARGEST_MAGNITUDE) for kind in (RISE, RETURN, DWELL)])]
    asked += [(make, both) for make in (mechanism.curvature, mechanism.profile_radius, mechanism.reach) if make]
    case = Case(replace(problem.setup, relative_error=error), problem.programme, designs)
    times = []
    for _ in range(RUNS + 1):  # the first may compile
        start = perf_counter()
        for make, questions in asked:
            case.extremes(make, questions)
        times.append(perf_counter() - start)
    return min(times) / len(designs) * 1e9


def proof(problem: Problem, designs: Designs) -> float:
    """Milliseconds for each design to prove or refute β ≤ 35° and no undercut in ball arithmetic."""
    start = perf_counter()
    for i in range(PROVED):
        certify_limits(problem, designs.take([i]))
    return (perf_counter() - start) / PROVED * 1e3


def lines() -> Iterator[str]:
    """The table, a line at a time."""
    heads = [f"to {error:.0e}, ns" for error in ERRORS]
    yield "| mechanism | " + " | ".join([*heads, "proved in balls, ms"]) + " |"
    yield "|---|" + "---:|" * (len(ERRORS) + 1)
    for name, (cam, follower) in SCENES.items():
        scene = Scene.from_dict(
            {"cam": cam, "follower": follower, "motion": MOTION, "limits": {"pressure_angle": 35}}
        )
        problem = resolve(scene)
        designs = random_designs(problem)
        prices = [f"{nanoseconds(problem, designs, error):.0f}" for error in ERRORS]
        yield f"| {name} | " + " | ".join([*prices, f"{proof(problem, designs):.1f}"]) + " |"


if __name__ == "__main__":
    for line in lines():
        print(line, flush=True)
