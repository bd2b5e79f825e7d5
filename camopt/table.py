"""Tables on disk: Parquet with units, symbols, scene, version and a digest in its metadata; pandas at the door."""

import json
import os
from collections.abc import Callable, Hashable, Iterator
from contextlib import ExitStack, contextmanager
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from camopt.files import regular_file, whole_file
from camopt.mistakes import BadInput, Mistake
from camopt.quantities import QUANTITIES
from camopt.rows import Rows
from camopt.scene import Scene
from camopt.version import VERSION

if TYPE_CHECKING:
    import pandas as pd

TYPES = {float: pa.float64(), bool: pa.bool_(), str: pa.string()}
COLUMN_TYPES = (*TYPES.values(), pa.int64(), pa.null(), pa.list_(pa.string()))
ROWS_IN_GROUP = 1 << 17
DIGEST, SCENE = b"camopt_digest", b"camopt_scene"


def schema(names: tuple[str, ...], scene: str) -> pa.Schema:
    """The schema of some quantities, with the scene (TOML text) and the version that made the table."""
    fields = []
    for name in names:
        quantity = QUANTITIES[name]
        about = {"unit": quantity.unit, "symbol": quantity.symbol, "description": quantity.sentence}
        fields.append(pa.field(name, TYPES[quantity.kind], nullable=False, metadata=about))
    return pa.schema(fields, metadata={"camopt_version": VERSION, "camopt_scene": scene})


def to_table(rows: Rows, layout: pa.Schema) -> pa.Table:
    """Rows as an arrow table."""
    return pa.table([_array(rows.columns[c.name], rows.count, c.type) for c in layout], schema=layout)


def _array(value: Any, rows: int, kind: pa.DataType) -> pa.Array:
    """A column as an arrow array, from its bytes: ``pa.array`` and ``pa.scalar`` would import pandas, at 0.3 s."""
    if kind == pa.string():
        texts = [str(value).encode()] * rows if not np.ndim(value) else [text.encode() for text in value.tolist()]
        ends = np.cumsum([0, *map(len, texts)], dtype=np.int32)
        return pa.Array.from_buffers(kind, rows, [None, pa.py_buffer(ends), pa.py_buffer(b"".join(texts))])
    value = np.broadcast_to(value, (rows,))
    if kind == pa.bool_():
        bits = np.packbits(value, bitorder="little")
        return pa.Array.from_buffers(kind, rows, [None, pa.py_buffer(bits)])
    values = np.ascontiguousarray(value, dtype=float)
    return pa.Array.from_buffers(kind, rows, [None, pa.py_buffer(values)])


@contextmanager
def table_file(path: Path, layout: pa.Schema) -> Iterator["TableWriter"]:
    """A Parquet file that grows by batches and takes its final name only when whole."""
    repeats = [q.name for q in QUANTITIES.values() if q.effect in ("sizes", "motion") or q.kind is not float]
    few_values = [name for name in repeats if name in layout.names]
    options = {"compression": "zstd", "compression_level": 1, "write_page_checksum": True}
    with whole_file(path) as partial, ExitStack() as stack:
        file = stack.enter_context(partial.open("wb"))  # a folder that takes no files is found out at once

        def opened(layout: pa.Schema) -> pq.ParquetWriter:
            return stack.enter_context(pq.ParquetWriter(file, sealed(layout), use_dictionary=few_values, **options))

        writer = TableWriter(opened, layout)
        yield writer
        writer.finish()


class TableWriter:
    """Collects rows and writes them in groups of a fixed size, so that files do not depend on the batches."""

    def __init__(self, opened: Callable[[pa.Schema], pq.ParquetWriter], layout: pa.Schema) -> None:
        self._opened, self._layout = opened, layout
        self._parquet: pq.ParquetWriter | None = None
        self._pending: list[pa.Table] = []
        self._waiting = 0

    def append(self, rows: Rows) -> None:
        """Add rows."""
        if not rows.count:
            return
        self._pending.append(to_table(rows, self._layout))
        self._waiting += rows.count
        if self._waiting >= ROWS_IN_GROUP:
            merged = pa.concat_tables(self._pending)
            whole = merged.num_rows - merged.num_rows % ROWS_IN_GROUP
            self._write(merged.slice(0, whole))
            self._pending = [merged.slice(whole)]
            self._waiting = merged.num_rows - whole

    def describe(self, key: str, text: str) -> None:
        """Add something to the metadata, before the first rows."""
        self._layout = self._layout.with_metadata({**self._layout.metadata, key: text})

    def finish(self) -> None:
        """Write the rows that fill no group."""
        if self._pending or self._parquet is None:
            self._write(pa.concat_tables(self._pending or [self._layout.empty_table()]))

    def _write(self, table: pa.Table) -> None:
        if self._parquet is None:
            self._parquet = self._opened(self._layout)
        self._parquet.write_table(table, row_group_size=ROWS_IN_GROUP)


def write_text(path: Path, text: str) -> None:
    """Write a small file."""
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8")


def sealed(layout: pa.Schema) -> pa.Schema:
    """A schema with the digest of its columns and metadata in its metadata."""
    return layout.with_metadata({**(layout.metadata or {}), DIGEST: _digest(layout)})


