"""Marks for the parts of kernels, and the rule when a kernel is compiled.

Everything here runs without numba: what is marked runs as it is written, with the same bits. A kernel for many
designs that has run so for some seconds, in whatever processes, is compiled by a process of its own (``beside``),
and taken from disk once it is there.
"""

import os
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cached_property, update_wrapper
from threading import RLock, local
from time import thread_time
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from camopt.kernels.arguments import kind_of
from camopt.kernels.compiling import READY

if TYPE_CHECKING:
    from camopt.kernels.kernel_cache import KernelFile
    from camopt.kernels.machine_code import MachineCode, ObjectCode

Value = TypeVar("Value")
Kinds = tuple[Any, ...]
"""The types of a kernel's arguments."""

SMALL_ARRAY = 1_000_000  # numbers in the largest array to fill: for more, a kernel is compiled at once
MANY = 10_000  # numbers in it, for which a plain run takes longer than importing llvmlite
PAYS = 1.2  # seconds of plain runs of a kernel, whenever, after which it is compiled: four of another core, once
ALONE = 8.0  # times as long: then it is compiled here, for no other process does, or it gets no time for it
PATIENCE = 10.0  # seconds of one plain run, after which it is given up and the kernel compiled
LINKER = 0.05  # seconds of plain runs of all kernels after which llvmlite is imported, which takes about as long
NEVER = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")  # whether everything runs as it is written
COMPILE_LOCK = RLock()


