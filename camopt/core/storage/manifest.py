"""The manifest of a folder: the files in the result of each command, with their digests.

A command writes the manifest last. So a file that it does not name, or whose digest differs, is from another run or
damaged, and is refused.
"""

import json
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from hashlib import file_digest, sha256
from io import BufferedReader
from pathlib import Path
from typing import Any, NamedTuple

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.storage.files import open_regular_file, read_bytes
from camopt.core.storage.version import VERSION

MANIFEST = "manifest.json"
PARQUET_SUFFIX = ".parquet"
"""Suffix of tables. Nobody edits tables, so a changed one is damaged."""
MANIFEST_MARKS = b'"camopt"', b'"results"', b'"digest"'
DIGEST_TEXT, FILE_NAME = re.compile(r"[0-9a-f]{64}"), re.compile(r"[^./\\\0][^/\\\0]*")


class FileEntry(NamedTuple):
    """Digest and size of a file, as its manifest has them."""

    sha256: str
    bytes: int


class CommandResult(NamedTuple):
    """The result of one command."""

    files: Mapping[str, FileEntry]
    """Entries by file name; empty for a result without files."""
    question: Any = None
    """Question to the command, as JSON; None if unknown, or if another command has replaced a file."""
    answer: Any = None
    """Answer of the command about its result, as JSON."""


@dataclass(frozen=True)
class Manifest:
    """All results in a folder, by command, and the version of camopt that wrote the last one."""

    results: Mapping[str, CommandResult] = field(default_factory=dict)
    camopt: str = VERSION

    def with_result(self, command: str, result: CommandResult) -> "Manifest":
        """The manifest with a new result of a command. Files with the same names leave other commands' results."""
        results = {}
        for name, other in self.results.items():
            remaining = {file: entry for file, entry in other.files.items() if file not in result.files}
            results[name] = other if len(remaining) == len(other.files) else CommandResult(remaining)
        return Manifest({**results, command: result})

    @property
    def files(self) -> dict[str, FileEntry]:
        """Entries of all results' files, by name."""
        return {name: entry for result in self.results.values() for name, entry in result.files.items()}

    def to_json(self) -> str:
        """Text of the manifest, with a digest of itself."""
        about = {
            "camopt": self.camopt,
            "results": {n: _result_without_missing_fields(self.results[n]) for n in sorted(self.results)},
        }
        digest = sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()
        return json.dumps({**about, "digest": digest}, indent=1) + "\n"


def _result_without_missing_fields(result: CommandResult) -> dict[str, Any]:
    """A result for JSON, without the fields that are None."""
    plain = result._asdict() | {"files": {name: entry._asdict() for name, entry in result.files.items()}}
    return {name: value for name, value in plain.items() if value is not None}


class DamagedManifest(BadInput):
    """A manifest of camopt was changed, is empty or no JSON, or is from an older version."""


def read_manifest(folder: str | os.PathLike[str]) -> Manifest | None:
    """Read the manifest of a folder; None if there is none, or it belongs to another program.

    Raises
    ------
    DamagedManifest
        If it was changed since camopt wrote it.
    OSError
        If it cannot be read.
    """
    path = Path(folder) / MANIFEST
    try:
        data = read_bytes(path)
        about = json.loads(data)
        results = {str(command): _parse_result(**facts) for command, facts in about["results"].items()}
        manifest = Manifest(results, str(about["camopt"]))
        if manifest.to_json().encode() == data:
            return manifest
    except (FileNotFoundError, BadInput):  # no file, a pipe, or a file longer than any manifest of camopt
        return None
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        if sum(mark in data for mark in MANIFEST_MARKS) < 2 and _is_json(data):
            return None
    why = "a manifest that this version of camopt wrote; this one is damaged, or of another version"
    raise DamagedManifest([Mistake("camopt", "file", str(path), why)])


def _is_json(data: bytes) -> bool:
    try:
        json.loads(data)
    except ValueError:
        return False
    except RecursionError:  # too deep for this parser
        return True
    return True


def _parse_result(files: Any, question: Any = None, answer: Any = None) -> CommandResult:
    """Read a result from JSON; raise ValueError or TypeError for a wrong form, or a file outside the folder."""
    entries = {name: FileEntry(**entry) for name, entry in files.items()}
    valid = all(DIGEST_TEXT.fullmatch(entry.sha256) and type(entry.bytes) is int for entry in entries.values())
    if not valid or not all(map(FILE_NAME.fullmatch, entries)):
        raise ValueError
    return CommandResult(entries, question, answer)


def read_manifest_or_empty(folder: Path) -> Manifest:
    """Read the manifest of a folder.

    An empty one if it is missing or damaged. Raise OSError if the file cannot be read.
    """
    try:
        return read_manifest(folder) or Manifest()
    except DamagedManifest:
        return Manifest()


def file_entry(file: BufferedReader) -> FileEntry:
    """Entry of an open file. The file is read whole, and then set to its start."""
    file.seek(0)
    digest = file_digest(file, "sha256").hexdigest()
    size = file.tell()
    file.seek(0)
    return FileEntry(digest, size)


def file_matches_entry(path: Path, entry: FileEntry) -> bool:
    """Whether a file exists and matches its entry. OSError if it cannot be read."""
    try:
        with open_regular_file(path) as file:
            return os.fstat(file.fileno()).st_size == entry.bytes and file_entry(file) == entry
    except (BadInput, FileNotFoundError, NotADirectoryError):
        return False


def result_paths(folder: Path, pattern: str, manifest: Manifest | None) -> list[Path]:
    """Files of a folder that match a pattern, sorted by name; only those of the manifest, if there is one."""
    names = manifest.files if manifest else [path.name for path in folder.glob("*")]
    return [folder / name for name in sorted(names) if fnmatchcase(name, pattern)]


@contextmanager
def open_checked_result_file(
    path: str | os.PathLike[str], manifest: Manifest | None = None
) -> Iterator[BufferedReader]:
    """Open a file for reading, checked against the manifest beside it, if there is one.

    Parameters
    ----------
    path : str or os.PathLike
        The file.
    manifest : Manifest, optional
        Manifest of the folder, if several files must be from one run.

    Raises
    ------
    BadInput
        If the manifest does not name the file, has another digest for it, or is damaged. Also the errors of
        ``open_regular_file``.
    OSError
        If there is no such file, or it cannot be read.
    """
    with open_regular_file(path) as file:
        manifest = manifest or read_manifest(Path(path).parent)
        if manifest and (why := _manifest_fault(Path(path).name, file, manifest)):
            raise BadInput([Mistake("camopt", "file", os.fsdecode(path), why, bare=True)])
        yield file


def _manifest_fault(name: str, file: BufferedReader, manifest: Manifest) -> str:
    """Why a file does not match the manifest; empty if it does."""
    entry = manifest.files.get(name)
    if entry is None:
        return (
            f"{MANIFEST} beside it does not name it, so it is of another run; move it to another folder to read it"
        )
    if file_entry(file) == entry:
        return ""
    return f"it differs from the file that {MANIFEST} names: it is damaged, was changed, or is from another run"
