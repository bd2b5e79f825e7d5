"""Faults of a file system: a call that fails, a process that is killed before one or after so long, a power cut.

Calls are those of Python on files of one folder: open, write, fsync, rename, unlink, mkdir, rmdir, chmod, truncate.
"""

import builtins
import io
import os
import pickle
import signal
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from errno import EIO, ENOSPC
from functools import partial
from itertools import chain, combinations
from pathlib import Path
from random import Random
from tempfile import TemporaryFile
from traceback import print_exc
from typing import Any, NamedTuple
from unittest.mock import patch

PATHS = ("open", "replace", "rename", "link", "unlink", "remove", "mkdir", "rmdir", "chmod")
DESCRIPTORS = ("write", "fsync")
GROWING = {"open for writing", "write", "fsync", "mkdir"}
"""Calls that a full disk fails."""
FAULTS = ("killed", "torn", "interrupted", "EIO", "ENOSPC", "full")
"""A call ends the process, or does so after half of its bytes, or is interrupted, or fails; or the disk is full."""

Told = Callable[..., None]


@contextmanager
def watch_calls(folder: Path, before: Told, after: Told = lambda *_: None) -> Iterator[None]:
    """``before`` is told of each call on files in a folder, with its arguments, and ``after`` when it is done.

    Nothing is synced, which takes long.
    """
    known: set[int] = set()
    real = {name: getattr(os, name) for name in (*PATHS, *DESCRIPTORS)} | {"fsync": lambda descriptor: None}
    real_open = io.open

    def mine(path: Any, dir_fd: int | None = None) -> bool:
        return dir_fd in known or Path(os.path.abspath(os.fsdecode(path))).is_relative_to(folder)

    def by_path(name: str, path: Any, *others: Any, **options: Any) -> Any:
        if not mine(path, options.get("dir_fd")):
            return real[name](path, *others, **options)
        creates = name == "open" and others[0] & os.O_CREAT
        before("open for writing" if creates else name, path)
        result = real[name](path, *others, **options)
        if name == "open":
            known.add(result)
        after(name, path)
        return result

    def by_descriptor(name: str, descriptor: int, *others: Any) -> Any:
        if descriptor not in known:
            return real[name](descriptor, *others)
        before(name, descriptor, *others)
        result = real[name](descriptor, *others)
        after(name, descriptor)
        return result

    class Raw(io.FileIO):
        def write(self, data: Any) -> int:
            before("write", self.fileno(), data)
            return super().write(data)

        def truncate(self, size: int | None = None) -> int:
            before("ftruncate", self.fileno())
            return super().truncate(size)

    def opened(
        file: Any, mode: str = "r", buffering: int = -1, encoding: Any = None, *others: Any, **options: Any
    ) -> Any:
        if isinstance(file, int) or not mine(file):
            return real_open(file, mode, buffering, encoding, *others, **options)
        if not {*mode} & {*"wax+"}:
            before("open", file)
            return real_open(file, mode, buffering, encoding, *others, **options)
        before("open for writing", file)
        raw = Raw(file, mode.replace("b", "").replace("t", ""), opener=options.get("opener"))
        binary = raw if buffering == 0 else io.BufferedRandom(raw) if "+" in mode else io.BufferedWriter(raw)
        after("open", file)
        return binary if "b" in mode else io.TextIOWrapper(binary, encoding, *others, **options)

    calls = {name: partial(by_path, name) for name in PATHS} | {n: partial(by_descriptor, n) for n in DESCRIPTORS}
    with patch.multiple(os, **calls), patch.object(io, "open", opened), patch.object(builtins, "open", opened):
        yield


def calls_of(folder: Path, work: Callable[[], Any]) -> list[str]:
    """The calls of some work on files in a folder."""
    calls: list[str] = []
    with watch_calls(folder, lambda call, *_: calls.append(call)):
        work()
    return calls


class End(NamedTuple):
    """How work in a process of its own ended: its exit code (that of a signal is negative), words and result."""

    code: int
    said: str
    result: Any


