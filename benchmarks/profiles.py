"""What `camopt fit` finds again of measured profiles.

    python benchmarks/profiles.py [FILES]

FILES is how many files of random errors (5) there are of each follower and noise: x and y of the centre of a ball
of 2 mm at 360 equal distances along the profile, with normal errors along the normal. The cam rises by 8 mm (or
8 deg) in 80 deg and returns in 100 deg, by the 4-5-6-7 polynomial. The table has medians: the band, the largest
acceleration and jerk over the true ones, how far the base radius is off, the largest distance of a point from the
profile that was found, and seconds.
"""

import sys
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from camopt import MeasuredProfile, Scene, fit
from camopt.mechanisms.geometry import cam_curves
from camopt.motion.programme import peak
from camopt.motion.table import ALL_STROKES
from camopt.problem.problem import resolve

NOISES = (0.001, 0.01, 0.05)  # mm
BASE, BALL, COUNT = 60.0, 2.0, 360
FOLLOWERS: dict[str, dict[str, Any]] = {
    "flat": {"motion": "translating", "contact": "flat"},
    "roller, offset": {"motion": "translating", "contact": "roller", "roller_radius": 6.0, "offset": 5.0},
    "oscillating roller": {
        "motion": "oscillating",
        "contact": "roller",
        "roller_radius": 8.0,
        "arm_length": 70.0,
        "centre_distance": 80.0,
    },
    "oscillating flat": {"motion": "oscillating", "contact": "flat", "centre_distance": 80.0, "face_offset": 5.0},
}
MOTION = [
    {"segment": "dwell", "angle": 60.0},
    {"segment": "rise", "angle": 80.0, "lift": 8.0, "law": "poly4567"},
    {"segment": "return", "angle": 100.0, "lift": 8.0, "law": "poly4567"},
    {"segment": "dwell", "angle": 120.0},
]


def row(follower: dict[str, Any], noise: float, files: int) -> list[float]:
    """What is found of the cam of a follower in files with other errors: medians."""
    tables = {"cam": {"form": "disc"}, "follower": follower}
    whole = {**tables, "cam": {"form": "disc", "base_radius": BASE}, "name": "cam", "motion": MOTION}
    problem = resolve(Scene.from_dict(whole))
    fine = np.linspace(0.0, 2.0 * np.pi, 100_001)
    along = cam_curves(problem.setup.mechanism, problem.design, problem.programme, fine).profile[0]
    length = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(along)))])
    theta = np.interp(np.linspace(0.0, length[-1], COUNT + 1)[:-1], length, fine)
    curves = cam_curves(problem.setup.mechanism, problem.design, problem.programme, theta)
    per = np.degrees(1.0) if problem.setup.angular else 1.0
    true = {
        name: per * peak(problem.programme, order, ALL_STROKES)
        for name, order in (("acceleration", 2), ("jerk", 3))
    }
    found = []
    for seed in range(files):
        errors = np.random.default_rng(seed).normal(0.0, noise, COUNT)
        points = curves.profile[0] + (BALL + errors) * curves.normal
        start = perf_counter()
        fitted = fit(MeasuredProfile(np.column_stack([points.real, points.imag]), "xy", BALL), tables)
        seconds = perf_counter() - start
        assert fitted.deviation.held
        ratios = [fitted.after[name] / exact for name, exact in true.items()]
        off = abs(fitted.scene.cam.base_radius - BASE)
        found.append((fitted.band, *ratios, off, float(np.abs(fitted.distances).max()), seconds))
    return [median(column) for column in zip(*found, strict=True)]


def main() -> None:
    files = int(sys.argv[1]) if sys.argv[1:] else 5
    print(
        "| follower | noise, mm | band, mm or deg | acceleration | jerk | base radius off, mm | distance, mm | s |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for name, follower in FOLLOWERS.items():
        for noise in NOISES:
            band, acceleration, jerk, off, distance, seconds = row(follower, noise, files)
            print(
                f"| {name} | {noise:g} | {band:.4f} | {acceleration:.3f} | {jerk:.3f} | {off:.4f} | {distance:.4f} "
                f"| {seconds:.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
