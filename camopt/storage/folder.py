"""The folder of a result: made if there is none, and written by one run at a time."""

import os
import platform
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from errno import EAGAIN, ENOENT, ENOTDIR
from io import FileIO
from pathlib import Path
from stat import S_ISDIR

from camopt.kernels.locking import lock
from camopt.storage.files import WORK_FOLDER, named, naming

LOCK_FILE = "lock"
LOCK_TRIES = 100
"""More often, other runs do not remove the folder of a lock while this one opens it."""


@contextmanager
def made_folder(folder: Path) -> Iterator[list[Path]]:
    """The folder, made with those above it if necessary; new ones are removed again if they stay empty."""
    made = [each for each in (folder, *folder.parents) if not each.exists()]
    try:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except FileExistsError as trouble:
            raise named(trouble, "this is neither a folder nor a link to one", Path(trouble.filename)) from None
        yield made
    finally:
        with suppress(OSError):  # there is something in it
            for each in made:
                each.rmdir()


@contextmanager
def held_folder(folder: Path) -> Iterator[tuple[Path, bool]]:
    """The work folder, held by this process; and whether no other process can hold it.

    The lock is that of the open file, which the system lets go when the process dies. The file goes at the end, so
    one that was opened just before and got the lock just after has no name any more: then again.
    """
    work = folder / WORK_FOLDER
    path = work / LOCK_FILE
    with ExitStack() as stack:
        stack.callback(_quietly, work.rmdir)  # if there is no journal in it
        while True:
            file = stack.enter_context(_opened(folder, work, path))
            held = lock(file.fileno())
            if held is False:
                _refuse(file, folder)
            if held is None or _same(file, path):
                break
            file.close()
        if held is None:  # Windows removes no open files
            file.close()
        stack.callback(_quietly, path.unlink)
        if held:
            _quietly(file.truncate, 0)
            _quietly(file.write, f"process {os.getpid()} on {platform.node()}".encode())
        yield work, bool(held)


def _opened(folder: Path, work: Path, path: Path) -> FileIO:
    """The file of the lock, made if there is none."""
    for _ in range(LOCK_TRIES):
        with naming(folder, work, path), suppress(FileExistsError):
            work.mkdir()
        with suppress(FileNotFoundError):  # another run has just removed the folder
            if not S_ISDIR(work.lstat().st_mode):
                raise NotADirectoryError(ENOTDIR, os.strerror(ENOTDIR), os.fspath(work))
            with naming(folder, work, path):
                return path.open("a+b", buffering=0)
    raise FileNotFoundError(ENOENT, os.strerror(ENOENT), os.fspath(path))


def _same(file: FileIO, path: Path) -> bool:
    """Whether an open file is still the one of that name."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    except FileNotFoundError:
        return False


def _refuse(file: FileIO, folder: Path) -> None:
    file.seek(0)
    holder = file.read(200).decode(errors="replace") or "another process"
    raise BlockingIOError(EAGAIN, f"another run writes to this folder ({holder})", os.fspath(folder))


def _quietly(call: Callable[..., object], *arguments: object) -> None:
    """Try an action that the result does not need."""
    with suppress(OSError):
        call(*arguments)
