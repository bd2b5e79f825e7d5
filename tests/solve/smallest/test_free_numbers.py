"""The smallest cam with numbers of the scene that are free as sizes are, such as the rate of its spring."""

from dataclasses import replace

import numpy as np
import pytest

from camopt import certify, evaluate, evaluate_designs, find_scene, optimise, prices
from camopt.scene.problem.problem import resolve, with_rounding_relative_error
from camopt.scene.problem.settings import problem_with_searched_numbers_per_design
from camopt.solve.smallest.free_variables import FreeVariables
from camopt.solve.smallest.optimise import with_all_sizes

TRAIN = {"mass": 0.8, "spring_rate": 59, "preload": 300}
VALVE = find_scene("exhaust-valve").replace(
    **{
        "cam.rpm": 900,
        "follower.dynamics": TRAIN,
        "materials": {"cam": "steel", "follower": "steel", "face_width": 20},
        "limits": {"pressure_angle": 60, "jump_speed_ratio": 1.2, "contact_stress": 670},
        "search": {"base_radius": {"start": 20, "stop": 120}},
    }
)
"""A weak spring lets go of the cam, and a strong one presses too hard on it."""
SPRING = "follower.dynamics.spring_rate"
SEARCHED = VALVE.replace(**{f"search.{SPRING}": {"start": 1, "stop": 80}})


def size_with(**changes):
    """The smallest cam of given numbers; infinite if there is none."""
    best = optimise(VALVE.replace(**changes)).best
    return np.inf if best is None else best["base_radius_mm"]


@pytest.fixture(scope="module")
def optimum():
    return optimise(SEARCHED)


@pytest.mark.slow
def test_no_given_spring_has_a_smaller_cam(optimum):
    best = optimum.best
    assert best["proved"]
    assert set(best["binding"]) == {
        "jump_speed_ratio",
        "contact_stress",
    }
    rate = best["spring_rate_N_per_mm"]
    assert size_with(**{SPRING: rate}) == pytest.approx(best["base_radius_mm"], rel=1e-8)
    for other in (0.9, 0.99, 1.002, 1.02, 1.2):
        assert size_with(**{SPRING: rate * other}) > best["base_radius_mm"]


def test_the_scene_that_is_found_is_feasible_and_proved(optimum):
    scene = optimum.best.scene
    assert scene.follower.dynamics.spring_rate == optimum.best["spring_rate_N_per_mm"]
    cam = evaluate(scene)
    assert cam["feasible"]
    assert {verdict for limit, verdict in certify(scene).items() if limit != "self_crossing"} <= {"held"}


@pytest.mark.slow
def test_a_bound_costs_what_the_smallest_cams_of_two_bounds_differ_by(optimum):
    """With the spring free, which gives way as well."""
    costs = {price.key: price for price in prices(optimum)[next(iter(optimum.by_law))]}
    price, step = costs["limits.contact_stress"].price, 0.1
    ends = [optimise(SEARCHED.replace(**{"limits.contact_stress": 670 + by})).best for by in (-step, step)]
    low, high = (best["base_radius_mm"] for best in ends)
    assert price == pytest.approx((high - low) / (2 * step), rel=1e-3)


@pytest.mark.one_in(6)
@pytest.mark.parametrize(
    ("key", "ends", "limits"),
    [
        ("cam.rpm", (700, 1100), {"contact_force_min": 50, "contact_stress": 800}),
        ("cam.rpm", (100, 900), {"acceleration": 100}),
        ("follower.dynamics.preload", (0, 600), {"contact_force_min": 80, "contact_stress": 700}),
        ("follower.dynamics.mass", (0.2, 1.0), {"normal_force": 4000, "contact_force_min": 20}),
        ("materials.face_width", (10, 40), {"contact_stress": 600}),
        ("materials.follower_modulus", (100, 210), {"contact_stress": 600}),
    ],
)
def test_a_free_number_makes_no_cam_larger_and_its_own_value_none_smaller(key, ends, limits):
    low, high = ends
    scene = VALVE.replace(limits={"pressure_angle": 60, **limits})
    best = optimise(scene.replace(**{f"search.{key}": {"start": low, "stop": high}}), seconds=20).best
    sizes = []
    for value in np.linspace(low, high, 5):
        fixed = optimise(scene.replace(**{key: float(value)})).best
        sizes.append(np.inf if fixed is None else fixed["base_radius_mm"])
    assert best["base_radius_mm"] <= min(sizes) * (1 + 1e-9)
    assert evaluate(best.scene)["feasible"]


