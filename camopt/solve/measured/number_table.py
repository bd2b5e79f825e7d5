"""A table of numbers as people save it: headings above, comments between, and the file row of each number."""

import re
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray, IntArray

TABLE_ROWS = 20_000
LIKE_NUMBERS = re.compile(r"[-+.,\d]+[;|\s]+[-+.,\d;|\s]+")
"""Two numbers or more, in any dialect."""

TableCell = float | str
"""A number, or a text that is no number; an empty text for an empty cell."""


class NumberedRow(NamedTuple):
    """A row that is not empty, with its number in the file, from 1."""

    number: int
    cells: Sequence[TableCell]

    @property
    def is_numeric(self) -> bool:
        return all(isinstance(cell, float) for cell in self.cells)


class NumberTable(NamedTuple):
    """The numbers (rows, columns), their file rows, and the heading of each column."""

    numbers: FloatArray
    rows: IntArray
    names: tuple[str, ...]


def number_table(file: str, rows: Sequence[NumberedRow]) -> NumberTable:
    """The numbers of a file, with the same number of columns in each row; the rows above are headings.

    Raises
    ------
    BadInput
        With the row that has no number, or another number of columns.
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
    number_rows = rows[first:]
    if len(number_rows) > TABLE_ROWS:
        raise file_mistake(file, "rows", len(number_rows), f"at most {TABLE_ROWS} are allowed")
    for row in number_rows:
        if fault := _row_fault(row, width):
            raise file_mistake(file, f"row {row.number}", *fault)
    numbers = np.array([row.cells for row in number_rows], dtype=float)
    headings = [row.cells for row in rows[:first] if len(row.cells) == width and not row.is_numeric]
    names = (" ".join(str(cells[column]) for cells in headings).strip() for column in range(width))
    return NumberTable(numbers, np.array([row.number for row in number_rows]), tuple(names))


def file_mistake(file: str, key: str, value: object, message: str) -> BadInput:
    """A mistake in a file of points: its place, the value there, and what is wrong."""
    return BadInput([Mistake(file, key, value, message, bare=True)])


def _row_fault(row: NumberedRow, width: int) -> tuple[object, str] | None:
    """The fault of a row among the numbers, as its value and a text; None if it has none."""
    text = next((cell for cell in row.cells if isinstance(cell, str)), None)
    if text == "":
        return None, "has an empty cell; each row needs all its numbers"
    if text is not None:
        return text, "is not a number, such as 12.5; a comment line starts with #"
    if len(row.cells) != width:
        return None, f"has {len(row.cells)} numbers, and most rows have {width}"
    return None
