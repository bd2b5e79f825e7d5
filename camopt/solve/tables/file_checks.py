"""Whether the files of results are as camopt wrote them, by the manifest beside them."""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from io import BufferedReader
from pathlib import Path
from typing import Any, Literal

from camopt.core.mistakes import BAD_INPUT, FILE_TROUBLE, BadInput, Mistake, printable
from camopt.core.storage.files import regular_file
from camopt.core.storage.manifest import MANIFEST, PARQUET_SUFFIX, DamagedManifest, Manifest, entry_of, manifest_of
from camopt.solve.tables.result import FileLine, Result

FileState = Literal["whole", "damaged", "changed", "missing", "unreadable", "unknown"]


@dataclass(frozen=True)
class FileCheck:
    """The state of a checked file.

    Attributes
    ----------
    file : pathlib.Path
        The file.
    state : str
        "whole": each byte is as it was written. "changed": it is not the file that the manifest names: damaged,
        changed by another hand, or of another run. "damaged": so is the manifest itself. "missing", "unreadable":
        so it is. "unknown": nothing tells what was written, so this is not "whole".
    told : str
        The same in words.
    rows : int or None
        Of a table that is whole.

    Examples
    --------
    >>> scene = camopt.find_scene("two-pauses").replace(**{"search.base_radius": [60, 80]})
    >>> swept = camopt.sweep(scene, out="results")
    >>> [(each.file.name, each.state) for each in camopt.check("results/designs.parquet", "results/scene.toml")]
    [('designs.parquet', 'whole'), ('scene.toml', 'whole')]
    """

    file: Path
    state: FileState
    told: str
    rows: int | None = None

    @property
    def is_whole(self) -> bool:
        """Whether each byte is as it was written."""
        return self.state == "whole"


class FileChecks(Result, tuple[FileCheck, ...]):
    """The states of some files: a tuple of ``FileCheck``.

    Examples
    --------
    >>> scene = camopt.find_scene("two-pauses").replace(**{"search.base_radius": [60, 80]})
    >>> swept = camopt.sweep(scene, out="results")
    >>> camopt.check("results").exit_code
    0
    """

    main_rows = "files"

    def sections(self) -> Iterator[FileLine]:
        """The state of each file, one a line."""
        return (FileLine(printable(f"{each.file}: {each.told}")) for each in self)

    def document(self) -> dict[str, Any]:
        """Whether all are whole, and the state of each."""
        return {"whole": all(each.is_whole for each in self), "files": [*self]}

    @property
    def exit_code(self) -> int:
        """0; 3 if a file is damaged, changed or missing; 2 if there is nothing to check one by."""
        states = {each.state for each in self}
        return FILE_TROUBLE if states - {"whole", "unknown"} else BAD_INPUT if "unknown" in states else 0


def check(*files: str | os.PathLike[str]) -> FileChecks:
    """Check whether the files of results are as camopt wrote them, bit for bit.

    A file is known by ``manifest.json`` beside it, and so are files that are missing, or of another run. All files
    are checked, whatever is found in the first ones. They are read in parts: memory does not grow with them.

    Parameters
    ----------
    *files : str or os.PathLike
        Files, and folders: all files in them and in folders inside them, but for hidden ones.

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


def _check_path(path: Path) -> Iterator[FileCheck]:
    """A file, or all files in a folder and those inside it."""
    if not os.path.isdir(path):
        about, manifest = _check_manifest(path.parent)
        yield about if about and path.name == MANIFEST else _check_file(path, manifest)
        return
    closed: list[OSError] = []
    found = 0
    for folder, inner, _ in os.walk(path, onerror=closed.append):
        inner[:] = sorted(name for name in inner if not name.startswith("."))
        for checked in _check_files_in(Path(folder)):
            found += 1
            yield checked
    yield from (_unreadable_check(Path(each.filename), each) for each in closed)
    if not found and not closed:
        yield FileCheck(path, "unknown", "a folder with no files in it")


def _check_files_in(folder: Path) -> Iterator[FileCheck]:
    """The manifest of a folder, and all files that are in it, or should be."""
    about, manifest = _check_manifest(folder)
    if about:
        yield about
    there = {each.name for each in os.scandir(folder) if not each.name.startswith(".") and not each.is_dir()}
    for name in sorted({*there, *(manifest.files if manifest else ())} - {MANIFEST}):
        yield _check_file(folder / name, manifest)


def _check_manifest(folder: Path) -> tuple[FileCheck | None, Manifest | None]:
    """The state of the manifest of a folder, and what it says; neither where there is none of camopt."""
    path = folder / MANIFEST
    try:
        manifest = manifest_of(folder)
    except DamagedManifest:
        told = "damaged, or of another version, so that it does not tell which files belong to it"
        return FileCheck(path, "damaged", told), None
    except OSError as trouble:
        return _unreadable_check(path, trouble), None
    if manifest is None:
        return (FileCheck(path, "unknown", "of another program"), None) if path.exists() else (None, None)
    return FileCheck(path, "whole", "whole"), manifest


def _check_file(path: Path, manifest: Manifest | None) -> FileCheck:
    """The state of a file by a manifest."""
    entry = manifest.files.get(path.name) if manifest else None
    try:
        with regular_file(path) as file:
            if entry is None:
                told = f"{MANIFEST} does not name it" if manifest else f"there is no {MANIFEST} to check it by"
                return FileCheck(path, "unknown", told)
            found = entry_of(file)
            if found == entry:
                return _whole_check(path, file)
    except FileNotFoundError:
        return FileCheck(path, "missing", f"missing, though {MANIFEST} names it" if entry else "no such file")
    except BadInput:
        return FileCheck(path, "unknown", "no regular file")
    except OSError as trouble:
        return _unreadable_check(path, trouble)
    sizes = "" if found.bytes == entry.bytes else f" ({found.bytes:,} bytes, where {entry.bytes:,} were written)"
    return FileCheck(path, "changed", f"damaged or changed since it was written, or of another run{sizes}")


def _whole_check(path: Path, file: BufferedReader) -> FileCheck:
    """The state of a whole file, with the rows of a table."""
    if path.suffix != PARQUET_SUFFIX:
        return FileCheck(path, "whole", "whole")
    import pyarrow.parquet as pq

    rows = pq.ParquetFile(file).metadata.num_rows
    return FileCheck(path, "whole", f"whole, {rows:,} row{'s' * (rows != 1)}", rows)


def _unreadable_check(path: Path, trouble: OSError) -> FileCheck:
    return FileCheck(path, "unreadable", trouble.strerror or str(trouble))
