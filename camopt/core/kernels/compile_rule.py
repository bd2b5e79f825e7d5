"""Other rules for compiling kernels, for programs that know their work in advance."""

from math import inf

from camopt.core.kernels import compile


def compile_never() -> None:
    """Compile no more kernels: plain formulas take milliseconds a design, a compilation takes seconds."""
    compile.COMPILATION = inf


def compile_at_first_call() -> None:
    """Compile each kernel at its first call, so that later commands find it on disk."""
    compile.COMPILATION = compile.LOADING = 0.0