def _digest(layout: pa.Schema) -> bytes:
    """Fingerprint of the columns (name, type, unit …) and of all metadata but the digest itself."""

    def own(metadata: dict[bytes, bytes] | None) -> list[tuple[bytes, bytes]]:
        pairs = (metadata or {}).items()
        return sorted((key, value) for key, value in pairs if key != DIGEST and not key.startswith(b"PARQUET:"))

    columns = [(field.name, str(field.type), field.nullable, own(field.metadata)) for field in layout]
    return sha256(repr((columns, own(layout.metadata))).encode()).hexdigest().encode()


def write_table(table: pa.Table, path: str | os.PathLike[str]) -> None:
    """Write a table with its digest, whole or not at all."""
    table = table.replace_schema_metadata(sealed(table.schema).metadata)
    with whole_file(path) as partial, partial.open("wb") as file:
        options = {"compression": "zstd", "write_page_checksum": True}
        pq.write_table(
            table, file, use_compliant_nested_type=False, **options
        )  # the items of lists keep their name


def read_table(path: str | os.PathLike[str]) -> pa.Table:
    """A table that camopt wrote: whole, with the digest of its schema, and checksums of its pages.

    Raises
    ------
    BadInput
        If the file is something else, or damaged.
    OSError
        If there is no such file, or it cannot be read.
    """
    with regular_file(path) as file:
        try:
            parquet = pq.ParquetFile(file, page_checksum_verification=True)
            why = _oddity(parquet.schema_arrow)  # before the data, of which odd types may be
            if not why:
                table = parquet.read()
                why = _oddity(table.schema)
            if not why:
                return table
        except (pa.ArrowException, ValueError, OSError, MemoryError) as trouble:
            if isinstance(trouble, OSError) and trouble.errno:
                raise
            why = f"this is none, or damaged: {str(trouble).splitlines()[0]}" if str(trouble) else "this is none"
    raise no_table(path, why)


def no_table(path: str | os.PathLike[str], why: str) -> BadInput:
    """What to say of a file that is no table of camopt's."""
    allowed = f"a Parquet table that camopt wrote; {why}"
    return BadInput([Mistake("camopt", "table", os.fsdecode(path), allowed)])


def _oddity(layout: pa.Schema) -> str:
    """What is odd about the schema of a table; empty if nothing is."""
    metadata = layout.metadata or {}
    if DIGEST not in metadata:
        return "this has no digest of its metadata"
    if metadata[DIGEST] != _digest(layout):
        return "the columns or metadata of this are not those that were written"
    for field in layout:
        if field.type not in COLUMN_TYPES:
            return f"its column {field.name!r} has the type {field.type}"
    try:
        _about(layout)
    except (ValueError, RecursionError):
        return "its metadata are not text, or its front is not JSON"
    return ""


def scene_in(table: pa.Table, path: str | os.PathLike[str]) -> Scene:
    """The scene that a table was made of; BadInput if it has none, or one with mistakes."""
    text = (table.schema.metadata or {}).get(SCENE)
    if not text:
        raise no_table(path, "this has no scene in it")
    try:
        return Scene.embedded(text.decode(), os.fsdecode(path))
    except BadInput as bad:
        first = bad.mistakes[0]
        raise no_table(path, f"the scene in this has mistakes, such as {first.key}: {first.allowed}") from None


def load(path: str | os.PathLike[str]) -> "pd.DataFrame":
    """A table that camopt wrote, as a pandas DataFrame.

    ``attrs`` holds ``units``, ``symbols`` and ``descriptions`` (by column), ``scene`` (TOML) and ``version``, and
    that of a Pareto table ``front``: its hypervolume, ideal, nadir and knee.

    Raises
    ------
    BadInput
        If the file is no table of camopt's, or damaged: a digest of schema and metadata and checksums of pages are
        verified.
    OSError
        If there is no such file, or it cannot be read.
    """
    table = read_table(path)
    frame: pd.DataFrame = table.replace_schema_metadata(None).to_pandas()
    frame.attrs = _about(table.schema)
    return frame


def _about(layout: pa.Schema) -> dict[Hashable | None, Any]:
    """What the metadata say of a table."""
    about = {field.name: _decoded(field.metadata) for field in layout}
    whole = _decoded(layout.metadata)
    return {
        "units": {name: facts.get("unit", "") for name, facts in about.items()},
        "symbols": {name: facts.get("symbol", "") for name, facts in about.items()},
        "descriptions": {name: facts.get("description", "") for name, facts in about.items()},
        "scene": whole.get("camopt_scene", ""),
        "front": json.loads(whole.get("camopt_front", "null")),
        "version": whole.get("camopt_version", ""),
    }


def _decoded(metadata: dict[bytes, bytes] | None) -> dict[str, str]:
    return {key.decode(): value.decode() for key, value in (metadata or {}).items()}


def to_json(document: Any) -> str:
    """Strict JSON text (no NaN or Infinity), in ASCII: it passes any pipe."""
    return json.dumps(document, indent=2, allow_nan=False)
