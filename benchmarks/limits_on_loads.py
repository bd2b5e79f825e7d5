"""Sweeps of the default space under limits on loads, in process: least seconds of several.

    python benchmarks/limits_on_loads.py [ROUNDS]

With another commit in PYTHONPATH it measures that one. Each limit is at about the median of the designs that hold
the limits of the scene.
"""

import sys
import time

import compiled  # noqa: F401

from camopt import find_scene, sweep

LOADS = {
    "follower.dynamics": {"mass": 0.5, "spring_rate": 20.0, "preload": 800.0},
    "materials": {"cam": "steel", "follower": "steel", "face_width": 15.0},
}
LIMITS = {
    "contact_stress": 620.0,
    "jump_speed": 1660.0,
    "torque": 88.0,
    "normal_force": 1808.0,
    "side_thrust": 630.0,
}


def main(rounds: int) -> None:
    scene = find_scene("roller-1000rpm").replace(**LOADS)
    scenes = {"none": scene} | {key: scene.replace(**{f"limits.{key}": LIMITS[key]}) for key in LIMITS}
    for name, each in scenes.items():
        sweep(each, workers=2)
        seconds = []
        for _ in range(rounds):
            start = time.perf_counter()
            found = sweep(each, workers=2)
            seconds.append(time.perf_counter() - start)
        print(f"{name:15} {found.designs:,} designs, {found.feasible:,} feasible: {min(seconds) * 1e3:.0f} ms")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 9)
