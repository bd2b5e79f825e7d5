"""Machine code of kernels on disk, in files with digests that show damage.

A file emptied by a power failure must not stop every later run, nor one with a flipped bit crash or compute
something else. Each file starts with its digest. A file that is odd in any way is as none: the kernel is compiled,
and the file written, anew. A folder or disk that takes no files is no trouble either.

Beside it is a file as long as the kernel has run uncompiled, a byte for each tenth of a second: what is called a
little by each of many processes is compiled once that pays.
"""

import inspect
import os
import shutil
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache, cached_property
from hashlib import sha256
from pathlib import Path
from time import time
from typing import Any

from platformdirs import user_cache_path

from camopt.kernels.locking import lock_in_time
from camopt.kernels.machine_code import ObjectCode, processor
from camopt.kernels.version import version_of_kernels

DIGEST_SIZE = sha256().digest_size
UNUSED = 30 * 24 * 3600.0  # seconds after which a folder of another version is removed
TENTH = 0.1
CLAIMED = 60.0  # seconds after which a process that was to compile a kernel is taken for dead


def checked(content: bytes) -> bytes:
    """The content of a file with its digest in front."""
    return sha256(content).digest() + content


def content_of(data: bytes) -> bytes | None:
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
        self._key = sha256(repr((kinds, processor())).encode() + source).digest()
        stem = f"{function.__module__}.{function.__qualname__}".replace("<", "").replace(">", "")
        self._file = folder / f"{stem}-{self._key.hex()[:16]}.kernel"
        self._beyond = 0.0  # seconds of plain runs that are no byte yet

    @property
    def exists(self) -> bool:
        return self._file.is_file()

    def read(self) -> ObjectCode | None:
        """The kernel; None if there is none on disk that is whole."""
        try:
            content = content_of(self._file.read_bytes())
        except OSError:
            return None
        if content is None or content[:DIGEST_SIZE] != self._key:
            return None
        name, _, code = content[DIGEST_SIZE:].partition(b"\n")
        return ObjectCode(name.decode(), code)

    @contextmanager
    def one_process(self) -> Iterator[None]:
        """A block that one process at a time is in: others wait, but go on if it takes that one too long."""
        path = self._file.with_suffix(".lock")
        with ExitStack() as stack:
            with suppress(OSError):
                file = stack.enter_context(path.open("ab"))
                stack.callback(_remove, path)
                lock_in_time(file.fileno(), CLAIMED)
            yield

    def write(self, code: ObjectCode) -> None:
        """Keep a kernel that is whole, if there is room for it."""
        if not code.whole:
            return
        content = self._key + code.name.encode() + b"\n" + code.content
        partial = self._file.with_name(f"{self._file.name}.{os.urandom(8).hex()}.partial")
        with suppress(OSError):
            try:
                partial.write_bytes(checked(content))
                os.replace(partial, self._file)
            finally:
                partial.unlink(missing_ok=True)

    @cached_property
    def plain_seconds(self) -> float:
        """Of runs of the function as it is written, in this process and those before it."""
        try:
            return self._runs.stat().st_size * TENTH
        except OSError:
            return 0.0

    def ran_plainly(self, seconds: float) -> None:
        """Remember that the function ran for so long."""
        self.plain_seconds += seconds
        tenths, self._beyond = divmod(self._beyond + seconds, TENTH)
        if tenths:
            with suppress(OSError), self._runs.open("ab") as file:
                file.write(b"." * int(tenths))

    def claim(self) -> bool:
        """Whether this process may have the kernel compiled: none other that may be at it has asked before."""
        claim = self._file.with_suffix(".claim")
        with suppress(OSError):
            if claim.exists() and time() - claim.stat().st_mtime > CLAIMED:
                claim.unlink()
            claim.touch(exist_ok=False)
            return True
        return False

    @property
    def _runs(self) -> Path:
        return self._file.with_suffix(".plain")


@cache
def kernel_folder() -> Path:
    """The folder of the kernels of this version of the package."""
    return opened_folder(cache_root(os.environ.get("NUMBA_CACHE_DIR", "")), version_of_kernels())


def cache_root(named: str) -> Path:
    """The folder of kernels: as configured, or in the user's folder; None for a user without a home folder."""
    nowhere = Path(os.devnull)
    try:
        root = Path(named) if named else user_cache_path("camopt")
    except RuntimeError:
        return nowhere
    return root if named or root.is_absolute() else nowhere


def opened_folder(root: Path, version: str) -> Path:
    """The folder of a version of the kernels, made if it can be; those of other versions go when long unused."""
    folder = root / version
    with suppress(OSError):
        if not folder.is_dir():
            folder.mkdir(parents=True, exist_ok=True)
            _remove_unused(root, len(version))
        os.utime(folder)  # in use
    return folder


def _remove(path: Path) -> None:
    with suppress(OSError):  # Windows removes no open files
        path.unlink()


def _remove_unused(root: Path, length: int) -> None:
    for folder in root.iterdir():
        version = len(folder.name) == length and set(folder.name) <= set("0123456789abcdef")
        if version and not folder.is_symlink() and time() - folder.stat().st_mtime > UNUSED:
            shutil.rmtree(folder, ignore_errors=True)
