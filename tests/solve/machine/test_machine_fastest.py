"""The highest speed of a machine: the least of its stations, and the verdicts on either side of it."""

import pytest

import camopt

MARGIN = 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", camopt.shipped_machines())
def test_the_machine_holds_just_below_its_highest_speed_and_not_above(name):
    found = camopt.fastest_machine(name)
    assert found.exit_code == 0
    for share, verdict in ((1.0 - MARGIN, "held"), (1.0 + MARGIN, "broken")):
        machine = camopt.find_machine(name)
        changed = machine.to_dict() | {"rpm": found.rpm * share}
        changed["station"] = [row | {"scene": machine.scenes[row["name"]].to_dict()} for row in changed["station"]]
        changed.pop("motor", None), changed.pop("clear", None)  # no clearance depends on the speed
        at_speed = camopt.evaluate_machine(camopt.Machine.from_dict(changed))
        assert at_speed.verdict == verdict
        if verdict == "broken":
            assert found.deciding_limit in at_speed.stations[found.deciding_station]["violated"]


def test_speeds_are_those_of_the_shaft():
    scene = camopt.find_scene("valve-with-rocker")
    own = camopt.fastest(scene)
    rows = [{"name": "a", "scene": "valve-with-rocker", "ratio": 4}, {"name": "b", "scene": "valve-with-rocker"}]
    found = camopt.fastest_machine(camopt.Machine(rpm=scene.cam.rpm / 4, station=rows))
    assert found.rpm == pytest.approx(own.rpm / 4, rel=1e-9)
    assert (found.deciding_station, found.deciding_limit) == ("a", own.deciding_limit)
