"""Free motion laws against the known ones, on each disc cam of the sources that has a roller.

    python benchmarks/free_laws.py > table.md
    python benchmarks/free_laws.py random > table.md

For each cam the pressure angle is at most 30° and the offset free, as far as the prime radius allows; for the
oscillating one it is at most 40°, since most laws have no cam below. At the peak acceleration and jerk of each of
four laws: the smallest prime radius with that law and with free laws, the bound that no motion can pass (none is
known where the follower oscillates), the gap to it, the free laws' radius if the jerk is free, seconds, and the
verdict of `camopt certify` on the free cam.

With ``random``: on 50 random convex scenes, the smallest prime radius with free laws, the gap to the bound, the
most numbers of a law, CPU seconds, and whether every limit is certified.
"""

import sys
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from camopt import CamoptError, certify, find_scene, optimise, synthesise
from camopt.scene.scene import Scene
from camopt.solve.synthesis.problem_from_scene import build_synthesis_problem

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from support.convex_scenes import random_convex_scene

SCENES = (
    "roller-1000rpm",
    "exhaust-valve",
    "two-pauses",
    "valve-rod-offset",
    "valve-rod-radial",
    "oscillating-roller",
)
COLUMNS = ("cam", "peaks of", "its radius, mm", "free laws, mm", "smaller by", "bound, mm", "gap")
COLUMNS += ("jerk free, mm", "s", "certified")
PEAKS = ("poly345", "cycloidal", "poly4567", "modified-sine")
RANDOM_SCENES = 50
FREE_OFFSET = {"start": -60, "stop": 60}


def problem(name: str, law: str) -> Scene:
    """A scene of the sources at its pressure angle, its offset free, at the peaks of a law."""
    scene = find_scene(name)
    swung = scene.follower.motion == "oscillating"
    angle = 40 if swung else 30
    changes: dict[str, Any] = {"limits.pressure_angle": angle, "limits.pressure_angle_return": angle}
    changes |= {"search.roller_radius": None, "search.law": [law]} | (
        {} if swung else {"search.offset": FREE_OFFSET}
    )
    changes |= {"synthesis.peak_acceleration": law, "synthesis.peak_jerk": law}
    return scene.replace(**changes)


def measure_random_scenes() -> None:
    """Print a row for each random scene in which only convex limits decide."""
    print("| scene | prime radius, mm | gap | numbers | s | certified |\n|---|---|---|---|---|---|")
    synthesise(problem(SCENES[0], PEAKS[0]))  # compiles
    for seed in range(RANDOM_SCENES):
        scene, start = random_convex_scene(seed), process_time()
        try:
            free = synthesise(scene)
        except CamoptError as reason:
            print(f"| {scene.name} | {reason} |||||", flush=True)
            continue
        seconds = process_time() - start
        prime = free.objective + build_synthesis_problem(scene).prime_less_cam_radius
        gap = "no bound" if free.bound is None else f"{(free.objective - free.bound) / prime:.3%}"
        laws = free.scene.to_dict()["laws"].values()
        numbers = max(len(law.get("coefficients") or law["positions"]) for law in laws)
        held = set(certify(free.scene).values()) == {"held"}
        decided = "" if free.convex else " (another limit decides)"
        print(
            f"| {scene.name} | {prime:.2f} | {gap}{decided} | {numbers} | {seconds:.2f} "
            f"| {'yes' if held else 'NO'} |",
            flush=True,
        )


def measure_shipped_scenes() -> None:
    """Print a row for each scene of the sources and each known law."""
    print(f"| {' | '.join(COLUMNS)} |\n|{'---|' * len(COLUMNS)}")
    synthesise(problem(SCENES[0], PEAKS[0]))  # compiles
    for name in SCENES:
        for law in PEAKS:
            scene = problem(name, law)
            best = optimise(scene).best
            assert best is not None
            start = perf_counter()
            free = synthesise(scene)
            seconds = perf_counter() - start
            rougher = synthesise(scene.replace(**{"synthesis.peak_jerk": None})).design["prime_radius_mm"]
            roller, radius = free.design["roller_radius_mm"], best["prime_radius_mm"]
            mine, bound, gap = free.design["prime_radius_mm"], "", ""
            if free.bound is not None:
                bound, gap = f"{free.bound + roller:.2f}", f"{1 - (free.bound + roller) / mine:.2%}"
            held = set(certify(free.scene).values()) == {"held"}
            print(
                f"| {name} | {law} | {radius:.2f} | {mine:.2f} | {1 - mine / radius:.1%} | {bound} "
                f"| {gap} | {rougher:.2f} | {seconds:.2f} | {'yes' if held else 'NO'} |",
                flush=True,
            )


if __name__ == "__main__":
    measure_random_scenes() if sys.argv[1:] == ["random"] else measure_shipped_scenes()
