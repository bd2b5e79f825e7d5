"""The size of a workbook, found before its reader allocates memory for every cell up to the last one.

A workbook is an archive whose directory says how large each part is. What it says holds: a part that is longer is
cut there, and its checksum is then wrong. In the parts of a sheet only the places of cells are looked at: .xlsx has
their rows and columns, .ods counts and repeats them, .xlsb has records.

Sources: ECMA-376, part 1, 18.3.1.4 and 18.3.1.73; OpenDocument 1.3, part 3, 19.675 and 19.679; MS-XLSB, 2.1.4.
"""

import zlib
from collections.abc import Iterator, Mapping
from io import BytesIO
from typing import NamedTuple
from xml.parsers.expat import ExpatError, ParserCreate
from zipfile import BadZipFile, ZipFile, ZipInfo

MOST_UNPACKED = 1 << 26  # bytes
MOST_CELLS = 2_000_000
SHEETS = "worksheets/"
ROW_HEADER, CELLS = 0, range(2, 12)  # records of .xlsb: what a row starts with, and cells that are not blank


class Extent(NamedTuple):
    """The last row and column in which a sheet has anything, from 1."""

    row: int = 0
    column: int = 0

    def with_cell(self, row: int, column: int) -> "Extent":
        return Extent(max(self.row, row), max(self.column, column))

    def check(self) -> None:
        """Whether all cells up to the last one can be laid out; a ValueError says if not."""
        if self.row * self.column > MOST_CELLS:
            where = f"has a sheet as far as row {self.row} and column {self.column}"
            raise ValueError(f"{where}; the most are {MOST_CELLS} cells: save the table as CSV")


def check_archive(data: bytes) -> None:
    """Whether a workbook that is an archive can be unpacked and laid out; a ValueError says why not."""
    try:
        with ZipFile(BytesIO(data)) as archive:
            unpacked = sum(part.file_size for part in archive.infolist())
            if unpacked > MOST_UNPACKED:
                most = f"the most are {MOST_UNPACKED >> 20}"
                raise ValueError(
                    f"is a workbook of {unpacked >> 20} MiB when unpacked; {most}: save the table as CSV"
                )
            for part in archive.infolist():
                _check_part(archive, part)
    except (BadZipFile, ExpatError, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError) as trouble:
        raise ValueError(f"is no workbook that can be read: {trouble}") from None


def _check_part(archive: ZipFile, part: ZipInfo) -> None:
    """Whether a part is as long as it says, and ends early enough if it is a sheet."""
    with archive.open(part) as stream:
        content = stream.read()
    if content.lstrip(b"\xef\xbb\xbf\r\n\t ").startswith(b"<"):
        _Cells().read(content)
    elif SHEETS in part.filename and part.filename.endswith(".bin"):
        _extent_of_records(content).check()


class _Cells:
    """The places of cells in the XML of sheets, one sheet after the other."""

    def __init__(self) -> None:
        self.extent, self.row, self.column = Extent(), 0, 0
        self.starts = {
            "row": self._row,
            "c": self._cell,
            "v": self._value,
            "is": self._value,
            "table": self._table,
            "table-row": self._repeated_row,
            "table-cell": self._repeated_cell,
            "covered-table-cell": self._repeated_cell,
            "p": self._value,
        }

    def read(self, content: bytes) -> None:
        parser = ParserCreate()
        parser.StartElementHandler = self._start
        parser.Parse(content, True)

    def _start(self, name: str, attributes: Mapping[str, str]) -> None:
        if begin := self.starts.get(name.rpartition(":")[2]):
            begin({key.rpartition(":")[2]: value for key, value in attributes.items()})

    def _row(self, attributes: Mapping[str, str]) -> None:
        self.row, self.column = _number(attributes.get("r"), self.row + 1), 0

    def _cell(self, attributes: Mapping[str, str]) -> None:
        self.column += 1
        if place := attributes.get("r"):
            letters = place.rstrip("0123456789")
            self.row = _number(place[len(letters) :], self.row)
            self.column = _column(letters)

    def _value(self, _: Mapping[str, str]) -> None:
        """Something in the cell that began last."""
        self.extent = self.extent.with_cell(self.row, self.column)
        self.extent.check()

    def _table(self, _: Mapping[str, str]) -> None:
        self.extent, self.row, self.column = Extent(), 0, 0

    def _repeated_row(self, attributes: Mapping[str, str]) -> None:
        self.row, self.column = self.row + _number(attributes.get("number-rows-repeated"), 1), 0

    def _repeated_cell(self, attributes: Mapping[str, str]) -> None:
        self.column += _number(attributes.get("number-columns-repeated"), 1)
        if "value-type" in attributes:
            self._value(attributes)


def _number(text: str | None, otherwise: int) -> int:
    """A number of a few digits, or of so many that the first are large enough."""
    return int(text[:12]) if text and text.isdecimal() else otherwise


def _column(letters: str) -> int:
    """The number of a column from its letters: A is 1, AA is 27."""
    number = 0
    for letter in letters.upper():
        number = 26 * number + ord(letter) - ord("A") + 1
    return number


def _extent_of_records(content: bytes) -> Extent:
    """The extent of a sheet of .xlsb: each record has its kind, its length and its bytes."""
    extent, row = Extent(), 0
    for kind, start in _records(content):
        number = int.from_bytes(content[start : start + 4], "little") + 1
        if kind == ROW_HEADER:
            row = number
        elif kind in CELLS:
            extent = extent.with_cell(row, number)
    return extent


def _records(content: bytes) -> Iterator[tuple[int, int]]:
    """The kind of each record, and where its bytes start."""
    place = 0
    while place < len(content):
        kind, place = _varied(content, place, 2)
        length, place = _varied(content, place, 4)
        yield kind, place
        place += length


def _varied(content: bytes, place: int, most: int) -> tuple[int, int]:
    """A number of seven bits in each byte, as long as the eighth is set, and where it ends."""
    number = 0
    for k, byte in enumerate(content[place : place + most]):
        number |= (byte & 0x7F) << 7 * k
        if not byte & 0x80:
            return number, place + k + 1
    return number, place + most
