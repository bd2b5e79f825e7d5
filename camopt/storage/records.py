"""Records of a journal, each with its length and digest: what was cut short, or is damaged, is known.

A file starts with ``JOURNAL_MAGIC``. A part of a sweep is a journal whose last record is ``END_RECORD``.
"""

import os
from collections.abc import Iterator
from hashlib import sha256
from struct import Struct
from typing import BinaryIO

from camopt.storage.files import BYTES_AT_ONCE

JOURNAL_MAGIC = b"camopt journal 1\n"
HEAD = Struct("<Q32s")  # length and digest of a record
END_RECORD = b"end"


def record(payload: bytes) -> bytes:
    """A record: length, digest, payload."""
    return HEAD.pack(len(payload), sha256(payload).digest()) + payload


def write_record(file: BinaryIO, source: BinaryIO) -> None:
    """Write a record with what a file holds, in bounded memory."""
    head, digest = file.tell(), sha256()
    file.write(HEAD.pack(0, digest.digest()))
    source.seek(0)
    while data := source.read(BYTES_AT_ONCE):
        digest.update(data)
        file.write(data)
    end = file.tell()
    file.seek(head)
    file.write(HEAD.pack(end - head - HEAD.size, digest.digest()))
    file.seek(end)


def records(file: BinaryIO) -> Iterator[tuple[bytes, int]]:
    """The records of the intact part of a journal, each with its end."""
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    if file.read(len(JOURNAL_MAGIC)) != JOURNAL_MAGIC:
        return
    while len(head := file.read(HEAD.size)) == HEAD.size:
        length, digest = HEAD.unpack(head)
        payload = file.read(length) if length <= size - file.tell() else b""
        if len(payload) != length or sha256(payload).digest() != digest:
            return
        yield payload, file.tell()


def whole_until(file: BinaryIO) -> tuple[int, bool]:
    """The end of the intact part of a journal, and whether it is the whole file; in bounded memory."""
    file.seek(0)
    whole, digest = len(JOURNAL_MAGIC) if file.read(len(JOURNAL_MAGIC)) == JOURNAL_MAGIC else 0, b""
    while whole and len(head := file.read(HEAD.size)) == HEAD.size:
        length, digest = HEAD.unpack(head)
        found = sha256()
        while length and (data := file.read(min(length, BYTES_AT_ONCE))):
            found.update(data)
            length -= len(data)
        if length or found.digest() != digest:
            break
        whole = file.tell()
    return whole, digest == sha256(END_RECORD).digest() and whole == file.seek(0, os.SEEK_END)


def damage_of(file: BinaryIO) -> str:
    """What keeps a file from being a whole part of a sweep, in words; empty if nothing does."""
    whole, ended = whole_until(file)
    return "" if ended else cut_after(whole)


def cut_after(whole: int) -> str:
    """The message on a journal that is intact only up to a byte."""
    return f"damaged, or cut short, after {whole:,} bytes"
