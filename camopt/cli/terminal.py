"""The terminal: a progress bar, tables whose rows are never cut off, one JSON document."""

import sys
import textwrap
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr
from typing import TYPE_CHECKING, Any

from camopt.cli.exits import print_message
from camopt.core.engines.progress import Advance, progress_bar
from camopt.core.kernels.compile_clock import compilation_notice
from camopt.core.storage.files import LossWarning
from camopt.solve.tables.cells import to_json
from camopt.solve.tables.result import ABOUT, NUMERIC, VALUE, Branch, FileLine, Result, Table

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table as RichTable
    from rich.tree import Tree as RichTree


@contextmanager
def progress(quiet: bool, unit: str) -> Iterator[Advance]:
    """On standard error how far the work is, and if kernels are compiled. Messages appear above the bar."""

    def announce_compilation() -> None:
        if not quiet:
            print_message("camopt: compiling kernels (once) …")

    with compilation_notice(announce_compilation), ExitStack() as shown:
        if quiet or not unit:
            yield lambda done, total: None
            return
        advance = shown.enter_context(progress_bar(unit))
        if sys.stderr.isatty():
            from tqdm.contrib import DummyTqdmFile

            shown.enter_context(redirect_stderr(DummyTqdmFile(sys.stderr)))
        yield advance


def print_json(document: Any) -> None:
    if sys.stdout is not None:
        sys.stdout.write(to_json(document) + "\n")


COLUMN_STYLES: dict[str, dict[str, Any]] = {
    NUMERIC: {"justify": "right", "no_wrap": True},
    VALUE: {"justify": "right", "style": "bold"},
    ABOUT: {"style": "dim"},
}
"""How columns are printed, by kind; words are kept whole, and a line as well if it is no list."""


def _rich_table(table: Table) -> "RichTable":
    """A table as the terminal prints it, without its title."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table as RichTable

    frame: dict[str, Any] = {"box": SIMPLE_HEAD, "padding": (0, 1)} if table.is_headed else {"box": None}
    made = RichTable(show_header=table.is_headed, pad_edge=False, **frame)
    for place, head in enumerate(table.heads):
        texts = [row[place].text for row in table.rows]
        wraps = head.kind in (VALUE, ABOUT) or any(", " in text for text in texts)
        whole = (part for text in (head.text, *texts) for part in (text.split() if wraps else text.split("\n")))
        kind = {
            "min_width": max(map(len, whole), default=0),
            "no_wrap": not wraps,
            **COLUMN_STYLES.get(head.kind, {}),
        }
        made.add_column(head.text, vertical="bottom" if table.is_headed else "top", **kind)
    for row in table.rows:
        made.add_row(*(cell.text for cell in row))
    return made


def _rich_tree(branch: Branch) -> "RichTree":
    """A tree as the terminal prints it."""
    from rich.tree import Tree as RichTree

    tree = RichTree(branch.text)
    tree.children += [_rich_tree(each) for each in branch.branches]
    return tree


def _plain_console(width: int | None = None) -> "Console":
    """What prints texts as they are: brackets and colons are no markup."""
    from rich.console import Console

    return Console(width=width, highlight=False, markup=False, emoji=False)


def print_sections(*things: Any, explained: bool = True) -> None:
    """Print to standard output. Nothing is cut off: a table wider than the screen is printed row by row.

    The meanings of quantities are left out on a narrow screen, and where ``explained`` is false.
    """
    if sys.stdout is None:
        return
    screen = _plain_console()
    for thing in things:
        if isinstance(thing, str):
            screen.print(thing if isinstance(thing, FileLine) else wrap_sentence(thing), soft_wrap=True)
            continue
        if isinstance(thing, Branch):  # it wraps within its branches on a screen, and not in a file
            _plain_console(row_width()).print(_rich_tree(thing))
            continue
        screen.print(thing.title, soft_wrap=True)  # above the table, or it is wrapped to the table's width
        if not thing.is_headed and not (explained and row_width() >= EXPLANATION_WIDTH):
            thing = thing.without_meanings()
        printed = _rich_table(thing)
        most = row_width() if thing.is_headed else line_length()
        least = _plain_console(NO_WIDTH).measure(printed).minimum if most < NO_WIDTH else 0
        if row_width() < least:
            screen.print(_row_by_row(thing), soft_wrap=True)
        else:
            _plain_console(max(most, least)).print(printed, crop=False)
        if thing.note:
            screen.print(wrap_sentence(thing.note), soft_wrap=True)


NO_WIDTH = 10_000
EXPLANATION_WIDTH = 110  # columns of a screen: on a narrower one each sentence would be a column of single words
FILE_WIDTH = 100  # columns of a sentence in a file


def row_width() -> int:
    """The columns that a row of a table may have: those of a screen; a file takes any."""
    return _plain_console().width if sys.stdout is not None and sys.stdout.isatty() else NO_WIDTH


def line_length() -> int:
    """The columns that a sentence may have."""
    return FILE_WIDTH if row_width() == NO_WIDTH else row_width()


def wrap_sentence(text: str) -> str:
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


def print_result(
    result: Result, as_json: bool, quiet: bool, files: Iterable[Any] = (), explained: bool = True
) -> int:
    """Print a result for people or programs, with its notes and the files written; its exit code."""
    if as_json:
        print_json(result.to_dict())
    else:
        print_sections(*result.sections(), explained=explained)
    if not quiet:
        print_notes(result.notes)
        print_written_files(files)
    asked = result.asked_accuracy
    if result.half_width > asked:
        print_note(f"relative error of {asked:g} not reached; values are exact to {result.half_width:.2g}")
    return result.exit_code


def print_files(document: Any, as_json: bool, quiet: bool, files: Iterable[Any]) -> int:
    """Print a document for programs, or name the files written for people; the exit code."""
    if as_json:
        print_json(document)
    elif not quiet:
        print_written_files(files)
    return 0


def print_notes(sentences: Iterable[str]) -> None:
    """What a reader should know of a result, on standard error."""
    for sentence in sentences:
        print_note(sentence)


def print_note(sentence: str) -> None:
    """Something to know before the work, on standard error."""
    print_message(f"camopt: {sentence}")


def print_loss(sentence: str) -> None:
    """Of what to know before the work only what is lost: whoever wants no messages wants this one."""
    if isinstance(sentence, LossWarning):
        print_note(sentence)


def print_written_files(files: Iterable[Any]) -> None:
    """Name the files written, on standard error."""
    for file in files:
        print_message(f"wrote {file}")
