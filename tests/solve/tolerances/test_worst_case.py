"""Exact errors of real cams, and the proven bound over all of them."""

import json

import numpy as np
import pytest
from mpmath import mp
from scipy import optimize
from support.cams import CONTACTS, cam_with
from support.depth import times
from support.real_cams import RealCams
from support.recontact import displacement

import camopt
from camopt.core.numerics.taylor import Taylor
from camopt.model.effects.motion import motion_unit_factor
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.solve.tolerances import worst_case
from camopt.solve.tolerances.errors import (
    BORE,
    BORE_DIRECTION,
    contact_errors_from_flat_errors,
    error_ranges_at_one_contact,
    flat_from_polar_errors,
    repeat_cam_errors,
)
from camopt.solve.tolerances.real_cam import RealCam
from tests.solve.tolerances.test_response import DIGITS, SIZES, scene_of

TENTH = 1e-4
"""rad"""


def random_errors(rng, contact, size=0.02):
    """Errors of every kind that a cam can have."""
    lengths = {f"follower.{key}": rng.uniform(-size, size) for key in SIZES[contact] if key != "face_tilt"}
    angles = {
        key: rng.uniform(-5, 5) * TENTH for key in ("phase", *SIZES[contact]) if key in ("phase", "face_tilt")
    }
    way = {} if contact.startswith("groove") else {BORE_DIRECTION: rng.uniform(-3, 3)}
    return {**lengths, **angles, "profile": rng.uniform(-size, size), BORE: rng.uniform(-size, size), **way}


def exact_error(scene, errors, place, theta):
    """The error at a cam angle by re-contact in 40 digits, of a cam that is touched at a place, mm or rad."""
    tables, known = scene.to_dict(), {key.removeprefix("follower."): each for key, each in errors.items()}
    way, sense = known.pop(BORE_DIRECTION, None), 1 if tables["cam"].get("rotation", "ccw") == "ccw" else -1
    turned = (
        theta + errors["phase"] if way is None else place
    )  # of the cam where the direction is that of the ground
    with mp.workdps(DIGITS):
        known["bore"] = known.pop(BORE) * mp.expj((way or 0) - sense * mp.mpf(turned))
        return float(displacement(tables, known, mp.mpf(theta)) - displacement(tables, {}, mp.mpf(theta)))


@pytest.mark.one_in(3)
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("contact", CONTACTS)
def test_where_a_follower_rests_is_its_exact_contact_in_40_digits(contact, rotation):
    scene, rng = Scene.from_dict(scene_of(contact, rotation)), np.random.default_rng(3)
    problem = resolve_design(scene)
    for place in (0.4, 1.7, 2.4, 3.5, 5.9):
        errors = random_errors(rng, contact)
        found = RealCam(problem).tool_error_at_contact(flat_from_polar_errors(errors), np.array([place]))
        assert found.error[0] == pytest.approx(exact_error(scene, errors, place, found.angle[0]), abs=1e-13)


@pytest.mark.parametrize("contact", ["offset-roller", "arm", "flat", "swinging-face", "groove-arm"])
def test_where_a_follower_rests_has_the_slopes_of_its_series(contact):
    """By differences of the numbers themselves, of a motion that is known as a series."""
    problem = resolve_design(Scene.from_dict(scene_of(contact, "ccw")))
    errors = flat_from_polar_errors(random_errors(np.random.default_rng(1), contact))
    step, places = 1e-4, 1.1 + 1e-4 * np.arange(-1, 2)
    y, y1, y2, y3 = problem.programme.motion_at(places)
    mechanism, lift = problem.setup.mechanism, problem.programme.lift
    numbers = mechanism.shifted_contact(problem.design, lift, y, y1, contact_errors_from_flat_errors(errors))
    series = mechanism.shifted_contact(
        problem.design,
        lift,
        Taylor([y, y1, y2 / 2]),
        Taylor([y1, y2, y3 / 2]),
        contact_errors_from_flat_errors(errors),
    )
    for near, found in zip(numbers, series, strict=True):
        np.testing.assert_allclose(found.terms[0], near, rtol=1e-13, atol=1e-16)
        slopes = (near[2] - near[0]) / (2 * step), (near[2] - 2 * near[1] + near[0]) / step**2
        for order, slope in enumerate(slopes, start=1):
            assert found.derivative(order)[1] == pytest.approx(slope, rel=1e-5, abs=1e-8)


