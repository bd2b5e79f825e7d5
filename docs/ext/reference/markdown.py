"""Markdown out of what the code says of itself."""

import re
from collections.abc import Iterable, Iterator, Sequence
from inspect import cleandoc


def prose(docstring: str | None) -> str:
    """A docstring as Markdown: what it indents is a formula already, and stars are stars."""
    lines = cleandoc(docstring or "").splitlines()
    return "\n".join(line if line.startswith("    ") else line.replace("*", r"\*") for line in lines)


def entry(kind: str, names: Iterable[str], text: str) -> Iterator[str]:
    """An object of the site under one or more names, with what is said of it."""
    yield from ("", f"````{{{kind}}} {', '.join(names)}", text, "````", "")


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """A table; bars within its cells are bars."""
    yield ""
    for row in (heads, ["---"] * len(heads), *rows):
        yield f"| {' | '.join(cell.replace('|', '&#124;') for cell in row)} |"
    yield ""


def symbol(text: str) -> str:
    """A symbol, or a sentence with symbols of one letter, with subscripts."""
    return re.sub(r"(?<!\w)(\w)_(\w+)", r"\1{sub}`\2`", text)
