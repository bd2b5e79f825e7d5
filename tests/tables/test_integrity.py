"""What was written is known again: any bit that is not as it was is found, and placed."""

import io
import struct
from hashlib import sha256
from itertools import pairwise

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import hostile

import camopt
from camopt import BadInput
from camopt.cli.exits import BAD_INPUT
from camopt.cli.main import main
from camopt.tables.damage import fault
from camopt.tables.row_digest import RowDigest
from camopt.tables.seal import KEYS, LONGEST_FOOTER, ROWS_IN_GROUP, footer_of, sealed
from camopt.tables.sealed import TableFile, read_table, write_table

COLUMNS = {
    "size_mm": pa.array([60.0, -0.0, None, 5e-324], pa.float64()),
    "count": pa.array([1, None, -(2**63), 0], pa.int64()),
    "feasible": pa.array([True, None, False, True], pa.bool_()),
    "law": pa.array(["cycloidal", "", None, "µ²"], pa.string()),
    "binding": pa.array([["a", None], [], None, ["bb", "ccc"]], pa.list_(pa.string())),
    "nothing": pa.nulls(4),
    "always_mm": pa.array([1.0, 2.0, float("inf"), float("nan")], pa.float64()),
}
LAYOUT = pa.schema(
    [pa.field(name, values.type, nullable=name != "always_mm") for name, values in COLUMNS.items()],
    metadata={"camopt_version": "1", "camopt_scene": "name = 'x'"},
)
TABLE = pa.table([*COLUMNS.values()], schema=LAYOUT)


def written(table, **options):
    sink = io.BytesIO()
    with sealed(sink, table.schema, **options) as add:
        add(table)
    return sink.getvalue()


WHOLE = written(TABLE)
START = footer_of(io.BytesIO(WHOLE))[0]


def said(data):
    found = fault(io.BytesIO(data))
    return found.told if found else ""


# --------------------------------------------------------------------------------------------------- the file


def test_a_whole_table_is_whole():
    assert said(WHOLE) == ""


def test_the_digests_are_those_of_the_bytes():
    """By hand: the metadata are at the end, the digest of the footer in it with zeros in its place."""
    pages, footer = WHOLE[:START], WHOLE[START:]
    found = pq.ParquetFile(io.BytesIO(WHOLE)).metadata.metadata
    assert found[b"camopt_pages"].decode() == sha256(pages).hexdigest()
    blank = footer.replace(found[b"camopt_footer"], b"0" * 64)
    assert found[b"camopt_footer"].decode() == sha256(blank).hexdigest()
    assert len(blank) == len(footer) == int.from_bytes(WHOLE[-8:-4], "little") + 8


@pytest.mark.parametrize(
    "bit", [pytest.param(range(8), marks=pytest.mark.long, id="all"), pytest.param([3], id="one")]
)
def test_a_flipped_bit_in_any_byte_is_found_and_placed(bit):
    for place in range(len(WHOLE)):
        for which in bit:
            told = said(hostile.flipped(WHOLE, 8 * place + which))
            if place < 4:
                assert told == "damaged in its first 4 bytes"
            elif place < START:
                assert told.startswith(("damaged in column ", "damaged in the header of a page"))
            elif place < len(WHOLE) - 8:
                assert told == f"damaged in its footer, bytes {START:,} to {len(WHOLE) - 1:,}"
            elif place < len(WHOLE) - 4:
                assert told.startswith("damaged in its footer") or told == "damaged in its last 8 bytes"
            else:
                assert told == f"cut short after {len(WHOLE):,} bytes, or damaged there"


def test_a_table_cut_at_any_length_is_found():
    for length in range(len(WHOLE)):
        told = said(WHOLE[:length])
        assert told.startswith(f"cut short after {length:,} bytes"), (length, told)


@given(start=st.integers(0, len(WHOLE)), lost=st.integers(1, 600), filled=st.booleans())
def test_lost_blocks_are_found(start, lost, filled):
    """Of a disk or a transfer: bytes that are zeros, or not there."""
    gone = WHOLE[start : start + lost]
    damaged = WHOLE[:start] + b"\0" * (len(gone) * filled) + WHOLE[start + lost :]
    assert (damaged == WHOLE) == (said(damaged) == "")


