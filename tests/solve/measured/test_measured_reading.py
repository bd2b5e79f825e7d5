"""Points of measured cams as people save them: the same numbers whatever the file, one line for each bad one."""

import re
import sys
from io import BytesIO
from struct import pack
from zipfile import ZIP_DEFLATED, ZipFile
from zlib import crc32

import numpy as np
import openpyxl
import pandas as pd
import polars
import pyarrow
import pytest
from hypothesis import given
from hypothesis import strategies as st

from camopt import BadInput
from camopt.model.motion import LAWS
from camopt.solve.measured.columns import TableReadingOptions
from camopt.solve.measured.measured_points import forward_angle_deg, read_points
from camopt.solve.measured.workbook import workbook_rows

ANGLES = np.arange(0.0, 360.0, 5.0)


def lobe(angles, lift=8.0):
    """A rise and a return of 60 deg each about 120 deg."""
    law = LAWS["cycloidal"]
    return lift * law.displacement(np.clip(1.0 - np.abs(np.mod(angles, 360.0) - 120.0) / 60.0, 0.0, 1.0))


LIFTS = np.round(lobe(ANGLES), 4)
ROWS = [f"{a:g},{y:.4f}" for a, y in zip(ANGLES, LIFTS, strict=True)]


def points_of(content, tmp_path, name="cam.csv", **columns):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_points(path, TableReadingOptions(**columns))


def agree(points, tolerance=0.0):
    np.testing.assert_allclose(points.angles, ANGLES, rtol=0, atol=tolerance)
    np.testing.assert_allclose(points.lifts, LIFTS, rtol=0, atol=tolerance)


@st.composite
def files(draw):
    """The same points as bytes of a file, and what has to be said to read them."""
    decimal = draw(st.sampled_from(".,"))
    delimiter = draw(
        st.sampled_from([d for d in (",", ";", "\t", " ", "   ", " ; ", "|", ", ") if d[0] != decimal])
    )
    digits = draw(st.sampled_from([4, 6, 9]))
    order = draw(st.sampled_from([range(72), range(71, -1, -1), [*range(30, 72), *range(30)]]))
    wrap = draw(st.sampled_from([360.0, 180.0, 0.0]))
    rows = []
    for k in order:
        angle = ANGLES[k] - (360.0 if ANGLES[k] >= wrap else 0.0)
        cells = f"{angle:.{draw(st.sampled_from([0, 1, 3]))}f}", f"{LIFTS[k]:.{digits}f}"
        rows.append(delimiter.join(cells).replace(".", decimal))
        if draw(st.integers(0, 20)) == 0:
            rows.append(draw(st.sampled_from(["", "# half way", "   ", "% comment", "// 1.5 2.5"])))
    heading = draw(st.sampled_from([[], ["Angle", "Lift"], ["Winkel [°]", "Hub [mm]"], ["angle_deg", "lift_mm"]]))
    top = draw(st.sampled_from([[], ["Cam 17, measured on Monday"], ["# probe 5"], [""]]))
    rows = [*top, *([delimiter.join(heading)] if heading else []), *rows]
    text = draw(st.sampled_from(["\n", "\r\n", "\r"])).join(rows) + draw(st.sampled_from(["", "\n", "\n\n"]))
    return text.encode(draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "latin-1"])))


@given(data=files())
def test_the_same_points_whatever_the_file(data, tmp_path_factory):
    points = points_of(data, tmp_path_factory.getbasetemp(), "any.txt")
    agree(points)
    assert points.step == 1e-4


@given(decimal=st.sampled_from(".,"), closed=st.booleans(), digits=st.sampled_from([3, 4, 7]))
def test_a_lift_for_each_degree(decimal, closed, digits, tmp_path_factory):
    angles = np.arange(360.0 + closed)
    text = "\n".join(f"{y:.{digits}f}" for y in lobe(angles)).replace(".", decimal)
    points = points_of(text, tmp_path_factory.getbasetemp(), "lifts.txt")
    assert points.angles.tolist() == list(range(360))  # the last of a closed turn is a copy of the first
    np.testing.assert_allclose(points.lifts, lobe(points.angles), atol=0.5001 * 10.0**-digits)


