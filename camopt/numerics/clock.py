"""The clock of a search: seconds that do not count while kernels are compiled, as they are once."""

from time import monotonic

from camopt.kernels.compiling import COMPILING


def now() -> float:
    """Seconds since some moment, without those of compilation."""
    return monotonic() - COMPILING.seconds


def share(end: float, left: int) -> float:
    """When the first of so many equal tasks is to stop, to leave the others as long before the end."""
    start = now()
    return start + max(end - start, 0.0) / left