def test_no_memory_is_taken_for_a_footer_that_is_too_long(tmp_path):
    with (tmp_path / "t.parquet").open("w+b") as file:  # it has holes, so that it takes no room on disk
        file.write(WHOLE[:START])
        file.truncate(LONGEST_FOOTER + 4096)
        file.seek(0, io.SEEK_END)
        file.write((LONGEST_FOOTER + 1).to_bytes(4, "little") + b"PAR1")
        assert fault(file).told == "damaged in its last 8 bytes"


def test_what_follows_a_table_is_found():
    assert said(WHOLE + b"\n").startswith("cut short after")
    assert said(WHOLE + WHOLE) != ""


@pytest.fixture(scope="module")
def two_groups():
    rows = ROWS_IN_GROUP + 100
    numbers = pa.array([float(k * k % 1009) for k in range(rows)], pa.float64())
    table = pa.table({"first_mm": numbers, "second_mm": numbers, "law": pa.array(["cycloidal"] * rows)})
    return written(table, use_dictionary=["law"])


@pytest.mark.parametrize("column", range(3))
@pytest.mark.parametrize(("group", "rows"), [(0, "0 to 131,071"), (1, "131,072 to 131,171")])
def test_damage_is_placed_by_column_and_rows(two_groups, column, group, rows):
    about = pq.ParquetFile(io.BytesIO(two_groups)).metadata.row_group(group).column(column)
    last = about.data_page_offset + about.total_compressed_size - 1
    if about.dictionary_page_offset is not None:
        last = about.dictionary_page_offset + about.total_compressed_size - 1
    told = said(hostile.flipped(two_groups, 8 * last))
    assert told == f"damaged in column {about.path_in_schema}, rows {rows}"


def test_many_damaged_places_are_counted(two_groups):
    start = footer_of(io.BytesIO(two_groups))[0]
    told = said(two_groups[:4] + b"\xff" * (start - 4) + two_groups[start:])
    assert told.startswith("damaged in column first_mm, rows 0 to 131,071; column second_mm, ")
    assert told.endswith(", and 3 more places")


# --------------------------------------------------------------------------------------------------- the rows


def slow_digest(table):
    """The digest by its definition, value by value."""

    def streams(values, kind, nullable):
        present = [bytes([value is not None]) for value in values]
        found = [b"".join(present)] if nullable else []
        if pa.types.is_float64(kind):
            return [*found, b"".join(struct.pack("<d", 0.0 if value is None else value) for value in values)]
        if pa.types.is_int64(kind):
            return [*found, b"".join(struct.pack("<q", value or 0) for value in values)]
        if pa.types.is_boolean(kind):
            return [*found, b"".join(bytes([bool(value)]) for value in values)]
        if pa.types.is_null(kind):
            return found
        items = [(value or "").encode() if pa.types.is_string(kind) else value or [] for value in values]
        found.append(b"".join(struct.pack("<i", len(item)) for item in items))
        if pa.types.is_string(kind):
            return [*found, b"".join(items)]
        return found + streams([each for item in items for each in item], kind.value_type, nullable=True)

    columns = [
        (
            field.name,
            str(field.type),
            field.nullable,
            [
                sha256(each).hexdigest()
                for each in streams(table[field.name].to_pylist(), field.type, field.nullable)
            ],
        )
        for field in table.schema
    ]
    return sha256(repr((table.num_rows, columns)).encode()).hexdigest()


def digest_of(*tables):
    digest = RowDigest(tables[0].schema)
    for table in tables:
        digest.update(table)
    return digest.hexdigest()


def test_the_digest_of_rows_is_that_of_its_definition():
    assert digest_of(TABLE) == slow_digest(TABLE)
    none = TABLE.slice(0, 0)
    assert digest_of(none) == slow_digest(none)


