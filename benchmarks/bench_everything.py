"""The smallest cam with more than the size free: offset, angles, arm and centre distance, a flat face's offset.

A rival samples the turn, so its cam may be too small: ``rival_excess`` says by how much it breaks a limit. A rival
whose cam holds the limits is never smaller than camopt's.
"""

from typing import Any

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture
from rival_numpy import LAWS, Array
from rival_optimisers import FULL, RIVALS, SHORT, Problem, quietly
from timing import measured, ratio, rival_seconds, seconds

from camopt import Scene, find_scene, optimise

LAW, ROLLER = "cycloidal", 5.0
SIZES = (1.0, 200.0)
LIMITS = (30.0, 30.0)
SWING_LIMITS = (35.0, 40.0)
SWING = [
    {"segment": "rise", "angle": 120, "lift": 20, "law": LAW},
    {"segment": "dwell", "angle": 30},
    {"segment": "return", "angle": 100, "lift": 20, "law": LAW},
    {"segment": "dwell", "angle": 110},
]
LEAST_RADIUS = 10.0
FREE = {"offset": "offset_mm", "arm": "arm_length_mm", "centre": "centre_distance_mm", "face": "face_offset_mm"}
CLOSE = 1e-6  # mm


Stroke = tuple[Array, Array, Array]


def strokes(rise: float, fall: float, lift: float, samples: int) -> tuple[Stroke, Stroke]:
    """y, y' and y'' of a rise and a return over angles in deg."""
    s, v, a = LAWS[LAW](np.linspace(0.0, 1.0, samples // 2))
    up, down = np.radians(rise), np.radians(fall)
    return (lift * s, lift / up * v, lift / up**2 * a), (lift * (1.0 - s), -lift / down * v, -lift / down**2 * a)


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

    def usage(x: Array, samples: int) -> Array:
        lead, rise = (x[1] if offset else 0.0), (x[-1] if angles else 120.0)
        height = np.sqrt(max((x[0] + ROLLER) ** 2 - lead**2, 0.0))
        turn = strokes(rise, 210.0 - rise, 50.0, samples)
        pairs = zip(turn, LIMITS, strict=True)
        parts = [np.abs((y1 - lead) / (height + y + 1e-12)) / np.tan(np.radians(lim)) for (y, y1, _), lim in pairs]
        return np.concatenate(parts)

    return scene, Problem(tuple(bounds), usage)


def oscillating(arm: bool, centre: bool) -> tuple[Scene, Problem]:
    """20° in 120°, back in 100°, ccw, a roller of 10 mm on an arm."""
    ranges = {"arm_length": (80.0, 140.0), "centre_distance": (100.0, 160.0)}
    fixed = {"arm_length": 120.0, "centre_distance": 130.0}
    free = [name for name, wanted in zip(ranges, (arm, centre), strict=True) if wanted]
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": 40},
            "follower": {"motion": "oscillating", "contact": "roller", "roller_radius": 10, **fixed},
            "motion": SWING,
            "limits": dict(zip(("pressure_angle", "pressure_angle_return"), SWING_LIMITS, strict=True)),
            "search": {name: dict(zip(("start", "stop"), ranges[name], strict=True)) for name in free},
        }
    )

    def usage(x: Array, samples: int) -> Array:
        l, c = ({**fixed, **dict(zip(free, x[1:], strict=True))}[name] for name in ranges)  # noqa: E741
        cosine = (c**2 + l**2 - (x[0] + 10.0) ** 2) / (2 * c * l)
        turn = strokes(120.0, 100.0, np.radians(20.0), samples)
        if not -1.0 < cosine < 1.0 or np.arccos(cosine) + np.radians(20.0) >= np.pi:
            return np.full(2 * (samples // 2), 10.0 + abs(cosine))
        parts = []
        for (y, y1, _), limit in zip(turn, SWING_LIMITS, strict=True):
            psi = np.arccos(cosine) + y
            parts.append(np.abs((l * (1 + y1) - c * np.cos(psi)) / (c * np.sin(psi))) / np.tan(np.radians(limit)))
        return np.concatenate(parts)

    return scene, Problem((SIZES, *(ranges[name] for name in free)), usage)


def flat() -> tuple[Scene, Problem]:
    """The same swing of a flat face, its offset and the centre distance free: curvature decides."""
    ranges = {"face_offset": (-10.0, 15.0), "centre_distance": (100.0, 160.0)}
    scene = Scene.from_dict(
        {
            "cam": {"form": "disc", "base_radius": 40},
            "follower": {"motion": "oscillating", "contact": "flat", "face_offset": 5, "centre_distance": 130},
            "motion": SWING,
            "limits": {"curvature_radius": LEAST_RADIUS},
            "search": {name: dict(zip(("start", "stop"), ends, strict=True)) for name, ends in ranges.items()},
        }
    )

    def usage(x: Array, samples: int) -> Array:
        radius, f, c = x
        sine = (radius - f) / c
        if not -1.0 < sine < 1.0 or np.arcsin(sine) + np.radians(20.0) >= np.pi / 2:
            return np.full(2 * (samples // 2), 10.0 + abs(sine))
        parts = []
        for y, y1, y2 in strokes(120.0, 100.0, np.radians(20.0), samples):
            psi, q = np.arcsin(sine) + y, 1 + y1
            curvature = f + c * (np.sin(psi) * (2 * q - 1) / q**2 + np.cos(psi) * y2 / q**3)
            parts.append(2.0 - curvature / LEAST_RADIUS)
        return np.concatenate(parts)

    return scene, Problem((SIZES, *ranges.values()), usage)


PROBLEMS = {
    "offset": translating(offset=True, angles=False),
    "angles": translating(offset=False, angles=True),
    "offset and angles": translating(offset=True, angles=True),
    "arm": oscillating(arm=True, centre=False),
    "arm and centre": oscillating(arm=True, centre=True),
    "face and centre": flat(),
}


@pytest.mark.parametrize("rival", RIVALS)
@pytest.mark.parametrize("name", PROBLEMS)
def bench_everything(benchmark: BenchmarkFixture, name: str, rival: str) -> None:
    """camopt's radius is never above a rival's whose cam holds the limits."""
    scene, problem = PROBLEMS[name]
    best = measured(benchmark, lambda: optimise(scene), rounds=2).best
    effort = FULL if benchmark.enabled else SHORT
    answer = quietly(RIVALS[rival], problem, effort)
    taken = rival_seconds(benchmark, lambda: quietly(RIVALS[rival], problem, effort), 1)
    chosen = {
        "face": "face_offset_mm",
        "offset": "offset_mm",
        "arm": "arm_length_mm",
        "centre": "centre_distance_mm",
    }
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