def test_copies_of_points_do_not_count():
    """Rows that are in a file twice; but of points that are measured again, equal ones are measurements too."""
    once, options = np.column_stack([ANGLES, LIFTS]), TableReadingOptions()
    first = read_points(once, options)
    for copies in (once[::-1], once[1::2], [[360.0, LIFTS[0]]]):
        points = read_points(np.vstack([once, copies]), options)
        agree(points)
        assert points.rows.tolist() == first.rows.tolist()
    again = np.vstack([once, once + [0.0, 1e-3] * (ANGLES[:, None] == 120.0)])
    assert read_points(again, options).rows.size == 2 * ANGLES.size
    few = np.vstack([once[::7], np.add(once[::7], [0.0, 1e-3])])
    with pytest.raises(BadInput, match="points: angles = 11: must be at least 12 different ones"):
        read_points(few, options)


@pytest.mark.parametrize(
    ("change", "columns"),
    [
        (lambda a, y: (np.radians(a), y), {"angle_unit": "rad"}),
        (lambda a, y: (2 * a, y), {"turn": 720.0}),
        (lambda a, y: (a, y / 25.4), {"lift_unit": "inch"}),
        (lambda a, y: (y, a), {"chosen": ["2", 1]}),
    ],
)
def test_units_and_columns(tmp_path, change, columns):
    rows = zip(*change(ANGLES, LIFTS), strict=True)
    agree(points_of("\n".join(f"{a};{y}" for a, y in rows), tmp_path, **columns), 1e-12)


def test_columns_by_their_names(tmp_path):
    rows = "\n".join(f"{k};{y};7;{a}" for k, (a, y) in enumerate(zip(ANGLES, LIFTS, strict=True)))
    agree(points_of("no;Hub (mm);temperature;Winkel (°)\n" + rows, tmp_path))
    agree(points_of("no;one;two;three\n" + rows, tmp_path, chosen=["three", "one"]))


def test_an_array_is_points_too():
    agree(read_points(np.column_stack([ANGLES, LIFTS]), TableReadingOptions()))
    agree(read_points(LIFTS, TableReadingOptions()))


def workbook(rows):
    book, data = openpyxl.Workbook(), BytesIO()
    book.create_sheet("notes", 0).append(["measured", "on Monday"])
    for row in rows:
        book["Sheet"].append(row)
    book.save(data)
    return data.getvalue()


PLACES = np.random.default_rng(7).permutation(ANGLES.size)
FRAME = pd.DataFrame({"temperature": 20.0 + PLACES, "hub": LIFTS[PLACES], "winkel": ANGLES[PLACES]})
SERIES = FRAME.set_index("winkel")["hub"]


@pytest.mark.parametrize(
    ("source", "columns"),
    [
        (SERIES, None),
        (SERIES.rename_axis(None), None),
        (SERIES.to_frame(), None),
        (SERIES.rename(None).rename_axis(None).to_frame(), None),
        (FRAME, None),
        (FRAME.set_index("winkel"), None),
        (FRAME.set_index("winkel"), ["winkel", "hub"]),
        (FRAME, ["winkel", "hub"]),
        (FRAME, [3, 2]),
        (FRAME.rename(columns={"winkel": "a", "hub": "b"}), ["a", "b"]),
        (FRAME.to_dict("list"), None),
        (FRAME.convert_dtypes(), None),
        (polars.DataFrame(FRAME.to_dict("list")), ["winkel", "hub"]),
        (pyarrow.table(FRAME.to_dict("list")), None),
        (pd.Series(LIFTS), None),
        (pd.Series(LIFTS).to_frame("hub"), None),
        (polars.Series(LIFTS), None),
        (pd.DataFrame(np.column_stack([ANGLES, LIFTS])), [1, 2]),
    ],
)
def test_tables_have_names_and_a_series_its_index(source, columns):
    agree(read_points(source, TableReadingOptions(columns)), 1e-11)


