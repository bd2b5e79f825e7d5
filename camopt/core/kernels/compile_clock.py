"""Compilation of kernels: its time in this process, and a message when it begins; and whether some are ready."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic


class CompileClock:
    """Counts the seconds of compilation; one kernel may compile another."""

    def __init__(self) -> None:
        self.depth, self.since, self.seconds = 0, 0.0, 0.0
        self.tell: Callable[[], None] | None = None

    def begin(self) -> None:
        if self.depth == 0:
            self.since = monotonic()
        self.depth += 1
        tell, self.tell = self.tell, None
        if tell:
            tell()

    def end(self) -> None:
        self.depth -= 1
        if self.depth == 0:
            self.seconds += monotonic() - self.since


COMPILE_CLOCK = CompileClock()
READY_KERNELS: list[str] = []
"""The kernels whose machine code is loaded, by name, once for each kind of arguments."""


@contextmanager
def compilation_notice(tell: Callable[[], None]) -> Iterator[None]:
    """Call ``tell`` once if a kernel is compiled within the block."""
    COMPILE_CLOCK.tell = tell
    try:
        yield
    finally:
        COMPILE_CLOCK.tell = None
