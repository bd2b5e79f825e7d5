"""The clock of a search: seconds that do not count while kernels are compiled, as they are once."""

from time import monotonic

from camopt.kernels.compiling import COMPILING


def now() -> float:
    """Seconds since a fixed moment, without time spent on compilation."""
    return monotonic() - COMPILING.seconds


def share(end: float, left: int) -> float:
    """The time at which the first of equal tasks must stop to leave the others as much time."""
    start = now()
    return start + max(end - start, 0.0) / left
