"""Paths settled before the work, files that appear only when whole, folders that stay only with a result inside."""

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EISDIR
from pathlib import Path
from stat import S_ISREG
from tempfile import TemporaryFile
from typing import BinaryIO

from camopt.mistakes import BadInput, Mistake

LARGEST_TEXT = 1 << 24
NO_TEXT = {
    b"PK\x03\x04": "an Excel workbook or another archive; save the table as CSV",
    b"\xd0\xcf\x11\xe0": "an old Excel workbook; save the table as CSV",
    b"PAR1": "a Parquet table",
    b"\xff\xfe": "text in UTF-16; save it in UTF-8",
    b"\xfe\xff": "text in UTF-16; save it in UTF-8",
}
ADDRESS = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://")


def path_of(path: str | os.PathLike[str]) -> Path:
    """A path as users write it: ``~`` is the home folder. A ValueError completes the sentence "must be …"."""
    if ADDRESS.match(os.fspath(path)):
        raise ValueError("a path on this machine, not an address")
    try:
        return Path(path).expanduser()
    except RuntimeError:
        raise ValueError("a path; its home folder is not known") from None


def checked_suffix(path: str | os.PathLike[str], key: str, known: tuple[str, ...]) -> str:
    """The suffix of a path in lower case; BadInput unless it is one of the known."""
    suffix = Path(path).suffix.lower()
    if suffix not in known:
        listed = " or ".join(filter(None, (", ".join(known[:-1]), known[-1])))
        raise BadInput([Mistake("camopt", key, os.fspath(path), f"a file that ends in {listed}")])
    return suffix


@contextmanager
def regular_file(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """A file to read, if it has an end and can be searched: no pipe, no device.

    Raises
    ------
    BadInput
        If it is a pipe, a device or a folder.
    OSError
        If there is no such file, or it cannot be read.
    """
    if "\0" in os.fsdecode(path) or not S_ISREG(os.stat(path).st_mode):
        raise BadInput([Mistake("camopt", "file", os.fsdecode(path), "a regular file, no folder, pipe or device")])
    with open(path, "rb") as file:
        yield file


def read_bytes(path: str | os.PathLike[str]) -> bytes:
    """What is in a text file of a user. Errors are those of ``regular_file``, and BadInput if it has no end."""
    with regular_file(path) as file:
        data = file.read(LARGEST_TEXT + 1)
    if len(data) > LARGEST_TEXT:
        allowed = f"a file of at most {LARGEST_TEXT >> 20} MiB"
        raise BadInput([Mistake("camopt", "file", os.fsdecode(path), allowed)])
    return data


def text_of(data: bytes) -> str:
    """The text in a file of a user; a ValueError says what the file is if not text in UTF-8, as in "is …"."""
    for start, kind in NO_TEXT.items():
        if data.startswith(start):
            raise ValueError(f"is {kind}")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ValueError(f"is not UTF-8 text: line {line} has the byte 0x{data[error.start]:02x}") from None


def check_writable(path: str | os.PathLike[str]) -> None:
    """Find out before the work whether a file can be written.

    Raises
    ------
    OSError
        With ``path`` in it, if not.
    """
    if Path(path).is_dir():
        raise IsADirectoryError(EISDIR, os.strerror(EISDIR), os.fspath(path))
    _check_folder(Path(path).parent, path)


def _check_folder(folder: Path, named: str | os.PathLike[str]) -> None:
    """Whether a folder takes files; if not, an OSError with the name that the user gave."""
    try:
        TemporaryFile(dir=folder).close()
    except OSError as trouble:
        raise OSError(trouble.errno or 0, os.strerror(trouble.errno or 0), os.fspath(named)) from None


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary path beside ``path``, which takes its name if the block ends well, and goes if not.

    Raises
    ------
    OSError
        With ``path`` in it, if the file cannot be written or a folder has its name.
    """
    path = Path(path)
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        if path.is_dir():
            raise IsADirectoryError(EISDIR, os.strerror(EISDIR))
        yield partial
        os.replace(partial, path)
    except OSError as trouble:
        if trouble.filename is not None and str(trouble.filename) != str(partial):
            raise  # of another file, which the block writes as well
        reason = os.strerror(trouble.errno) if trouble.errno else str(trouble)
        raise OSError(trouble.errno or 0, reason, os.fspath(path)) from None
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)


@contextmanager
def result_folder(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A folder that takes files, made if there is none; what was made goes again if the block leaves it empty.

    Raises
    ------
    OSError
        If it cannot be made, or takes no files.
    """
    path = Path(path)
    made = [folder for folder in (path, *path.parents) if not folder.exists()]
    try:
        path.mkdir(parents=True, exist_ok=True)
        _check_folder(path, path)
        yield path
    finally:
        with suppress(OSError):  # there is something in it
            for folder in made:
                folder.rmdir()


def write_text(path: Path, text: str) -> None:
    """Write a small file."""
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8")
