"""Marks for what kernels are made of, and when a kernel is compiled.

Everything here runs without numba. The first kernel that is worth compiling imports it (``dispatchers``); until
then, what is marked runs as it is written, with the same bits.
"""

import os
import sys
from collections.abc import Callable
from functools import cached_property, update_wrapper
from time import thread_time
from typing import Any, NamedTuple, TypeVar

import numpy as np

Value = TypeVar("Value")

FEW = 600  # numbers in the largest array to fill: for more, a kernel is compiled at once
PAYS = 4.0  # seconds of plain runs of a kernel, after which it is compiled, which takes about as long
IMPORT = 0.5  # seconds of plain runs of all kernels, after which numba is imported, which takes about as long
NEVER = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")  # whether everything runs as it is written


class Kind(NamedTuple):
    """What numba calls the type of a number, and the dimensions of an array of such, in C order; 0: the number."""

    name: str
    dimensions: int = 0


class Record(NamedTuple):
    """The type of a NamedTuple: its class, and the types of its fields."""

    owner: type
    fields: tuple[Any, ...]


NONE, COUNT, NUMBER, BOOLEAN, ADDRESS = map(Kind, ("none", "int64", "float64", "boolean", "voidptr"))


class Part:
    """A function that kernels compile into themselves; called from Python it runs as it is written."""

    def __init__(self, function: Callable[..., Any], *, inline: bool = False) -> None:
        update_wrapper(self, function)
        self.py_func, self.inline = function, inline
        self.in_python = function

    def __call__(self, *arguments: Any) -> Any:
        return self.in_python(*arguments)

    def uncompiled(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Mark what runs in place of the function where it is not compiled: the same, on arrays."""
        self.in_python = function
        return function

    @cached_property
    def dispatcher(self) -> Any:
        """What numba compiles."""
        from camopt.kernels.dispatchers import dispatcher_of

        return dispatcher_of(self)


class Kernel(Part):
    """A kernel that is compiled when it is called, and cached on disk."""

    def __call__(self, *arguments: Any) -> Any:
        return self.py_func(*arguments) if NEVER else self.dispatcher(*arguments)


class KernelForMany(Kernel):
    """A kernel that is compiled once that pays: for many designs, or when plain runs have taken as long.

    Both give the same bits. A kernel that is on disk is not compiled, so it is taken at once where numba is there.
    """

    seconds = 0.0
    """Of plain runs of all kernels."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self.spent: dict[Any, float] = {}  # seconds of plain runs since numba is there, by types of the arguments

    def __call__(self, *arguments: Any) -> Any:
        if NEVER or not (self.dear(arguments) or self.seconds > IMPORT or "numba" in sys.modules):
            return self.plain(arguments)[0]
        return self.dispatcher(*arguments)

    @staticmethod
    def dear(arguments: tuple[Any, ...]) -> bool:
        """Whether a call has many numbers to fill in."""
        return max((values.size for values in arguments if isinstance(values, np.ndarray)), default=0) > FEW

    def plain(self, arguments: tuple[Any, ...]) -> tuple[Any, float]:
        """Result and seconds of a run as it is written."""
        start = thread_time()
        with np.errstate(all="ignore"):  # as machine code
            result = self.py_func(*arguments)
        seconds = thread_time() - start
        KernelForMany.seconds += seconds
        return result, seconds


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a function into each kernel that calls it: a call left standing would keep a loop out of vectors."""
    return Part(function, inline=True)


called_by_kernels: Callable[..., Any] = Part
"""Compile a function that kernels call, but not for each number."""

compiled: Callable[..., Any] = Kernel
"""Compile a kernel with numba, cached on disk."""

compiled_for_many: Callable[..., Any] = KernelForMany
"""As ``compiled``, but plain Python where a call fills arrays of a few numbers."""


VALUES: list[tuple[type, tuple[str, ...]]] = []
"""What numba is still to be told: classes that are value types inside kernels, and the fields they are made of."""

CHOICES: list[tuple[Callable[..., Any], Callable[..., Any]]] = []
"""And functions for which kernels take others by the types of the arguments: the function, and what chooses."""


def value_type(*fields: str) -> Callable[[type[Value]], type[Value]]:
    """Mark a class whose objects are numbers under these names, and in kernels as many registers."""

    def register(owner: type[Value]) -> type[Value]:
        VALUES.append((owner, fields))
        return owner

    return register


def chosen_by_type(function: Callable[..., Any]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Mark what chooses the function that kernels call in place of another one, or None.

    It takes the classes of the arguments, under the same names: a value type, a NamedTuple, ``tuple`` for any other
    tuple, ``NoneType``, or ``float`` for all the rest.
    """

    def register(choose: Callable[..., Any]) -> Callable[..., Any]:
        CHOICES.append((function, choose))
        return choose

    return register
