"""Motions of cams with errors by exact contact, against contact in 40 digits, dense scans and closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp
from scipy import stats
from support.cams import CONTACTS
from support.real_cams import RealCams
from support.recontact import displacement
from support.trains import exact

import camopt
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.solve.tolerances.error_samples import LargestErrorSearch, sample_errors
from tests.solve.tolerances.test_response import SIZES
from tests.solve.tolerances.test_response import scene_of as plain_of
from tests.solve.tolerances.test_tolerance import TRAINS, scene_of

EVERY = {"profile": 0.02, "waves": 9, "bore_eccentricity": 0.02, "phase": 0.05}
PLACES = np.array([0.7, 2.2, 4.0])
KEYS = {"bore_eccentricity": "bore"}


def tolerances_of(contact):
    """All tolerances of a contact."""
    sizes = {f"follower.{key}": 0.03 for key in SIZES[contact] if key != "face_tilt"}
    tilt = {"face_tilt": 0.1} if "face_tilt" in SIZES[contact] else {}
    return {**sizes, **tilt, **EVERY}


def errors_of(off, cam, waves):
    """Those of one cam, as the computation in 40 digits takes them."""
    found = {key.removeprefix("follower."): mp.mpmathify(each[cam].item()) for key, each in off.items()}
    return {"waves": waves, **{KEYS.get(key, key): each for key, each in found.items()}}


def slope(motion, theta, order):
    """A derivative of a motion by differences."""
    step = mp.mpf(10) ** -9
    first, middle, last = (motion(theta + side * step) for side in (-1, 0, 1))
    return (middle, (last - first) / (2 * step), (last - 2 * middle + first) / step**2)[order]


@pytest.mark.one_in(3)
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("contact", CONTACTS)
def test_motions_are_those_of_exact_contact_in_40_digits(contact, rotation):
    """Displacement, velocity and acceleration of cams with all errors at once, none of them small."""
    plain = plain_of(contact, rotation)
    scene = Scene.from_dict({**plain, "tolerances": tolerances_of(contact)})
    problem = resolve_design(scene)
    off, cams = sample_errors(scene, problem, PLACES.size, 5), RealCams(problem, waves=9)
    for order in range(3):
        moved = cams.motion(off, PLACES, order)
        for cam, theta in enumerate(moved.angle.terms[0]):
            with mp.workdps(40):
                errors = errors_of(off, cam, 9)
                known = slope(lambda at, e=errors: displacement(plain, e, at), mp.mpf(theta), order)
            assert moved.by_angle(order)[cam] == pytest.approx(float(known), rel=1e-11, abs=1e-11)


@pytest.mark.parametrize("contact", TRAINS)
def test_at_the_tool_motions_are_those_of_closed_loops(contact):
    stage = {"crossed": False, **TRAINS[contact]} if contact == "arm" else TRAINS[contact]
    scene = scene_of(contact, given={"follower.roller_radius": 0.05, "phase": 0.1}, train=[stage])
    problem = resolve_design(scene)
    off, cams = sample_errors(scene, problem, 3, 1), RealCams(problem)
    alone = replace(cams, problem=replace(problem, setup=replace(problem.setup, train=None)))
    follower = alone.motion(off, PLACES, 0).tool.terms[0]
    start = problem.programme.strokes[0].low  # of the follower, where its train starts
    keys = {key: each for key, each in stage.items() if key != "stage"}
    with mp.workdps(30):
        known = [float(exact([(stage["stage"], keys)], contact == "arm", mp.mpf(y - start))) for y in follower]
    np.testing.assert_allclose(cams.motion(off, PLACES, 0).tool.terms[0], known, rtol=1e-9, atol=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("contact", "law"), [("offset-roller", "harmonic"), ("arm", "poly345"), ("flat", "cycloidal")]
)
def test_the_largest_error_of_a_cam_is_that_of_a_scan_over_cam_angles(contact, law):
    """At 21,000 cam angles, dense near joints, at each of which the place of contact is found by itself."""
    scene = scene_of(contact, law, tolerances_of(contact) | {"waves": 4})
    problem = resolve_design(scene)
    off = sample_errors(scene, problem, 6, 2)
    found = LargestErrorSearch(RealCams(problem, 4), tuple(off))
    near = np.add.outer(found._joints, np.outer([-1, 1], np.logspace(-8, -3, 100)).ravel()).ravel()
    angles = np.concatenate([np.linspace(0.0, 2 * np.pi, 20_001)[:-1] + 1e-5, near])
    for order in range(3):
        most = found.largest_motion_errors(off, order).error
        for cam, value in enumerate(most):
            one = {key: np.full(angles.size, each[cam]) for key, each in off.items()}
            scanned = np.abs(
                found.real_cam.motion_errors(one, found.real_cam.contact_places(one, angles), order)
            ).max()
            assert scanned * (1 - 0.01) <= value <= scanned * (1 + 1e-3)


@pytest.mark.slow
def test_under_a_flat_face_errors_have_the_distributions_that_are_known():
    """A profile that is too large everywhere lifts a flat face by as much; with a bore that is off, by its distance
    more at some angle: |profile| + |bore|, a normal and a Rayleigh distribution."""
    face = camopt.find_scene("bucket-valve")
    batch = camopt.sample_cams(face.replace(tolerances={"profile": 0.03, "follower.offset": 0.5}), cams=2**14)
    first, second, third, dwell = batch.errors
    assert [first.median, first.of_95, first.of_99_73] == pytest.approx(
        [0.01 * stats.norm.isf((1 - share) / 2) for share in (0.5, 0.95, 0.9973)], rel=2e-3
    )
    assert max(second.worst, third.worst, dwell.worst) < 1e-8
    assert first.variances == pytest.approx({"follower.offset": 0.0, "profile": 1.0}, abs=5e-3)
    batch = camopt.sample_cams(face.replace(tolerances={"bore_eccentricity": 0.03}), cams=2**14)
    assert [batch.errors[0].median, batch.errors[0].of_99_73] == pytest.approx(
        [0.01 * stats.rayleigh.ppf(share) for share in (0.5, 0.9973)], rel=5e-3
    )


@pytest.mark.slow
def test_shares_of_the_variance_are_those_of_the_first_order_and_yields_those_of_a_second_sampler():
    scene = scene_of("arm", given=tolerances_of("arm"))
    batch, known = camopt.sample_cams(scene, cams=2**13), camopt.tolerance(scene).errors
    for spread, error in zip(batch.errors, known, strict=False):
        for key, share in error.variances.items():
            assert spread.variances[key] == pytest.approx(share, abs=0.02)
        assert spread.worst < 2.0 * error.worst
    problem, rng, cams = resolve_design(scene), np.random.default_rng(9), 3000
    off = {f"follower.{key}": rng.normal(0.0, 0.01, cams) for key in SIZES["arm"]}
    for key, size in (("profile", 0.02), ("bore_eccentricity", 0.02)):
        off[key] = rng.normal(0.0, size / 3, cams) + 1j * rng.normal(0.0, size / 3, cams)
    off["phase"] = rng.normal(0.0, np.radians(0.05) / 3, cams)
    values = np.degrees(LargestErrorSearch(RealCams(problem, 9), tuple(off)).largest_motion_errors(off, 0).error)
    for share, value in ((0.5, batch.errors[0].median), (0.95, batch.errors[0].of_95)):
        low, high = stats.binom.interval(0.9999, cams, share)
        assert low <= np.count_nonzero(values <= value) <= high


def test_a_dwell_wobbles_no_more_than_the_worst_case_says():
    scene = scene_of("flat", given={"bore_eccentricity": {**EVERY}["bore_eccentricity"]})
    batch, worst = (
        camopt.sample_cams(scene, cams=2**10),
        max(each.change for each in camopt.tolerance(scene).dwells),
    )
    off = sample_errors(scene, resolve_design(scene), 2**10, 0)["bore_eccentricity"]
    assert batch.errors[3].worst <= worst * np.abs(off).max() / 0.02 * (1 + 1e-9)
    stroke = resolve_design(scene).programme.strokes[3]
    angles = np.linspace(stroke.start, stroke.end, 500)[:, None]
    lifted = (off * np.exp(1j * angles)).imag
    assert batch.errors[3].worst == pytest.approx(np.ptp(lifted, axis=0).max(), rel=1e-4)
