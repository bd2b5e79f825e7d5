"""Machine code of kernels on disk, in files with digests that show damage.

A file that a power failure emptied must not stop later runs, and a flipped bit must not change a result. So each
file starts with its digest. If anything about a file is wrong, the kernel is compiled again and the file replaced.
If the folder or disk takes no files, kernels are compiled in each process.

The code in the folder runs in this process. So the folder is used only if it belongs to this user and is closed to
all others. Numba's own cache would need numba, whose import takes half a second in every command.
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

from camopt.core.kernels.machine_code import MachineCode, ObjectCode, target_system_cpu_and_features
from camopt.core.kernels.version import version_of_kernels

DIGEST_SIZE = sha256().digest_size
UNUSED_SECONDS = 30 * 24 * 3600.0  # time after which an unused folder of another version is removed
PRIVATE_MODE = 0o700
NO_FOLDER = Path(os.devnull)


def content_if_undamaged(data: bytes) -> bytes | None:
    """Content of a file without its digest; None if the file is damaged."""
    digest, content = data[:DIGEST_SIZE], data[DIGEST_SIZE:]
    return content if sha256(content).digest() == digest else None


class KernelFile:
    """File of a function's machine code, for arguments of some kinds and one kind of processor.

    Raises
    ------
    OSError
        If the function has no source file.
    """

    def __init__(self, function: Any, kinds: tuple[Any, ...], folder: Path) -> None:
        source = Path(inspect.getfile(function)).read_bytes()
        self._kinds = kinds
        self._key = sha256(repr((kinds, target_system_cpu_and_features())).encode() + source).digest()
        stem = f"{function.__module__}.{function.__qualname__}".replace("<", "").replace(">", "")
        self._file = folder / f"{stem}-{self._key.hex()[:16]}.kernel"

    def load_or_compile(self, compile_code: Callable[[tuple[Any, ...]], ObjectCode]) -> MachineCode:
        """Machine code from disk, or compiled and kept. If two processes compile at once, one file stays."""
        code = self.read()
        if code is None:
            code = compile_code(self._kinds)
            self.write(code)
        return MachineCode(self._kinds, code)

    @property
    def exists(self) -> bool:
        return self._file.is_file()

    def read(self) -> ObjectCode | None:
        """Read the kernel; None if the file is missing or damaged."""
        try:
            content = content_if_undamaged(self._file.read_bytes())
        except OSError:
            return None
        if content is None or content[:DIGEST_SIZE] != self._key:
            return None
        name, _, code = content[DIGEST_SIZE:].partition(b"\n")
        return ObjectCode(name.decode(), code)

    def write(self, code: ObjectCode) -> None:
        """Write a whole kernel to disk, if the disk takes it."""
        if not code.whole:
            return
        content = self._key + code.name.encode() + b"\n" + code.content
        partial = self._file.with_name(f"{self._file.name}.{os.urandom(8).hex()}.partial")
        with suppress(OSError):
            try:
                partial.write_bytes(sha256(content).digest() + content)
                os.replace(partial, self._file)
            finally:
                partial.unlink(missing_ok=True)


@cache
def kernel_folder() -> Path:
    """Folder of the kernels for this version of the package."""
    return open_version_folder(kernel_cache_root(os.environ.get("NUMBA_CACHE_DIR", "")), version_of_kernels())


def kernel_cache_root(configured_path: str) -> Path:
    """Folder of kernels: as configured, or in the user's cache; ``NO_FOLDER`` for a user without a home."""
    try:
        root = Path(configured_path) if configured_path else user_cache_path("camopt")
    except RuntimeError:
        return NO_FOLDER
    return root if configured_path or root.is_absolute() else NO_FOLDER


def open_version_folder(root: Path, version: str) -> Path:
    """Open the folder of a version of the kernels, or make it. Long unused folders of other versions are removed.

    A folder that is open to other users is not used, with a line on standard error.
    """
    folder = root / version
    with suppress(OSError):
        if not folder.is_dir():
            root.mkdir(parents=True, exist_ok=True)
            folder.mkdir(PRIVATE_MODE, exist_ok=True)
            _remove_unused_versions(root, len(version))
        if is_private(folder):
            with suppress(OSError):
                os.utime(folder)  # marks it as used
            return folder
        print(f"camopt: {folder} is not used: it must be your folder, with mode 0700", file=sys.stderr)
    return NO_FOLDER


def is_private(folder: Path) -> bool:
    """Whether a folder belongs to this user and is closed to all others; always true on Windows."""
    if not hasattr(os, "geteuid"):
        return True
    status, user = folder.lstat(), os.geteuid()
    private = stat.S_IMODE(status.st_mode) == PRIVATE_MODE
    return stat.S_ISDIR(status.st_mode) and status.st_uid == user and private


def _remove_unused_versions(root: Path, name_length: int) -> None:
    for folder in root.iterdir():
        version = len(folder.name) == name_length and set(folder.name) <= set("0123456789abcdef")
        if version and not folder.is_symlink() and time() - folder.stat().st_mtime > UNUSED_SECONDS:
            shutil.rmtree(folder, ignore_errors=True)
