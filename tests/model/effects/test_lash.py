"""Lash: the speeds at which a valve train takes up its lash and the valve returns to its seat."""

from math import isclose, pi, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.cams import cam_with

from camopt import BadInput, Scene, certify, evaluate, find_scene
from camopt.model.effects.lash import angle_span_above_level, lash_speeds
from camopt.model.motion import LAWS
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import INWARD, OUTWARD
from camopt.scene.problem.problem import resolve

LIFT = 10.0


def turn(rise, fall):
    segments = [
        ("rise", 90, LIFT, rise),
        ("dwell", 30, 0.0, None),
        ("return", 110, LIFT, fall),
        ("dwell", 130, 0.0, None),
    ]
    return Programme.from_segments(segments, angular=False)


def one_way(programme, low, high, way):
    found = lash_speeds(programme, low, high)
    return found.opening if way == OUTWARD else found.closing


def sampled_speed(programme, low, high, sign, count=200_001):
    """Largest speed of many samples between two levels, in one direction."""
    y, y1, _, _ = programme.motion_at(np.linspace(0.0, 2 * pi, count))
    inside = (y >= low) & (y <= high) & (sign * y1 > 0)
    return float(np.abs(y1[inside]).max(initial=0.0))


@pytest.mark.one_in(7)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("low", "high"), [(0.1, 0.3), (-1.0, 0.5), (4.0, 6.0), (9.9, 30.0), (10.5, 11.0)])
def test_speeds_between_levels_are_those_of_samples(law, low, high):
    programme = turn(law, law)
    for way, sign in ((OUTWARD, 1), (INWARD, -1)):
        found, expected = one_way(programme, low, high, way), sampled_speed(programme, low, high, sign)
        assert expected <= found * (1 + 1e-12)
        assert isclose(found, expected, rel_tol=2e-3, abs_tol=1e-9)  # as near as samples of a steep speed come


@given(st.floats(0.01, 9.99))
def test_the_speed_at_a_level_is_that_where_the_motion_is(level):
    """At lash without variation: y′ at the one angle where y is there, found by bisection."""
    programme = turn("cycloidal", "poly345")
    low, high = 0.0, radians(90)
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if programme.motion_at(np.array([middle]))[0, 0] < level else (low, middle)
    speed = programme.motion_at(np.array([high]))[1, 0]
    assert isclose(one_way(programme, level, level, OUTWARD), speed, rel_tol=1e-9)


@pytest.mark.parametrize("level", [0.0, 0.2, 5.0, 9.99, 10.5])
def test_the_angle_above_a_level_is_that_of_samples(level):
    programme = turn("modified-sine", "cycloidal")
    above = np.mean(programme.motion_at(np.linspace(0.0, 2 * pi, 400_001)[:-1])[0] > level) * 2 * pi
    assert isclose(angle_span_above_level(programme, level), above, abs_tol=1e-4)


def test_a_ramp_has_the_speed_that_it_was_given():
    """0.8 mm/rad at 3000 rev/min for any lash on the ramp; beyond the ramp the speed differs."""
    scene, speed = find_scene("bucket-valve"), 0.8 * 3000 * 2 * pi / 60 / 1000
    found = evaluate(scene.replace(outputs=["lash"]))
    for name in ("opening_speed_max_m_s", "closing_speed_max_m_s", "lash_speed_max_m_s"):
        assert found[name] == pytest.approx(speed, rel=1e-12)
    wide = evaluate(scene.replace(**{"follower.dynamics.lash_variation": 0.15, "outputs": ["lash"]}))
    assert wide["opening_speed_max_m_s"] > 1.2 * speed
    angles = np.linspace(0.0, 2 * pi, 720_001)[:-1]
    beyond = resolve(scene).programme.motion_at(angles)[0] > 0.15
    assert found["lash_open_deg"] == pytest.approx(360.0 * np.mean(beyond), abs=1e-3)


def test_a_limit_on_the_speed_at_the_lash():
    scene, speed = find_scene("bucket-valve"), 0.8 * 3000 * 2 * pi / 60 / 1000
    for factor, verdict in ((1.001, "held"), (0.999, "broken")):
        limited = scene.replace(**{"limits.lash_speed": speed * factor})
        assert certify(limited)["lash_speed"] == verdict
        assert evaluate(limited)["feasible"] is (verdict == "held")


@pytest.mark.parametrize("contact", ["roller", "arm", "groove-arm"])
def test_scaling_and_speed(contact):
    """Twice the rev/min is twice the speed; an arm has its lash in degrees and its speed in rad/s."""
    scene = Scene.from_dict({**cam_with(contact), "outputs": ["lash"]})
    scene = scene.replace(**{"follower.dynamics.lash": 0.4, "follower.dynamics.lash_variation": 0.1})
    unit = "rad_s" if contact != "roller" else "m_s"
    one, two = evaluate(scene), evaluate(scene.replace(**{"cam.rpm": 2 * scene.cam.rpm}))
    assert two[f"lash_speed_max_{unit}"] == pytest.approx(2 * one[f"lash_speed_max_{unit}"], rel=1e-12)
    assert two["lash_open_deg"] == one["lash_open_deg"]


def test_a_limit_without_a_lash_is_told():
    scene = cam_with("roller")
    with pytest.raises(BadInput, match=r"limits.lash_speed = 0.3: needs follower.dynamics.lash"):
        evaluate(Scene.from_dict({**scene, "limits": {"lash_speed": 0.3}}))


@pytest.mark.parametrize(
    ("lash", "variation", "line"),
    [
        (12.0, 0.0, "follower.dynamics.lash = 12.0: must be below the lift"),
        (0.1, 0.2, "follower.dynamics.lash_variation = 0.2: must be at most the lash (0.1)"),
    ],
)
def test_a_lash_that_no_valve_has_is_told(lash, variation, line):
    scene = find_scene("bucket-valve")
    with pytest.raises(BadInput) as caught:
        scene.replace(**{"follower.dynamics.lash": lash, "follower.dynamics.lash_variation": variation})
    assert line in str(caught.value)


def test_a_spring_on_the_valve_has_its_own_force_above_the_lash_with_the_preload_that_the_guide_says():
    """F₀ + c·(y − lash) on the seat side, and inertia, by hand at samples above the lash."""
    mass, rate, seat, lash = 0.11, 28.0, 250.0, 0.2
    loads = {"mass": mass, "spring_rate": rate, "preload": seat - rate * lash, "lash": lash}
    scene = find_scene("bucket-valve").replace(**{"follower.dynamics": loads, "outputs": ["contact_force_max_N"]})
    programme = resolve(scene).programme
    y, _, y2, _ = programme.motion_at(np.linspace(0, 2 * np.pi, 400001))
    above = y > lash
    omega = scene.cam.rpm * np.pi / 30
    force = seat + rate * (y - lash) + mass * omega**2 * y2 / 1e3
    assert evaluate(scene)["contact_force_max_N"] == pytest.approx(force[above].max(), rel=1e-6)
