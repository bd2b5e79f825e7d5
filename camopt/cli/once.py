"""Commands whose result is published are done once: whoever asks the same again is told what they said of it.

That may be found out twice. In the same words it is known before the scene is read, and before what reads it is
imported: an array of jobs that is queued again asks hundreds of times. Other words may ask the same question.
"""

import json
import sys
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout, suppress
from functools import partial
from hashlib import sha256
from io import StringIO
from pathlib import Path
from shutil import get_terminal_size
from typing import Any, NamedTuple

import click

from camopt.cli.exits import NOT_REACHED, say
from camopt.cli.options import Command
from camopt.mistakes import BadInput
from camopt.quantities.unit_systems import MM, system_shown
from camopt.scene.sources import sources
from camopt.storage.publishing import already_done, answered, answered_in_words, published
from camopt.storage.unit import Unit
from camopt.storage.version import version_of_rows

NO_MATTER = {"as_json", "quiet", "again", "workers", "scheduler"}
"""Options that ask for no other result."""


class KeptReport(NamedTuple):
    """What a command said of its result, as its manifest keeps it."""

    text: str
    json: str
    code: int
    """Exit code."""
    notes: list[str]
    words: str
    """Those of the question; empty if they do not tell what was asked."""

    @classmethod
    def of(cls, answer: Any) -> "KeptReport | None":
        """What an answer says; None if it is none of a command."""
        with suppress(KeyError, TypeError):
            found = cls(**{name: answer[name] for name in cls.__annotations__})
            texts = (found.text, found.json, found.words, *found.notes)
            if all(isinstance(text, str) for text in texts) and isinstance(found.code, int):
                return found
        return None

    def fits(self, as_json: bool) -> bool:
        """Whether it can be printed as it is: a table that is wider than a screen is printed in another way."""
        widest = max(map(len, self.text.splitlines()), default=0)
        return as_json or not sys.stdout.isatty() or widest <= get_terminal_size().columns

    def repeat(self, folder: Path, as_json: bool, quiet: bool) -> int:
        """Print it again; the exit code."""
        sys.stdout.write(self.json if as_json else self.text)
        for note in () if quiet else (*self.notes, already_done(folder)):
            say(f"camopt: {note}")
        return self.code


class Report(NamedTuple):
    """What a command reports of its result."""

    show: Callable[[bool], None]
    """Prints it: for people, or as JSON."""
    code: int
    """Exit code."""
    notes: tuple[str, ...] = ()
    """What a reader should know of it."""

    def tell(self, as_json: bool, kept: Mapping[str, Any]) -> None:
        """Print it: as it is kept, but on a screen, which is as wide as it is."""
        name = "json" if as_json else "text"
        if name in kept and (as_json or not sys.stdout.isatty()):
            sys.stdout.write(kept[name])
        else:
            self.show(as_json)

    def kept(self, words: str, before: tuple[str, ...] = ()) -> dict[str, Any]:
        """The same as a manifest keeps it, with what was to know before the work."""
        text, document = (_printed(partial(self.show, as_json)) for as_json in (False, True))
        known = "" if self.code == NOT_REACHED else words  # how far it is exact is said each time
        return KeptReport(text, document, self.code, [*before, *self.notes], known)._asdict()


class Once(NamedTuple):
    """A command that publishes a result in a folder, and what it is asked beside the scene."""

    folder: Path
    command: str
    may_write: tuple[str, ...]
    asked: dict[str, Any]
    before: tuple[str, ...] = ()
    """What a reader should know before the work."""


class OnceCommand(Command):
    """A command that publishes a result. ``place`` says of its options where: the folder, and the result's name."""

    def __init__(self, *args: Any, place: Callable[..., tuple[Path, str] | None], **options: Any) -> None:
        super().__init__(*args, **options)
        self.place = place

    def invoke(self, ctx: click.Context) -> Any:
        ctx.obj = _words(ctx)
        place = self.place(**ctx.params) if ctx.obj and not ctx.params["again"] else None
        said = KeptReport.of(answered_in_words(*place, ctx.obj)) if place else None
        as_json, quiet = ctx.params["as_json"], ctx.params["quiet"]
        if place and said and said.fits(as_json):
            return said.repeat(place[0], as_json, quiet)
        return super().invoke(ctx)


def words_read() -> str:
    """The words of the question, once the scene is read; empty if its files have changed meanwhile."""
    context = click.get_current_context()
    return str(context.obj) if context.obj == _words(context) else ""


def _words(context: click.Context) -> str:
    """A digest of a command, its options, all that its scene is read of, and the version; empty if that fails."""
    given: Mapping[str, Any] = context.params
    asked = {name: value for name, value in given.items() if name not in NO_MATTER}
    question = [context.command.name, version_of_rows(), system_shown(), asked]
    digest = sha256(json.dumps(question, default=str, sort_keys=True).encode())
    try:
        for text in sources(given["scene"]):
            digest.update(sha256(text).digest())
    except (BadInput, ValueError, RecursionError):  # a table, or no scene
        return ""
    return digest.hexdigest()


def once(made: Once, scene: Any, again: bool, as_json: bool, quiet: bool, work: Callable[[Unit], Report]) -> int:
    """Do the work, or repeat its report if it is done already; the exit code."""
    from camopt.cli import terminal

    words, question = words_read(), {"scene": scene.to_toml(), "version": version_of_rows(), **made.asked}
    if system_shown() != MM:
        question["units"] = system_shown()
    if not again and (said := KeptReport.of(answered(made.folder, made.command, question))):
        return said.repeat(made.folder, as_json, quiet)
    terminal.say_notes(() if quiet else made.before)
    with published(made.folder, made.command, made.may_write, question=question) as unit:
        report = work(unit)
        unit.answer = report.kept(words, made.before)
    report.tell(as_json, unit.answer)
    if not quiet:
        terminal.say_notes(report.notes)
        terminal.say_written(unit.files)
    return report.code


def _printed(show: Callable[[], None]) -> str:
    """What is printed where it goes to a file."""
    with redirect_stdout(StringIO()) as text:
        show()
    return text.getvalue()
