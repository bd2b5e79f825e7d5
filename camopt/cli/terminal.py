"""The terminal: a progress bar, tables whose rows are never cut off, one JSON document."""

import os
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext
from shutil import get_terminal_size
from typing import Any

import click

from camopt.cli.exits import say
from camopt.cli.grid import HEADING, least_width, lines_of
from camopt.cli.pace import LogLines, Pace, rate_of, time_left
from camopt.tables.cells import to_json
from camopt.tables.layout import ABOUT, VALUE, Table

Advance = Callable[[int, int], None]


@contextmanager
def progress(quiet: bool, unit: str) -> Iterator[Advance]:
    """On standard error how far the work is, by a bar if that is a terminal, and if kernels are compiled."""
    from camopt.kernels.compiling import announced

    def tell() -> None:
        if not quiet:
            say("camopt: compiling kernels, this first time only …")

    with announced(tell), nullcontext(_nothing) if quiet or not unit else _shown(unit) as advance:
        yield advance


def _nothing(done: int, total: int) -> None:
    """Show nothing."""


@contextmanager
def _shown(unit: str) -> Iterator[Advance]:
    from camopt.numerics.clock import now

    if not sys.stderr.isatty():
        yield LogLines(unit, now, say)
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskProgressColumn, TextColumn

    pace = Pace(now)
    told = (TextColumn("{task.fields[rate]}"), TextColumn("{task.fields[left]}", style="cyan"))
    columns = (TextColumn(unit), BarColumn(), MofNCompleteColumn(), TaskProgressColumn(), *told)
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(unit, total=None, rate="", left="")

        def advance(done: int, total: int) -> None:
            rate, left = pace(done, total)
            bar.update(task, completed=done, total=total, rate=rate_of(rate, unit), left=time_left(left))

        yield advance


def print_json(document: Any) -> None:
    if sys.stdout is not None:
        sys.stdout.write(to_json(document) + "\n")


STYLES: dict[str, dict[str, Any]] = {HEADING: {"bold": True}, VALUE: {"bold": True}, ABOUT: {"dim": True}}
"""How texts of tables look on a screen, by kind; others as they are."""


def show(*things: Any) -> None:
    """Print to standard output. Nothing is cut off: a table wider than the screen is printed row by row."""
    for thing in things if sys.stdout is not None else ():
        if isinstance(thing, str):
            _print(in_lines(thing))
        elif isinstance(thing, Table):
            _show_table(thing)
        else:  # of rich, which wraps it within its branches on a screen, and not at all in a file
            from rich.console import Console

            Console(width=room_across(), highlight=False, markup=False, emoji=False).print(thing)


def _show_table(table: Table) -> None:
    """Print a table, and above it its title, which may be longer."""
    _print(table.title)
    room = room_across() if table.is_headed else line_length()
    rule = "─" if (sys.stdout.encoding or "UTF").upper().startswith("UTF") else "-"
    if (least := least_width(table)) > room_across():
        _print(_row_by_row(table))
    else:
        for line in lines_of(table, max(room, least), _styled, rule):
            _print(line)
    if table.note:
        _print(in_lines(table.note))


def _styled(text: str, kind: str) -> str:
    """A text of a table, on a screen in the style of its kind."""
    on_screen = sys.stdout.isatty() and os.environ.get("TERM") != "dumb"
    return click.style(text, **STYLES[kind]) if on_screen and kind in STYLES else text


def _print(text: str) -> None:
    """Print a text that is read together with what goes to standard error."""
    print(text, flush=True)


def show_lines(records: Iterable[str]) -> None:
    """Print texts one a line, however long, for people and programs."""
    for record in records if sys.stdout is not None else ():
        _print(record)


NO_WIDTH = 10_000
FILE_WIDTH = 100  # columns of a sentence in a file


def room_across() -> int:
    """The columns that a row of a table may have: those of a screen; a file takes any."""
    return get_terminal_size().columns if sys.stdout is not None and sys.stdout.isatty() else NO_WIDTH


def line_length() -> int:
    """The columns that a sentence may have."""
    return FILE_WIDTH if room_across() == NO_WIDTH else room_across()


def in_lines(text: str) -> str:
    """A sentence in lines that fit, a longer word on a line of its own."""
    return textwrap.fill(text, line_length(), break_long_words=False, break_on_hyphens=False)


def _row_by_row(table: Table) -> str:
    """A table as text for a narrow screen: each row as lines of heading and value."""
    heads = [head.text.replace("\n", " ").strip() for head in table.heads]
    width = max(map(len, heads))
    rows = [
        "\n".join(f"{head:<{width}}  {cell.text}" for head, cell in zip(heads, row, strict=True) if cell.text)
        for row in table.rows
    ]
    return "\n" + "\n\n".join(rows) + "\n"


def unused_of(scene: Any) -> tuple[str, ...]:
    """What of a scene is odd, what of it nothing called for, and what its outputs lack."""
    from camopt.problem.unused import unanswered, unused
    from camopt.scene.oddities import oddities

    return (*oddities(scene), *unused(scene), *unanswered(scene))


def say_notes(sentences: Iterable[str]) -> None:
    """What a reader should know of a result, on standard error."""
    for sentence in sentences:
        say_note(sentence)


def say_note(sentence: str) -> None:
    """Something to know before the work, on standard error."""
    say(f"camopt: {sentence}")


def say_lost(sentence: str) -> None:
    """Of what to know before the work only what is lost: whoever wants no messages wants this one."""
    from camopt.front.journal import Lost

    if isinstance(sentence, Lost):
        say_note(sentence)


def say_written(files: Iterable[Any]) -> None:
    """Name the files written, on standard error."""
    for file in files:
        say(f"wrote {file}")
