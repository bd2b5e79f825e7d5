"""The smallest pair of discs, whose limits hold at both, against scans of all sizes."""

import numpy as np
import pytest
from support.pairs import pair

from camopt import Scene, certify, evaluate, optimise
from camopt.scene.problem.problem import resolve, with_rounding_relative_error
from camopt.solve.verdicts.feasible_filter import feasible_designs

STEP = 0.05  # mm
MOTIONS = ("translating", "oscillating")


def pair_with_limits(seed, **search):
    """A random pair with one size for both discs, and limits."""
    scene = pair(np.random.default_rng(seed), MOTIONS[seed % 2])
    del scene["drive"]["base_radius"]
    limits = {"pressure_angle": 30 if seed % 2 else 24, "curvature_radius": 4.0}
    return Scene.from_dict({**scene, "limits": limits, "search": search})


@pytest.mark.slow
@pytest.mark.one_in(20)
@pytest.mark.parametrize("seed", range(40))
def test_a_dense_scan_finds_the_same_smallest_pair(seed):
    scene = pair_with_limits(seed)
    problem, best = with_rounding_relative_error(resolve(scene)), optimise(scene).best
    sizes = np.arange(STEP, 120.0, STEP)
    designs = problem.design.take(np.zeros(sizes.size, dtype=int)).with_values({"size": sizes})
    held = feasible_designs(problem, designs)
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


@pytest.mark.slow
@pytest.mark.one_in(10)
@pytest.mark.parametrize("seed", range(10))
def test_no_pair_with_free_sizes_is_smaller(seed):
    """Sizes of both discs are free: of many random ones that are smaller none holds the limits."""
    swings = seed % 2
    ends = {"start": 70, "stop": 88} if swings else {"start": -6, "stop": 9}
    own = "arm_length" if swings else "offset"
    scene = pair_with_limits(seed, **{own: ends, f"drive.{own}": ends})
    problem, best = with_rounding_relative_error(resolve(scene)), optimise(scene, seconds=20).best
    size, rng, count = best["base_radius_mm"], np.random.default_rng(seed), 40_000
    again = evaluate(scene.replace(search=None, **best_sizes(best, own)))
    assert again["feasible"]
    drawn = {
        "size": rng.uniform(0.5 * size, size - 1e-3, count),
        own: rng.uniform(ends["start"], ends["stop"], count),
        f"second_{own}": rng.uniform(ends["start"], ends["stop"], count),
    }
    assert not feasible_designs(problem, problem.design.take(np.zeros(count, dtype=int)).with_values(drawn)).any()


def best_sizes(best, own):
    keys = {"cam.base_radius": "base_radius_mm", f"follower.{own}": f"{own}_mm", f"drive.{own}": f"second_{own}_mm"}
    return {key: best[name] for key, name in keys.items()}


def cams_of(scene):
    """Both discs of a pair as ordinary cams: the second turns the other way, and its rises are returns."""
    data = scene.to_dict()
    drive, search = data.pop("drive"), data.pop("search")
    seconds = search.pop("drive")
    own = {key: value for key, value in drive.items() if key in ("roller_radius", "offset", "arm_length")}
    rise, top, fall, foot = data["motion"]
    turned = [{**fall, "segment": "rise"}, foot, {**rise, "segment": "return"}, top]
    turns = "ccw" if data["cam"].get("rotation") == "cw" else "cw"
    second = {
        **data,
        "cam": {**data["cam"], "rotation": turns},
        "follower": {**data["follower"], **own},
        "motion": turned,
        "search": seconds,
    }
    return Scene.from_dict({**data, "search": search}), Scene.from_dict(second)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(40))
def test_both_discs_of_the_smallest_pair_are_the_smallest_cams_of_their_own(seed):
    """Base radii and offsets, or arms, of both discs are free: four numbers, of which no two are of both."""
    swings, radii = seed % 2, {"start": 5, "stop": 150}
    ends = {"start": 66, "stop": 88} if swings else {"start": -6, "stop": 9}
    own = "arm_length" if swings else "offset"
    scene = pair(np.random.default_rng(seed), MOTIONS[swings])
    search = {"base_radius": radii, own: ends, "drive.base_radius": radii, f"drive.{own}": ends}
    scene = Scene.from_dict(
        {**scene, "limits": {"pressure_angle": 35, "curvature_radius": 4.0 + seed % 8}, "search": search}
    )
    best, alone = optimise(scene).best, [optimise(each).best for each in cams_of(scene)]
    assert (best is None) == (None in alone)
    if best is None:
        return
    assert best["proved"]
    found = [best["base_radius_mm"], best["second_base_radius_mm"]]
    assert found == pytest.approx([each["base_radius_mm"] for each in alone], rel=1e-8)
    sizes = best_sizes(best, own) | {"drive.base_radius": found[1]}
    for place, limit in enumerate(("first_pressure_angle_max_deg", "second_pressure_angle_max_deg")):
        seen = scene.replace(search=None, **sizes)
        reached = evaluate(seen.replace(outputs=["pair"]))[limit]
        for share, said in ((1.0 + 1e-9, "held"), (1.0 - 1e-9, "broken")):
            assert certify(seen.replace(**{f"limits.{limit}": reached * share}))[limit] == said, place


@pytest.mark.long
def test_the_smallest_pair_with_sizes_of_both_discs_is_that_of_a_scan():
    """One offset and one roller for both discs; rollers share the force with a preload."""
    scene = pair(np.random.default_rng(4), "translating")
    del scene["drive"]["offset"], scene["drive"]["roller_radius"]
    scene["drive"] |= {"interference": 0.01, "stiffness": 30_000}
    scene["follower"]["dynamics"] = {"mass": 3}
    scene["materials"] = {"cam": "steel", "follower": "steel", "face_width": 10}
    limits = {"pressure_angle": 35, "contact_stress": 800}
    radii = {"start": 5, "stop": 150}
    search = {"base_radius": radii, "offset": {"start": -6, "stop": 9}, "drive.base_radius": radii}
    scene = Scene.from_dict({**scene, "limits": limits, "search": search})
    problem, best = with_rounding_relative_error(resolve(scene)), optimise(scene).best
    size = max(best["base_radius_mm"], best["second_base_radius_mm"])
    assert best["proved"]
    grid = np.meshgrid(np.arange(size - 1.0, size + 0.2, 0.1), np.arange(-6.0, 9.01, 0.1), indexing="ij")
    sizes, offsets = (each.ravel() for each in grid)
    drawn = {"size": sizes, "second_size": sizes, "offset": offsets}
    held = feasible_designs(problem, problem.design.take(np.zeros(sizes.size, dtype=int)).with_values(drawn))
    assert not held[sizes < size].any()
    assert held[sizes > size].any()
