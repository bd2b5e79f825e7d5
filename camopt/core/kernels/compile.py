"""Kernels, and the rule that decides when a kernel is compiled.

A kernel for many designs first runs uncompiled, as plain numpy. It is compiled when its uncompiled runs would take
longer than the compilation. The machine code is kept on disk, so each machine compiles a kernel once.

Both times are counted as work and not in seconds, so that a busy machine compiles the same kernels as an idle one.
The unit of work is one value of a simple curve, for one design at one cam angle, evaluated by numpy in a large
array: about 30 ns. A run counts its work. When the runs of this process have done as much work as the compilation
takes, the run is given up and the kernel compiled. So no command does more than twice the work that was needed.
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

from camopt.core.kernels.arguments import Record, kernel_argument_type
from camopt.core.kernels.compile_notice import READY_KERNELS
from camopt.core.kernels.marks import COMPILE_LOCK, KernelPart, Kinds

if TYPE_CHECKING:
    from camopt.core.kernels.kernel_cache import KernelFile
    from camopt.core.kernels.machine_code import MachineCode, ObjectCode


FORMULA_CALL_WORK = 8_000  # work of the numpy calls for a simple curve, even for a single value
COMPILATION = 25e6  # work that takes as long uncompiled as compiling a small kernel
CURVE_SHARE = 0.7  # share of COMPILATION for each curve inside a curve
NUMBA_SHARE = 2.0  # share of COMPILATION for the import of numba
LOADING = 1e6  # work that takes as long as importing llvmlite, which loads machine code
NEVER_COMPILE = os.environ.get("NUMBA_DISABLE_JIT", "0") not in {"", "0"}  # everything runs as plain Python


class Kernel(KernelPart):
    """A kernel that is compiled at its first call and kept on disk. It returns nothing and raises nothing.

    ``size`` is the time of its compilation divided by that of a small kernel.
    """

    is_kernel = True

    def __init__(self, function: Callable[..., Any], *, size: float = 1.0) -> None:
        super().__init__(function)
        self.size = size
        self.plain_work: Counter[Kinds] = Counter()
        self.loaded: dict[Kinds, MachineCode] = {}
        self.files: dict[Kinds, KernelFile] = {}

    def __call__(self, *arguments: Any) -> None:
        if NEVER_COMPILE:
            self.py_func(*arguments)
        else:
            self.machine_code(tuple(map(kernel_argument_type, arguments)))(arguments)

    def machine_code(self, kinds: Kinds) -> "MachineCode":
        """Machine code for arguments of some types, from disk or compiled. Threads get the same object."""
        if kinds not in self.loaded:
            with COMPILE_LOCK:
                if kinds not in self.loaded:
                    self.loaded[kinds] = self.file(kinds).load_or_compile(self.object_code)
                    READY_KERNELS.append(self.py_func.__qualname__)
        return self.loaded[kinds]

    def object_code(self, kinds: Kinds) -> "ObjectCode":
        """Compile the kernel with numba."""
        from camopt.core.kernels.dispatchers import object_code

        return object_code(self, kinds)

    def file(self, kinds: Kinds) -> "KernelFile":
        """File of the machine code on disk."""
        from camopt.core.kernels.kernel_cache import KernelFile, kernel_folder

        if kinds not in self.files:
            self.files[kinds] = KernelFile(self.py_func, kinds, kernel_folder())
        return self.files[kinds]

    def work_left_until_compiling_pays(self, kinds: Kinds) -> float:
        """Work that uncompiled runs of this process may still do before compiling the kernel pays."""
        numba = 0.0 if "numba" in sys.modules else NUMBA_SHARE
        cost = COMPILATION * (numba + self.size * (1.0 + CURVE_SHARE * nested_curve_count(kinds[0])))
        return cost - self.plain_work[kinds]


class TooMuchWork(Exception):
    """An uncompiled run has done more work than it may."""


class PlainRun(local):
    """Uncompiled run of a thread: its work, the most work that it may do, and the work of one value."""

    work, most, weight = 0.0, np.inf, 1.0

    def add_formula_work_within_limit(self, value_count: float) -> None:
        """Count the work of one formula for some values; raise ``TooMuchWork`` above the run's most."""
        self.work += self.weight * (FORMULA_CALL_WORK + value_count)
        if self.work > self.most:
            raise TooMuchWork


