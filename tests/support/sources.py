"""The modules of a folder, parsed once."""

import ast
from functools import cache
from pathlib import Path

import camopt

PACKAGE = Path(camopt.__file__).parent


@cache
def parsed_modules(folder: Path) -> dict[Path, ast.Module]:
    """The syntax trees of all modules in a folder."""
    return {path: ast.parse(path.read_text(encoding="utf-8")) for path in sorted(folder.rglob("*.py"))}
