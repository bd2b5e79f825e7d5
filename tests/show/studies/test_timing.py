"""Where the follower passes a lift, beside the laws themselves, dense samples and the quantity of the lash."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import camopt
from camopt import BadInput, evaluate, find_scene, timing
from camopt.scene.problem.problem import resolve

SCENES = [*camopt.shipped_scenes()]
DENSE = 36_000


@pytest.mark.slow
@settings(deadline=None, max_examples=100)
@given(st.sampled_from(SCENES), st.floats(1e-3, 1 - 1e-3))
def test_it_is_above_just_between_the_angles_told(name, share):
    scene = find_scene(name)
    programme = resolve(scene).programme.tool
    lift = share * programme.lift / programme.unit_in_mm_or_rad
    passages = timing(scene, [lift]).passages
    assert passages
    ends = np.radians([(each.rises_at_deg, each.falls_at_deg) for each in passages])
    motion = programme.motion_at(ends.ravel() % (2 * np.pi))
    assert np.allclose(motion[0], lift * programme.unit_in_mm_or_rad, rtol=0, atol=1e-11 * programme.lift)
    angles = (np.arange(DENSE) + 0.5) / DENSE * 360
    above = programme.motion_at(np.radians(angles))[0] > lift * programme.unit_in_mm_or_rad
    told = np.zeros(DENSE, dtype=bool)
    for each in passages:
        told |= (angles - each.rises_at_deg) % 360 < each.above_deg
    assert np.mean(above != told) <= 3 * len(passages) / DENSE
    assert all(each.rising > 0 > each.falling for each in passages)


@pytest.mark.parametrize("name", ["bucket-valve", "rocker-valve"])
def test_without_a_lift_it_is_the_lash(name):
    scene = find_scene(name)
    (found,) = timing(scene).passages
    assert found.lift == scene.follower.dynamics.lash
    quantities = evaluate(scene.replace(outputs=["lash"]))
    assert found.above_deg == pytest.approx(quantities["lash_open_deg"], rel=1e-12)
    fixed = evaluate(scene.replace(**{"outputs": ["lash"], "follower.dynamics.lash_variation": None}))
    (speed,) = (fixed[key] for key in fixed if key.startswith("opening_speed"))
    assert found.rising == pytest.approx(speed, rel=1e-9)


def test_without_a_lash_it_is_half_of_the_lift():
    scene = find_scene("roller-1000rpm")
    (found,) = timing(scene).passages
    assert found.lift == pytest.approx(25.0)


def test_a_rest_at_the_lift_is_not_above_it():
    scene = find_scene("knife-300rpm-radial")
    steps = [
        {"segment": "rise", "angle": 60, "lift": 10, "law": "cycloidal"},
        {"segment": "dwell", "angle": 60},
        {"segment": "rise", "angle": 60, "lift": 10, "law": "cycloidal"},
        {"segment": "return", "angle": 180, "lift": 20, "law": "cycloidal"},
    ]
    (found,) = timing(scene.replace(motion=steps), [10.0]).passages
    assert found.rises_at_deg == pytest.approx(120.0, abs=0.01)  # a dwell's end is flat: its place is not sharp
    assert found.falls_at_deg == pytest.approx(270.0)


def test_over_the_start_of_the_turn():
    scene = find_scene("knife-300rpm-radial")
    steps = [
        {"segment": "return", "angle": 90, "to": 0, "law": "harmonic"},
        {"segment": "dwell", "angle": 90},
        {"segment": "rise", "angle": 90, "to": 10, "law": "harmonic"},
        {"segment": "dwell", "angle": 90},
    ]
    (found,) = timing(scene.replace(motion=steps), [5.0]).passages
    assert (found.rises_at_deg, found.falls_at_deg) == (pytest.approx(225.0), pytest.approx(45.0))
    assert found.above_deg == pytest.approx(180.0)


@pytest.mark.parametrize("lift", [0, -1, 50, 51, True, "1", float("nan")])
def test_a_lift_that_is_not_passed(lift):
    with pytest.raises(BadInput, match=r"lift = .*: must be above 0 and below the largest lift \(50 mm\)"):
        timing(find_scene("roller-1000rpm"), [lift])


def test_the_command(command):
    code, out, _ = command("timing", "bucket-valve", "--lift", "1", "--lift", "2", "--json")
    told = json.loads(out)
    found = timing(find_scene("bucket-valve"), [1.0, 2.0])
    assert (code, told["velocity_unit"]) == (0, "m/s")
    assert told["passages"] == found.records()
    code, out, _ = command("timing", "bucket-valve")
    assert code == 0
    assert "149.973" in out
    assert command("timing", "--lift", "60")[0] == 2


def test_a_scene_with_the_speed_of_its_crank_has_the_angles_of_that_too(command, tmp_path):
    file = tmp_path / "valve.toml"
    file.write_text(find_scene("bucket-valve").to_toml().replace("rpm = 3000.0", "rpm_of_crank = 6000"))
    (told,) = json.loads(command("timing", file, "--json")[1])["passages"]
    assert {name: told[name] for name in told if "crank" in name} == {
        f"{name}_crank_deg": 2.0 * told[f"{name}_deg"] for name in ("rises_at", "falls_at", "above")
    }
    assert "299.946" in command("timing", file)[1]
