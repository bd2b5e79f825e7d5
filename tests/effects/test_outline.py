"""Outer radius and clearance of a pivot: against points of the profile, closed forms, and what limits leave."""

import numpy as np
import pytest
from mpmath import mp, mpf
from support.cams import CONTACTS, cam_with

from camopt import BadInput, Scene, cam_points, evaluate, optimise, sweep
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


@pytest.mark.parametrize("contact", ["arm", "swinging-face"])
def test_the_turning_cam_stays_as_far_from_the_pivot_as_the_nearest_point_of_its_profile(contact):
    """In the cam's frame the pivot goes round it: the least distance of its path from any point of the profile."""
    scene = scene_of(contact).replace(outputs=["pivot_clearance_min_mm"])
    points = cam_points(scene, step=0.25)
    profile = points["profile_x_mm"] + 1j * points["profile_y_mm"]
    centre = scene.numbers(["follower.centre_distance"])["follower.centre_distance"]
    path = centre * np.exp(1j * np.radians(np.arange(0.0, 360.0, 0.25)))
    nearest = min(np.abs(path - each).min() for each in profile)
    assert evaluate(scene)["pivot_clearance_min_mm"] == pytest.approx(nearest, rel=1e-4)


def test_no_cam_of_a_grid_that_stays_clear_of_the_pivot_is_smaller():
    """With the centre distance free, a clearance makes it larger: that of the smallest cam at all leaves 8.3 mm."""
    search = {"base_radius": {"start": 20, "stop": 150}, "centre_distance": {"start": 60, "stop": 180}}
    limits = {"pressure_angle": 35, "pivot_clearance_min_mm": 15.0}
    scene = scene_of("swinging-face", limits=limits, search=search)
    best = optimise(scene).best
    assert best["proved"]
    assert evaluate(best.scene)["pivot_clearance_min_mm"] == pytest.approx(15.0, rel=1e-7)
    steps = {name: ends | {"step": 0.2} for name, ends in search.items()}
    seen = sweep(scene.replace(**{f"search.{name}": each for name, each in steps.items()})).best["cycloidal"]
    assert 0.0 <= seen["base_radius_mm"] - best["base_radius_mm"] < 0.5


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


def test_other_cams_have_none():
    with pytest.raises(BadInput, match="only a disc cam has one"):
        scene_of("groove", limits={"outer_radius": 100})
    with pytest.raises(BadInput, match="outer_radius_mm"):
        evaluate(scene_of("groove"))
    with pytest.raises(BadInput, match="this mechanism has no pivot_clearance_min_mm"):
        evaluate(scene_of("roller", limits={"pivot_clearance_min_mm": 10}))
