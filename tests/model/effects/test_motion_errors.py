"""Largest errors of the motion as quantities and limits, against the series that ``tolerance`` has of them."""

import numpy as np
import pytest
from support.cams import CONTACTS

import camopt
from camopt.core.kernels import compile
from camopt.core.mistakes import BadInput
from tests.solve.tolerances.test_recontact import tolerances_of
from tests.solve.tolerances.test_tolerance import TRAINS, scene_of

LOPSIDED = ("follower", "phase", "face_tilt")


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    """Few designs, of so many mechanisms that their kernels would be compiled."""
    monkeypatch.setattr(compile, "COMPILATION", np.inf)


def lopsided_zones(given):
    """Zones that go further to one side."""
    return {k: {"plus": v, "minus": v / 4} if k.startswith(LOPSIDED) else v for k, v in given.items()}


def errors_of(scene):
    """The quantities of a scene, by the start of their names."""
    found = camopt.evaluate(scene.replace(outputs=["motion_errors"]))
    return {name.partition("_error")[0]: found[name] for name in found if "_error_max" in name}


@pytest.mark.slow
@pytest.mark.one_in(18)
@pytest.mark.parametrize("given", [dict, lopsided_zones])
@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("contact", CONTACTS)
def test_they_are_those_of_the_series_of_the_answers(contact, rotation, given):
    """Whose coefficients are those of exact contact in 40 digits (test_response)."""
    scene = scene_of(contact, given=given(tolerances_of(contact)), rotation=rotation)
    found, known = errors_of(scene), camopt.tolerance(scene)
    for name, each in zip(("position", "velocity", "acceleration"), known.errors, strict=True):
        assert found[name] == pytest.approx(each.worst, rel=1e-11)
    assert found["dwell"] == pytest.approx(max(each.change for each in known.dwells), rel=1e-12)


@pytest.mark.parametrize(
    ("contact", "law", "given", "infinite"),
    [
        ("roller", "harmonic", {"profile": 0.02, "waves": 5, "follower.roller_radius": 0.01}, []),
        ("roller", "parabolic", {"follower.roller_radius": 0.01}, ["acceleration"]),
        ("offset-roller", "harmonic", {"profile": 0.02, "waves": 5}, ["acceleration"]),
        ("flat", "parabolic", {"profile": 0.02, "waves": 5, "bore_eccentricity": 0.01}, []),
        ("flat", "harmonic", {"phase": 0.01}, ["acceleration"]),
        ("groove", "linear", {"phase": 0.01}, ["velocity", "acceleration"]),
        ("groove", "harmonic", {"profile": 0.02, "waves": 5}, []),
    ],
)
def test_where_the_motion_jumps_they_are_infinite_as_series_have_it(contact, law, given, infinite):
    scene = scene_of(contact, law, given)
    found, known = errors_of(scene), camopt.tolerance(scene).errors
    for name, each in zip(("velocity", "acceleration"), known[1:], strict=True):
        assert np.isinf(found[name]) == (name in infinite)
        assert found[name] == pytest.approx(each.worst, rel=1e-11)


@pytest.mark.slow
def test_at_the_tool_they_are_those_that_come_through_its_train():
    given = {"profile": 0.02, "phase": 0.05}
    scene = scene_of("arm", given=given, train=[{"stage": "ratio", "radius": -30}])
    found, known = errors_of(scene.replace(**{"tolerances.waves": 7})), camopt.tolerance(scene)
    assert found["position"] == pytest.approx(known.errors[0].worst, rel=1e-12)
    known = camopt.tolerance(scene.replace(**{"tolerances.waves": 7})).errors[2]
    assert found["acceleration"] == pytest.approx(known.worst, rel=1e-11)
    rocker = scene_of("roller", given=given, train=[TRAINS["roller"]])
    assert errors_of(rocker)["position"] == pytest.approx(camopt.tolerance(rocker).errors[0].worst, rel=1e-9)


def test_a_limit_needs_tolerances():
    with pytest.raises(BadInput, match=r"limits\.position_error = 0\.02: needs tolerances"):
        camopt.evaluate(camopt.find_scene("bucket-valve").replace(**{"limits.position_error": 0.02}))
    scene = scene_of("roller", given={"profile": 0.02}, limits={"velocity_error": 0.01})
    with pytest.raises(BadInput, match=r"limits\.velocity_error = 0\.01: needs tolerances\.waves"):
        camopt.evaluate(scene)


@pytest.mark.slow
@pytest.mark.one_in(3)
@pytest.mark.parametrize("contact", ["offset-roller", "arm", "flat", "swinging-face", "groove-arm"])
def test_a_limit_is_proved_on_either_side_of_the_error(contact):
    scene = scene_of(contact, "poly4567", given=lopsided_zones(tolerances_of(contact)))
    for name, worst in errors_of(scene).items():
        for share, verdict in ((1 + 1e-9, "held"), (1 - 1e-9, "broken")):
            limited = scene.replace(**{f"limits.{name}_error": worst * share})
            assert camopt.certify(limited)[f"{name}_error"] == verdict


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
    y, y1, *_ = camopt.scene.problem.problem.resolve_design(nominal).programme.motion_at(angles)
    assert best["base_radius_mm"] + 14 == pytest.approx((np.abs(y1) / slope - y).max(), rel=1e-6)
    assert best["proved"]
    assert best["binding"] == ["position_error"]
    assert best["position_error_max_mm"] == pytest.approx(bound, rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("name", ["velocity", "acceleration"])
def test_the_smallest_cam_just_holds_a_limit_on_velocity_or_acceleration(name):
    """And a smaller one is refuted in balls, a robust box of its sizes proved."""
    scene = scene_of("offset-roller", "poly4567", given=tolerances_of("offset-roller"))
    bound = 0.97 * errors_of(scene)[name]
    asked = scene.replace(search={"base_radius": [20, 200]}, limits={f"{name}_error": bound})
    best = camopt.optimise(asked).best
    assert best["proved"]
    assert best["binding"] == [f"{name}_error"]
    for share, verdict in ((1.0, "held"), (1.0 - 1e-6, "broken")):
        cam = asked.replace(**{"cam.base_radius": best["base_radius_mm"] * share})
        assert camopt.certify(cam)[f"{name}_error"] == verdict
    room = best.scene.replace(**{f"limits.{name}_error": 1.01 * bound, "search.robust": True})
    assert camopt.certify(room)[f"{name}_error"] == "held"


def test_the_smallest_cam_with_a_limit_on_dwells_just_holds_it():
    """In closed form: the lower dwell has the pressure angle e/s₀, and the waves move its follower by 2t/cos β."""
    scene = scene_of("offset-roller", given={"profile": 0.02, "waves": 12}).replace(
        search={"base_radius": [20, 200]}, limits={"dwell_error": 0.0404}
    )
    best = camopt.optimise(scene).best
    prime = 11.0 / np.sqrt(1.0 - (0.04 / 0.0404) ** 2)  # cos β = s₀/R_p
    assert best["base_radius_mm"] == pytest.approx(prime - 14.0, rel=1e-8)
    assert best["binding"] == ["dwell_error"]


def test_a_batch_has_the_yield_of_the_limit():
    scene = scene_of("flat", given={"profile": 0.03}).replace(**{"limits.position_error": 0.01})
    batch = camopt.sample_cams(scene, cams=2**12)
    assert batch.held == batch.errors[0].held
    assert batch.held.share == pytest.approx(0.6827, abs=1e-3)  # one standard deviation
    swept = camopt.sweep(scene.replace(outputs=["motion_errors"], search={"base_radius": [60, 70]}), keep="all")
    assert swept.feasible == 0
