"""Results of several files, published by one rename; a folder is written by one run at a time.

A run writes its files to a folder of its own, ``.camopt/…``. At its end they are synced, and the new manifest
replaces the old one: from then on the new result is valid, as a whole. Then the files of the earlier result are
removed, and the new ones get their names. If the run dies before the manifest is replaced, the earlier result
stays, and the next run removes what was left. If it dies after that, the next run gives the files their names, and
until then readers find them by ``settled_path``.
"""

import os
import platform
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from errno import EAGAIN, ENOENT, ENOTDIR, EXDEV
from fnmatch import fnmatchcase
from functools import partial
from io import FileIO
from pathlib import Path
from stat import S_ISDIR
from typing import Any

from camopt.files import (
    LARGEST_TEXT,
    WORK,
    check_replaceable,
    forgotten,
    keep_mode,
    lock,
    named,
    naming,
    random_name,
    synced,
    target_of,
    tell_untidy,
    whole_file,
)
from camopt.manifest import (
    MANIFEST,
    Damaged,
    Fact,
    Manifest,
    Result,
    answer_in,
    command_of,
    fact_of,
    manifest_of,
    of_one_run,
    run_of,
)
from camopt.mistakes import BadInput, Mistake

LOCK = "lock"
JOURNAL = ".journal"
TABLE, PART = ".parquet", ".sweep"
"""Endings of tables, and of parts of a sweep."""
DATA = (TABLE, PART)
"""Endings of files that nobody edits: those that are not as they were written are damaged, and are replaced."""
TRIES = 100
"""More often, other runs do not remove the folder of a lock while this one opens it."""


@dataclass
class Unit:
    """Files that are published together.

    Attributes
    ----------
    folder : pathlib.Path
        Where they will be.
    work : pathlib.Path
        The folder inside it for what is not finished.
    staging : pathlib.Path
        Where they are written.
    command : str
        What writes them.
    may_write : tuple of str
        Names, or patterns of names.
    stale : tuple of str
        Other names that earlier versions or runs of the command may have written.
    revises : bool
        Whether other files of the result stay.
    question : Any
        What was asked, in what JSON takes; None where nobody asks again.
    answer : Any
        What to tell whoever asks again, in what JSON takes; it is kept if it is set before the end.
    files : tuple of pathlib.Path
        What was published; nothing before the end.
    """

    folder: Path
    work: Path
    staging: Path
    command: str
    may_write: tuple[str, ...]
    stale: tuple[str, ...] = ()
    revises: bool = False
    question: Any = None
    answer: Any = None
    files: tuple[Path, ...] = ()

    @property
    def journal(self) -> Path:
        """Where the command may keep what it has done: it stays if the command fails, and is removed if not."""
        return journal_path(self.folder, self.command)

    def path(self, name: str) -> Path:
        """Where a file is written."""
        if not any(fnmatchcase(name, known) for known in self.may_write):
            raise KeyError(f"{name} is none of {', '.join(self.may_write)}")
        return self.staging / name


def journal_path(folder: Path, command: str) -> Path:
    """Where a command keeps what it has done of a result in a folder."""
    return folder / WORK / f"{command}{JOURNAL}"


@contextmanager
def published(
    folder: str | os.PathLike[str],
    command: str,
    may_write: tuple[str, ...],
    *,
    stale: tuple[str, ...] = (),
    revises: bool = False,
    question: Any = None,
) -> Iterator[Unit]:
    """A result of several files in a folder: it replaces the earlier one if the block ends well.

    Tables of the user, and texts that were edited, stay; where they would be replaced, the result is refused.

    Parameters
    ----------
    folder : str or os.PathLike
        It is made if there is none, and goes again if nothing is in it at the end.
    command : str
        Whose earlier result is replaced; results of other commands stay.
    may_write : tuple of str
        Names, or patterns such as ``optimum-*.toml``. Files with such a name (not those that only match a pattern)
        are taken for an earlier result where there is no manifest, unless they are tables of another program.
    stale : tuple of str, default ()
        Names of files, taken for an earlier result likewise, that the block does not write.
    revises : bool, default False
        Whether files of the earlier result that the block does not write stay; so does what it answers.
    question : Any, optional
        What is asked, in what JSON takes: the next run gets the ``answer`` of the unit by ``answered``.

    Raises
    ------
    OSError
        If a file cannot be written, or another run has the folder.
    BadInput
        If a file of another program has the name of the manifest, or one of the user that of a file of the
        result, or a file of the earlier result was edited; for an empty ``folder``.

    Warns
    -----
    Untidy
        If the result is published, and something failed after that.
    """
    folder = _folder_of(folder)
    with _made(folder) as made, _held(folder) as (work, alone):
        unit = Unit(folder, work, work / random_name(), command, may_write, stale, revises, question)
        try:
            _settle(folder, work, alone)
            _check_own(unit, _exact(may_write))
            unit.staging.mkdir()
            yield unit
            _commit(unit, made)
            _tidy_up(unit, alone)
        except BaseException as end:
            with suppress(OSError):
                _clear(unit, alone)
            if isinstance(end, OSError):
                _raise_of_result(end, unit)
            raise


