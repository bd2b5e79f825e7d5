"""A given cam that drives a tool: against closed loops at 50 digits, reflected loads, limits, and dead points."""

from math import inf

import mpmath
import numpy as np
import pytest
from mpmath import mpf
from support.trains import exact

import camopt
from camopt import Scene, certify, evaluate, find_scene
from camopt.core.mistakes import BadInput
from camopt.model.motion.tool_drive import tool_travel_range
from camopt.scene.problem.problem import resolve

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
AT_FOLLOWER = {
    "a rocker": ("valve-with-rocker", [ROCKER]),
    "positions": ("feeder-with-stop", [{**ROCKER, "input_arm": 100, "output_arm": 150}]),
    "an arm": ("oscillating-roller", [FOUR_BAR, SLIDE]),
}
GIVEN = ON_PROFILES | AT_FOLLOWER


def scene_with_train(name, train, **more):
    """With a turn of positions that starts above 0, where its train starts."""
    scene = find_scene(name)
    scene = scene.replace(**{"cam.rpm": scene.cam.rpm or 300})
    rows = scene.to_dict().get("motion", [])
    turned = {"motion": [*rows[1:], rows[0]]} if name == "feeder-with-stop" else {}
    at_follower = {} if scene.profile else {"motion_at": "follower"}
    return scene.replace(train=train, **turned, **at_follower, **more)


@pytest.mark.one_in(9)
@pytest.mark.parametrize(("name", "train"), GIVEN.values(), ids=GIVEN)
def test_the_tool_goes_where_closed_loops_have_it(name, train):
    """With its first three derivatives, by the chain rule from those of the follower and of the loops."""
    problem = resolve(scene_with_train(name, train))
    programme = problem.programme
    start = float(programme.motion_at(np.zeros(1))[0, 0]) if problem.profile else 0.0
    stages = [(each["stage"], {"offset": 0.0, "crossed": False, **each}) for each in train]
    stages = [(kind, {key: value for key, value in keys.items() if key != "stage"}) for kind, keys in stages]
    theta = np.random.default_rng(2).uniform(0.0, 2 * np.pi, 25)
    motion, tool = programme.motion_at(theta), programme.tool.motion_at(theta)
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
    dense = programme.tool.motion_at(np.linspace(0.0, 2 * np.pi, 20001))[0]
    assert np.ptp(tool_travel_range(programme)) == pytest.approx(np.ptp(dense), rel=1e-5)
    known = np.transpose(found)
    known[0] -= tool_travel_range(programme)[0]
    for row, ours in zip(known, tool, strict=True):
        assert ours == pytest.approx(row, abs=1e-11 * max(np.abs(row).max(), 1e-3))


def test_a_constant_ratio_is_a_cam_with_what_it_reflects():
    ratio, tool = 2.0, {"mass": 0.05, "spring_rate": 9.0, "preload": 30.0}
    ours = evaluate(
        scene_with_train("three-arc-valve", [{"stage": "ratio", "ratio": ratio, **tool}], outputs=["all"])
    )
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
@pytest.mark.parametrize(("name", "train"), GIVEN.values(), ids=GIVEN)
def test_limits_are_decided_next_to_their_bounds(name, train):
    scene = scene_with_train(name, train, limits={}, outputs=["all"])
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
    scene = scene_with_train("three-arc-valve", [{**ROCKER, **load}], outputs=["all"])
    found = evaluate(scene)
    assert (
        found["normal_force_max_N"]
        > evaluate(scene_with_train("three-arc-valve", [ROCKER], outputs=["all"]))["normal_force_max_N"]
    )
    for share in (1.0 + 1e-9, 1.0 - 1e-9):
        limited = scene.replace(**{"limits.normal_force": found["normal_force_max_N"] * share})
        assert certify(limited)["normal_force"] == ("held" if share > 1.0 else "broken")


def test_the_cam_is_that_of_the_follower_alone():
    """Whatever its train: every curve is that of the scene without it; conditions of its moves are proved."""
    scene = scene_with_train("rocker-valve", [FOUR_BAR], limits={})
    alone = find_scene("rocker-valve").replace(limits={})
    ours, theirs = evaluate(scene), evaluate(alone)
    for name in ("pressure_angle_max_deg", "pitch_curvature_max_per_mm", "cutter_radius_max_mm"):
        assert ours[name] == pytest.approx(theirs[name], rel=1e-12)
    assert ours["acceleration_max_follower_rad_s2"] == pytest.approx(theirs["acceleration_max_rad_s2"], rel=1e-12)
    assert certify(scene)["conditions"] == certify(alone)["conditions"] == "held"


def test_a_cam_with_its_train_in_ranges_is_proved_by_what_the_tool_does_not_enter():
    arm = {"base_radius": {"start": 10, "stop": 60}, "train": {"1": {"output_arm": {"start": 30, "stop": 40}}}}
    scene = scene_with_train(
        "valve-with-rocker", [ROCKER], limits={"pressure_angle": 25, "velocity": 2.5}, search=arm
    )
    best = camopt.optimise(scene).best
    size = {"base_radius": arm["base_radius"]}
    alone = camopt.optimise(scene.replace(train=[], search=size, limits={"pressure_angle": 25})).best
    assert best["proved"]
    assert best["base_radius_mm"] == pytest.approx(alone["base_radius_mm"], rel=1e-9)
    assert best["velocity_max_m_s"] <= 2.5


