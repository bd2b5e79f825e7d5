"""The manifest of a folder: which files the result of each command has, with digests.

A command publishes its files by writing the manifest, and then gives them their names. If it dies in between, the
manifest is right, and the files wait for their names in a folder of their own under ``.camopt``.
"""

import json
import os
import re
from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import lru_cache
from hashlib import file_digest, sha256
from io import BufferedReader
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from camopt.mistakes import BadInput, Mistake
from camopt.storage.files import WORK_FOLDER, read_bytes, regular_file
from camopt.storage.version import VERSION

PathLike = TypeVar("PathLike", bound=str | os.PathLike[str])
Outcome = TypeVar("Outcome")

MANIFEST = "manifest.json"
READ_TRIES = 3
"""To read what others publish meanwhile."""
MARKS = b'"camopt"', b'"results"', b'"digest"'
RUN_NAME, DIGEST_TEXT, FILE_NAME = (
    re.compile(text) for text in (r"[0-9a-f]{16}", r"[0-9a-f]{64}", r"[^./\\\0][^/\\\0]*")
)


class Fact(NamedTuple):
    """A manifest's record of a file."""

    sha256: str
    bytes: int


class RunResult(NamedTuple):
    """The result of one command."""

    run: str
    """What tells it from other results: runs with the same files are the same."""
    files: Mapping[str, Fact]
    """By name; a result with nothing found has none."""
    replaces: tuple[str, ...] = ()
    """Names of files that go: earlier results had them, and this one has not."""
    question: Any = None
    """What was asked, as JSON has it; None if nothing tells, or another command took over a file."""
    answer: Any = None
    """What the command says of its result, as JSON has it."""

    def without(self, names: Container[str]) -> "RunResult":
        """The result without the files that another one has taken over; it is then incomplete."""
        kept = {name: fact for name, fact in self.files.items() if name not in names}
        return self if len(kept) == len(self.files) else RunResult(self.run, kept, self.replaces)

    def waiting(self, folder: Path, name: str = "") -> Path:
        """The path where a file waits for its final name."""
        return folder / WORK_FOLDER / self.run / name


@dataclass(frozen=True)
class Manifest:
    """All results in a folder, by command, and the version of camopt that wrote the last one."""

    results: Mapping[str, RunResult] = field(default_factory=dict)
    camopt: str = VERSION

    def with_result(self, command: str, result: RunResult) -> "Manifest":
        """The manifest with another result of a command, which takes over names of files that others have."""
        others = {each: other.without(result.files) for each, other in self.results.items()}
        return Manifest({**others, command: result})

    @property
    def files(self) -> dict[str, Fact]:
        """The files of all results, by name."""
        return {name: fact for result in self.results.values() for name, fact in result.files.items()}

    def others(self, command: str) -> set[str]:
        """Names of files of other commands."""
        return {name for each, result in self.results.items() if each != command for name in result.files}

    def to_json(self) -> str:
        """The text of the file, with a digest of itself."""
        about = {
            "camopt": self.camopt,
            "results": {name: _plain(self.results[name]) for name in sorted(self.results)},
        }
        return json.dumps({**about, "digest": _digest(about)}, indent=1) + "\n"


def _plain(result: RunResult) -> dict[str, Any]:
    """A result for JSON, without unknown fields."""
    plain = result._asdict() | {"files": {name: fact._asdict() for name, fact in result.files.items()}}
    return {name: value for name, value in plain.items() if value is not None}


class Damaged(BadInput):
    """A damaged manifest of camopt; also one that is empty, or no JSON."""


def run_of(command: str, files: Mapping[str, Fact]) -> str:
    """The run of a command that wrote some files."""
    named = sorted((name, fact.sha256) for name, fact in files.items())
    return sha256(repr((command, named)).encode()).hexdigest()[:16]


def _digest(about: dict[str, Any]) -> str:
    return sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()


def manifest_of(folder: str | os.PathLike[str]) -> Manifest | None:
    """The manifest of a folder; None if there is none.

    Raises
    ------
    Damaged
        If it is not as it was written.
    BadInput
        If it is another program's: JSON that camopt did not write.
    OSError
        If it cannot be read.
    """
    path = Path(folder) / MANIFEST
    try:
        data = read_bytes(path)
    except FileNotFoundError:
        return None
    try:
        return _parsed(data)
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        ours = sum(mark in data for mark in MARKS) > 1 or not _is_json(data)  # one of them may be damaged
        kind, what = (Damaged, "this is damaged") if ours else (BadInput, "this is another program's")
        raise kind([Mistake("camopt", "file", str(path), f"the manifest that camopt wrote; {what}")]) from None


