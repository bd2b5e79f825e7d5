"""Measured profiles: the lift of each follower is found again, the points it cannot reach are named."""

import json
import re
from functools import cache
from itertools import combinations, product
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree
from support.depth import covering_cases, times
from support.measured_cams import (
    BASE,
    LEAST,
    OFFSET,
    ROLLER,
    STROKE,
    WEAR,
    along_the_profile,
    at_polar_angles,
    probe_centres,
    touched_lift,
    valve_lift,
    valve_profile,
    worn_profile,
    xy,
)

import camopt
from camopt import BadInput, MeasuredProfile, Scene, Unmet
from camopt.cli.main import main
from camopt.model.mechanisms.geometry import cam_curves
from camopt.scene.problem.problem import resolve
from camopt.solve.measured.columns import POLAR_TABLE, XY_TABLE, TableReadingOptions
from camopt.solve.measured.fit import fit
from camopt.solve.measured.measured_points import read_points
from camopt.solve.measured.noise import estimate_point_errors, noise_band_factor
from camopt.solve.measured.profile import base_radius_at, contacts_at_points

DATA = Path(__file__).parents[2] / "data" / "measured"
FOLLOWERS = {
    "knife": {"motion": "translating", "contact": "knife", "offset": -4.0},
    "roller": {"motion": "translating", "contact": "roller", "roller_radius": 6.0, "offset": 5.0},
    "spherical": {"motion": "translating", "contact": "spherical", "face_radius": 40.0},
    "flat": {"motion": "translating", "contact": "flat"},
    "arm": {"motion": "oscillating", "contact": "roller", "roller_radius": 8.0, "arm_length": 70.0, "centre_distance": 80.0},
    "flat arm": {"motion": "oscillating", "contact": "flat", "centre_distance": 80.0, "face_offset": 5.0},
}  # fmt: skip
LOBE = [
    {"segment": "dwell", "angle": 60.0},
    {"segment": "rise", "angle": 80.0, "lift": 8.0, "law": "poly4567"},
    {"segment": "return", "angle": 100.0, "lift": 8.0, "law": "poly4567"},
    {"segment": "dwell", "angle": 120.0},
]
SENSES = {"ccw": 1.0, "cw": -1.0}
EVERY = list(product(FOLLOWERS, SENSES))
FLAT, WORN = (
    FOLLOWERS["flat"],
    {"motion": "translating", "contact": "roller", "roller_radius": ROLLER, "offset": OFFSET},
)


def cam_of(follower, rotation="ccw", **more):
    follower = FOLLOWERS[follower] if isinstance(follower, str) else follower
    return {"cam": {"form": "disc", "rotation": rotation, **more}, "follower": follower}


def scene_of(follower, rotation="ccw", base=60.0, motion=LOBE):
    return Scene.from_dict({"name": "lobe", **cam_of(follower, rotation, base_radius=base), "motion": motion})


def problem_of(follower, rotation="ccw", base=60.0, motion=LOBE):
    return resolve(scene_of(follower, rotation, base, motion))


def curve_of(problem):
    """The profile of a problem: what ``measured`` measures."""

    def curve(theta):
        found = cam_curves(problem.setup.mechanism, problem.design, problem.programme, theta)
        return found.profile[0], found.normal

    return curve


def displacement(fitted, angles):
    """The fitted motion at measured cam angles (deg), above its lowest."""
    return resolve(fitted.scene).programme.motion_at(np.radians(np.mod(angles - fitted.start, 360.0)))[0]


DEGREES = np.arange(360.0)
TURN = np.radians(DEGREES)


# --------------------------------------------------------------------------------------------------- contacts


@pytest.mark.one_in(3)
@settings(max_examples=times(10, 400))
@given(data=st.data(), base=st.floats(45.0, 70.0), lift=st.floats(1.0, 8.0))
@pytest.mark.parametrize(("follower", "rotation"), EVERY)
def test_where_a_follower_touches_is_the_inverse_of_what_it_makes(follower, rotation, data, base, lift):
    """Whatever the cam: from the points of the profile and their normals come cam angles and positions again."""
    law = data.draw(st.sampled_from(["cycloidal", "poly345", "modified-sine", "harmonic"]))
    strokes = [{"segment": kind, "angle": 180.0, "lift": lift, "law": law} for kind in ("rise", "return")]
    problem, rest = problem_of(follower, rotation, base, strokes), problem_of(follower, rotation, 50.0)
    angles = np.array(data.draw(st.lists(st.floats(0.0, 6.28), min_size=1, max_size=5)))
    found = contacts_at_points(rest, *curve_of(problem)(angles))
    assert found.possible.all()
    np.testing.assert_allclose(np.exp(1j * found.angles), np.exp(1j * angles), atol=1e-12)
    lowest = contacts_at_points(rest, *curve_of(problem)(np.zeros(1))).positions
    np.testing.assert_allclose(found.positions - lowest, problem.programme.motion_at(angles)[0], atol=1e-11)
    assert base_radius_at(rest, float(lowest[0])) == pytest.approx(base, abs=1e-11)