def _folder_of(folder: str | os.PathLike[str]) -> Path:
    if not os.fspath(folder):  # as the shell gives a variable that is not set; a Path would be the current folder
        raise BadInput([Mistake("camopt", "out", "", "a folder; it is empty")])
    return Path(folder)


def answered(
    folder: str | os.PathLike[str],
    command: str,
    question: Any,
    is_spent: Callable[[Path], bool] = lambda journal: False,
) -> Any:
    """The answer to a question that is in a folder already: of the same command, with all files whole; None if not.

    What a run left that died after it had published is put in order: files get their names, and the journal goes if
    ``is_spent`` says that it is that of the result.

    Raises
    ------
    OSError
        If another run has the folder, or it cannot be put in order.
    BadInput
        For an empty ``folder``.
    """
    folder = _folder_of(folder)
    if not (folder / WORK).is_dir():
        return of_one_run(folder, partial(answer_in, folder, command, question))
    with _held(folder) as (work, alone):
        _settle(folder, work, alone)
        answer, journal = answer_in(folder, command, question), journal_path(folder, command)
        if answer is not None and is_spent(journal):
            _remove(journal)
        return answer


def already_done(folder: str | os.PathLike[str]) -> str:
    """What is said where a folder has the answer already."""
    what = f"already done: {os.fspath(folder)} has the whole result of the same question and version"
    return f"{what}; `again` computes it anew"


