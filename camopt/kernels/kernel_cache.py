"""Machine code of kernels on disk, in files that say whether they are what was written.

numba's own cache trusts its files: one emptied by a power failure stops every later run, one with a flipped bit
crashes or computes something else. Here each file starts with the digest of its content. A file that is odd in any
way is as none: the kernel is compiled, and the file written, anew. A folder or disk that takes no files is no
trouble either.
"""

import inspect
import os
import pickle
import shutil
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from time import time
from typing import Any

from numba.core import compiler, serialize
from numba.core.caching import NullCache
from numba.core.runtime.nrt import rtsys
from platformdirs import user_cache_path

rebuilt: Callable[..., Any] = compiler.CompileResult._rebuild
pickled: Callable[..., bytes] = serialize.dumps
DIGEST = sha256().digest_size
UNUSED = 30 * 24 * 3600.0  # seconds after which a folder of another version is removed


def checked(content: bytes) -> bytes:
    """What a file holds, with its digest before it."""
    return sha256(content).digest() + content


def content_of(data: bytes) -> bytes | None:
    """The content of a checked file; None if it is not what was written."""
    digest, content = data[:DIGEST], data[DIGEST:]
    return content if sha256(content).digest() == digest else None


class KernelCache(NullCache):
    """The compiled versions of one function: a file for each signature and processor, in place of numba's cache.

    Raises
    ------
    OSError
        If the function's source is no file.
    """

    def __init__(self, function: Callable[..., Any], folder: Path) -> None:
        self._folder = folder
        self._stem = f"{function.__module__}.{function.__qualname__}".replace("<", "").replace(">", "")
        self._source = sha256(Path(inspect.getfile(function)).read_bytes()).hexdigest()

    @property
    def cache_path(self) -> str:
        return str(self._folder)

    def _key(self, signature: Any, codegen: Any) -> tuple[Any, ...]:
        """What the machine code depends on beside the folder: types, source, processor."""
        return signature, self._source, codegen.magic_tuple()

    def _file(self, key: tuple[Any, ...]) -> Path:
        return self._folder / f"{self._stem}-{sha256(repr(key).encode()).hexdigest()[:16]}.kernel"

    def holds(self, signature: Any, codegen: Any) -> bool:
        """Whether there is a file for a signature."""
        return self._file(self._key(signature, codegen)).is_file()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled function for a signature; None if there is none on disk that is whole.

        Machine code needs numba's memory management, and none of what numba knows of Python, which takes it half a
        second to load.
        """
        rtsys.initialize(target_context)
        key = self._key(sig, target_context.codegen())
        try:
            content = content_of(self._file(key).read_bytes())
        except OSError:
            return None
        if content is None:
            return None
        stored, result = pickle.loads(content)
        return rebuilt(target_context, *result) if stored == key else None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled function, if there is room for it."""
        if data.library.has_dynamic_globals:  # addresses of this process
            return
        key = self._key(sig, data.codegen)
        file = self._file(key)
        partial = file.with_name(f"{file.name}.{os.urandom(8).hex()}.partial")
        with suppress(OSError):
            try:
                partial.write_bytes(checked(pickled((key, data._reduce()))))
                os.replace(partial, file)
            finally:
                partial.unlink(missing_ok=True)


def cache_root(named: str) -> Path:
    """Where kernels are kept: as named, or in the user's folder; nowhere for a user who has no home."""
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


def _remove_unused(root: Path, length: int) -> None:
    for folder in root.iterdir():
        version = len(folder.name) == length and set(folder.name) <= set("0123456789abcdef")
        if version and not folder.is_symlink() and time() - folder.stat().st_mtime > UNUSED:
            shutil.rmtree(folder, ignore_errors=True)
