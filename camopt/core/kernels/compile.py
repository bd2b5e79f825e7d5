"""Kernels, and the rule when a kernel is compiled.

A kernel for many designs is compiled, in this process, once per machine, when its uncompiled runs would take longer
than that.

Both are known as work, not as seconds of the clock: on a busy machine the same is compiled as on an idle one. The
unit of work is the value of a simple curve at one cam angle of one design, evaluated by numpy among many: about
30 ns. A run counts its work as it goes. It is given up, and the kernel compiled, when the runs of this process have
done the work for which the kernel could have been compiled, so no command does more than twice what was needed.
"""

import os
import sys
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from threading import local
from typing import TYPE_CHECKING, Any

import numpy as np

from camopt.core.kernels.arguments import Record, kind_of
from camopt.core.kernels.compile_clock import READY_KERNELS
from camopt.core.kernels.marks import COMPILE_LOCK, KernelPart, Kinds

if TYPE_CHECKING:
    from camopt.core.kernels.kernel_cache import KernelFile
    from camopt.core.kernels.machine_code import MachineCode, ObjectCode


FORMULA_CALL_WORK = 8_000  # work: the calls of numpy that evaluate a simple curve, for however few values
COMPILATION = 25e6  # work done uncompiled in the time in which a small kernel is compiled
CURVE_SHARE = 0.7  # of that: each curve of which a curve is made
NUMBA_SHARE = 2.0  # of that: the import of numba
LOADING = 1e6  # work done in the time in which llvmlite is imported, which loads machine code
NEVER_COMPILE = os.environ.get("NUMBA_DISABLE_JIT", "0") not in {"", "0"}  # everything runs as it is written


class Kernel(KernelPart):
    """A kernel that is compiled when it is called, and kept on disk. It returns nothing and raises nothing.

    ``size`` says how many times as long as a small kernel it takes to compile.
    """

    is_kernel = True

    def __init__(self, function: Callable[..., Any], *, size: float = 1.0) -> None:
        super().__init__(function)
        self.size = size
        self.plain_work: Counter[Kinds] = Counter()
        self.made: dict[Kinds, MachineCode] = {}
        self.files: dict[Kinds, KernelFile] = {}

    def __call__(self, *arguments: Any) -> None:
        if NEVER_COMPILE:
            self.py_func(*arguments)
        else:
            self.machine_code(tuple(map(kind_of, arguments)))(arguments)

    def machine_code(self, kinds: Kinds) -> "MachineCode":
        """What runs for arguments of some types: from disk, or compiled; once, whatever threads ask for it."""
        if kinds not in self.made:
            with COMPILE_LOCK:
                if kinds not in self.made:
                    self.made[kinds] = self.file(kinds).machine_code(self.object_code)
                    READY_KERNELS.append(self.py_func.__qualname__)
        return self.made[kinds]

    def object_code(self, kinds: Kinds) -> "ObjectCode":
        """Compile the kernel by numba."""
        from camopt.core.kernels.dispatchers import object_code

        return object_code(self, kinds)

    def file(self, kinds: Kinds) -> "KernelFile":
        """Where machine code is kept on disk."""
        from camopt.core.kernels.kernel_cache import KernelFile, kernel_folder

        if kinds not in self.files:
            self.files[kinds] = KernelFile(self.py_func, kinds, kernel_folder())
        return self.files[kinds]

    def work_until_compiled(self, kinds: Kinds) -> float:
        """The work that uncompiled runs of this process may still do before it pays to compile the kernel."""
        numba = 0.0 if "numba" in sys.modules else NUMBA_SHARE
        cost = COMPILATION * (numba + self.size * (1.0 + CURVE_SHARE * curves_in(kinds[0])))
        return cost - self.plain_work[kinds]


class TooMuchWork(Exception):
    """An uncompiled run has done so much work that it is given up."""


