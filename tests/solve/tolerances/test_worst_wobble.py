"""Proven bounds of the movement in a dwell, and the cams that nearly reach them."""

import json

import numpy as np
import pytest
from mpmath import mp
from scipy import optimize
from support.real_cams import cams_of
from support.recontact import displacement

import camopt
from camopt.core.numerics.budget import UNLIMITED
from camopt.model.effects.motion import motion_unit_factor
from camopt.model.motion.stroke import DWELL
from camopt.scene.problem.problem import resolve_design
from camopt.scene.scene import Scene
from camopt.solve.tolerances.dwells_and_passages import WobbleSearch
from camopt.solve.tolerances.errors import BORE, BORE_DIRECTION, error_ranges_by_key_at_all_contacts
from camopt.solve.tolerances.turn_errors import TurnErrors
from camopt.solve.tolerances.worst_case import make_worst_cam_search
from tests.solve.tolerances.test_response import DIGITS
from tests.solve.tolerances.test_worst_case import scene_with_tolerances

OF_PAIR = {"disc_phase": 0.005, "profile": 0.01, "bore_eccentricity": 0.01, "follower.arm_length": 0.02}
OF_LINKS = {"train.1.coupler": 0.05, "train.1.crank": 0.02, "profile": 0.01, "bore_eccentricity": 0.01}


def cam_of(kind):
    """A cam with two dwells."""
    if kind == "pair":
        return camopt.find_scene("press-feed-by-pair").replace(part={}).replace(tolerances=OF_PAIR)
    if kind == "links":
        return camopt.find_scene("slide-by-bell-crank").replace(tolerances=OF_LINKS)
    return scene_with_tolerances(kind)


def first_dwell_error(scene):
    """The first dwell of a scene, with what cams wobble in it at most, however long that takes."""
    turn = TurnErrors(scene.with_profile_tolerance_moved, resolve_design(scene))
    stroke = next(each for each in turn.problem.programme.tool.strokes if each.kind == DWELL)
    return stroke, WobbleSearch(make_worst_cam_search(turn), stroke).find_worst_wobble(UNLIMITED)


