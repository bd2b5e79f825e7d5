"""A given cam that drives a tool: against closed loops at 50 digits, reflected loads, limits, and dead points."""

from math import inf

import mpmath
import numpy as np
import pytest
from mpmath import mpf
from support.trains import exact

import camopt
from camopt import Scene, certify, evaluate, find_scene
from camopt.mistakes import BadInput
from camopt.motion.driven import travel
from camopt.problem.problem import resolve

ROCKER = {"stage": "rocker", "input_arm": 30, "input_angle": -8, "output_arm": 45, "output_angle": -15}
FOUR_BAR = {"stage": "four-bar", "crank": 60, "coupler": 130, "rocker": 75, "ground": 140, "angle": 70}
SLIDE = {"stage": "slider-crank", "crank": 60, "coupler": 150, "angle": 80}
INCLINE = {"stage": "incline", "angle": 30}
ON_PROFILES = {
    "a valve": ("three-arc-valve", [ROCKER]),
    "a valve on an incline": ("three-arc-valve", [ROCKER, INCLINE]),
    "a roller on lines": ("tangent-cam", [ROCKER]),
    "an eccentric": ("eccentric-rocker", [FOUR_BAR]),
    "an eccentric and a slide": ("eccentric-rocker", [FOUR_BAR, SLIDE]),
    "a motion turned round": ("three-arc-valve", [{"stage": "ratio", "ratio": -1.5}]),
}


def driving(name, train, **more):
    return find_scene(name).replace(train=train, **more)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("name", "train"), ON_PROFILES.values(), ids=ON_PROFILES)
def test_the_tool_goes_where_closed_loops_have_it(name, train):
    """With its first three derivatives, by the chain rule from those of the follower and of the loops."""
    problem = resolve(driving(name, train))
    programme, start = problem.programme, float(problem.programme.at(np.zeros(1))[0, 0])
    stages = [(each["stage"], {"offset": 0.0, "crossed": False, **each}) for each in train]
    stages = [(kind, {key: value for key, value in keys.items() if key != "stage"}) for kind, keys in stages]
    theta = np.random.default_rng(2).uniform(0.0, 2 * np.pi, 25)
    motion, tool = programme.at(theta), programme.tool.at(theta)
    found = []
    with mpmath.workdps(50):
        for y, y1, y2, y3 in motion.T:
            _, f1, f2, f3 = (
                each * mpmath.factorial(k)
                for k, each in enumerate(
                    mpmath.taylor(lambda x: exact(stages, problem.setup.angular, x), mpf(float(y - start)), 3)
                )
            )
            here = exact(stages, problem.setup.angular, mpf(float(y - start)))
            rows = (here, f1 * y1, f1 * y2 + f2 * y1**2, f1 * y3 + 3 * f2 * y1 * y2 + f3 * y1**3)
            found.append([float(each) for each in rows])
    dense = programme.tool.at(np.linspace(0.0, 2 * np.pi, 20001))[0] - programme.tool.at(np.zeros(1))[0, 0]
    assert travel(programme) == pytest.approx((dense.min(), dense.max()), abs=1e-5 * np.ptp(dense))
    known = np.transpose(found)
    known[0] += float(programme.tool.at(np.zeros(1))[0, 0])
    for row, ours in zip(known, tool, strict=True):
        assert ours == pytest.approx(row, abs=1e-11 * max(np.abs(row).max(), 1e-3))


def test_a_constant_ratio_is_a_cam_with_what_it_reflects():
    ratio, tool = 2.0, {"mass": 0.05, "spring_rate": 9.0, "preload": 30.0}
    ours = evaluate(driving("three-arc-valve", [{"stage": "ratio", "ratio": ratio, **tool}], outputs=["all"]))
    own = find_scene("three-arc-valve").follower.dynamics
    dynamics = {
        "mass": own.mass + ratio**2 * tool["mass"],
        "spring_rate": own.spring_rate + ratio**2 * tool["spring_rate"],
        "preload": own.preload + ratio * tool["preload"],
    }
    theirs = evaluate(find_scene("three-arc-valve").replace(**{"follower.dynamics": dynamics, "outputs": ["all"]}))
    assert ours["acceleration_max_m_s2"] == pytest.approx(ratio * theirs["acceleration_max_m_s2"], rel=1e-12)
    assert ours["acceleration_max_follower_m_s2"] == pytest.approx(theirs["acceleration_max_m_s2"], rel=1e-12)
    names = [
        "contact_force_min_N",
        "contact_force_max_N",
        "torque_peak_N_m",
        "normal_force_max_N",
        "jump_speed_rpm",
    ]
    for name in [*names, "torque_rms_N_m", "energy_fluctuation_J", "face_diameter_min_mm", "outer_radius_mm"]:
        assert ours[name] == pytest.approx(theirs[name], rel=1e-10), name


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("name", "train"), ON_PROFILES.values(), ids=ON_PROFILES)
def test_limits_are_decided_next_to_their_bounds(name, train):
    scene = driving(name, train, limits={}, outputs=["all"])
    turns = scene.tool_turns
    names = ["acceleration_max_rad_s2" if turns else "acceleration_max_m_s2"]
    names += ["velocity_max_rad_s" if turns else "velocity_max_m_s"]
    found = evaluate(scene)
    for quantity in names:
        for share in (1.0 + 1e-9, 1.0 - 1e-9):
            limited = scene.replace(**{f"limits.{quantity}": found[quantity] * share})
            assert certify(limited)[quantity] == ("held" if share > 1.0 else "broken")
            assert (evaluate(limited)["violated"] == quantity) == (share < 1.0)