TRAIN = {"stage": "rocker", "input_arm": 40, "input_angle": -10, "output_arm": 55, "output_angle": -25}
KINDS = [*CONTACTS, "train"]


def scene_with_tolerances(contact, law="poly345", rotation="ccw", size=0.01):
    """A cam with a tolerance of everything that it has."""
    train = [TRAIN] if contact == "train" else None
    contact = "roller" if contact == "train" else contact
    found = cam_with(contact, law, dynamics={}, rotation=rotation, **({"train": train} if train else {}))
    found = {key: found[key] for key in ("cam", "follower", "motion", "train") if key in found}
    angles = {"phase": {"plus": 0.03, "minus": 0.02}} | (
        {"face_tilt": 0.02} if "face_tilt" in SIZES[contact] else {}
    )
    lengths = {f"follower.{key}": {"plus": size, "minus": size / 2} for key in SIZES[contact] if key != "face_tilt"}
    given = {**lengths, **angles, "profile": size, "bore_eccentricity": size}
    return Scene.from_dict({**found, "name": contact, "tolerances": given})


@pytest.mark.slow
@pytest.mark.one_in(18)
@pytest.mark.parametrize("law", ["poly345", "harmonic"])
@pytest.mark.parametrize("contact", KINDS)
def test_no_cam_exceeds_the_bound_and_the_worst_cam_nearly_has_it(contact, law):
    """By 200,000 cams, half of them at corners, at random places, and a local search from the worst of them."""
    scene, rng = scene_with_tolerances(contact, law), np.random.default_rng(2)
    found, problem = camopt.tolerance(scene).worst_case, resolve_design(scene)
    unit, zones = motion_unit_factor(problem.setup, 0), error_ranges_at_one_contact(scene, problem)
    ends = np.array([*zones.values()])
    assert 0.0 <= found.gap <= 2e-5 * found.bound
    assert abs(found.bound - camopt.tolerance(scene).errors[0].worst) < 1e-4

    def errors(x, places):
        return (
            np.abs(
                RealCam(problem)
                .tool_error_at_contact(flat_from_polar_errors(dict(zip(zones, x.T, strict=True))), places)
                .error
            )
            * unit
        )

    x = ends[:, 0] + rng.uniform(size=(200_000, len(ends))) * (ends[:, 1] - ends[:, 0])
    x[100_000:] = np.where(rng.uniform(size=(100_000, len(ends))) < 0.5, ends[:, 0], ends[:, 1])
    if BORE_DIRECTION in zones:
        x[:, [*zones].index(BORE_DIRECTION)] = rng.uniform(-np.pi, np.pi, 200_000)
    places = rng.uniform(0.0, 2 * np.pi, 200_000)
    sampled = errors(x, places)
    assert sampled.max() <= found.bound
    best = int(sampled.argmax())
    inside = [*map(tuple, ends), (places[best] - 0.2, places[best] + 0.2)]
    climbed = optimize.minimize(
        lambda v: -errors(v[None, :-1], v[-1:])[0], [*x[best], places[best]], bounds=inside, method="Nelder-Mead"
    )
    assert 0.97 * found.bound < -climbed.fun <= found.bound


@pytest.mark.one_in(3)
@pytest.mark.parametrize("contact", CONTACTS)
def test_the_worst_cam_has_its_error_by_exact_contact_in_40_digits(contact):
    scene = scene_with_tolerances(contact)
    found, tables = camopt.tolerance(scene).worst_case, scene.to_dict()
    known = {key.removeprefix("follower."): each for key, each in found.errors.items()}
    known |= {key: np.radians(known[key]) for key in ("phase", "face_tilt") if key in known}
    with mp.workdps(DIGITS):
        known["bore"] = known.pop(BORE) * mp.expj(np.radians(known.pop(BORE_DIRECTION)))
        theta = mp.mpf(np.radians(found.at_deg))
        exact = displacement(tables, known, theta) - displacement(tables, {}, theta)
    assert found.error == pytest.approx(
        float(exact) * motion_unit_factor(resolve_design(scene).setup, 0), abs=1e-11
    )


