"""Tables on disk, in Parquet files with units, symbols, scene and version in their metadata, and in pandas."""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.quantities import QUANTITIES, Quantity
from camopt.core.storage.files import check_path
from camopt.core.storage.manifest import Manifest
from camopt.core.storage.tables import (
    ARROW_TYPES,
    PARQUET_OPTIONS,
    ROWS_IN_GROUP,
    SCENE_KEY,
    not_a_table_error,
    read_table,
    table_metadata,
    with_pandas_attributes,
    write_table,
)
from camopt.core.storage.version import VERSION
from camopt.scene.design_rows import LAW_NAME_COLUMNS, index_level_values_at_place
from camopt.scene.problem.rows import DesignRows
from camopt.scene.scene import Scene

if TYPE_CHECKING:
    import pandas as pd


def schema_of(quantities: Iterable[Quantity], **about: str) -> pa.Schema:
    """Schema of a table of quantities; its metadata are camopt's version and ``about``."""
    facts = {q: {"unit": q.unit, "symbol": q.symbol, "description": q.sentence} for q in quantities}
    fields = [pa.field(q.name, ARROW_TYPES[q.kind], nullable=False, metadata=about) for q, about in facts.items()]
    return pa.schema(fields, metadata={"camopt_version": VERSION, **about})


def write_columns(
    columns: Mapping[str, tuple[str, str, FloatArray]], scene: Scene, path: str | os.PathLike[str]
) -> None:
    """Write columns of numbers, each with its unit and description, as a table with the scene."""
    facts = {name: {"unit": unit, "description": sentence} for name, (unit, sentence, _) in columns.items()}
    fields = [pa.field(name, pa.float64(), nullable=False, metadata=about) for name, about in facts.items()]
    layout = pa.schema(fields, metadata={"camopt_version": VERSION, "camopt_scene": scene.to_toml()})
    values = {name: numbers for name, (*_, numbers) in columns.items()}
    write_table(to_arrow_table(DesignRows({**values}, len(next(iter(values.values())))), layout), path)


def read_scene_metadata(layout: pa.Schema, path: str | os.PathLike[str]) -> Scene:
    """Read the scene in the metadata of a table; raise BadInput if it is missing or has mistakes."""
    text = (layout.metadata or {}).get(SCENE_KEY)
    if not text:
        raise not_a_table_error(path, "this one has no scene in it")
    try:
        return Scene.embedded(text.decode(), os.fsdecode(path))
    except BadInput as bad:
        first = bad.mistakes[0]
        raise not_a_table_error(
            path, f"the scene in this one has mistakes, such as {first.key}: {first.allowed}"
        ) from None


def to_arrow_table(rows: DesignRows, layout: pa.Schema) -> pa.Table:
    """Convert rows to an Arrow table."""
    return pa.table([_arrow_array(rows.columns[c.name], rows.count, c.type) for c in layout], schema=layout)


def _arrow_array(value: Any, rows: int, kind: pa.DataType) -> pa.Array:
    """Convert a column to an Arrow array by its bytes: ``pa.array`` would import pandas, which takes 0.3 s."""
    if kind == pa.string():
        changes = value[1:] != value[:-1] if np.ndim(value) else np.zeros(max(rows - 1, 0), dtype=bool)
        starts = np.flatnonzero(
            np.concatenate([[rows > 0], changes])
        )  # rows whose value differs from the row before
        value = np.broadcast_to(value, (rows,))
        texts, repeats = [text.encode() for text in value[starts].tolist()], np.diff(starts, append=rows)
        ends = np.cumsum(np.repeat(np.array([0, *map(len, texts)]), [1, *repeats]), dtype=np.int32)
        data = b"".join(text * count for text, count in zip(texts, repeats.tolist(), strict=True))
        return pa.Array.from_buffers(kind, rows, [None, pa.py_buffer(ends), pa.py_buffer(data)])
    value = np.broadcast_to(value, (rows,))
    if kind == pa.bool_():
        return pa.Array.from_buffers(kind, rows, [None, pa.py_buffer(np.packbits(value, bitorder="little"))])
    return pa.Array.from_buffers(kind, rows, [None, pa.py_buffer(np.ascontiguousarray(value, dtype=float))])


