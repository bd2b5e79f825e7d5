"""What was written is known again: any bit that is not as it was is found."""

import io
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory

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
from camopt.storage.damage import TableFault, open_table
from camopt.storage.seal import (
    BLANK,
    LONGEST_FOOTER,
    OLD_KEY,
    ROWS_IN_GROUP,
    SEAL_KEYS,
    close_seal,
    footer_of,
    sealed,
)
from camopt.storage.sealed import read_table, write_table

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
    with TemporaryDirectory() as folder:
        with sealed(path := Path(folder) / "table", table.schema, **options) as add:
            add(table)
        return path.read_bytes()


WHOLE = written(TABLE)
START = footer_of(io.BytesIO(WHOLE))[0]


def told(data):
    """What is said of a file that is no sealed table, or a damaged one; empty of one that is whole."""
    try:
        open_table(io.BytesIO(data))
    except TableFault as fault:
        return str(fault)
    return ""


def test_a_whole_table_is_whole():
    assert told(WHOLE) == ""


def test_the_digests_are_those_of_the_bytes():
    """By hand: the metadata are at the end, the digest of the footer in it with zeros in its place."""
    pages, footer = WHOLE[:START], WHOLE[START:]
    found = pq.ParquetFile(io.BytesIO(WHOLE)).metadata.metadata
    assert found[b"camopt_pages"].decode() == sha256(pages).hexdigest()
    blank = footer.replace(found[b"camopt_footer"], b"0" * 64)
    assert found[b"camopt_footer"].decode() == sha256(blank).hexdigest()
    assert len(blank) == len(footer) == int.from_bytes(WHOLE[-8:-4], "little") + 8


@pytest.mark.parametrize(
    "bits", [pytest.param(range(8), marks=pytest.mark.long, id="all"), pytest.param([3], id="one")]
)
def test_a_flipped_bit_in_any_byte_is_found(bits):
    for place in range(len(WHOLE)):
        for bit in bits:
            end = f"cut short after {len(WHOLE):,} bytes, or damaged at its end"
            expected = "damaged" if place < len(WHOLE) - 4 else end
            assert told(hostile.flipped(WHOLE, 8 * place + bit)) == expected, (place, bit)


def test_without_a_seal_flipped_bits_make_other_tables():
    """Why there is one: Parquet's checksums are of pages alone."""
    others = 0
    for place in range(START, len(WHOLE) - 8):
        try:
            data = pa.BufferReader(hostile.flipped(WHOLE, 8 * place))
            read = pq.ParquetFile(data, page_checksum_verification=True).read(use_threads=False)
            others += repr(read.to_pydict()) != repr(TABLE.to_pydict()) or read.schema.metadata != SAID
        except (pa.ArrowException, ValueError, OSError):
            pass
    assert others > 10


SAID = pq.ParquetFile(io.BytesIO(WHOLE)).schema_arrow.metadata


def test_a_table_cut_at_any_length_is_found():
    for length in range(len(WHOLE)):
        assert told(WHOLE[:length]) == f"cut short after {length:,} bytes, or damaged at its end"


@given(start=st.integers(0, len(WHOLE)), lost=st.integers(1, 600), filled=st.booleans())
def test_lost_blocks_are_found(start, lost, filled):
    """Of a disk or a transfer: bytes that are zeros, or not there."""
    gone = WHOLE[start : start + lost]
    damaged = WHOLE[:start] + b"\0" * (len(gone) * filled) + WHOLE[start + lost :]
    assert (damaged == WHOLE) == (told(damaged) == "")


def test_no_memory_is_taken_for_a_footer_that_is_too_long(tmp_path):
    with (tmp_path / "t.parquet").open("w+b") as file:  # it has holes, so that it takes no room on disk
        file.write(WHOLE[:START])
        file.truncate(LONGEST_FOOTER + 4096)
        file.seek(0, io.SEEK_END)
        file.write((LONGEST_FOOTER + 1).to_bytes(4, "little") + b"PAR1")
        with pytest.raises(ValueError, match="no footer is so long"):
            footer_of(file)


def test_what_follows_a_table_is_found():
    assert told(WHOLE + b"\n").startswith("cut short after")
    assert told(WHOLE + WHOLE) == "damaged"


def test_rows_in_groups_are_one_table(tmp_path):
    rows = ROWS_IN_GROUP + 100
    numbers = pa.array([float(k * k % 1009) for k in range(rows)], pa.float64())
    table = pa.table({"first_mm": numbers, "law": pa.array(["cycloidal"] * rows)})
    (tmp_path / "t.parquet").write_bytes(written(table, use_dictionary=["law"]))
    assert read_table(tmp_path / "t.parquet").equals(table)


def test_a_table_that_an_earlier_camopt_sealed_is_read_and_its_damage_is_found(tmp_path):
    """Its seal had a digest of the rows besides."""
    sink = io.BytesIO()
    with pq.ParquetWriter(sink, LAYOUT, use_compliant_nested_type=False) as parquet:
        parquet.write_table(TABLE)
        parquet.add_key_value_metadata({OLD_KEY: BLANK, **dict.fromkeys(SEAL_KEYS, BLANK)})
    close_seal(sink)
    (tmp_path / "t.parquet").write_bytes(sink.getvalue())
    table = read_table(tmp_path / "t.parquet")
    assert table.schema.equals(LAYOUT, check_metadata=True)
    assert repr(table.to_pydict()) == repr(TABLE.to_pydict())
    for place in range(0, len(sink.getvalue()), 7):
        assert told(hostile.flipped(sink.getvalue(), 8 * place)), place


@pytest.fixture
def table_file(tmp_path):
    write_table(TABLE, tmp_path / "t.parquet")
    return tmp_path / "t.parquet"


def test_other_programs_read_a_sealed_table(table_file):
    assert repr(pq.read_table(table_file).to_pydict()) == repr(TABLE.to_pydict())
    assert pd.read_parquet(table_file).law.tolist()[:2] == ["cycloidal", ""]


def test_the_seal_is_not_a_part_of_the_table_that_is_read(table_file):
    table = read_table(table_file)
    assert table.schema.equals(LAYOUT, check_metadata=True)
    assert table.schema.metadata.keys().isdisjoint(key.encode() for key in SEAL_KEYS)


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
    line = capsys.readouterr().err
    assert f"another program ({'pandas' if how == 'pandas' else 'parquet-cpp-arrow'}" in line
    assert "choose rows of it afterwards" in line
    assert table_file.read_bytes() == before
    with pytest.raises(BadInput, match="as camopt saved it"):
        camopt.load(table_file)
