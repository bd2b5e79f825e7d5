"""The clock of a search: seconds that do not count while kernels are compiled, as they are once."""

from time import monotonic
from typing import Any

from numba.core import event


class Compiling(event.Listener):
    """How long kernels have been compiled in this process."""

    def __init__(self) -> None:
        self.depth, self.since, self.seconds = 0, 0.0, 0.0

    def on_start(self, happening: Any) -> None:
        if self.depth == 0:
            self.since = monotonic()
        self.depth += 1

    def on_end(self, happening: Any) -> None:
        self.depth -= 1
        if self.depth == 0:
            self.seconds += monotonic() - self.since


COMPILING = Compiling()
event.register("numba:compile", COMPILING)  # type: ignore[no-untyped-call]


def now() -> float:
    """Seconds since some moment, without those of compilation."""
    return monotonic() - COMPILING.seconds
