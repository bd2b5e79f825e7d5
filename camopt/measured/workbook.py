"""Tables of numbers in workbooks of Excel and LibreOffice, read by python-calamine if that is installed."""

from io import BytesIO
from typing import Any

from camopt.measured.delimited import DIALECTS
from camopt.measured.number_table import NumberedRow, TableCell
from camopt.measured.workbook_extent import Extent, check_archive

ARCHIVE = b"PK\x03\x04"
WORKBOOKS = (ARCHIVE, b"\xd0\xcf\x11\xe0")
"""How workbooks begin: .xlsx and .ods, and .xls."""
SPOKEN = [dialect for dialect in DIALECTS if dialect.delimiter == r"\t"]


def workbook_rows(data: bytes) -> list[NumberedRow]:
    """The rows of the first sheet that has numbers; a ValueError says why there are none."""
    try:
        from python_calamine import CalamineError, CalamineWorkbook
    except ImportError:
        raise ValueError(
            'is a workbook; pip install "camopt[excel]" lets camopt read it, or save it as CSV'
        ) from None
    if data.startswith(ARCHIVE):
        check_archive(data)
    try:
        book = CalamineWorkbook.from_filelike(BytesIO(data))
        tables = (_rows(book.get_sheet_by_name(name)) for name in book.sheet_names)
        return next((rows for rows in tables if any(row.numeric for row in rows)), [])
    except CalamineError as trouble:
        raise ValueError(f"is no workbook that can be read: {trouble}") from None


def _rows(sheet: Any) -> list[NumberedRow]:
    found = []
    Extent(sheet.total_height, sheet.total_width).check()  # of an .xls: it has 65,536 rows of 256 columns at most
    for number, values in enumerate(sheet.to_python(skip_empty_area=False), start=1):
        cells = [_cell(value) for value in values]
        while cells and cells[-1] == "":
            cells.pop()
        while cells and cells[0] == "":  # tables need not start in the first column
            cells.pop(0)
        if cells and not str(cells[0]).startswith("#"):
            found.append(NumberedRow(number, cells))
    return found


def _cell(value: Any) -> TableCell:
    """A cell's number, also if it was stored as text; of anything else (dates, errors) its text."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    text = str(value).strip()
    if not text:
        return text
    found = (cell for dialect in SPOKEN for cell in dialect.cells(text) if isinstance(cell, float))
    return next(found, text)
