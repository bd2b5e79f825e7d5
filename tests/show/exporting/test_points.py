"""Points of a cam: how close they are, and the loads along the turn."""

import numpy as np
import pytest

import camopt
from camopt import BadInput, cam_points, evaluate, find_scene
from camopt.cli.main import main
from camopt.show.exporting.cam_points import load_column_name

LOADED = {
    "cam.rpm": 300,
    "follower.dynamics": {"mass": 1.5, "spring_rate": 15, "preload": 250, "natural_frequency": 152,
                          "friction": 0.1, "guide_length": 90, "overhang": 80, "stem_diameter": 16},
    "materials": {"cam": "steel", "follower": "steel", "face_width": 10, "wear_rate": 1e-10, "viscosity": 0.02,
                  "pressure_viscosity": 18, "roughness": 0.3},
    "outputs": "all",
}  # fmt: skip


def distance(points, corners):
    """From each point to the nearest place of a polyline, by every one of its sides."""
    first, along = corners[:-1], np.diff(corners)
    share = ((points[:, None] - first) * along.conjugate()).real / np.abs(along) ** 2
    return np.abs(points[:, None] - first - np.clip(share, 0.0, 1.0) * along).min(axis=1)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", ["two-pauses", "flat-reciprocating"])
@pytest.mark.parametrize("chord", [0.5, 0.01])
def test_straight_lines_stay_within_the_chord(name, chord):
    scene = find_scene(name)
    cutter = None if name.startswith("flat") else 5.0
    found, dense = (
        cam_points(scene, a, cutter_radius=cutter, chord=c)
        for a, c in ((None, chord), (np.arange(0, 360, 0.1), None))
    )
    assert found["cam_angle_deg"][[0, -1]].tolist() == [0.0, 360.0]
    curves = {name.removesuffix("_x_mm") for name in found if name.endswith("_x_mm")}
    assert "profile" in curves
    for curve in curves:
        corners, points = (p[f"{curve}_x_mm"] + 1j * p[f"{curve}_y_mm"] for p in (found, dense))
        corners = corners[np.append(True, np.abs(np.diff(corners)) > 0.0)]
        assert 0.02 * chord < distance(points, corners).max() <= chord
    assert found["cam_angle_deg"].size < 40 / chord**0.5


def test_the_polar_radius_of_the_rollers_centre_is_that_of_the_textbook():
    scene = find_scene("two-pauses").replace(**{"follower.offset": 4.0})
    found, design = cam_points(scene, cutter_radius=5.0), evaluate(scene)
    prime = design["prime_radius_mm"]
    expected = np.hypot(4.0, np.sqrt(prime**2 - 16.0) + found["displacement_mm"])
    np.testing.assert_allclose(found["pitch_radius_mm"], expected, rtol=1e-13)
    assert found["cutter_radius_mm"][0] == pytest.approx(prime - scene.follower.roller_radius + 5.0, rel=1e-13)


def test_a_velocity_that_jumps_does_not_halve_for_ever():
    assert cam_points(find_scene("uniform-knife-offset"), chord=0.1)["cam_angle_deg"].size < 2000


@pytest.mark.parametrize(("step", "count"), [(1, 361), (0.1, 3601), (7, 53), (360, 2), (1 / 3, 1081)])
def test_even_steps_end_with_the_turn(step, count):
    angles = cam_points(find_scene("two-pauses"), step=step)["cam_angle_deg"]
    assert (angles.size, angles[0], angles[-1]) == (count, 0.0, 360.0)
    assert np.allclose(np.diff(angles)[:-1], step, rtol=1e-9)
    assert 0.0 < angles[-1] - angles[-2] <= step * (1 + 1e-9)


