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


def of_package() -> Iterator[str]:
    """The folders and modules of the package in the order of the data, each with what it says of itself."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    (lines,) = (rule["layers"] for rule in project["tool"]["importlinter"]["contracts"] if rule["type"] == "layers")
    rows = []
    for room in (room for line in reversed(lines) for room in line.split(" | ")):
        said = (import_module(f"camopt.{room}").__doc__ or "").split("\n\n")[0]
        rows.append((f"`{room}`", " ".join(said.split())))
    return table(("room", "what is in it"), rows)


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
