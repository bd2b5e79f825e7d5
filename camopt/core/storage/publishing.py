"""Publish results of several files at once: a folder has the new result or the old one, and never a mixture.

A run locks the folder and writes its files to ``.camopt/COMMAND``. At the end it writes the new manifest there.
From then on there is no way back: the old files are removed, the new files get their names, and the manifest gets
its name last. If the run dies in between, the next run in the folder finishes these steps. Until then the manifest
in the folder does not match the files, and readers refuse them. Files and folders are synced before each step.
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
    copy_os_error_for_path,
    sync_to_disk,
    warn_of_failed_tidying,
)
from camopt.core.storage.manifest import (
    MANIFEST,
    PARQUET_SUFFIX,
    CommandResult,
    DamagedManifest,
    Manifest,
    file_entry,
    file_matches_entry,
    read_manifest,
    read_manifest_or_empty,
)

LOCK_FILE = "lock"
REVISION = "revision"
"""Staging folder for single files of a result that are written again."""


@dataclass
class Publication:
    """The files of a result that is being written.

    Attributes
    ----------
    folder : pathlib.Path
        Folder of the result.
    staging : pathlib.Path
        Folder in which the files are written first.
    writable_patterns : tuple of str
        Names of allowed files, or patterns.
    answer : Any
        Answer for the next run with the same question, as JSON. It must be set before the end of the block.
    files : tuple of pathlib.Path
        Published files; empty before the end of the block.
    """

    folder: Path
    staging: Path
    writable_patterns: tuple[str, ...]
    answer: Any = None
    files: tuple[Path, ...] = field(default=())

    def staged_path(self, name: str) -> Path:
        """Path at which a file is to be written."""
        if not _matches_any_pattern(name, self.writable_patterns):
            raise KeyError(f"{name} is not one of {', '.join(self.writable_patterns)}")
        return self.staging / name


def _matches_any_pattern(name: str, patterns: tuple[str, ...]) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns)


@contextmanager
def publication(
    folder: str | os.PathLike[str],
    command: str,
    writable_patterns: tuple[str, ...],
    *,
    revises: bool = False,
    question: Any = None,
    kept_patterns: tuple[str, ...] = (),
) -> Iterator[Publication]:
    """Publish a result of several files in a folder: it replaces the earlier one if the block ends well.

    Files that no manifest names, and edited texts, are never replaced: a result that would replace one is refused.

    Parameters
    ----------
    folder : str or os.PathLike
        Folder of the result. A new folder is made, and removed again if it stays empty.
    command : str
        Command whose earlier result is replaced; results of other commands stay.
    writable_patterns : tuple of str
        Names of allowed files, or patterns such as ``optimum-*.toml``.
    revises : bool, default False
        Whether the earlier result stays, with its answer, but for the files that the block writes.
    question : Any, optional
        Question to the command, as JSON. ``published_answer_to_same_question`` returns the ``answer`` for the same
        question.
    kept_patterns : tuple of str, default ()
        Names or patterns of files in the staging folder that stay if the block fails, such as finished work.

    Raises
    ------
    OSError
        If a file cannot be written, or another run has locked the folder.
    BadInput
        If ``folder`` is empty, a file of the user or of another program would be replaced, or a file of the earlier
        result was edited.

    Warns
    -----
    TidyingWarning
        If something fails after the result is published.
    """
    folder = _checked_folder(folder)
    with _locked_work_folder(folder) as work:
        output = Publication(folder, work / (REVISION if revises else command), writable_patterns)
        try:
            _finish_interrupted_publications(folder, work)
            output.staging.mkdir(exist_ok=True)
            _remove_unfinished(output.staging, kept_patterns)
            _check_ownership(folder, command, {name for name in writable_patterns if "*" not in name}, revises)
            yield output
            _publish(output, command, revises, question)
        except BaseException as end:
            if not (output.staging / MANIFEST).exists():
                _remove_unfinished(output.staging, kept_patterns)
            if isinstance(end, OSError):
                _reraise_with_result_path(end, output)
            raise
        finally:
            with suppress(OSError):  # if finished work is in it
                output.staging.rmdir()


def _checked_folder(folder: str | os.PathLike[str]) -> Path:
    check_path(folder, "out")
    if not os.fspath(folder):  # an unset variable of the shell; as a Path it would be the current folder
        raise BadInput([Mistake("camopt", "out", "", "a folder; it is empty")])
    return Path(folder)


@contextmanager
def _locked_work_folder(folder: Path) -> Iterator[Path]:
    """Lock a folder and yield its work folder. Folders that were made for it are removed if they stay empty."""
    work = folder / WORK_FOLDER
    new_folders = [parent for parent in (folder, *folder.parents) if not parent.exists()]
    try:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except FileExistsError as trouble:
            raise copy_os_error_for_path(
                trouble, "this is neither a folder nor a link to one", Path(trouble.filename)
            ) from None
        for new in new_folders:
            sync_to_disk(new.parent)
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
        with suppress(OSError):
            left = {*os.listdir(folder)} - {WORK_FOLDER} | {*os.listdir(work)} - {LOCK_FILE}
            if new_folders and not left:
                (work / LOCK_FILE).unlink(missing_ok=True)
                for new in (work, *new_folders):
                    new.rmdir()


def _remove_unfinished(staging: Path, kept_patterns: tuple[str, ...]) -> None:
    """Remove the files of a run that failed, except its finished work."""
    with suppress(OSError):
        for path in staging.iterdir():
            if not _matches_any_pattern(path.name, kept_patterns):
                remove_path(path)


def remove_path(path: Path) -> None:
    """Remove a file or a folder with all its content, if it exists."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _check_ownership(folder: Path, command: str, names: Iterable[str], revises: bool) -> None:
    """Raise BadInput if a file that would be replaced or removed belongs to the user, or was edited."""
    manifest = read_manifest_or_empty(folder)
    earlier = manifest.results.get(command, CommandResult({}))
    mistakes = [
        Mistake("camopt", "out", str(folder / name), f"{what}, and it would be replaced; {REMEDY}", bare=True)
        for name in sorted({*names, *(() if revises else earlier.files)})
        if (what := _ownership_fault(folder / name, manifest))
    ]
    if (folder / MANIFEST).exists() and not manifest.results and _has_manifest_of_another_program(folder):
        mistakes.append(Mistake("camopt", "out", str(folder / MANIFEST), f"another program's; {REMEDY}"))
    if mistakes:
        raise BadInput(mistakes)


