"""A table as lines of text: columns as wide as their cells, or narrower where cells wrap for want of room."""

import textwrap
from collections.abc import Callable, Iterable, Iterator
from itertools import zip_longest
from typing import NamedTuple
from unicodedata import combining, east_asian_width

from camopt.tables.layout import ABOUT, NUMERIC, VALUE, WORDS, Table

HEADING = "heading"
"""The kind of a heading; other texts are of the kinds of their columns."""


class Column(NamedTuple):
    """The cells of a column, the heading first where there are any, and how wide it may be."""

    kind: str
    cells: list[str]
    least: int
    """As its longest word if cells may wrap: sentences, values, and words that are lists. Otherwise as the next."""
    widest: int
    """As its longest line."""


def width_of(text: str) -> int:
    """The columns of a screen that a line takes: two for each wide character, none for a mark on another one."""
    if text.isascii():
        return len(text)
    return sum(2 if east_asian_width(each) in "WF" else not combining(each) for each in text)


def _columns(table: Table) -> list[Column]:
    """The columns of a table."""
    columns = []
    for place, head in enumerate(table.heads):
        cells = [row[place].text for row in table.rows]
        wraps = head.kind in (VALUE, ABOUT) or (head.kind == WORDS and any(", " in text for text in cells))
        cells = [head.text, *cells] if table.is_headed else cells
        widest = max((width_of(line) for text in cells for line in text.split("\n")), default=0)
        longest = max((width_of(word) for text in cells for word in text.split()), default=0)
        columns.append(Column(head.kind, cells, longest if wraps else widest, widest))
    return columns


def _gap_and_end(table: Table) -> tuple[str, str]:
    """What is between two columns, and at either end of a line."""
    return ("   ", " ") if table.is_headed else ("  ", "")


def _beside(table: Table) -> int:
    """The room between columns, and at either end of a line."""
    gap, end = _gap_and_end(table)
    return len(gap) * (len(table.heads) - 1) + 2 * len(end)


def least_width(table: Table) -> int:
    """The room that a table needs, in columns of a screen."""
    return _beside(table) + sum(column.least for column in _columns(table))


def lines_of(table: Table, room: int, style: Callable[[str, str], str], rule: str = "─") -> Iterator[str]:
    """The lines of a table without its title, no longer than a room that is at least ``least_width``.

    ``style`` takes a text and its kind, and gives how it is printed; a line below the headings is of ``rule``.
    """
    columns, (gap, end) = _columns(table), _gap_and_end(table)
    widths = _widths(columns, room - _beside(table))
    inside, headed = sum(widths) + _beside(table) - 2 * len(end), table.is_headed
    if headed:
        yield end + " " * inside + end
    for place, row in enumerate(zip(*(column.cells for column in columns), strict=True)):
        is_heading = headed and not place
        kinds = [HEADING if is_heading else column.kind for column in columns]
        for line in _lines(row, widths, at_foot=headed):
            texts = map(_filled, line, columns, widths)
            yield end + gap.join(map(style, texts, kinds)) + end
        if is_heading:
            yield end + rule * inside + end
    if headed:
        yield end + " " * inside + end


def _widths(columns: list[Column], room: int) -> list[int]:
    """The widths of columns: the widest of those that may be narrower give way until all find room."""
    widths = [column.widest for column in columns]
    for _ in range(sum(widths) - room):
        wide = [place for place, column in enumerate(columns) if widths[place] > column.least]
        if wide:
            widths[max(wide, key=widths.__getitem__)] -= 1
    return widths


def _lines(row: Iterable[str], widths: list[int], *, at_foot: bool) -> list[tuple[str, ...]]:
    """The lines of a row; what has fewer of them is at its foot or at its head."""
    cells = [_wrapped(text, width) for text, width in zip(row, widths, strict=True)]
    if at_foot:
        return [*zip_longest(*(lines[::-1] for lines in cells), fillvalue="")][::-1]
    return [*zip_longest(*cells, fillvalue="")]


def _wrapped(text: str, width: int) -> list[str]:
    """The lines of a cell in a column."""
    lines = text.split("\n")
    if max(map(width_of, lines)) <= width:
        return lines
    parts = (textwrap.wrap(line, width, break_long_words=False, break_on_hyphens=False) for line in lines)
    return [part for some in parts for part in some or [""]]


def _filled(text: str, column: Column, width: int) -> str:
    """A line of a cell as wide as its column: numbers and values to the right."""
    text = text.rstrip()
    room = " " * (width - width_of(text))
    return room + text if column.kind in (NUMERIC, VALUE) else text + room
