"""The designs that differ between two results, as a table on disk."""

import os
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import csv

from camopt.comparing.design_table import DesignTable
from camopt.comparing.designs import Matching, as_text
from camopt.storage.files import check_writable, checked_suffix, path_of, whole_file
from camopt.storage.tables import write_table
from camopt.storage.version import VERSION

PARQUET, CSV = ".parquet", ".csv"
ORIGIN = pa.schema({"change": pa.string(), "table": pa.string(), "row": pa.int64()})
"""Columns that say where a row comes from, and what happened to its design."""
Different = tuple[DesignTable, DesignTable, Matching, NDArray[np.intp]]
"""Two tables, which of their rows are of the same designs, and pairs of rows that changed."""


def checked_place(path: str | os.PathLike[str]) -> Path:
    """The file to write; BadInput unless it is of a known kind, OSError if it cannot be written."""
    checked_suffix(path, "out", (PARQUET, CSV))
    place = path_of(path)
    check_writable(place)
    return place


def write_differences(found: Mapping[str, Different], path: Path) -> None:
    """Write all rows of designs that went, came or changed, with where they come from."""
    parts = [part for name, each in found.items() for part in _parts(name, *each)]
    table = pa.concat_tables([ORIGIN.empty_table(), *parts], promote_options="default")
    if path.suffix.lower() == PARQUET:
        write_table(table.replace_schema_metadata({"camopt_version": VERSION}), path)
        return
    columns = {name: table[name].combine_chunks() for name in table.column_names}
    texts = {name: as_text(column) if pa.types.is_list(column.type) else column for name, column in columns.items()}
    with whole_file(path) as partial:
        csv.write_csv(pa.table(texts), partial)


def _parts(
    name: str, a: DesignTable, b: DesignTable, pairs: Matching, changed: NDArray[np.intp]
) -> Iterator[pa.Table]:
    """The rows of two tables by what happened to them; of those that changed, both."""
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
            yield pa.table([*origin, *taken], schema=pa.schema([*ORIGIN, *layout]))
