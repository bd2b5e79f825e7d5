"""The unit of publishing: the files of a result, where they are written, and their allowed names."""

from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from camopt.storage.files import WORK_FOLDER
from camopt.storage.manifest import Fact

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
    facts : dict
        The records of files that were made as they were written, by name; of the others they are made in the end.
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
    facts: dict[str, Fact] = field(default_factory=dict)
    files: tuple[Path, ...] = ()

    @property
    def journal(self) -> Path:
        """The path for finished work of the command: kept if the command fails, removed if it succeeds."""
        return journal_path(self.folder, self.command)

    def path(self, name: str) -> Path:
        """The path at which a file is written."""
        if not any(fnmatchcase(name, known) for known in self.may_write):
            raise KeyError(f"{name} is none of {', '.join(self.may_write)}")
        return self.staging / name


def name_of_part(part: int, parts: int) -> str:
    """What a part of a sweep is called, and its folder."""
    return f"part-{part}-of-{parts}"


def journal_path(folder: Path, command: str) -> Path:
    """The path of the journal of a command in a folder."""
    return folder / WORK_FOLDER / f"{command}{JOURNAL}"
