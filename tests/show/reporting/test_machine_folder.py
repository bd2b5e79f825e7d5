"""The folder of a machine: it reads back as the same machine, and its parts list counts every cam."""

import csv

import numpy as np
import pytest
from support.machines import KNIFE

import camopt
from camopt.library import write_machine_folder


@pytest.mark.slow
@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", ["pick-and-place", "camshaft"])
def test_the_folder_of_a_machine_reads_back(name, tmp_path):
    found = camopt.evaluate_machine(name)
    files, notes = write_machine_folder(found, tmp_path / "out")
    again = camopt.evaluate_machine(tmp_path / "out" / "machine.toml")
    cams = len({scene.to_toml() for scene in found.machine.scenes.values()})
    assert again.to_dict() == found.to_dict()
    assert {file.suffix for file in files} >= {".pdf", ".dxf", ".csv", ".toml", ".html", ".json", ".xlsx"}
    assert sum(file.suffix == ".dxf" for file in files) == cams
    assert sum("thickness" in note for note in notes) == cams  # the scenes have no thickness for a solid


@pytest.mark.slow
def test_equal_cams_have_one_drawing_and_are_counted(tmp_path):
    write_machine_folder(camopt.evaluate_machine("camshaft"), tmp_path)
    rows = [*csv.DictReader((tmp_path / "parts.csv").read_text(encoding="utf-8").splitlines())]
    named = {(row["part"], row["stations"]): int(row["quantity"]) for row in rows}
    assert named == {
        ("Exhaust valve", "exhaust 1, exhaust 2"): 2,
        ("Spring", "exhaust 1, exhaust 2"): 2,
        ("Inlet valve", "inlet 1, inlet 2"): 2,
        ("Spring", "inlet 1, inlet 2"): 2,
    }


@pytest.mark.slow
def test_a_file_of_the_user_is_never_replaced(tmp_path):
    mine = tmp_path / "parts.csv"
    mine.write_text("mine")
    with pytest.raises(camopt.BadInput, match="choose another folder"):
        write_machine_folder(camopt.evaluate_machine("camshaft"), tmp_path)
    assert mine.read_text() == "mine"


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
def test_one_key_of_the_shaft_fits_all_cams(rotation):
    """At any angle of the shaft, all keyways point the same way: the frame of each drawing is turned by its cam."""
    rng, sense = np.random.default_rng(3), {"ccw": 1.0, "cw": -1.0}[rotation]
    part = {"thickness": 20, "bore": 20, "keyway": "DIN 6885"}
    scene = {**KNIFE, "cam": {**KNIFE["cam"], "rotation": rotation}, "part": part}
    stations = [
        {"name": name, "scene": scene, "phase": rng.uniform(-300, 300), "follower_angle": rng.uniform(0, 360)}
        for name in "abc"
    ]
    machine = camopt.Machine(station=[*stations, {"name": "d", "scene": scene, "ratio": 2}])
    for shaft in rng.uniform(0.0, 360.0, 3):
        directions = []
        for station in machine.station[:3]:
            drawing = machine.keyed_scenes[station.name].whole_part.keyway_angle
            turned = drawing + station.follower_angle - 90.0 + sense * (shaft - station.phase)
            directions.append(turned % 360.0)
        assert directions == pytest.approx([directions[0]] * 3)
    assert machine.keyed_scenes["a"].whole_part.keyway_angle == 90.0
    assert machine.keyed_scenes["d"] == machine.scenes["d"]
