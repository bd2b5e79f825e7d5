"""Tables of numbers in workbooks of Excel and LibreOffice, read by python-calamine if it is installed."""

import re
from collections.abc import Iterator
from io import BytesIO
from typing import Any
from zipfile import ZipFile

from camopt.solve.measured.delimited_text import TEXT_DIALECTS
from camopt.solve.measured.number_table import NumberedRow, TableCell

ARCHIVE = b"PK\x03\x04"
WORKBOOK_STARTS = (ARCHIVE, b"\xd0\xcf\x11\xe0")
"""First bytes of workbooks: .xlsx and .ods, and .xls."""
MOST_UNPACKED = 64  # MiB
MOST_CELLS = 2_000_000  # rows times columns of a sheet
XML_ELEMENT = re.compile(
    rb"<(?:\w+:)?(row|c)\b(?:[^<>]*?\sr\s*=\s*[\"']([A-Za-z]{0,40})([0-9]{1,40})[\"'])?[^<>]*>(?:(?<!/>)(?!\s*</)())?"
)
"""A row or a cell of .xlsx, with its column and row if it names them; the last group is set unless it is empty."""
BINARY_RECORD = re.compile(rb"([\x80-\xff]?.)([\x80-\xff]{0,3}.)(.{0,4})", re.DOTALL)
"""A record of .xlsb (MS-XLSB 2.1.4): its kind, its length, and the row or column at the start of its content."""
ROW_RECORD, FILLED_RECORDS = 0, range(2, 12)  # kinds of record: a row, and cells that are not blank
TAB_DIALECTS = [dialect for dialect in TEXT_DIALECTS if dialect.delimiter == r"\t"]


def workbook_rows(data: bytes) -> list[NumberedRow]:
    """The rows of the first sheet with numbers; a ValueError if the workbook cannot be read."""
    try:
        from python_calamine import CalamineWorkbook
    except ImportError:
        raise ValueError(
            'is a workbook; pip install "camopt[excel]" lets camopt read it, or save it as CSV'
        ) from None
    try:
        if data.startswith(ARCHIVE):
            _check_archive(data)
        book = CalamineWorkbook.from_filelike(BytesIO(data))
        tables = (_sheet_rows(book.get_sheet_by_name(name)) for name in book.sheet_names)
        return next((rows for rows in tables if any(row.is_numeric for row in rows)), [])
    except (ValueError, KeyboardInterrupt):
        raise
    except BaseException as trouble:  # panics of calamine are no Exception; unpacking may fail too
        raise ValueError(f"is not a readable workbook: {trouble}") from None


def _check_archive(data: bytes) -> None:
    """Refuse a workbook that is too large, before calamine allocates memory for it and ends the process.

    Each part is unpacked, because the directory of an archive may state wrong sizes.
    """
    bytes_left = MOST_UNPACKED << 20
    with ZipFile(BytesIO(data)) as archive:
        for part in archive.infolist():
            part.file_size = bytes_left + 2  # one more than is read, so that no checksum is compared
            with archive.open(part) as stream:
                content = stream.read(bytes_left + 1)
            bytes_left -= len(content)
            if bytes_left < 0:
                most = f"is a workbook of more than {MOST_UNPACKED} MiB when unpacked"
                raise ValueError(f"{most}: save the table as CSV")
            binary = "worksheets/" in part.filename and part.filename.endswith(".bin")
            cells = [(0, 0), *(_binary_cell_places if binary else _xml_cell_places)(content)]
            _check_cell_count(max(row for row, _ in cells), max(column for _, column in cells))


def _xml_cell_places(content: bytes) -> Iterator[tuple[int, int]]:
    """Row and column of each XML cell that is not blank. An element without a place follows the one before it."""
    row = column = 0
    for element in XML_ELEMENT.finditer(content):
        name, letters, number, filled = element.groups()
        if name == b"row":
            row, column = int(number or row + 1), 0
        else:
            column += 1
            if letters:  # A is 1, AA is 27
                column = sum((digit - 64) * 26**k for k, digit in enumerate(reversed(letters.upper())))
            if filled is not None:
                yield int(number or row), column


def _binary_cell_places(content: bytes) -> Iterator[tuple[int, int]]:
    """Row and column of each .xlsb cell that is not blank."""
    place = row = 0
    while record := BINARY_RECORD.match(content, place):
        kind, length = (
            sum((byte & 127) << 7 * k for k, byte in enumerate(digits)) for digits in record.groups()[:2]
        )
        number = int.from_bytes(record[3], "little") + 1
        if kind == ROW_RECORD:
            row = number
        elif kind in FILLED_RECORDS:
            yield row, number
        place = record.start(3) + length


def _check_cell_count(last_row: int, last_column: int) -> None:
    """Refuse a sheet whose last cell is far from the first: calamine allocates memory for all cells between."""
    if last_row * last_column > MOST_CELLS:
        where = f"has a sheet up to row {last_row} and column {last_column}"
        raise ValueError(f"{where}; at most {MOST_CELLS} cells are allowed: save the table as CSV")


def _sheet_rows(sheet: Any) -> list[NumberedRow]:
    rows = []
    _check_cell_count(sheet.total_height, sheet.total_width)
    for number, values in enumerate(sheet.to_python(skip_empty_area=False), start=1):
        cells = [_cell_value(value) for value in values]
        while cells and cells[-1] == "":
            cells.pop()
        while cells and cells[0] == "":  # tables need not start in the first column
            cells.pop(0)
        if cells and not str(cells[0]).startswith("#"):
            rows.append(NumberedRow(number, cells))
    return rows


def _cell_value(value: Any) -> TableCell:
    """Number of a cell, even if stored as text; the text of anything else (dates, errors)."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    text = str(value).strip()
    if not text:
        return text
    numbers = (cell for dialect in TAB_DIALECTS for cell in dialect.split_cells(text) if isinstance(cell, float))
    return next(numbers, text)