@pytest.mark.slow
def test_springs_in_a_list_are_tried_one_by_one():
    listed = optimise(VALVE.replace(**{f"search.{SPRING}": [55, 59, 64]})).best
    sizes = {rate: size_with(**{SPRING: rate}) for rate in (55, 59, 64)}
    assert listed["base_radius_mm"] == pytest.approx(min(sizes.values()), rel=1e-9)
    assert sizes[listed["spring_rate_N_per_mm"]] == min(sizes.values())


@pytest.mark.long
def test_a_spring_is_found_with_the_angles_of_the_segments():
    """Sizes, numbers and angles are free together."""
    scene = SEARCHED.replace(
        **{"search.angle_rise": {"start": 55, "stop": 65}, "search.angle_return": {"start": 55, "stop": 65}}
    )
    best, fixed = optimise(scene, seconds=20).best, optimise(SEARCHED).best
    assert best["base_radius_mm"] <= fixed["base_radius_mm"] * (1 + 1e-4)  # the search over turns has no proof here
    assert evaluate(best.scene)["feasible"]


def test_a_spring_that_only_the_search_has_is_that_of_the_smallest_cam(optimum):
    """For serve and effects, which show one cam."""
    open_ = SEARCHED.replace(**{SPRING: None})
    assert with_all_sizes(open_).follower.dynamics.spring_rate == pytest.approx(
        optimum.best["spring_rate_N_per_mm"], rel=1e-6
    )
    assert with_all_sizes(VALVE) is VALVE


def test_a_number_below_0_is_taken_as_it_is():
    """The excesses of a cam around itself, against its own scene with that number."""
    loaded = find_scene("roller-1000rpm").replace(
        **{"follower.dynamics": {"mass": 0.5, "preload": 80.0, "load": -25.0}, "limits.normal_force": 900.0},
        search={"follower": {"dynamics": {"load": {"start": -30, "stop": -20}}}, "law": ["cycloidal"]},
    )
    problem = problem_with_searched_numbers_per_design(with_rounding_relative_error(resolve(loaded)))
    cam = replace(problem, design=problem.design.with_values({"follower.dynamics.load": np.array([-25.0])}))
    freedom = FreeVariables.from_problem(cam)
    excesses = freedom.excesses_at_steps(cam.limits, np.zeros((1, freedom.independent_change_directions.shape[1])))[
        :, 0
    ]
    expected = evaluate_designs(loaded, {"base_radius_mm": [loaded.cam.base_radius]})
    assert excesses == pytest.approx([expected[f"excess_{each.name}"][0] for each in cam.limits], rel=1e-9)


def test_a_number_that_does_not_hold_the_size_is_told():
    scene = find_scene("exhaust-valve").replace(
        **{
            "cam.rpm": 300,
            "follower.dynamics": {"mass": 0.5, "preload": 200},
            "limits": {"pressure_angle": 30, "contact_force_min": 10},
            "search": {
                "follower": {
                    "dynamics": {"spring_rate": {"start": 10, "stop": 30}, "preload": {"start": 150, "stop": 300}}
                }
            },
        }
    )
    optimum = optimise(scene)
    idle = "follower.dynamics.preload and follower.dynamics.spring_rate"
    assert any(f"the size does not depend on {idle} here" in each for each in optimum.warnings)


def test_a_number_that_holds_the_size_is_not_told_as_idle(optimum):
    assert "contact_stress" in optimum.best["binding"]
    assert not any("does not depend" in each for each in optimum.warnings)
