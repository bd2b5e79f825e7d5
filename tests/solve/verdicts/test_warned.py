"""Warnings in results: lost contact, steep grooves, and moves beyond every position in the scene."""

import json
import re

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from support.cams import FREE, UNGUIDED, cam_with
from support.depth import times

import camopt
from camopt import BadInput, Scene, evaluate, find_scene
from camopt.cli.main import main
from camopt.scene.problem.problem import resolve

# ------------------------------------------------------------------------------------------ the elastic train

TRAIN = {**FREE, "preload": 100.0, "natural_frequency": 40.0, "damping_ratio": 0.05}


def scene_with_train(contact="roller", **changes):
    scene = cam_with(contact, dynamics={**TRAIN, **changes}, rpm=600)
    return Scene.from_dict({**scene, "outputs": []})


@pytest.mark.parametrize("preload", [100.0, 300.0, 600.0, 1000.0])
@pytest.mark.parametrize("frequency", [20.0, 40.0, 80.0, 150.0])
def test_contact_that_only_a_rigid_train_keeps_is_told(preload, frequency):
    scene = scene_with_train(preload=preload, natural_frequency=frequency)
    asked = evaluate(scene.replace(outputs=["force", "vibration"]))
    rigid, elastic = (asked[f"contact_force_{name}min_N"] for name in ("", "elastic_"))
    told = evaluate(scene).warnings
    assert rigid > 0.0
    assert bool(told) == (elastic <= 0.0)
    for sentence in told:
        numbers = [float(text) for text in re.findall(r"-?[\d.]+(?= N\b)", sentence)]
        assert numbers == pytest.approx([elastic, rigid], rel=1e-3)
        assert f"{frequency:g} Hz" in sentence


def test_nothing_is_told_of_what_is_asked_known_or_not_given():
    limited = scene_with_train().replace(limits={"contact_force_elastic": 10.0})
    assert (evaluate(limited)["violated"], evaluate(limited).warnings) == ("contact_force_elastic", ())
    assert evaluate(scene_with_train(preload=0.0, spring_rate=0.0)).warnings == ()  # no train keeps contact
    assert evaluate(Scene.from_dict({**cam_with("roller", dynamics=FREE), "outputs": []})).warnings == ()
    train = {**UNGUIDED, "preload": 100.0, "natural_frequency": 40.0}
    assert evaluate(Scene.from_dict(cam_with("groove", dynamics=train, rpm=600))).warnings == ()


def test_resonance_is_told():
    resonant = scene_with_train(natural_frequency=40.0, damping_ratio=0.0)
    assert "it is in resonance" in evaluate(resonant).warnings[0]


def test_stress_that_inertia_relieves_is_told_where_it_is_beyond_its_limit_at_low_speed():
    """At the nose of a valve cam; the stress at low speed is that of the scene at 1 rev/min."""
    data = find_scene("bucket-valve").to_dict() | {
        "materials": {"cam": "steel", "follower": "steel", "face_width": 14}
    }
    data["follower"]["dynamics"] = {"mass": 0.12, "spring_rate": 35, "preload": 280}
    scene = Scene.from_dict({**data, "limits": {}, "outputs": ["hertz"]})
    fast, slow = (evaluate(scene.replace(**{"cam.rpm": rpm}))["contact_stress_max_MPa"] for rpm in (3000, 1))
    assert slow > 1.02 * fast

    def warnings_at(limit):
        return evaluate(scene.replace(**{"limits.contact_stress": limit})).warnings

    (sentence,) = warnings_at(1.01 * fast)
    numbers = [float(text) for text in re.findall(r"[\d.]+(?= MPa)", sentence)]
    assert numbers == pytest.approx([slow, 1.01 * fast, fast], rel=1e-3)
    assert warnings_at(1.01 * slow) == warnings_at(0.99 * fast) == ()


def test_a_groove_that_is_steeper_at_its_bottom_than_allowed_is_told():
    """tan β is as 1/R under a follower that translates: within the limit at the mean radius, and not further in."""
    scene = camopt.find_scene("feeder-with-stop").replace(part={"groove_depth": 12})
    mean = evaluate(scene.replace(outputs=["pressure"]))["pressure_angle_max_deg"]
    limited = scene.replace(limits={"pressure_angle": mean + 0.01})
    (told,) = evaluate(limited).warnings
    bottom = np.degrees(np.arctan(np.tan(np.radians(mean)) * 100 / 94))
    assert float(re.search(r"is ([\d.]+) deg", told)[1]) == pytest.approx(bottom, abs=0.006)
    assert evaluate(limited.replace(**{"limits.pressure_angle": bottom + 0.01})).warnings == ()
    by_bottom = limited.replace(**{"limits.pressure_angle_max_bottom_deg": mean})
    assert (evaluate(by_bottom)["violated"], evaluate(by_bottom).warnings) == ("pressure_angle_max_bottom_deg", ())


