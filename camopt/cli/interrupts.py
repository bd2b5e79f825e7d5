"""Signals that end a command. Each becomes a KeyboardInterrupt, so that what is half done is left in order."""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from types import FrameType

ENDING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
ONCE = 1.0  # seconds in which several signals are one: a terminal that closes sends two, and so do some wrappers
CTRL_C = 128 + signal.SIGINT
"""The exit code of shells for a command that was interrupted."""
_heard: list[tuple[int, float]] = []
"""The signal that ends this command, and when it came."""


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
    try:
        yield
    finally:
        for each in heeded:
            signal.signal(each, signal.SIG_DFL)


def _hear(number: int, frame: FrameType | None) -> None:
    if not _heard:
        _heard.append((number, monotonic()))
        raise KeyboardInterrupt
    if monotonic() > _heard[0][1] + ONCE:
        signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