@contextmanager
def revised(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Where to write a file anew: as a part of the result that has it, or the path itself if none has.

    Raises
    ------
    OSError
        If the file cannot be written, or another run writes to the folder.
    """
    path = Path(path)
    command = command_of(path)
    if command is None:
        yield path
    else:
        with published(path.parent, command, (path.name,), revises=True) as unit:
            yield unit.path(path.name)


def _tidy_up(unit: Unit, alone: bool) -> None:
    """What is left to do once a result is published. Trouble does not undo it, and is told.

    Raises
    ------
    OSError
        If the files did not get their names, not even at a second try: camopt finds them, other programs do not.
    """
    steps = [partial(synced, unit.folder), partial(_clear, unit, alone)]
    steps += [] if unit.revises else [partial(_remove, unit.journal)]
    troubles = [*_tried(steps)]
    if not troubles:
        return
    troubles += _tried(steps)
    if any(unit.staging.glob("*")):
        why = f"published, but its files wait for their names, which the next run gives: {troubles[0].strerror}"
        raise named(troubles[0], why, unit.folder)
    tell_untidy(troubles[0], unit.folder)


def _tried(calls: Iterable[Callable[[], None]]) -> Iterator[OSError]:
    """Make some calls, each whatever the others do; their troubles."""
    for call in calls:
        try:
            call()
        except OSError as trouble:
            yield trouble


def _clear(unit: Unit, alone: bool) -> None:
    """Settle the folder, and remove what was not published."""
    _settle(unit.folder, unit.work, alone)
    _remove(unit.staging)


def _raise_of_result(trouble: OSError, unit: Unit) -> None:
    """Say which file of the result cannot be written; where it was being written is nobody's concern."""
    if isinstance(trouble.filename, str) and Path(trouble.filename).is_relative_to(unit.work):
        name = Path(trouble.filename).name
        meant = unit.folder / name if any(fnmatchcase(name, known) for known in unit.may_write) else unit.folder
        raise named(trouble, trouble.strerror or str(trouble), meant) from None


@contextmanager
def _made(folder: Path) -> Iterator[list[Path]]:
    """The folder and those above it that had to be made; they go again if nothing is in them at the end."""
    made = [each for each in (folder, *folder.parents) if not each.exists()]
    try:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except FileExistsError as trouble:
            raise named(trouble, "this is neither a folder nor a link to one", Path(trouble.filename)) from None
        yield made
    finally:
        with suppress(OSError):  # there is something in it
            for each in made:
                each.rmdir()


@contextmanager
def _held(folder: Path) -> Iterator[tuple[Path, bool]]:
    """The folder for what is not finished, held by this process; and whether no other one can have it.

    The lock is that of the open file, which the system lets go when the process dies. The file goes at the end, so
    one that was opened just before and got the lock just after has no name any more: then again.
    """
    work = folder / WORK
    path = work / LOCK
    with ExitStack() as stack:
        stack.callback(_quietly, work.rmdir)  # if there is no journal in it
        while True:
            file = stack.enter_context(_opened(folder, work, path))
            held = lock(file.fileno())
            if held is False:
                _refuse(file, folder)
            if held is None or _same(file, path):
                break
            file.close()
        if held is None:  # Windows removes no open files
            file.close()
        stack.callback(_quietly, path.unlink)
        if held:
            _quietly(file.truncate, 0)
            _quietly(file.write, f"process {os.getpid()} on {platform.node()}".encode())
        yield work, bool(held)


def _opened(folder: Path, work: Path, path: Path) -> FileIO:
    """The file of the lock, made if there is none."""
    for _ in range(TRIES):
        with naming(folder, work, path), suppress(FileExistsError):
            work.mkdir()
        with suppress(FileNotFoundError):  # another run has just removed the folder
            if not S_ISDIR(work.lstat().st_mode):
                raise NotADirectoryError(ENOTDIR, os.strerror(ENOTDIR), os.fspath(work))
            with naming(folder, work, path):
                return path.open("a+b", buffering=0)
    raise FileNotFoundError(ENOENT, os.strerror(ENOENT), os.fspath(path))


def _same(file: FileIO, path: Path) -> bool:
    """Whether an open file is still the one of that name."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    except FileNotFoundError:
        return False


def _refuse(file: FileIO, folder: Path) -> None:
    file.seek(0)
    holder = file.read(200).decode(errors="replace") or "another process"
    raise BlockingIOError(EAGAIN, f"another run writes to this folder ({holder})", os.fspath(folder))


def _quietly(call: Callable[..., object], *arguments: object) -> None:
    """Try something that the result does not need."""
    with suppress(OSError):
        call(*arguments)


def _settle(folder: Path, work: Path, alone: bool) -> None:
    """Give the files of published results their names, and remove what dead runs left; journals stay."""
    manifest = _manifest(folder)
    commands = {result.run: command for command, result in manifest.results.items()}
    for left in sorted(work.iterdir()):
        if left.name == LOCK or left.suffix == JOURNAL:
            continue
        if left.name in commands:
            _place(folder, left, manifest, commands[left.name])
        elif alone or forgotten(left):
            _remove(left)


def _manifest(folder: Path) -> Manifest:
    """The manifest of a folder; a new one if there is none, or it is damaged. That of another program stays."""
    try:
        return manifest_of(folder) or Manifest()
    except Damaged:
        return Manifest()


def _exact(names: Iterable[str]) -> set[str]:
    return {name for name in names if "*" not in name}


def _check_own(unit: Unit, names: set[str]) -> None:
    """BadInput if a file that would be replaced, or go with the earlier result, is of the user, or was edited."""
    manifest = _manifest(unit.folder)
    earlier = set() if unit.revises else {*_earlier(unit, manifest)}
    why = "{}, and it would be replaced; choose another folder, or move the file"
    found = ((unit.folder / name, _foreign(unit, manifest, name)) for name in sorted(names | earlier))
    mistakes = [Mistake("camopt", "out", str(path), why.format(what), bare=True) for path, what in found if what]
    if mistakes:
        raise BadInput(mistakes)


def _earlier(unit: Unit, manifest: Manifest) -> Mapping[str, Fact]:
    """The files of the earlier result, as far as the manifest names them."""
    return manifest.results.get(unit.command, Result("", {})).files


def _foreign(unit: Unit, manifest: Manifest, name: str) -> str:
    """What of a file is not camopt's, in words; empty if all is, or there is none.

    Where no manifest names it, a table says of itself whether it is as it was written. Other files do not: they are
    taken for those of an older camopt, which wrote no manifest, until there is one of this command.
    """
    path, fact = unit.folder / name, manifest.files.get(name)
    if not path.is_file():
        return ""
    if fact:
        return "" if path.suffix in DATA or fact_of(path) == fact else "this was edited since camopt wrote it"
    own = _is_own(path) if path.suffix == TABLE else unit.command not in manifest.results
    return "" if own else "camopt did not write this as it is"


def _is_own(path: Path) -> bool:
    """Whether a file is a table, and as camopt wrote it."""
    from camopt.tables.damage import Fault, open_table

    with path.open("rb") as file, suppress(Fault):
        open_table(file)
        return True
    return False


def _commit(unit: Unit, made: list[Path]) -> None:
    """Publish what was written: sync it, and give the manifest its name."""
    folder, staged = unit.folder, {}
    # again: the work may have taken days, and names by pattern are known only now
    _check_own(unit, {file.name for file in unit.staging.iterdir()})
    for file in sorted(unit.staging.iterdir()):
        target = target_of(folder / file.name)
        with naming(folder / file.name, target):
            check_replaceable(target)
        synced(file)
        staged[file.name] = fact_of(file)
        keep_mode(target, file)
    old = _manifest(folder)
    earlier = _earlier(unit, old)
    exact = {name for name in _exact((*unit.may_write, *unit.stale)) if not _foreign(unit, old, name)}
    gone = set() if unit.revises else {*earlier, *exact} - old.others(unit.command)
    if not staged and unit.command not in old.results and not any((folder / name).is_file() for name in gone):
        return  # there is nothing, and there was nothing
    files = {**(earlier if unit.revises else {}), **staged}
    asked, replaces = old.results.get(unit.command, unit) if unit.revises else unit, tuple(sorted(gone - {*files}))
    result = Result(run_of(unit.command, files), files, replaces, asked.question, asked.answer)
    synced(unit.staging)
    unit.staging = unit.staging.rename(result.waiting(folder))
    written = unit.work / MANIFEST
    with naming(folder / MANIFEST, written):
        written.write_text(_manifest_with(old, unit.command, result), encoding="utf-8", newline="\n")
    keep_mode(folder / MANIFEST, written)
    for path in (written, unit.work, folder, *(each.parent for each in made)):
        synced(path)
    unit.files = tuple(folder / name for name in staged)
    os.replace(written, folder / MANIFEST)


def _manifest_with(old: Manifest, command: str, result: Result) -> str:
    """The text of a manifest with one more result; without an answer that would make it too long to be read."""
    text = old.with_result(command, result).to_json()
    if len(text) <= LARGEST_TEXT // 2:
        return text
    return old.with_result(command, replace(result, question=None, answer=None)).to_json()


def _place(folder: Path, staging: Path, manifest: Manifest, command: str) -> None:
    """Give files their names, after those of the earlier result are gone: no two results are ever side by side.

    A disk that fails to sync fails at the end: the names matter more.
    """
    result, others = manifest.results[command], manifest.others(command)
    waiting = [name for name in result.files if (staging / name).exists()]
    old = [folder / name for name in result.replaces if name not in others]
    for path in (*old, *(target_of(folder / name) for name in waiting)):
        if not path.is_dir():
            path.unlink(missing_ok=True)
    troubles = [*_tried([partial(synced, folder)])]
    for name in waiting:
        _rename(staging / name, folder / name)
    troubles += _tried([partial(synced, folder)])
    _remove(staging)
    if troubles:
        raise troubles[0]


def _rename(staged: Path, path: Path) -> None:
    """Give a file its name; on another disk, where a link may lead, as a copy."""
    try:
        os.replace(staged, target_of(path))
    except OSError as trouble:
        if trouble.errno != EXDEV:
            raise
        with whole_file(path) as partial:
            shutil.copyfile(staged, partial)
        staged.unlink()


def _remove(path: Path) -> None:
    """Remove a file or a folder with all that is in it, if there is one."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