def eccentric_by_mpmath(follower, sense, radius, away, angle):
    """The position of a follower on a circle whose centre is away from the axis, in 50 digits, by root finding."""
    with mpmath.workdps(50):
        centre = away * mpmath.expj(-sense * mpmath.mpf(angle))
        kind, size = follower["motion"], {key: mpmath.mpf(v) for key, v in follower.items() if isinstance(v, float)}
        c, round_ = size.get("centre_distance"), size.get("roller_radius", size.get("face_radius", 0))
        if follower["contact"] == "flat" and kind == "translating":
            return centre.imag + radius
        if follower["contact"] == "flat":  # the distance of the centre from the face is the radius

            def off(psi):
                normal = 1j * mpmath.expj(-psi)
                return ((centre - c) * mpmath.conj(normal)).real + radius - size["face_offset"]
        elif kind == "oscillating":

            def off(psi):
                return abs(c - size["arm_length"] * mpmath.expj(-psi) - centre) - radius - round_
        else:

            def off(height):
                return abs(size.get("offset", 0) + 1j * height - centre) - radius - round_

        start = radius + round_ if kind == "translating" else mpmath.mpf(0.9)
        return mpmath.findroot(off, start)


@pytest.mark.parametrize(("follower", "rotation"), EVERY)
def test_an_eccentric_in_50_digits(follower, rotation):
    """A circle off the axis has exact points and normals, and each follower a position on it without derivatives."""
    problem, away, radius = problem_of(follower, rotation), 7 + 3j, 52.0
    normals = np.exp(1j * np.linspace(0.1, 6.2, 24))
    found = contacts_at_points(problem, away + radius * normals, normals)
    exact = [
        eccentric_by_mpmath(FOLLOWERS[follower], -SENSES[rotation], mpmath.mpf(radius), mpmath.mpc(away), angle)
        for angle in found.angles
    ]
    assert np.abs([mpmath.mpf(a) - b for a, b in zip(found.positions.tolist(), exact, strict=True)]).max() < 1e-12


# ------------------------------------------------------------------------------------------- what was measured


PROBED = [(cam, ball) for balls in ((0.0, 20.0), (3.0, 6.0)) for cam, ball in zip(EVERY, balls * 6, strict=True)]
PROBED += [case for case in product(EVERY, (0.0, 3.0, 6.0, 20.0)) if case not in PROBED]


@cache
def in_the_plane(follower, rotation, probe):
    """A cam that is measured without errors, in any order and with the x-axis anywhere: its rows, and the fit."""
    rows = np.random.default_rng(3).permutation(360)
    centres = probe_centres(curve_of(problem_of(follower, rotation)), TURN, probe)[rows] * np.exp(0.7j)
    return rows, fit(MeasuredProfile(xy(centres), "xy", probe), cam_of(follower, rotation), band=0.005)


@pytest.mark.slow
@pytest.mark.one_in(10)
@pytest.mark.parametrize(
    ("cam", "probe"), covering_cases(PROBED, lambda case: [case[0], (case[0][0], case[1]), (case[0][1], case[1])])
)
def test_the_lift_of_each_follower_is_found_again(cam, probe):
    """Without errors, whatever the ball and wherever the x-axis: each row has its cam angle and its lift."""
    follower, rotation = cam
    problem = problem_of(follower, rotation)
    rows, fitted = in_the_plane(follower, rotation, probe)
    seen = fitted.profile.positions
    turned = TURN[rows[seen.rows - 1]] - SENSES[rotation] * 0.7
    off = np.angle(np.exp(1j * (np.radians(seen.angles) - turned)))
    assert np.abs(off).max() < 2e-4
    scale = np.radians(1.0) if fitted.unit == "deg" else 1.0
    lifts = (
        scale * (seen.lifts - seen.lifts.min())
        - problem.programme.motion_at(np.mod(np.radians(seen.angles) + SENSES[rotation] * 0.7, 2 * np.pi))[0]
    )
    assert np.abs(lifts).max() < 2e-6 * (problem.programme.lift or 1.0)
    assert fitted.profile.unreached.size == 0
    assert fitted.scene.cam.base_radius == pytest.approx(60.0, abs=0.01)
    assert [segment.segment for segment in fitted.scene.motion][-3:] == ["rise", "return", "dwell"]


@cache
def with_errors(follower, rotation):
    """A cam that is measured with noise and two outliers: the centres of the ball, and the fit."""
    centres = probe_centres(curve_of(problem_of(follower, rotation)), TURN, 2.0, 0.004)
    centres[[50, 130]] += 0.2 * centres[[50, 130]] / np.abs(centres[[50, 130]])
    return centres, fit(MeasuredProfile(xy(centres), "xy", 2.0), cam_of(follower, rotation))


@pytest.mark.slow
@pytest.mark.one_in(10)
@pytest.mark.parametrize(("follower", "rotation"), EVERY)
def test_noise_and_outliers_are_those_of_the_points(follower, rotation):
    _, fitted = with_errors(follower, rotation)
    scale = np.radians(1.0) * 70.0 if fitted.unit == "deg" else 1.0
    assert fitted.noise * scale == pytest.approx(0.004, rel=0.3)
    assert [each.row for each in fitted.left_out] == [51, 131]
    assert fitted.deviation.held
    name = fitted.quantity("acceleration")
    assert fitted.after["acceleration"] == pytest.approx(
        camopt.evaluate(scene_of(follower, rotation))[name], rel=0.05
    )


ORDERS = {
    "backwards": lambda z: z[::-1],
    "from anywhere": lambda z: np.roll(z, 100),
    "in any order": lambda z: z[np.random.default_rng(5).permutation(z.size)],
    "closed": lambda z: np.append(z, z[0]),
    "round twice": lambda z: np.concatenate([z, z[1::2], z[:1]]),
    "turned": lambda z: z * np.exp(-2.0j),
}


@cache
def worn_points():
    """The worn cam, measured with noise along its profile: the centres of the ball, and the fit."""
    centres = probe_centres(worn_profile, along_the_profile(worn_profile, 360), 3.0, 0.002)
    return centres, fit(MeasuredProfile(xy(centres), "xy", 3.0), cam_of(WORN), band=0.01)


