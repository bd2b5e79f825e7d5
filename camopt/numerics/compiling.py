"""While kernels are compiled: how long that has taken in this process, and a word when it begins."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import Any

from numba.core import event


class Compiling(event.Listener):
    """Counts the seconds of compilation; one kernel may compile another."""

    def __init__(self) -> None:
        self.depth, self.since, self.seconds = 0, 0.0, 0.0
        self.tell: Callable[[], None] | None = None

    def on_start(self, happening: Any) -> None:
        if self.depth == 0:
            self.since = monotonic()
        self.depth += 1
        tell, self.tell = self.tell, None
        if tell:
            tell()

    def on_end(self, happening: Any) -> None:
        self.depth -= 1
        if self.depth == 0:
            self.seconds += monotonic() - self.since


COMPILING = Compiling()
event.register("numba:compile", COMPILING)  # type: ignore[no-untyped-call]


@contextmanager
def announced(tell: Callable[[], None]) -> Iterator[None]:
    """Call ``tell`` once if a kernel is compiled within the block."""
    COMPILING.tell = tell
    try:
        yield
    finally:
        COMPILING.tell = None