def parquet_options(layout: pa.Schema) -> dict[str, Any]:
    """Options of Parquet for small files that are quick to write.

    Columns with repeated values have a dictionary. Others are split by bytes (BYTE_STREAM_SPLIT), because the
    leading bytes of doubles change little from row to row and compress well.
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
def open_row_group_writer(
    path: Path, quantities: Iterable[Quantity], about: Mapping[str, str]
) -> Iterator["RowGroupWriter"]:
    """Open a Parquet file of some quantities, and yield its writer."""
    layout = with_pandas_attributes(schema_of(quantities, **about))
    with (
        pa.OSFile(os.fsencode(path), "wb") as file,  # Python's own file would need the interpreter for each write
        pq.ParquetWriter(file, layout, **PARQUET_OPTIONS, **parquet_options(layout)) as parquet,
    ):
        yield RowGroupWriter(lambda table: parquet.write_table(table, row_group_size=ROWS_IN_GROUP), layout)


class RowGroupWriter:
    """Writes rows in groups of a fixed size, so that the file does not depend on the batches."""

    def __init__(self, add: Callable[[pa.Table], None], layout: pa.Schema) -> None:
        self._add, self._layout = add, layout
        self._pending: list[pa.Table] = []
        self._pending_rows = self._groups = 0

    def append(self, rows: DesignRows) -> None:
        """Add rows."""
        for first in range(0, rows.count, ROWS_IN_GROUP):
            part = rows.slice_rows(slice(first, first + ROWS_IN_GROUP))
            self._pending.append(to_arrow_table(part, self._layout))
            self._pending_rows += part.count
            if self._pending_rows >= ROWS_IN_GROUP:
                merged = pa.concat_tables(self._pending)
                whole = merged.num_rows - merged.num_rows % ROWS_IN_GROUP
                self._write_group(merged.slice(0, whole))
                self._pending = [merged.slice(whole)]
                self._pending_rows = merged.num_rows - whole

    def write_last_group(self) -> None:
        """Write the remaining rows, which do not fill a group."""
        if self._pending or not self._groups:
            self._write_group(pa.concat_tables(self._pending or [self._layout.empty_table()]))

    def _write_group(self, table: pa.Table) -> None:
        self._groups += 1
        self._add(table)


def load(path: str | os.PathLike[str]) -> "pd.DataFrame":
    """Read a table that camopt wrote as a pandas DataFrame.

    ``attrs`` has ``units``, ``symbols`` and ``descriptions`` by column, ``scene`` (TOML) and ``version``. A Pareto
    table also has ``front`` (hypervolume, ideal, nadir and knee) and ``sweep`` (the numbers of designs evaluated,
    and of designs decided in boxes).

    Parameters
    ----------
    path : str or os.PathLike
        A Parquet file that ``sweep``, ``frontier``, ``cam_points`` or another command wrote.

    Returns
    -------
    pandas.DataFrame
        The rows of the file.

    Raises
    ------
    BadInput
        If the file is no table of camopt, is damaged, or differs from the one that ``manifest.json`` names.
    OSError
        If there is no such file, or it cannot be read.

    Examples
    --------
    >>> search = {"base_radius": [55, 60, 65], "offset": [0, 10, 20], "law": ["cycloidal"]}
    >>> scene = camopt.find_scene("roller-1000rpm").replace(search=search)
    >>> swept = camopt.sweep(scene, out="results", keep="all")
    >>> designs = camopt.load("results/designs.parquet")
    >>> len(designs), designs.attrs["units"]["base_radius_mm"]
    (9, 'mm')
    """
    check_path(path, "path")
    return read_data_frame(path)


def read_arrow_table_checking_types(path: str | os.PathLike[str], manifest: Manifest | None = None) -> pa.Table:
    """Read a table that camopt wrote as an Arrow table, and check the types of its columns.

    It raises the errors of ``load``. ``manifest`` is that of the folder, if several tables must be from one run.
    """
    table = read_table(path, manifest)
    for column in table.schema:
        if column.name in QUANTITIES and column.type != ARROW_TYPES[QUANTITIES[column.name].kind]:
            raise not_a_table_error(path, f"its column {column.name} has the type {column.type}")
    return table


def read_data_frame(path: str | os.PathLike[str], manifest: Manifest | None = None) -> "pd.DataFrame":
    """Read a table that camopt wrote as a DataFrame; for ``manifest`` see ``read_arrow_table_checking_types``."""
    return _frame_of_table(read_arrow_table_checking_types(path, manifest))


def data_frame_from_rows(
    parts: Iterable[DesignRows], quantities: Iterable[Quantity], about: Mapping[str, str]
) -> "pd.DataFrame":
    """Rows of some quantities as a DataFrame like that of ``load``, with ``about`` in its ``attrs``."""
    layout = schema_of(quantities, **about)
    tables = [to_arrow_table(rows, layout) for rows in parts]
    return _frame_of_table(pa.concat_tables(tables or [layout.empty_table()]))


def _frame_of_table(table: pa.Table) -> "pd.DataFrame":
    frame: pd.DataFrame = table.replace_schema_metadata(None).to_pandas()
    frame.attrs = table_metadata(table.schema)
    return frame


def values_of_table_row(table: Any, row: Any, table_name: str) -> dict[str, Any]:
    """Values of one row of a table, by column; a pandas index counts as a column. A single row needs no label."""
    import narwhals.stable.v2 as nw  # imported only here: most commands take no table

    frame = nw.from_native(table, eager_only=True, pass_through=True)
    if not isinstance(frame, nw.DataFrame):
        if row is None and (isinstance(table, Mapping) or hasattr(table, "dropna")):
            return {str(column): value for column, value in dict(table).items()}
        hint = ": give its .to_pandas()" if hasattr(table, "to_pandas") else ""
        why = (
            f"a table that camopt wrote, or one of its rows without a label; this is a {type(table).__name__}{hint}"
        )
        raise BadInput([Mistake("camopt", "table", None, why)])
    labels = nw.maybe_get_index(frame)
    row_labels = np.arange(len(frame)) if labels is None else np.asarray(labels)
    if row is None:
        places = np.arange(len(frame))
    else:
        matches = [label == row for label in row_labels] if isinstance(row, tuple) else row_labels == row
        places = np.flatnonzero(matches)
    if places.size != 1:
        allowed = f"a row of {table_name}, which has {len(frame):,}, counted from 0"
        if row is not None and places.size:
            allowed += f"; {places.size} rows have this label: number them again with .reset_index(drop=True)"
        raise BadInput([Mistake("camopt", "row", row, allowed)])
    place = int(places[0])
    levels = {} if labels is None else index_level_values_at_place(labels, place)
    known = {level: value for level, value in levels.items() if level in QUANTITIES or level in LAW_NAME_COLUMNS}
    return known | frame[place : place + 1].rows(named=True)[0]
