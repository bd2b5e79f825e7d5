"""What the public functions and classes say of themselves: all sections are there, and the examples run."""

import ast
import dataclasses
import doctest
import inspect
import re
import textwrap
from functools import cache, wraps

import numpy as np
import pytest
from numpydoc.docscrape import FunctionDoc
from numpydoc.validate import validate
from support.sources import PACKAGE, parsed_modules

import camopt

CLASSES = [name for name in camopt.__all__ if inspect.isclass(getattr(camopt, name))]
FUNCTIONS = [name for name in camopt.__all__ if inspect.isroutine(inspect.unwrap(getattr(camopt, name)))]
DEMANDED = {
    "GL06": "no unknown section",
    "GL07": "sections in the order of numpydoc",
    "GL08": "a docstring",
    "SS01": "a summary",
    "SS03": "which ends with a period",
    "PR02": "no parameter that is none",
    "PR03": "parameters in their order",
    "PR04": "each with its type",
    "PR07": "and described",
    "RT01": "what is returned",
    "RT03": "described",
    "EX01": "an example",
}
"""The rules of numpydoc that hold for every public name."""


def test_functions_and_classes_are_found():
    assert {"evaluate", "optimise", "sweep", "shipped_scenes", "plot"} <= set(FUNCTIONS)
    assert {"Scene", "Evaluation", "Optimum", "Frontier", "BadInput", "Unsolved"} <= set(CLASSES)
    assert {*FUNCTIONS, *CLASSES} == {*camopt.__all__} - {"LAWS", "QUANTITIES", "__version__"}


def sections(name):
    """The docstring by sections: the names that are listed in each."""
    text = inspect.getdoc(inspect.unwrap(getattr(camopt, name)))
    found = FunctionDoc(None, doc=text)
    listed = ("Parameters", "Attributes", "Returns", "Raises")
    return {
        key: [each for entry in found[key] for each in (entry.name or entry.type).split(", ")] for key in listed
    }


@pytest.mark.parametrize("name", [*FUNCTIONS, *CLASSES])
def test_a_public_name_is_described_by_the_rules(name):
    broken = [message for code, message in validate(f"camopt.{name}")["errors"] if code in DEMANDED]
    assert broken == []


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_says_what_it_takes_and_raises(name):
    given = [
        f"{ {each.VAR_POSITIONAL: '*', each.VAR_KEYWORD: '**'}.get(each.kind, '') }{each.name}"
        for each in inspect.signature(inspect.unwrap(getattr(camopt, name))).parameters.values()
    ]
    told = sections(name)
    assert told["Parameters"] == given
    assert bool(told["Raises"]) == bool(given)
    assert {*told["Raises"]} <= {*camopt.__all__, "OSError"}


UNITS_AND_AXES = {"mm", "deg", "rad", "s", "s2", "s3", "in", "x", "y"}
"""Ends of columns of exported files, whose names are made."""


def test_docstrings_name_parameters_and_what_the_package_has():
    """A renaming otherwise leaves the old names. Names of one word are words, too."""
    known, named = {*camopt.QUANTITIES}, []
    for path, tree in parsed_modules(PACKAGE).items():
        known.add(path.stem)
        for node in ast.walk(tree):
            match node:
                case ast.FunctionDef() | ast.ClassDef():
                    known.add(node.name)
                    names = re.findall(r"``([a-z]+(?:_[a-z0-9]+)+)``", ast.get_docstring(node) or "")
                    named += [(path.name, node.name, name) for name in names]
                case ast.Name(id=name) | ast.Attribute(attr=name) | ast.arg(arg=name) | ast.alias(name=name):
                    known.add(name)
                case ast.Constant(value=str(text)) if len(text) < 80:
                    known |= {*re.findall(r"\w+", text)}
    unknown = [place for place in named if place[2] not in known]
    assert [place for place in unknown if place[2].rpartition("_")[2] not in UNITS_AND_AXES] == []


@pytest.mark.parametrize(
    "name",
    ["certify", "evaluate", "fit", "frontier", "optimise", "prices", "response_spectrum", "sweep", "synthesise"],
)
def test_a_function_of_theory_names_its_sources(name):
    assert FunctionDoc(None, doc=inspect.getdoc(getattr(camopt, name)))["References"]


@pytest.mark.parametrize("name", CLASSES)
def test_a_class_says_what_it_is_made_of(name):
    kind, told = getattr(camopt, name), sections(name)
    if name == "Scene":
        assert told["Parameters"] == list(kind.model_fields)
    elif dataclasses.is_dataclass(kind) and not told["Parameters"]:
        names = [field.name for field in dataclasses.fields(kind)]
        assert told["Attributes"] == [name for name in names if not name.startswith("_")]
    elif "__init__" in vars(kind):
        assert told["Parameters"] == list(inspect.signature(kind).parameters)


@cache
def example_of(name):
    text = inspect.getdoc(inspect.unwrap(getattr(camopt, name)))
    return doctest.DocTestParser().get_doctest(text, {"camopt": camopt, "np": np}, name, None, None)


def remembering(function):
    """The function with its answers for names and scenes remembered."""
    answers = cache(function)

    @wraps(function)
    def answer(given, **options):
        return (answers if isinstance(given, str | camopt.Scene) else function)(given, **options)

    return answer


SHARED = {name: remembering(getattr(camopt, name)) for name in ("evaluate_machine", "frontier", "optimise_phases")}
"""Examples of their results ask the same of them: each answer is computed once."""


@pytest.mark.parametrize("name", [*FUNCTIONS, *CLASSES])
def test_an_example_runs(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    example = example_of(name)
    for shared, function in SHARED.items():
        monkeypatch.setattr(camopt, shared, function)
    assert example.examples
    failures: list[str] = []
    quiet = doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS)  # else with pytest -v it is not
    quiet.run(example, out=failures.append, clear_globs=False)
    assert failures == []


def test_the_session_in_the_text_of_the_package_runs():
    code = [line for line in camopt.__doc__.splitlines() if line.startswith("    ")]
    assert len(code) > 5
    given = {"camopt": camopt}
    exec(textwrap.dedent("\n".join(code)), given)
    assert given["one"].cam.base_radius == given["front"]["base_radius_mm"][0]
    assert given["rows"]["feasible"].all()
