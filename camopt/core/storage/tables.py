"""Tables of camopt as Parquet files: written whole or not at all, and refused if damaged or foreign."""

import json
import os
from collections.abc import Hashable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, BinaryIO

import pyarrow as pa
import pyarrow.parquet as pq

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.storage.files import atomically_written_file
from camopt.core.storage.manifest import Manifest, open_checked_result_file

ARROW_TYPES = {float: pa.float64(), bool: pa.bool_(), str: pa.string()}
COLUMN_TYPES = (*ARROW_TYPES.values(), pa.int64(), pa.null(), pa.list_(pa.string()))
SCENE_KEY, VERSION_KEY = b"camopt_scene", b"camopt_version"
PANDAS_KEY = b"PANDAS_ATTRS"  # where pandas keeps the attrs of a table, from 2.1 on
ROWS_IN_GROUP = 1 << 17
ARROW_ERRORS = (pa.ArrowException, ValueError, OSError, MemoryError)
"""Errors of pyarrow about an unreadable file."""
PARQUET_OPTIONS: dict[str, Any] = {"compression": "zstd", "write_page_checksum": True}


def write_table(table: pa.Table, path: str | os.PathLike[str]) -> None:
    """Write a table, whole or not at all."""
    table = table.replace_schema_metadata(with_pandas_attributes(table.schema).metadata)
    with atomically_written_file(path) as partial, pa.OSFile(os.fsencode(partial), "wb") as file:
        # else the items of lists are renamed
        pq.write_table(
            table, file, row_group_size=ROWS_IN_GROUP, use_compliant_nested_type=False, **PARQUET_OPTIONS
        )


def read_table(path: str | os.PathLike[str], manifest: Manifest | None = None) -> pa.Table:
    """Read a table that camopt wrote, checked against the manifest beside it, if there is one.

    Raises
    ------
    BadInput
        If the file is no table of camopt, or damaged.
    OSError
        If there is no such file, or it cannot be read.
    """
    with open_checked_result_file(path, manifest) as file:
        return TableFile(path, file).read()


class TableFile:
    """A table that camopt wrote, open for reading, whole or by columns. It raises the errors of ``read_table``."""

    def __init__(self, path: str | os.PathLike[str], file: BinaryIO) -> None:
        self._path = path
        with _arrow_errors_as_bad_input(path):
            self._parquet = pq.ParquetFile(file, page_checksum_verification=True)
            self.layout: pa.Schema = self._parquet.schema_arrow
            self.count: int = self._parquet.metadata.num_rows
            metadata = self.layout.metadata or {}
            if VERSION_KEY not in metadata:
                why = f"another program ({self._parquet.metadata.created_by}) wrote this"
                if b'"scene"' in metadata.get(PANDAS_KEY, b""):
                    how = "read it with pandas.read_parquet, and give the frame in place of the path"
                    why = f"pandas wrote this: {how}"
                raise not_a_table_error(path, why)
            if why := _schema_fault(self.layout):  # checked before the data are read
                raise not_a_table_error(path, why)

    def read(self, columns: list[str] | None = None) -> pa.Table:
        """Read some columns, or all."""
        with _arrow_errors_as_bad_input(self._path):
            # with threads, a process that ends during the reading aborts (apache/arrow#34314)
            table = self._parquet.read(columns, use_threads=False)
        return table.replace_schema_metadata(
            self.layout.metadata
        )  # the file has its metadata twice; these were checked


@contextmanager
def _arrow_errors_as_bad_input(path: str | os.PathLike[str]) -> Iterator[None]:
    """Turn Arrow's errors about a file that is no table into BadInput."""
    try:
        yield
    except BadInput:
        raise
    except ARROW_ERRORS as trouble:
        if isinstance(trouble, OSError) and trouble.errno:
            raise  # an error of the disk
        why = (
            f"this is another file, or damaged: {str(trouble).splitlines()[0]}"
            if str(trouble)
            else "this is another file"
        )
        raise not_a_table_error(path, why) from None


def not_a_table_error(path: str | os.PathLike[str], why: str) -> BadInput:
    """Error about a file that is no table of camopt."""
    return BadInput([Mistake("camopt", "table", os.fsdecode(path), f"a Parquet table that camopt wrote; {why}")])


def _schema_fault(schema: pa.Schema) -> str:
    """What is wrong with the schema of a table; empty if nothing is."""
    for field in schema:
        if field.type not in COLUMN_TYPES:
            return f"its column {field.name!r} has the type {field.type}"
    if len({*schema.names}) < len(schema.names):
        return "two of its columns have the same name"
    try:
        facts = table_metadata(schema)
    except (ValueError, RecursionError):
        return "its metadata are not text, or its front is not JSON"
    front = {"points": int, "hypervolume": float | int}
    if not _is_missing_or_has_types(facts["front"], front) or not _is_missing_or_has_types(
        facts["sweep"], {"designs": int}
    ):
        return "the facts about its front or its sweep have another form than camopt's"
    return ""


def _is_missing_or_has_types(metadata_part: Any, types_by_name: Mapping[str, Any]) -> bool:
    """Whether a part of the metadata is absent, or a mapping whose values have the given types."""
    return metadata_part is None or (
        isinstance(metadata_part, dict)
        and all(isinstance(metadata_part.get(name), kind) for name, kind in types_by_name.items())
    )


def table_metadata(schema: pa.Schema) -> dict[Hashable | None, Any]:
    """Units, symbols, descriptions, scene, front, sweep and version in the metadata of a table."""
    columns = {field.name: _decode_metadata(field.metadata) for field in schema}
    whole = _decode_metadata(schema.metadata)
    return {
        "units": {name: facts.get("unit", "") for name, facts in columns.items()},
        "symbols": {name: facts.get("symbol", "") for name, facts in columns.items()},
        "descriptions": {name: facts.get("description", "") for name, facts in columns.items()},
        "scene": whole.get("camopt_scene", ""),
        "front": json.loads(whole.get("camopt_front", "null")),
        "sweep": json.loads(whole.get("camopt_sweep", "null")),
        "version": whole.get("camopt_version", ""),
    }


def with_pandas_attributes(schema: pa.Schema) -> pa.Schema:
    """The schema of a table with its facts also where pandas looks for ``attrs``."""
    facts = json.dumps(table_metadata(schema), ensure_ascii=False)
    return schema.with_metadata({**(schema.metadata or {}), PANDAS_KEY: facts.encode()})


def _decode_metadata(metadata: dict[bytes, bytes] | None) -> dict[str, str]:
    return {key.decode(): value.decode() for key, value in (metadata or {}).items()}
