"""Tables with a digest of their columns and metadata, by which those that camopt wrote are known again."""

import json
import os
from collections.abc import Hashable, Iterator
from contextlib import contextmanager
from hashlib import sha256
from typing import Any, BinaryIO

import pyarrow as pa
import pyarrow.parquet as pq

from camopt.files import regular_file, whole_file
from camopt.manifest import settled_path
from camopt.mistakes import BadInput, Mistake
from camopt.scene.scene import Scene

TYPES = {float: pa.float64(), bool: pa.bool_(), str: pa.string()}
COLUMN_TYPES = (*TYPES.values(), pa.int64(), pa.null(), pa.list_(pa.string()))
DIGEST, SCENE = b"camopt_digest", b"camopt_scene"


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
    with regular_file(settled_path(path)) as file:
        return TableFile(path, file).read()


class TableFile:
    """A table that camopt wrote, open to be read whole or by columns; errors are those of ``read_table``."""

    def __init__(self, path: str | os.PathLike[str], file: BinaryIO) -> None:
        self._path = path
        with _refused(path):
            self._parquet = pq.ParquetFile(file, page_checksum_verification=True)
            self.layout: pa.Schema = self._parquet.schema_arrow
            self.count: int = self._parquet.metadata.num_rows
        self._check(self.layout)  # before the data, of which odd types may be

    def read(self, columns: list[str] | None = None) -> pa.Table:
        """Some columns, or all."""
        with _refused(self._path):
            table = self._parquet.read(columns)
        if columns is None:
            self._check(table.schema)
        return table

    def _check(self, layout: pa.Schema) -> None:
        with _refused(self._path):
            why = _oddity(layout)
        if why:
            raise no_table(self._path, why)


@contextmanager
def _refused(path: str | os.PathLike[str]) -> Iterator[None]:
    """What Arrow says of a file that is no table, or damaged, as BadInput."""
    try:
        yield
    except (pa.ArrowException, ValueError, OSError, MemoryError) as trouble:
        if isinstance(trouble, OSError) and trouble.errno:
            raise
        why = f"this is none, or damaged: {str(trouble).splitlines()[0]}" if str(trouble) else "this is none"
        raise no_table(path, why) from None


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
        about(layout)
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


def about(layout: pa.Schema) -> dict[Hashable | None, Any]:
    """What the metadata say of a table."""
    columns = {field.name: _decoded(field.metadata) for field in layout}
    whole = _decoded(layout.metadata)
    return {
        "units": {name: facts.get("unit", "") for name, facts in columns.items()},
        "symbols": {name: facts.get("symbol", "") for name, facts in columns.items()},
        "descriptions": {name: facts.get("description", "") for name, facts in columns.items()},
        "scene": whole.get("camopt_scene", ""),
        "front": json.loads(whole.get("camopt_front", "null")),
        "sweep": json.loads(whole.get("camopt_sweep", "null")),
        "version": whole.get("camopt_version", ""),
    }


def _decoded(metadata: dict[bytes, bytes] | None) -> dict[str, str]:
    return {key.decode(): value.decode() for key, value in (metadata or {}).items()}