@pytest.mark.slow
@pytest.mark.one_in(6)
@pytest.mark.parametrize("order", ORDERS)
def test_the_order_and_the_sense_of_points_do_not_matter(order):
    centres, first = worn_points()
    other = fit(MeasuredProfile(xy(ORDERS[order](centres)), "xy", 3.0), cam_of(WORN), band=0.01)
    turned = np.degrees(2.0) if order == "turned" else 0.0
    at = np.linspace(0.0, 359.0, 200)
    np.testing.assert_allclose(displacement(other, at + turned), displacement(first, at), rtol=0, atol=2e-3)
    assert other.scene.cam.base_radius == pytest.approx(first.scene.cam.base_radius, abs=2e-3)


@pytest.mark.parametrize("step", [0.0, 0.001])
def test_the_noise_of_points_that_are_measured_again_is_theirs(step):
    """Two turns with errors of their own, some equal by rounding; a turn that is in the file twice is one."""
    rng, options = np.random.default_rng(2), TableReadingOptions()
    turns = [valve_lift(TURN)[0] + rng.normal(0.0, 0.002, TURN.size) for _ in range(2)]
    lifts = np.round(turns, 3) if step else np.array(turns)
    once, twice = ([np.column_stack([DEGREES, y]) for y in lifts[[0, k]]] for k in (0, 1))
    copied, measured = (read_points(np.vstack(rows), options) for rows in (once, twice))
    assert (copied.rows.size, measured.rows.size) == (360, 720)
    for points in (copied, measured):
        assert estimate_point_errors(points).noise == pytest.approx(np.hypot(0.002, step / 12**0.5), rel=0.1)


def test_units_and_forms_are_the_same_profile(tmp_path):
    centres = probe_centres(worn_profile, along_the_profile(worn_profile, 360), 3.0)
    z = centres.tolist()
    path = tmp_path / "cam.csv"
    path.write_text("\n".join(["no;Y [inch];X [inch]", *(f"1;{p.imag / 25.4};{p.real / 25.4}" for p in z)]))
    seen = [
        read_points(path, TableReadingOptions(lift_unit="inch", kind=XY_TABLE)),
        read_points(xy(centres), TableReadingOptions(kind=XY_TABLE)),
        read_points(np.column_stack([np.pi / 2 - np.angle(centres), np.abs(centres)]), TableReadingOptions(angle_unit="rad", kind=POLAR_TABLE)),
    ]  # fmt: skip
    for other in seen[1:]:
        np.testing.assert_allclose(other.angles, seen[0].angles, rtol=0, atol=1e-12)
        np.testing.assert_allclose(other.lifts, seen[0].lifts, rtol=1e-14)


def test_distances_alone_are_in_equal_steps():
    distances = 30.0 + np.cos(TURN)
    np.testing.assert_array_equal(
        read_points(distances, TableReadingOptions(kind=POLAR_TABLE)).lifts,
        read_points(np.column_stack([DEGREES, distances]), TableReadingOptions(kind=POLAR_TABLE)).lifts,
    )


@pytest.mark.slow
@pytest.mark.one_in(6)
@pytest.mark.parametrize(("follower", "rotation"), EVERY)
def test_polar_angles_are_cam_angles_whichever_way_the_cam_turns(follower, rotation):
    """Where a radial follower meets the centre of the ball: of a cam that turns cw, the other way round on it."""
    probe = next(ball for cam, ball in PROBED if cam == (follower, rotation) and ball)
    centres = probe_centres(curve_of(problem_of(follower, rotation)), TURN, probe)
    met = np.degrees(SENSES[rotation] * (np.pi / 2 - np.angle(centres)))
    rows = np.column_stack([met, np.abs(centres)])[np.argsort(met)]
    polar = fit(MeasuredProfile(rows, "polar", probe), cam_of(follower, rotation), band=0.005)
    in_plane = displacement(
        in_the_plane(follower, rotation, probe)[1], DEGREES - SENSES[rotation] * np.degrees(0.7)
    )
    np.testing.assert_allclose(displacement(polar, DEGREES), in_plane, rtol=0, atol=1e-3)
    np.testing.assert_allclose(
        in_plane, problem_of(follower, rotation).programme.motion_at(TURN)[0], rtol=0, atol=0.01
    )


FORMS = ("polar", "xy")
ROUNDED = [(follower, FORMS[(n + d) % 2], d) for n, follower in enumerate(FOLLOWERS) for d in (1, 2, 3)]
ROUNDED += [case for case in product(FOLLOWERS, FORMS, (1, 2, 3)) if case not in ROUNDED]


@pytest.mark.slow
@pytest.mark.one_in(10)
@pytest.mark.parametrize(
    ("follower", "form", "digits"), covering_cases(ROUNDED, lambda case: combinations(case, 2))
)
def test_rounded_points_have_the_noise_of_their_step(follower, form, digits):
    curve, step = curve_of(problem_of(follower)), 10.0**-digits
    if form == "polar":
        centres = probe_centres(curve, at_polar_angles(curve, 2.0, TURN), 2.0)
        rows = np.column_stack([DEGREES, np.round(np.abs(centres), digits)])
    else:
        rows = np.round(xy(probe_centres(curve, along_the_profile(curve, 360), 2.0) * np.exp(0.1j)), digits)
    fitted = fit(MeasuredProfile(rows, form, 2.0), cam_of(follower))
    scale = np.radians(1.0) * 75.0 if fitted.unit == "deg" else 1.0
    assert fitted.noise * scale == pytest.approx(step / 12**0.5, rel=0.6)
    true = camopt.evaluate(scene_of(follower))[fitted.quantity("acceleration")]
    assert fitted.after["acceleration"] == pytest.approx(true, rel=0.08)
    assert fitted.deviation.held