@pytest.mark.slow
@pytest.mark.one_in(6)
@pytest.mark.parametrize("kind", ["offset-roller", "flat", "arm", "swinging-face", "groove-arm", "pair", "links"])
def test_no_cam_wobbles_more_than_the_bound_and_the_worst_cam_nearly_does(kind):
    """By 20,000 cams, half of them at corners, at two random places of the arc each, and a local search."""
    scene, rng, count = cam_of(kind), np.random.default_rng(2), 20_000
    (stroke, found), problem = first_dwell_error(scene), resolve_design(scene)
    zones, cams, unit = (
        error_ranges_by_key_at_all_contacts(scene.with_profile_tolerance_moved, problem),
        cams_of(problem, 0),
        motion_unit_factor(problem.setup, 0),
    )
    profiles = [key for key in zones if key.startswith("profile")]
    ends = np.array([*(zones[key] for key in zones if key != BORE_DIRECTION), *(zones[key] for key in profiles)])
    assert 0.0 <= found.gap <= 2e-4 * found.bound

    def wobbles(x, places):
        keys = [key for key in zones if key != BORE_DIRECTION]
        high = dict(zip(keys, x.T, strict=False))
        if BORE in high:  # in the frame of the cam
            high[BORE] = high[BORE] * np.exp(1j * x[:, -1])
        low = high | dict(zip(profiles, x.T[len(keys) :], strict=False))
        one, other = (cams.motion(each, at, 0).by_angle(0) for each, at in zip((high, low), places.T, strict=True))
        return unit * (one - other)

    share = rng.uniform(size=(count, len(ends)))
    share[count // 2 :] = rng.integers(0, 2, (count - count // 2, len(ends)))
    x = np.column_stack([ends[:, 0] + share * np.ptp(ends, axis=1), rng.uniform(-np.pi, np.pi, count)])
    places = stroke.start + stroke.angle * rng.uniform(0.001, 0.999, (count, 2))
    sampled = wobbles(x, places)
    assert sampled.max() <= found.bound
    best, most = int(sampled.argmax()), (stroke.start + 1e-6, stroke.end - 1e-6)
    inside = [*map(tuple, ends), (-4.0, 4.0), most, most]
    climbed = optimize.minimize(
        lambda v: -wobbles(v[None, :-2], v[None, -2:])[0], [*x[best], *places[best]], bounds=inside, method="Powell"
    )
    assert 0.97 * found.bound < -climbed.fun <= found.bound


@pytest.mark.parametrize("contact", ["offset-roller", "arm", "flat", "groove-arm"])
def test_the_worst_cam_of_a_dwell_has_its_places_by_exact_contact_in_40_digits(contact):
    scene = scene_with_tolerances(contact)
    (_, found), tables = first_dwell_error(scene), scene.to_dict()
    with mp.workdps(DIGITS):

        def place(errors, theta):
            known = {key.removeprefix("follower."): each for key, each in errors.items()}
            known |= {key: np.radians(known[key]) for key in ("phase", "face_tilt") if key in known}
            known["bore"] = known.pop(BORE) * mp.expj(np.radians(known.pop(BORE_DIRECTION)))
            return displacement(tables, known, mp.mpf(np.radians(theta)))

        exact = place(found.errors, found.highest_deg) - place(found.errors | found.at_lowest, found.lowest_deg)
    assert found.change == pytest.approx(
        float(exact) * motion_unit_factor(resolve_design(scene).setup, 0), abs=1e-10
    )


def dwelling_scene(contact, angle, tolerances):
    """A cam with a follower on the line of its axis that dwells over an angle, deg."""
    moving = [
        {"segment": each, "angle": (360 - angle) / 2, "lift": 10, "law": "poly345"} for each in ("rise", "return")
    ]
    follower = {"motion": "translating", "contact": contact, "offset": 0}
    motion = [moving[0], {"segment": "dwell", "angle": angle}, moving[1]]
    cam = {"form": "disc", "base_radius": 30}
    return Scene.from_dict(
        {"name": "rests", "cam": cam, "follower": follower, "motion": motion, "tolerances": tolerances}
    )


@pytest.mark.parametrize(
    ("contact", "angle", "tolerances", "exact"),
    [
        ("knife", 200, {"bore_eccentricity": 0.02}, 0.04),  # out by ε, and in by ε half a turn later
        ("flat", 60, {"bore_eccentricity": 0.02, "follower.offset": 0.5}, 0.04 * np.sin(np.radians(30))),
        ("flat", 60, {"profile": 0.01, "waves": 2}, 0.02 * np.sin(np.radians(60))),
        ("flat", 60, {"profile": 0.01, "waves": 9}, 0.02),
        ("knife", 60, {"profile": 0.01}, 0.02),
        ("knife", 60, {"follower.offset": 0.01, "phase": 0.1}, 0.0),
    ],
)
def test_the_bound_is_the_closed_form_where_there_is_one(contact, angle, tolerances, exact):
    _, found = first_dwell_error(dwelling_scene(contact, angle, tolerances))
    assert found.bound == pytest.approx(exact, rel=2e-4)
    assert found.change == pytest.approx(exact, rel=1e-6)
    assert found.bound >= exact * (1 - 1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("order", ["0110", "1100"], ids=["over the end of the turn", "neighbours"])
def test_a_dwell_in_two_segments_wobbles_as_the_whole(order):
    """By 2ε of a knife edge, in each that knows dwells; pieces of 90 deg have √2·ε."""
    moving = iter({"segment": each, "angle": 90, "lift": 10, "law": "poly345"} for each in ("rise", "return"))
    motion = [next(moving) if each == "1" else {"segment": "dwell", "angle": 90} for each in order]
    scene = dwelling_scene("knife", 60, {"bore_eccentricity": 0.02}).replace(motion=motion)
    (rests,) = camopt.tolerance(scene).dwells
    assert (rests.start_deg, rests.end_deg) == pytest.approx((270, 90) if order == "0110" else (180, 360))
    quantity = camopt.evaluate(scene.replace(outputs=["motion_errors"]))["dwell_error_max_mm"]
    assert (rests.change, rests.worst_case.change, quantity) == pytest.approx([0.04] * 3)
    assert 0.04 <= rests.worst_case.bound <= 0.04 * (1 + 1e-2)
    geared = scene.replace(train=[{"stage": "ratio", "ratio": 2}], outputs=["motion_errors"])
    by_sampling = camopt.evaluate(geared.replace(**{"tolerances.train.1.ratio": 1e-9}))["dwell_error_max_mm"]
    assert by_sampling == pytest.approx(0.08)
    worst = {each.name: each.worst for each in camopt.sample_cams(scene, cams=4096).errors}["change in a dwell"]
    assert worst > 0.05  # of a bore that is off by more than 4σ: 0.039 in a piece


def test_the_command_shows_the_bound_of_a_dwell_and_its_worst_cam(command, tmp_path, monkeypatch):
    file = tmp_path / "rests.toml"
    file.write_text(dwelling_scene("flat", 60, {"profile": 0.01, "bore_eccentricity": 0.02}).to_toml())
    out = " ".join(command("tolerance", file)[1].split())
    assert "change in a dwell, proven upper bound 0.04 " in out
    assert "with profile 0.01 mm, lowest at" in out
    (found,) = json.loads(command("tolerance", file, "--json")[1])["dwells"]
    assert found["worst_case"]["bound"] > found["worst_case"]["change"] > 0.0399999
    monkeypatch.setattr("camopt.solve.tolerances.tolerance.MOTION_PROOF_WORK", 0.0)
    late = camopt.tolerance(Scene.from_toml(file))
    assert np.isinf(late.dwells[0].worst_case.bound)
    assert (
        "No bound is proved for the dwell from 150 to 210 deg: the proof takes too much work." in late.table().note
    )
