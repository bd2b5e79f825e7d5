"""Other rules when kernels are compiled, for programs that know better."""

from math import inf

from camopt.core.kernels import compile


def compile_never() -> None:
    """Compile no kernel from here on: plain formulas take milliseconds a design, a compiler seconds."""
    compile.COMPILATION = inf


def compile_at_once() -> None:
    """Compile each kernel when it is first called, for the commands after this one."""
    compile.COMPILATION = compile.LOADING = 0.0
