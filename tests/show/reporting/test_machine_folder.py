"""The folder of a machine: it reads back as the same machine, and its parts list counts every cam."""

import csv

import pytest

import camopt
from camopt.library import write_machine_folder


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


def test_a_file_of_the_user_is_never_replaced(tmp_path):
    mine = tmp_path / "parts.csv"
    mine.write_text("mine")
    with pytest.raises(camopt.BadInput, match="choose another folder"):
        write_machine_folder(camopt.evaluate_machine("camshaft"), tmp_path)
    assert mine.read_text() == "mine"
