"""The smallest cam with more than the size free: offset, angles of rise and return, arm and centre distance.

A rival samples the turn, so its cam may be too small: ``rival_excess`` says by how much it breaks a limit. A rival
whose cam holds the limits is never smaller than camopt's.
"""

from typing import Any

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture
from rival_numpy import LAWS, Array
from rival_optimisers import RIVALS, Problem, quietly
from timing import least_seconds, measured, ratio, seconds

from camopt import Scene, find_scene, optimise

LAW, ROLLER = "cycloidal", 5.0
SIZES = (1.0, 200.0)
LIMITS = (30.0, 30.0)
SWING_LIMITS = (35.0, 40.0)
CLOSE = 1e-6  # mm


def strokes(rise: float, fall: float, lift: float, samples: int) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """y and y' of a rise and a return over angles in deg."""
    s, v, _ = LAWS[LAW](np.linspace(0.0, 1.0, samples // 2))
    up, down = lift / np.radians(rise), lift / np.radians(fall)
    return (lift * s, up * v), (lift * (1.0 - s), -down * v)


def translating(offset: bool, angles: bool) -> tuple[Scene, Problem]:
    """50 mm in 120°, back in 90°."""
    search: dict[str, Any] = {"law": [LAW]}
    bounds = [SIZES]
    if offset:
        search["offset"] = {"start": -40, "stop": 40}
        bounds.append((-40.0, 40.0))
    if angles:
        search |= {f"angle_{kind}": {"start": 60, "stop": 150} for kind in ("rise", "return")}
        bounds.append((60.0, 150.0))
    sizes = {"follower.offset": 0, "follower.roller_radius": ROLLER}
    limits = dict(zip(("pressure_angle", "pressure_angle_return"), LIMITS, strict=True))
    scene = find_scene("roller-1000rpm").replace(**sizes, limits=limits, search=search)

    def tangents(x: Array, samples: int) -> Array:
        lead, rise = (x[1] if offset else 0.0), (x[-1] if angles else 120.0)
        height = np.sqrt(max((x[0] + ROLLER) ** 2 - lead**2, 0.0))
        turn = strokes(rise, 210.0 - rise, 50.0, samples)
        pairs = zip(turn, LIMITS, strict=True)
        parts = [np.abs((y1 - lead) / (height + y + 1e-12)) / np.tan(np.radians(lim)) for (y, y1), lim in pairs]
        return np.concatenate(parts)

    return scene, Problem(tuple(bounds), tangents)


def oscillating(arm: bool, centre: bool) -> tuple[Scene, Problem]:
    """20° in 120°, back in 100°, ccw, a roller of 10 mm on an arm."""
    motion = [
        {"segment": "rise", "angle": 120, "lift": 20, "law": LAW},
        {"segment": "dwell", "angle": 30},
        {"segment": "return", "angle": 100, "lift": 20, "law": LAW},
        {"segment": "dwell", "angle": 110},
    ]
    ranges = {"arm_length": (80.0, 140.0), "centre_distance": (100.0, 160.0)}
    fixed = {"arm_length": 120.0, "centre_distance": 130.0}
    free = [name for name, wanted in zip(ranges, (arm, centre), strict=True) if wanted]
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": 40},
            "follower": {"motion": "oscillating", "contact": "roller", "roller_radius": 10, **fixed},
            "motion": motion,
            "limits": dict(zip(("pressure_angle", "pressure_angle_return"), SWING_LIMITS, strict=True)),
            "search": {name: dict(zip(("start", "stop"), ranges[name], strict=True)) for name in free},
        }
    )

    def tangents(x: Array, samples: int) -> Array:
        l, c = ({**fixed, **dict(zip(free, x[1:], strict=True))}[name] for name in ranges)  # noqa: E741
        cosine = (c**2 + l**2 - (x[0] + 10.0) ** 2) / (2 * c * l)
        turn = strokes(120.0, 100.0, np.radians(20.0), samples)
        if not -1.0 < cosine < 1.0 or np.arccos(cosine) + np.radians(20.0) >= np.pi:
            return np.full(2 * (samples // 2), 10.0 + abs(cosine))
        parts = []
        for (y, y1), limit in zip(turn, SWING_LIMITS, strict=True):
            psi = np.arccos(cosine) + y
            parts.append(np.abs((l * (1 + y1) - c * np.cos(psi)) / (c * np.sin(psi))) / np.tan(np.radians(limit)))
        return np.concatenate(parts)

    return scene, Problem((SIZES, *(ranges[name] for name in free)), tangents)


PROBLEMS = {
    "offset": translating(offset=True, angles=False),
    "angles": translating(offset=False, angles=True),
    "offset and angles": translating(offset=True, angles=True),
    "arm": oscillating(arm=True, centre=False),
    "arm and centre": oscillating(arm=True, centre=True),
}


@pytest.mark.parametrize("rival", RIVALS)
@pytest.mark.parametrize("name", PROBLEMS)
def bench_everything(benchmark: BenchmarkFixture, name: str, rival: str) -> None:
    """camopt's radius is never above a rival's whose cam holds the limits."""
    scene, problem = PROBLEMS[name]
    best = measured(benchmark, lambda: optimise(scene), rounds=2).best
    answer = quietly(RIVALS[rival], problem)
    taken = least_seconds(lambda: quietly(RIVALS[rival], problem), 1)
    chosen = {"offset": "offset_mm", "arm": "arm_length_mm", "centre": "centre_distance_mm"}
    keys = [chosen[word] for word in name.split(" and ") if word in chosen]
    x = [best["base_radius_mm"], *(best[key] * (-1.0 if key == "offset_mm" else 1.0) for key in keys)]  # cw
    x += best["angles_deg"][:1] if "angles_deg" in best else []
    benchmark.extra_info |= {
        "radius_mm": x[0],
        "excess": problem.excess(np.array(x)),
        "proved": best["proved"],
        "gap_mm": best["gap_mm"],
        "rival_radius_mm": float(answer[0]),
        "rival_excess": problem.excess(answer),
        "rival_seconds": taken,
        "ratio": ratio(taken, seconds(benchmark)),
    }
    assert best["proved"]
    assert problem.excess(np.array(x)) <= 1e-9
    if problem.excess(answer) <= 0.0:
        assert x[0] <= answer[0] + CLOSE
