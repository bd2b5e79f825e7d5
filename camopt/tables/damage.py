"""Whether a table is as it was written, by its seal; and if not, where it is damaged."""

import os
from base64 import b64decode
from collections.abc import Iterator
from hashlib import sha256
from typing import BinaryIO, NamedTuple

import pyarrow as pa
import pyarrow.parquet as pq

from camopt.tables.row_digest import RowDigest
from camopt.tables.seal import END, FOOTER, KEYS, Seal, footer_of, without_seal

MAGIC = b"PAR1"
LEAST = len(MAGIC) + END  # bytes of a Parquet file
AT_ONCE = 1 << 22  # bytes
MOST_NAMED = 3  # damaged places


class Fault(NamedTuple):
    """What keeps a file from being a sealed table that is whole."""

    told: str
    """What it is instead, and where."""
    damaged: bool = True
    """False where nothing tells that camopt wrote it."""


def fault(file: BinaryIO) -> Fault | None:
    """What is wrong with a file that should be a sealed table; None if each byte is as it was written.

    The file is read once, in parts; a damaged one again, column by column, for the checksums of its pages.
    """
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    head = file.read(len(MAGIC))
    file.seek(max(size - len(MAGIC), 0))
    tail = file.read()
    if size < LEAST and MAGIC.startswith(head):
        return Fault(f"cut short after {size:,} bytes")
    if size < LEAST or MAGIC not in (head, tail):
        return Fault("no Parquet file", damaged=False)
    if head != MAGIC:
        return Fault("damaged in its first 4 bytes")
    if tail != MAGIC:
        return Fault(f"cut short after {size:,} bytes, or damaged there")
    try:
        start, footer = footer_of(file)
    except ValueError:
        return Fault(f"damaged in its last {END} bytes")
    try:
        seal = Seal.of(footer)
        in_order = seal.digest_of(footer) == seal.footer
    except KeyError:
        in_order = False
    if not in_order:
        other = _by_another_program(file, footer)
        return other or Fault(f"damaged in its footer, bytes {start:,} to {size - 1:,}")
    return None if _digest(file, start) == seal.pages else Fault(f"damaged in {_listed(damaged_pages(file))}")


def _by_another_program(file: BinaryIO, footer: bytes) -> Fault | None:
    """What to say of a table that another program saved; None if it is one of camopt's, damaged.

    It has no seal, or that of the table it was made of: Arrow takes it for a part of the schema then.
    """
    try:
        about = pq.ParquetFile(file).metadata
        metadata = about.metadata or {}
        arrow = b64decode(metadata.get(b"ARROW:schema", b""))
    except TROUBLE as trouble:
        raise_if_of_the_disk(trouble)
        return None
    if any(key.encode() in footer for key in KEYS) and FOOTER.encode() not in arrow:
        return None
    other = "pandas" if b"pandas" in metadata else about.created_by
    go_on = "go on from the table that the command wrote, and choose rows of it afterwards"
    return Fault(
        f"not as camopt saved it: another program ({other}) did, or an older camopt; {go_on}", damaged=False
    )


def _digest(file: BinaryIO, size: int) -> str:
    """SHA-256 of the first bytes of a file."""
    digest = sha256()
    file.seek(0)
    while size > 0 and (part := file.read(min(AT_ONCE, size))):
        digest.update(part)
        size -= len(part)
    return digest.hexdigest()


TROUBLE = (pa.ArrowException, ValueError, OSError, MemoryError)
"""What pyarrow raises of a file that is no good."""


def raise_if_of_the_disk(trouble: BaseException) -> None:
    """Go on unless it is the disk that failed, and not what is in the file."""
    if isinstance(trouble, OSError) and trouble.errno:
        raise trouble


def damaged_pages(file: BinaryIO) -> Iterator[str]:
    """The columns and rows whose pages are damaged, as far as their checksums and their decoding tell."""
    parquet = pq.ParquetFile(file, page_checksum_verification=True)
    first = 0
    for group in range(parquet.num_row_groups):
        last = first + parquet.metadata.row_group(group).num_rows - 1
        for column in parquet.schema_arrow.names:
            try:
                parquet.read_row_group(group, columns=[column], use_threads=False)
            except TROUBLE as trouble:
                raise_if_of_the_disk(trouble)
                yield f"column {column}, rows {first:,} to {last:,}"
        first = last + 1


def _listed(places: Iterator[str]) -> str:
    """Places in words. Checksums of pages leave out their headers."""
    named = [*places] or ["the header of a page, though all columns can be read"]
    more = f", and {len(named) - MOST_NAMED:,} more places" if len(named) > MOST_NAMED else ""
    return "; ".join(named[:MOST_NAMED]) + more


def rows_of(file: BinaryIO) -> tuple[int, str] | None:
    """Of a table without a fault the number of rows and their digest; None if it is not that of the rows in it.

    They are read a group at a time.
    """
    try:
        parquet = pq.ParquetFile(file)
        digest = RowDigest(without_seal(parquet.schema_arrow))
        for group in range(parquet.num_row_groups):
            digest.update(parquet.read_row_group(group, use_threads=False))  # as in ``sealed``
    except (*TROUBLE, TypeError) as trouble:  # sealed by another hand
        raise_if_of_the_disk(trouble)
        return None
    rows = Seal.of(footer_of(file)[1]).rows
    return (parquet.metadata.num_rows, rows) if digest.hexdigest() == rows else None
