"""Random conditions on the way of moves: what free laws and their bound make of them, and which contradict.

    python benchmarks/conditions.py [SETS]

SETS is how many random sets (200) there are of each kind. The feasible ones are read off a random motion:
positions, velocities and accelerations at angles and over ranges of angles, which that motion has. For each the
laws of the least mean-square jerk, or of the least peak acceleration, are computed with their bound. The
contradictory ones have two positions that are further apart than a range of velocity between them allows; the
scene's reader names an irreducible set, and each set with one of those less is read without a mistake.
"""

import sys
from collections import Counter
from collections.abc import Iterator
from time import perf_counter
from typing import Any

import numpy as np

from camopt import BadInput, Scene, Unmet, synthesise
from camopt.scene.problem.problem import resolve

CAM = {"form": "disc", "rpm": 60, "base_radius": 500}
FOLLOWER = {"motion": "translating", "contact": "knife"}
NAMES = ("position", "velocity", "acceleration")
ANGLE, LIFT = 200.0, 40.0  # of the move with the conditions: deg, mm
SHARES = (0.5, 0.9, 0.99, 1.0)


def scene_with(conditions: list[dict[str, Any]], **changes: Any) -> Scene:
    """A move up with conditions, and one back."""
    motion = [
        {"segment": "move", "angle": ANGLE, "to": LIFT, "through": conditions},
        {"segment": "dwell", "angle": 20},
        {"segment": "move", "angle": 120, "to": 0},
        {"segment": "dwell", "angle": 20},
    ]
    return Scene.from_dict({"cam": CAM, "follower": FOLLOWER, "motion": motion}).replace(**changes)


def feasible(random: np.random.Generator) -> list[dict[str, Any]]:
    """Conditions that a random motion meets: one through two or three points."""
    angles = np.linspace(50, 150, random.integers(2, 4))
    points = [{"angle": a, "position": random.uniform(0.1, 0.9) * LIFT} for a in angles]
    motion = resolve(scene_with(points)).programme
    start = motion.strokes[0].low  # above the lowest of this motion, which is on its base circle

    found = []
    for _ in range(random.integers(2, 6)):
        order = int(random.integers(0, 3))
        angle, length = random.uniform(5, 155), random.choice([0.0, random.uniform(10, 40)])
        values = motion.motion_at(np.radians(np.linspace(angle, angle + length, 101)))[order] - start * (order == 0)
        slack = random.uniform(0.02, 0.2) * np.ptp(motion.motion_at(np.radians(np.arange(ANGLE)))[order])
        within = [float(values.min() - slack), float(values.max() + slack)] if length else float(values[0])
        found.append({"angle": [angle, angle + length] if length else angle, NAMES[order]: within})
    return found


def contradictory(random: np.random.Generator) -> list[dict[str, Any]]:
    """Some that go together, and two positions too far apart for a range of velocities."""
    first = random.uniform(30, 100)
    last = first + random.uniform(20, 50)
    low, fastest = random.uniform(5, 15), random.uniform(3, 10)
    far = low + 1.1 * fastest * np.radians(last - first)
    found = [
        {"angle": first, "position": low},
        {"angle": last, "position": float(far)},
        {"angle": [first - 5, last + 5], "velocity": [-fastest, fastest]},
        {"angle": random.uniform(160, 175), "position": [0.0, 2 * LIFT]},
        {"angle": [180.0, 190.0], "acceleration": [-2000.0, 2000.0]},
    ]
    return [found[k] for k in random.permutation(len(found))]


def irreducible_of(conditions: list[dict[str, Any]]) -> list[int]:
    """The places of those that contradict each other, as the scene's reader says."""
    try:
        scene_with(conditions)
    except BadInput as mistakes:
        text = str(mistakes)
        return [k for k in range(len(conditions)) if f"motion.1.through.{k + 1}." in text]
    return []


def _gaps(count: int, minimise: str) -> Iterator[tuple[float, float]]:
    """Gap and seconds of each feasible set."""
    for seed in range(count):
        scene = scene_with(feasible(np.random.default_rng(seed)), **{"synthesis.minimise": minimise})
        start = perf_counter()
        try:
            result = synthesise(scene)
        except Unmet as why:
            print(f"set {seed}: {why}")
            continue
        yield 1.0 if result.gap is None else result.gap, perf_counter() - start


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    print("| minimised | sets met | gap to the bound: median, 90 %, 99 %, largest | s each, median |")
    print("|---|---|---|---|")
    for minimise in ("jerk_rms", "acceleration"):
        gaps, seconds = np.array(list(_gaps(count, minimise))).T
        shown = ", ".join(f"{gap:.2%}" for gap in np.quantile(gaps, SHARES))
        print(f"| {minimise} | {gaps.size} of {count} | {shown} | {np.median(seconds):.2f} |")
    sizes: Counter[int] = Counter()
    for seed in range(count):
        conditions = contradictory(np.random.default_rng(seed))
        named = irreducible_of(conditions)
        assert named, seed
        for left_out in named:  # each subset with one less of them can be met
            assert not irreducible_of([conditions[k] for k in named if k != left_out]), seed
        sizes[len(named)] += 1
    told = ", ".join(f"{sizes[size]} of {size}" for size in sorted(sizes))
    print(
        f"\n{count} contradictory sets: irreducible ones {told} conditions; without any one of them each can be met"
    )


if __name__ == "__main__":
    main()
