"""For what measures compiled kernels: one that is not on disk is compiled where a call has some numbers.

In use a kernel runs in numpy until that has taken as long as compiling. Programs change the rule when they run, not
when they are imported, because tests import them and keep the rule of users.
"""

from contextlib import suppress
from importlib import import_module
from typing import Any

SMALL_ARRAY = 600


def compile_early() -> None:
    """Compile each kernel at its first call with some numbers, in this process."""
    with suppress(ImportError):  # a commit before camopt decided that
        compile: Any = import_module("camopt.core.kernels.compile")
        compile.SMALL_ARRAY = SMALL_ARRAY  # of a commit before work was counted
        compile.COMPILATION = 30.0 * SMALL_ARRAY
