"""Commands whose result is published are done once: whoever asks the same again is told what they said of it."""

import sys
from collections.abc import Callable
from contextlib import redirect_stdout
from functools import partial
from io import StringIO
from pathlib import Path
from typing import Any, NamedTuple

from camopt.cli import terminal
from camopt.front.asked import version_of_rows
from camopt.storage.publishing import already_done, answered, published
from camopt.storage.unit import Unit


class Told(NamedTuple):
    """What a command tells of its result."""

    show: Callable[[bool], None]
    """Prints it: for people, or as JSON."""
    code: int
    """Exit code."""
    notes: tuple[str, ...] = ()
    """What a reader should know of it."""


class Once(NamedTuple):
    """A command that publishes a result in a folder, and what it is asked beside the scene."""

    folder: Path
    command: str
    may_write: tuple[str, ...]
    asked: dict[str, Any]


def once(made: Once, scene: Any, again: bool, as_json: bool, quiet: bool, work: Callable[[Unit], Told]) -> int:
    """Do the work, or tell what it told if it is done already; the exit code."""
    question = {"scene": scene.to_toml(), "version": version_of_rows(), **made.asked}
    said = None if again else answered(made.folder, made.command, question)
    if said:
        sys.stdout.write(said["json" if as_json else "text"])
        if not quiet:
            terminal.say_notes((*said["notes"], already_done(made.folder)))
        return int(said["code"])
    with published(made.folder, made.command, made.may_write, question=question) as unit:
        told = work(unit)
        texts = {kind: _printed(partial(told.show, kind == "json")) for kind in ("text", "json")}
        unit.answer = {**texts, "code": told.code, "notes": [*told.notes]}
    if as_json:
        sys.stdout.write(texts["json"])
    else:
        told.show(False)  # on a screen it is as wide as that
    if not quiet:
        terminal.say_notes(told.notes)
        terminal.say_written(unit.files)
    return told.code


def _printed(show: Callable[[], None]) -> str:
    """What is printed where it goes to a file."""
    with redirect_stdout(StringIO()) as text:
        show()
    return text.getvalue()
