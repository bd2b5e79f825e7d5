"""Measured cams against their drawings: cams of known errors, with a follower that is put on them by trial."""

import json
from pathlib import Path

import numpy as np
import pytest
from support.cams import cam_with

import camopt
from camopt.core.mistakes import BadInput
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.solve.tolerances.errors import BORE as BORE_KEY
from camopt.solve.tolerances.errors import BORE_DIRECTION, flat_from_polar_errors
from camopt.solve.tolerances.real_cam import RealCam

SIZE, BORE, WAVE, ORDER, TURNED = 0.004, 0.012 - 0.005j, 0.003, 9, 40.0
GIVEN = {"profile": 0.02, "waves": 12, "bore_eccentricity": 0.02, "phase": 0.1}


def drawn_scene(contact, law="poly345", rotation="ccw"):
    found = cam_with(contact, law, dynamics={}, rotation=rotation)
    return Scene.from_dict(
        {**{key: found[key] for key in ("cam", "follower", "motion")}, "name": contact, "tolerances": GIVEN}
    )


def cut(scene, angles):
    """The profile of a cam that is too large, off its axis and has waves, in the frame of the drawing."""
    points = camopt.cam_points(scene, np.degrees(angles))
    profile = points["profile_x_mm"] + 1j * points["profile_y_mm"]
    normal = points["profile_normal_x"] + 1j * points["profile_normal_y"]
    return profile + (SIZE + WAVE * np.cos(ORDER * angles + 1.0)) * normal + BORE


def measured_profile(scene, turned=TURNED, noise=0.0002):
    angles = np.radians(np.arange(0.0, 360.0, 0.5))
    return with_noise(cut(scene, angles) * np.exp(1j * np.radians(turned)), noise)


def with_noise(points, noise=0.0002):
    rng = np.random.default_rng(6)
    points = points + noise * (rng.normal(size=points.size) + 1j * rng.normal(size=points.size))
    return camopt.MeasuredProfile(np.column_stack([points.real, points.imag]), "xy")


def highest(scene, profile, theta, sense):
    """The displacement of a follower that rests on a dense profile, by trying where it is as high as it can be."""
    seen, follower = profile * np.exp(1j * sense * theta), scene.follower
    base = scene.cam.base_radius
    if follower.contact == "flat":
        return seen.imag.max() - base
    offset, radius = follower.offset or 0.0, follower.roller_radius
    off = seen.real - offset
    near = np.abs(off) < radius
    start = np.sqrt((base + radius) ** 2 - offset**2)
    return (seen.imag[near] + np.sqrt(radius**2 - off[near] ** 2)).max() - start


@pytest.mark.slow
@pytest.mark.parametrize(("contact", "rotation"), [("offset-roller", "cw"), ("flat", "ccw"), ("roller", "ccw")])
def test_the_error_of_a_cut_cam_is_that_of_a_follower_put_on_it(contact, rotation):
    scene = drawn_scene(contact, rotation=rotation)
    found = camopt.inspect(measured_profile(scene), scene)
    problem = resolve_design(scene)
    sense, dense = problem.design.sense, cut(scene, np.linspace(0.0, 2 * np.pi, 60_001))
    phase = _phase_beyond_turn(found, sense)
    assert abs(phase) < 1e-3
    for theta in np.linspace(0.2, 6.0, 12):
        exact = highest(scene, dense, theta - phase, sense) - problem.programme.motion_at(np.array([theta]))[0, 0]
        near = np.interp(np.degrees(theta), *_sort_by_angle(found.angles, found.errors), period=360.0)
        assert near == pytest.approx(exact, abs=3e-4)
    assert found.noise == pytest.approx(0.0002, rel=0.15)
    assert found.size == pytest.approx(SIZE, abs=1e-4)
    assert abs(complex(*found.eccentricity) - BORE) < 3e-4
    assert found.waves[0].number in (ORDER - 1, ORDER, ORDER + 1)
    assert found.waves[0].amplitude == pytest.approx(WAVE, rel=0.25)
    assert found.within
    assert [each.key for each in found.used] == ["profile", "waves", "bore_eccentricity", "motion"]


def _phase_beyond_turn(found, sense):
    """By how much it fits best beyond the turn of its points, rad."""
    return np.radians((found.phase_deg - sense * TURNED + 180.0) % 360.0 - 180.0)


