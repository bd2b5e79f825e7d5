"""Signals that end a command. Each raises KeyboardInterrupt, so that unfinished work is cleaned up."""

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
RESEND_SECONDS = 0.01  # s; a callback ends sooner
REPEAT_SECONDS = 1.0  # s; signals this close count once: a closing terminal sends two, and so do some wrappers
CTRL_C_CODE = 128 + signal.SIGINT
"""The exit code of shells for a command that was interrupted."""
_received_signals: list[tuple[int, float]] = []
"""The signal that ends this command, and when it came."""


def is_interrupted() -> bool:
    """Whether a signal ends this command."""
    return bool(_received_signals)


def exit_code_of_interrupt() -> int:
    """Exit code of an interrupted command, as in shells: 128 plus the number of the signal."""
    return 128 + _received_signals[0][0] if _received_signals else CTRL_C_CODE


@contextmanager
def raise_keyboard_interrupt_on_signals() -> Iterator[None]:
    """Within the block, SIGINT, SIGTERM and SIGHUP raise KeyboardInterrupt in the main thread, once.

    A second signal while the command ends kills the process. Signals that were ignored from the start stay ignored
    (``nohup``, background jobs). After the block, each signal ends the process at once, without a traceback.
    """
    handled = [number for number in ENDING_SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
    for number in handled:
        signal.signal(number, _receive_signal)
    sys.unraisablehook = _resend_signal
    try:
        yield
    finally:
        sys.unraisablehook = sys.__unraisablehook__
        for number in handled:
            signal.signal(number, signal.SIG_DFL)


def _resend_signal(unraisable: Any) -> None:
    """Send a signal again that came in a callback that swallows exceptions, as imports have them."""
    if _received_signals and isinstance(unraisable.exc_value, KeyboardInterrupt):
        number, _ = _received_signals.pop()
        Timer(RESEND_SECONDS, os.kill, (os.getpid(), number)).start()  # later: this hook swallows exceptions too
    else:
        sys.__unraisablehook__(unraisable)


def _receive_signal(number: int, frame: FrameType | None) -> None:
    if not _received_signals:
        _received_signals.append((number, monotonic()))
        raise KeyboardInterrupt
    if monotonic() > _received_signals[0][1] + REPEAT_SECONDS:
        signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