PLAIN_RUN = PlainRun()


class TieredKernel(Kernel):
    """A kernel that runs uncompiled until compiling it pays. Both ways give the same bits.

    A kernel on disk is loaded at once, unless the uncompiled run takes less time than importing llvmlite. ``work``
    is the least work of an uncompiled run for each number that it fills.
    """

    whole_work = 0.0
    """Work of the uncompiled runs of all kernels."""

    def __init__(self, function: Callable[..., Any], *, size: float = 1.0, work: float = 1.0) -> None:
        super().__init__(function, size=size)
        self.work = work

    def __call__(self, *arguments: Any) -> None:
        if NEVER_COMPILE:
            self.run_uncompiled(arguments, np.inf)
            return
        kinds = tuple(map(kernel_argument_type, arguments))
        while kinds not in self.loaded:
            called = self.called_kernels(kinds, arguments)
            filled = max((values.size for values in arguments if isinstance(values, np.ndarray)), default=0)
            least = self.work * filled * nested_curve_count(kinds[0])
            most = self.uncompiled_work_limit(called, least)
            if least >= most:
                break
            with suppress(TooMuchWork):
                self._run_uncompiled_and_add_work(called, arguments, least, most)
                return
        self.machine_code(kinds)(arguments)

    def called_kernels(self, kinds: Kinds, arguments: tuple[Any, ...]) -> "list[tuple[Kernel, Kinds]]":
        """The kernel and the kernels that it calls by address, each with the types of its arguments."""
        others = [(curve.kernel, curve.code.arguments) for curve in arguments if hasattr(curve, "kernel")]
        return [*others, (self, kinds)]

    def uncompiled_work_limit(self, kernels_and_kinds: "list[tuple[Kernel, Kinds]]", least_work: float) -> float:
        """Limit of the work of an uncompiled run that needs at least ``least_work``.

        0 if all kernels are on disk.
        """
        before_loading = LOADING - self.whole_work
        if before_loading > least_work and "llvmlite" not in sys.modules:
            return before_loading
        missing = [
            kernel.work_left_until_compiling_pays(kinds)
            for kernel, kinds in kernels_and_kinds
            if not (kinds in kernel.loaded or kernel.file(kinds).exists)
        ]
        return max(missing, default=0.0)

    def _run_uncompiled_and_add_work(
        self, kernels_and_kinds: Any, arguments: tuple[Any, ...], least_work: float, work_limit: float
    ) -> None:
        try:
            self.run_uncompiled(arguments, work_limit)
        finally:
            done = max(PLAIN_RUN.work, least_work)
            TieredKernel.whole_work += done
            for kernel, kinds in kernels_and_kinds:
                kernel.plain_work[kinds] += done

    def run_uncompiled(self, arguments: tuple[Any, ...], work_limit: float) -> None:
        """Run the function as plain Python; raise ``TooMuchWork`` after ``work_limit`` work."""
        PLAIN_RUN.work, PLAIN_RUN.most, PLAIN_RUN.weight = (
            0.0,
            work_limit,
            nested_curve_count(kernel_argument_type(arguments[0])),
        )
        try:
            with np.errstate(all="ignore"):  # as machine code
                self.in_python(*arguments)
        finally:
            PLAIN_RUN.most = np.inf


def nested_curve_count(curve_kind: Any) -> int:
    """Number of curves in a curve: itself and the curves in its fields."""
    fields = curve_kind.fields if isinstance(curve_kind, Record) else ()
    return 1 + sum(nested_curve_count(field) for field in fields if isinstance(field, Record))


compiled: Callable[..., Any] = Kernel
"""Compile a kernel with numba, cached on disk."""


def compiled_once_it_pays(*, work: float) -> Callable[..., Any]:
    """Decorate a kernel that runs as plain Python until compiling it pays.

    ``work`` is the least work of a plain run per number that it writes.
    """
    return partial(TieredKernel, work=work)