@given(st.lists(st.integers(0, 4), max_size=4))
def test_the_digest_of_rows_does_not_depend_on_groups(cuts):
    edges = [0, *sorted(cuts), 4]
    parts = [TABLE.slice(a, b - a) for a, b in pairwise(edges)]
    assert digest_of(*parts) == digest_of(pa.concat_tables(parts)) == digest_of(TABLE)


def test_the_digest_of_rows_is_in_the_file_and_that_of_what_is_read(tmp_path):
    for options in ({}, {"compression_level": 9}, {"use_dictionary": False}, {"data_page_size": 8}):
        (tmp_path / "t.parquet").write_bytes(written(TABLE, use_compliant_nested_type=False, **options))
        with (tmp_path / "t.parquet").open("rb") as file:
            table = TableFile("t.parquet", file)
            assert table.row_digest == digest_of(table.read()) == digest_of(TABLE)
    other = TABLE.replace_schema_metadata({"camopt_scene": "another"})
    assert digest_of(other) == digest_of(TABLE)


@pytest.mark.parametrize("name", ["size_mm", "count", "feasible", "law", "binding"])
@pytest.mark.parametrize("row", range(4))
def test_another_value_is_another_digest(name, row):
    values = TABLE[name].to_pylist()
    kind, other = TABLE[name].type, {"size_mm": 0.0, "count": 7, "feasible": None, "law": "x", "binding": ["a", ""]}
    for value in (None, other[name]):
        changed = pa.array([*values[:row], value, *values[row + 1 :]], kind)
        table = TABLE.set_column(TABLE.column_names.index(name), LAYOUT.field(name), changed)
        assert (digest_of(table) == digest_of(TABLE)) == (repr(value) == repr(values[row]))


@pytest.mark.parametrize("kind", [pa.float32(), pa.large_string(), pa.dictionary(pa.int32(), pa.string())])
def test_columns_that_no_table_has_have_no_digest(kind):
    with pytest.raises(TypeError, match="no columns of type"):
        digest_of(pa.table({"odd": pa.nulls(3, kind)}))


def test_rows_in_another_order_have_another_digest():
    assert digest_of(TABLE.take([1, 0, 2, 3])) != digest_of(TABLE)


# ------------------------------------------------------------------------------------------- other programs


@pytest.fixture
def table_file(tmp_path):
    write_table(TABLE, tmp_path / "t.parquet")
    return tmp_path / "t.parquet"


def test_other_programs_read_a_sealed_table(table_file):
    assert digest_of(pq.read_table(table_file)) == digest_of(TABLE)
    assert pd.read_parquet(table_file).law.tolist()[:2] == ["cycloidal", ""]


def test_the_seal_is_not_a_part_of_the_table_that_is_read(table_file):
    table = read_table(table_file)
    assert table.schema.equals(LAYOUT, check_metadata=True)
    assert table.schema.metadata.keys().isdisjoint(key.encode() for key in KEYS)


SAVED = {
    "pandas": lambda path: pd.read_parquet(path).iloc[:2].to_parquet(path),
    "arrow": lambda path: pq.write_table(pq.read_table(path).slice(0, 2), path),
    "arrow with all metadata": lambda path: pq.write_table(pq.ParquetFile(path).read().slice(0, 2), path),
    "arrow, all rows": lambda path: pq.write_table(pq.ParquetFile(path).read(), path, compression="none"),
}


@pytest.mark.parametrize("how", SAVED)
def test_a_table_that_another_program_saved_is_told_from_a_damaged_one(table_file, how, capsys):
    SAVED[how](table_file)
    before = table_file.read_bytes()
    assert main(["certify", str(table_file)]) == BAD_INPUT
    told = capsys.readouterr().err
    assert f"another program ({'pandas' if how == 'pandas' else 'parquet-cpp-arrow'}" in told
    assert "choose rows of it afterwards" in told
    assert table_file.read_bytes() == before
    with pytest.raises(BadInput, match="as camopt saved it"):
        camopt.load(table_file)
