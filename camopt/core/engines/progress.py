"""Progress of long work: reports to the caller, who can stop the work, and a progress bar."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from inspect import signature
from typing import Any, ParamSpec, TypeVar

from camopt.core.mistakes import BadInput, Mistake, Stopped

Advance = Callable[[int, int], bool | None]
"""Function of the amount done and of the total, which may change; it returns False to stop the work."""
Progress = Advance | bool
"""Argument of callers: a function, or True for a progress bar."""

CallParameters = ParamSpec("CallParameters")
CallResult = TypeVar("CallResult")

LOG_DELAY, LOG_INTERVAL = 10.0, 30.0  # seconds before the first line in a log, and shortest between lines
LARGE_TOTAL = 10_000  # totals from here on are shown as 12.3k or 252M


def report_progress(progress: Progress | None, done: int, total: int) -> None:
    """Report to the caller how far the work is.

    Raises
    ------
    Stopped
        If the caller's function returns False. None, which most functions return, lets the work go on.
    """
    if callable(progress) and progress(done, total) is False:
        raise Stopped("stopped by the caller")


def with_progress_bar(
    unit: str,
) -> Callable[[Callable[CallParameters, CallResult]], Callable[CallParameters, CallResult]]:
    """Decorate a function to show a progress bar if its ``progress`` is True."""

    def decorate(function: Callable[CallParameters, CallResult]) -> Callable[CallParameters, CallResult]:
        @wraps(function)
        def run(*args: CallParameters.args, **kwargs: CallParameters.kwargs) -> CallResult:
            call = signature(function).bind(*args, **kwargs)
            progress = call.arguments.get("progress")
            if progress not in (None, True, False) and not callable(progress):
                raise BadInput([Mistake("camopt", "progress", progress, "a function, True, False or None")])
            if progress is not True:
                return function(*args, **kwargs)
            with progress_bar(unit) as call.arguments["progress"]:
                return function(*call.args, **call.kwargs)

        return run

    return decorate


@contextmanager
def progress_bar(unit: str) -> Iterator[Advance]:
    """Show a progress bar on standard error in a terminal or notebook; in a log, a line now and then."""
    from tqdm.auto import tqdm

    in_log = not sys.stderr.isatty() and "ipykernel.zmqshell" not in sys.modules
    log_settings = {"file": _LogLines(), "delay": LOG_DELAY, "mininterval": LOG_INTERVAL}
    settings = log_settings if in_log else {"file": sys.stderr, "dynamic_ncols": True}
    bar: Any = None

    def advance(done: int, total: int) -> None:
        nonlocal bar
        if bar is None or done < bar.n:  # the work may have several phases
            if bar is not None:
                bar.close()
            scale = total >= LARGE_TOTAL
            bar = tqdm(
                unit=f" {unit}", initial=done, total=total, unit_scale=scale, miniters=0, leave=False, **settings
            )
        bar.total = total
        bar.update(done - bar.n)

    try:
        yield advance
    finally:
        if bar is not None:
            bar.close()


class _LogLines:
    """Standard error for a bar that prints lines, because a log cannot move its cursor back."""

    def write(self, text: str) -> None:
        if line := text.strip():
            print(line, file=sys.stderr, flush=True)