REMEDY = "choose another folder, or move the file"


def _has_manifest_of_another_program(folder: Path) -> bool:
    try:
        return read_manifest(folder) is None
    except DamagedManifest:
        return False


def _ownership_fault(path: Path, manifest: Manifest) -> str:
    """Why a file must not be replaced; empty if camopt wrote it, or there is no file."""
    entry = manifest.files.get(path.name)
    if not path.is_file():
        return ""
    if entry is None:
        return "no manifest names this as a file of camopt"
    unchanged = path.suffix == PARQUET_SUFFIX or file_matches_entry(path, entry)
    return "" if unchanged else "this was edited since camopt wrote it"


def _publish(output: Publication, command: str, revises: bool, question: Any) -> None:
    """Sync the written files, write their manifest, and give both their names."""
    folder, entries = output.folder, {}
    staged = [
        path
        for path in sorted(output.staging.iterdir())
        if _matches_any_pattern(path.name, output.writable_patterns)
    ]
    # checked again, because the work may have taken days
    _check_ownership(folder, command, {path.name for path in staged}, revises)
    for file in staged:
        with attribute_errors_to(folder / file.name):
            check_replaceable(folder / file.name)
        sync_to_disk(file)
        with file.open("rb") as content:
            entries[file.name] = file_entry(content)
    old = read_manifest_or_empty(folder)
    earlier = old.results.get(command)
    if not entries and earlier is None:
        remove_path(output.staging)  # neither a new nor an earlier result
        return
    if revises and earlier:
        result = earlier._replace(files={**earlier.files, **entries})
    else:
        result = CommandResult(entries, question, output.answer)
    text = old.with_result(command, result).to_json()
    if len(text) > LARGEST_TEXT:  # readers would refuse it
        text = old.with_result(command, CommandResult(result.files)).to_json()
    new_manifest = output.staging / f"{MANIFEST}.new"
    new_manifest.write_text(text, encoding="utf-8", newline="\n")
    for path in (new_manifest, output.staging, output.staging.parent, folder):
        sync_to_disk(path)
    os.replace(new_manifest, output.staging / MANIFEST)
    sync_to_disk(output.staging)
    output.files = tuple(folder / name for name in entries)
    _publish_staged_files(folder, output.staging)


