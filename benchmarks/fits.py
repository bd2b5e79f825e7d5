"""What `camopt fit` finds again of motions that are known, measured with errors.

    python benchmarks/fits.py [FILES]

FILES is how many files of random errors (5) there are of each motion and noise: a point each degree, normal errors
of 0.001, 0.01 and 0.05 mm. Motions are lobes of 8 mm, 60° up and 60° down, of each law that rests at both ends, and
those of shipped valves. The table has the largest acceleration and jerk that the fit found over the true ones (the
median of the files; ∞ where the true jerk has an impulse), the acceleration by plain differences, in how many files
the band is proved at every point, the root mean square of the jerk over the least of all motions as near to the
points, and seconds.
"""

import sys
from collections.abc import Iterator
from math import inf
from statistics import median
from time import perf_counter

import numpy as np

from camopt import LAWS, Unmet, find_scene, fit
from camopt.motion.programme import Programme, law_peaks, peak
from camopt.motion.table import TURN
from camopt.problem.problem import resolve

NOISES = (0.001, 0.01, 0.05)  # mm
VALVES = ("exhaust-valve", "bucket-valve")
CAM = {"cam": {"form": "disc", "base_radius": 20.0}, "follower": {"motion": "translating", "contact": "flat"}}
ANGLES = np.arange(360.0)


def motions() -> Iterator[tuple[str, Programme]]:
    """The motions by name."""
    for name, law in LAWS.items():
        if law_peaks(law)["jumps"] != "velocity":
            lobe = [("dwell", 60.0, 0.0, None), ("rise", 60.0, 8.0, name), ("return", 60.0, 8.0, name)]
            yield name, Programme.from_segments([*lobe, ("dwell", 180.0, 0.0, None)], angular=False)
    for name in VALVES:
        yield name, resolve(find_scene(name)).programme


def row(programme: Programme, noise: float, files: int) -> dict[str, float]:
    """What is found of a motion in files with other errors: medians."""
    lifts = programme.at(np.radians(ANGLES))[0]
    true = {"acceleration": peak(programme, 2, TURN), "jerk": peak(programme, 3, TURN)}
    rows = []
    for seed in range(files):
        errors = np.random.default_rng(seed).normal(0.0, noise, ANGLES.size)
        start = perf_counter()
        try:
            found = fit(np.column_stack([ANGLES, lifts + errors]), CAM)
        except Unmet:
            continue
        seconds = perf_counter() - start
        assert found.deviation.held
        ratios = [found.after[name] / value if value < inf else inf for name, value in true.items()]
        before = found.before["acceleration"] / true["acceleration"]
        rows.append((found.band, *ratios, before, found.jerk_rms / found.least_jerk_rms, seconds))
    names = ("band", "acceleration", "jerk", "differences", "over_bound", "seconds")
    return {**dict(zip(names, map(median, zip(*rows, strict=True)), strict=True)), "held": len(rows)}


def main() -> None:
    files = int(sys.argv[1]) if sys.argv[1:] else 5
    print(
        "| motion | noise, mm | band, mm | held | acceleration | by differences | jerk | rms jerk over bound | s |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for name, programme in motions():
        for noise in NOISES:
            of = row(programme, noise, files)
            jerk = "∞" if of["jerk"] == inf else f"{of['jerk']:.3f}"
            print(
                f"| {name} | {noise:g} | {of['band']:.4f} | {of['held']} of {files} | {of['acceleration']:.3f} "
                f"| {of['differences']:.2f} | {jerk} | {of['over_bound']:.3f} | {of['seconds']:.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
