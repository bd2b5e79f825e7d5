"""Rows of designs as tables of arrow, and groups of them in a Parquet file."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from camopt.problem.rows import Rows
from camopt.quantities import QUANTITIES, Quantity
from camopt.storage.seal import ROWS_IN_GROUP, Tell, sealed
from camopt.storage.sealed import TYPES
from camopt.storage.version import VERSION


def arrow_schema(names: tuple[str, ...], scene: str) -> pa.Schema:
    """The schema of some quantities, with the scene (TOML text) and the version that made the table."""
    return schema_of((QUANTITIES[name] for name in names), camopt_scene=scene)


def schema_of(quantities: Iterable[Quantity], **about: str) -> pa.Schema:
    """The schema of quantities, with the version that made the table, and what else there is to say of it."""
    fields = []
    for each in quantities:
        facts = {"unit": each.unit, "symbol": each.symbol, "description": each.sentence}
        fields.append(pa.field(each.name, TYPES[each.kind], nullable=False, metadata=facts))
    return pa.schema(fields, metadata={"camopt_version": VERSION, **about})


def to_table(rows: Rows, layout: pa.Schema) -> pa.Table:
    """Rows as an arrow table."""
    return pa.table([array_of(rows.columns[c.name], rows.count, c.type) for c in layout], schema=layout)


def array_of(value: Any, rows: int, kind: pa.DataType) -> pa.Array:
    """A column as an arrow array, from its bytes: ``pa.array`` and ``pa.scalar`` would import pandas, at 0.3 s."""
    if kind == pa.string():
        starts = first_of_equals(value, rows)
        value = np.broadcast_to(value, (rows,))
        texts, repeats = [text.encode() for text in value[starts].tolist()], np.diff(starts, append=rows)
        lengths = np.repeat(np.array([0, *map(len, texts)]), [1, *repeats])
        ends = np.cumsum(lengths, dtype=np.int32)
        data = b"".join(text * count for text, count in zip(texts, repeats.tolist(), strict=True))
        return pa.Array.from_buffers(kind, rows, [None, pa.py_buffer(ends), pa.py_buffer(data)])
    value = np.broadcast_to(value, (rows,))
    if kind == pa.bool_():
        bits = np.packbits(value, bitorder="little")
        return pa.Array.from_buffers(kind, rows, [None, pa.py_buffer(bits)])
    values = np.ascontiguousarray(value, dtype=float)
    return pa.Array.from_buffers(kind, rows, [None, pa.py_buffer(values)])


def first_of_equals(value: Any, rows: int) -> NDArray[np.intp]:
    """The rows of a column whose value is not that of the row before."""
    changes = value[1:] != value[:-1] if np.ndim(value) else np.zeros(max(rows - 1, 0), dtype=bool)
    return np.flatnonzero(np.concatenate([[rows > 0], changes]))


def parquet_options(layout: pa.Schema) -> dict[str, Any]:
    """Options of Parquet by which rows of designs take little room, and little time.

    Values that repeat go by a dictionary. Others are split by bytes (BYTE_STREAM_SPLIT): the leading bytes of
    doubles are much the same from row to row, and compress well.
    """
    known = (QUANTITIES[name] for name in layout.names if name in QUANTITIES)
    repeats = {q.name for q in known if q.effect in ("sizes", "motion") or q.kind is not float}
    floats = [field.name for field in layout if pa.types.is_floating(field.type)]
    return {
        "use_dictionary": [name for name in layout.names if name in repeats],
        "use_byte_stream_split": [name for name in floats if name not in repeats],
        "compression_level": 1,
    }


@contextmanager
def row_groups(
    path: Path, names: tuple[str, ...], about: Mapping[str, str], tell: Tell
) -> Iterator[Callable[[Rows], None]]:
    """A function that adds rows of some quantities to a file, which is sealed when the block ends well."""
    layout = schema_of((QUANTITIES[name] for name in names), **about)
    with sealed(path, layout, tell, **parquet_options(layout)) as add:
        groups = RowGroups(add, layout)
        yield groups.append
        groups.finish()


class RowGroups:
    """Collects rows and writes them in groups of a fixed size, so that files do not depend on the batches."""

    def __init__(self, add: Callable[[pa.Table], None], layout: pa.Schema) -> None:
        self._add, self._layout = add, layout
        self._pending: list[pa.Table] = []
        self._waiting = self._groups = 0

    def append(self, rows: Rows) -> None:
        """Add rows."""
        for first in range(0, rows.count, ROWS_IN_GROUP):
            self._append(rows.part(slice(first, first + ROWS_IN_GROUP)))

    def _append(self, rows: Rows) -> None:
        """Add no more rows than a group has."""
        self._pending.append(to_table(rows, self._layout))
        self._waiting += rows.count
        if self._waiting >= ROWS_IN_GROUP:
            merged = pa.concat_tables(self._pending)
            whole = merged.num_rows - merged.num_rows % ROWS_IN_GROUP
            self._write(merged.slice(0, whole))
            self._pending = [merged.slice(whole)]
            self._waiting = merged.num_rows - whole

    def finish(self) -> None:
        """Write the rows that fill no group."""
        if self._pending or not self._groups:
            self._write(pa.concat_tables(self._pending or [self._layout.empty_table()]))

    def _write(self, table: pa.Table) -> None:
        self._groups += 1
        self._add(table)