@pytest.mark.parametrize(
    ("source", "line"),
    [
        (FRAME.assign(note="a"), "points: rows: must be a path, or rows of an angle and a lift"),
        (SERIES.rename(index=str).rename(index=lambda each: f"row {each}"), "points: rows: must be a path"),
        (
            FRAME[["temperature", "hub", "temperature"]].set_axis(["hub", "a", "hub"], axis=1),
            "points: rows: must be",
        ),
        (FRAME.rename(columns={"winkel": "a"}), "which are angle and lift?"),
        ({"angle": [0.0, 1.0], "lift": [3.0]}, "points: rows: must be"),
        ({}, "points: rows: must be"),
        (SERIES.rename("lift (deg)"), "column 'lift (deg)': is in deg, and mm is taken"),
    ],
)
def test_a_table_that_is_none_of_points_is_refused(source, line):
    with pytest.raises(BadInput) as refused:
        read_points(source, TableReadingOptions())
    assert line in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_workbook(tmp_path):
    rows = list(zip(ANGLES, LIFTS, strict=True))
    points = points_of(workbook([("Angle", "Lift"), (), *rows]), tmp_path, "cam.xlsx")
    agree(points)
    assert points.rows[0] == 3
    agree(points_of(workbook([(None, a, f"{y}".replace(".", ",")) for a, y in rows]), tmp_path, "cam.xlsx"))


def archive(**parts):
    """A workbook of some parts, by their names with __ for a slash and a dot at the last _."""
    data = BytesIO()
    with ZipFile(data, "w", ZIP_DEFLATED) as into:
        for name, content in parts.items():
            place = name if "." in name else ".".join(name.replace("__", "/").rsplit("_", 1))
            into.writestr(place, content)  # mimetype has no ending
    return data.getvalue()


TABLE = "urn:oasis:names:tc:opendocument:xmlns:table:1.0"
OFFICE = "urn:oasis:names:tc:opendocument:xmlns:office:1.0"
TEXT = "urn:oasis:names:tc:opendocument:xmlns:text:1.0"


def open_document(rows, before="", after=""):
    """A spreadsheet of LibreOffice: rows of numbers, and what is before and after them."""

    def cell(value):
        return f'<table:table-cell office:value-type="float" office:value="{value}"><text:p>{value}</text:p></table:table-cell>'

    table = "".join(f"<table:table-row>{''.join(map(cell, row))}</table:table-row>" for row in rows)
    content = (
        f'<office:document-content xmlns:office="{OFFICE}" xmlns:table="{TABLE}" xmlns:text="{TEXT}"><office:body><office:spreadsheet>'
        f'<table:table table:name="cam">{before}{table}{after}</table:table></office:spreadsheet></office:body></office:document-content>'
    )
    manifest = '<m:manifest xmlns:m="urn:oasis:names:tc:opendocument:xmlns:manifest:1.0"/>'
    kind = "application/vnd.oasis.opendocument.spreadsheet"
    return archive(mimetype=kind, content_xml=content, **{"META-INF__manifest_xml": manifest})


def cell_in_the_corner():
    book, data = openpyxl.Workbook(), BytesIO()
    book["Sheet"].append((0, 1))
    book["Sheet"].cell(1_048_576, 16_384, 5.0)
    book.save(data)
    return data.getvalue()


def archive_that_lies(size):
    """The directory says that a part of so many bytes ends after the first tag, and has the checksum of this."""
    tag = b"<workbook/>"
    content = tag.ljust(size)
    data = archive(xl__workbook_xml=content)
    for true, said in ((size, len(tag)), (crc32(content), crc32(tag))):
        data = data.replace(true.to_bytes(4, "little"), said.to_bytes(4, "little"))
    return data


def record(kind, content=b""):
    return bytes([*([kind] if kind < 128 else [kind & 127 | 128, kind >> 7]), len(content)]) + content


def binary_workbook(cells, relation="a"):
    """A workbook of .xlsb with numbers in cells: row, column and number of each."""
    related = f'<Relationships><Relationship Id="{relation}" Target="worksheets/sheet1.bin"/></Relationships>'
    names = b"".join(pack("<I", len(text)) + text.encode("utf-16-le") for text in ("a", "cam"))
    sheet = record(0x94, bytes(16)) + record(0x91)
    for row, column, number in cells:
        sheet += record(0, pack("<II", row - 1, 0)) + record(5, pack("<IId", column - 1, 0, number))
    return archive(
        **{"xl/_rels/workbook.bin.rels": related},
        xl__workbook_bin=record(0x9C, pack("<II", 0, 1) + names) + record(0x90) + record(0x9D),
        xl__worksheets__sheet1_bin=sheet + record(0x92),
    )