def _publish_staged_files(folder: Path, staging: Path) -> None:
    """Do the remaining steps for a staging folder with a manifest: remove old files and name the new ones.

    Raises
    ------
    OSError
        If a step fails before the manifest has its name; the next run finishes the steps.

    Warns
    -----
    TidyingWarning
        If something fails after the manifest has its name.
    """
    new, old = read_manifest(staging), read_manifest_or_empty(folder)
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
        why = f"only partly published; the next run finishes it: {trouble.strerror or trouble}"
        raise copy_os_error_for_path(trouble, why, folder) from None
    try:
        sync_to_disk(folder)
        remove_path(staging)
    except OSError as trouble:
        warn_of_failed_tidying(trouble, folder)


def _finish_interrupted_publications(folder: Path, work_folder: Path) -> None:
    """Finish the publications of runs that died."""
    for staging in sorted(work_folder.iterdir()):
        if (staging / MANIFEST).exists():
            with suppress(DamagedManifest):
                if read_manifest(staging):
                    _publish_staged_files(folder, staging)


def _reraise_with_result_path(error: OSError, output: Publication) -> None:
    """Raise an error about a temporary file again, with the name of the result's file."""
    if isinstance(error.filename, str) and Path(error.filename).is_relative_to(output.staging.parent):
        name = Path(error.filename).name
        target = output.folder / name if _matches_any_pattern(name, output.writable_patterns) else output.folder
        raise copy_os_error_for_path(error, error.strerror or str(error), target) from None


def finish_interrupted_publication(folder: Path) -> None:
    """Finish the publication of a run that died in a folder, if there is one.

    Raises
    ------
    OSError
        If another run has locked the folder, or a file cannot be written.
    """
    if any((folder / WORK_FOLDER).glob(f"*/{MANIFEST}")):
        with _locked_work_folder(folder) as work:
            _finish_interrupted_publications(folder, work)


def published_answer_to_same_question(folder: str | os.PathLike[str], command: str, question: Any) -> Any:
    """Answer of a command in a folder to the same question; None for another question, or if a file is damaged.

    The publication of a run that died is finished first.

    Raises
    ------
    OSError
        If another run has locked the folder, or a file cannot be written.
    BadInput
        For an empty ``folder``.
    """
    folder = _checked_folder(folder)
    finish_interrupted_publication(folder)
    result = read_manifest_or_empty(folder).results.get(command)
    if result is None or question != result.question:
        return None
    complete = all(file_matches_entry(folder / name, entry) for name, entry in result.files.items())
    return result.answer if complete else None


@contextmanager
def path_to_revise_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield the path at which to rewrite a file: staged if a result has the file, else the path itself.

    Raises
    ------
    OSError
        If the file cannot be written, or another run has locked the folder.
    """
    path = Path(path)
    results = read_manifest_or_empty(path.parent).results
    command = next((command for command, result in results.items() if path.name in result.files), None)
    if command is None:
        yield path
    else:
        with publication(path.parent, command, (path.name,), revises=True) as output:
            yield output.staged_path(path.name)
