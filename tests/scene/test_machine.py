"""Machines: what their files may say, and one message for each mistake."""

import re
from contextlib import suppress

import pytest
import tomli_w
from hypothesis import given, settings
from hypothesis import strategies as st
from support.machines import KNIFE

import camopt
from camopt.scene.machine import MACHINE_TABLES, Machine, is_machine

STATION = {"name": "a", "scene": KNIFE}
TURNING = {"name": "b", "scene": "oscillating-roller"}
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]


@pytest.mark.slow
@pytest.mark.parametrize("name", camopt.shipped_machines())
def test_shipped_machines_hold_their_limits(name):
    assert camopt.evaluate_machine(name).verdict == "held"
    assert is_machine(name)


@pytest.mark.parametrize("name", camopt.shipped_machines())
def test_a_shipped_machine_has_no_file(name, tmp_path):
    """Otherwise ``serve`` would save beside it, in the folder of the package."""
    machine = camopt.find_machine(name)
    assert machine.file == name
    path = tmp_path / "own.toml"
    path.write_text(machine.with_files_inside().to_toml())
    assert camopt.find_machine(path).file == str(path)


def test_a_machine_is_read_from_its_file_with_paths_beside_it(tmp_path):
    folder = tmp_path / "cams"
    folder.mkdir()
    (folder / "knife.toml").write_text(tomli_w.dumps(KNIFE))
    tables = {"rpm": "2 rev/s", "station": [{"name": "a", "scene": "cams/knife.toml", "ratio": 2}, TURNING]}
    path = tmp_path / "press.toml"
    path.write_text(tomli_w.dumps(tables))
    machine = camopt.find_machine(path)
    assert is_machine(str(path))
    assert not is_machine(str(folder / "knife.toml"))
    assert machine.name == "press"
    assert machine.shaft_rpm == 120.0
    assert [scene.cam.rpm for scene in machine.scenes.values()] == [240.0, 120.0]


def test_the_speed_of_a_machine_follows_from_its_scenes():
    machine = Machine(station=[TURNING, STATION | {"ratio": 3}])
    assert machine.shaft_rpm == 30.0
    assert machine.scenes["b"].cam.rpm == 30.0
    assert Machine(station=[TURNING]).shaft_rpm is None


def test_a_machine_reads_back_from_its_own_text(tmp_path):
    machine = Machine(
        name="x",
        station=[STATION | {"outline": SQUARE, "direction": 90}, TURNING],
        body=[{"name": "rail", "outline": [[5, 5]], "outline_radius": 2}],
        clear=[{"between": ["a", "rail"], "at_least": 1}, {"between": ["a", "b"], "along": [1, -1]}],
        search={"phase": {"a": [10, 20]}},
    )
    path = tmp_path / "x.toml"
    path.write_text(machine.to_toml())
    again = camopt.find_machine(path)
    assert again.to_dict() == machine.to_dict()
    assert again.scenes == machine.scenes


MISTAKES = [
    ({"station": []}, "station = ..: must be a list of at least one value"),
    ({"stations": [STATION]}, "stations = .*did you mean station"),
    ({"rpm": -3, "station": [STATION]}, "rpm = -3: must be at least"),
    ({"station": [STATION, STATION]}, "station.2.name = 'a': another station or body has this name"),
    ({"station": [{"name": "a"}]}, "station.1.scene: missing"),
    ({"station": [STATION | {"ratio": 1.5}]}, "station.1.ratio = 1.5: must be a whole number"),
    ({"station": [STATION | {"ratio": 0}]}, "station.1.ratio = 0: must be at least 1"),
    ({"station": [STATION | {"scene": "rollr-1000rpm"}]}, "station.1.scene = 'rollr-1000rpm'.*roller-1000rpm"),
    ({"station": [STATION | {"scene": "none.toml"}]}, "station.1.scene = .*there is no such file"),
    ({"station": [STATION | {"scene": 3}]}, "station.1.scene = 3: must be the path"),
    ({"station": [STATION | {"outline": SQUARE}]}, "station.1.direction: missing: the tool slides"),
    ({"station": [TURNING | {"outline": SQUARE, "direction": 9}]}, "station.1.pivot: missing: the tool turns"),
    ({"station": [STATION | {"outline": [[1, 2, 3]], "direction": 0}]}, "outline = .*two numbers"),
    ({"station": [STATION | {"outline": [[1, "x"]], "direction": 0}]}, "outline.* must be a number"),
    ({"station": [STATION | {"phase": "1 mm"}]}, "station.1.phase = '1 mm'"),
    ({"station": [STATION], "clear": [{"between": ["a", "c"], "along": [1, 1]}]}, "between.2 = 'c': not a station"),
    (
        {"station": [STATION, TURNING], "clear": [{"between": ["a", "b"]}]},
        "clear.1.between.1 = 'a': has no outline",
    ),
    ({"station": [STATION], "clear": [{"between": ["a"], "along": [1, 2]}]}, "clear.1.along = .*1 numbers"),
    ({"station": [STATION], "clear": [{"between": ["a"]}]}, "clear.1.between = .*two stations or bodies"),
    ({"station": [STATION], "clear": [{"between": ["a", "a"], "along": [1, 1]}]}, "must name each station once"),
    ({"station": [STATION], "clear": [{"between": ["a"], "along": [1], "angles": [9, 9]}]}, "clear.1.angles"),
    ({"station": [STATION], "search": {"phase": {"x": [0, 9]}}}, "search.phase.x: not a station"),
    ({"station": [STATION], "flywheel": {"fluctuation": 3}}, "flywheel.fluctuation = 3: must be below 2"),
    ({"station": [STATION], "motor": {"catalogue": "none.csv"}}, "motor.catalogue = 'none.csv': must be a CSV"),
    ({"station": [STATION], "cam": {"rpm": 9}}, "cam = .*belongs to the scene of a station"),
]


