"""Excel workbooks with a sheet for each table and one for the scene, written by XlsxWriter."""

import os
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.storage.files import atomically_written_file
from camopt.scene.scene import Scene

SheetColumns = tuple[Sequence[str], Sequence[str], Sequence[FloatArray]]
"""Headings, units and columns of numbers."""
SHEET_ROWS = 1_048_574  # most rows of a sheet below its two lines of headings
NUMBERS_SHOWN = {"mm": "0.0000", "in": "0.00000", "deg": "0.0000"}
"""Number formats by unit; the numbers keep all their digits."""
FIXED_TIME = datetime(2000, 1, 1, tzinfo=UTC).replace(tzinfo=None)
"""Time of creation in every workbook, so that the same cam gives the same file."""


def write_rows(path: str | os.PathLike[str], name: str, rows: Sequence[Sequence[Any]]) -> None:
    """Write rows of texts and numbers, the first of them headings, to a workbook with one sheet."""
    from xlsxwriter import Workbook

    with atomically_written_file(path) as partial, Workbook(partial) as book:
        book.set_properties({"created": FIXED_TIME})
        sheet = book.add_worksheet(name)
        for number, row in enumerate(rows):
            sheet.write_row(number, 0, row, None if number else book.add_format({"bold": True}))
        sheet.freeze_panes(1, 1)
        sheet.autofit()


def write_workbook(path: str | os.PathLike[str], sheets: Mapping[str, SheetColumns], scene: Scene) -> None:
    """Write tables and their scene to a workbook, whole or not at all.

    Raises
    ------
    BadInput
        If XlsxWriter is not installed, or a table is longer than a sheet.
    OSError
        If the file cannot be written.
    """
    try:
        from xlsxwriter import Workbook
    except ModuleNotFoundError:
        why = 'needs XlsxWriter, which is not installed: pip install "camopt[excel]" adds it'
        raise BadInput([Mistake("camopt", "file", os.fspath(path), why, bare=True)]) from None
    longest = max(columns[0].size for _, _, columns in sheets.values())
    if longest > SHEET_ROWS:
        raise BadInput(
            [Mistake("camopt", "file", os.fspath(path), f"of at most {SHEET_ROWS:,} rows; it has {longest:,}")]
        )
    with atomically_written_file(path) as partial, Workbook(partial) as book:
        book.set_properties({"created": FIXED_TIME})
        bold = book.add_format({"bold": True})
        formats = {unit: book.add_format({"num_format": shown}) for unit, shown in NUMBERS_SHOWN.items()}
        for name, (headings, units, columns) in sheets.items():
            sheet = book.add_worksheet(name)
            sheet.write_row(0, 0, headings, bold)
            sheet.write_row(1, 0, units)
            for k, column in enumerate(columns):
                sheet.write_column(2, k, column.tolist(), formats.get(units[k]))
                sheet.set_column(k, k, len(headings[k]) + 1)
            sheet.freeze_panes(2, 1)
        book.add_worksheet("scene").write_column(0, 0, scene.to_toml().splitlines())
