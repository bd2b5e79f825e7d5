"""Check by the manifest whether files of results are as camopt wrote them."""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from io import BufferedReader
from pathlib import Path
from typing import Any, Literal

from camopt.core.mistakes import BAD_INPUT, FILE_TROUBLE, BadInput, Mistake, escape_unprintable
from camopt.core.storage.files import open_regular_file
from camopt.core.storage.manifest import (
    MANIFEST,
    PARQUET_SUFFIX,
    DamagedManifest,
    Manifest,
    file_entry,
    read_manifest,
)
from camopt.solve.tables.result import FileLine, Result


@dataclass(frozen=True)
class FileCheck:
    """The state of a checked file.

    Attributes
    ----------
    file : pathlib.Path
        The file.
    state : str
        "whole": every byte is as it was written. "changed": the file differs from the one that the manifest names;
        it is damaged, edited or from another run. "damaged": the manifest itself is damaged. "missing" and
        "unreadable": the file is so. "unknown": there is no manifest for the file, so it cannot be checked.
    told : str
        The state in words.
    rows : int or None
        Number of rows, for a table that is whole.

    Examples
    --------
    >>> scene = camopt.find_scene("two-pauses").replace(**{"search.base_radius": [60, 80]})
    >>> swept = camopt.sweep(scene, out="results")
    >>> [(each.file.name, each.state) for each in camopt.check("results/designs.parquet", "results/scene.toml")]
    [('designs.parquet', 'whole'), ('scene.toml', 'whole')]
    """

    file: Path
    state: Literal["whole", "damaged", "changed", "missing", "unreadable", "unknown"]
    told: str
    rows: int | None = None

    @property
    def is_whole(self) -> bool:
        """Whether every byte is as it was written."""
        return self.state == "whole"


class FileChecks(Result, tuple[FileCheck, ...]):
    """The states of checked files: a tuple of ``FileCheck``.

    Examples
    --------
    >>> scene = camopt.find_scene("two-pauses").replace(**{"search.base_radius": [60, 80]})
    >>> swept = camopt.sweep(scene, out="results")
    >>> camopt.check("results").exit_code
    0
    """

    main_rows = "files"

    def sections(self) -> Iterator[FileLine]:
        """One line for each file, with its state."""
        return (FileLine(escape_unprintable(f"{check.file}: {check.told}")) for check in self)

    def values_for_json(self) -> dict[str, Any]:
        """Whether all files are whole, and the state of each."""
        return {"whole": all(check.is_whole for check in self), "files": [*self]}

    @property
    def exit_code(self) -> int:
        """0 if all files are whole, 3 if one is damaged, changed or missing, 2 if one cannot be checked."""
        states = {check.state for check in self}
        return FILE_TROUBLE if states - {"whole", "unknown"} else BAD_INPUT if "unknown" in states else 0


def check(*files: str | os.PathLike[str]) -> FileChecks:
    """Check whether the files of results are as camopt wrote them, bit for bit.

    Each file is compared with ``manifest.json`` beside it, which also shows missing files and files of another run.
    All files are checked, even after a fault. Files are read in parts, so large files need little memory.

    Parameters
    ----------
    *files : str or os.PathLike
        Files and folders. In a folder, all files are checked, those of its subfolders included, but hidden ones are
        not.

    Returns
    -------
    FileChecks
        A tuple of ``FileCheck``, one for each file.

    Raises
    ------
    BadInput
        If no file is given.

    Examples
    --------
    >>> scene = camopt.find_scene("two-pauses").replace(**{"search.base_radius": [60, 80]})
    >>> swept = camopt.sweep(scene, out="results")
    >>> all(each.is_whole for each in camopt.check("results"))
    True
    """
    if not files:
        raise BadInput([Mistake("camopt", "files", None, "at least one file or folder")])
    return FileChecks(checked for path in map(Path, files) for checked in _check_path(path))


def _check_path(path: Path) -> list[FileCheck]:
    """Check a file, or all files in a folder and its subfolders."""
    if not os.path.isdir(path):
        about, manifest = _check_and_read_manifest(path.parent)
        return [about if about and path.name == MANIFEST else _check_file(path, manifest)]
    checks, errors = list[FileCheck](), list[OSError]()
    for folder, subfolders, names in os.walk(path, onerror=errors.append):
        subfolders[:] = sorted(name for name in subfolders if not name.startswith("."))
        about, manifest = _check_and_read_manifest(Path(folder))
        checks += [about] if about else []
        present = {name for name in names if not name.startswith(".")}
        for name in sorted(present.union(manifest.files if manifest else ()) - {MANIFEST}):
            checks.append(_check_file(Path(folder) / name, manifest))
    checks += [_unreadable_check(Path(error.filename), error) for error in errors]
    return checks or [FileCheck(path, "unknown", "a folder with no files in it")]


def _check_and_read_manifest(folder: Path) -> tuple[FileCheck | None, Manifest | None]:
    """State of a folder's manifest, and the manifest; None for each that does not exist."""
    path = folder / MANIFEST
    try:
        manifest = read_manifest(folder)
    except DamagedManifest:
        return FileCheck(path, "damaged", "damaged, or of another version; its files cannot be checked"), None
    except OSError as trouble:
        return _unreadable_check(path, trouble), None
    if manifest is None:
        return (FileCheck(path, "unknown", "of another program"), None) if path.exists() else (None, None)
    return FileCheck(path, "whole", "whole"), manifest


def _check_file(path: Path, manifest: Manifest | None) -> FileCheck:
    """State of a file by its manifest."""
    entry = manifest.files.get(path.name) if manifest else None
    try:
        with open_regular_file(path) as file:
            if entry is None:
                told = f"{MANIFEST} does not name it" if manifest else f"there is no {MANIFEST} with its digest"
                return FileCheck(path, "unknown", told)
            actual = file_entry(file)
            if actual == entry:
                return _whole_check_with_row_count(path, file)
    except FileNotFoundError:
        return FileCheck(path, "missing", f"missing, though {MANIFEST} names it" if entry else "no such file")
    except BadInput:
        return FileCheck(path, "unknown", "no regular file")
    except OSError as trouble:
        return _unreadable_check(path, trouble)
    sizes = "" if actual.bytes == entry.bytes else f" ({actual.bytes:,} bytes, but {entry.bytes:,} were written)"
    return FileCheck(path, "changed", f"damaged or changed since it was written, or of another run{sizes}")


def _whole_check_with_row_count(path: Path, file: BufferedReader) -> FileCheck:
    """State of a whole file, with the number of rows of a table."""
    if path.suffix != PARQUET_SUFFIX:
        return FileCheck(path, "whole", "whole")
    import pyarrow.parquet as pq

    rows = pq.ParquetFile(file).metadata.num_rows
    return FileCheck(path, "whole", f"whole, {rows:,} row{'s' * (rows != 1)}", rows)


def _unreadable_check(path: Path, trouble: OSError) -> FileCheck:
    return FileCheck(path, "unreadable", trouble.strerror or str(trouble))