def test_every_way_to_look_at_a_cam_tells_it(tmp_path, capsys):
    scene = scene_with_train().replace(**{"limits.pressure_angle": 30})
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml(), encoding="utf-8")
    for command in ("evaluate", "optimise"):
        main([command, str(path), "--json"])
        out, err = capsys.readouterr()
        (told,) = json.loads(out)["warnings"]
        assert told.startswith("the elastic train (natural frequency 40 Hz) loses contact")
        assert f"camopt: {told}" in err
    page = camopt.report(scene, tmp_path / "page.html").read_text(encoding="utf-8")
    assert f"T{told[1:]}." in page


# ------------------------------------------------------------------------------------- beyond what was asked

CAM = {
    "cam": {"form": "disc", "base_radius": 30},
    "follower": {"motion": "translating", "contact": "roller", "roller_radius": 10},
}


def scene_of(*moves):
    """A turn of moves, (angle, to, more of them), and a dwell."""
    rows = [{"segment": "move", "angle": angle, "to": to, **more} for angle, to, more in moves]
    left = 360 - sum(row["angle"] for row in rows)
    return Scene.from_dict({**CAM, "motion": [*rows, {"segment": "dwell", "angle": left}]})


def sampled_positions(scene):
    """Positions of a turn at many cam angles, deg and as given: by its laws, from where the last move ends."""
    degrees = np.linspace(0.0, 360.0, 36_001)[:-1]
    y = resolve(scene).programme.motion_at(np.radians(degrees))[0]
    return degrees, y - y[0] + [row.to for row in scene.motion if row.to is not None][-1]


NOSE = ((70, 8.75, {}), (50, 6.0, {}), (80, 0.0, {}))


def test_a_nose_that_does_not_rest_is_told():
    scene = scene_of(*NOSE)
    (told,) = evaluate(scene).warnings
    degrees, y = sampled_positions(scene)
    at, angle, asked = map(
        float, re.search(r"goes to (\S+) mm at (\S+)°, above .* scene \((\S+) mm\)", told).groups()
    )
    assert at == pytest.approx(y.max(), abs=1e-4)
    assert angle == pytest.approx(degrees[y.argmax()], abs=0.05)
    assert at > asked == 8.75
    assert told.endswith("; motion.1.velocity = 0 stops it")


positions = st.floats(-20.0, 20.0).map(lambda y: round(y, 2))


@settings(max_examples=times(5, deep=500))
@given(st.lists(st.tuples(st.integers(40, 80), positions), min_size=2, max_size=4))
def test_what_is_told_to_stop_a_motion_does(moves):
    """And a motion of which nothing is told goes nowhere that was not asked."""
    assume(len({y for _, y in moves}) > 1)
    rows = [(angle, y, {}) for angle, y in moves]
    scene = scene_of(*rows)
    told, (_, y) = evaluate(scene).warnings, sampled_positions(scene)
    asked, room = [y for _, y in moves], 1e-5 * np.ptp(y)
    for sentence in told:
        if "through" in sentence:
            continue
        side = 1 if "above every" in sentence else -1
        assert (side * y).max() > max(side * p for p in asked)
        resting = {int(number) - 1 for number in re.findall(r"motion\.(\d)\.velocity = 0", sentence)}
        rested = scene_of(*((a, p, {"velocity": 0.0} if k in resting else {}) for k, (a, p) in enumerate(moves)))
        _, kept = sampled_positions(rested)
        assert (side * kept).max() <= max(side * p for p in asked) + room
    if not told:
        assert y.max() <= max(asked) + room
        assert y.min() >= min(asked) - room


def test_a_motion_that_has_to_go_on_is_not_told():
    """Behind a belt at constant velocity the follower goes on, and what a law of its own does was given."""
    for name in ("belt-matching", "feeder-with-stop", "press-with-drift"):
        assert not evaluate(camopt.find_scene(name)).warnings
    assert not evaluate(scene_of(*((a, y, {"velocity": 0.0} if y else {}) for a, y, _ in NOSE))).warnings
    with pytest.raises(BadInput, match=r"motion\.1\.velocity = 'none': must be a number"):
        scene_of((70, 8.75, {"velocity": "none"}))