class KernelPart:
    """A function that is compiled into kernels; called from Python it runs as plain Python."""

    def __init__(self, function: Callable[..., Any], *, inline: bool = False) -> None:
        update_wrapper(self, function)
        self.py_func, self.inline = function, inline
        self.in_python = function

    def __call__(self, *arguments: Any) -> Any:
        return self.in_python(*arguments)

    def uncompiled(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Mark the version of the function for arrays, which runs in its place where it is not compiled."""
        self.in_python = function
        return function

    @cached_property
    def dispatcher(self) -> Any:
        """The dispatcher of numba that compiles it."""
        from camopt.kernels.dispatchers import dispatcher_of

        return dispatcher_of(self)


class Kernel(KernelPart):
    """A kernel that is compiled when it is called, and kept on disk. It returns nothing and raises nothing."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self.made: dict[Kinds, MachineCode] = {}
        self.files: dict[Kinds, KernelFile] = {}

    def __call__(self, *arguments: Any) -> None:
        if NEVER:
            self.py_func(*arguments)
        else:
            self.machine_code(tuple(map(kind_of, arguments)))(arguments)

    def machine_code(self, kinds: Kinds) -> "MachineCode":
        """What runs for arguments of some types: from disk, or compiled; once, whatever threads ask for it."""
        if kinds not in self.made:
            with COMPILE_LOCK:
                if kinds not in self.made:
                    self.made[kinds] = self._loaded(kinds)
                    READY.append(self.py_func.__qualname__)
        return self.made[kinds]

    def _loaded(self, kinds: Kinds) -> "MachineCode":
        from camopt.kernels.machine_code import MachineCode

        file = self.file(kinds)
        return MachineCode(kinds, file.read() or self._compiled(kinds, file))

    def _compiled(self, kinds: Kinds, file: "KernelFile") -> "ObjectCode":
        """By numba; or by another process, if one was at it."""
        with file.one_process():
            code = file.read()
            if code is None:
                from camopt.kernels.dispatchers import object_code

                code = object_code(self, kinds)
                file.write(code)
        return code

    def file(self, kinds: Kinds) -> "KernelFile":
        """Where machine code is kept on disk."""
        from camopt.kernels.kernel_cache import KernelFile, kernel_folder

        if kinds not in self.files:
            self.files[kinds] = KernelFile(self.py_func, kinds, kernel_folder())
        return self.files[kinds]


class TooLong(Exception):
    """A plain run has taken so long that it is given up."""


class PlainRun(local):
    """The plain run of a thread."""

    end = np.inf
    """The thread's time at which it is given up."""

    def go_on(self) -> None:
        """Raise ``TooLong`` if the run is to be given up."""
        if thread_time() > self.end:
            raise TooLong


PLAIN_RUN = PlainRun()


class KernelForMany(Kernel):
    """A kernel that runs plainly until plain runs have taken as long as compiling, and is compiled then.

    Both give the same bits. A kernel that is on disk is taken at once, but where all that is asked takes no longer
    than to import what loads it.
    """

    seconds = 0.0
    """Of plain runs of all kernels."""

    def __call__(self, *arguments: Any) -> None:
        if NEVER:
            self.plain(arguments, np.inf)
            return
        kinds = tuple(map(kind_of, arguments))
        if not (kinds in self.made or filled(arguments) > SMALL_ARRAY or self.pays(kinds, arguments)):
            with suppress(TooLong):
                self._run_plainly(kinds, arguments)
                return
        self.machine_code(kinds)(arguments)

    def _run_plainly(self, kinds: Kinds, arguments: tuple[Any, ...]) -> None:
        seconds = self.plain(arguments, PATIENCE if np.isfinite(PAYS) else np.inf)
        KernelForMany.seconds += seconds
        if self.linker(arguments):
            self.file(kinds).ran_plainly(seconds)
            if self.file(kinds).plain_seconds > PAYS:
                from camopt.kernels.beside import compile_beside

                compile_beside(self.called(kinds, arguments))

    def linker(self, arguments: tuple[Any, ...]) -> bool:
        """Whether what loads machine code is imported, or cheap beside a plain run, or beside those that were."""
        return self.seconds > LINKER or "llvmlite" in sys.modules or filled(arguments) > MANY

    def pays(self, kinds: Kinds, arguments: tuple[Any, ...]) -> bool:
        """Whether machine code is on disk, or plain runs have taken far longer than compiling does."""
        if not self.linker(arguments):
            return False
        there = all(kernel.file(asked).exists for kernel, asked in self.called(kinds, arguments))
        return there or self.file(kinds).plain_seconds > ALONE * PAYS

    def called(self, kinds: Kinds, arguments: tuple[Any, ...]) -> "list[tuple[Kernel, Kinds]]":
        """The kernel and those that it calls by their address, each with the types of its arguments."""
        others = [(each.kernel, each.code.arguments) for each in arguments if hasattr(each, "kernel")]
        return [*others, (self, kinds)]

    def plain(self, arguments: tuple[Any, ...], patience: float) -> float:
        """Seconds of a run as it is written, or ``TooLong`` after some."""
        start = thread_time()
        PLAIN_RUN.end = start + patience
        try:
            with np.errstate(all="ignore"):  # as machine code
                self.py_func(*arguments)
        finally:
            PLAIN_RUN.end = np.inf
        return thread_time() - start


def filled(arguments: tuple[Any, ...]) -> int:
    """The numbers in the largest array that a call has to fill."""
    return max((values.size for values in arguments if isinstance(values, np.ndarray)), default=0)


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a function into each kernel that calls it: a call left standing would keep a loop out of vectors."""
    return KernelPart(function, inline=True)


called_by_kernels: Callable[..., Any] = KernelPart
"""Compile a function that kernels call, but not for each number."""

compiled: Callable[..., Any] = Kernel
"""Compile a kernel with numba, cached on disk."""

compiled_for_many: Callable[..., Any] = KernelForMany
"""As ``compiled``, but plain Python where a call fills arrays of a few numbers."""


VALUE_TYPES: list[tuple[type, tuple[str, ...]]] = []
"""What numba is still to be told: classes that are value types inside kernels, and the fields they are made of."""

CHOICES: list[tuple[Callable[..., Any], Callable[..., Any]]] = []
"""And functions for which kernels take others by the types of the arguments: the function, and what chooses."""


def value_type(*fields: str) -> Callable[[type[Value]], type[Value]]:
    """Mark a class whose objects are numbers with names; in kernels each number is in a register."""

    def register(owner: type[Value]) -> type[Value]:
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
