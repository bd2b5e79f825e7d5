"""Files that appear under their final name only when whole, and folders that stay only with a result in them."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EISDIR
from pathlib import Path


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
        partial.unlink(missing_ok=True)


@contextmanager
def result_folder(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A folder, made if there is none; what was made goes again if the block fails and left nothing in it."""
    path = Path(path)
    made = [folder for folder in (path, *path.parents) if not folder.exists()]
    path.mkdir(parents=True, exist_ok=True)
    try:
        yield path
    except BaseException:
        with suppress(OSError):
            for folder in made:
                folder.rmdir()
        raise
