"""The seal of a table: two digests in its footer, which protect each byte of the file.

A Parquet file is a row of pages, then a footer that says where they are. ``camopt_pages`` is the SHA-256 of all
that comes before the footer, ``camopt_footer`` that of the footer itself, to the end of the file, with zeros in
its own place. So the seal needs nothing beside the file, and any program that reads Parquet reads a sealed table.
Parquet's own checksums leave out the footer and the headers of pages, where a few bytes make another table.
"""

import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from hashlib import sha256
from math import inf
from pathlib import Path
from typing import Any, BinaryIO

import pyarrow as pa
import pyarrow.parquet as pq

from camopt.storage.files import BYTES_AT_ONCE
from camopt.storage.manifest import Fact

SEAL_KEYS = PAGES, FOOTER = "camopt_pages", "camopt_footer"
OLD_KEY = "camopt_rows"
"""What the seal of earlier tables has besides."""
BLANK = "0" * 64
ROWS_IN_GROUP = 1 << 17
LONGEST_FOOTER = 1 << 28  # bytes: those of a table of a terabyte
FOOTER_BYTES = 8
"""Bytes at the end of a Parquet file: the length of the footer, and PAR1."""


Tell = Callable[[Fact], Any]
"""What takes the manifest's record of a file."""


@contextmanager
def sealed(
    path: Path, layout: pa.Schema, tell: Tell = lambda fact: None, **options: Any
) -> Iterator[Callable[[pa.Table], None]]:
    """A function that adds rows to a Parquet file, which is sealed when the block ends well.

    It is a file of arrow's: in each write to one of Python's a thread would wait for the interpreter. What is
    written is read again at once, for its digest.

    Parameters
    ----------
    path : pathlib.Path
        The file, which is made anew.
    layout : pyarrow.Schema
        Columns and metadata.
    tell : callable, optional
        Called in the end with the manifest's record of the file.
    **options
        Options of ``pyarrow.parquet.ParquetWriter``.
    """
    plain: Any = {"compression": "zstd", "write_page_checksum": True, **options}
    with path.open("w+b") as whole:
        digest = sha256()
        with pa.OSFile(os.fspath(path), "wb") as file, pq.ParquetWriter(file, layout, **plain) as parquet:

            def add(table: pa.Table) -> None:
                parquet.write_table(table, row_group_size=ROWS_IN_GROUP)
                _update(digest, whole)

            yield add
            parquet.add_key_value_metadata(dict.fromkeys(SEAL_KEYS, BLANK))
        tell(close_seal(whole, digest))


def close_seal(file: BinaryIO, digest: Any = None) -> Fact:
    """Put the digests into their places; the record of the file. ``digest`` is of what has been read of it."""
    read, digest = (file.tell(), digest) if digest else (0, sha256())
    start, footer = footer_of(file)
    file.seek(read)
    _update(digest, file, start - read)
    footer = _with_digests(digest.hexdigest(), footer)
    file.seek(start)
    file.write(footer)
    file.flush()
    digest.update(footer)
    return Fact(digest.hexdigest(), start + len(footer))


def is_intact(file: BinaryIO) -> bool:
    """Whether each byte of a sealed table is as it was written.

    Raises
    ------
    ValueError
        If there is no footer, or no seal in it.
    """
    start, footer = footer_of(file)
    digest = sha256()
    file.seek(0)
    _update(digest, file, start)
    return _with_digests(digest.hexdigest(), footer) == footer


def footer_of(file: BinaryIO) -> tuple[int, bytes]:
    """Where the footer of a Parquet file starts, and all from there to the end.

    Raises
    ------
    ValueError
        If it would start before the file, or would be longer than any that camopt writes.
    """
    length_at = file.seek(-FOOTER_BYTES, os.SEEK_END)
    length = int.from_bytes(file.read(4), "little")
    start = length_at - length
    if start < 0 or length > LONGEST_FOOTER:
        raise ValueError("no footer is so long")
    file.seek(start)
    return start, file.read()


def _with_digests(digest: str, footer: bytes) -> bytes:
    """A footer with its digests filled in: that of all before it, and its own."""
    pages, own = (_place(key, footer) for key in SEAL_KEYS)
    found = bytearray(footer)
    found[pages], found[own] = digest.encode(), BLANK.encode()
    found[own] = sha256(found).hexdigest().encode()
    return bytes(found)


def _place(key: str, footer: bytes) -> slice:
    """The place of the digest under a key of the metadata: a text of 64 bytes in Thrift's compact protocol."""
    found = [*re.finditer(key.encode() + rb"\x18\x40([0-9a-f]{64})", footer)]
    if len(found) != 1:
        raise ValueError("no seal")
    return slice(*found[0].span(1))


def _update(digest: Any, file: BinaryIO, size: float = inf) -> None:
    """Add so many bytes of a file, or all that follow, to a digest; they are read in parts."""
    while size > 0 and (part := file.read(int(min(BYTES_AT_ONCE, size)))):
        digest.update(part)
        size -= len(part)


def without_seal(layout: pa.Schema) -> pa.Schema:
    """A schema as it was given to be written; pyarrow reads the seal as a part of its metadata."""
    seal = {key.encode() for key in (*SEAL_KEYS, OLD_KEY)}
    return layout.with_metadata({k: value for k, value in (layout.metadata or {}).items() if k not in seal})
