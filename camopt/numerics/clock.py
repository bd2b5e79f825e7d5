"""The clock of a search: seconds that do not count while kernels are compiled, as they are once."""

from time import monotonic

from camopt.numerics.compiling import COMPILING


def now() -> float:
    """Seconds since some moment, without those of compilation."""
    return monotonic() - COMPILING.seconds
