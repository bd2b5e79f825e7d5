"""Results of several files: each appears in its folder as a whole, or the older one stays, or readers refuse it.

A run writes its files to ``.camopt/COMMAND``, and has the folder to itself. In the end it writes the new manifest
there, from which on it only goes forward: the old files go, the new ones get their names, and the manifest gets its
name last. If it dies in between, the next run in the folder goes on from there; until then the manifest in the
folder does not name what is there, and readers refuse it. Files and folders are synced before each step.
"""

import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from errno import EAGAIN, ENOTDIR
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.storage.files import (
    LARGEST_TEXT,
    WORK_FOLDER,
    attribute_errors_to,
    check_path,
    check_replaceable,
    error_of_file,
    sync_to_disk,
    warn_untidy,
)
from camopt.core.storage.manifest import (
    MANIFEST,
    PARQUET_SUFFIX,
    CommandResult,
    DamagedManifest,
    Manifest,
    entry_of,
    has_entry,
    manifest_of,
    readable_manifest,
)

LOCK_FILE = "lock"
REVISION = "revision"
"""The folder, beside those of commands, in which single files of a result are written anew."""


@dataclass
class Publication:
    """The files of a result that is being written.

    Attributes
    ----------
    folder : pathlib.Path
        Where they will be.
    staging : pathlib.Path
        Where they are written.
    may_write : tuple of str
        Names, or patterns of names.
    answer : Any
        What to tell whoever asks the same again, in what JSON takes; it is kept if it is set before the end.
    files : tuple of pathlib.Path
        What was published; nothing before the end.
    """

    folder: Path
    staging: Path
    may_write: tuple[str, ...]
    answer: Any = None
    files: tuple[Path, ...] = field(default=())

    def path(self, name: str) -> Path:
        """The path at which a file is written."""
        if not _matches(name, self.may_write):
            raise KeyError(f"{name} is none of {', '.join(self.may_write)}")
        return self.staging / name


def _matches(name: str, patterns: tuple[str, ...]) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns)


@contextmanager
def publication(
    folder: str | os.PathLike[str],
    command: str,
    may_write: tuple[str, ...],
    *,
    revises: bool = False,
    question: Any = None,
    keeps: tuple[str, ...] = (),
) -> Iterator[Publication]:
    """Publish a result of several files in a folder: it replaces the earlier one if the block ends well.

    Files that no manifest names, and texts that were edited, stay; where they would be replaced, the result is
    refused.

    Parameters
    ----------
    folder : str or os.PathLike
        It is made if there is none, and goes again if nothing is in it at the end.
    command : str
        Whose earlier result is replaced; results of other commands stay.
    may_write : tuple of str
        Names, or patterns such as ``optimum-*.toml``.
    revises : bool, default False
        Whether files of the earlier result that the block does not write stay; so does what it answers.
    question : Any, optional
        What is asked, in what JSON takes: ``published_answer`` gives the ``answer`` to who asks the same again.
    keeps : tuple of str, default ()
        Names, or patterns, of files in the staging folder that stay if the block fails: finished work.

    Raises
    ------
    OSError
        If a file cannot be written, or another run has the folder.
    BadInput
        If another program's file has the name of the manifest, or the user's that of a file of the result, or a
        file of the earlier result was edited; for an empty ``folder``.

    Warns
    -----
    TidyingWarning
        If the result is published, and something failed after that.
    """
    folder = _checked_folder(folder)
    with _locked_work_folder(folder) as work:
        made = Publication(folder, work / (REVISION if revises else command), may_write)
        try:
            _finish_publications(folder, work)
            made.staging.mkdir(exist_ok=True)
            _remove_unfinished(made.staging, keeps)
            _check_ownership(folder, command, {name for name in may_write if "*" not in name}, revises)
            yield made
            _publish(made, command, revises, question)
        except BaseException as end:
            if not (made.staging / MANIFEST).exists():
                _remove_unfinished(made.staging, keeps)
            if isinstance(end, OSError):
                _raise_of_result(end, made)
            raise
        finally:
            with suppress(OSError):  # there is finished work in it
                made.staging.rmdir()