def _sort_by_angle(angles, errors):
    order = np.argsort(angles)
    return angles[order], errors[order]


@pytest.mark.parametrize("contact", ["arm", "swinging-face"])
def test_a_cam_that_is_off_its_axis_moves_an_arm_as_exact_contact_says(contact):
    """With the phase that its keyway has; the axis is off in the frame of the drawing."""
    scene, bore, ahead = drawn_scene(contact), 0.015 + 0.004j, 0.04
    problem, angles = resolve_design(scene), np.radians(np.arange(0.0, 360.0, 0.5))
    points = camopt.cam_points(scene, np.degrees(angles))
    cam = (points["profile_x_mm"] + 1j * points["profile_y_mm"] + bore) * np.exp(1j * np.radians(ahead))
    found = camopt.inspect(camopt.MeasuredProfile(np.column_stack([cam.real, cam.imag]), "xy"), scene, aligned=True)
    ways = np.angle(bore) + problem.design.sense * angles
    errors = {BORE_KEY: np.full(angles.size, abs(bore)), BORE_DIRECTION: ways, "phase": np.radians(ahead)}
    exact = RealCam(problem).tool_error_at_contact(flat_from_polar_errors(errors), angles)
    largest = np.degrees(np.abs(exact.error).max())
    assert abs(found.error) == pytest.approx(largest, rel=2e-3)
    assert found.phase_deg == pytest.approx(ahead, abs=2e-3)
    assert abs(complex(*found.eccentricity) - bore) < 3e-4
    used = {each.key: each for each in found.used}
    assert used["phase"].share == pytest.approx(0.4, abs=0.03)
    assert used["motion"].allowed > used["motion"].found
    assert used["motion"].moves == found.error


ROLLER = drawn_scene("offset-roller")
ANGLES = np.radians(np.arange(0.0, 360.0, 0.5))


def points_off_profile(off, keep=slice(None)):
    """Points of a profile that stands out along its normal, mm, at ANGLES."""
    points = camopt.cam_points(ROLLER, np.degrees(ANGLES))
    profile = points["profile_x_mm"] + 1j * points["profile_y_mm"]
    normal = points["profile_normal_x"] + 1j * points["profile_normal_y"]
    return with_noise((profile + normal * off)[keep])


@pytest.mark.slow
@pytest.mark.parametrize("gap", [slice(0), slice(599, 720), slice(60, 100)], ids=["none", "dwell", "rise"])
def test_waves_count_by_how_steep_and_curved_they_are(gap):
    """A gap leaves them as they are; its ends are told."""
    keep, scene = np.delete(np.arange(ANGLES.size), gap), ROLLER.replace(**{"tolerances.waves": 5})
    for number, height in ((30, 0.0003), (45, 0.0005)):
        found = camopt.inspect(points_off_profile(height * np.cos(number * ANGLES), keep), scene)
        assert found.waves[0].number == number
        assert found.waves[0].amplitude == pytest.approx(height, rel=0.1)
        (waves,) = (each for each in found.used if each.key == "waves")
        assert waves.found == pytest.approx(number * np.sqrt(height / GIVEN["profile"]), rel=0.1)
        assert (found.within, waves.share <= 1.0) == (number == 30, number == 30)
        missing = [*np.degrees(ANGLES[gap])]
        ends = [(missing[0] - 0.5, (missing[-1] + 0.5) % 360.0)] if missing else []
        assert np.allclose(np.exp(1j * np.radians(np.ravel(found.gaps) - np.ravel(ends))), 1.0, atol=0.01)
        assert ("where points are" in found.table().note) == bool(missing and found.within)


@pytest.mark.parametrize("keep_outliers", [False, True])
def test_a_dent_is_told_by_its_row_and_is_beyond_the_profile(keep_outliers):
    points = points_off_profile(np.where(np.arange(ANGLES.size) == 100, -0.2, 0.0))
    found = camopt.inspect(points, ROLLER, keep_outliers=keep_outliers)
    assert [each.row for each in found.outliers] == [101]
    assert found.outliers[0].off == pytest.approx(-0.2, abs=0.002)
    assert found.used[0].share == pytest.approx(10.0, rel=0.02)
    assert not found.within
    assert "row 101 by -0.2" in found.table().note


