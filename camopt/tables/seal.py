"""The seal of a table: digests in its footer, by which each byte of the file is known to be as it was written.

A Parquet file is a row of pages, then a footer that says where they are. ``camopt_pages`` is the SHA-256 of all
that comes before the footer, ``camopt_footer`` that of the footer itself, to the end of the file, with zeros in
its own place; ``camopt_rows`` is the digest of the rows. So the seal needs nothing beside the file, and any program
that reads Parquet reads a sealed table.
"""

import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import sha256
from typing import Any, BinaryIO

import pyarrow as pa
import pyarrow.parquet as pq

from camopt.tables.row_digest import RowDigest

KEYS = ROWS, PAGES, FOOTER = "camopt_rows", "camopt_pages", "camopt_footer"
BLANK = "0" * 64
ROWS_IN_GROUP = 1 << 17
LONGEST_FOOTER = 1 << 28  # bytes: those of a table of a terabyte
END = 8
"""Bytes at the end of a Parquet file: the length of the footer, and PAR1."""


@contextmanager
def sealed(file: BinaryIO, layout: pa.Schema, **options: Any) -> Iterator[Callable[[pa.Table], None]]:
    """A function that adds rows to a Parquet file, which is sealed when the block ends well.

    Parameters
    ----------
    file : BinaryIO
        An empty file to write and read.
    layout : pyarrow.Schema
        Columns and metadata.
    **options
        Options of ``pyarrow.parquet.ParquetWriter``.
    """
    hashed, digest = _Hashed(file), RowDigest(layout)
    with pq.ParquetWriter(hashed, layout, compression="zstd", write_page_checksum=True, **options) as parquet:

        def add(rows: pa.Table) -> None:
            digest.update(rows)
            parquet.write_table(rows, row_group_size=ROWS_IN_GROUP)

        yield add
        digests = {ROWS: digest.hexdigest(), PAGES: hashed.hexdigest(), FOOTER: BLANK}
        parquet.add_key_value_metadata(digests)
    close_seal(file)


class _Hashed:
    """A file to write, with the digest of what was written so far."""

    def __init__(self, file: BinaryIO) -> None:
        self._file, self._digest = file, sha256()
        self.tell, self.flush = file.tell, file.flush

    def write(self, data: bytes) -> None:
        self._digest.update(data)
        self._file.write(data)

    @property
    def closed(self) -> bool:
        return self._file.closed

    def hexdigest(self) -> str:
        return self._digest.hexdigest()


def close_seal(file: BinaryIO) -> None:
    """Put the digest of the footer into its place."""
    start, footer = footer_of(file)
    seal = Seal.of(footer)
    file.seek(start + seal.place)
    file.write(seal.digest_of(footer).encode())
    file.flush()


def footer_of(file: BinaryIO) -> tuple[int, bytes]:
    """Where the footer of a Parquet file starts, and all from there to the end.

    Raises
    ------
    ValueError
        If it would start before the file, or would be longer than any that camopt writes.
    """
    length_at = file.seek(-END, os.SEEK_END)
    length = int.from_bytes(file.read(4), "little")
    start = length_at - length
    if start < 0 or length > LONGEST_FOOTER:
        raise ValueError("no footer is so long")
    file.seek(start)
    return start, file.read()


@dataclass(frozen=True)
class Seal:
    """The digests that a footer has."""

    rows: str
    pages: str
    footer: str
    place: int
    """Where in the footer the digest of it starts."""

    @classmethod
    def of(cls, footer: bytes) -> "Seal":
        """The seal in a footer; a KeyError unless each digest is there once."""
        rows, pages, own = (_only(key, footer) for key in KEYS)
        return cls(rows[1].decode(), pages[1].decode(), own[1].decode(), own.start(1))

    def digest_of(self, footer: bytes) -> str:
        """The digest that the footer has, with zeros in the place of it."""
        end = self.place + len(BLANK)
        return sha256(b"".join((footer[: self.place], BLANK.encode(), footer[end:]))).hexdigest()


def _only(key: str, footer: bytes) -> re.Match[bytes]:
    """The one digest under a key of the metadata: a text of 64 bytes in Thrift's compact protocol."""
    found = [*re.finditer(key.encode() + rb"\x18\x40([0-9a-f]{64})", footer)]
    if len(found) != 1:
        raise KeyError(key)
    return found[0]


def without_seal(layout: pa.Schema) -> pa.Schema:
    """A schema as it was given to be written; pyarrow reads the seal as a part of its metadata."""
    kept = {
        key: value for key, value in (layout.metadata or {}).items() if key.decode(errors="replace") not in KEYS
    }
    return layout.with_metadata(kept)
