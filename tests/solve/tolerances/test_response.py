"""First-order responses of the motion to small errors, against exact contact of cams with these errors."""

import numpy as np
import pytest
from mpmath import mp
from support.cams import CONTACTS, cam_with
from support.recontact import displacement

from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.solve.tolerances.response import ToolResponse

SIZES = {
    "knife": ("offset",),
    "roller": ("offset", "roller_radius"),
    "offset-roller": ("offset", "roller_radius"),
    "flat": ("offset", "face_tilt"),
    "spherical": ("offset", "face_radius"),
    "arm": ("arm_length", "centre_distance", "roller_radius"),
    "swinging-face": ("centre_distance", "face_offset"),
    "groove": (),
    "groove-arm": ("arm_length",),
}
EVERY = ("profile", "phase", "bore x", "bore y")
CASES = [(contact, key) for contact in CONTACTS for key in (*SIZES[contact], *EVERY)]
DIGITS, STEP, APART = 40, 1e-12, 1e-5


def package_response(answers, key):
    """What the package says."""
    if key.startswith("bore"):
        return answers.bore_responses_in_two_directions[key == "bore y"]
    if key == "profile":
        return answers.profile_response
    return answers.number_response(key if key in ("phase", "face_tilt") else f"follower.{key}")


def single_error(key, size):
    """An error of a kind."""
    return {"bore": mp.mpc(size) if key == "bore x" else mp.mpc(0, size)} if key.startswith("bore") else {key: size}


def scene_of(contact, rotation):
    law = "poly4567" if rotation == "cw" else "poly345"
    found = cam_with(contact, law, rotation=rotation)
    return {"name": "cut", "cam": found["cam"], "follower": found["follower"], "motion": found["motion"]}


@pytest.mark.one_in(5)
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize(("contact", "key"), CASES)
def test_responses_are_those_of_exact_contact_in_40_digits(contact, key, rotation):
    """The displacement, and its slopes by the cam angle, by differences of errors of 1e-12 mm (rad) either way."""
    scene, angles = scene_of(contact, rotation), np.array([0.7, 2.2, 3.1, 5.0])
    found = package_response(ToolResponse(resolve_design(Scene.from_dict(scene)), angles), key)
    with mp.workdps(DIGITS):
        for place, theta in enumerate(map(mp.mpf, angles.tolist())):

            def answer(theta):
                step = mp.mpf(STEP)
                ends = (displacement(scene, single_error(key, side * step), theta) for side in (1, -1))
                return (next(ends) - next(ends)) / (2 * step)

            near = [answer(theta + side * mp.mpf(APART)) for side in (-1, 0, 1)]
            exact = (
                near[1],
                (near[2] - near[0]) / (2 * APART),
                (near[2] - 2 * near[1] + near[0]) / mp.mpf(APART) ** 2,
            )
            size = max(1.0, *(abs(float(each)) for each in exact))
            np.testing.assert_allclose(
                found[:, place], [float(each) for each in exact], rtol=1e-7, atol=1e-7 * size
            )


@pytest.mark.one_in(5)
@pytest.mark.parametrize(("contact", "key"), CASES)
def test_neglected_terms_are_of_second_order(contact, key):
    """Errors of 20 µm (0.2 mrad) are off by four times what those of 10 µm are, and those by less than 0.05 µm."""
    scene, theta = scene_of(contact, "ccw"), mp.mpf(0.7)
    first = package_response(ToolResponse(resolve_design(Scene.from_dict(scene)), np.array([0.7])), key)[0, 0]
    with mp.workdps(DIGITS):
        nominal = displacement(scene, {}, theta)
        rest = [
            float(
                displacement(scene, single_error(key, mp.mpf(size)), theta) - nominal - mp.mpf(first) * mp.mpf(size)
            )
            for size in ((1e-4, 2e-4) if key in ("phase", "face_tilt") else (1e-2, 2e-2))
        ]
    assert abs(rest[0]) < 5e-5
    assert abs(rest[0]) < 1e-12 or rest[1] / rest[0] == pytest.approx(4.0, rel=0.05)
