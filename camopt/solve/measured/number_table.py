"""A table of numbers as people save them: lines of words above it, comments between, and the row of each number."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray, IntArray

TABLE_ROWS = 20_000
LIKE_NUMBERS = re.compile(r"[-+.,\d]+[;|\s]+[-+.,\d;|\s]+")
"""Two numbers or more in whatever dialect."""

TableCell = float | str
"""A number, or a text that is none; an empty text where a cell has nothing."""


class NumberedRow(NamedTuple):
    """A row that has anything in it, with its number in the file, from 1."""

    number: int
    cells: Sequence[TableCell]

    @property
    def is_numeric(self) -> bool:
        return all(isinstance(cell, float) for cell in self.cells)


class NumberTable(NamedTuple):
    """The numbers (rows, columns), the row of the file that each has, and the words above each column."""

    numbers: FloatArray
    rows: IntArray
    names: tuple[str, ...]


def number_table(file: str, rows: Sequence[NumberedRow]) -> NumberTable:
    """The numbers of a file, all of the same number of columns; what is above the first of them is its heading.

    Raises
    ------
    BadInput
        With the row in which there is no number, or another number of columns.
    """
    counts = Counter(len(row.cells) for row in rows if row.is_numeric)
    if not counts:
        raise file_mistake(file, "rows", None, "has no row of numbers; it needs a row for each angle")
    width = counts.most_common(1)[0][0]
    first = next(k for k, row in enumerate(rows) if row.is_numeric and len(row.cells) == width)
    for row in rows[:first]:
        if LIKE_NUMBERS.fullmatch("\t".join(map(str, row.cells))):
            raise file_mistake(
                file, f"row {row.number}", None, f"is not read as {width} numbers like most rows, and no heading"
            )
    found = rows[first:]
    if len(found) > TABLE_ROWS:
        raise file_mistake(file, "rows", len(found), f"the most are {TABLE_ROWS}")
    for row in found:
        if fault := _row_fault(row, width):
            raise file_mistake(file, f"row {row.number}", *fault)
    numbers = np.array([row.cells for row in found], dtype=float)
    return NumberTable(
        numbers, np.array([row.number for row in found]), tuple(_column_headings(rows[:first], width))
    )


def file_mistake(file: str, key: str, value: object, what: str) -> BadInput:
    """A mistake in a file of points: where, what is there, and what is wrong with it."""
    return BadInput([Mistake(file, key, value, what, bare=True)])


def _row_fault(row: NumberedRow, width: int) -> tuple[object, str] | None:
    """The fault of a row among the numbers: the value, and the words."""
    other = next((cell for cell in row.cells if isinstance(cell, str)), None)
    if other == "":
        return None, "has an empty cell; each row needs all its numbers"
    if other is not None:
        return other, "is no number such as 12.5; a comment starts with #"
    if len(row.cells) != width:
        return None, f"has {len(row.cells)} numbers, and most rows have {width}"
    return None


def _column_headings(above: Sequence[NumberedRow], width: int) -> Iterator[str]:
    """The words above each column, from the lines that have one for each."""
    lines = [row.cells for row in above if len(row.cells) == width and not row.is_numeric]
    for column in range(width):
        yield " ".join(str(cells[column]) for cells in lines).strip()
