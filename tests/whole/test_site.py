"""What the site's reference is made from is there, its checks find mistakes, and the cheat sheet says what is so.

The site itself is built and checked by `.ci/site`.
"""

import json
import re
import shlex
import subprocess
import sys
import tomllib
from itertools import product

import click
import pytest
from support.pages import ROOT, blocks

from camopt import Scene
from camopt.cli.main import camopt as command
from camopt.core.quantities import BOUNDED_QUANTITIES, QUANTITIES
from camopt.core.quantities.limit_keys import LIMIT_KEYS
from camopt.scene.problem.problem import resolve
from camopt.scene.schema import scene_schema
from camopt.scene.table_places import key_record
from camopt.scene.tables import SceneTable

UNITS = {
    *(quantity.unit for quantity in QUANTITIES.values() if quantity.unit),
    *("rev/min", "kg/m³", "deg and mm", "no unit", "in the unit of the number"),
}


def tables():
    """Every table of a scene, with those that it holds."""
    found = [SceneTable]
    for model in found:
        found += [each for each in model.__subclasses__() if each not in found]
    return [model for model in found if model.__module__.startswith("camopt.") and model is not SceneTable]


KEYS = [
    (model, key)
    for model in tables()
    for key in vars(model).get("__annotations__", {})
    if key in model.model_fields and key not in BOUNDED_QUANTITIES.keys() - LIMIT_KEYS.keys()
]


@pytest.mark.parametrize(("model", "key"), KEYS, ids=lambda each: each if isinstance(each, str) else each.__name__)
def test_a_key_says_what_it_is_and_a_number_its_unit(model, key):
    record = key_record(model, key)
    assert re.fullmatch(r"[A-Zs±].*[^.;]", record.sentence), "a sentence without its full stop"
    text = json.dumps(model.model_json_schema()["properties"][key])
    if '"number"' in text and '"$ref"' not in text and key != "minimise":
        assert "`per`" in record.unit or {record.unit, record.turning or record.unit} <= UNITS


def test_a_limit_by_the_name_of_a_quantity_says_so_in_the_schema():
    described = scene_schema()["definitions"]["Limits"]["properties"]
    for name in BOUNDED_QUANTITIES.keys() - LIMIT_KEYS.keys():
        assert f"`{name}`. Unit: {BOUNDED_QUANTITIES[name].unit or 'no unit'}." in described[name]["description"]


def test_every_table_of_a_scene_is_found():
    assert {"Cam", "Dynamics", "Limits", "Search", "Part", "Scene", "StepRange"} <= {
        model.__name__ for model in tables()
    }


CHEATS = blocks(ROOT / "docs" / "cheat-sheet.md")


def test_the_scene_of_the_cheat_sheet_is_one():
    (text,) = [block.text for block in CHEATS if block.language == "toml"]
    assert resolve(Scene.from_dict(tomllib.loads(text))).limits


LINES = [line for block in CHEATS if block.language == "sh" for line in block.text.splitlines()]


@pytest.mark.parametrize("line", LINES)
def test_a_command_of_the_cheat_sheet_is_one(line):
    _, name, *words = shlex.split(line, comments=True)
    found = command.get_command(click.Context(command), name)
    assert found is not None
    known = {option for parameter in found.params for option in parameter.opts}
    assert {word for word in words if word.startswith("-")} <= known


def test_the_python_of_the_cheat_sheet_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (text,) = [block.text for block in CHEATS if block.language == "python"]
    few = {"search.base_radius": {"start": 40, "stop": 100, "step": 20}, "synthesis.pieces": 16}
    narrow = text.replace("25})", f"25, **{few}}})")
    assert narrow != text
    exec(narrow, {})
    assert {"cam.svg", "cam.dxf", "results"} <= {path.name for path in tmp_path.iterdir()}


PAGE = '<html><head>{head}</head><body><div id="a"></div>{body}</body></html>'
WRONG = {
    '<script src="https://example.com/x.js"></script>': "asks another host",
    '<link rel="stylesheet" href="//example.com/x.css">': "asks another host",
    '<img src="none.png">': "nothing at none.png",
    '<a href="none.html">x</a>': "leads to none.html, which is not there",
    '<a href="#b">x</a>': "leads to index.html#b, which is not there",
}
RIGHT = ['<a href="#a">x</a>', '<a href="https://example.com">x</a>', '<img src="data:image/png;base64,AA==">']


@pytest.mark.parametrize(("body", "mistake"), [*WRONG.items(), *product(RIGHT, [""])])
def test_the_check_of_the_site_finds_what_is_wrong(body, mistake, tmp_path):
    (tmp_path / "index.html").write_text(PAGE.format(head="", body=body), encoding="utf-8")
    found = subprocess.run(
        [sys.executable, ROOT / "docs" / "check.py", tmp_path], capture_output=True, text=True, check=False
    )
    lines = [line for line in found.stdout.splitlines() if line.startswith("index.html: ")]
    assert found.returncode == 1  # what readers look for is not there
    assert [mistake in line for line in lines] == ([True] if mistake else [])