class PlainRun(local):
    """The uncompiled run of a thread: the work it has done, the most it may do, and how much a value counts."""

    work, most, weight = 0.0, np.inf, 1.0

    def count(self, values: float) -> None:
        """Count the work of one formula for some values; ``TooMuchWork`` if the run may not do that much."""
        self.work += self.weight * (FORMULA_CALL_WORK + values)
        if self.work > self.most:
            raise TooMuchWork


PLAIN_RUN = PlainRun()


class KernelForMany(Kernel):
    """A kernel that runs uncompiled until it pays to compile it. Both give the same bits.

    A kernel that is on disk is taken at once, but where all that is asked takes no longer than to import what loads
    it. ``work`` is the least that an uncompiled run does for each number that it fills.
    """

    whole_work = 0.0
    """Of uncompiled runs of all kernels."""

    def __init__(self, function: Callable[..., Any], *, size: float = 1.0, work: float = 1.0) -> None:
        super().__init__(function, size=size)
        self.work = work

    def __call__(self, *arguments: Any) -> None:
        if NEVER_COMPILE:
            self.run_uncompiled(arguments, np.inf)
            return
        kinds = tuple(map(kind_of, arguments))
        while kinds not in self.made:
            called = self.called_kernels(kinds, arguments)
            least = self.work * largest_array_size(arguments) * curves_in(kinds[0])
            most = self.most_work(called, least)
            if least >= most:
                break
            with suppress(TooMuchWork):
                self._run_and_count(called, arguments, least, most)
                return
        self.machine_code(kinds)(arguments)

    def called_kernels(self, kinds: Kinds, arguments: tuple[Any, ...]) -> "list[tuple[Kernel, Kinds]]":
        """The kernel and those that it calls by their address, each with the types of its arguments."""
        others = [(each.kernel, each.code.arguments) for each in arguments if hasattr(each, "kernel")]
        return [*others, (self, kinds)]

    def most_work(self, called: "list[tuple[Kernel, Kinds]]", least: float) -> float:
        """The most work that a run may do uncompiled, of which it does ``least``; 0 where kernels are on disk."""
        unloaded = LOADING - self.whole_work
        if unloaded > least and "llvmlite" not in sys.modules:
            return unloaded
        missing = [
            kernel.work_until_compiled(kinds)
            for kernel, kinds in called
            if not (kinds in kernel.made or kernel.file(kinds).exists)
        ]
        return max(missing, default=0.0)

    def _run_and_count(self, called: Any, arguments: tuple[Any, ...], least: float, most: float) -> None:
        try:
            self.run_uncompiled(arguments, most)
        finally:
            done = max(PLAIN_RUN.work, least)
            KernelForMany.whole_work += done
            for kernel, kinds in called:
                kernel.plain_work[kinds] += done

    def run_uncompiled(self, arguments: tuple[Any, ...], most: float) -> None:
        """Run the function as it is written, or raise ``TooMuchWork`` after so much work."""
        PLAIN_RUN.work, PLAIN_RUN.most, PLAIN_RUN.weight = 0.0, most, curves_in(kind_of(arguments[0]))
        try:
            with np.errstate(all="ignore"):  # as machine code
                self.in_python(*arguments)
        finally:
            PLAIN_RUN.most = np.inf


def largest_array_size(arguments: tuple[Any, ...]) -> int:
    """The numbers in the largest array that a call has to fill."""
    return max((values.size for values in arguments if isinstance(values, np.ndarray)), default=0)


def curves_in(kind: Any) -> int:
    """How many curves a curve is made of: itself, and those in its fields."""
    fields = kind.fields if isinstance(kind, Record) else ()
    return 1 + sum(curves_in(each) for each in fields if isinstance(each, Record))


compiled: Callable[..., Any] = Kernel
"""Compile a kernel with numba, cached on disk."""


def compiled_for_many(*, work: float) -> Callable[..., Any]:
    """As ``compiled``, once that pays; ``work`` is the least of an uncompiled run for each number that it fills."""
    return partial(KernelForMany, work=work)
