"""The package as folders, public names and exit codes."""

import re
import tomllib
from collections.abc import Iterator
from importlib import import_module
from inspect import cleandoc, isclass, isroutine
from pathlib import Path

import camopt
from camopt.cli.main import camopt as command

from .markdown import table

ROOT = Path(__file__).parents[3]


def folders_and_parts() -> Iterator[str]:
    """The folders of the package and their parts, in the order of the data, each with its first sentence."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    rules = [rule for rule in project["tool"]["importlinter"]["contracts"] if rule["type"] == "layers"]
    layers = {rule["containers"][0]: _names_upwards(rule["layers"]) for rule in rules}
    rows = []
    for folder in layers["camopt"]:
        rows.append((f"**`{folder}`**", _first_sentence(f"camopt.{folder}")))
        for part in layers.get(f"camopt.{folder}", ["problem"] if folder == "scene" else []):
            rows.append((f"`{folder}/{part}`", _first_sentence(f"camopt.{folder}.{part}")))
    return table(("folder", "what is in it"), rows)


def _names_upwards(lines: list[str]) -> list[str]:
    """The names in layers, the lowest first."""
    return [name for line in reversed(lines) for name in line.split(" | ")]


def _first_sentence(module: str) -> str:
    """The first paragraph of a module's docstring, in one line."""
    return " ".join((import_module(module).__doc__ or "").split("\n\n")[0].split())


def exit_codes() -> Iterator[str]:
    """What the help of the command says of them."""
    (said,) = [part for part in cleandoc(command.help or "").split("\n\n") if part.startswith("Exit codes: ")]
    pairs = re.findall(r"(\d+) ([^;]+)", " ".join(said.removeprefix("Exit codes: ").removesuffix(".").split()))
    return table(("code", "meaning"), pairs)


def public_names() -> Iterator[str]:
    """A page (reStructuredText) of the functions and classes of ``camopt.__all__``, for autosummary."""
    names = {name: getattr(camopt, name) for name in camopt.__all__ if name != "__version__"}
    parts = {
        "Functions": [name for name, value in names.items() if isroutine(value)],
        "Results and scenes": [
            name for name, value in names.items() if isclass(value) and not issubclass(value, Exception)
        ],
        "Errors": [name for name, value in names.items() if isclass(value) and issubclass(value, Exception)],
    }
    yield from ("Python", "======", "", ".. automodule:: camopt", "   :no-members:", "")
    for title, found in parts.items():
        yield from (title, "-" * len(title), "", ".. currentmodule:: camopt", "", ".. autosummary::")
        yield from ("   :toctree: .", "   :nosignatures:", "", *(f"   {name}" for name in found), "")
