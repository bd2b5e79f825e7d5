"""The speed of a crankshaft in place of that of the cam."""

import pytest

import camopt
from camopt import BadInput, Scene, find_scene


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
    with pytest.raises(BadInput, match=r"not together with cam\.rpm, which is half of it: give one of both"):
        valve(rpm=3000, rpm_of_crank=6000)


def test_a_search_varies_the_speed_of_the_cam_alone():
    with pytest.raises(BadInput, match=r"search\.cam\.rpm_of_crank = .*: not a number of this table; known: rpm, "):
        valve(rpm=3000).replace(search={"cam": {"rpm_of_crank": [4000, 6000]}})