def test_a_step_of_distances_is_a_step_of_angles():
    """Rounding to 0.01 mm is much less of a degree at the end of a long arm."""
    arm = {**FOLLOWERS["arm"], "arm_length": 200.0, "centre_distance": 205.0}
    curve = curve_of(problem_of(arm))
    distances = np.round(np.abs(probe_centres(curve, at_polar_angles(curve, 2.0, TURN), 2.0)), 2)
    fitted = fit(MeasuredProfile(np.column_stack([DEGREES, distances]), "polar", 2.0), cam_of(arm))
    assert fitted.noise * np.radians(1.0) * 200.0 == pytest.approx(0.01 / 12**0.5, rel=0.2)


def test_distances_of_a_probe_like_the_roller_are_the_lift():
    """A radial roller that is as round as the probe is where the ball was: the fit is that of the distances."""
    follower = {"motion": "translating", "contact": "roller", "roller_radius": 3.0}
    lifts = problem_of(follower).programme.motion_at(TURN)[0] + 0.003 * np.random.default_rng(1).normal(size=360)
    rows = np.column_stack([DEGREES, 63.0 + lifts])
    one = fit(MeasuredProfile(rows, "polar", 3.0), cam_of(follower), band=0.013)
    other = fit(rows, cam_of(follower, base_radius=one.scene.cam.base_radius), band=0.013)
    np.testing.assert_allclose(one.points.lifts, other.points.lifts, rtol=1e-14)
    assert one.scene.motion[1].lift == pytest.approx(other.scene.motion[1].lift, abs=1e-5)
    assert one.scene.cam.base_radius == pytest.approx(60.0, abs=0.005)


# ------------------------------------------------------------------------------------------------ the envelope

HOLLOW, OVER = 95.0, 4.0  # deg: where the cam is hollow, and how far to either side


def hollow_lobe(depth):
    """The lobe of a roller with a hollow ground into it."""
    curve = curve_of(problem_of("roller"))

    def profile(theta):
        points, normals = curve(np.mod(theta, 2 * np.pi))
        away = np.clip((np.degrees(theta) - HOLLOW) / OVER, -1.0, 1.0)
        return points - depth * np.cos(away * np.pi / 2) ** 2 * normals, normals

    return profile


@pytest.mark.slow
@pytest.mark.parametrize(("depth", "reached"), [(0.05, True), (1.5, False)])
def test_a_roller_bridges_a_hollow_that_is_too_narrow(depth, reached):
    """The lift at every point is that of the whole profile, by trying all of its points."""
    profile = hollow_lobe(depth)
    centres = probe_centres(profile, np.radians(np.arange(0.0, 360.0, 0.5)), 0.0)
    fitted = fit(MeasuredProfile(xy(centres), "xy"), cam_of("roller"), band=0.1)
    seen = fitted.profile.positions
    exact = touched_lift(profile, np.radians(seen.angles), 6.0, 5.0)
    assert np.abs(seen.lifts - exact).max() < (2e-3 if reached else 1e-2)
    hollow = np.abs(np.arange(0.0, 360.0, 0.5)[fitted.profile.unreached - 1] - HOLLOW)
    assert fitted.profile.unreached.size == 0 if reached else (fitted.profile.unreached.size > 8)
    assert (hollow < OVER).all()
    assert any("does not reach" in words for words in fitted.warnings) is not reached


@pytest.mark.slow
def test_what_a_roller_reaches_is_right_within_the_noise():
    """No point of a hollow is kept that the roller is off by more than the noise leaves open."""
    profile = hollow_lobe(1.5)
    centres = probe_centres(profile, np.radians(np.arange(0.0, 360.0, 0.1)), 0.0, 0.002)
    seen = fit(MeasuredProfile(xy(centres), "xy"), cam_of("roller"), band=0.1).profile.positions
    assert np.abs(seen.lifts - touched_lift(profile, np.radians(seen.angles), 6.0, 5.0)).max() < 0.012


def test_a_face_that_touches_four_corners_is_no_follower():
    turn = np.linspace(0.0, 2 * np.pi, 401)[:-1] + 0.001
    square = 30.0 / np.maximum(np.abs(np.cos(turn)), np.abs(np.sin(turn)))
    with pytest.raises(BadInput, match=r"points: the follower touches \d of 400 points; it needs 12"):
        fit(MeasuredProfile(np.column_stack([np.degrees(turn), square]), "polar"), cam_of("flat"))


def test_a_flat_face_bridges_every_hollow():
    """On an ellipse with a groove the face stands on the edges: what it reaches is the convex hull, no more."""
    turn = np.linspace(0.0, 2 * np.pi, 721)[:-1]
    ellipse = 40.0 * np.cos(turn) + 34.0j * np.sin(turn)
    groove = np.abs(turn - 1.2) < 0.08
    points = ellipse * np.where(groove, 1.0 - 0.01 * np.cos((turn - 1.2) / 0.08 * np.pi / 2) ** 2, 1.0)
    fitted = fit(MeasuredProfile(xy(points), "xy"), cam_of("flat"), band=0.02)
    inside = np.flatnonzero(groove)
    assert set(inside[4:-4] + 1) <= set(fitted.profile.unreached) <= set(np.arange(inside[0] - 8, inside[-1] + 10))
    normals = np.exp(1j * (np.pi / 2 - np.radians(fitted.profile.positions.angles)))
    support = np.max((points[:, None] * normals.conjugate()).real, axis=0)
    np.testing.assert_allclose(fitted.profile.positions.lifts, support, rtol=0, atol=2e-3)


