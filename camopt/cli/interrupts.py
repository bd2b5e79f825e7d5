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

ENDING_SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
RESEND_SECONDS = 0.01  # seconds, in which a callback ends
REPEAT_SECONDS = (
    1.0  # seconds in which several signals are one: a terminal that closes sends two, and so do some wrappers
)
CTRL_C_CODE = 128 + signal.SIGINT
"""The exit code of shells for a command that was interrupted."""
_received_signals: list[tuple[int, float]] = []
"""The signal that ends this command, and when it came."""


def is_interrupted() -> bool:
    """Whether a signal ends this command."""
    return bool(_received_signals)


def interrupt_code() -> int:
    """The exit code of an interrupted command, as shells have it: 128 and the number of the signal."""
    return 128 + _received_signals[0][0] if _received_signals else CTRL_C_CODE


@contextmanager
def raise_interrupts() -> Iterator[None]:
    """Within the block, SIGINT, SIGTERM and SIGHUP raise KeyboardInterrupt in the main thread, once.

    A second one, while the command ends, kills the process. Those that were ignored from the start still are
    (``nohup``, jobs in the background). After the block, all end the process at once, without a traceback.
    """
    heeded = [each for each in ENDING_SIGNALS if signal.getsignal(each) is not signal.SIG_IGN]
    for each in heeded:
        signal.signal(each, _receive_signal)
    sys.unraisablehook = _resend_signal
    try:
        yield
    finally:
        sys.unraisablehook = sys.__unraisablehook__
        for each in heeded:
            signal.signal(each, signal.SIG_DFL)


def _resend_signal(lost: Any) -> None:
    """Send a signal again that came in a callback out of which no exception gets, as imports have them."""
    if _received_signals and isinstance(lost.exc_value, KeyboardInterrupt):
        number, _ = _received_signals.pop()
        Timer(RESEND_SECONDS, os.kill, (os.getpid(), number)).start()  # later: no exception gets out of here either
    else:
        sys.__unraisablehook__(lost)


def _receive_signal(number: int, frame: FrameType | None) -> None:
    if not _received_signals:
        _received_signals.append((number, monotonic()))
        raise KeyboardInterrupt
    if monotonic() > _received_signals[0][1] + REPEAT_SECONDS:
        signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
