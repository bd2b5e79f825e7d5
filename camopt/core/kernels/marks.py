"""Marks for the parts of kernels: compiled functions, and classes that are numbers inside kernels.

Everything here runs without numba: what is marked runs as it is written, with the same bits.
"""

from collections.abc import Callable
from functools import cached_property, update_wrapper, wraps
from threading import RLock
from typing import Any, ClassVar, TypeVar

ValueClass = TypeVar("ValueClass")

Kinds = tuple[Any, ...]
"""The types of a kernel's arguments."""

COMPILE_LOCK = RLock()


class KernelPart:
    """A function that is compiled into kernels; called from Python it runs as plain Python."""

    is_kernel = False
    make_dispatcher: ClassVar[Callable[["KernelPart"], Any]]
    """Makes the dispatcher of numba; ``dispatchers`` sets it when it is imported."""

    def __init__(self, function: Callable[..., Any], *, inline: bool = False) -> None:
        update_wrapper(self, function)
        self.py_func, self.inline = function, inline
        self.in_python = function

    def __call__(self, *arguments: Any) -> Any:
        return self.in_python(*arguments)

    def array_version(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Mark the version of the function for arrays, which runs in its place where it is not compiled."""
        self.in_python = function
        return function

    @cached_property
    def dispatcher(self) -> Any:
        """The dispatcher of numba that compiles it."""
        return KernelPart.make_dispatcher(self)


def inline_in_kernels(function: Callable[..., Any]) -> Any:
    """Compile a function into each kernel that calls it: a call left standing would keep a loop out of vectors."""
    return KernelPart(function, inline=True)


called_by_kernels: Callable[..., Any] = KernelPart
"""Compile a function that kernels call, but not for each number."""

VALUE_TYPES: list[tuple[type, tuple[str, ...]]] = []
"""What numba is still to be told: classes that are value types inside kernels, and the fields they are made of."""

CHOICES: list[tuple[Callable[..., Any], Callable[..., Any]]] = []
"""And functions for which kernels take others by the types of the arguments: the function, and what chooses."""


def value_type(*fields: str) -> Callable[[type[ValueClass]], type[ValueClass]]:
    """Mark a class whose objects are numbers with names; in kernels each number is in a register."""

    def register(owner: type[ValueClass]) -> type[ValueClass]:
        VALUE_TYPES.append((owner, fields))
        return owner

    return register


def chosen_by_type(function: Callable[..., Any]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Mark a chooser of the function that kernels call in place of another one; it may return None.

    It takes the classes of the arguments, under the same names: a value type, a NamedTuple, ``tuple`` for any other
    tuple, ``NoneType``, or ``float`` for all the rest.
    """

    def register(choose: Callable[..., Any]) -> Callable[..., Any]:
        CHOICES.append((function, choose))
        return choose

    return register


def overload_in_kernels(function: Callable[..., Any]) -> Any:
    """Compile a function into each kernel that calls it, as ``inline_in_kernels``; plain Python calls it without a
    detour."""
    chosen_by_type(function)(wraps(function)(lambda *kinds: function))
    return function
