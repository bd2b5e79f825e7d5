"""Imported by what measures compiled kernels: one that is not on disk is compiled where a call has some numbers.

In use a kernel runs in numpy until that has taken seconds, and a process of its own compiles it then.
"""

from contextlib import suppress
from importlib import import_module

SMALL_ARRAY = 600

with suppress(ImportError):  # a commit before camopt decided that
    import_module("camopt.kernels.compile").SMALL_ARRAY = SMALL_ARRAY  # type: ignore[attr-defined]
