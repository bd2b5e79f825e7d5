"""Plain Python formulas, for programs that must not wait for a compiler."""

from math import inf

from camopt.kernels import compile


def without_compiler() -> None:
    """Compile no kernel from here on: plain formulas take milliseconds a design, a compiler seconds."""
    compile.PAYS = inf
