"""The public names: each is there, is listed once, and whatever can be raised is among them."""

import ast
import inspect
import re
import tomllib
from pathlib import Path
from typing import get_args

import pytest
from test_house import trees

import camopt
from camopt.core import mistakes
from camopt.core.quantities import QUANTITIES, Flag, Word

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", camopt.__all__)
def test_a_public_name_is_there_and_documented(name):
    value = getattr(camopt, name)
    assert inspect.getdoc(value)
    assert name in dir(camopt)


def test_every_exception_is_public():
    raised = {
        name
        for name, value in vars(mistakes).items()
        if inspect.isclass(value) and issubclass(value, Exception) and value.__module__ == mistakes.__name__
    }
    assert raised <= set(camopt.__all__)


def test_every_error_is_a_camopt_error_and_what_pythons_are():
    errors = {
        value
        for value in vars(camopt.core.mistakes).values()
        if inspect.isclass(value) and issubclass(value, Exception)
    }
    assert {error for error in errors if not issubclass(error, camopt.CamoptError)} == set()
    assert issubclass(camopt.BadInput, ValueError)
    assert issubclass(camopt.UnknownName, KeyError)
    assert issubclass(camopt.Unsolved, ArithmeticError)


def test_type_checkers_know_which_quantities_are_no_numbers():
    kinds = {kind: {name for name, quantity in QUANTITIES.items() if quantity.kind is kind} for kind in (bool, str)}
    assert (set(get_args(Flag)), set(get_args(Word))) == (kinds[bool], kinds[str])


def test_the_types_of_a_users_program_are_checked():
    """With those of the package, by the same run of mypy: what it must find is marked in the program."""
    config = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["mypy"]
    assert "tests/support/user.py" in config["files"]
    assert config["strict"]
    program = (ROOT / "tests" / "support" / "user.py").read_text(encoding="utf-8")
    assert program.count("assert_type(") > 10
    assert program.count("# type: ignore[") == 3


def test_every_picture_of_a_command_has_a_public_function():
    """Of modules of commands and studies only those that draw pictures take parts of pictures."""
    drawing = {
        name for name, tree in trees().items() if "draw" in {getattr(node, "name", "") for node in tree.body}
    }
    drawn = {
        alias.name
        for name, tree in trees().items()
        if name.startswith(("cli.", "show.studies.")) and name not in drawing
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("camopt.show.drawing.")
        for alias in node.names
    }
    assert drawn <= {"plot", "animate", "construct"} <= {*camopt.__all__}


SAID_BY_COMMANDS = {"scene.problem.scene_notes", "scene.scene_templates"}
"""Modules outside of cli that make sentences for commands alone."""


@pytest.mark.slow
def test_no_message_of_the_library_names_an_option_or_an_argument_of_a_command():
    found = {
        (name, node.value)
        for name, tree in trees().items()
        if not name.startswith("cli.") and name not in SAID_BY_COMMANDS
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
        if re.search(r"(^|[\s'\"(])--[a-z]", node.value) or node.value in ("SCENE", "FILE", "TABLE")
    }
    assert found == set()


SCENE = camopt.find_scene("two-pauses")
MISTAKEN = {
    "find_scene": (
        lambda: camopt.find_scene("two-pause"),
        "scene = 'two-pause': must be a TOML file or a shipped scene; did you mean two-pauses?",
    ),
    "find_scene of a number": (lambda: camopt.find_scene(3), "scene = 3: must be the path of a TOML file"),
    "evaluate": (lambda: camopt.evaluate(SCENE.replace(**{"cam.base_radius": None})), "cam.base_radius: missing"),
    "optimise": (lambda: camopt.optimise(SCENE, seconds=-1), "seconds = -1: must be a number above 0"),
    "sweep": (
        lambda: camopt.sweep(SCENE, keep="some"),
        "keep = 'some': must be a choice of designs; known: pareto, feasible, all, front-only",
    ),
    "frontier": (
        lambda: camopt.frontier(SCENE, axes=["size", "weight"]),
        "axes = 'weight': must be a term of the objective or a load of this scene",
    ),
    "fit": (lambda: camopt.fit([[0.0, 1.0]], SCENE), "points: rows = 1: must be at least 12 points"),
    "export": (lambda: camopt.export(SCENE, "cam.dxf", chord=-1.0), "chord = -1.0: must be from 1e-06 to 10 mm"),
    "export to another kind": (
        lambda: camopt.export(SCENE, "cam.doc"),
        "file = 'cam.doc': must be a file that ends in .dxf, .svg",
    ),
    "plot": (
        lambda: camopt.plot(SCENE, "cam.bmp"),
        "path = 'cam.bmp': must be a file that ends in .png, .svg or .pdf",
    ),
    "animate": (
        lambda: camopt.animate(SCENE, "cam.bmp"),
        "path = 'cam.bmp': must be a file that ends in .svg, .gif or .mp4",
    ),
    "cam_points": (lambda: camopt.cam_points(SCENE, step=-1.0), "step = -1.0: must be from 0.00036 to 360 deg"),
    "response_spectrum": (
        lambda: camopt.response_spectrum("cycloydal", [1.0]),
        "law = 'cycloydal': must be a motion law; did you mean cycloidal?",
    ),
    "sensitivities": (
        lambda: camopt.sensitivities(SCENE.replace(**{"cam.base_radius": None})),
        "cam.base_radius: missing",
    ),
    "certify": (lambda: camopt.certify(SCENE.replace(**{"cam.base_radius": None})), "cam.base_radius: missing"),
    "load": (
        lambda: camopt.load(str(Path(__file__))),
        "must be a Parquet table that camopt wrote; this is another file, or damaged",
    ),
    "evaluate_designs": (
        lambda: camopt.evaluate_designs(SCENE, {"base_radius": [50.0]}),
        "base_radius: this mechanism has no such size, number or law; did you mean base_radius_mm?",
    ),
    "replace": (
        lambda: SCENE.replace(**{"cam.base_radus": 1.0}),
        "cam.base_radus = 1.0: not a known key; did you mean base_radius?",
    ),
}


@pytest.mark.parametrize("name", MISTAKEN)
def test_a_mistake_of_a_program_is_told_in_its_own_words(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, words = MISTAKEN[name]
    with pytest.raises(camopt.BadInput, match=re.escape(words)) as told:
        call()
    message = str(told.value)
    assert not re.search(r"--[a-z]|\bSCENE\b|\bFILE\b|\boption\b|Traceback|pydantic", message)
    assert not list(tmp_path.iterdir())