def run_forked(work: Callable[[], Any]) -> End:
    """Do some work in a process of its own, whose exit code is the number that the work returns, or else 0."""
    with TemporaryFile("w+") as said, TemporaryFile() as results, warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads, which the child does not touch
        child = os.fork()
        if not child:
            code = 70
            try:
                sys.stdout = sys.stderr = said
                result = work()
                code = result if isinstance(result, int) else pickle.dump(result, results) or 0
            except (OSError, KeyboardInterrupt) as end:
                print(f"{type(end).__name__}: {end}")
                code = 3
            except BaseException:
                print_exc()
            finally:
                said.flush()
                results.flush()
                os._exit(code)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        has_result = results.seek(0, os.SEEK_END)
        said.seek(0), results.seek(0)
        return End(code, said.read(), pickle.load(results) if has_result else None)


def with_fault(folder: Path, work: Callable[[], Any], number: int, fault: str) -> End:
    """Do some work, in a process of its own, with a fault at one of its calls on files in a folder.

    With the fault "blind" it is killed after so many milliseconds of CPU time.
    """
    count = 0

    def before(call: str, what: Any, *data: Any) -> None:
        nonlocal count
        here, full = count == number, fault == "full" and count >= number and call in GROWING
        count += 1
        if here and fault == "torn" and call == "write":
            real_write(what, bytes(data[0])[: len(data[0]) // 2])
        if here and fault in ("killed", "torn"):
            os.kill(os.getpid(), signal.SIGKILL)
        if here and fault == "interrupted":
            raise KeyboardInterrupt
        if full or (here and fault in ("EIO", "ENOSPC")):
            code = EIO if fault == "EIO" else ENOSPC
            raise OSError(code, os.strerror(code), *([] if isinstance(what, int) else [os.fspath(what)]))

    def faulty() -> Any:
        if fault == "blind":
            signal.signal(signal.SIGPROF, signal.SIG_DFL)
            signal.setitimer(signal.ITIMER_PROF, number / 1000)
            return work()
        with watch_calls(folder, before):
            return work()

    real_write = os.write
    return run_forked(faulty)


Tree = dict[str, bytes | None]
"""What is in a folder by relative path; folders have no content."""


def tree_of(folder: Path) -> Tree:
    """A folder as it is."""
    paths = sorted(folder.rglob("*")) if folder.is_dir() else []
    return {str(path.relative_to(folder)): None if path.is_dir() else path.read_bytes() for path in paths}


def make(folder: Path, tree: Tree) -> None:
    """A folder with nothing else in it than a tree."""
    for path in sorted(folder.rglob("*"), reverse=True):
        path.rmdir() if path.is_dir() else path.unlink()
    folder.mkdir(exist_ok=True)
    for name, content in sorted(tree.items()):
        if content is None:
            (folder / name).mkdir()
        else:
            (folder / name).write_bytes(content)


RENAMES = {"replace", "rename"}
Place = tuple[int, str]
"""A folder by its number, and a name in it."""
LEFT: dict[str, Callable[[bytes, bytes], bytes]] = {
    "lost": lambda synced, now: synced,
    "whole": lambda synced, now: now,
    "half": lambda synced, now: now[: len(now) // 2],
    "zeros": lambda synced, now: synced[: len(now)] + bytes(max(len(now) - len(synced), 0)),
}
"""What a power cut may leave of the content of a file that was written to since its last sync."""


def _subsets(groups: list[set[Place]]) -> Iterator[Iterable[set[Place]]]:
    """All subsets of a few groups; of many, as many at random, with none and all of them."""
    if len(groups) <= 6:
        yield from chain.from_iterable(combinations(groups, count) for count in range(len(groups) + 1))
        return
    draw = Random(len(groups))
    yield from ([], groups, *([each for each in groups if draw.random() < 0.5] for _ in range(62)))


class Disk:
    """What of a folder is on the disk for sure: contents of files, and names in folders, as of their last sync."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._ids: dict[int, int] = {}
        self._renamed: dict[Place, Place] = {}
        """Old names by new ones, as of the last sync."""
        self._count = 0
        self.contents: dict[int, bytes] = {}
        self.today: dict[int, bytes] = {}
        """Contents as other programs see them now."""
        self.names: dict[int, dict[str, int]] = {}
        self.now: dict[int, dict[str, int] | None] = {}
        """Of each folder the names in it; None of each file."""
        self._look()
        for path in (root, *root.rglob("*")):
            self._sync(path)

    def after(self, call: str, what: Any) -> None:
        """Look at what a call has done."""
        before = self._places() if call in RENAMES else {}
        self._look()
        if before:
            self._pair(before, self._places())
        if call == "fsync":
            self._sync(Path(f"/proc/self/fd/{what}").resolve())

    def _places(self) -> dict[Place, int]:
        return {(f, name): number for f, names in self.now.items() if names for name, number in names.items()}

    def _pair(self, before: dict[Place, int], here: dict[Place, int]) -> None:
        """Find out which name became which."""
        old = next(place for place in before if place not in here)
        new = next(place for place, number in here.items() if number == before[old] != before.get(place))
        self._renamed[new] = self._renamed.pop(old, old)

    def _id(self, path: Path) -> int:
        inode = path.stat().st_ino
        if inode not in self._ids:
            self._ids[inode] = self._count
            self._count += 1
        return self._ids[inode]

    def _look(self) -> None:
        paths = [self.root, *self.root.rglob("*")]
        inodes = {path.stat().st_ino for path in paths}
        self._ids = {inode: number for inode, number in self._ids.items() if inode in inodes}  # or used again
        self.now = {
            self._id(path): {each.name: self._id(each) for each in path.iterdir()} if path.is_dir() else None
            for path in paths
        }
        self.today = {self._id(path): path.read_bytes() for path in paths if path.is_file()}
        self.top = self._id(self.root)

    def _sync(self, path: Path) -> None:
        number, names = self._id(path), self.now[self._id(path)]
        if names is None:
            self.contents[number] = path.read_bytes()
        else:
            self.names[number] = names
            pairs = self._renamed.items()
            self._renamed = {new: old for new, old in pairs if number not in (new[0], old[0])}

    def after_power_cuts(self) -> Iterator[Tree]:
        """What a power cut may leave: any names that changed since the last sync; of a rename both, or none.

        Of files that were written to since, any of what ``LEFT`` says.
        """
        names = {number: names for number, names in self.now.items() if names is not None}
        changed = [
            (number, name)
            for number, today in names.items()
            for name in sorted({*today, *self.names.get(number, {})})
            if today.get(name) != self.names.get(number, {}).get(name)
        ]
        pairs = [{*pair} for pair in self._renamed.items() if {*pair} <= {*changed}]
        paired = {place for pair in pairs for place in pair}
        for chosen in _subsets([*pairs, *({place} for place in changed if place not in paired)]):
            late: set[Place] = set().union(*chosen)
            if all(len(pair & late) != 1 for pair in pairs):
                found = dict(self._below(self.top, "", late))
                open_to_loss = {*found.values()} & self._unsynced()
                for left in LEFT if open_to_loss else ("lost",):
                    yield {name: self._content(number, LEFT[left]) for name, number in found.items()}

    def _unsynced(self) -> set[int]:
        return {number for number, now in self.today.items() if self.contents.get(number, b"") != now}

    def _below(self, number: int, prefix: str, late: set[tuple[int, str]]) -> Iterator[tuple[str, int]]:
        """Numbers by relative path: as of now for some names in folders, and else as of the last sync."""
        synced, today = self.names.get(number, {}), self.now.get(number) or {}
        for name in sorted({*synced, *today}):
            each = (today if (number, name) in late else synced).get(name)
            if each is not None:
                yield f"{prefix}{name}", each
                yield from self._below(each, f"{prefix}{name}/", late)

    def _content(self, number: int, left: Callable[[bytes, bytes], bytes]) -> bytes | None:
        """Of a file that has no name any more, what was synced."""
        if number in self.names or self.now.get(number) is not None:
            return None
        synced = self.contents.get(number, b"")
        return left(synced, self.today[number]) if number in self._unsynced() else synced
