"""Decorators for the parts of kernels: compiled functions, and classes that are plain numbers inside kernels.

Nothing here needs numba. Marked functions also run as plain Python, and give the same bits.
"""

from collections.abc import Callable
from functools import cached_property, update_wrapper, wraps
from threading import RLock
from typing import Any, ClassVar, TypeVar

ValueClass = TypeVar("ValueClass")

Kinds = tuple[Any, ...]
"""Types of a kernel's arguments."""

COMPILE_LOCK = RLock()


class KernelPart:
    """A function that is compiled into kernels. A call from Python runs it as plain Python."""

    is_kernel = False
    make_dispatcher: ClassVar[Callable[["KernelPart"], Any]]
    """Function that makes numba's dispatcher; the module ``dispatchers`` sets it at its import."""

    def __init__(self, function: Callable[..., Any], *, inline: bool = False) -> None:
        update_wrapper(self, function)
        self.py_func, self.inline = function, inline
        self.in_python = function

    def __call__(self, *arguments: Any) -> Any:
        return self.in_python(*arguments)

    def array_version(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Mark the version for arrays, which runs in place of the function when it is not compiled."""
        self.in_python = function
        return function

    @cached_property
    def dispatcher(self) -> Any:
        """Numba's dispatcher, which compiles the function."""
        return KernelPart.make_dispatcher(self)


def inline_in_kernels(function: Callable[..., Any]) -> Any:
    """Compile a function into each kernel that calls it: a call would keep a loop from being vectorised."""
    return KernelPart(function, inline=True)


called_by_kernels: Callable[..., Any] = KernelPart
"""Compile a function that kernels call, but not for every number."""

VALUE_TYPES: list[tuple[type, tuple[str, ...]]] = []
"""Value types that are not yet registered with numba: classes, and the fields of their numbers."""

CHOICES: list[tuple[Callable[..., Any], Callable[..., Any]]] = []
"""Choices that are not yet registered with numba: functions, and their choosers by argument types."""


def value_type(*fields: str) -> Callable[[type[ValueClass]], type[ValueClass]]:
    """Mark a class whose objects are named numbers. In kernels, each number is in a register."""

    def register(owner: type[ValueClass]) -> type[ValueClass]:
        VALUE_TYPES.append((owner, fields))
        return owner

    return register


def chosen_by_type(function: Callable[..., Any]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Mark a function that chooses, by argument types, what kernels call in place of ``function``; or None.

    The chooser takes the classes of the arguments under the same names: a value type, a NamedTuple, ``tuple`` for
    any other tuple, ``NoneType``, or ``float`` for everything else.
    """

    def register(choose: Callable[..., Any]) -> Callable[..., Any]:
        CHOICES.append((function, choose))
        return choose

    return register


def inline_in_kernels_by_overload(function: Callable[..., Any]) -> Any:
    """Compile a function into each kernel that calls it. Unlike ``inline_in_kernels``, Python calls it directly."""
    chosen_by_type(function)(wraps(function)(lambda *kinds: function))
    return function