@pytest.mark.slow
def test_random_cams_within_their_tolerances_are_within_the_bound():
    """Every mechanism, some laws, both senses, each with all errors at once, by exact contact in 40 digits."""
    rng, most = np.random.default_rng(9), 0.0
    for number in range(times(5, 300)):
        contact = [*CONTACTS][number % len(CONTACTS)]
        law, rotation = rng.choice(["poly345", "harmonic", "cycloidal", "modified-sine"]), rng.choice(["ccw", "cw"])
        scene = scene_with_tolerances(contact, str(law), str(rotation), 10 ** rng.uniform(-3, -1.5))
        problem, bound = resolve_design(scene), camopt.tolerance(scene).worst_case.bound
        shares = rng.choice([0.0, 1.0], 9) if number % 2 else rng.uniform(size=9)
        ends = error_ranges_at_one_contact(scene, problem)
        errors = {k: low + x * (high - low) for (k, (low, high)), x in zip(ends.items(), shares, strict=False)}
        place = rng.uniform(0.1, 6.1)
        found = RealCam(problem).tool_error_at_contact(flat_from_polar_errors(errors), np.array([place]))
        exact = exact_error(scene, errors, place, found.angle[0])
        unit = motion_unit_factor(problem.setup, 0)
        assert abs(found.error[0] - exact) < 1e-12
        assert abs(exact) * unit <= bound
        most = max(most, abs(exact) * unit / bound)
    assert most > 0.3


def test_where_the_velocity_jumps_no_bound_is_proved_and_it_is_said():
    scene = camopt.find_scene("uniform-knife-offset").replace(tolerances={"follower.offset": 0.01})
    found = camopt.tolerance(scene)
    assert np.isinf(found.worst_case.bound)
    assert "No bound of the displacement is proved: the velocity of the motion jumps at" in found.reason


def test_why_no_bound_is_proved_and_a_bound_that_is_far_above_are_said(monkeypatch):
    given = {"follower": {"offset": 0.01}, "profile": 0.05}
    scene = camopt.find_scene("roller-1000rpm").replace(tolerances=given)
    monkeypatch.setattr(worst_case, "DISPLACEMENT_GAP", 1e-2)
    found = camopt.tolerance(scene)
    above = found.worst_case.gap / abs(found.worst_case.error)
    assert 1e-3 < above < 1e-2
    assert f"The proven bound is {100 * above:.2g} % larger." in found.table().note
    monkeypatch.setattr(worst_case, "DISPLACEMENT_WORK", 0.0)
    found = camopt.tolerance(scene)
    assert np.isinf(found.worst_case.bound)
    assert found.reason.startswith(
        "No bound of the displacement is proved: the proof takes too much work. profile has the largest share:"
    )


@pytest.mark.slow
def test_the_command_shows_the_bound_and_the_worst_cam(command, tmp_path):
    file = tmp_path / "cut.toml"
    file.write_text(scene_with_tolerances("offset-roller").to_toml())
    assert "proven upper bound" in command("tolerance", file)[1]
    found = json.loads(command("tolerance", file, "--json")[1])["worst_case"]
    assert found["bound"] > abs(found["error"]) > 0.03
    corners = json.loads(command("tolerance", "uniform-knife-offset", "--set", "tolerances.phase=0.1", "--json")[1])
    assert corners["worst_case"]["bound"] is None


@pytest.mark.one_in(3)
@pytest.mark.parametrize("contact", ["offset-roller", "arm", "groove-arm"])
def test_the_worst_cam_with_its_reported_errors_has_its_reported_motion_error(contact):
    """Told in mm and deg, with the axis of the bore in the frame of the cam; by exact contact over the turn."""
    given = {"profile": 0.02, "bore_eccentricity": 0.02, "phase": 0.05}
    given |= {f"follower.{key}": 0.03 for key in SIZES[contact] if key != "face_tilt"}
    scene = Scene.from_dict({**scene_of(contact, "ccw"), "tolerances": given})
    worst, problem = camopt.tolerance(scene).worst_case, resolve_design(scene)
    places = np.linspace(0.0, 2 * np.pi, 20_001)[:-1]
    errors = motion_unit_factor(problem.setup, 0) * RealCams(problem).motion_errors(
        repeat_cam_errors(worst.errors, places.size), places, 0
    )
    assert np.abs(errors).max() == pytest.approx(abs(worst.error), rel=1e-6)
    assert errors[np.abs(errors).argmax()] * worst.error > 0.0
    again = camopt.tolerance(camopt.tolerance(scene).worst_motion()).worst_case  # the cam as a scene
    assert (again.error, again.errors) == (worst.error, worst.errors)
