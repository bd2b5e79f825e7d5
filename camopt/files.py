"""Paths settled before the work, files that appear only when whole, folders that stay only with a result inside."""

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EISDIR
from pathlib import Path
from tempfile import TemporaryFile

from camopt.mistakes import BadInput, Mistake

ADDRESS = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://")


def settled(path: str | os.PathLike[str]) -> Path:
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
        listed = f"{', '.join(known[:-1])} or {known[-1]}"
        raise BadInput([Mistake("camopt", key, os.fspath(path), f"a file that ends in {listed}")])
    return suffix


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
