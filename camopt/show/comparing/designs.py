"""Matches the designs of two tables: designs only in one table, and designs with changed quantities.

Designs are matched by integers. Each value of a key column is numbered over both tables; these numbers, combined
column after column, number the designs. The match is exact and takes linear time, with few columns in memory.
"""

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
from pyarrow import csv

from camopt.core.numerics import BoolArray, FloatArray, IndexArray, IntArray
from camopt.core.storage.files import atomically_written_file, check_writable, checked_suffix, expand_user_path
from camopt.core.storage.tables import write_table
from camopt.core.storage.version import VERSION
from camopt.scene.toml_text import parse_toml
from camopt.show.comparing.compared_results import SCENE_COLUMN, DesignTable

Index = IndexArray
MOST_CODES = 2**62
ERROR_BOUND = "relative_half_width"
"""A bound on errors: a change of it is no change of a quantity."""


class Matching(NamedTuple):
    """Row numbers: pairs of rows with the same design, and rows with designs only in one table."""

    in_a: Index
    in_b: Index
    went: Index
    came: Index


@dataclass(frozen=True)
class Change:
    """The change of a quantity over the designs in both tables."""

    designs: int
    """Number of designs in which it differs."""
    beyond: int
    """Number of designs in which it differs by more than the relative errors of both scenes, or is not a number."""
    largest: float | None
    """Largest change, relative to the larger value; None if the quantity is not a number."""
    a: Any
    """Value in A of the design with the largest change."""
    b: Any
    """Value in B of this design."""
    rows: tuple[int, int]
    """Rows of this design in A and B."""


def match_designs(a: DesignTable, b: DesignTable) -> Matching:
    """Pair the rows with the same design. Repeated designs are paired in the order of rows."""
    codes = np.zeros(a.count + b.count, dtype=np.int64)
    for name in dict.fromkeys((*a.key_columns, *b.key_columns)):
        codes = _pair_codes(codes, _value_codes(*(_key_column_or_scene_value(each, name) for each in (a, b))))
    codes = _dense_codes(codes)
    if any(np.bincount(side).max(initial=0) > 1 for side in (codes[: a.count], codes[a.count :])):
        again = np.concatenate(
            [_earlier_occurrence_counts(codes[: a.count]), _earlier_occurrence_counts(codes[a.count :])]
        )
        codes = _dense_codes(_pair_codes(codes, again))
    place = np.full(int(codes.max(initial=-1)) + 1, -1, dtype=np.intp)
    place[codes[a.count :]] = np.arange(b.count)
    partner = place[codes[: a.count]]
    in_a = np.flatnonzero(partner >= 0)
    in_b = partner[in_a]
    alone = np.ones(b.count, dtype=bool)
    alone[in_b] = False
    return Matching(in_a, in_b, np.flatnonzero(partner < 0), np.flatnonzero(alone))


def _pair_codes(codes: IntArray, column_codes: IntArray) -> IntArray:
    """A number for each pair of numbers."""
    many = int(column_codes.max(initial=0)) + 1
    if (int(codes.max(initial=0)) + 1) * many > MOST_CODES:
        codes = _dense_codes(codes)
    return codes * many + column_codes


def _dense_codes(codes: IntArray) -> IntArray:
    """The numbers renumbered from 0 without gaps."""
    return np.asarray(pa.array(codes).dictionary_encode().indices.to_numpy(), dtype=np.int64)


def _earlier_occurrence_counts(codes: IntArray) -> IntArray:
    """Count of earlier occurrences of each number."""
    order = np.argsort(codes, kind="stable")
    ordered = codes[order]
    first = np.concatenate([[True], ordered[1:] != ordered[:-1]])[: codes.size]
    start = np.maximum.accumulate(np.where(first, np.arange(codes.size), 0))
    counts = np.empty(codes.size, dtype=np.int64)
    counts[order] = np.arange(codes.size) - start
    return counts


def _key_column_or_scene_value(table: DesignTable, name: str) -> pa.Array:
    """A key column, or the value of the scene in its place. A column of scenes becomes one of their motions."""
    if name not in table.names:
        value = table.scene_value(name)
        return pa.nulls(table.count) if value is None else pa.array(np.full(table.count, value))
    column = table.column(name)
    if name != SCENE_COLUMN:
        return column
    return pa.array(
        [text and _motion_identity(parse_toml(text, table.name)) for text in column.to_pylist()], pa.string()
    )


def _motion_identity(scene_tables: Mapping[str, Any]) -> str:
    """The tables of a scene that define its motion, as text."""
    return repr([scene_tables.get(key) for key in ("motion", "profile", "laws")])


def _value_codes(a: pa.Array, b: pa.Array) -> IntArray:
    """A number for each distinct value of two joined columns; −0 equals 0."""
    both = pa.concat_arrays(_unify_types(a, b))
    coded = both.dictionary_encode(null_encoding="encode")
    return np.asarray(coded.indices.to_numpy(zero_copy_only=False), dtype=np.int64)


def _unify_types(*columns: pa.Array) -> list[pa.Array]:
    """The columns with one type: numbers if all are numbers, else texts."""
    if all(_is_numeric(column.type) for column in columns):
        return [pa.compute.add(column.cast(pa.float64()), 0.0) for column in columns]
    return [as_text(column) for column in columns]


