"""Whether files are as camopt wrote them: tables and parts of sweeps by their own digests, others by a manifest."""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from hashlib import file_digest
from io import BufferedReader
from pathlib import Path
from typing import Literal

from camopt.mistakes import BadInput, Mistake
from camopt.storage.manifest import MANIFEST, Damaged, Fact, Manifest, manifest_of, of_one_run, settled_file
from camopt.storage.records import damage_of
from camopt.storage.unit import PART_ENDING, TABLE_ENDING

FileState = Literal["whole", "damaged", "changed", "missing", "unreadable", "unknown"]
TABLE_START, PART_START = b"PAR1", b"camopt journal"
"""How files start that have digests of their own."""
UNCHECKABLE = "nothing to check it by"


@dataclass(frozen=True)
class FileCheck:
    """The state of a checked file.

    Attributes
    ----------
    file : pathlib.Path
        The file.
    state : str
        "whole": each byte is as it was written. "damaged": by its own digests it is not. "changed": it is not the
        file that the manifest names, by another hand or by damage. "missing", "unreadable": so it is. "unknown":
        nothing tells what was written, so this is not "whole".
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


def check(*files: str | os.PathLike[str]) -> tuple[FileCheck, ...]:
    """Check whether files are as camopt wrote them, bit for bit.

    A table is known by the digests in its footer, wherever it is, and so is a part of a sweep. Any other file of a
    result is known by ``manifest.json`` beside it, and so are files that are missing, or of another run. All files
    are checked, whatever is found in the first ones. They are read in parts: memory does not grow with them.

    Parameters
    ----------
    *files : str or os.PathLike
        Files, and folders: all files in them and in folders inside them, but for hidden ones.

    Returns
    -------
    tuple of FileCheck
        One for each file.

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
    return tuple(checked for path in map(Path, files) for checked in _each(path))


def _each(path: Path) -> Iterator[FileCheck]:
    """A file, or all files in a folder and those inside it."""
    if not os.path.isdir(path):
        about, manifest = _manifest(path.parent)
        fact = manifest.files.get(path.name) if manifest else None
        yield about if about and path.name == MANIFEST else _file(path, fact)
        return
    closed: list[OSError] = []
    found = 0
    for folder, inner, _ in os.walk(path, onerror=closed.append):
        inner[:] = sorted(name for name in inner if not name.startswith("."))
        for checked in of_one_run(Path(folder), partial(_folder, Path(folder))):
            found += 1
            yield checked
    yield from (_unreadable(Path(each.filename), each) for each in closed)
    if not found and not closed:
        yield FileCheck(path, "unknown", "a folder with no files in it")


def _folder(folder: Path) -> list[FileCheck]:
    """The manifest of a folder, and all files that are in it, or should be."""
    about, manifest = _manifest(folder)
    named = manifest.files if manifest else {}
    there = {each.name for each in os.scandir(folder) if not each.name.startswith(".") and not each.is_dir()}
    files = [_file(folder / name, named.get(name)) for name in sorted({*there, *named} - {MANIFEST})]
    return [about, *files] if about else files


def _manifest(folder: Path) -> tuple[FileCheck | None, Manifest | None]:
    """The manifest of a folder, and what is known of it; neither where there is none."""
    path = folder / MANIFEST
    try:
        manifest = manifest_of(folder)
    except Damaged:
        return FileCheck(path, "damaged", "damaged, so that it does not tell which files belong to it"), None
    except BadInput:
        return FileCheck(path, "unknown", f"of another program: {UNCHECKABLE}"), None
    except OSError as trouble:
        return _unreadable(path, trouble), None
    return (FileCheck(path, "whole", "whole"), manifest) if manifest else (None, None)


def _file(path: Path, fact: Fact | None) -> FileCheck:
    """A file, by its own digests and by what the manifest says of it."""
    try:
        with settled_file(path) as file:
            own = _by_itself(path, file)
            return own if own.state == "damaged" or fact is None else _by_manifest(own, file, fact)
    except FileNotFoundError:
        return FileCheck(path, "missing", f"missing, though {MANIFEST} names it" if fact else "no such file")
    except BadInput:
        return FileCheck(path, "unknown", f"no regular file: {UNCHECKABLE}")
    except OSError as trouble:
        return _unreadable(path, trouble)


def _unreadable(path: Path, trouble: OSError) -> FileCheck:
    return FileCheck(path, "unreadable", trouble.strerror or str(trouble))


def _by_itself(path: Path, file: BufferedReader) -> FileCheck:
    """What a file says of itself: tables and parts of sweeps do, under whatever name."""
    head, suffix = file.read(max(map(len, (TABLE_START, PART_START)))), path.suffix.lower()
    if suffix == TABLE_ENDING or head.startswith(TABLE_START):
        return _table(path, file)
    if suffix == PART_ENDING or head.startswith(PART_START):
        return _part(path, file)
    return FileCheck(path, "unknown", UNCHECKABLE)


def _table(path: Path, file: BufferedReader) -> FileCheck:
    from camopt.storage.damage import TableFault, open_table

    try:
        rows = open_table(file).metadata.num_rows
    except TableFault as fault:
        return FileCheck(path, "damaged" if fault.damaged else "unknown", str(fault))
    return FileCheck(path, "whole", f"whole, {rows:,} row{'s' * (rows != 1)}", rows)


def _part(path: Path, file: BufferedReader) -> FileCheck:
    damage = damage_of(file)
    return FileCheck(path, "damaged" if damage else "whole", damage or "whole")


def _by_manifest(own: FileCheck, file: BufferedReader, fact: Fact) -> FileCheck:
    """What the manifest says of a file, after what it says of itself."""
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    if size == fact.bytes and file_digest(file, "sha256").hexdigest() == fact.sha256:
        return own if own.is_whole else FileCheck(own.file, "whole", "whole")
    if own.is_whole:
        return FileCheck(own.file, "changed", f"whole, but not the one that {MANIFEST} names: it is of another run")
    sizes = "" if size == fact.bytes else f": {size:,} bytes, where {fact.bytes:,} were written"
    told = f"changed or damaged since it was written{sizes}" if own.told == UNCHECKABLE else own.told
    return FileCheck(own.file, "changed", told)