def sheet_of(rows):
    """A workbook of .xlsx with a sheet of rows that are given as XML."""
    data = BytesIO()
    with ZipFile(BytesIO(workbook([(1, 2)]))) as book, ZipFile(data, "w", ZIP_DEFLATED) as into:
        for name in book.namelist():
            content = book.read(name)
            if name.endswith("sheet2.xml"):
                content = re.sub(
                    rb"<sheetData>.*</sheetData>", b"<sheetData>%s</sheetData>" % rows.encode(), content
                )
            into.writestr(name, content)
    return data.getvalue()


FIRST = '<row r="1"><c r="A1"><v>1</v></c></row>'
TOO_LARGE = {
    "a cell in the last corner": (cell_in_the_corner, r"has a sheet up to row 1048576 and column 16384; at most 2000000 cells are allowed"),
    "a cell in single quotes": (lambda: sheet_of(FIRST + "<row r='2'><c r = 'XFD1048576'><v>1</v></c></row>"), r"has a sheet up to row 1048576 and column 16384"),
    "a comment before the number": (lambda: sheet_of(FIRST + '<row r="2"><c r="XFD1048576"><!-- --><v>1</v></c></row>'), r"has a sheet up to row 1048576 and column 16384"),
    "cells that name no place": (lambda: sheet_of(FIRST + '<row r="1048576">' + 16384 * "<c><v>1</v></c>" + "</row>"), r"has a sheet up to row 1048576 and column 16384"),
    "a row beyond the sheet": (lambda: sheet_of(FIRST + '<row r="4294967295"><c r="A4294967295"><v>1</v></c></row>'), r"has a sheet up to row 4294967295 and column 1"),
    "a corner of .xlsb": (lambda: binary_workbook([(1, 1, 5.0), (1048576, 16384, 6.0)]), r"has a sheet up to row 1048576 and column 16384"),
    "much that is unpacked": (lambda: archive(xl__media__picture_png=bytes(65 << 20)), r"is a workbook of more than 64 MiB when unpacked: save the table as CSV"),
    "a directory that lies": (lambda: archive_that_lies(65 << 20), r"is a workbook of more than 64 MiB when unpacked: save the table as CSV"),
}  # fmt: skip


@pytest.mark.parametrize("name", TOO_LARGE)
def test_a_workbook_that_is_too_large_is_refused_before_its_reader_sees_it(name, tmp_path, monkeypatch):
    monkeypatch.setattr("python_calamine.CalamineWorkbook.from_filelike", lambda _: pytest.fail("it is read"))
    content, told = TOO_LARGE[name]
    with pytest.raises(BadInput, match=rf"^\S+: file: {told}") as error:
        points_of(content(), tmp_path, "cam.xlsx")
    assert len(str(error.value).splitlines()) == 1


def test_what_has_nothing_in_it_makes_no_workbook_large(tmp_path):
    """LibreOffice ends its sheets with repeated empty rows, Excel formats cells without values."""
    rows = [(float(a), float(y)) for a, y in zip(ANGLES, LIFTS, strict=True)]
    empty = '<table:table-row table:number-rows-repeated="1048000"><table:table-cell table:number-columns-repeated="16384"/></table:table-row>'
    agree(points_of(open_document(rows, after=empty), tmp_path, "cam.ods"))
    book, data = openpyxl.Workbook(), BytesIO()
    for row in rows:
        book["Sheet"].append(row)
    book["Sheet"].cell(1_048_576, 16_384).font = openpyxl.styles.Font(bold=True)
    book.save(data)
    agree(points_of(data.getvalue(), tmp_path, "cam.xlsx"))


