"""What the public functions say of themselves: all sections are there, and the examples run."""

import doctest
import inspect

import pytest

import camopt

FUNCTIONS = [name for name in camopt.__all__ if inspect.isroutine(inspect.unwrap(getattr(camopt, name)))]


def test_functions_are_found():
    assert {"evaluate", "optimise", "sweep", "shipped_scenes", "plot_frontier"} <= set(FUNCTIONS)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_says_what_it_takes_and_gives(name):
    function = inspect.unwrap(getattr(camopt, name))
    text, given = inspect.getdoc(function), list(inspect.signature(function).parameters)
    for section in ("Returns", "Examples", *(("Parameters", "Raises") if given else ())):
        assert f"\n{section}\n{'-' * len(section)}\n" in text
    named = [line.strip() for line in text.partition("Parameters\n")[2].partition("Returns\n")[0].splitlines()]
    assert [parameter for parameter in given if parameter not in named] == []


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_example_runs(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = inspect.getdoc(inspect.unwrap(getattr(camopt, name)))
    example = doctest.DocTestParser().get_doctest(text, {"camopt": camopt}, name, None, None)
    assert example.examples
    failures: list[str] = []
    doctest.DocTestRunner().run(example, out=failures.append)
    assert failures == []
