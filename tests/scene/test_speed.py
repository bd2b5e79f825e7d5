"""The speed of a crankshaft in place of that of the cam."""

import re

import numpy as np
import pytest

import camopt
from camopt import BadInput, Scene, find_scene
from camopt.cli.main import main
from camopt.scene.problem.problem import resolve


def valve(**cam):
    data = find_scene("bucket-valve").to_dict()
    del data["cam"]["rpm"]
    data["cam"] |= cam
    return Scene.from_dict(data)


@pytest.mark.parametrize("speed", [6000, "6000 rev/min", "100 rev/s"])
def test_a_camshaft_turns_at_half_the_speed_of_the_crankshaft(speed):
    scene = valve(rpm_of_crank=speed)
    assert scene.cam.rpm == pytest.approx(3000.0, rel=1e-15)
    assert "crank" not in scene.to_toml()
    assert scene.replace(**{"cam.rpm": 3000.0}) == find_scene("bucket-valve")


def test_it_takes_a_search_over_the_speed_of_the_cam():
    scene = valve(rpm_of_crank=6000).replace(search={"cam": {"rpm": [2000, 3000]}})
    assert camopt.sweep(scene).designs == 2


def test_it_takes_the_place_of_the_speed_of_a_scene():
    scene = valve(rpm_of_crank=7000)
    assert scene.replace(**{"cam.rpm_of_crank": 5000}).cam.rpm == 2500.0
    assert scene.replace(**{"cam.rpm": 100}).cam.rpm == 100.0


@pytest.mark.parametrize("speed", [-1, 0, "fast", True, float("inf"), "3 mm"])
def test_what_is_no_speed(speed):
    with pytest.raises(BadInput, match=r"cam\.rpm_of_crank = .*: must be"):
        valve(rpm_of_crank=speed)


def test_both_speeds_are_one_too_many():
    with pytest.raises(BadInput, match=r"cam\.rpm, half this speed, is given too: leave one of them out"):
        valve(rpm=3000, rpm_of_crank=6000)


def test_a_search_varies_the_speed_of_the_cam_alone():
    with pytest.raises(BadInput, match=r"search\.cam\.rpm_of_crank = .*: not a number of this table; known: rpm, "):
        valve(rpm=3000).replace(search={"cam": {"rpm_of_crank": [4000, 6000]}})


def test_the_speed_of_a_crankshaft_is_said_beside_that_of_the_cam(tmp_path, capsys):
    """Twice the cam's: what was given, and the jump speed."""
    scene = valve(rpm_of_crank=6000)
    assert scene.is_speed_of_crank
    assert not scene.replace(**{"cam.rpm": 3000}).is_speed_of_crank
    loads = {"mass": 0.1, "spring_rate": 30, "preload": 200, "lash": 0.15}
    scene = scene.replace(**{"follower.dynamics": loads, "limits.jump_speed": 100})
    changes = [f"follower.dynamics.{key}={value}" for key, value in loads.items()]
    given = [word for each in ("limits.jump_speed=100", *changes) for word in ("--set", each)]
    file = tmp_path / "valve.toml"
    file.write_text(find_scene("bucket-valve").to_toml().replace("\nrpm = 3000.0", "\nrpm_of_crank = 6000"))
    assert main(["evaluate", str(file), *given]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "cam.rpm_of_crank 6000 rev/min cam.rpm 3000 rev/min" in printed
    jump = camopt.evaluate(scene)["jump_speed_rpm"]
    assert f"half those of the crankshaft; at the crankshaft, the jump speed is {2 * jump:.6g} rev/min" in printed


@pytest.mark.parametrize("name", ["bucket-valve", "slide-by-bell-crank", "rocker-valve"])
def test_the_largest_lift_is_told_with_its_cam_angle(name, capsys):
    """By samples of the motion, of the tool where there is one."""
    assert main(["evaluate", name]) == 0
    told = re.search(r"Largest lift(?: of the tool)?: (\S+) (mm|deg), reached at (\S+)°", capsys.readouterr().out)
    lift, unit, angle = told.groups()
    programme = resolve(find_scene(name)).programme.tool
    theta = np.linspace(0, 2 * np.pi, 720001)
    y = programme.motion_at(theta)[0] / programme.unit_in_mm_or_rad
    assert float(lift) == pytest.approx(np.ptp(y), rel=1e-5)
    assert programme.motion_at(np.radians([float(angle)]))[0][0] / programme.unit_in_mm_or_rad == pytest.approx(
        y.max(), rel=1e-5
    )
    assert unit == ("deg" if find_scene(name).tool_turns else "mm")
