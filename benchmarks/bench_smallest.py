"""The smallest cam with a pressure angle of at most 30°, against scipy and the package ``mechanism``.

First the radial cam, where only the base radius is free; then with the offset free as well. A rival that samples
the turn may return a cam that is too small: what its cam does between the samples is in ``rival_excess_deg``.
"""

import warnings
from collections.abc import Callable

import numpy as np
import pytest
from mechanism import Cam
from pytest_benchmark.fixture import BenchmarkFixture
from rival_numpy import Array, Cams, polished
from scipy import optimize
from smallest_cams import LIMIT, OFFSETS, RADII, ROLLER, Answer, by_brentq, sampled_tangents, smallest_cam
from timing import measured, ratio, rival_seconds, seconds

from camopt import Scene, optimise
from camopt.problem.problem import resolve
from camopt.problem.settings import problems_of
from camopt.smallest.optimise import boxes_of
from camopt.smallest.result import Smallest
from camopt.smallest.smallest import smallest

KNOWN = {("cycloidal", "radial"): 82.5472265, ("harmonic", "radial"): 60.1387819}  # mm
CLOSE = 1e-6  # mm


def solved(scene: Scene) -> Smallest:
    """The solve alone, without the description of the cam that ``optimise`` gives."""
    problem = resolve(scene)
    (each,), (box,) = problems_of(problem), boxes_of(problem)
    return smallest(each, box)


def by_mechanism(law: str) -> Answer:
    """The peer package: a root of the pressure angle at its own 1014 samples."""
    motion = [("Rise", 50, 120), ("Dwell", 60), ("Fall", 50, 90), ("Dwell", 90)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        peer = Cam(motion, degrees=True, omega=1000 * np.pi / 30, rotation="cw")
        found = peer.get_base_circle(kind=law, follower="roller", roller_radius=ROLLER, max_pressure_angle=LIMIT)
    return float(found["Rb"]), 0.0


def by_slsqp(law: str) -> Answer:
    """The least base radius with a constraint at every sample, by sequential quadratic programming."""
    tangents, limit = sampled_tangents(law), np.tan(np.radians(LIMIT))

    def room(x: Array) -> Array:
        tangent = tangents(x[0], x[1])
        return np.concatenate([limit - tangent, limit + tangent])

    found = optimize.minimize(
        lambda x: x[0],
        (100.0, 0.0),
        jac=lambda x: np.array([1.0, 0.0]),
        bounds=(RADII, OFFSETS),
        constraints={"type": "ineq", "fun": room},
        method="SLSQP",
        options={"ftol": 1e-10},
    )
    return float(found.x[0]), float(found.x[1])


def by_differential_evolution(law: str) -> Answer:
    """The least base radius with the excess of the sampled pressure angle as a constraint, by evolution."""
    tangents, limit = sampled_tangents(law), np.tan(np.radians(LIMIT))
    held = optimize.NonlinearConstraint(lambda x: np.abs(tangents(x[0], x[1])).max(), -np.inf, limit)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of its last, local step
        found = optimize.differential_evolution(
            lambda x: x[0], (RADII, OFFSETS), constraints=held, rng=1, tol=1e-10, maxiter=300
        )
    return float(found.x[0]), float(found.x[1])


RIVALS: dict[tuple[str, str], Callable[[str], Answer]] = {
    ("radial", "mechanism"): by_mechanism,
    ("radial", "brentq"): by_brentq,
    ("free", "slsqp"): by_slsqp,
    ("free", "differential_evolution"): by_differential_evolution,
}


def excess_deg(law: str, answer: Answer) -> float:
    """By how much a cam exceeds the limit on its continuous motion: by numpy, not by camopt."""
    radius, lead = answer
    cam = Cams(np.array([radius + ROLLER]), np.array([lead]))
    return float(polished(cam, law, 720)["pressure_angle_max_deg"][0]) - LIMIT


@pytest.mark.parametrize("law", ["cycloidal", "harmonic"])
@pytest.mark.parametrize(("offset", "rival"), list(RIVALS))
def bench_smallest(benchmark: BenchmarkFixture, law: str, offset: str, rival: str) -> None:
    """camopt's radius is never above a rival's whose cam holds the limit."""
    scene, run = smallest_cam(law, offset), RIVALS[offset, rival]
    best = measured(benchmark, lambda: optimise(scene)).best
    radius, answer = best["base_radius_mm"], run(law)
    taken = rival_seconds(benchmark, lambda: run(law), 3)
    alone = rival_seconds(benchmark, lambda: solved(scene))
    benchmark.extra_info |= {
        "radius_mm": radius,
        "offset_mm": best["offset_mm"],
        "excess_deg": excess_deg(law, (radius, -best["offset_mm"])),  # the cam turns cw
        "proved": best["proved"],
        "rival_radius_mm": answer[0],
        "rival_excess_deg": excess_deg(law, answer),
        "rival_seconds": taken,
        "ratio": ratio(taken, seconds(benchmark)),
        "solve_seconds": alone,
        "solve_ratio": ratio(taken, alone),
    }
    assert radius == pytest.approx(KNOWN.get((law, offset), radius), abs=CLOSE)
    assert excess_deg(law, (radius, -best["offset_mm"])) <= 1e-9
    if excess_deg(law, answer) <= 0.0:
        assert radius <= answer[0] + CLOSE