def test_free_laws_are_not_sought_of_a_follower_behind_a_train():
    with pytest.raises(BadInput, match="motion_at"):
        camopt.synthesise(scene_with_train("valve-with-rocker", [ROCKER]))


def test_points_have_the_displacement_of_both():
    scene = scene_with_train("three-arc-valve", [ROCKER])
    points = camopt.cam_points(scene, np.arange(0.0, 360.0, 5.0))
    tool, follower = points["tool_displacement_mm"], points["displacement_mm"]
    assert follower.max() == pytest.approx(9.0, abs=1e-3)
    assert 1.3 < tool.max() / follower.max() < 1.7
    assert np.argmax(tool) == np.argmax(follower)


def test_linkages_are_swept_under_a_given_cam(tmp_path):
    scene = scene_with_train(
        "three-arc-valve", [ROCKER], search={"train": {"1": {"output_arm": [40.0, 45.0, 50.0]}}}
    )
    camopt.sweep(scene, out=tmp_path, keep="all", workers=1)
    designs = camopt.load(tmp_path / "designs.parquet")
    assert len(designs) == 3
    for row in range(3):
        alone = evaluate(camopt.scene_of(designs, row))
        assert designs["acceleration_max_m_s2"][row] == pytest.approx(alone["acceleration_max_m_s2"], rel=1e-9)


def test_a_follower_beyond_a_dead_point_is_told_with_its_angle():
    short = {"stage": "rocker", "input_arm": 9.5, "input_angle": 20, "output_arm": 45}
    with pytest.raises(BadInput) as told:
        scene_with_train("three-arc-valve", [short])
    (mistake,) = told.value.mistakes
    assert mistake.key == "train.1"
    assert "the follower has to go to 9 mm" in str(mistake)
    assert "(cam angle " in str(mistake)


def test_a_profile_that_is_none_is_told_once():
    with pytest.raises(BadInput) as told:
        Scene.from_dict(
            {**find_scene("three-arc-valve").to_dict(), "train": [ROCKER], "profile": [{"element": "line"}]}
        )
    assert all(mistake.key.startswith("profile") for mistake in told.value.mistakes)


def test_jerk_jumps_at_the_tool_where_arcs_meet():
    assert evaluate(scene_with_train("three-arc-valve", [ROCKER]))["jerk_max_m_s3"] == inf


def tappet_of(valve):
    """The lift of the tappet of ``valve-with-rocker``, by both arms, l·(sin(α + φ) − sin α) of one φ."""
    phi = np.arcsin(valve / 40.0 + np.sin(np.radians(-18.0))) - np.radians(-18.0)
    return 26.0 * (np.sin(np.radians(-4.0) + phi) - np.sin(np.radians(-4.0)))


ANGLES = np.arange(0.0, 360.0)


@pytest.fixture(scope="module")
def overhead():
    """A valve's scene, its points, and errors of 3 µm."""
    scene = camopt.find_scene("valve-with-rocker")
    return scene, camopt.cam_points(scene, ANGLES), np.random.default_rng(3).normal(0.0, 0.003, ANGLES.size)


def test_lifts_measured_at_the_tool_give_the_cam(overhead):
    """Within the band at the valve."""
    scene, points, errors = overhead
    noisy = np.asarray(points["tool_displacement_mm"]) + errors
    fitted = camopt.fit(np.column_stack([ANGLES, noisy]), scene=scene)
    points = camopt.cam_points(fitted.scene, (ANGLES - fitted.start) % 360.0)
    tool = np.asarray(points["tool_displacement_mm"])
    assert np.abs(tool - (noisy - fitted.zero)).max() <= fitted.band + 1e-6
    assert points["displacement_mm"] == pytest.approx(tappet_of(tool) - tappet_of(tool).min(), abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("measured", ["lift", "profile"])
def test_what_is_measured_at_the_cam_gives_the_motion_of_the_tool(overhead, measured):
    """The follower within the band, and the valve where both arms have it."""
    scene, points, errors = overhead
    if measured == "lift":
        given = np.column_stack([ANGLES, points["displacement_mm"] + errors])
        scene = scene.replace(motion_at="follower")
    else:
        along = np.column_stack([points["profile_normal_x"], points["profile_normal_y"]])
        profile = np.column_stack([points["profile_x_mm"], points["profile_y_mm"]]) + errors[:, None] * along
        given = camopt.MeasuredProfile(profile, "xy")
    fitted = camopt.fit(given, scene=scene)
    assert fitted.scene.motion_at == "follower"
    assert fitted.deviation.held
    assert "jerk_max_follower_m_s3" in fitted.to_dict()["after"]
    found = camopt.cam_points(fitted.scene, (ANGLES - fitted.start) % 360.0)
    assert found["displacement_mm"] == pytest.approx(tappet_of(found["tool_displacement_mm"]), abs=1e-9)
    off = np.asarray(found["tool_displacement_mm"]) - np.asarray(points["tool_displacement_mm"])
    assert np.abs(off - off[-1]).max() <= 1.05 * 40.0 / 26.0 * (fitted.band + np.abs(errors).max())
