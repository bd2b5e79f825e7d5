"""The smallest pair of discs, whose limits hold at both, against scans of all sizes."""

import numpy as np
import pytest
from support.pairs import pair

from camopt import Scene, certify, evaluate, optimise
from camopt.problem.problem import exactly, resolve
from camopt.verdicts.screening import feasible

STEP = 0.05  # mm
MOTIONS = ("translating", "oscillating")


def bounded(seed, **search):
    """A random pair with one size for both discs, and limits."""
    scene = pair(np.random.default_rng(seed), MOTIONS[seed % 2])
    del scene["drive"]["base_radius"]
    limits = {"pressure_angle": 30 if seed % 2 else 24, "curvature_radius": 4.0}
    return Scene.from_dict({**scene, "limits": limits, "search": search})


@pytest.mark.one_in(20)
@pytest.mark.parametrize("seed", range(40))
def test_a_dense_scan_finds_the_same_smallest_pair(seed):
    scene = bounded(seed)
    problem, best = exactly(resolve(scene)), optimise(scene).best
    sizes = np.arange(STEP, 120.0, STEP)
    designs = problem.design.take(np.zeros(sizes.size, dtype=int)).with_values({"size": sizes})
    held = feasible(problem, designs)
    if best is None:
        assert not held.any()
        return
    assert best["proved"]
    scanned, size = sizes[np.argmax(held)], best["base_radius_mm"]
    assert scanned - STEP - 1e-9 < size <= scanned + 1e-9
    for share, verdict in ((1.0 + 1e-9, "held"), (1.0 - 1e-6, "broken")):
        found = certify(scene.replace(**{"cam.base_radius": size * share}))
        assert verdict in found.values()
        assert ("broken" in found.values()) == (share < 1.0)


@pytest.mark.one_in(10)
@pytest.mark.parametrize("seed", range(10))
def test_no_pair_with_free_sizes_is_smaller(seed):
    """Sizes of both discs are free: of many random ones that are smaller none holds the limits."""
    swings = seed % 2
    ends = {"start": 70, "stop": 88} if swings else {"start": -6, "stop": 9}
    own = "arm_length" if swings else "offset"
    scene = bounded(seed, **{own: ends, f"drive.{own}": ends})
    problem, best = exactly(resolve(scene)), optimise(scene, seconds=20).best
    size, rng, count = best["base_radius_mm"], np.random.default_rng(seed), 40_000
    again = evaluate(scene.replace(search=None, **best_sizes(best, own)))
    assert again["feasible"]
    drawn = {
        "size": rng.uniform(0.5 * size, size - 1e-3, count),
        own: rng.uniform(ends["start"], ends["stop"], count),
        f"second_{own}": rng.uniform(ends["start"], ends["stop"], count),
    }
    assert not feasible(problem, problem.design.take(np.zeros(count, dtype=int)).with_values(drawn)).any()


def best_sizes(best, own):
    keys = {"cam.base_radius": "base_radius_mm", f"follower.{own}": f"{own}_mm", f"drive.{own}": f"second_{own}_mm"}
    return {key: best[name] for key, name in keys.items()}