def test_a_binary_workbook(tmp_path):
    cells = (
        (k + 3, k2 + 2, x) for k, row in enumerate(zip(ANGLES, LIFTS, strict=True)) for k2, x in enumerate(row)
    )
    agree(points_of(binary_workbook(cells), tmp_path, "cam.xlsb"))


def test_a_damaged_binary_workbook_is_refused(tmp_path):
    """calamine panics, which is no Exception of Python."""
    data = binary_workbook([(1, 1, 5.0)], relation="b")
    with pytest.raises(BadInput, match="file: is not a readable workbook"):
        points_of(data, tmp_path, "cam.xlsb")


@given(row=st.integers(1, 1_048_576), column=st.integers(1, 16_384), binary=st.booleans())
def test_the_last_cell_of_a_workbook_is_found(row, column, binary):
    """Its name is openpyxl's."""
    place = f"{openpyxl.utils.get_column_letter(column)}{row}"
    sheet = f'<x:row r="{row}"><x:c s="1" r="{place}" t="n"><x:v>1</x:v></x:c></x:row>'
    data = binary_workbook([(row, column, 1.0)]) if binary else archive(xl__worksheets__sheet1_xml=sheet)
    if row * column > 2_000_000:
        with pytest.raises(ValueError, match=f"row {row} and column {column};"):
            workbook_rows(data)
    elif binary:
        assert workbook_rows(data)[-1].number == row
    else:
        with pytest.raises(ValueError, match="is not a readable workbook"):
            workbook_rows(data)


def test_a_workbook_without_its_reader(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "python_calamine", None)
    with pytest.raises(BadInput, match=r'is a workbook; pip install "camopt\[excel\]"'):
        points_of(workbook([(1, 2)]), tmp_path, "cam.xlsx")


def test_what_is_a_little_less_than_an_angle_of_0_is_not_a_turn():
    assert forward_angle_deg(0.0, np.array([-1e-20, 0.0, 359.0, 360.0])).tolist() == [0.0, 0.0, 359.0, 0.0]


def with_row(place, text):
    rows = ROWS.copy()
    rows[place] = text
    return "\n".join(rows)


