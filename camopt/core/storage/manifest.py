"""The manifest of a folder: which files the result of each command has, with their digests.

A command writes it last. So a file that it does not name, or that differs from what it names, is of another run, or
damaged, and is refused.
"""

import json
import os
import re
from collections.abc import Container, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from hashlib import file_digest, sha256
from io import BufferedReader
from pathlib import Path
from typing import Any, NamedTuple

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.storage.files import read_bytes, regular_file
from camopt.core.storage.version import VERSION

MANIFEST = "manifest.json"
PARQUET_SUFFIX = ".parquet"
"""The ending of tables, which nobody edits: those that are not as they were written are damaged."""
MANIFEST_MARKS = b'"camopt"', b'"results"', b'"digest"'
DIGEST_TEXT, FILE_NAME = re.compile(r"[0-9a-f]{64}"), re.compile(r"[^./\\\0][^/\\\0]*")


class FileEntry(NamedTuple):
    """What a manifest says of a file."""

    sha256: str
    bytes: int


class CommandResult(NamedTuple):
    """The result of one command."""

    files: Mapping[str, FileEntry]
    """By name; a result with nothing found has none."""
    question: Any = None
    """What was asked, as JSON has it; None if nothing tells, or another command took over a file."""
    answer: Any = None
    """What the command says of its result, as JSON has it."""


@dataclass(frozen=True)
class Manifest:
    """All results in a folder, by command, and the version of camopt that wrote the last one."""

    results: Mapping[str, CommandResult] = field(default_factory=dict)
    camopt: str = VERSION

    def with_result(self, command: str, result: CommandResult) -> "Manifest":
        """The manifest with another result of a command, which takes over names of files that others have."""
        others = {each: _drop_files(other, result.files) for each, other in self.results.items()}
        return Manifest({**others, command: result})

    @property
    def files(self) -> dict[str, FileEntry]:
        """The files of all results, by name."""
        return {name: entry for result in self.results.values() for name, entry in result.files.items()}

    def to_json(self) -> str:
        """The text of the file, with a digest of itself."""
        about = {
            "camopt": self.camopt,
            "results": {n: _result_document(self.results[n]) for n in sorted(self.results)},
        }
        digest = sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()
        return json.dumps({**about, "digest": digest}, indent=1) + "\n"


def _drop_files(result: CommandResult, names: Container[str]) -> CommandResult:
    """A result without the files that another one has taken over; nothing tells then what it was asked."""
    kept = {name: entry for name, entry in result.files.items() if name not in names}
    return result if len(kept) == len(result.files) else CommandResult(kept)


def _result_document(result: CommandResult) -> dict[str, Any]:
    """A result for JSON, without unknown fields."""
    plain = result._asdict() | {"files": {name: entry._asdict() for name, entry in result.files.items()}}
    return {name: value for name, value in plain.items() if value is not None}


class DamagedManifest(BadInput):
    """A manifest of camopt is not as it was written; also one that is empty, no JSON, or of an older camopt."""


def manifest_of(folder: str | os.PathLike[str]) -> Manifest | None:
    """The manifest of a folder; None if there is none, or it is another program's.

    Raises
    ------
    DamagedManifest
        If it is not as it was written.
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
    except (FileNotFoundError, BadInput):  # there is none, or a pipe, or one longer than any that camopt writes
        return None
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        if sum(mark in data for mark in MANIFEST_MARKS) < 2 and _is_json(data):
            return None
    why = "the manifest that this version of camopt wrote; this is damaged, or of another version"
    raise DamagedManifest([Mistake("camopt", "file", str(path), why)])


def _is_json(data: bytes) -> bool:
    try:
        json.loads(data)
    except ValueError:
        return False
    except RecursionError:  # too deep for this one to tell
        return True
    return True


def _parse_result(files: Any, question: Any = None, answer: Any = None) -> CommandResult:
    """A result as it was written: its names are of files in its folder. ValueError or TypeError if it is odd."""
    entries = {name: FileEntry(**entry) for name, entry in files.items()}
    whole = all(DIGEST_TEXT.fullmatch(each.sha256) and type(each.bytes) is int for each in entries.values())
    if not whole or not all(map(FILE_NAME.fullmatch, entries)):
        raise ValueError
    return CommandResult(entries, question, answer)


def readable_manifest(folder: Path) -> Manifest:
    """The manifest of a folder; an empty one if there is none, or it is damaged. OSError if it cannot be read."""
    try:
        return manifest_of(folder) or Manifest()
    except DamagedManifest:
        return Manifest()


def entry_of(file: BufferedReader) -> FileEntry:
    """The entry of an open file as it is now; the file is read from its start to its end, and set to its start."""
    file.seek(0)
    digest = file_digest(file, "sha256").hexdigest()
    size = file.tell()
    file.seek(0)
    return FileEntry(digest, size)


def has_entry(path: Path, entry: FileEntry) -> bool:
    """Whether a file is there, and is as its entry says. OSError if it cannot be read."""
    try:
        with regular_file(path) as file:
            return os.fstat(file.fileno()).st_size == entry.bytes and entry_of(file) == entry
    except (BadInput, FileNotFoundError, NotADirectoryError):
        return False


def result_paths(folder: Path, pattern: str, manifest: Manifest | None) -> list[Path]:
    """The files of a folder whose names match a pattern, sorted by name: those of its manifest, if there is one."""
    names = manifest.files if manifest else [path.name for path in folder.glob("*")]
    return [folder / name for name in sorted(names) if fnmatchcase(name, pattern)]


@contextmanager
def whole_result_file(path: str | os.PathLike[str], manifest: Manifest | None = None) -> Iterator[BufferedReader]:
    """A file to read, as the manifest beside it names it; as it is where there is no manifest.

    Parameters
    ----------
    path : str or os.PathLike
        The file.
    manifest : Manifest, optional
        That of the folder, where several files have to be of one run.

    Raises
    ------
    BadInput
        If the manifest does not name the file, or another one of its name, or is damaged; and as ``regular_file``.
    OSError
        If there is no such file, or it cannot be read.
    """
    with regular_file(path) as file:
        manifest = manifest or manifest_of(Path(path).parent)
        if manifest and (why := _manifest_fault(Path(path).name, file, manifest)):
            raise BadInput([Mistake("camopt", "file", os.fsdecode(path), why, bare=True)])
        yield file


def _manifest_fault(name: str, file: BufferedReader, manifest: Manifest) -> str:
    """What a manifest has against a file; empty if it is the one that it names."""
    entry = manifest.files.get(name)
    if entry is None:
        return f"{MANIFEST} beside it does not name it: it is of another run; it can be read in a folder of its own"
    if entry_of(file) == entry:
        return ""
    return f"it is not the one that {MANIFEST} names: it is damaged, was changed, or is of another run"