def test_a_load_at_the_tool_comes_to_the_cam_and_is_proved():
    load = {"mass": 0.1, "load": [[0, 10], [100, 200], [300, 20]]}
    scene = driving("three-arc-valve", [{**ROCKER, **load}], outputs=["all"])
    found = evaluate(scene)
    assert (
        found["normal_force_max_N"]
        > evaluate(driving("three-arc-valve", [ROCKER], outputs=["all"]))["normal_force_max_N"]
    )
    for share in (1.0 + 1e-9, 1.0 - 1e-9):
        limited = scene.replace(**{"limits.normal_force": found["normal_force_max_N"] * share})
        assert certify(limited)["normal_force"] == ("held" if share > 1.0 else "broken")


def test_points_have_the_displacement_of_both():
    scene = driving("three-arc-valve", [ROCKER])
    points = camopt.cam_points(scene, np.arange(0.0, 360.0, 5.0))
    tool, follower = points["tool_displacement_mm"], points["displacement_mm"]
    assert follower.max() == pytest.approx(9.0, abs=1e-3)
    assert 1.3 < tool.max() / follower.max() < 1.7
    assert np.argmax(tool) == np.argmax(follower)


def test_linkages_are_swept_under_a_given_cam(tmp_path):
    scene = driving("three-arc-valve", [ROCKER], search={"train": {"1": {"output_arm": [40.0, 45.0, 50.0]}}})
    camopt.sweep(scene, out=tmp_path, keep="all", workers=1)
    designs = camopt.load(tmp_path / "designs.parquet")
    assert len(designs) == 3
    for row in range(3):
        alone = evaluate(camopt.scene_of(designs, row))
        assert designs["acceleration_max_m_s2"][row] == pytest.approx(alone["acceleration_max_m_s2"], rel=1e-9)


def test_a_follower_beyond_a_dead_point_is_told_with_its_angle():
    short = {"stage": "rocker", "input_arm": 9.5, "input_angle": 20, "output_arm": 45}
    with pytest.raises(BadInput) as told:
        driving("three-arc-valve", [short])
    (mistake,) = told.value.mistakes
    assert mistake.key == "train.1"
    assert "the follower goes to 9 mm" in str(mistake)
    assert "deg of the turn" in str(mistake)


def test_a_profile_that_is_none_is_told_once():
    with pytest.raises(BadInput) as told:
        Scene.from_dict(
            {**find_scene("three-arc-valve").to_dict(), "train": [ROCKER], "profile": [{"element": "line"}]}
        )
    assert all(mistake.key.startswith("profile") for mistake in told.value.mistakes)


def test_jerk_jumps_at_the_tool_where_arcs_meet():
    assert evaluate(driving("three-arc-valve", [ROCKER]))["jerk_max_m_s3"] == inf


def test_lifts_measured_at_the_tool_give_the_cam():
    """Within the band at the valve; the tappet by both arms of the rocker, l·(sin(α + φ) − sin α) of one φ."""
    scene = camopt.find_scene("valve-with-rocker")
    angles = np.arange(0.0, 360.0)
    lifts = np.asarray(camopt.cam_points(scene, angles)["tool_displacement_mm"])
    noisy = lifts + np.random.default_rng(3).normal(0.0, 0.003, lifts.size)
    fitted = camopt.fit(np.column_stack([angles, noisy]), scene=scene)
    points = camopt.cam_points(fitted.scene, (angles - fitted.start) % 360.0)
    tool = np.asarray(points["tool_displacement_mm"])
    assert np.abs(tool - (noisy - fitted.zero)).max() <= fitted.band + 1e-6
    phi = np.arcsin(tool / 40.0 + np.sin(np.radians(-18.0))) - np.radians(-18.0)
    tappet = 26.0 * (np.sin(np.radians(-4.0) + phi) - np.sin(np.radians(-4.0)))
    assert points["displacement_mm"] == pytest.approx(tappet - tappet.min(), abs=1e-9)
