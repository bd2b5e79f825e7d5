"""Animated machines: each part is at every frame where the phase and ratio of its station put it."""

from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image
from support.drawn_machines import random_machine
from support.pictures import faults_of

import camopt
from camopt.scene.machine import Machine
from camopt.scene.problem.problem import resolve_design
from camopt.show.drawing.moving_bodies import FRAME_ANGLES, FRAMES, reading_texts
from camopt.show.machines.animated_machine import (
    animated_machine_figure,
    cam_angles,
    machine_tools,
    rounded_outline,
)
from camopt.show.machines.timing_spans import TimingData
from camopt.solve.machine.stations import resolve_stations

G = "{http://www.w3.org/2000/svg}"
SQUARE = [[-5, -5], [5, -5], [5, 5], [-5, 5]]


def two_stations():
    """A sliding and a turning tool, at phases and ratios that are not round."""
    slider = {"name": "slider", "scene": "two-pauses", "phase": 77.7, "ratio": 3, "direction": 30}
    lever = {"name": "lever", "scene": "oscillating-roller", "phase": -20.2, "ratio": 2, "pivot": [40, 10]}
    return Machine(
        name="Two",
        station=[slider | {"outline": SQUARE}, lever | {"outline": SQUARE, "sense": "cw"}],
        body=[{"name": "post", "outline": [[60, 0]], "outline_radius": 3}],
    )


def displacement(scene, ratio, phase):
    """Of the follower above its position at cam angle 0, at the frames [mm or rad]."""
    cam = np.degrees(FRAME_ANGLES) * ratio - phase * ratio
    programme = resolve_design(scene).programme
    return programme.motion_at(np.radians(cam % 360.0), 0)[0] - programme.motion_at(np.zeros(1), 0)[0]


def test_parts_of_each_station_are_at_its_cam_angle():
    machine = two_stations()
    with animated_machine_figure(machine) as stage:
        cam, follower, _, other_cam, other_follower, _, *tools = stage.bodies[:9]
    for body, follow, station in zip((cam, other_cam), (follower, other_follower), machine.station, strict=True):
        scene, (ratio, phase) = machine.scenes[station.name], (station.ratio, np.radians(station.phase))
        sense = 1.0 if scene.cam.rotation == "ccw" else -1.0
        point = np.array([10.0 + 3.0j])
        expected = point * np.exp(1j * sense * ratio * (FRAME_ANGLES - phase))
        np.testing.assert_allclose(body.positions(point)[0], expected)
        moved = displacement(scene, ratio, station.phase)
        if scene.follower.motion == "translating":
            np.testing.assert_allclose(follow.positions(point)[0], point + 1j * moved, atol=1e-9)
        else:
            turned = (follow.positions(point)[0] - follow.origin) / (point - follow.origin)
            np.testing.assert_allclose(np.abs(np.angle(turned)), np.abs(moved), atol=1e-9)
    slider, lever, post = (tool.positions(np.array([7.0 - 2.0j]))[0] for tool in tools)
    lift = displacement(machine.scenes["slider"], 3, 77.7)
    np.testing.assert_allclose(slider, 7.0 - 2.0j + lift * np.exp(1j * np.pi / 6), atol=1e-9)
    turn = displacement(machine.scenes["lever"], 2, -20.2)
    np.testing.assert_allclose(lever, (7.0 - 2.0j - (40 + 10j)) * np.exp(-1j * turn) + 40 + 10j, atol=1e-9)
    np.testing.assert_allclose(post, 7.0 - 2.0j)


@pytest.mark.slow
def test_cursor_dots_and_readings_follow_the_lifts():
    machine = camopt.find_machine("pick-and-place")
    with animated_machine_figure(machine) as stage:
        dots, readings = stage.bodies[-4:], stage.readings
    data = TimingData.from_machine(machine)
    line = stage.bodies[-5]
    steps = np.diff(line.path.real)
    np.testing.assert_allclose(steps, steps[0])
    assert [each.values[25] for each in readings[:1]] == ["90.0°"]
    for dot, reading, station in zip(dots, readings[1:], data.stations, strict=True):
        np.testing.assert_allclose(dot.path.real, line.path.real)
        lift = station.lift.value(FRAME_ANGLES)
        rows = dot.path.imag - dot.path.imag.min()
        np.testing.assert_allclose(rows / rows.max(), lift / lift.max(), atol=1e-6)
        shown = [float(text.split()[0].replace("−", "-")) for text in reading.values]
        np.testing.assert_allclose(shown, lift, atol=6e-3)


@pytest.mark.slow
def test_no_text_hides_another():
    with animated_machine_figure(random_machine(12, 12)) as stage:
        for body in stage.bodies:
            body.axes.set_visible(False)
        assert faults_of(stage.figure) == []
    width, height = stage.figure.get_size_inches() * 100
    assert (round(width) % 2, round(height) % 2) == (0, 0)


def test_cam_angles_begin_near_0_and_go_on():
    for station in resolve_stations(random_machine(4, 2)):
        angles = cam_angles(station, FRAME_ANGLES)
        assert -np.pi <= angles[0] <= np.pi
        assert np.ptp(angles) == pytest.approx(2 * np.pi * station.station.ratio)


@pytest.mark.slow
def test_files_are_whole_and_the_same(tmp_path):
    machine = two_stations()
    animation = camopt.animate(machine, tmp_path / "a.gif")
    assert (animation.name, animation.svg) == ("Two", camopt.animate(machine).svg)
    assert "<script" not in animation.svg
    groups = [each for each in ElementTree.fromstring(animation.svg).iter(f"{G}g") if each.get("id") == "body-0"]
    (motion,) = groups[0].iter(f"{G}animateTransform")
    (turned,) = [each for each in groups[0].iter(f"{G}g") if each.get("transform", "").startswith("rotate(")]
    assert turned.get("transform") == f"rotate({motion.get('values').split(';')[0]})"
    values = [float(value.split()[0]) for value in motion.get("values").split(";")]
    first = (np.degrees(cam_angles(resolve_stations(machine)[0], FRAME_ANGLES[:1])))[0]
    assert abs(values[0]) == pytest.approx(abs(first), abs=1e-3)
    assert abs(values[-1] - values[0]) == pytest.approx(3 * 360.0, abs=1e-2)
    with Image.open(tmp_path / "a.gif") as image:
        assert image.n_frames == FRAMES


def test_outlines_are_rounded():
    circle = rounded_outline(((1.0, 2.0),), 3.0)
    np.testing.assert_allclose(np.abs(circle - (1 + 2j)), 3.0)
    line = rounded_outline(((0.0, 0.0), (10.0, 0.0)), 2.0)
    assert (line.real.min(), line.real.max()) == pytest.approx((-2.0, 12.0))
    assert len(rounded_outline(tuple(map(tuple, SQUARE)), 0.0)) == 5
    machine = camopt.find_machine("pick-and-place")
    assert [tool.name for tool in machine_tools(machine, resolve_stations(machine))] == ["lift", "feed", "stop"]
    assert machine_tools(random_machine(2), resolve_stations(random_machine(2))) == []


def test_readings_have_a_real_minus_and_four_digits():
    assert reading_texts(np.array([-0.5, 12.345])) == ["−0.50", "12.35"]
    assert reading_texts(np.zeros(2)) == ["0", "0"]
