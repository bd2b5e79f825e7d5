"""Largest errors of the motion as quantities and limits, against the series that ``tolerance`` has of them."""

import numpy as np
import pytest

import camopt
from camopt.mistakes import BadInput
from tests.support.cams import CONTACTS
from tests.tolerances.test_recontact import given_of
from tests.tolerances.test_tolerance import TRAINS, scene_of

LOPSIDED = ("follower", "phase", "face_tilt")


def lopsided(given):
    """Zones that go further to one side."""
    return {k: {"plus": v, "minus": v / 4} if k.startswith(LOPSIDED) else v for k, v in given.items()}


def errors_of(scene):
    """The two quantities of a scene, by the start of their names."""
    found = camopt.evaluate(scene.replace(outputs=["motion_errors"]))
    return {name.partition("_error")[0]: found[name] for name in found if "_error_max" in name}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("given", [dict, lopsided])
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("contact", CONTACTS)
def test_they_are_those_of_the_series_of_the_answers(contact, rotation, given):
    """Whose coefficients are those of exact contact in 40 digits (test_response)."""
    scene = scene_of(contact, given=given(given_of(contact)), rotation=rotation)
    found, known = errors_of(scene), camopt.tolerance(scene)
    assert found["position"] == pytest.approx(known.errors[0].worst, rel=1e-12)
    assert found["dwell"] == pytest.approx(max(each.change for each in known.dwells), rel=1e-12)


def test_at_the_tool_they_are_those_of_a_constant_ratio_and_of_no_other_train():
    given = {"profile": 0.02, "phase": 0.05}
    scene = scene_of("arm", given=given, train=[{"stage": "ratio", "radius": -30}])
    assert errors_of(scene)["position"] == pytest.approx(camopt.tolerance(scene).errors[0].worst, rel=1e-12)
    rocker = scene_of("roller", given=given, train=[TRAINS["roller"]], limits={"position_error": 0.1})
    with pytest.raises(BadInput, match="has no position_error_max"):
        camopt.evaluate(rocker)


def test_a_limit_needs_tolerances():
    with pytest.raises(BadInput, match=r"limits\.position_error = 0\.02: needs tolerances"):
        camopt.evaluate(camopt.find_scene("bucket-valve").replace(**{"limits.position_error": 0.02}))


@pytest.mark.parametrize("contact", ["offset-roller", "arm", "flat", "swinging-face", "groove-arm"])
def test_a_limit_is_proved_on_either_side_of_the_error(contact):
    scene = scene_of(contact, given=lopsided(given_of(contact)))
    worst = errors_of(scene)["position"]
    for share, verdict in ((1 + 1e-9, "held"), (1 - 1e-9, "broken")):
        limited = scene.replace(**{"limits.position_error": worst * share})
        assert camopt.certify(limited)["position_error"] == verdict


def test_the_smallest_cam_with_a_limit_is_that_of_its_closed_form():
    """Without an offset the error of a profile is t·√(1 + T²), T = y'/(R_p + y), so that T is bounded."""
    given, bound = {"profile": 0.02, "bore_eccentricity": 0.01}, 0.0324
    scene = scene_of("roller", given=given).replace(
        search={"base_radius": [20, 200]}, limits={"position_error": bound}
    )
    best = camopt.optimise(scene).best
    slope = np.sqrt((bound / 0.03) ** 2 - 1.0)
    nominal = scene_of("roller", given=given)
    angles = np.linspace(0.0, 2 * np.pi, 200_001)
    y, y1, *_ = camopt.problem.problem.resolve_design(nominal).programme.at(angles)
    assert best["base_radius_mm"] + 14 == pytest.approx((np.abs(y1) / slope - y).max(), rel=1e-6)
    assert best["proved"]
    assert best["binding"] == ["position_error"]
    assert best["position_error_max_mm"] == pytest.approx(bound, rel=1e-9)


def test_a_batch_has_the_yield_of_the_limit():
    scene = scene_of("flat", given={"profile": 0.03}).replace(**{"limits.position_error": 0.01})
    batch = camopt.sample_cams(scene, cams=2**12)
    assert batch.held == batch.errors[0].held
    assert batch.held.share == pytest.approx(0.6827, abs=1e-3)  # one standard deviation
    swept = camopt.sweep(scene.replace(outputs=["motion_errors"], search={"base_radius": [60, 70]}), keep="all")
    assert swept.feasible == 0
