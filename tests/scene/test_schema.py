"""The schema of scenes: fresh, taken by a validator of JSON Schema for all scenes, and strict with wrong keys."""

import json
import tomllib
from itertools import chain
from pathlib import Path

import jsonschema
import pytest
from support.smallest_cams import FREE

import camopt
from camopt.scene.keys import find_keys, keys_of_table
from camopt.scene.scene import SCENE_TABLES
from camopt.scene.schema import scene_schema
from camopt.scene.table_places import TABLE_LISTS

FOLDER = Path(camopt.__file__).parent / "scene"
SHIPPED = sorted((FOLDER / "shipped").glob("*.toml"))
SCHEMA = FOLDER / "scene.schema.json"
READER = jsonschema.Draft7Validator(json.loads(SCHEMA.read_text(encoding="utf-8")))
MADE = scene_schema()


def test_it_is_a_schema():
    jsonschema.Draft7Validator.check_schema(MADE)


@pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.stem)
def test_a_shipped_scene_leads_to_it_and_is_taken(file):
    text = file.read_text(encoding="utf-8")
    assert (file.parent / text.splitlines()[0].removeprefix("#:schema ")).resolve() == SCHEMA
    READER.validate(tomllib.loads(text))


@pytest.mark.parametrize("name", FREE)
def test_what_camopt_writes_is_taken(name):
    READER.validate(FREE[name].to_dict())


PLACED = {"laws.NAME": "laws.mine", "search.KEY": "search.offset", "tolerances.KEY": "tolerances.phase"}


def put_value(place, key, value):
    """A scene with a value under a key of a table, and the names that lead there."""
    scene, path = camopt.find_scene("roller-1000rpm").to_dict(), PLACED.get(place, place).split(".")
    if place in TABLE_LISTS:  # with one entry of each list on the way
        scene[path[0]] = [{"segment": "dwell", "angle": 0}]
    table = scene
    for name in filter(None, path):
        table = table.setdefault(name, [{}] if name == "through" else {})
        table = table[0] if isinstance(table, list) else table
    table[key] = value
    return scene, [*filter(None, path)]


@pytest.mark.parametrize("place", SCENE_TABLES)
def test_a_wrong_key_is_found_in_its_table(place):
    scene, path = put_value(place, "angel", 1)
    leaves = list(leaves_of(READER.iter_errors(scene)))
    wrong = [error for error in leaves if "angel" in error.message and error.validator == "additionalProperties"]
    assert [name for name in wrong[0].absolute_path if isinstance(name, str)] == path


def leaves_of(errors):
    """Errors, those within the alternatives too."""
    for error in errors:
        yield error
        yield from leaves_of(error.context)


@pytest.mark.parametrize("key", [*chain(*map(keys_of_table, SCENE_TABLES))], ids=lambda key: key.key)
def test_a_key_says_what_it_is_and_takes_no_table_of_others(key):
    table = MADE if not key.table else MADE["definitions"][SCENE_TABLES[key.table].__name__]
    said = table["properties"][key.key.rpartition(".")[2]]["description"]
    assert said.startswith(key.sentence.removesuffix("."))
    assert (f"Unit: {key.unit}." in said) == bool(key.unit)
    if key.key != "search.cam" and "a table" not in key.allowed:
        scene, _ = put_value(key.table, key.key.rpartition(".")[2], {"wrong": 1})
        assert not READER.is_valid(scene)


def test_links_lead_to_the_site_where_there_is_one():
    schema = scene_schema(site="https://camopt.example")
    rpm = schema["definitions"]["Cam"]["properties"]["rpm"]
    assert rpm["x-taplo"]["links"]["key"] == "https://camopt.example/reference/scene.html#key-cam.rpm"
    assert "camopt.example" not in json.dumps(MADE)


def test_the_keys_of_tables_with_names_are_found_by_the_table():
    assert find_keys("laws") == find_keys("laws.NAME") == [*keys_of_table("laws.NAME")]
