"""The pressure angle at the bottom of a groove, against the slope of the motion and a cam of that radius."""

import numpy as np
import pytest
from support.cams import cam_with

from camopt import BadInput, Scene, evaluate
from camopt.scene.problem.problem import resolve_design

BOTTOM, DEPTH = "pressure_angle_max_bottom_deg", 16.0


def groove(contact, **changes):
    return Scene.from_dict(cam_with(contact, "cycloidal", part={"groove_depth": DEPTH})).replace(**changes)


def test_at_the_bottom_a_groove_is_steeper_by_the_share_of_the_radii():
    scene = groove("groove")
    slope = resolve_design(scene).programme.motion_at(np.linspace(0, 2 * np.pi, 400_001))[1]
    bottom = scene.cam.mean_radius - DEPTH / 2
    assert evaluate(scene)[BOTTOM] == pytest.approx(np.degrees(np.arctan(np.abs(slope).max() / bottom)), abs=1e-7)


@pytest.mark.parametrize("contact", ["groove", "groove-arm"])
def test_at_the_bottom_it_is_that_of_a_cam_of_its_radius(contact):
    scene = groove(contact)
    inner = scene.replace(**{"cam.mean_radius": scene.cam.mean_radius - DEPTH / 2})
    found = evaluate(scene)
    assert found[BOTTOM] == pytest.approx(evaluate(inner)["pressure_angle_max_deg"], rel=1e-12)
    assert found[BOTTOM] > found["pressure_angle_max_deg"]


def test_it_needs_the_depth():
    with pytest.raises(BadInput, match=r"part\.groove_depth"):
        evaluate(groove("groove", part={}, **{f"limits.{BOTTOM}": 40}))