@pytest.mark.slow
@settings(max_examples=times(4, 60))
@given(seed=st.integers(0, 10**6), delta=st.sampled_from([0.01, 0.05]))
@pytest.mark.parametrize("offset", [0.0, 8.0])
def test_a_change_of_the_profile_lifts_by_no_more_than_that_over_the_cosine(offset, seed, delta):
    """Each point moved by up to δ along the normal: the lift changes by up to δ/cos β, by trying all points."""
    follower = {"motion": "translating", "contact": "roller", "roller_radius": 6.0, "offset": offset}
    problem = problem_of(follower, base=30.0)
    curve, bumps = curve_of(problem), np.random.default_rng(seed).normal(size=(2, 9))
    waves = np.arange(1, 10)

    def move_profile(theta):
        points, normals = curve(np.mod(theta, 2 * np.pi))
        wave = np.sum(bumps[0] * np.cos(np.outer(theta, waves)) + bumps[1] * np.sin(np.outer(theta, waves)), axis=1)
        return points + delta * np.tanh(wave)[:, None].ravel() * normals, normals

    angles = np.radians(np.arange(0.0, 360.0, 15.0))
    tangent = (problem.programme.motion_at(angles)[1] - offset) / touched_lift(curve, angles, 6.0, offset)
    change = touched_lift(move_profile, angles, 6.0, offset) - touched_lift(curve, angles, 6.0, offset)
    assert (np.abs(change) <= 1.01 * delta * np.hypot(1.0, tangent) + 1e-6).all()


@pytest.mark.slow
@settings(max_examples=times(4, 200))
@given(
    data=st.data(),
    base=st.floats(50.0, 84.0),  # a flat arm of 80 mm about a face offset of 5 mm allows no more
    lift=st.floats(2.0, 8.0),
    probe=st.floats(0.0, 20.0),
    turned=st.floats(-3.0, 3.0),
)
def test_any_cam_is_found_within_its_band(data, base, lift, probe, turned):
    """A random lobe under a random follower and ball: the points are as near to the profile that is found."""
    follower, rotation = data.draw(st.sampled_from(EVERY))
    rise, pause, fall = (data.draw(st.integers(*ends)) for ends in ((70, 110), (0, 40), (70, 110)))
    law = data.draw(st.sampled_from(["cycloidal", "poly345", "poly4567", "modified-sine"]))
    motion = [{"segment": "rise", "angle": rise, "lift": lift, "law": law}]
    motion += [{"segment": "dwell", "angle": pause}] if pause else []
    motion += [{"segment": "return", "angle": fall, "lift": lift, "law": law}]
    motion += [{"segment": "dwell", "angle": 360 - rise - pause - fall}]
    curve = curve_of(problem_of(follower, rotation, base, motion))
    centres = probe_centres(curve, along_the_profile(curve, 300), probe, 0.003) * np.exp(1j * turned)
    fitted = fit(MeasuredProfile(xy(centres), "xy", probe), cam_of(follower, rotation))
    assert fitted.deviation.held
    assert fitted.profile.unreached.size == 0
    assert fitted.scene.cam.base_radius == pytest.approx(base, abs=0.01)
    kept = np.setdiff1d(np.arange(300), [each.row - 1 for each in fitted.left_out])
    assert fitted.distances.size == kept.size >= 298
    assert np.abs(fitted.distances).max() < 4.5 * 0.003 * fitted.band / (noise_band_factor(300) * fitted.noise)


# --------------------------------------------------------------------------------------- far from the profile


@pytest.mark.slow
@pytest.mark.one_in(6)
@pytest.mark.parametrize(("follower", "rotation"), EVERY)
def test_the_points_are_as_near_to_the_profile_of_the_result(follower, rotation):
    """By the points of the scene alone, as it is exported: no part of the fit is in this."""
    centres, fitted = with_errors(follower, rotation)
    centres = np.delete(centres, [each.row - 1 for each in fitted.left_out])
    columns = camopt.cam_points(fitted.scene, step=0.02)
    profile = columns["profile_x_mm"] + 1j * columns["profile_y_mm"]
    back = centres * np.exp(1j * SENSES[rotation] * np.radians(fitted.start))
    tree = cKDTree(np.column_stack([profile.real, profile.imag]))
    away = tree.query(np.column_stack([back.real, back.imag]))[0] - 2.0
    assert np.abs(np.sort(away) - np.sort(fitted.distances)).max() < 1e-4
    band = fitted.band * (np.radians(1.0) * 80.0 if fitted.unit == "deg" else 1.0)
    assert np.abs(away).max() < 1.05 * band
    assert fitted.to_dict()["profile"]["distance_max_mm"] == np.abs(fitted.distances).max()


def test_points_of_another_cam_are_far_from_it():
    centres = probe_centres(worn_profile, along_the_profile(worn_profile, 360), 3.0)
    fitted = fit(MeasuredProfile(xy(centres), "xy", 3.0), cam_of(WORN), band=0.002)
    assert np.abs(fitted.distances).max() < 0.00201  # a tolerance is filled
    grown = fitted.scene.replace(**{"cam.base_radius": fitted.scene.cam.base_radius + 0.1})
    off = fitted.profile.distances_outside_profile(resolve(grown), fitted.start, fitted.points.rows)
    assert off.max() < 0.0
    assert off.min() == pytest.approx(-0.1, abs=0.01)
    turned = fitted.profile.distances_outside_profile(resolve(fitted.scene), fitted.start + 1.0, fitted.points.rows)
    assert np.abs(turned).max() > 0.1


