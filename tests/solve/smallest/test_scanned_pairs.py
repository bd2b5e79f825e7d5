"""The smallest pair with four free numbers, against a dense scan of them by a program of its own."""

from math import inf

import numpy as np
import pytest
from support.pairs import pair
from support.scanned_pairs import ScannedPair

from camopt import Scene, certify, evaluate, optimise

BASES, ROLLERS = (4.0, 124.0), (4.0, 16.0)
PLACES = {"offset": (-6.0, 9.0), "arm_length": (66.0, 88.0)}
FREE = (
    ("cam.base_radius", "drive.base_radius", "follower.{}", "drive.{}"),
    ("cam.base_radius", "follower.roller_radius", "follower.{}", "drive.{}"),
    ("cam.base_radius", "drive.base_radius", "follower.roller_radius", "follower.{}"),
    ("cam.base_radius", "follower.roller_radius", "drive.roller_radius", "drive.{}"),
)
"""What is free; the second disc has the other sizes of the first. ``{}`` is the offset, or the arm's length."""
CAMS = 40


def random_pair_and_ranges(seed):
    """A random pair with limits, and the ranges of its four free numbers by their keys."""
    rng, own = np.random.default_rng(seed), ("offset", "arm_length")[seed % 2]
    scene = pair(rng, ("translating", "oscillating")[seed % 2])
    keys = [key.format(own) for key in FREE[seed // 2 % len(FREE)]]
    kinds = {"base_radius": BASES, "roller_radius": ROLLERS, own: PLACES[own]}
    free = {key: kinds[key.split(".")[1]] for key in keys}
    for name in kinds:
        if f"drive.{name}" not in free:
            del scene["drive"][name]
    steepest = rng.uniform(24, 35) if seed % 2 else rng.uniform(14, 22)
    scene["limits"] = {"pressure_angle": float(steepest), "curvature_radius": float(rng.uniform(2, 14))}
    return scene, free


@pytest.mark.long
@pytest.mark.parametrize("seed", range(CAMS))
def test_a_dense_scan_of_four_free_numbers_finds_no_smaller_pair(seed):
    scene, free = random_pair_and_ranges(seed)
    places = {key: key if key.startswith("drive.") else key.split(".")[1] for key in free}
    search = {places[key]: {"start": low, "stop": high} for key, (low, high) in free.items()}
    best, scanned = optimise(Scene.from_dict({**scene, "search": search})).best, ScannedPair(scene)
    size, _ = scanned.least(free)
    if best is None:
        assert size == inf
        return
    found = {key: best[place.replace("drive.", "second_") + "_mm"] for key, place in places.items()}
    reached = max(sizes.base for sizes in scanned.sizes(found))
    print(f"scan {size:.9f} mm, above optimum by {size / reached - 1.0:.1e} of it; gap {best['gap_mm']:.1e} mm")
    assert best["proved"]
    assert reached * (1.0 - 1e-8) < size < reached * (1.0 + 1e-6)
    assert min(float(np.min(each)) for each in scanned.margins(found)) > -1e-8
    seen = Scene.from_dict({**scene, "outputs": ["pair"]}).replace(**found)
    told = evaluate(seen)
    for disc in ("first", "second"):
        for quantity, sign in (("pressure_angle_max_deg", 1.0), ("profile_radius_min_mm", -1.0)):
            key = f"{disc}_{quantity}"
            for share, verdict in ((1.0 + sign * 1e-9, "held"), (1.0 - sign * 1e-9, "broken")):
                assert certify(seen.replace(**{f"limits.{key}": told[key] * share}))[key] == verdict