def _is_numeric(kind: pa.DataType) -> bool:
    return bool(pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_null(kind))


def as_text(column: pa.Array) -> pa.Array:
    """A column of texts, flags or lists of texts, as texts."""
    if pa.types.is_list(column.type):
        return pa.array([None if each is None else ", ".join(each) for each in column.to_pylist()], pa.string())
    return column.cast(pa.string())


def changed_quantities_with_masks(
    a: DesignTable, b: DesignTable, pairs: Matching
) -> Iterator[tuple[str, Change, BoolArray, BoolArray]]:
    """Changed quantities: name, change, and masks of pairs that differ, at all and beyond the accuracy."""
    if not pairs.in_a.size:
        return
    for name in a.names:
        if name not in b.names or name in a.key_columns:
            continue
        one, other = a.column(name).take(pa.array(pairs.in_a)), b.column(name).take(pa.array(pairs.in_b))
        numbers = _is_numeric(one.type) and _is_numeric(other.type)
        compare = _compare_numbers if numbers else _compare_texts
        differs, share, beyond = compare(
            one, other, a.scene.accuracy.relative_error, b.scene.accuracy.relative_error
        )
        if not differs.any():
            continue
        if name == ERROR_BOUND:
            beyond = np.zeros_like(beyond)
        i = int(np.argmax(share))
        yield (
            name,
            Change(
                designs=int(differs.sum()),
                beyond=int(beyond.sum()),
                largest=float(share[i]) if numbers else None,
                a=one[i].as_py(),
                b=other[i].as_py(),
                rows=(int(pairs.in_a[i]), int(pairs.in_b[i])),
            ),
            differs,
            beyond,
        )


Differences = tuple[BoolArray, FloatArray, BoolArray]
"""Whether values differ, the share of the larger value, and whether beyond the accuracy."""


def _compare_numbers(a: pa.Array, b: pa.Array, relative_error_a: float, relative_error_b: float) -> Differences:
    """Differences of numbers. A number that is missing on one side, or infinite, has an infinite difference."""
    x, y = (np.asarray(column.to_numpy(zero_copy_only=False), dtype=float) for column in (a, b))
    differs = (x != y) & ~(np.isnan(x) & np.isnan(y))
    share, beyond = np.zeros(x.size), np.zeros(x.size, dtype=bool)
    x, y = x[differs], y[differs]
    with np.errstate(invalid="ignore", over="ignore"):
        apart, largest = np.abs(x - y), np.maximum(np.abs(x), np.abs(y))
        finite = np.isfinite(apart)
        share[differs] = np.where(finite, apart / np.where(finite, largest, 1.0), np.inf)
        beyond[differs] = ~finite | (apart > relative_error_a * np.abs(x) + relative_error_b * np.abs(y))
    return differs, share, beyond


def _compare_texts(a: pa.Array, b: pa.Array, *_: float) -> Differences:
    """Differences of texts, flags and lists of texts."""
    codes = _value_codes(a, b)
    differs = codes[: len(a)] != codes[len(a) :]
    return differs, differs.astype(float), differs


PARQUET, CSV = ".parquet", ".csv"
ORIGIN_SCHEMA = pa.schema({"change": pa.string(), "table": pa.string(), "row": pa.int64()})
"""Columns for the kind of change and the source of a row."""
ChangedTables = tuple[DesignTable, DesignTable, Matching, IndexArray]
"""Two tables, their matching, and pairs of rows that changed."""


def check_output_file(path: str | os.PathLike[str]) -> Path:
    """The path to write. Raises BadInput for another suffix, OSError if it cannot be written."""
    checked_suffix(path, "out", (PARQUET, CSV))
    place = expand_user_path(path)
    check_writable(place)
    return place


def write_differences(tables: Mapping[str, ChangedTables], path: Path) -> None:
    """Write all rows of designs only in one table, or changed, with their source."""
    parts = [part for name, each in tables.items() for part in _difference_rows(name, *each)]
    table = pa.concat_tables([ORIGIN_SCHEMA.empty_table(), *parts], promote_options="default")
    if path.suffix.lower() == PARQUET:
        write_table(table.replace_schema_metadata({"camopt_version": VERSION}), path)
        return
    columns = {name: table[name].combine_chunks() for name in table.column_names}
    texts = {name: as_text(column) if pa.types.is_list(column.type) else column for name, column in columns.items()}
    with atomically_written_file(path) as partial:
        csv.write_csv(pa.table(texts), partial)


def _difference_rows(
    name: str, a: DesignTable, b: DesignTable, pairs: Matching, changed: IndexArray
) -> Iterator[pa.Table]:
    """The differing rows of two tables, by kind of change; both rows of a changed design."""
    for change, table, rows in (
        ("went", a, pairs.went),
        ("came", b, pairs.came),
        ("before", a, changed[:, 0]),
        ("after", b, changed[:, 1]),
    ):
        if rows.size:
            origin = [pa.repeat(change, rows.size), pa.repeat(name, rows.size), pa.array(rows.astype(np.int64))]
            taken = [table.column(each).take(pa.array(rows)) for each in table.names]
            layout = [field.with_nullable(True) for field in table.layout]  # another table may lack a column
            yield pa.table([*origin, *taken], schema=pa.schema([*ORIGIN_SCHEMA, *layout]))
