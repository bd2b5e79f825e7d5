"""Tables on disk: Parquet with units, symbols, scene and version in its metadata; pandas at the door."""

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
    no_table_error,
    read_table,
    table_facts,
    with_pandas_attributes,
    write_table,
)
from camopt.core.storage.version import VERSION
from camopt.scene.design_rows import LAW_NAME_COLUMNS, values_of_index
from camopt.scene.problem.rows import DesignRows
from camopt.scene.scene import Scene

if TYPE_CHECKING:
    import pandas as pd


def schema_of(quantities: Iterable[Quantity], **about: str) -> pa.Schema:
    """The schema of quantities, with the version that made the table, and what else there is to say of it."""
    facts = {q: {"unit": q.unit, "symbol": q.symbol, "description": q.sentence} for q in quantities}
    fields = [pa.field(q.name, ARROW_TYPES[q.kind], nullable=False, metadata=about) for q, about in facts.items()]
    return pa.schema(fields, metadata={"camopt_version": VERSION, **about})


def write_columns(
    columns: Mapping[str, tuple[str, str, FloatArray]], scene: Scene, path: str | os.PathLike[str]
) -> None:
    """Write columns of numbers, each with its unit and a sentence about it, as a table with the scene."""
    facts = {name: {"unit": unit, "description": sentence} for name, (unit, sentence, _) in columns.items()}
    fields = [pa.field(name, pa.float64(), nullable=False, metadata=about) for name, about in facts.items()]
    layout = pa.schema(fields, metadata={"camopt_version": VERSION, "camopt_scene": scene.to_toml()})
    values = {name: each for name, (*_, each) in columns.items()}
    write_table(to_table(DesignRows({**values}, len(next(iter(values.values())))), layout), path)


def scene_in(layout: pa.Schema, path: str | os.PathLike[str]) -> Scene:
    """The scene in the metadata of a table; BadInput if it has none, or one with mistakes."""
    text = (layout.metadata or {}).get(SCENE_KEY)
    if not text:
        raise no_table_error(path, "this has no scene in it")
    try:
        return Scene.embedded(text.decode(), os.fsdecode(path))
    except BadInput as bad:
        first = bad.mistakes[0]
        raise no_table_error(
            path, f"the scene in this has mistakes, such as {first.key}: {first.allowed}"
        ) from None


def to_table(rows: DesignRows, layout: pa.Schema) -> pa.Table:
    """Rows as an arrow table."""
    return pa.table([_arrow_array(rows.columns[c.name], rows.count, c.type) for c in layout], schema=layout)


def _arrow_array(value: Any, rows: int, kind: pa.DataType) -> pa.Array:
    """A column as an arrow array, from its bytes: ``pa.array`` and ``pa.scalar`` would import pandas, at 0.3 s."""
    if kind == pa.string():
        changes = value[1:] != value[:-1] if np.ndim(value) else np.zeros(max(rows - 1, 0), dtype=bool)
        starts = np.flatnonzero(np.concatenate([[rows > 0], changes]))  # values that are not those before them
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
def row_groups(path: Path, quantities: Iterable[Quantity], about: Mapping[str, str]) -> Iterator["RowGroupWriter"]:
    """What writes rows of some quantities to a file."""
    layout = with_pandas_attributes(schema_of(quantities, **about))
    with (
        pa.OSFile(os.fsencode(path), "wb") as file,  # Python's would wait for the interpreter in each write
        pq.ParquetWriter(file, layout, **PARQUET_OPTIONS, **parquet_options(layout)) as parquet,
    ):
        yield RowGroupWriter(lambda table: parquet.write_table(table, row_group_size=ROWS_IN_GROUP), layout)


class RowGroupWriter:
    """Collects rows and writes them in groups of a fixed size, so that files do not depend on the batches."""

    def __init__(self, add: Callable[[pa.Table], None], layout: pa.Schema) -> None:
        self._add, self._layout = add, layout
        self._pending: list[pa.Table] = []
        self._waiting = self._groups = 0

    def append(self, rows: DesignRows) -> None:
        """Add rows."""
        for first in range(0, rows.count, ROWS_IN_GROUP):
            self._append(rows.slice_rows(slice(first, first + ROWS_IN_GROUP)))

    def _append(self, rows: DesignRows) -> None:
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