@pytest.mark.parametrize(("tables", "message"), MISTAKES)
def test_each_mistake_has_one_message(tables, message):
    with pytest.raises(camopt.BadInput) as caught:
        Machine.from_dict(tables)
    assert re.search(message, str(caught.value)), str(caught.value)


def test_all_mistakes_are_said_at_once_with_the_file_of_the_scene(tmp_path):
    wrong = KNIFE | {"cam": {"form": "disc", "base_radius": -40, "rpm": 90.0}}
    (tmp_path / "knife.toml").write_text(tomli_w.dumps(wrong))
    path = tmp_path / "press.toml"
    path.write_text(tomli_w.dumps({"rpm": 0, "station": [STATION | {"scene": "knife.toml", "phase": "x"}]}))
    with pytest.raises(camopt.BadInput) as caught:
        camopt.find_machine(path)
    keys = {(mistake.file.rpartition("/")[2], mistake.key) for mistake in caught.value.mistakes}
    assert keys == {("press.toml", "rpm"), ("press.toml", "station.1.phase"), ("knife.toml", "cam.base_radius")}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name,rated_torque_N_m\nx,1\n", "no peak_torque_N_m"),
        ("name,rated_torque_N_m,peak_torque_N_m,rated_speed_rpm,inertia_kg_m2\nx,1,2,three,4\n", "line 2"),
        (
            "name,rated_torque_N_m,peak_torque_N_m,rated_speed_rpm,inertia_kg_m2\nx,1,2,-3,4\n",
            "rated_speed_rpm of motor x",
        ),
        ("name,rated_torque_N_m,peak_torque_N_m,rated_speed_rpm,inertia_kg_m2\n", "has no motor"),
    ],
)
def test_a_wrong_catalogue_is_said(tmp_path, text, message):
    path = tmp_path / "motors.csv"
    path.write_text(text)
    with pytest.raises(camopt.BadInput, match=message):
        Machine(station=[STATION], motor={"catalogue": str(path)})


VALUES = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner, max_size=3),
    max_leaves=6,
)


@pytest.mark.slow
@settings(max_examples=150, deadline=None)
@given(st.data())
def test_any_value_of_any_key_is_taken_or_refused(data):
    tables = {"rpm": 60, "station": [STATION | {"outline": SQUARE, "direction": 0}], "clear": [{"between": ["a"]}]}
    place = data.draw(st.sampled_from([*MACHINE_TABLES]))
    key = data.draw(st.sampled_from([*MACHINE_TABLES[place].model_fields]))
    value = data.draw(VALUES)
    if place == "":
        tables[key] = value
    elif place in ("station", "body", "clear"):
        row = {"station": STATION, "body": {"name": "w", "outline": [[0, 0]]}, "clear": {"between": ["a"]}}[place]
        tables[place] = [row | {key: value}]
    else:
        tables[place] = {key: value}
    with suppress(camopt.BadInput):
        assert Machine.from_dict(tables).scenes
