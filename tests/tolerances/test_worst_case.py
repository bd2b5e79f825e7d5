"""The exact error of cams that are off, and what none of them exceeds."""

import numpy as np
import pytest
from mpmath import mp

from camopt.numerics.taylor import Taylor
from camopt.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.tolerances.touching import BORE, BORE_WAY, contact_of, off_by
from tests.support.cams import CONTACTS
from tests.support.recontact import displacement
from tests.tolerances.test_response import DIGITS, SIZES, scene_of

TENTH = 1e-4
"""rad"""


def random_errors(rng, contact, size=0.02):
    """Errors of every kind that a cam can have, as the package and as exact contact take them."""
    lengths = {key: rng.uniform(-size, size) for key in SIZES[contact] if key != "face_tilt"}
    others = {"profile": rng.uniform(-size, size), "phase": rng.uniform(-5, 5) * TENTH}
    if "face_tilt" in SIZES[contact]:
        others["face_tilt"] = rng.uniform(-5, 5) * TENTH
    bore = {BORE: rng.uniform(-size, size)} | (
        {} if contact.startswith("groove") else {BORE_WAY: rng.uniform(-3, 3)}
    )
    return {**{f"follower.{key}": each for key, each in lengths.items()}, **others, **bore}, lengths | others


@pytest.mark.one_in(3)
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("contact", CONTACTS)
def test_where_a_follower_rests_is_its_exact_contact_in_40_digits(contact, rotation):
    scene, rng = scene_of(contact, rotation), np.random.default_rng(3)
    problem = resolve_design(Scene.from_dict(scene))
    sense = problem.design.sense
    for place in (0.4, 1.7, 2.4, 3.5, 5.9):
        errors, known = random_errors(rng, contact)
        found = contact_of(problem, errors, np.array([place]))
        turned = place if BORE_WAY in errors else found.angle[0] + errors["phase"]
        with mp.workdps(DIGITS):
            known["bore"] = errors[BORE] * mp.expj(errors.get(BORE_WAY, 0) - sense * mp.mpf(turned))
            theta = mp.mpf(found.angle[0])
            exact = displacement(scene, known, theta) - displacement(scene, {}, theta)
        assert found.error[0] == pytest.approx(float(exact), abs=1e-13)


@pytest.mark.parametrize("contact", ["offset-roller", "arm", "flat", "swinging-face", "groove-arm"])
def test_where_a_follower_rests_has_the_slopes_of_its_series(contact):
    """By differences of the numbers themselves, of a motion that is known as a series."""
    problem = resolve_design(Scene.from_dict(scene_of(contact, "ccw")))
    errors, _ = random_errors(np.random.default_rng(1), contact)
    step, places = 1e-4, 1.1 + 1e-4 * np.arange(-1, 2)
    y, y1, y2, y3 = problem.programme.at(places)
    mechanism, lift = problem.setup.mechanism, problem.programme.lift
    numbers = mechanism.rest(problem.design, lift, y, y1, off_by(errors))
    series = mechanism.rest(problem.design, lift, Taylor([y, y1, y2 / 2]), Taylor([y1, y2, y3 / 2]), off_by(errors))
    for near, found in zip(numbers, series, strict=True):
        np.testing.assert_allclose(found.terms[0], near, rtol=1e-13, atol=1e-16)
        slopes = (near[2] - near[0]) / (2 * step), (near[2] - 2 * near[1] + near[0]) / step**2
        for order, slope in enumerate(slopes, start=1):
            assert found.derivative(order)[1] == pytest.approx(slope, rel=1e-5, abs=1e-8)