def test_the_first_point_may_stand_again_as_the_last():
    """But for what rounding makes of its angle."""
    cam = cut(ROLLER, np.append(ANGLES, 2 * np.pi)) * np.exp(1j * np.radians(0.01))
    with np.errstate(all="raise"):
        found = camopt.inspect(camopt.MeasuredProfile(np.column_stack([cam.real, cam.imag]), "xy"), ROLLER)
    assert found.outliers == ()
    assert found.size == pytest.approx(SIZE, abs=1e-5)


@pytest.mark.slow
def test_a_cam_that_is_none_of_the_drawing_and_a_phase_are_told():
    behind = cut(ROLLER, ANGLES) * np.exp(-1j * np.radians(0.05))
    aligned = camopt.inspect(
        with_noise(behind), ROLLER.replace(**{"tolerances.follower.offset": 0.02}), aligned=True
    )
    assert "behind the angles of the points by 0.0" in aligned.table().note
    assert aligned.not_counted == ("follower.offset",)
    phase = {each.key: each for each in aligned.used}["phase"]
    slope = resolve_design(ROLLER).programme.motion_at(np.radians([aligned.at_deg]))[1, 0]
    assert phase.moves == pytest.approx(np.radians(aligned.phase_deg) * slope, rel=0.01)
    mirrored = camopt.inspect(with_noise(behind.conj()), ROLLER)
    assert (aligned.far, mirrored.far) == (False, True)
    assert "but its mirrored points (x to -x) fit" in mirrored.table().note
    circle = camopt.inspect(with_noise(30.0 * np.exp(1j * ANGLES)), ROLLER)
    assert "does not match this drawing: check rotation" in circle.table().note


def test_the_command_refuses_what_does_not_go_with_points(command, tmp_path):
    given = ["tolerance", "bucket-valve", "--measured", "cut.csv", "--profile", "xy"]
    for others in (("--plot", "a.png"), ("--out", tmp_path), ("--cams", 9), ("--seed", 1), ("--allocate", 1)):
        code, out, err = command(*given, *others)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert f"{others[0]} = " in err
        assert "cannot be used with --measured" in err
    assert "--costs = 'a.csv'" in command(*given, "--costs", "a.csv")[2]
    table = camopt.cam_points(ROLLER, np.degrees(ANGLES))
    file, scene = tmp_path / "own.csv", tmp_path / "own.toml"
    names = ["cam_angle_deg", "profile_x_mm", "profile_y_mm"]
    np.savetxt(
        file, np.column_stack([table[name] for name in names]), delimiter=",", header=",".join(names), comments=""
    )
    scene.write_text(ROLLER.to_toml())
    asked = ["tolerance", scene, "--measured", file, "--profile", "xy"]
    assert command(*asked)[0] == 2
    assert "Within all tolerances" in command(*asked, "--columns", "profile_x_mm,profile_y_mm")[1]


def test_the_command_tells_which_tolerance_a_worn_cam_exceeds(command):
    folder = Path(__file__).parents[2] / "data" / "measured"
    given = ["tolerance", folder / "cam-as-drawn.toml", "--measured", folder / "worn-cam.csv", "--probe", "3"]
    given += ["--set", "tolerances.profile=0.02", "--set", "tolerances.bore_eccentricity=0.01"]
    code, out, _ = command(*given, "--profile", "xy")
    assert (code, "Beyond a tolerance" in out, "worn-cam.csv against Worn cam" in out) == (0, True, True)
    found = json.loads(command(*given, "--profile", "xy", "--json")[1])
    assert found["error"] == pytest.approx(-0.049, abs=0.002)  # up to 0.05 mm of its rising flank is lost
    assert 0 < found["at_deg"] < 80
    assert {each["key"]: each["share"] > 1 for each in found["used"] if each["allowed"]} == {
        "profile": True,
        "bore_eccentricity": False,
        "motion": True,
    }
    code, out, err = command(*given)
    assert (code, out) == (2, "")
    assert "missing: polar or xy" in err
    assert command("tolerance", "bucket-valve", "--probe", "3")[0] == 2


def test_what_is_no_drawing_of_a_disc_is_refused():
    tables = cam_with("groove", dynamics={})
    scene = Scene.from_dict({"name": "groove", **{key: tables[key] for key in ("cam", "follower", "motion")}})
    with pytest.raises(BadInput, match="a measured profile needs a disc cam"):
        camopt.inspect(camopt.MeasuredProfile(np.ones((20, 2)), "xy"), scene)