# ------------------------------------------------------------------------------------------- cams of practice


def test_the_files_are_those_that_the_script_makes():
    from data.make_measured import tables

    for name, (heading, rows) in tables().items():
        first, *lines = (DATA / name).read_text().splitlines()
        assert first == heading
        np.testing.assert_allclose(np.loadtxt(lines, delimiter=","), rows, rtol=0, atol=5.1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("form", ["lift", "profile"])
def test_an_inlet_lobe_is_found_again(form):
    """Lift and profile of the same cam, 2 µm of noise: acceleration and jerk are those of its polynomial."""
    path = DATA / f"inlet-{form}.csv"
    points = path if form == "lift" else MeasuredProfile(path, "polar", 1.5)
    scene = camopt.find_scene("bucket-valve").replace(**{"cam.base_radius": BASE + 5.0 * (form == "profile")})
    fitted = fit(points, scene)
    true = valve_lift(np.linspace(0.0, 2 * np.pi, 100_001))
    assert fitted.noise == pytest.approx(0.002, rel=0.15)
    assert fitted.scene.cam.base_radius == pytest.approx(BASE, abs=0.002)
    for order, (name, within) in enumerate((("velocity", 0.005), ("acceleration", 0.02), ("jerk", 0.15)), start=1):
        per = (3000 * 2 * np.pi / 60) ** order * 1e-3  # mm/radⁿ to m/sⁿ
        assert fitted.after[name] == pytest.approx(per * np.abs(true[order]).max(), rel=within)
    exact = valve_lift(TURN)[0] - fitted.zero + (BASE if form == "profile" else 0.0)
    assert np.abs(displacement(fitted, DEGREES) - exact).max() < fitted.band


@pytest.mark.slow
def test_what_wear_did_to_the_acceleration():
    """The lift is that of the worn profile, by trying all its points; so is what it lost, and what that costs."""
    drawn = camopt.find_scene(DATA / "cam-as-drawn.toml")
    fitted = fit(MeasuredProfile(DATA / "worn-cam.csv", "xy", 3.0), drawn)
    at = np.radians(np.arange(0.0, 360.0, 0.5))
    worn = touched_lift(worn_profile, at, ROLLER, OFFSET)
    new = touched_lift(lambda theta: worn_profile(theta, 0.0), at, ROLLER, OFFSET)
    found = displacement(fitted, np.degrees(at) - np.degrees(0.6)) + fitted.zero
    assert np.abs(found - worn).max() < 0.6 * fitted.band
    assert (new - found).max() == pytest.approx(WEAR, abs=0.6 * fitted.band)
    per = (600 * 2 * np.pi / 60) ** 2 * 1e-3  # mm/rad² to m/s²
    acceleration = [per * np.abs(np.diff(y, 2)).max() / np.radians(0.5) ** 2 for y in (new, worn)]
    assert camopt.evaluate(drawn)["acceleration_max_m_s2"] == pytest.approx(acceleration[0], rel=1e-3)
    assert acceleration[0] == pytest.approx(per * 2 * np.pi * STROKE / np.radians(80.0) ** 2, rel=1e-3)
    assert fitted.after["acceleration"] == pytest.approx(acceleration[1], rel=0.03)
    assert fitted.after["acceleration"] > 1.15 * acceleration[0]
    assert fitted.scene.cam.base_radius == pytest.approx(LEAST, abs=0.001)


def test_a_base_circle_need_not_be_measured():
    turn = at_polar_angles(valve_profile, 1.5, TURN[20:190])
    distances = np.abs(probe_centres(valve_profile, turn, 1.5, 0.002))
    fitted = fit(MeasuredProfile(np.column_stack([DEGREES[20:190], distances]), "polar", 1.5), cam_of(FLAT))
    assert fitted.after["acceleration"] == pytest.approx(52.86, rel=0.03)
    assert fitted.scene.cam.base_radius == pytest.approx(BASE, abs=0.003)


@pytest.mark.slow
@pytest.mark.parametrize("count", [72, 120, 180])
def test_few_points_on_a_sharp_nose_are_enough(count):
    """A flat face rolls over the nose within a few points, up to 23 deg of cam angle from one to the next."""
    centres = probe_centres(valve_profile, along_the_profile(valve_profile, count), 2.0, 0.002)
    fitted = fit(MeasuredProfile(xy(centres), "xy", 2.0), cam_of(FLAT))
    assert np.diff(np.sort(fitted.points.angles)).max() > 9.0
    assert fitted.after["acceleration"] == pytest.approx(52.86, rel=0.04)


def test_the_usual_band_is_that_of_the_noise():
    fitted = fit(MeasuredProfile(DATA / "inlet-profile.csv", "polar", 1.5), cam_of(FLAT))
    assert fitted.band == pytest.approx(fitted.noise * noise_band_factor(360), rel=1e-12)
    assert fitted.deviation_rms < 1.1 * fitted.noise


# ---------------------------------------------------------------------------------------------------- refusals

GOOD = xy(probe_centres(worn_profile, along_the_profile(worn_profile, 360), 3.0, 0.001))
ARM = FOLLOWERS["arm"]


@pytest.mark.parametrize(
    ("rows", "more", "line"),
    [
        (GOOD + np.array([60.0, 0.0]), {}, r"points: points: do not go round the axis of the cam, which is at x = 0, y = 0: none over 2\d\d"),
        (GOOD[:150], {}, "points: do not go round the axis"),
        (np.delete(GOOD, np.s_[20:50], axis=0), {}, r"row 20: no points from \d+\.\d+ to \d+\.\d+ deg \(up to row 21\), and this is not on the base circle"),
        (np.delete(GOOD, np.s_[88:118], axis=0), {}, r"row \d+: no points from .* deg \(up to row \d+\), and this is not on the base circle"),
        (np.vstack([GOOD, [0.0, 0.0]]), {}, "row 361: is on the axis of the cam"),
        (np.vstack([GOOD, [1e7, 0.0]]), {}, "row 361 = 10000000.0: the x must be within"),
        (GOOD[::40], {}, "rows = 9: must be at least 12 points"),
        (np.vstack([GOOD[::40], GOOD[::40]]), {}, "angles = 9: must be at least 12 different ones"),
        (GOOD[:, 0], {}, "columns: has one column, and points need both x and y"),
        (30.0 * GOOD / np.abs(GOOD[:, :1] + 1j * GOOD[:, 1:]), {}, "no motion|does not move"),
        (GOOD, {"probe": 50.0}, r"row \d+ = \d+\.\d+: must be further from the axis of the cam than the probe's radius 50"),
        (GOOD, {"probe": -1.0}, "probe = -1.0: must be a radius from 0 to 1000 mm"),
        (GOOD, {"probe": float("nan")}, "probe = nan: must be a radius"),
        (GOOD, {"probe": "3"}, "probe = '3': must be a radius"),
        (GOOD, {"form": "xyz"}, "profile = 'xyz': must be one of polar, xy"),
        (GOOD, {"form": None}, "profile: missing: polar or xy"),
        (GOOD, {"turn": 720.0}, "turn = 720.0: must be left out: points x, y have no angles"),
        (GOOD, {"lift_unit": "deg"}, "lift_unit = 'deg': must be mm or inch for a profile"),
        (GOOD, {"columns": [1, 2, 3]}, r"columns = \[1, 2, 3\]: must be those of x and y"),
        (GOOD, {"scene": {"cam": {"form": "cylindrical"}, "follower": FLAT}}, "scene: cam.form = 'cylindrical': must be disc"),
        (GOOD, {"scene": {"cam": "disc", "follower": FLAT}}, "scene: cam = 'disc': must be a table"),
        (GOOD, {"scene": {"cam": {"form": "disc"}}}, "scene: follower: missing"),
        (GOOD, {"scene": cam_of({**WORN, "offset": 60.0})}, r"follower.offset = 60.0: must be smaller than the prime radius \(4[12]\.\d+\)"),
        (GOOD, {"scene": cam_of({**ARM, "arm_length": 20.0, "centre_distance": 30.0})}, r"points: row \d+: the follower cannot touch this point: prime radius, arm and centre distance have to form a triangle"),
        (GOOD * [1.0, -1.0], {"form": "polar"}, r"row \d+ = -\d+\.\d+: must be further from the axis of the cam than 0"),
        (np.column_stack([2 * DEGREES, 30.0 + np.cos(TURN)]), {"form": "polar"}, "row 360 = 718.0: the angles go from 0"),
    ],
)  # fmt: skip
def test_what_is_no_profile_is_refused(rows, more, line):
    options = {"scene": cam_of(WORN), **more}
    probe = options.pop("probe", 3.0 if "form" not in more else 0.0)
    with pytest.raises(BadInput, match=line) as error:
        fit(MeasuredProfile(rows, options.pop("form", "xy"), probe), **options)
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.slow
def test_a_band_that_no_motion_holds_is_told_with_its_rows():
    with pytest.raises(Unmet, match=r"no motion with these dwells and turns is within 0\.0003 .*, because of rows"):
        fit(MeasuredProfile(GOOD, "xy", 3.0), cam_of(WORN), band=0.0003)
    twice = np.vstack([GOOD, 1.002 * GOOD[:1], 0.998 * GOOD[:1]])
    with pytest.raises(Unmet, match=r"rows \d+ and \d+ are 0\.\d+ apart"):
        fit(MeasuredProfile(twice, "xy", 3.0), cam_of(WORN), keep_outliers=True)


@settings(max_examples=times(13, 400))
@given(
    rows=st.lists(st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0)), min_size=12, max_size=40),
    form=st.sampled_from(["polar", "xy"]),
)
def test_whatever_the_points_are_a_cam_or_a_message_comes_of_them(rows, form):
    told = []
    try:
        fitted = fit(MeasuredProfile(rows, form), cam_of("roller"))
    except (BadInput, Unmet, camopt.Unsolved) as error:
        told = str(error).splitlines()
    else:
        assert fitted.deviation.held
        assert np.isfinite(fitted.distances).all()
    assert len(told) <= 1