@pytest.mark.parametrize(("given", "message"), [
    ({"step": 0}, "camopt: step = 0: must be from 0.00036 to 360 deg"),
    ({"step": float("nan")}, "camopt: step = nan: must be"),
    ({"step": "x"}, "camopt: step = 'x': must be from"),
    ({"chord": "x"}, "camopt: chord = 'x': must be above 0 mm"),
    ({"chord": -1}, "camopt: chord = -1: must be above 0 mm"),
    ({"chord": 1e-12}, "camopt: chord = 1e-12: must be larger: this chord needs more than 1,000,000 points"),
    ({"chord": 1, "step": 1}, "camopt: chord = 1: give one of step, chord, not several"),
    ({"cutter_radius": -1}, "camopt: cutter_radius = -1: must be above 0"),
    ({"angles": [400]}, "camopt: angles = 400.0: must be from 0 to 360 deg"),
])  # fmt: skip
def test_python_is_answered_in_python(given, message):
    with pytest.raises(BadInput) as error:
        cam_points(find_scene("two-pauses"), **given)
    assert str(error.value).startswith(message)


def test_loads_along_the_turn_reach_their_extremes():
    motion = find_scene("two-pauses").to_dict()["motion"]
    smooth = [{**segment, "law": "cycloidal"} if "law" in segment else segment for segment in motion]
    scene = find_scene("two-pauses").replace(**LOADED, motion=smooth)  # no peak just before a jump
    found, cam = cam_points(scene, step=0.1), evaluate(scene)
    loads = {
        n for n in cam if isinstance(cam[n], float) and load_column_name(n) in found and n != load_column_name(n)
    }
    every = ["contact_force_max_N", "torque_min_N_m", "normal_force_max_N", "side_thrust_max_N", "film_ratio_min"]
    every += ["guide_reaction_max_N", "stem_bending_stress_max_MPa", "contact_stress_max_MPa", "overshoot_max_mm"]
    every += ["roller_speed_max_rpm", "contact_force_elastic_min_N", "acceleration_elastic_max_m_s2"]
    assert {*every} <= loads
    for name in loads:
        column = found[load_column_name(name)]
        signed = name.startswith(("contact_force", "torque", "film"))
        largest = column if signed else np.abs(column)
        assert (largest.min() if "_min" in name else largest.max()) == pytest.approx(cam[name], rel=1e-3), name


@pytest.mark.parametrize("name", ["two-pauses", "oscillating-roller", "slide-by-bell-crank"])
def test_velocity_acceleration_and_jerk_are_differences_of_each_other(name):
    scene = find_scene(name)
    angles = np.arange(40.0, 41.0, 0.05)
    found, time = cam_points(scene, angles), angles / (6.0 * scene.cam.rpm) if scene.cam.rpm else np.radians(angles)
    whole = {"mm": 1e-3, "deg": np.pi / 180} if scene.cam.rpm else {"mm": 1.0, "deg": 1.0}
    for ending, displacement in (("", "tool_displacement"), ("_follower", "displacement")):
        first = next((n for n in found if n.startswith(f"{displacement}_")), None)
        if first is None:
            continue
        value = found[first] * whole[first.removeprefix(f"{displacement}_")]
        whose = ending if any(n.startswith("tool_") for n in found) else ""
        for derivative in ("velocity", "acceleration", "jerk"):
            own = [n for n in found if n.startswith(f"{derivative}{whose}_") and (whose or "follower" not in n)]
            (column,) = [n for n in own if "elastic" not in n]
            slopes = np.gradient(value, time)
            assert found[column][1:-1] == pytest.approx(slopes[1:-1], rel=1e-3, abs=2e-3 * np.abs(slopes).max())
            value = found[column]


def test_loads_are_those_of_the_effects_that_run():
    scene = find_scene("two-pauses").replace(**{**LOADED, "outputs": ["force"]})
    angles = [350, 0, 90, 90, 17.5, 360]
    found = cam_points(scene, angles)
    assert [n for n in found if not n.startswith(("profile", "pitch"))] == [
        "cam_angle_deg", "displacement_mm", "velocity_m_s", "acceleration_m_s2", "jerk_m_s3", "contact_force_N",
    ]  # fmt: skip
    in_order = cam_points(scene, sorted(angles))
    assert found["contact_force_N"].tolist() == in_order["contact_force_N"][[4, 0, 2, 3, 1, 5]].tolist()
    plain = cam_points(find_scene("two-pauses"))
    assert not [name for name in plain if "force" in name]


