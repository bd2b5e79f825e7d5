"""Robust cams whose links have tolerances, against scans of cams and trains, and at zero tolerances."""

import itertools

import numpy as np
import pytest

import camopt
from camopt.scene.problem.problem import resolve_design, with_rounding_relative_error
from camopt.scene.problem.tolerance_zones import design_copies_with_errors, entries_of_train_numbers
from camopt.solve.synthesis.nonconvex_constraints import nonconvex_constraints_of
from camopt.solve.synthesis.problem_from_scene import build_synthesis_problem
from camopt.solve.synthesis.sequential_convex import SequentialConvex
from camopt.solve.synthesis.synthesise import solve_free_laws
from camopt.solve.synthesis.through_train import follower_states
from camopt.solve.tolerances.margins import evaluate_limits

GIVEN = {
    "slide-by-bell-crank": {"train.1.crank": 0.1, "train.1.coupler": 0.1, "follower.roller_radius": 0.02},
    "press-ram-by-four-bar": {"train.1.coupler": 0.05, "train.2.crank": {"plus": 0.05, "minus": 0.02}},
    "valve-with-rocker": {"train.1.output_arm": 0.05, "follower.offset": 0.05},
    "pusher-by-lever": {"train.1.ratio": 0.01, "train.1.mass": 0.05},
}
STEPS = 3
"""Of each number in a scan."""


def robust_scene(name, tolerances=None, **more):
    """A scene whose robust cam is sought, with one law and nothing else that is free."""
    given = GIVEN[name] if tolerances is None else tolerances
    return camopt.find_scene(name).replace(search={"robust": True}, tolerances=given, **more)


def worst_excess(scene, steps=STEPS):
    """Over all limits, of a dense scan of all cams and trains within the tolerances: corners, sides and insides."""
    problem = with_rounding_relative_error(resolve_design(scene))
    spans = {field: np.linspace(zone.lower, zone.upper, steps) for field, zone in problem.zones.items()}
    trains = entries_of_train_numbers(spans)
    own = {field: each for field, each in spans.items() if field not in trains}
    offs = [dict(zip(own, values, strict=True)) for values in itertools.product(*own.values())]
    worst = []
    for values in itertools.product(*trains.values()):
        numbers = {key: problem.nominal_numbers[key] + by for key, by in zip(trains, values, strict=True)}
        each = problem.with_numbers(numbers)
        worst.append(evaluate_limits(each, each.limits, design_copies_with_errors(each.design, offs))[0].max())
    return max(worst)


def is_the_smallest(best):
    """Whether a robust cam is proved, holds its limits in a scan, and a little smaller one does not."""
    smaller = best.scene.replace(**{"cam.base_radius": best["base_radius_mm"] * (1.0 - 1e-6)})
    proved = best["proved"] and best["every_cam"] == "held"
    return proved and worst_excess(best.scene) <= 0.0 < worst_excess(smaller)


@pytest.mark.long
@pytest.mark.parametrize("name", GIVEN)
def test_a_robust_cam_is_the_smallest_of_which_no_cam_with_any_train_breaks_a_limit(name):
    best = camopt.optimise(robust_scene(name)).best
    assert is_the_smallest(best)
    assert best["nominal_proved"]
    assert best["safety_mm"] > 1e-3
    assert set(camopt.certify(best.scene).values()) == {"held"}
    nominal = best.scene.replace(**{"cam.base_radius": best["nominal_mm"] * (1.0 + 1e-9)})
    assert "broken" in camopt.certify(nominal).values()
    assert set(camopt.certify(nominal.replace(**{"search.robust": False})).values()) == {"held"}


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("limit", ["joint_force_max_N", "contact_force_min"])
def test_forces_under_a_load_over_the_turn_are_proved_for_all_trains(limit):
    """To 1e-8 of the force of the worst corner, which is computed from its own train."""
    scene = robust_scene("clamp-by-wedge", {"train.1.angle": 0.1, "train.1.mass": 0.1})
    problem, column = resolve_design(scene), "contact_force_min_N" if limit == "contact_force_min" else limit
    forces = [
        camopt.evaluate(scene.replace(**{"train.1.angle": 12 + angle, "train.1.mass": 2 + mass}))[column]
        for angle, mass in itertools.product((-0.1, 0.0, 0.1), repeat=2)
    ]
    side, worst = (-1.0, min(forces)) if limit == "contact_force_min" else (1.0, max(forces))
    assert problem.programme.load.angles
    for share, verdict in ((1e-8, "held"), (-1e-8, "broken")):
        bound = worst * (1.0 + side * share)
        assert camopt.certify(scene.replace(**{f"limits.{limit}": bound}))[limit] == verdict


def test_zero_tolerances_of_links_give_the_nominal_answer_to_the_last_bit():
    scene = robust_scene("slide-by-bell-crank", {"train.1.crank": 0.0, "train.1.coupler": 0.0})
    robust, nominal = (camopt.optimise(each).best for each in (scene, scene.replace(**{"search.robust": False})))
    assert dict(robust) == dict(nominal)
    assert camopt.certify(scene) == camopt.certify(scene.replace(**{"search.robust": False}))