def _checked_folder(folder: str | os.PathLike[str]) -> Path:
    check_path(folder, "out")
    if not os.fspath(folder):  # as the shell gives a variable that is not set; a Path would be the current folder
        raise BadInput([Mistake("camopt", "out", "", "a folder; it is empty")])
    return Path(folder)


@contextmanager
def _locked_work_folder(folder: Path) -> Iterator[Path]:
    """The work folder in a folder, which this run has to itself; what it made goes again if it stays empty."""
    work = folder / WORK_FOLDER
    made = [each for each in (folder, *folder.parents) if not each.exists()]
    try:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except FileExistsError as trouble:
            raise error_of_file(
                trouble, "this is neither a folder nor a link to one", Path(trouble.filename)
            ) from None
        for each in made:
            sync_to_disk(each.parent)
        with attribute_errors_to(folder, work), suppress(FileExistsError):
            work.mkdir()
        if work.is_symlink() or not work.is_dir():
            raise NotADirectoryError(ENOTDIR, os.strerror(ENOTDIR), os.fspath(work))
        lock = FileLock(work / LOCK_FILE, thread_local=False)
        with attribute_errors_to(folder, work / LOCK_FILE):
            try:
                lock.acquire(timeout=0)
            except Timeout:
                raise BlockingIOError(EAGAIN, "another run writes to this folder", os.fspath(folder)) from None
        try:
            yield work
        finally:
            lock.release()
    finally:
        if made and _is_unused(folder, work):
            with suppress(OSError):
                (work / LOCK_FILE).unlink(missing_ok=True)
                for each in (work, *made):
                    each.rmdir()


def _is_unused(folder: Path, work: Path) -> bool:
    """Whether a folder holds no more than the lock."""
    try:
        return {*os.listdir(folder)} <= {WORK_FOLDER} and {*os.listdir(work)} <= {LOCK_FILE}
    except OSError:
        return False


def _remove_unfinished(staging: Path, keeps: tuple[str, ...]) -> None:
    """Remove what is left of a run, but for its finished work."""
    with suppress(OSError):
        for left in staging.iterdir():
            if not _matches(left.name, keeps):
                remove_path(left)


def remove_path(path: Path) -> None:
    """Remove a file or a folder with all its content, if it exists."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _check_ownership(folder: Path, command: str, names: Iterable[str], revises: bool) -> None:
    """BadInput if a file to be replaced, or to go with the earlier result, is the user's or was edited."""
    manifest = readable_manifest(folder)
    earlier = manifest.results.get(command, CommandResult({}))
    mistakes = [
        Mistake("camopt", "out", str(folder / name), f"{what}, and it would be replaced; {REMEDY}", bare=True)
        for name in sorted({*names, *(() if revises else earlier.files)})
        if (what := _ownership_fault(folder / name, manifest))
    ]
    if (folder / MANIFEST).exists() and not manifest.results and _is_of_another_program(folder):
        mistakes.append(Mistake("camopt", "out", str(folder / MANIFEST), f"another program's; {REMEDY}"))
    if mistakes:
        raise BadInput(mistakes)


REMEDY = "choose another folder, or move the file"


def _is_of_another_program(folder: Path) -> bool:
    try:
        return manifest_of(folder) is None
    except DamagedManifest:
        return False


def _ownership_fault(path: Path, manifest: Manifest) -> str:
    """What of a file is not camopt's, in words; empty if all is, or there is no file."""
    entry = manifest.files.get(path.name)
    if not path.is_file():
        return ""
    if entry is None:
        return "no manifest names this as a file of camopt"
    return (
        "" if path.suffix == PARQUET_SUFFIX or has_entry(path, entry) else "this was edited since camopt wrote it"
    )


