"""Matches the designs of two tables: designs only in one table, and designs with changed quantities.

Designs are matched by integers. Each value of a key column is numbered over both tables; these numbers, combined
column after column, number the designs. The match is exact and takes linear time, with few columns in memory.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
from pyarrow import csv

from camopt.core.numerics import BoolArray, FloatArray, IndexArray, IntArray
from camopt.core.storage.files import atomically_written_file
from camopt.core.storage.tables import write_table
from camopt.core.storage.version import VERSION
from camopt.scene.problem.variables import variables_of_scene
from camopt.scene.toml_text import parse_toml
from camopt.show.comparing.compared_results import SCENE_COLUMN, DesignTable

MOST_CODES = 2**62
ERROR_BOUND = "relative_half_width"
"""A bound on errors: a change of it is no change of a quantity."""


class Matching(NamedTuple):
    """Row numbers: pairs of rows with the same design, and rows with designs only in one table."""

    in_a: IndexArray
    in_b: IndexArray
    went: IndexArray
    came: IndexArray


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
    sides = codes[: a.count], codes[a.count :]
    if any(np.bincount(side).max(initial=0) > 1 for side in sides):
        from pandas import Series  # only for repeated designs

        earlier = np.concatenate([Series(side).groupby(side).cumcount() for side in sides])  # occurrences before
        codes = _dense_codes(_pair_codes(codes, earlier))
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


def _key_column_or_scene_value(table: DesignTable, name: str) -> pa.Array:
    """A key column, or the value of the scene in its place. A column of scenes becomes one of their motions."""
    if name not in table.names:
        keys = [each.key for each in variables_of_scene(table.scene) if each.quantity == name]
        value = next(iter(table.scene.numbers(keys).values()), None)
        return pa.nulls(table.count) if value is None else pa.array(np.full(table.count, value))
    column = table.column(name)
    if name != SCENE_COLUMN:
        return column
    motions = []
    for text in column.to_pylist():
        scene_tables = parse_toml(text, table.name) if text else {}
        motions.append(text and repr([scene_tables.get(key) for key in ("motion", "profile", "laws")]))
    return pa.array(motions, pa.string())


def _value_codes(a: pa.Array, b: pa.Array) -> IntArray:
    """A number for each distinct value of two joined columns, as numbers (−0 equals 0) or texts."""
    numeric = _is_numeric(a.type) and _is_numeric(b.type)
    both = [pa.compute.add(each.cast(pa.float64()), 0.0) if numeric else as_text(each) for each in (a, b)]
    coded = pa.concat_arrays(both).dictionary_encode(null_encoding="encode")
    return np.asarray(coded.indices.to_numpy(zero_copy_only=False), dtype=np.int64)


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
        if numbers:
            errors = a.scene.accuracy.relative_error, b.scene.accuracy.relative_error
            differs, share, beyond = _compare_numbers(one, other, *errors)
        else:
            codes = _value_codes(one, other)
            differs = beyond = codes[: len(one)] != codes[len(one) :]
            share = differs.astype(float)
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


def _compare_numbers(
    a: pa.Array, b: pa.Array, relative_error_a: float, relative_error_b: float
) -> tuple[BoolArray, FloatArray, BoolArray]:
    """Whether numbers differ, by which share of the larger one, and whether by more than both relative errors.

    A number that is missing on one side, or infinite, has an infinite difference.
    """
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


PARQUET, CSV = ".parquet", ".csv"
ORIGIN_SCHEMA = pa.schema({"change": pa.string(), "table": pa.string(), "row": pa.int64()})
"""Columns for the kind of change and the source of a row."""


def write_differences(
    tables: Mapping[str, tuple[DesignTable, DesignTable, Matching, IndexArray]], path: Path
) -> None:
    """Write all rows of designs only in one table, and both rows of changed designs, with their source.

    ``tables`` has two tables, their matching, and pairs of rows that changed.
    """
    parts = []
    for name, (a, b, pairs, changed) in tables.items():
        kinds = (
            ("went", a, pairs.went),
            ("came", b, pairs.came),
            ("before", a, changed[:, 0]),
            ("after", b, changed[:, 1]),
        )
        for change, side, rows in (kind for kind in kinds if kind[2].size):
            origin = [pa.repeat(change, rows.size), pa.repeat(name, rows.size), pa.array(rows.astype(np.int64))]
            taken = [side.column(each).take(pa.array(rows)) for each in side.names]
            layout = [field.with_nullable(True) for field in side.layout]  # another table may lack a column
            parts.append(pa.table([*origin, *taken], schema=pa.schema([*ORIGIN_SCHEMA, *layout])))
    table = pa.concat_tables([ORIGIN_SCHEMA.empty_table(), *parts], promote_options="default")
    if path.suffix.lower() == PARQUET:
        write_table(table.replace_schema_metadata({"camopt_version": VERSION}), path)
        return
    columns = {name: table[name].combine_chunks() for name in table.column_names}
    texts = {name: as_text(column) if pa.types.is_list(column.type) else column for name, column in columns.items()}
    with atomically_written_file(path) as partial:
        csv.write_csv(pa.table(texts), partial)
