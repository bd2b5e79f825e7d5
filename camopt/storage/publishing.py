"""Results of several files, published by one rename; a folder is written by one run at a time.

A run writes its files to a folder of its own, ``.camopt/…``. At its end they are synced, and the new manifest
replaces the old one: from then on the new result is valid, as a whole. Then the files of the earlier result are
removed, and the new ones get their names. If the run dies before the manifest is replaced, the earlier result
stays, and the next run removes what was left. If it dies after that, the next run gives the files their names, and
until then readers find them by ``settled_path``.
"""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path
from typing import Any

from camopt.mistakes import BadInput, Mistake
from camopt.storage.files import (
    LARGEST_TEXT,
    WORK_FOLDER,
    check_replaceable,
    keep_mode,
    named,
    naming,
    random_name,
    synced,
    target_of,
    tell_untidy,
)
from camopt.storage.folder import held_folder, made_folder
from camopt.storage.manifest import (
    MANIFEST,
    Manifest,
    RunResult,
    answer_in,
    command_of,
    fact_of,
    manifest_to_renew,
    of_one_run,
    run_of,
)
from camopt.storage.ownership import check_own, earlier_files, exact_names, foreign
from camopt.storage.placing import place_results, remove, tried
from camopt.storage.unit import Unit, journal_path


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
    with made_folder(folder) as made, held_folder(folder) as (work, alone):
        unit = Unit(folder, work, work / random_name(), command, may_write, stale, revises, question)
        try:
            place_results(folder, work, alone)
            check_own(unit, exact_names(may_write))
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
    """The result in a folder that answers a question: of the same command, with all files intact; None if none.

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
    read = partial(answer_in, folder, command, lambda result: question == result.question is not None)
    if not (folder / WORK_FOLDER).is_dir():
        return of_one_run(folder, read)
    with held_folder(folder) as (work, alone):
        place_results(folder, work, alone)
        answer, journal = read(), journal_path(folder, command)
        if answer is not None and is_spent(journal):
            remove(journal)
        return answer


def answered_in_words(folder: Path, command: str, words: str) -> Any:
    """The same for who has the words of the question alone, which the answer has under ``words``.

    None, too, where a run may have died or be at work: who has the question looks at that.
    """
    if (folder / WORK_FOLDER).is_dir():
        return None
    return of_one_run(folder, partial(answer_in, folder, command, partial(_is_in_words, words)))


def _is_in_words(words: str, result: RunResult) -> bool:
    return isinstance(result.answer, dict) and result.answer.get("words") == words


def already_done(folder: str | os.PathLike[str]) -> str:
    """The message when a folder has the result already."""
    what = f"already done: {os.fspath(folder)} has the whole result of the same question and version"
    return f"{what}; `again` computes it anew"


@contextmanager
def revised(path: str | os.PathLike[str]) -> Iterator[Path]:
    """The path to rewrite a file: as a part of the result that has it, or the path itself.

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
    """Tidy up after a result is published. Errors do not undo it, and are reported.

    Raises
    ------
    OSError
        If the files did not get their names, not even at a second try: camopt finds them, other programs do not.
    """
    steps = [partial(synced, unit.folder), partial(_clear, unit, alone)]
    steps += [] if unit.revises else [partial(remove, unit.journal)]
    troubles = [*tried(steps)]
    if not troubles:
        return
    troubles += tried(steps)
    if any(unit.staging.glob("*")):
        why = f"published, but its files wait for their names, which the next run gives: {troubles[0].strerror}"
        raise named(troubles[0], why, unit.folder)
    tell_untidy(troubles[0], unit.folder)


def _clear(unit: Unit, alone: bool) -> None:
    """Give published files their names, and remove unpublished ones."""
    place_results(unit.folder, unit.work, alone)
    remove(unit.staging)


def _raise_of_result(trouble: OSError, unit: Unit) -> None:
    """Raise an error that names the file of the result that cannot be written, not the temporary one."""
    if isinstance(trouble.filename, str) and Path(trouble.filename).is_relative_to(unit.work):
        name = Path(trouble.filename).name
        meant = unit.folder / name if any(fnmatchcase(name, known) for known in unit.may_write) else unit.folder
        raise named(trouble, trouble.strerror or str(trouble), meant) from None


def _commit(unit: Unit, made: list[Path]) -> None:
    """Publish what was written: sync it, and give the manifest its name."""
    folder, staged = unit.folder, {}
    # again: the work may have taken days, and names by pattern are known only now
    check_own(unit, {file.name for file in unit.staging.iterdir()})
    for file in sorted(unit.staging.iterdir()):
        target = target_of(folder / file.name)
        with naming(folder / file.name, target):
            check_replaceable(target)
        synced(file)
        staged[file.name] = unit.facts.get(file.name) or fact_of(file)
        keep_mode(target, file)
    old = manifest_to_renew(folder)
    earlier = earlier_files(unit, old)
    exact = {name for name in exact_names((*unit.may_write, *unit.stale)) if not foreign(unit, old, name)}
    gone = set() if unit.revises else {*earlier, *exact} - old.others(unit.command)
    if not staged and unit.command not in old.results and not any((folder / name).is_file() for name in gone):
        return  # there is nothing, and there was nothing
    files = {**(earlier if unit.revises else {}), **staged}
    asked, replaces = old.results.get(unit.command, unit) if unit.revises else unit, tuple(sorted(gone - {*files}))
    result = RunResult(run_of(unit.command, files), files, replaces, asked.question, asked.answer)
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


def _manifest_with(old: Manifest, command: str, result: RunResult) -> str:
    """The text of a manifest with one more result, without an answer that would make it too long."""
    text = old.with_result(command, result).to_json()
    if len(text) <= LARGEST_TEXT // 2:
        return text
    return old.with_result(command, result._replace(question=None, answer=None)).to_json()