def load(path: str | os.PathLike[str]) -> "pd.DataFrame":
    """A table that camopt wrote, as a pandas DataFrame.

    ``attrs`` holds ``units``, ``symbols`` and ``descriptions`` (by column), ``scene`` (TOML) and ``version``, and
    that of a Pareto table ``front``: its hypervolume, ideal, nadir and knee, and ``sweep``: how many designs were
    evaluated, and how many were decided in boxes.

    Parameters
    ----------
    path : str or os.PathLike
        A Parquet file that ``sweep``, ``frontier``, ``cam_points`` or another command wrote.

    Returns
    -------
    pandas.DataFrame
        A row for each row of the file.

    Raises
    ------
    BadInput
        If the file is no table of camopt's, or damaged, or not the one that ``manifest.json`` beside it names.
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
    return frame_of(path)


def read_quantities(path: str | os.PathLike[str], manifest: Manifest | None = None) -> pa.Table:
    """A table that camopt wrote, in Arrow, whose columns of quantities have the types of these.

    Errors are those of ``load``. A manifest is that of the folder, where several tables have to be of one run.
    """
    table = read_table(path, manifest)
    for column in table.schema:
        if column.name in QUANTITIES and column.type != ARROW_TYPES[QUANTITIES[column.name].kind]:
            raise no_table_error(path, f"its column {column.name} has the type {column.type}")
    return table


def frame_of(path: str | os.PathLike[str], manifest: Manifest | None = None) -> "pd.DataFrame":
    """A table that camopt wrote, as ``load`` gives it; ``read_quantities`` says what the manifest is for."""
    return _frame_of_table(read_quantities(path, manifest))


def frame_of_rows(
    parts: Iterable[DesignRows], quantities: Iterable[Quantity], about: Mapping[str, str]
) -> "pd.DataFrame":
    """Rows of some quantities as ``load`` gives them, with what there is to say of the table."""
    layout = schema_of(quantities, **about)
    tables = [to_table(rows, layout) for rows in parts]
    return _frame_of_table(pa.concat_tables(tables or [layout.empty_table()]))


def _frame_of_table(table: pa.Table) -> "pd.DataFrame":
    frame: pd.DataFrame = table.replace_schema_metadata(None).to_pandas()
    frame.attrs = table_facts(table.schema)
    return frame


def row_of(table: Any, row: Any, name: str) -> dict[str, Any]:
    """The values of one row, or of the row of a table, by column; quantities in an index of pandas are columns."""
    import narwhals.stable.v2 as nw  # most commands are given no table

    frame = nw.from_native(table, eager_only=True, pass_through=True)
    if not isinstance(frame, nw.DataFrame):
        return _values_of_row(table, row)
    labels = nw.maybe_get_index(frame)
    every = np.arange(len(frame)) if labels is None else np.asarray(labels)
    if row is None:
        places = np.arange(len(frame))
    else:
        labelled = [label == row for label in every] if isinstance(row, tuple) else every == row
        places = np.flatnonzero(labelled)
    if places.size != 1:
        twice = f"; {places.size} have this label: number the rows anew with .reset_index(drop=True)"
        has = f"a row of {name}, which has {len(frame):,}, counted from 0"
        has += twice if row is not None and places.size else ""
        raise BadInput([Mistake("camopt", "row", row, has)])
    place = int(places[0])
    levels = {} if labels is None else values_of_index(labels, place)
    known = {level: value for level, value in levels.items() if level in QUANTITIES or level in LAW_NAME_COLUMNS}
    return known | frame[place : place + 1].rows(named=True)[0]


def _values_of_row(values: Any, row: Any) -> dict[str, Any]:
    """The values of one row that is no table, and so has no label of a row."""
    if row is None and (isinstance(values, Mapping) or hasattr(values, "dropna")):
        return {str(column): value for column, value in dict(values).items()}
    hint = ": give its .to_pandas()" if hasattr(values, "to_pandas") else ""
    why = f"a table that camopt wrote, or one row of it without a label; this is a {type(values).__name__}{hint}"
    raise BadInput([Mistake("camopt", "table", None, why)])
