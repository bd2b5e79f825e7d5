"""Tables of numbers in text, with any delimiter and a decimal point or comma.

``csv.Sniffer`` and pandas look for a delimiter in a sample and ignore the decimal comma. A table read in a wrong
dialect still has numbers, but wrong ones. So this module reads the whole text in each dialect, and takes the
dialect that makes numbers of the most rows.
"""

import re
from collections.abc import Sequence
from typing import NamedTuple

from camopt.solve.measured.number_table import TABLE_ROWS, NumberedRow, TableCell

COMMENT = re.compile(r"\s*(#|%|//|!)")
NUMBER_FORMS = {
    ".": re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?"),
    ",": re.compile(r"[+-]?(\d+(,\d+)?|,\d+)([eEdD][+-]?\d+)?"),
}
BLANKS = r"\s+"
DELIMITERS = (r"\t", ";", r"\|", ",", BLANKS)
DISTINCT_ANGLE_SHARE = 0.9  # least share of distinct angles in a table
MOST_LINES = 2 * TABLE_ROWS  # including comments and empty lines
MOST_LINE_CHARACTERS = 2000


class TextDialect(NamedTuple):
    """A delimiter and a decimal mark."""

    delimiter: str
    decimal: str

    def split_cells(self, line: str) -> list[TableCell]:
        """The cells of a line, without empty ones at its end."""
        line = line.partition("#")[0].strip(None if self.delimiter == BLANKS else " \r\n")
        cells = [self._parse_cell(word.strip(" \t\"'\u00a0")) for word in re.split(self.delimiter, line)]
        while cells and cells[-1] == "":
            cells.pop()
        return cells

    def _parse_cell(self, word: str) -> TableCell:
        word = word.replace("\u2212", "-")
        if not NUMBER_FORMS[self.decimal].fullmatch(word):
            return word
        return float(re.sub("[dD]", "e", word.replace(",", ".")))

    def read_rows(self, lines: Sequence[str]) -> list[NumberedRow]:
        """The rows of some lines, without comments and empty lines.

        A comment just above the first numbers is a row of headings if it has as many cells.
        """
        numbered = (
            (number, self.split_cells(line))
            for number, line in enumerate(lines, start=1)
            if not COMMENT.match(line)
        )
        rows = [NumberedRow(number, cells) for number, cells in numbered if cells]
        first = next((place for place, row in enumerate(rows) if row.is_numeric), len(rows))
        if first < len(rows) and (number := rows[first].number - 1) > 0:
            headings = self.split_cells(COMMENT.sub("", lines[number - 1], count=1))
            if COMMENT.match(lines[number - 1]) and len(headings) == len(rows[first].cells):
                rows.insert(first, NumberedRow(number, headings))
        return rows


TEXT_DIALECTS = [TextDialect(mark, sign) for mark in DELIMITERS for sign in NUMBER_FORMS if mark != sign]


def text_rows(text: str) -> list[NumberedRow]:
    """The rows of a text, in the dialect that makes numbers of the most rows.

    Raises ValueError for too many lines, or for a line that is too long.
    """
    lines = text.splitlines()
    if len(lines) > MOST_LINES:
        raise ValueError(f"has {len(lines)} lines; at most {MOST_LINES} are allowed")
    for number, line in enumerate(lines, start=1):
        if len(line) > MOST_LINE_CHARACTERS:
            raise ValueError(
                f"has {len(line)} characters in line {number}; at most {MOST_LINE_CHARACTERS} are allowed"
            )
    return max((dialect.read_rows(lines) for dialect in TEXT_DIALECTS), key=_dialect_score)


def _dialect_score(rows: list[NumberedRow]) -> tuple[int, int]:
    """Number of numeric rows; then 2 if the first column may be angles, 1 for one column, else 0.

    "1,25" in every line may be an angle and a lift, or a lift with a decimal comma.
    """
    numeric = [row.cells for row in rows if row.is_numeric]
    if not numeric or min(map(len, numeric)) == 1:
        return len(numeric), 1
    return len(numeric), 2 if len({cells[0] for cells in numeric}) >= DISTINCT_ANGLE_SHARE * len(numeric) else 0


def decode_text(data: bytes) -> str:
    """Text in UTF-8, UTF-16 with its mark, or Latin-1; a ValueError for anything else."""
    for mark, encoding in ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"), (b"\xef\xbb\xbf", "utf-8-sig")):
        if data.startswith(mark):
            return data.decode(encoding)
    if b"\0" in data:
        raise ValueError("is neither text nor an Excel workbook; save the table as CSV")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")