def _publish(made: Publication, command: str, revises: bool, question: Any) -> None:
    """Publish what was written: sync it, write down that it is published, and do so."""
    folder, entries = made.folder, {}
    staged = [each for each in sorted(made.staging.iterdir()) if _matches(each.name, made.may_write)]
    _check_ownership(
        folder, command, {each.name for each in staged}, revises
    )  # again: the work may have taken days
    for file in staged:
        with attribute_errors_to(folder / file.name):
            check_replaceable(folder / file.name)
        sync_to_disk(file)
        with file.open("rb") as content:
            entries[file.name] = entry_of(content)
    old = readable_manifest(folder)
    earlier = old.results.get(command)
    if not entries and earlier is None:
        remove_path(made.staging)  # there is nothing, and there was nothing
        return
    if revises and earlier:
        result = earlier._replace(files={**earlier.files, **entries})
    else:
        result = CommandResult(entries, question, made.answer)
    text = old.with_result(command, result).to_json()
    if len(text) > LARGEST_TEXT:  # nobody could read it
        text = old.with_result(command, CommandResult(result.files)).to_json()
    written = made.staging / f"{MANIFEST}.new"
    written.write_text(text, encoding="utf-8", newline="\n")
    for path in (written, made.staging, made.staging.parent, folder):
        sync_to_disk(path)
    os.replace(written, made.staging / MANIFEST)
    sync_to_disk(made.staging)
    made.files = tuple(folder / name for name in entries)
    _finish_publication(folder, made.staging)


def _finish_publication(folder: Path, staging: Path) -> None:
    """Do what the manifest in a staging folder says, as far as it is not done: old files out, new ones in.

    Raises
    ------
    OSError
        If that fails before the manifest has its name; the next run goes on from there.

    Warns
    -----
    TidyingWarning
        If something fails after that.
    """
    new, old = manifest_of(staging), readable_manifest(folder)
    assert new
    fresh = [name for name in new.files if (staging / name).exists()]
    try:
        for name in {*fresh} | ({*old.files} - {*new.files}):
            if not (folder / name).is_dir():
                (folder / name).unlink(missing_ok=True)
        sync_to_disk(folder)
        for name in fresh:
            os.replace(staging / name, folder / name)
        sync_to_disk(folder)
        os.replace(staging / MANIFEST, folder / MANIFEST)
    except OSError as trouble:
        why = f"not wholly published, which the next run goes on with: {trouble.strerror or trouble}"
        raise error_of_file(trouble, why, folder) from None
    try:
        sync_to_disk(folder)
        remove_path(staging)
    except OSError as trouble:
        warn_untidy(trouble, folder)


def _finish_publications(folder: Path, work: Path) -> None:
    """Go on where runs died that were publishing."""
    for staging in sorted(work.iterdir()):
        if (staging / MANIFEST).exists():
            with suppress(DamagedManifest):
                if manifest_of(staging):
                    _finish_publication(folder, staging)


def _raise_of_result(trouble: OSError, made: Publication) -> None:
    """Raise an error that names the file of the result that cannot be written, not the temporary one."""
    if isinstance(trouble.filename, str) and Path(trouble.filename).is_relative_to(made.staging.parent):
        name = Path(trouble.filename).name
        meant = made.folder / name if _matches(name, made.may_write) else made.folder
        raise error_of_file(trouble, trouble.strerror or str(trouble), meant) from None


def finish_publishing(folder: Path) -> None:
    """Go on where a run died that was publishing in a folder; nothing if there is none.

    Raises
    ------
    OSError
        If another run has the folder, or it cannot be put in order.
    """
    if any((folder / WORK_FOLDER).glob(f"*/{MANIFEST}")):
        with _locked_work_folder(folder) as work:
            _finish_publications(folder, work)


def published_answer(folder: str | os.PathLike[str], command: str, question: Any) -> Any:
    """What a command said of its result in a folder; None if it was asked something else, or a file is not whole.

    What a run left that died while it published is put in order first.

    Raises
    ------
    OSError
        If another run has the folder, or it cannot be put in order.
    BadInput
        For an empty ``folder``.
    """
    folder = _checked_folder(folder)
    finish_publishing(folder)
    result = readable_manifest(folder).results.get(command)
    if result is None or question != result.question:
        return None
    whole = all(has_entry(folder / name, entry) for name, entry in result.files.items())
    return result.answer if whole else None


@contextmanager
def revision(path: str | os.PathLike[str]) -> Iterator[Path]:
    """The path to rewrite a file: as a part of the result that has it, or the path itself.

    Raises
    ------
    OSError
        If the file cannot be written, or another run writes to the folder.
    """
    path = Path(path)
    results = readable_manifest(path.parent).results
    command = next((command for command, result in results.items() if path.name in result.files), None)
    if command is None:
        yield path
    else:
        with publication(path.parent, command, (path.name,), revises=True) as made:
            yield made.path(path.name)