@pytest.mark.long
def test_a_linkage_between_the_corners_that_is_the_worst_has_to_hold_the_limits_too(monkeypatch):
    """The pressure angle is largest where the input arm is 3 deg off, of 6: no corner is as bad."""
    scene = robust_scene("valve-with-rocker", {"train.1.input_angle": 6}, limits={"pressure_angle": 20})
    best = camopt.optimise(scene).best
    assert (best["proved"], best["every_cam"]) == (True, "held")
    assert worst_excess(best.scene) < -1e-4 < worst_excess(best.scene, 25) <= 0.0
    at_corners = best.scene.replace(**{"cam.base_radius": best["base_radius_mm"] - 0.01})
    assert worst_excess(at_corners, 2) < 0.0
    assert camopt.certify(at_corners)["pressure_angle"] == "broken"
    scene = scene.replace(**{"search.base_radius": {"start": 20.37, "stop": 20.39, "step": 0.01}})
    swept = camopt.sweep(scene)  # done again where the proof refutes what the corners hold
    assert (swept.best["poly4567"]["base_radius_mm"], swept.every_cam) == (20.39, {"held": 1})
    monkeypatch.setattr("camopt.solve.front.certified_front.SWEEP_EXCHANGES", 0)
    assert camopt.sweep(scene).every_cam == {"broken": 2, "held": 1}


@pytest.mark.long
def test_the_smallest_robust_cam_comes_with_its_linkage():
    scene = robust_scene("slide-by-bell-crank", {"train.1.crank": 0.1}).replace(
        **{"search.train": {"1": {"crank": {"start": 158, "stop": 162}}}}
    )
    best = camopt.optimise(scene).best
    assert is_the_smallest(best)
    own = scene.replace(**{"search.train": None})
    for crank in (158, 159, 162):
        fixed = camopt.optimise(own.replace(**{"train.1.crank": crank})).best
        assert best["base_radius_mm"] <= fixed["base_radius_mm"] * (1.0 + 1e-9)


@pytest.mark.slow
def test_free_laws_of_the_tool_hold_the_limits_with_every_ratio():
    """The least acceleration within a radius: little more than that of the nominal ratio, proved and scanned."""
    own = {"synthesis.pieces": 8, "synthesis.minimise": "acceleration", "cam.base_radius": 30}
    scene = robust_scene("pusher-by-lever", {"train.1.ratio": 0.1}, **own)
    found, nominal = camopt.synthesise(scene), camopt.synthesise(scene.replace(**{"search.robust": False}))
    assert found.bound <= nominal.objective < found.objective < 1.05 * nominal.objective
    assert (found.design["every_cam"], found.design["base_radius_mm"] <= 30.0, found.convex) == ("held", True, True)
    assert worst_excess(found.scene) <= 0.0 < worst_excess(nominal.scene.replace(**{"search.robust": True}))


def test_convex_steps_look_at_the_motion_of_each_train():
    """What free laws of the tool make of the follower of a train that is off, against the motion of that train."""
    scene = robust_scene("slide-by-bell-crank", {"train.1.crank": 1, "follower.roller_radius": 0.1})
    synthesis_problem = build_synthesis_problem(scene)
    steps = SequentialConvex(solve_free_laws(synthesis_problem)[0], nonconvex_constraints_of(synthesis_problem))
    cams = {id(each.constraints.scene_problem) for each in steps.blocks}
    assert len(cams) == 3  # nominal, and both ends of the crank
    for block in steps.blocks:
        sampled, problem = block.constraints, block.constraints.scene_problem
        motion = synthesis_problem.scene_problem.programme.tool.motion_at(sampled.angles)[:4]
        exact = problem.programme.motion_at(sampled.angles)[:4]
        np.testing.assert_allclose(
            follower_states(problem, synthesis_problem.zero, motion), exact, rtol=0.0, atol=1e-9
        )


LINKS = {
    "slide-by-bell-crank": ["train.1.crank", "train.1.coupler", "train.1.offset", "train.1.angle"],
    "press-ram-by-four-bar": [
        "train.1.coupler",
        "train.1.rocker",
        "train.1.ground",
        "train.2.crank",
        "train.2.angle",
    ],
    "valve-with-rocker": ["train.1.input_arm", "train.1.input_angle", "train.1.output_arm", "train.1.output_angle"],
    "pusher-by-lever": ["train.1.ratio", "train.1.mass", "train.1.spring_rate", "train.1.preload"],
    "clamp-by-wedge": ["train.1.angle", "train.1.mass", "train.1.friction_force"],
}


@pytest.mark.long
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", LINKS)
def test_random_robust_cams_are_the_smallest(name, seed):
    rng, scene = np.random.default_rng(seed), camopt.find_scene(name)
    sizes = ["roller_radius", "arm_length" if scene.follower.arm_length else "offset"]
    keys = [*rng.choice(LINKS[name], 2, replace=False), f"follower.{rng.choice(sizes)}"]
    zones = dict(zip(keys, rng.uniform(0.02, 0.2, 3), strict=True))
    assert is_the_smallest(camopt.optimise(robust_scene(name, zones)).best)
