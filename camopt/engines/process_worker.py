"""A process that works for another one until the pipe between them is closed."""

import os
import pickle
import signal
import sys
from queue import SimpleQueue
from threading import Thread
from traceback import format_exc
from typing import Any


def work() -> None:
    """Do the work that comes on standard input, and write its result or exception.

    What else prints goes nowhere, or it would be taken for a result.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    results, nowhere = os.fdopen(os.dup(1), "wb"), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    waiting: SimpleQueue[Any] = SimpleQueue()
    Thread(target=_read, args=[waiting], daemon=True).start()
    while True:
        work, items = waiting.get()
        try:
            found = pickle.dumps((work(items), None))
        except Exception as error:
            found = _told(error)
        results.write(found)
        results.flush()


def _told(error: Exception) -> bytes:
    """An exception for the other process; if it cannot be pickled, another one that says the same."""
    try:
        said = pickle.dumps((None, (error, format_exc())))
        pickle.loads(said)
    except Exception:
        said = pickle.dumps((None, (RuntimeError(f"{type(error).__name__}: {error}"), "")))
    return said


def _read(waiting: "SimpleQueue[Any]") -> None:
    """Take in work, beside it, so that the end of the other process ends this one at once."""
    try:
        while True:
            waiting.put(pickle.load(sys.stdin.buffer))
    finally:
        os._exit(0)
