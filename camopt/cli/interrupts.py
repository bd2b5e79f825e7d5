"""Signals that end a command. Each becomes a KeyboardInterrupt, so that what is half done is left in order."""

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Timer
from time import monotonic
from types import FrameType
from typing import Any

ENDING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
SOON = 0.01  # seconds, in which a callback ends
ONCE = 1.0  # seconds in which several signals are one: a terminal that closes sends two, and so do some wrappers
CTRL_C = 128 + signal.SIGINT
"""The exit code of shells for a command that was interrupted."""
_heard: list[tuple[int, float]] = []
"""The signal that ends this command, and when it came."""


def heard() -> bool:
    """Whether a signal ends this command."""
    return bool(_heard)


def code() -> int:
    """The exit code of an interrupted command, as shells have it: 128 and the number of the signal."""
    return 128 + _heard[0][0] if _heard else CTRL_C


@contextmanager
def interrupts() -> Iterator[None]:
    """Within the block, SIGINT, SIGTERM and SIGHUP raise KeyboardInterrupt in the main thread, once.

    A second one, while the command ends, kills the process. Those that were ignored from the start still are
    (``nohup``, jobs in the background). After the block, all end the process at once, without a traceback.
    """
    heeded = [each for each in ENDING if signal.getsignal(each) is not signal.SIG_IGN]
    for each in heeded:
        signal.signal(each, _hear)
    sys.unraisablehook = _hear_again
    try:
        yield
    finally:
        sys.unraisablehook = sys.__unraisablehook__
        for each in heeded:
            signal.signal(each, signal.SIG_DFL)


def _hear_again(lost: Any) -> None:
    """Send a signal again that came in a callback out of which no exception gets, as imports have them."""
    if _heard and isinstance(lost.exc_value, KeyboardInterrupt):
        number, _ = _heard.pop()
        Timer(SOON, os.kill, (os.getpid(), number)).start()  # later: no exception gets out of here either
    else:
        sys.__unraisablehook__(lost)


def _hear(number: int, frame: FrameType | None) -> None:
    if not _heard:
        _heard.append((number, monotonic()))
        raise KeyboardInterrupt
    if monotonic() > _heard[0][1] + ONCE:
        signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
