"""The outer radius: against points of the profile, closed forms, and the smallest cam within a housing."""

import numpy as np
import pytest
from mpmath import mp, mpf
from support.cams import CONTACTS, cam_with

from camopt import BadInput, Scene, cam_points, evaluate, optimise
from camopt.motion import LAWS

OPEN = [contact for contact in CONTACTS if not contact.startswith("groove")]


def scene_of(contact, law="cycloidal", rotation="ccw", **more):
    return Scene.from_dict(cam_with(contact, law, rotation=rotation, outputs=["outer_radius_mm"], **more))


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("contact", OPEN)
def test_no_point_of_the_profile_is_farther_and_one_is_as_far(contact, rotation):
    scene = scene_of(contact, rotation=rotation)
    points = cam_points(scene, step=0.05)
    farthest = np.max(np.hypot(points["profile_x_mm"], points["profile_y_mm"]))
    assert evaluate(scene)["outer_radius_mm"] == pytest.approx(farthest, rel=1e-12)  # a dwell at the highest


@pytest.mark.parametrize("law", LAWS)
def test_without_a_dwell_at_the_highest_it_is_reached_at_one_angle(law):
    """√(e² + (s₀ + h)²) − R_r in 50 digits."""
    motion = cam_with("offset-roller", law)["motion"]
    turn = [motion[0] | {"angle": 130}, motion[2] | {"angle": 120}, {"segment": "dwell", "angle": 110}]
    with mp.workdps(50):
        height = mp.sqrt(mpf(84) ** 2 - mpf(11) ** 2)
        exact = mp.sqrt(mpf(11) ** 2 + (height + 24) ** 2) - 14
    found = evaluate(scene_of("offset-roller", law, motion=turn))["outer_radius_mm"]
    assert found == pytest.approx(float(exact), rel=1e-13)


@pytest.mark.long
def test_the_smallest_cam_fits_its_housing_or_there_is_none():
    search = {"base_radius": {"start": 20, "stop": 120}, "law": ["cycloidal"]}
    wide = scene_of("offset-roller", limits={"pressure_angle": 30}, search=search)
    free = optimise(wide).best
    within = optimise(wide.replace(**{"limits.outer_radius": free["outer_radius_mm"] * (1 + 1e-6)})).best
    assert within["proved"]
    assert within["base_radius_mm"] == pytest.approx(free["base_radius_mm"], rel=1e-7)
    assert optimise(wide.replace(**{"limits.outer_radius": free["base_radius_mm"] + 24.0 - 1.0})).best is None


def test_a_cylindrical_cam_has_none():
    with pytest.raises(BadInput, match="only a disc cam has one"):
        scene_of("groove", limits={"outer_radius": 100})
    with pytest.raises(BadInput, match="outer_radius_mm"):
        evaluate(scene_of("groove"))