@pytest.mark.slow
@pytest.mark.parametrize("law", ["parabolic", "cycloidal"])
@pytest.mark.parametrize("offset", [-11.3, 7.9])
def test_a_load_that_jumps_has_its_larger_value_and_no_point_exceeds_the_extreme(law, offset):
    """At the ends of strokes with friction in the guide, and where the acceleration jumps; 0 deg is 360 deg."""
    guide = {"guide_length": 41.3, "overhang": 88.7, "friction": 0.117, "stem_diameter": 14.0}
    dynamics = {"mass": 0.53, "spring_rate": 19.3, "preload": 411.0, **guide}
    steel = {"cam": "steel", "follower": "steel", "face_width": 8.3}
    scene = find_scene("roller-1000rpm").replace(
        **{"cam.rpm": 287.0, "follower.offset": offset, "follower.dynamics": dynamics, "materials": steel},
        **{f"motion.{number}.law": law for number in (1, 3)},
        outputs=["force", "thrust", "torque", "hertz"],
    )
    starts = np.cumsum([0.0, *(each.angle for each in scene.motion)])
    ends = np.unique([*starts, *((starts[:-1] + starts[1:]) / 2)])
    at, near = cam_points(scene, ends), cam_points(scene, np.sort([*(ends[1:] - 1e-6), *(ends[:-1] + 1e-6)]))
    values, jumps = evaluate(scene), 0
    for column in sorted(
        {load_column_name(name) for name in values if name.endswith(("_N", "_MPa", "_N_m"))} & at.keys()
    ):
        sides = np.roll(near[column], 1).reshape(-1, 2)  # before and after each end, from 0 deg
        larger = np.take_along_axis(sides, np.abs(sides).argmax(axis=1)[:, None], axis=1)[:, 0]
        assert at[column][:-1] == pytest.approx(larger, rel=1e-5, abs=1e-5)
        assert at[column][0] == at[column][-1]
        jumps += np.count_nonzero(np.abs(np.diff(sides)) > 1e-3 * np.abs(sides).max())
        most = max(abs(value) for name, value in values.items() if load_column_name(name) == column)
        whole = cam_points(scene, np.unique([*ends, *np.linspace(0.0, 360.0, 3601)]))[column]
        assert np.abs(whole).max() == pytest.approx(most, rel=1e-4)
        assert np.abs(whole).max() <= most * (1.0 + 1e-12)
    assert jumps > 5


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_the_command_spaces_and_loads_its_points(capsys, tmp_path, monkeypatch, suffix):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(find_scene("two-pauses").replace(**LOADED).to_toml(), encoding="utf-8")
    assert main(["evaluate", "mine.toml", "--points", f"p.{suffix}", "--chord", "0.01", "--quiet"]) == 0
    if suffix == "parquet":
        table = camopt.load("p.parquet")
        assert table.attrs["units"]["contact_stress_MPa"] == "MPa"
        assert len(table) == cam_points(find_scene("two-pauses"), chord=0.01)["cam_angle_deg"].size
    capsys.readouterr()
    for options, message in (
        (["--step", "1"], "camopt: --step = 1.0: needs --points"),
        (["--points", f"p.{suffix}", "--step", "-1"], "camopt: --step = -1.0: must be from 0.00036 to 360 deg"),
        (["--points", f"p.{suffix}", "--cutter-radius", "0"], "camopt: --cutter-radius = 0.0: must be above 0"),
    ):
        assert main(["evaluate", "mine.toml", *options]) == 2
        told = [line for line in capsys.readouterr().err.splitlines() if "compiling" not in line]
        assert told[0].startswith(message)
