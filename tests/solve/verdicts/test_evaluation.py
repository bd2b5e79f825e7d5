"""Every quantity against the sources' cams and against 50-digit computations (tests/support/naive.py)."""

import json
from math import isinf

import pytest
from support import naive
from support.references import REFERENCE, WORKED, relative_error

from camopt import QUANTITIES, Scene, evaluate, find_scene


@pytest.mark.parametrize("name", WORKED)
def test_worked_cams_of_the_sources(name):
    found = evaluate(find_scene(name))
    for quantity, expected in WORKED[name]["expected"].items():
        assert relative_error(found, quantity, expected) < 1e-13, quantity


@pytest.mark.parametrize("name", REFERENCE)
def test_each_mechanism_and_law_against_fifty_digits(name):
    found = evaluate(Scene.from_dict(REFERENCE[name]["scene"]))
    for quantity, expected in REFERENCE[name]["expected"].items():
        close = 1e-9 if quantity == "pressure_angle_max_at_deg" else 1e-11
        assert relative_error(found, quantity, expected) < close, quantity


def test_the_reference_covers_every_mechanism_and_law():
    scenes = [entry["scene"] for entry in REFERENCE.values()]
    pairs = {
        (s["cam"]["form"], s["follower"]["motion"], s["follower"]["contact"], segment["law"])
        for s in scenes
        for segment in s["motion"]
        if "law" in segment
    }
    mechanisms = {pair[:3] for pair in pairs}
    assert len(mechanisms) >= 8
    for mechanism in [m for m in mechanisms if m[:2] != ("disc", "oscillating") or m[2] in ("roller", "flat")]:
        assert {pair[3] for pair in pairs if pair[:3] == mechanism} >= set(naive.COMMON)


def variants(scene):
    """The scene mirrored: the other sense of rotation, and the offset on the other side."""
    other = {"ccw": "cw", "cw": "ccw"}[scene.cam.rotation]
    return scene.replace(**{"cam.rotation": other, "follower.offset": -scene.follower.offset or None})


@pytest.mark.parametrize("name", [n for n in WORKED if n != "oscillating-roller"])
def test_a_mirrored_scene_gives_the_same_bits(name):
    scene = find_scene(name)
    plain, mirrored = dict(evaluate(scene)), dict(evaluate(variants(scene)))
    assert plain.pop("offset_mm") == -mirrored.pop("offset_mm")
    assert plain == mirrored


LENGTHS = ("base_radius", "shaft_diameter", "roller_radius", "offset", "arm_length", "centre_distance")


@pytest.mark.parametrize("power", [-20, -3, 1, 20])
@pytest.mark.parametrize("name", ["two-pauses", "exhaust-valve", "flat-reciprocating", "roller-1000rpm"])
def test_lengths_scaled_by_a_power_of_two_scale_the_result_bit_for_bit(name, power):
    scene = find_scene(name).replace(limits=None, search=None)
    data = scene.to_dict()
    for table in (data["cam"], data["follower"]):
        for key in set(table) & set(LENGTHS):
            table[key] *= 2.0**power
    for segment in data["motion"]:
        segment["lift"] = segment.get("lift", 0.0) * 2.0**power
    plain, scaled = evaluate(scene), evaluate(Scene.from_dict(data))
    for quantity, value in plain.items():
        unit = QUANTITIES[quantity].unit
        factor = 2.0**power if unit.startswith(("mm", "m/")) else 2.0**-power if unit == "1/mm" else 1
        expected = value if isinstance(value, (bool, str)) else value * factor
        assert scaled[quantity] == expected, quantity


@pytest.mark.parametrize("name", WORKED)
def test_every_value_is_a_number_and_every_infinity_has_its_reason(name):
    found = evaluate(find_scene(name))
    for quantity, value in found.items():
        assert value == value, f"{quantity} is NaN"
        assert (quantity in found.unbounded) == (isinstance(value, float) and isinf(value))
    document = json.dumps(found.to_dict(), allow_nan=False)
    assert json.loads(document)["feasible"] in (True, False)


def test_named_outputs_are_all_that_is_computed():
    scene = find_scene("exhaust-valve").replace(outputs=["pressure_angle_max_deg"])
    assert set(evaluate(scene)) >= {"pressure_angle_max_deg", "base_radius_mm", "roller_radius_mm"}
    assert evaluate(scene)["base_radius_mm"] == scene.cam.base_radius
    assert "velocity_max_rise_mm_per_rad" not in evaluate(scene)
    assert "face_reach_max_mm" not in evaluate(scene)


def test_uniform_velocity_a_knife_follows_the_corner_and_a_roller_is_undercut():
    knife = find_scene("uniform-knife-radial")
    roller = knife.replace(**{"follower.contact": "roller", "follower.roller_radius": 5.0})
    assert evaluate(knife)["undercut"] is False
    assert evaluate(knife)["profile_radius_min_mm"] == 0.0
    assert evaluate(roller)["undercut"] is True
    assert evaluate(roller)["profile_radius_min_mm"] == -5.0
    assert evaluate(roller)["feasible"] is False
    assert evaluate(roller)["violated"] == "undercut"


@pytest.mark.parametrize("k", range(1, 13))
@pytest.mark.parametrize("side", [-1, 1])
def test_the_undercut_verdict_flips_at_the_critical_roller(k, side):
    """Harmonic, radial: κ_max of the pitch curve at constant prime radius does not depend on the roller."""
    scene = find_scene("valve-rod-radial").replace(**{"cam.shaft_diameter": None, "part": None})
    prime = 35.0
    critical = 1.0 / evaluate(scene)["pitch_curvature_max_per_mm"]
    radius = critical * (1 + side * 10.0**-k)
    changed = scene.replace(**{"follower.roller_radius": radius, "cam.base_radius": prime - radius})
    assert evaluate(changed)["undercut"] is (side > 0)


def test_an_undercut_profile_crosses_itself():
    """An undercut profile crosses itself; a plain one does not."""
    scene = find_scene("exhaust-valve")
    assert evaluate(scene)["self_crossing"] is False
    small = scene.replace(**{"cam.base_radius": 5.0})
    assert evaluate(small)["undercut"] is True
    assert evaluate(small)["self_crossing"] is True