@pytest.mark.parametrize(
    ("heading", "line"),
    [
        ("x,y", "columns = 'x, y': are points of a profile? Then say so (profile xy)"),
        ("X [mm],Y [mm]", "columns = 'X [mm], Y [mm]': are points of a profile? Then say so (profile xy)"),
        ("Angle,Radius", "columns = 'Angle, Radius': are points of a profile? Then say so (profile polar)"),
        ("θ,r", "columns = 'θ, r': are points of a profile? Then say so (profile polar)"),
    ],
)  # fmt: skip
def test_a_profile_is_not_taken_for_lifts(tmp_path, heading, line):
    path = tmp_path / "cam.csv"
    path.write_text("\n".join([heading, *(f"{a:g},{30 + np.cos(np.radians(a)):.4f}" for a in DEGREES)]))
    with pytest.raises(BadInput) as error:
        read_points(path, TableReadingOptions())
    assert str(error.value).startswith(f"{path}: {line}; if not, give the columns, such as 1,2")


def test_columns_that_are_chosen_are_taken_for_lifts(tmp_path):
    path = tmp_path / "cam.csv"
    path.write_text("\n".join(["x,y", *(f"{a:g},{30 + np.cos(np.radians(a)):.4f}" for a in DEGREES)]))
    assert read_points(path, TableReadingOptions(chosen=["x", "y"])).lifts.max() == 31.0


