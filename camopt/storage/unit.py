"""What is published together: the files of a result, where they are written and what they may be called."""

from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from camopt.storage.files import WORK_FOLDER

JOURNAL = ".journal"
TABLE_ENDING, PART_ENDING = ".parquet", ".sweep"
"""Endings of tables, and of parts of a sweep."""
DATA = (TABLE_ENDING, PART_ENDING)
"""Endings of files that nobody edits: those that are not as they were written are damaged, and are replaced."""


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


def name_of_part(part: int, parts: int) -> str:
    """What a part of a sweep is called, and its folder."""
    return f"part-{part}-of-{parts}"


def journal_path(folder: Path, command: str) -> Path:
    """Where a command keeps what it has done of a result in a folder."""
    return folder / WORK_FOLDER / f"{command}{JOURNAL}"
