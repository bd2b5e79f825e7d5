"""The least diameter of a bucket's face: against fifty digits, and against samples of the line of contact."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf
from support.cams import cam_with

from camopt import BadInput, Scene, evaluate, sweep
from camopt.scene.problem.problem import resolve

REFERENCE = {
    entry["id"]: entry
    for entry in json.loads((Path(__file__).parents[2] / "data" / "reference.json").read_text())
    if "face_reach_max_mm" in entry["expected"] and entry["scene"]["follower"]["motion"] == "translating"
}
DIAMETER = "face_diameter_min_mm"


@pytest.mark.parametrize("width", [None, 7.0])
@pytest.mark.parametrize("name", REFERENCE)
def test_the_diameter_against_fifty_digits(name, width):
    """Twice the hypotenuse of the larger reach, of the 50-digit reference, and half the width."""
    scene = Scene.from_dict(REFERENCE[name]["scene"]).replace(outputs=[DIAMETER])
    expected = REFERENCE[name]["expected"]
    with mp.workdps(50):
        reach = max(abs(mpf(expected[f"face_reach_{end}_mm"])) for end in ("max", "min"))
        exact = 2 * mp.sqrt(reach**2 + (mpf(width or 0) / 2) ** 2)
    found = evaluate(scene.replace(**{"materials.face_width": width}) if width else scene)
    assert found[DIAMETER] == pytest.approx(float(exact), rel=1e-12)


@given(width=st.floats(0.1, 60.0), offset=st.floats(-15.0, 15.0), rotation=st.sampled_from(["ccw", "cw"]))
def test_the_line_of_contact_never_leaves_the_circle_and_reaches_it(width, offset, rotation):
    """Both ends of the line as the cam turns: y′ of the motion, and the face's axis, by the rotation's sense."""
    flat = Scene.from_dict(cam_with("flat", "cycloidal", rotation=rotation))
    scene = flat.replace(**{"follower.offset": offset, "materials.face_width": width, "outputs": [DIAMETER]})
    sense = 1.0 if rotation == "ccw" else -1.0
    slopes = resolve(scene).programme.motion_at(np.linspace(0.0, 2 * np.pi, 36_001))[1]
    ends = np.hypot(slopes - offset * sense, width / 2)
    found = evaluate(scene)[DIAMETER]
    assert 2 * ends.max() <= found * (1 + 1e-12)
    assert 2 * ends.max() >= found * (1 - 1e-6)


def test_a_face_that_swings_has_none():
    with pytest.raises(BadInput, match=DIAMETER):
        evaluate(Scene.from_dict(cam_with("swinging-face", "cycloidal", outputs=[DIAMETER])))


def test_designs_of_a_sweep_have_the_diameter_of_their_law(tmp_path):
    scene = Scene.from_dict(cam_with("flat", "cycloidal", outputs=[DIAMETER]))
    search = {"base_radius": [60, 80], "law": ["cycloidal", "poly345"]}
    best = sweep(scene.replace(search=search, limits={}), tmp_path, keep="all").best
    assert len(best) == 2
    for row in best.values():
        assert row[DIAMETER] == pytest.approx(evaluate(row.scene)[DIAMETER], rel=1e-9)
