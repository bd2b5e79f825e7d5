"""Output in the terminal: a progress bar, tables that are never cut off, JSON."""

import sys
import textwrap
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr
from typing import TYPE_CHECKING, Any

from camopt.cli.exits import print_message
from camopt.core.engines.progress import Advance, progress_bar
from camopt.core.kernels.compile_notice import compilation_notice
from camopt.core.storage.files import LossWarning
from camopt.solve.tables.cells import to_json
from camopt.solve.tables.result import ABOUT, NUMERIC, VALUE, Branch, FileLine, Result, Table

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table as RichTable
    from rich.tree import Tree as RichTree


@contextmanager
def progress(quiet: bool, unit: str) -> Iterator[Advance]:
    """Show on standard error the progress, and a notice when kernels are compiled. Messages stay above the bar."""

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
"""Options of printed columns, by kind of column."""


def _rich_table(table: Table) -> "RichTable":
    """A table as the terminal prints it, without its title.

    Words are never broken. Lines are broken only in values, explanations and lists.
    """
    from rich.box import SIMPLE_HEAD
    from rich.table import Table as RichTable

    frame: dict[str, Any] = {"box": SIMPLE_HEAD, "padding": (0, 1)} if table.is_headed else {"box": None}
    printed = RichTable(show_header=table.is_headed, pad_edge=False, **frame)
    for place, head in enumerate(table.heads):
        texts = [row[place].text for row in table.rows]
        wraps = head.kind in (VALUE, ABOUT) or any(", " in text for text in texts)
        whole = (part for text in (head.text, *texts) for part in (text.split() if wraps else text.split("\n")))
        kind = {
            "min_width": max(map(len, whole), default=0),
            "no_wrap": not wraps,
            **COLUMN_STYLES.get(head.kind, {}),
        }
        printed.add_column(head.text, vertical="bottom" if table.is_headed else "top", **kind)
    for row in table.rows:
        printed.add_row(*(cell.text for cell in row))
    return printed


def _rich_tree(branch: Branch) -> "RichTree":
    """A tree as the terminal prints it."""
    from rich.tree import Tree as RichTree

    tree = RichTree(branch.text)
    tree.children += [_rich_tree(child) for child in branch.branches]
    return tree


def _plain_console(width: int | None = None) -> "Console":
    """A console that prints texts as they are: brackets and colons are no markup."""
    from rich.console import Console

    return Console(width=width, highlight=False, markup=False, emoji=False)


def print_sections(*sections: Any, explained: bool = True) -> None:
    """Print texts, trees and tables to standard output. A table wider than the screen is printed row by row.

    The meanings of quantities are left out on a narrow screen, or if ``explained`` is false.
    """
    if sys.stdout is None:
        return
    screen = _plain_console()
    for thing in sections:
        if isinstance(thing, str):
            screen.print(thing if isinstance(thing, FileLine) else wrap_sentence(thing), soft_wrap=True)
            continue
        if isinstance(thing, Branch):  # wrapped within its branches on a screen, not wrapped in a file
            _plain_console(table_width_limit()).print(_rich_tree(thing))
            continue
        screen.print(thing.title, soft_wrap=True)  # rich wraps a title to its table
        if not thing.is_headed and not (explained and table_width_limit() >= EXPLANATION_WIDTH):
            thing = thing.without_meaning_sentences()
        printed = _rich_table(thing)
        width = table_width_limit() if thing.is_headed else sentence_width_limit()
        minimum = _plain_console(NO_WIDTH).measure(printed).minimum if width < NO_WIDTH else 0
        if table_width_limit() < minimum:
            screen.print(_table_text_row_by_row(thing), soft_wrap=True)
        else:
            _plain_console(max(width, minimum)).print(printed, crop=False)
        if thing.note:
            screen.print(wrap_sentence(thing.note), soft_wrap=True)


NO_WIDTH = 10_000
EXPLANATION_WIDTH = 110  # columns of a screen: on a narrower one a meaning would be a column of single words
FILE_WIDTH = 100  # columns of a sentence in a file


def table_width_limit() -> int:
    """Largest width of a table row [columns]: that of the screen; no limit in a file."""
    return _plain_console().width if sys.stdout is not None and sys.stdout.isatty() else NO_WIDTH


def sentence_width_limit() -> int:
    """Largest width of a sentence [columns]."""
    return FILE_WIDTH if table_width_limit() == NO_WIDTH else table_width_limit()


def wrap_sentence(text: str) -> str:
    """A sentence in lines of ``sentence_width_limit``; a longer word gets its own line."""
    return textwrap.fill(text, sentence_width_limit(), break_long_words=False, break_on_hyphens=False)


def _table_text_row_by_row(table: Table) -> str:
    """A table for a narrow screen: for each row, one line of heading and value per column."""
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
    """Print a result as tables or JSON, then its notes and the written files; return its exit code."""
    if as_json:
        print_json(result.to_dict())
    else:
        print_sections(*result.sections(), explained=explained)
    if not quiet:
        print_notes(result.notes)
        print_written_files(files)
    limit = result.asked_accuracy
    if result.relative_half_width > limit:
        print_note(f"relative error of {limit:g} not reached; values are exact to {result.relative_half_width:.2g}")
    return result.exit_code


def print_json_or_files(document: Any, as_json: bool, quiet: bool, files: Iterable[Any]) -> int:
    """Print a JSON document, or name the written files; return exit code 0."""
    if as_json:
        print_json(document)
    elif not quiet:
        print_written_files(files)
    return 0


def print_notes(sentences: Iterable[str]) -> None:
    """Print notes on a result to standard error."""
    for sentence in sentences:
        print_note(sentence)


def print_note(sentence: str) -> None:
    """Print a note to standard error."""
    print_message(f"camopt: {sentence}")


def print_note_if_loss_warning(sentence: str) -> None:
    """Print a note only if it is a LossWarning, which --quiet does not silence."""
    if isinstance(sentence, LossWarning):
        print_note(sentence)


def print_written_files(files: Iterable[Any]) -> None:
    """Name the written files on standard error."""
    for file in files:
        print_message(f"wrote {file}")
