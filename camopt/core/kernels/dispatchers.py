"""Numba's compile options, each with its reason, and its dispatchers for marked functions."""

import gc
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite import binding

from camopt.core.kernels.compile_notice import announce_compilation
from camopt.core.kernels.marks import COMPILE_LOCK, KernelPart, Kinds
from camopt.core.mistakes import BadInput, Mistake

try:
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "Environment variable")
        import numba
        from numba.core import event
        from numba.core.compiler_lock import global_compiler_lock
        from numba.core.registry import CPUDispatcher
except (RuntimeWarning, ValueError) as trouble:  # NUMBA_NUM_THREADS=0, NUMBA_OPT=fast
    why = f"numba does not start with its environment variables: {str(trouble).splitlines()[0]}"
    raise BadInput([Mistake("camopt", "NUMBA_…", None, why, bare=True)]) from None

from camopt.core.kernels.arguments import NONE
from camopt.core.kernels.machine_code import ObjectCode
from camopt.core.kernels.numba_types import (
    INLINE_OPTIONS,
    KERNEL_OPTIONS,
    LINKED_OPTIONS,
    numba_type,
    register_marks,
)

FLAGS: dict[str, Any] = {
    "_nrt": False,  # kernels make no arrays, and code for reference counts takes long to compile
    "nogil": True,  # blocks of designs run on threads
    "error_model": "numpy",  # 1/0 is inf, as in the formulas; Python's model would add a branch to each division
    "fastmath": False,  # inf and signed zeros decide feasibility; and no reordering: results are bit-identical
}

NUMBA_PREFIXES = ("numba_", "NRT_", "Py")  # first letters of functions that exist only where numba is loaded


class CompilationListener(event.Listener):
    """Numba notifies it of each compilation."""

    def on_start(self, event: Any) -> None:
        announce_compilation()

    def on_end(self, event: Any) -> None:
        """Does nothing."""


event.register("numba:compile", CompilationListener())  # type: ignore[no-untyped-call]


class Dispatcher(CPUDispatcher):
    """The numba dispatcher of a marked function."""

    part: KernelPart

    def compile(self, signature: Any) -> Any:
        with global_compiler_lock:
            register_marks()
        return super().compile(signature)


def dispatcher_of(part: KernelPart) -> Any:
    """Numba's dispatcher of a function: one for all threads, complete before any thread gets it."""
    with COMPILE_LOCK:
        if "dispatcher" not in vars(part):
            options = KERNEL_OPTIONS if part.is_kernel else INLINE_OPTIONS if part.inline else LINKED_OPTIONS
            dispatcher: Any = numba.njit(**options, **FLAGS)(part.py_func)
            dispatcher.__class__ = Dispatcher
            dispatcher.part = part
            vars(part)["dispatcher"] = dispatcher
        return vars(part)["dispatcher"]


KernelPart.make_dispatcher = staticmethod(dispatcher_of)


def object_code(kernel: KernelPart, kinds: Kinds) -> ObjectCode:
    """Compile a kernel for arguments of some types."""
    signature = numba_type(NONE)(*map(numba_type, kinds))
    with _without_garbage_collection():
        compiled = kernel.dispatcher.get_compile_result(signature)
    _, _, (content, bitcode) = compiled.library.serialize_using_object_code()
    calls_numba = any(
        function.is_declaration and function.name.startswith(NUMBA_PREFIXES)
        for function in binding.parse_bitcode(bitcode).functions
    )
    whole = not (calls_numba or compiled.library.has_dynamic_globals)
    return ObjectCode(compiled.fndesc.llvm_func_name, content, whole)


@contextmanager
def _without_garbage_collection() -> Iterator[None]:
    """Turn garbage collection off for the block: numba makes many objects, and it took a tenth of the time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
