"""Whether a table is as it was written, by its seal; and the message if it is not."""

import os
from base64 import b64decode
from typing import BinaryIO

import pyarrow as pa
import pyarrow.parquet as pq

from camopt.storage.seal import FOOTER, FOOTER_BYTES, SEAL_KEYS, footer_of, is_intact

PARQUET_MAGIC = b"PAR1"
LEAST_BYTES = len(PARQUET_MAGIC) + FOOTER_BYTES  # bytes of a Parquet file
ARROW_ERRORS = (pa.ArrowException, ValueError, OSError, MemoryError)
"""What pyarrow raises of a file that is no good."""


class TableFault(ValueError):
    """A file is no sealed table, or a damaged one; the message completes "this is …"."""

    def __init__(self, told: str, damaged: bool = True) -> None:
        super().__init__(told)
        self.damaged = damaged
        """False where nothing tells that camopt wrote it."""


def open_table(file: BinaryIO) -> pq.ParquetFile:
    """A sealed table, each byte of it as it was written. The file is read once, in parts.

    Raises
    ------
    Fault
        If it is something else.
    OSError
        If the disk fails.
    """
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    head = file.read(len(PARQUET_MAGIC))
    file.seek(max(size - len(PARQUET_MAGIC), 0))
    tail = file.read()
    if tail != PARQUET_MAGIC and not PARQUET_MAGIC.startswith(head):
        raise TableFault("no Parquet file", damaged=False)
    if tail != PARQUET_MAGIC or size < LEAST_BYTES:
        raise TableFault(f"cut short after {size:,} bytes, or damaged at its end")
    try:
        if is_intact(file):
            return pq.ParquetFile(file)
    except ARROW_ERRORS as trouble:
        raise_if_of_the_disk(trouble)
    raise _by_another_program(file) or TableFault("damaged")


def _by_another_program(file: BinaryIO) -> TableFault | None:
    """The message on a table that another program saved; None for a damaged one of camopt.

    It has no seal, or that of the table it was made of: Arrow takes it for a part of the schema then.
    """
    try:
        footer = footer_of(file)[1]
        about = pq.ParquetFile(file).metadata
        metadata = about.metadata or {}
        arrow = b64decode(metadata.get(b"ARROW:schema", b""))
    except ARROW_ERRORS as trouble:
        raise_if_of_the_disk(trouble)
        return None
    if any(key.encode() in footer for key in SEAL_KEYS) and FOOTER.encode() not in arrow:
        return None
    other = "pandas" if b"pandas" in metadata else about.created_by
    go_on = "go on from the table that the command wrote, and choose rows of it afterwards"
    return TableFault(f"not as camopt saved it: another program ({other}) did; {go_on}", damaged=False)


def raise_if_of_the_disk(trouble: BaseException) -> None:
    """Raise an error of the disk again; return for errors in the content of a file."""
    if isinstance(trouble, OSError) and trouble.errno:
        raise trouble
