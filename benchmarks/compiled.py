"""Imported by what measures compiled kernels: one that is not on disk is compiled where a call has some numbers.

In use a kernel runs in numpy until that has taken as long as compiling.
"""

from contextlib import suppress
from importlib import import_module
from typing import Any

SMALL_ARRAY = 600

with suppress(ImportError):  # a commit before camopt decided that
    compile: Any = import_module("camopt.core.kernels.compile")
    compile.SMALL_ARRAY = SMALL_ARRAY  # of a commit before work was counted
    compile.COMPILATION = 30.0 * SMALL_ARRAY
