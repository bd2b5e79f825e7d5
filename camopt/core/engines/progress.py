"""Progress of long work: how callers see it, how they end the work, and a bar for those who want one."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from inspect import signature
from typing import Any, ParamSpec, TypeVar

from camopt.core.mistakes import BadInput, Mistake, Stopped

Advance = Callable[[int, int], bool | None]
"""Called with how much is done, and of how much, which may change; False ends the work."""
Progress = Advance | bool
"""What a caller gives: a function, or True for a progress bar."""

CallParameters = ParamSpec("CallParameters")
CallResult = TypeVar("CallResult")

LOG_DELAY, LOG_INTERVAL = 10.0, 30.0  # seconds before the first line in a log, and between lines at least
LARGE_TOTAL = 10_000  # from which counts are shown as 12.3k or 252M


def report_progress(progress: Progress | None, done: int, total: int) -> None:
    """Tell a caller how far the work is.

    Raises
    ------
    Stopped
        If the caller's answer is False. None, which most functions return, is no answer.
    """
    if callable(progress) and progress(done, total) is False:
        raise Stopped("stopped by the caller")


def with_progress_bar(
    unit: str,
) -> Callable[[Callable[CallParameters, CallResult]], Callable[CallParameters, CallResult]]:
    """Let a function show a progress bar where its ``progress`` is True."""

    def decorate(function: Callable[CallParameters, CallResult]) -> Callable[CallParameters, CallResult]:
        @wraps(function)
        def run(*args: CallParameters.args, **kwargs: CallParameters.kwargs) -> CallResult:
            given = signature(function).bind(*args, **kwargs)
            progress = given.arguments.get("progress")
            if progress not in (None, True, False) and not callable(progress):
                raise BadInput([Mistake("camopt", "progress", progress, "a function, True, False or None")])
            if progress is not True:
                return function(*args, **kwargs)
            with progress_bar(unit) as given.arguments["progress"]:
                return function(*given.args, **given.kwargs)

        return run

    return decorate


@contextmanager
def progress_bar(unit: str) -> Iterator[Advance]:
    """A progress bar for a terminal or a notebook, and a line now and then for a log, on standard error."""
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
    """Standard error for a bar that prints lines, since a log cannot move its cursor back."""

    def write(self, text: str) -> None:
        if line := text.strip():
            print(line, file=sys.stderr, flush=True)