@lru_cache(maxsize=1)  # who publishes reads it several times
def _parsed(data: bytes) -> Manifest:
    """The manifest of a file's content; an error if it is not as it was written."""
    about = json.loads(data)
    results = {str(command): _result(**facts) for command, facts in about["results"].items()}
    manifest = Manifest(results, str(about["camopt"]))
    if manifest.to_json().encode() != data:
        raise ValueError
    return manifest


def _is_json(data: bytes) -> bool:
    try:
        json.loads(data)
    except RecursionError:  # too deep for this one to tell
        return True
    except ValueError:
        return False
    return True


def _result(run: Any, files: Any, replaces: Any, question: Any = None, answer: Any = None) -> RunResult:
    """A result as it was written: its names are of files in its folder. ValueError or TypeError if it is odd."""
    facts = {name: Fact(**fact) for name, fact in files.items()}
    names = RUN_NAME.fullmatch(run) and all(FILE_NAME.fullmatch(name) for name in (*facts, *replaces))
    if not names or not all(DIGEST_TEXT.fullmatch(f.sha256) and type(f.bytes) is int for f in facts.values()):
        raise ValueError
    return RunResult(run, facts, tuple(replaces), question, answer)


def settled_path(path: PathLike) -> PathLike | Path:
    """The file to read for a path: the one that still waits for that name, if a command died before renaming it.

    Where the manifest is damaged, the path itself.
    """
    folder, name = Path(path).parent, Path(path).name
    if os.path.isdir(folder / WORK_FOLDER):
        for result in _unplaced(folder):
            waiting = result.waiting(folder, name)
            if waiting.exists() or name in result.replaces:
                return waiting
    return path


def settled_paths(folder: Path, pattern: str) -> list[Path]:
    """The files of a folder whose names match a pattern, sorted by name, as ``settled_path`` finds them."""
    names = {path.name for path in folder.glob(pattern)}
    names |= {name for result in _unplaced(folder) for name in result.files if fnmatchcase(name, pattern)}
    return [path for path in (settled_path(folder / name) for name in sorted(names)) if path.exists()]


@contextmanager
def settled_file(path: str | os.PathLike[str]) -> Iterator[BufferedReader]:
    """A file to read, which ``settled_path`` finds; errors are those of ``regular_file``."""
    with ExitStack() as stack:
        yield _tried(lambda: stack.enter_context(regular_file(settled_path(path))))


def of_one_run(folder: Path, read: Callable[[], Outcome]) -> Outcome:
    """Read several files of a folder, again if another result was published meanwhile.

    If that goes on and on, it is what was read last.
    """
    for _ in range(READ_TRIES):
        before, found = _known(folder), _tried(read)
        if _known(folder) == before:
            break
    return found


def _tried(read: Callable[[], Outcome]) -> Outcome:
    """Read a file, with retries if it is missing: it may be renamed at this moment."""
    for _ in range(READ_TRIES):
        with suppress(FileNotFoundError):
            return read()
    return read()


def command_of(path: Path) -> str | None:
    """The command whose result has a file, by the manifest."""
    results = _known(path.parent).results
    return next((command for command, result in results.items() if path.name in result.files), None)


def has_result(folder: Path, command: str) -> bool:
    """Whether a folder has a result of a command, by its manifest."""
    return command in _known(folder).results


def question_in(folder: Path, command: str) -> Any:
    """The question that a command's result in a folder answers, by its manifest; None if there is none."""
    result = _known(folder).results.get(command)
    return result and result.question


def answer_in(folder: Path, command: str, asked: Callable[[RunResult], bool]) -> Any:
    """What a command said of its result in a folder; None if it was not what is asked, or a file is damaged."""
    result = _known(folder).results.get(command)
    if result is None or not asked(result):
        return None
    try:
        whole = all(fact_of(settled_path(folder / name)) == fact for name, fact in result.files.items())
    except (BadInput, OSError):
        return None
    return result.answer if whole else None


def fact_of(path: Path) -> Fact:
    """The record of a file as it is now; errors are those of ``regular_file``."""
    with regular_file(path) as file:
        return Fact(file_digest(file, "sha256").hexdigest(), os.fstat(file.fileno()).st_size)


def _unplaced(folder: Path) -> Iterator[RunResult]:
    """Results with files that still wait for their names."""
    return (result for result in _known(folder).results.values() if result.waiting(folder).is_dir())


def _known(folder: Path) -> Manifest:
    """The manifest of a folder, if there is a readable one."""
    try:
        return manifest_of(folder) or Manifest()
    except (BadInput, OSError):
        return Manifest()


def manifest_to_renew(folder: Path) -> Manifest:
    """The manifest of a folder; a new one if there is none, or it is damaged. That of another program stays."""
    try:
        return manifest_of(folder) or Manifest()
    except Damaged:
        return Manifest()
