"""Machine code of kernels on disk, in files with digests that show damage.

A file emptied by a power failure must not stop every later run, nor one with a flipped bit crash or compute
something else. Each file starts with its digest. A file that is odd in any way is as none: the kernel is compiled,
and the file written, anew. A folder or disk that takes no files is no trouble either.

What is in the folder runs in this process. So it is a folder of this user, closed to all others, or it is not used.
numba has a cache of its own, which serves only those who import numba: half a second in every command.
"""

import inspect
import os
import shutil
import stat
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from time import time
from typing import Any

from platformdirs import user_cache_path

from camopt.core.kernels.machine_code import MachineCode, ObjectCode, processor
from camopt.core.kernels.version import version_of_kernels

DIGEST_SIZE = sha256().digest_size
UNUSED_SECONDS = 30 * 24 * 3600.0  # seconds after which a folder of another version is removed
PRIVATE_MODE = 0o700
NO_FOLDER = Path(os.devnull)


def with_digest(content: bytes) -> bytes:
    """The content of a file with its digest in front."""
    return sha256(content).digest() + content


def checked_content(data: bytes) -> bytes | None:
    """The content of a checked file; None if it is damaged."""
    digest, content = data[:DIGEST_SIZE], data[DIGEST_SIZE:]
    return content if sha256(content).digest() == digest else None


class KernelFile:
    """The machine code of a function for arguments of some kinds, on one kind of processor.

    Raises
    ------
    OSError
        If the function's source is no file.
    """

    def __init__(self, function: Any, kinds: tuple[Any, ...], folder: Path) -> None:
        source = Path(inspect.getfile(function)).read_bytes()
        self._kinds = kinds
        self._key = sha256(repr((kinds, processor())).encode() + source).digest()
        stem = f"{function.__module__}.{function.__qualname__}".replace("<", "").replace(">", "")
        self._file = folder / f"{stem}-{self._key.hex()[:16]}.kernel"

    def machine_code(self, compile_code: Callable[[tuple[Any, ...]], ObjectCode]) -> MachineCode:
        """The machine code from disk, or compiled and kept. Of two processes that do so at once, one file stays."""
        code = self.read()
        if code is None:
            code = compile_code(self._kinds)
            self.write(code)
        return MachineCode(self._kinds, code)

    @property
    def exists(self) -> bool:
        return self._file.is_file()

    def read(self) -> ObjectCode | None:
        """The kernel; None if there is none on disk that is whole."""
        try:
            content = checked_content(self._file.read_bytes())
        except OSError:
            return None
        if content is None or content[:DIGEST_SIZE] != self._key:
            return None
        name, _, code = content[DIGEST_SIZE:].partition(b"\n")
        return ObjectCode(name.decode(), code)

    def write(self, code: ObjectCode) -> None:
        """Keep a kernel that is whole, if there is room for it."""
        if not code.whole:
            return
        content = self._key + code.name.encode() + b"\n" + code.content
        partial = self._file.with_name(f"{self._file.name}.{os.urandom(8).hex()}.partial")
        with suppress(OSError):
            try:
                partial.write_bytes(with_digest(content))
                os.replace(partial, self._file)
            finally:
                partial.unlink(missing_ok=True)


@cache
def kernel_folder() -> Path:
    """The folder of the kernels of this version of the package."""
    return open_version_folder(cache_root(os.environ.get("NUMBA_CACHE_DIR", "")), version_of_kernels())


def cache_root(named: str) -> Path:
    """The folder of kernels: as configured, or in the user's folder; None for a user without a home folder."""
    try:
        root = Path(named) if named else user_cache_path("camopt")
    except RuntimeError:
        return NO_FOLDER
    return root if named or root.is_absolute() else NO_FOLDER


def open_version_folder(root: Path, version: str) -> Path:
    """The folder of a version of the kernels, made if it can be; those of other versions go when long unused.

    If others may have put files into it, it is not used, and a line on standard error says so.
    """
    folder = root / version
    with suppress(OSError):
        if not folder.is_dir():
            root.mkdir(parents=True, exist_ok=True)
            folder.mkdir(PRIVATE_MODE, exist_ok=True)
            _remove_unused(root, len(version))
        if is_private(folder):
            with suppress(OSError):
                os.utime(folder)  # in use
            return folder
        print(f"camopt: {folder} is not used: it is not a folder of yours with mode 0700", file=sys.stderr)
    return NO_FOLDER


def is_private(folder: Path) -> bool:
    """Whether a folder belongs to this user and is closed to all others. Windows has no such modes."""
    if not hasattr(os, "geteuid"):
        return True
    found = folder.lstat()
    return (
        stat.S_ISDIR(found.st_mode) and found.st_uid == os.geteuid() and stat.S_IMODE(found.st_mode) == PRIVATE_MODE
    )


def _remove_unused(root: Path, length: int) -> None:
    for folder in root.iterdir():
        version = len(folder.name) == length and set(folder.name) <= set("0123456789abcdef")
        if version and not folder.is_symlink() and time() - folder.stat().st_mtime > UNUSED_SECONDS:
            shutil.rmtree(folder, ignore_errors=True)