# ----------------------------------------------------------------------------------------------------- command


@pytest.fixture
def run(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        code = main(["fit", *map(str, arguments)])
        out, err = capsys.readouterr()
        assert "Traceback" not in out + err
        return code, out, err

    return call


@pytest.mark.slow
def test_the_command_says_what_was_measured_and_draws_it(run, tmp_path):
    more = ("--profile", "xy", "--probe", 3, "--follower", "roller", "--roller-radius", 10)
    code, out, err = run(DATA / "worn-cam.csv", *more, "--rpm", 600, "--plot", "worn.png")
    assert code == 0
    assert "Measured: centres of a ball of 3 mm; the lift is that of the follower: translating, roller." in out
    assert "Base radius 32" in out
    assert "wrote fitted.toml" in err
    assert (tmp_path / "worn.png").stat().st_size > 20_000
    assert camopt.find_scene("fitted.toml").cam.base_radius == pytest.approx(LEAST, abs=0.001)


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("depth", "legend"), [(0.0, {"base circle", "points"}), (1.5, {"base circle", "points", "not reached"})]
)
def test_the_picture_has_the_profile_beside_the_diagrams(depth, legend):
    centres = probe_centres(hollow_lobe(depth), np.radians(np.arange(0.0, 360.0, 0.5)), 0.0, 0.001)
    fitted = fit(MeasuredProfile(xy(centres), "xy"), cam_of("roller"), band=0.1)
    *diagrams, profile = camopt.plot(fitted).axes
    assert len(diagrams) == 3
    assert {text.get_text() for text in profile.get_legend().get_texts()} == legend
    (magnified,) = re.findall(r"magnified ([\d.]+) times", profile.get_title(loc="left"))
    times_ = float(magnified)
    drawn = next(line for line in profile.lines if line.get_label() == "points")
    assert drawn.get_xdata().size == fitted.points.angles.size
    outline = fitted.scene.cam.base_radius
    nearest = np.hypot(drawn.get_xdata(), drawn.get_ydata()).min()
    assert nearest == pytest.approx(
        outline + times_ * fitted.distances.min(), abs=0.3 * times_ * np.abs(fitted.distances).max()
    )


def test_its_document(run):
    code, out, err = run(DATA / "inlet-profile.csv", "--profile", "polar", "--probe", 1.5, "--json", "--quiet")
    found = json.loads(out)["profile"]
    assert (code, err) == (0, "")
    assert found["probe_radius_mm"] == 1.5
    assert found["unreached_rows"] == []
    assert found["distance_max_mm"] < 0.009
    assert found["distance_rms_mm"] == pytest.approx(0.002, rel=0.2)
    assert found["base_radius_mm"] == pytest.approx(BASE, abs=0.002)
    code, out, _ = run(DATA / "inlet-lift.csv", "--base-radius", BASE, "--json", "--quiet", "--out", "b.toml")
    assert (code, json.loads(out)["profile"]) == (0, None)


PROFILE = str(DATA / "inlet-profile.csv")


@pytest.mark.parametrize(
    ("arguments", "code", "line"),
    [
        ([PROFILE, "--base-radius", 18], 2, f"{PROFILE}: columns = 'angle_deg, radius_mm': are points of a profile?"),
        ([PROFILE, "--profile", "round"], 2, "camopt: --profile = 'round': must be one of polar, xy"),
        ([PROFILE, "--profile", "polar", "--probe", -2], 2, "camopt: --probe = -2.0: must be a radius from 0 to 1000 mm"),
        ([PROFILE, "--profile", "polar", "--base-radius", 18], 2, "camopt: --base-radius = 18.0: belongs to lifts"),
        ([PROFILE, "--base-radius", 18, "--probe", 2], 2, "camopt: --probe = 2.0: needs --profile"),
        ([PROFILE, "--profile", "xy"], 2, f"{PROFILE}: column 'angle_deg': is in deg, and mm is taken; only mm, inch can be read"),
        ([PROFILE, "--profile", "polar", "--lift-unit", "inch"], 2, f"{PROFILE}: column 'radius_mm': is in mm, and inch is taken"),
        ([PROFILE, "--profile", "polar", "--follower", "roller"], 2, "camopt: --roller-radius: missing; a roller follower needs it"),
        (["none.csv", "--profile", "xy"], 3, "camopt: none.csv: No such file or directory"),
        ([PROFILE, "--profile", "polar", "--columns", "1,radius"], 2, f"{PROFILE}: columns = 'radius': must be a number from 1 to 2"),
        ([PROFILE, "--profile", "polar", "--band", 1e-4], 1, f"camopt: {PROFILE}: no motion"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(run, tmp_path, arguments, code, line):
    found, out, err = run(*arguments)
    assert (found, out) == (code, "")
    assert err.startswith(line)
    assert len(err.splitlines()) == 1
    assert not list(tmp_path.iterdir())
