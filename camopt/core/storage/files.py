"""Paths, which are checked before the work, and files, which get their names only when they are complete."""

import os
import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from errno import EBADF, EINVAL, EISDIR, ENOSYS, ENOTSUP, EROFS
from glob import escape
from io import BufferedReader
from pathlib import Path
from stat import S_IMODE, S_ISREG
from tempfile import TemporaryFile
from time import time
from typing import Any
from warnings import warn

from camopt.core.mistakes import BadInput, Mistake

LARGEST_TEXT = 1 << 24
BINARY_STARTS = {
    b"PK\x03\x04": "an Excel workbook or another archive; save the table as CSV",
    b"\xd0\xcf\x11\xe0": "an old Excel workbook; save the table as CSV",
    b"PAR1": "a Parquet table",
    b"\xff\xfe": "text in UTF-16; save it in UTF-8",
    b"\xfe\xff": "text in UTF-16; save it in UTF-8",
}
PARTIAL = ".partial"
WORK_FOLDER = ".camopt"
"""Folder inside a result's folder, for unfinished files."""
NO_SYNC_ERRORS = {EBADF, EINVAL, ENOSYS, ENOTSUP, EROFS}
"""Errors of file systems that cannot sync."""
ORPHAN_SECONDS = 24 * 3600.0  # age of temporary files whose run must have died
URL_START = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://")


def expand_user_path(path: str | os.PathLike[str]) -> Path:
    """Read a path as users write it: a leading ``~`` is the home folder, and ``./~`` is a folder of that name.

    Raises
    ------
    ValueError
        If it is no path. The message completes the sentence "must be …".
    """
    if not os.fspath(path):
        raise ValueError("a path; it is empty")
    if URL_START.match(os.fspath(path)):
        raise ValueError("a path on this machine, not an address")
    try:
        expanded = Path(path).expanduser() if os.fspath(path).startswith("~") else Path(path)
    except RuntimeError:
        raise ValueError("a path; its home folder is not known") from None
    return expanded.absolute() if str(expanded).startswith("~") else expanded  # so that reading it twice is safe


def check_path(path: Any, key: str) -> None:
    """Raise BadInput for an object that is no path, such as a table."""
    if not isinstance(path, (str, bytes, os.PathLike)):
        raise BadInput([Mistake("camopt", key, type(path).__name__, "a path")])


def checked_path(path: str | os.PathLike[str], key: str) -> Path:
    """Read a path as users write it; raise BadInput if it is none."""
    check_path(path, key)
    try:
        return expand_user_path(path)
    except ValueError as trouble:
        raise BadInput([Mistake("camopt", key, os.fspath(path), str(trouble))]) from None


def checked_suffix(path: str | os.PathLike[str], key: str, allowed_suffixes: tuple[str, ...]) -> str:
    """The suffix of a path in lower case; raise BadInput unless it is one of ``allowed_suffixes``."""
    suffix = Path(path).suffix.lower()
    if suffix not in allowed_suffixes:
        listed = " or ".join(filter(None, (", ".join(allowed_suffixes[:-1]), allowed_suffixes[-1])))
        raise BadInput([Mistake("camopt", key, os.fspath(path), f"a file that ends in {listed}")])
    return suffix


@contextmanager
def open_regular_file(path: str | os.PathLike[str]) -> Iterator[BufferedReader]:
    """Open a regular file for reading.

    Raises
    ------
    BadInput
        If it is a pipe, a device or a folder.
    OSError
        If there is no such file, or it cannot be read.
    """
    if "\0" in os.fsdecode(path) or not S_ISREG(os.stat(path).st_mode):
        raise BadInput(
            [Mistake("camopt", "file", os.fsdecode(path), "a regular file, not a folder, pipe or device")]
        )
    with open(path, "rb") as file:
        yield file


def read_bytes(path: str | os.PathLike[str]) -> bytes:
    """Bytes of a user's text file. It raises the errors of ``open_regular_file``, and BadInput above 16 MiB."""
    with open_regular_file(path) as file:
        data = file.read(LARGEST_TEXT + 1)
    if len(data) > LARGEST_TEXT:
        allowed = f"a file of at most {LARGEST_TEXT >> 20} MiB"
        raise BadInput([Mistake("camopt", "file", os.fsdecode(path), allowed)])
    return data


def decode_user_text(data: bytes) -> str:
    """Decode a user's text file; a ValueError says what a file that is no UTF-8 text is, as in "is …"."""
    for start, kind in BINARY_STARTS.items():
        if data.startswith(start):
            raise ValueError(f"is {kind}")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ValueError(f"is not UTF-8 text: line {line} has the byte 0x{data[error.start]:02x}") from None


