"""Time that this process has spent compiling kernels, a notice when it begins, and the loaded kernels."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic


class CompileClock:
    """Counts the seconds of compilation. Compilations may be nested."""

    def __init__(self) -> None:
        self.depth, self.since, self.seconds = 0, 0.0, 0.0
        self.notify: Callable[[], None] | None = None

    def begin_compilation(self) -> None:
        if self.depth == 0:
            self.since = monotonic()
        self.depth += 1
        notify, self.notify = self.notify, None
        if notify:
            notify()

    def end_compilation(self) -> None:
        self.depth -= 1
        if self.depth == 0:
            self.seconds += monotonic() - self.since


COMPILE_CLOCK = CompileClock()
READY_KERNELS: list[str] = []
"""Names of the kernels whose machine code is loaded, once for each kind of arguments."""


@contextmanager
def compilation_notice(notify: Callable[[], None]) -> Iterator[None]:
    """Call ``notify`` once if a kernel is compiled within the block."""
    COMPILE_CLOCK.notify = notify
    try:
        yield
    finally:
        COMPILE_CLOCK.notify = None
