"""The content of a table, the same for every printer: title, headings, rows and note, all of them texts."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from camopt.tables.cells import heading, quantity

WORDS, NUMERIC, VALUE, ABOUT = "", "number", "value", "about"
"""Kinds of column: words, numbers, what a name has (bold, of any length), sentences about the others."""


class Cell(NamedTuple):
    """A text of a table and its kind: that of its column, or a verdict."""

    text: str
    kind: str = WORDS


class FileLine(str):
    """A line that begins with a file: however long, it stays one line, for people and programs."""

    __slots__ = ()


@dataclass(frozen=True)
class Branch:
    """A line of a tree, and the branches below it."""

    text: str
    branches: tuple["Branch", ...] = ()

    @classmethod
    def of(cls, text: str, *branches: "Branch | str") -> "Branch":
        """A line above lines and other branches."""
        return cls(text, tuple(each if isinstance(each, Branch) else cls(each) for each in branches))


@dataclass(frozen=True)
class Table:
    """A table: a heading for each column, with a line for each word, for the unit and for the limit."""

    title: str
    heads: list[Cell]
    rows: list[list[Cell]]
    note: str = ""

    @classmethod
    def of(
        cls, title: str, heads: Iterable[Cell | str], rows: Iterable[Iterable[Cell | str]], note: str = ""
    ) -> "Table":
        """A table of texts, each of the kind of its column unless it says otherwise."""
        tops = [head if isinstance(head, Cell) else Cell(head) for head in heads]
        cells = [
            [each if isinstance(each, Cell) else Cell(each, top.kind) for each, top in zip(row, tops, strict=True)]
            for row in rows
        ]
        return cls(title, tops, cells, note)

    def __str__(self) -> str:
        lines = [[head.text.replace("\n", " ").strip() for head in self.heads]] if self.is_headed else []
        lines += [[cell.text for cell in row] for row in self.rows]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        right = [head.kind == NUMERIC for head in self.heads]
        texts = (
            "  ".join(
                text.rjust(width) if numeric else text.ljust(width)
                for text, width, numeric in zip(line, widths, right, strict=True)
            ).rstrip()
            for line in lines
        )
        return "\n".join(filter(None, (self.title, *texts, self.note)))

    def unexplained(self) -> "Table":
        """The table without its sentences about the other columns."""
        return replace(self, rows=[[Cell("") if each.kind == ABOUT else each for each in row] for row in self.rows])

    @property
    def is_headed(self) -> bool:
        """Whether any column has a heading: a table without them says of one thing what it has, line by line."""
        return any(head.text for head in self.heads)


def table_of(
    title: str,
    records: Sequence[Mapping[str, Any]],
    names: Iterable[str],
    bounds: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> Table:
    """A row for each record; in the headings name, unit and, in a table with ``bounds``, the limit.

    ``units`` are those of columns that are no quantities.
    """
    names, bounds, units = [*names], bounds or {}, units or {}
    limited = any(name in bounds for name in names)
    heads = []
    for name in names:
        words = heading(name, units.get(name)) + (f"\n{bounds.get(name, ' ')}" if limited else "")
        texts = all(isinstance(record.get(name, ""), str) for record in records)
        heads.append(Cell(words, WORDS if texts else NUMERIC))
    rows = ([quantity(name, record.get(name, ""), units.get(name)) for name in names] for record in records)
    return Table.of(title, heads, rows)
