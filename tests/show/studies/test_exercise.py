"""Exercises: twenty problems of two seeds, solved again from the equations of the lectures."""

import re
from math import acos, asin, cos, pi, radians, sin, sqrt

import numpy as np
import pytest

from camopt import BadInput, evaluate
from camopt.show.studies.exercise import EXERCISE_KINDS, LAW_WORDS, make_exercise

EQUATIONS = {
    "uniform": lambda x: x,
    "harmonic": lambda x: (1 - cos(pi * x)) / 2,
    "parabolic": lambda x: 2 * x * x if x <= 0.5 else 1 - 2 * (1 - x) ** 2,
    "cycloidal": lambda x: x - sin(2 * pi * x) / (2 * pi),
}
PEAKS = {"uniform": (1, np.inf), "harmonic": (pi / 2, pi**2 / 2), "parabolic": (2, 4), "cycloidal": (2, 2 * pi)}
STEP = 1e-4  # rad


def displacement(scene, angle):
    """Of the follower at a cam angle, rad; mm or deg."""
    turned, level = 0.0, 0.0
    for move in scene.motion:
        size, sign = radians(move.angle), {"rise": 1, "return": -1, "dwell": 0}[move.segment]
        share = min(max((angle - turned) / size, 0.0), 1.0)
        level += sign * (move.lift or 0.0) * (EQUATIONS[move.law](share) if move.law else 0.0)
        turned += size
    return level


def follower_at(scene, angle):
    """The follower's point, how it would move, both in the ground frame, and the turn of the cam's frame."""
    cam, follower, y = scene.cam, scene.follower, displacement(scene, angle)
    sense = 1 if cam.rotation == "ccw" else -1
    radius = follower.roller_radius or follower.face_radius or 0.0
    if cam.form == "cylindrical":
        if follower.motion == "translating":
            return complex(0, y), 1j, angle * cam.mean_radius
        swing = radians(y) - radians(max(displacement(scene, a) for a in np.linspace(0, 6.28, 200))) / 2
        place = follower.arm_length * complex(-sense * cos(swing), sin(swing))
        return place, complex(sense * sin(swing), cos(swing)), angle * cam.mean_radius
    turn = np.exp(-1j * sense * angle)
    prime = cam.base_radius + radius
    if follower.motion == "translating":
        offset = follower.offset or 0.0
        return complex(offset, sqrt(prime**2 - offset**2) + y), 1j, turn
    centre, arm = follower.centre_distance, follower.arm_length
    swing = acos((centre**2 + arm**2 - prime**2) / (2 * centre * arm)) + radians(y)
    return centre + arm * complex(-cos(swing), sin(swing)), complex(sin(swing), cos(swing)), turn


def pitch_point(scene, angle):
    place, _, turn = follower_at(scene, angle)
    return place + turn if scene.cam.form == "cylindrical" else place * turn


def pressure_and_curvature(scene, angle):
    """The pressure angle, deg, and how sharply the pitch curve bulges to the roller, 1/mm, by differences."""
    before, here, after = (pitch_point(scene, angle + k * STEP) for k in (-1, 0, 1))
    first, second = (after - before) / (2 * STEP), (after - 2 * here + before) / STEP**2
    _, moves, turn = follower_at(scene, angle)
    moves = moves if scene.cam.form == "cylindrical" else moves * turn
    along = abs(((first / abs(first)) * moves.conjugate()).real)
    bend = (first.conjugate() * second).imag / abs(first) ** 3
    bend = abs(bend) if scene.cam.form == "cylindrical" else bend * (1 if scene.cam.rotation == "cw" else -1)
    return np.degrees(asin(min(along, 1.0))), bend


def inner_angles(scene):
    """Cam angles inside strokes, away from their ends and middles, where laws may jump."""
    turned = 0.0
    for move in scene.motion:
        size = radians(move.angle)
        yield from (turned + size * x for x in np.linspace(0.01, 0.99, 51) if move.law and abs(x - 0.5) > 0.005)
        turned += size


@pytest.mark.one_in(4)
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("kind", EXERCISE_KINDS)
def test_the_cam_of_an_exercise_can_be_made(kind, seed):
    text, scene = make_exercise(kind, seed)
    found = evaluate(scene)
    if "flat" not in kind:
        angles, bends = zip(*(pressure_and_curvature(scene, a) for a in inner_angles(scene)), strict=True)
        assert max(angles) <= 30.001
        assert max(angles) == pytest.approx(found["pressure_angle_max_deg"], abs=0.6)
        radius = scene.follower.roller_radius or scene.follower.face_radius or 0.0
        assert max(bends) * radius < 1
    elif scene.follower.motion == "translating":
        lowest = min(
            scene.cam.base_radius
            + displacement(scene, a)
            + (displacement(scene, a + STEP) - 2 * displacement(scene, a) + displacement(scene, a - STEP)) / STEP**2
            for a in inner_angles(scene)
        )
        assert lowest > 0
    omega, unit = scene.cam.rpm * 2 * pi / 60, (1.0 if scene.follower.motion == "oscillating" else 1e-3)
    for move in (scene.motion[0], scene.motion[2]):
        lift, angle = move.lift * unit, radians(move.angle)
        names = ("deg_s", "deg_s2") if scene.follower.motion == "oscillating" else ("m_s", "m_s2")
        for order, (quantity, name) in enumerate(zip(("velocity", "acceleration"), names, strict=True), start=1):
            key = f"{quantity}_max_{move.segment}_{name}"
            key = key if key in found else key.replace("deg_s", "rad_s")
            expected = PEAKS[move.law][order - 1] * lift * (omega / angle) ** order
            factor = radians(1) if "rad_s" in key else 1.0
            assert found[key] == pytest.approx(expected * factor, rel=1e-12)
    numbers = {float(word) for word in re.findall(r"\d+(?:\.\d+)?", text)}
    given = {*scene.cam.model_dump().values(), *scene.follower.model_dump().values()}
    assert {n for n in given if isinstance(n, float) and n} <= numbers
    assert {n for move in scene.motion for n in (move.angle, move.lift or move.angle)} <= numbers
    assert [text.count(LAW_WORDS[move.law]) > 0 for move in scene.motion if move.law] == [True, True]
    assert all(n == round(2 * n) / 2 for n in numbers)


def test_a_seed_is_a_problem():
    assert make_exercise("roller", 5)[0] == make_exercise("roller", 5)[0]
    assert len({make_exercise("roller", seed)[0] for seed in range(8)}) == 8


@pytest.mark.slow
def test_an_exercise_is_written_with_its_problem(command, tmp_path):
    code, _, errors = command("new", "--exercise", "barrel", "--seed", "3", "exercise.toml")
    assert (code, errors.strip()) == (0, "wrote exercise.toml")
    text = (tmp_path / "exercise.toml").read_text(encoding="utf-8")
    assert " ".join(line[2:] for line in text.splitlines() if line[:1] == "#") == make_exercise("barrel", 3)[0]
    assert command("plot", "exercise.toml", "solution.pdf", "--construction", "--quiet")[0] == 0
    assert command("new", "--exercise", "cam")[0] == 2
    assert command("new", "valve", "--exercise", "knife")[0] == 2
    assert command("new", "--exercise", "knife", "--form", "disc")[0] == 2
    with pytest.raises(BadInput, match="one of knife, offset-knife"):
        make_exercise("cam", 1)