BAD = {
    "empty": ("", "rows: has no row of numbers"),
    "words alone": ("Angle;Lift\nsee below", "rows: has no row of numbers"),
    "few points": ("\n".join(ROWS[:5]), "rows = 5: must be at least 12 points"),
    "a word": (with_row(9, "45,high"), "row 10 = 'high': is not a number, such as 12.5"),
    "a unit": (with_row(9, "45,1.5 mm"), "row 10 = '1.5 mm': is not a number"),
    "not a number": (with_row(9, "45,nan"), "row 10 = 'nan': is not a number"),
    "infinite": (with_row(9, "45,inf"), "row 10 = 'inf': is not a number"),
    "no lift": (with_row(9, "45"), "row 10: has 1 numbers, and most rows have 2"),
    "no angle": (with_row(9, ",1.5"), "row 10: has an empty cell"),
    "three numbers": (with_row(9, "45,1.5,2.5"), "row 10: has 3 numbers, and most rows have 2"),
    "last words": ("\n".join([*ROWS, "end of data"]), "row 73 = 'end of data': is not a number"),
    "two decimal signs": (with_row(9, "45;1.5").replace(",", ";").replace("1.5", "1,5"), "row 10 = '1,5': is not a number"),
    "two delimiters": (with_row(0, "0;0"), "row 1: is not read as 2 numbers like most rows, and no heading"),
    "thousands": ("\n".join(f"{a:g};1.234,{k:02}" for k, a in enumerate(ANGLES)), "rows: has no row of numbers"),
    "three columns": ("\n".join(f"{r},1" for r in ROWS), "columns = '1, 2, 3': which are angle and lift?"),
    "two turns": ("\n".join(f"{2 * a:g},{y}" for a, y in zip(ANGLES, LIFTS, strict=True)), "row 72 = 710.0: the angles go from 0 (row 1) to 710, more than a turn; give 720 as the turn"),
    "far away": (with_row(9, "45,1e9"), "row 10 = 1000000000.0: the lift must be within"),
    "far round": (with_row(9, "4e7,1"), "row 10 = 40000000.0: the angle must be within"),
    "one angle": ("\n".join(f"5,{y}" for y in LIFTS), "angles = 1: must be at least 12 different ones"),
    "no motion": ("\n".join(f"{a:g},2" for a in ANGLES), "row 1 = 2.0: all rows have this lift: the follower does not move"),
    "degrees": ("Angle (deg),Lift (deg)\n" + "\n".join(ROWS), "column 'Lift (deg)': is in deg, and mm is taken; give the unit of the lifts as deg"),
    "microns": ("Angle,Lift µm\n" + "\n".join(ROWS), "column 'Lift µm': is in µm, and mm is taken; only mm, inch, deg can be read"),
    "radians": ("Angle [rad],Lift\n" + "\n".join(ROWS), "column 'Angle [rad]': is in rad, and deg is taken; give the unit of the angles as rad"),
    "no text": (b"\x00\x01\x02" * 100, "file: is neither text nor an Excel workbook"),
    "broken XML": (archive(xl__workbook_xml="<a><b></a>"), "file: is not a readable workbook"),
    "a broken workbook": (b"PK\x03\x04 and no more", "file: is not a readable workbook"),
    "a workbook of words": (workbook([("a", "b")]), "rows: has no row of numbers"),
    "a date": (workbook([(a, "2026-05-01" if a == 45 else y) for a, y in zip(ANGLES, LIFTS, strict=True)]), "row 10 = '2026-05-01': is not a number"),
    "too long": ("\n".join("1" for _ in range(20_001)), "rows = 20001: at most 20000 are allowed"),
    "a long line": (with_row(9, "1" * 10_000_000), "file: has 10000000 characters in line 10; at most 2000 are allowed"),
    "many lines": ("\n" * 1_000_000, "file: has 1000000 lines; at most 40000 are allowed"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_gets_one_line_with_its_row(name, tmp_path):
    content, line = BAD[name]
    with pytest.raises(BadInput) as error:
        points_of(content, tmp_path)
    (told,) = str(error.value).splitlines()
    assert told.startswith(f"{tmp_path / 'cam.csv'}: {line}")
    assert told.isprintable()


@pytest.mark.parametrize(
    ("columns", "line"),
    [
        ({"angle_unit": "gon"}, "angle_unit = 'gon': must be one of deg, rad"),
        ({"lift_unit": "mil"}, "lift_unit = 'mil': must be one of mm, inch, deg"),
        ({"turn": 0.0}, "turn = 0.0: must be above 0: the angle of a whole turn"),
        ({"turn": float("nan")}, "turn = nan: must be above 0: the angle of a whole turn"),
        ({"chosen": [1, 2, 3]}, r"columns = \[1, 2, 3\]: must be those of angle and lift"),
        ({"chosen": ["1", "lift"]}, "columns = 'lift': must be a number from 1 to 2"),
        ({"chosen": [1, 3]}, "columns = 3: must be a number from 1 to 2"),
    ],
)
def test_a_bad_choice_is_named(tmp_path, columns, line):
    with pytest.raises(BadInput, match=line):
        points_of("\n".join(ROWS), tmp_path, **columns)


@given(data=st.one_of(st.binary(max_size=400), st.text("0123456789.,;-+e# \t\nabcé", max_size=400)))
def test_whatever_is_in_a_file_is_read_or_refused(data, tmp_path_factory):
    try:
        points = points_of(data, tmp_path_factory.getbasetemp(), "any.dat")
    except BadInput as error:
        told = str(error).splitlines()
    else:
        told = ["nothing"]
        assert np.isfinite(points.lifts).all()
        assert (np.diff(points.angles) >= 0.0).all()
        assert points.angles.min() >= 0.0
        assert points.angles.max() < 360.0
    assert len(told) == 1


@pytest.mark.parametrize("points", [[["a", 1]], [[[1.0]]], [], None, object()])
def test_what_is_no_points_is_refused(points):
    with pytest.raises(BadInput, match="points: rows: must be a path, or rows of an angle and a lift"):
        read_points(points, TableReadingOptions())


def test_a_file_that_is_not_there_is_told():
    with pytest.raises(FileNotFoundError, match="'abc'"):
        read_points("abc", TableReadingOptions())