def check_writable(path: str | os.PathLike[str]) -> None:
    """Check before the work that a file can be written.

    Raises
    ------
    OSError
        If it cannot. The error names ``path``.
    """
    if Path(path).is_dir():
        raise IsADirectoryError(EISDIR, os.strerror(EISDIR), os.fspath(path))
    # an error must name the path that the user gave, not the temporary file
    try:
        TemporaryFile(dir=Path(path).parent).close()
    except OSError as trouble:
        raise OSError(trouble.errno or 0, os.strerror(trouble.errno or 0), os.fspath(path)) from None


@contextmanager
def atomically_written_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside ``path``. It is renamed to ``path`` if the block ends well, else removed.

    The file is synced to disk before the renaming. The mode of an earlier file stays. A link stays too, and then
    points to the new file. Temporary files that are more than a day old are removed: their runs have died.

    Raises
    ------
    OSError
        If the file cannot be written, or a folder or a device has its name. The error names ``path``.

    Warns
    -----
    TidyingWarning
        If something fails after the file has its name.
    """
    path = Path(path)
    target = Path(os.path.realpath(path)) if path.is_symlink() else path
    partial = target.with_name(f".{target.name}.{os.urandom(8).hex()}{PARTIAL}")
    with attribute_errors_to(path, partial), ExitStack() as stack:
        check_replaceable(target)
        _remove_orphans(target)
        stack.callback(_remove_partial, partial)
        partial.open("xb").close()
        yield partial
        sync_to_disk(partial)
        with suppress(OSError):
            partial.chmod(S_IMODE(target.stat().st_mode))
        os.replace(partial, target)
        try:
            sync_to_disk(target.parent)
        except OSError as trouble:
            warn_of_failed_tidying(trouble, path)


class TidyingWarning(RuntimeWarning):
    """A result is published and complete, but tidying up failed afterwards."""


class LossWarning(str):
    """A sentence about data that will be removed."""


def warn_of_failed_tidying(error: OSError, path: Path) -> None:
    """Warn of an error after a file or folder was published."""
    warn(f"{path}: published; tidying failed: {error.strerror or error}", TidyingWarning, stacklevel=2)


@contextmanager
def attribute_errors_to(path: Path, *temporary_paths: Path) -> Iterator[None]:
    """Make an OSError about a temporary file, or about no file, name ``path``; others stay as they are."""
    try:
        yield
    except OSError as trouble:
        if trouble.filename is not None and Path(os.fsdecode(trouble.filename)) not in temporary_paths:
            raise  # about another file that the block writes
        reason = os.strerror(trouble.errno) if trouble.errno else str(trouble)
        raise copy_os_error_for_path(trouble, reason, path) from None


def copy_os_error_for_path(original: OSError, reason: str, path: Path) -> OSError:
    """Copy an error and its notes, with another file and reason."""
    error = OSError(original.errno or 0, reason, os.fspath(path))
    for note in getattr(original, "__notes__", ()):
        error.add_note(note)
    return error


def check_replaceable(target: Path) -> None:
    """Raise an OSError if a folder, pipe or device has the file's name."""
    if target.is_dir():
        raise IsADirectoryError(EISDIR, os.strerror(EISDIR))
    if target.exists() and not target.is_file():
        raise OSError(EINVAL, os.strerror(EINVAL))


def sync_to_disk(path: Path) -> None:
    """Wait until a file, or the list of names in a folder, is on disk, if the system can do that.

    Raises
    ------
    OSError
        If the disk is full or fails.
    """
    try:
        descriptor = os.open(path, os.O_RDWR if os.name == "nt" else os.O_RDONLY)
    except PermissionError:  # a folder that cannot be read, or any folder on Windows
        return
    try:
        os.fsync(descriptor)
    except OSError as trouble:
        if trouble.errno not in NO_SYNC_ERRORS:
            raise OSError(trouble.errno, trouble.strerror, os.fspath(path)) from None
    finally:
        os.close(descriptor)


def _remove_orphans(target: Path) -> None:
    """Remove a target's temporary files that are more than a day old."""
    with suppress(OSError):
        for partial in target.parent.glob(f".{escape(target.name)}.*{PARTIAL}"):
            if time() - partial.lstat().st_mtime > ORPHAN_SECONDS:
                _remove_partial(partial)


def _remove_partial(partial: Path) -> None:
    with suppress(OSError):
        partial.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a small text file, whole or not at all."""
    with atomically_written_file(path) as partial:
        partial.write_text(text, encoding="utf-8", newline="\n")  # the same bytes on every system
