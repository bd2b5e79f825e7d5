"""The end of a command: its exit code, and one line on standard error if it failed."""

import os
import sys
import warnings
from collections.abc import Callable
from contextlib import suppress
from io import TextIOWrapper
from logging import CRITICAL, getLogger
from pathlib import Path
from traceback import extract_tb, print_exception
from warnings import catch_warnings

import click

from camopt.cli import interrupts
from camopt.core.mistakes import (
    BAD_INPUT,
    FILE_TROUBLE,
    NOT_REACHED,
    NOTHING_FEASIBLE,
    BadInput,
    Stopped,
    Unmet,
    Unsolved,
    to_terminal_line,
)
from camopt.core.storage.files import TidyingWarning

INTERNAL_ERROR, READER_GONE = 70, 141  # the numbers of sysexits.h and of shells
DEBUG_VARIABLE = "CAMOPT_DEBUG"
LIBRARY_SUFFIXES = (".so", ".pyd", ".dylib")


def run_command(command: Callable[[], int]) -> int:
    """Run a command and return its exit code. An error prints one line, never a traceback."""
    _open_closed_streams_on_null_device()
    for library in ("matplotlib", "ezdxf"):  # they warn about folders for their font caches
        getLogger(library).setLevel(CRITICAL)
    try:
        with catch_warnings(action="always", category=TidyingWarning):
            warnings.showwarning = lambda message, *_, **__: print_message(f"camopt: {message}")
            code = command()
        sys.stdout.flush()
        return code
    except BaseException as end:
        code = _exit_code_after_printing_exception(end)
        for note in getattr(end, "__notes__", ()):
            print_message(f"camopt: {note}")
        return code
    finally:
        _discard_unwritable_output()


def print_message(text: str) -> None:
    """Print lines on standard error, in printable characters; do nothing if it is closed."""
    with suppress(OSError):
        for line in text.splitlines():
            print(to_terminal_line(line), file=sys.stderr, flush=True)


def _open_closed_streams_on_null_device() -> None:
    """Open closed standard streams on the null device, so that no file gets their numbers."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without ∞ or ² shows ?, not a traceback


def _discard_unwritable_output() -> None:
    """Send unwritable streams to the null device, so that Python's last flush raises no error."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            with suppress(OSError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _exit_code_after_printing_exception(ending_exception: BaseException) -> int:  # noqa: C901
    """The exit code for the exception that ended a command; prints its message."""
    match ending_exception:
        case SystemExit():  # click and rich exit with 1 only when the reader of a pipe is gone
            return READER_GONE if ending_exception.code == 1 else int(ending_exception.code or 0)
        case BrokenPipeError():
            return READER_GONE
        case click.Abort() if ending_exception.__cause__:
            return _exit_code_after_printing_exception(ending_exception.__cause__)
        case KeyboardInterrupt() | click.Abort() | Stopped():
            return _print_failure(str(ending_exception) or "interrupted", interrupts.exit_code_of_interrupt())
        case _ if interrupts.is_interrupted():  # an import turns interrupts into other errors
            return _print_failure("interrupted", interrupts.exit_code_of_interrupt())
        case click.ClickException():
            context = getattr(ending_exception, "ctx", None)
            command = context.command_path if context else "camopt"
            return _print_failure(f"{ending_exception.format_message()} (see {command} --help)", BAD_INPUT)
        case BadInput():
            print_message(str(ending_exception))
            return BAD_INPUT
        case Unmet():
            return _print_failure(str(ending_exception), NOTHING_FEASIBLE)
        case Unsolved():
            return _print_failure(str(ending_exception), NOT_REACHED)
        case MemoryError():
            return _print_failure("out of memory", FILE_TROUBLE)
        case ImportError() if (ending_exception.path or "").endswith(
            LIBRARY_SUFFIXES
        ):  # damaged, or too large for memory
            return _print_failure(_message_line(ending_exception), FILE_TROUBLE)
        case ImportError() if isinstance(ending_exception.__cause__, ImportError):  # the message of numpy is a page
            return _exit_code_after_printing_exception(ending_exception.__cause__)
        case OSError():
            where = (
                f"{os.fsdecode(ending_exception.filename)}: "
                if isinstance(ending_exception.filename, (str, bytes))
                else ""
            )
            return _print_failure(
                f"{where}{ending_exception.strerror or _message_line(ending_exception)}", FILE_TROUBLE
            )
    return _print_internal_error(ending_exception)


def _message_line(ending_exception: BaseException) -> str:
    """The first line of an exception's message."""
    return (str(ending_exception) or type(ending_exception).__name__).splitlines()[0]


def _print_failure(text: str, code: int) -> int:
    print_message(f"camopt: {text}")
    return code


def _print_internal_error(fault: BaseException) -> int:
    """Print a fault of camopt itself: its message, its place, and how to see more."""
    if os.environ.get(DEBUG_VARIABLE):
        print_exception(fault)
    package = str(Path(__file__).parents[1])
    frames = extract_tb(fault.__traceback__)
    last = next((f for f in reversed(frames) if f.filename.startswith(package)), frames[-1])
    what = f"{type(fault).__name__}: {fault}".splitlines()[0]
    where = f"{Path(last.filename).name}, line {last.lineno}"
    report = f"please report it with the command and its files; {DEBUG_VARIABLE}=1 prints the traceback"
    return _print_failure(f"internal error ({where}): {what}; {report}", INTERNAL_ERROR)
