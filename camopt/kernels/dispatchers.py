"""The compile options of the package, each with its reason, and what numba makes of marked functions."""

import warnings
from threading import RLock
from typing import Any

from camopt.kernels import compile
from camopt.kernels.by_address import Reached
from camopt.kernels.compile import Kernel, KernelForMany, Part
from camopt.kernels.compiling import COMPILING
from camopt.mistakes import BadInput, Mistake

try:
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "Environment variable")
        import numba
        from numba.core import config, event
        from numba.core.compiler_lock import global_compiler_lock
        from numba.core.registry import CPUDispatcher
except (RuntimeWarning, ValueError) as trouble:  # NUMBA_NUM_THREADS=0, NUMBA_OPT=fast
    why = f"numba does not start with its environment variables: {str(trouble).splitlines()[0]}"
    raise BadInput([Mistake("camopt", "NUMBA_…", None, why, bare=True)]) from None

from camopt.kernels.kernel_cache import KernelCache, cache_root, opened_folder
from camopt.kernels.numba_types import INLINE, LINKED, numba_type, tell_numba
from camopt.kernels.version import version_of_kernels

FLAGS: dict[str, Any] = {
    "_nrt": False,  # arrays are made outside: code that counts references to them takes long to compile
    "nogil": True,  # blocks of designs run on threads
    "error_model": "numpy",  # 1/0 is inf, as in the formulas; Python's model would add a branch to each division
    "fastmath": False,  # inf and signed zeros decide feasibility; and no reordering: results are bit-identical
}

CACHE_DIR: str = vars(config)["CACHE_DIR"]  # NUMBA_CACHE_DIR
CACHE_FOLDER = opened_folder(cache_root(CACHE_DIR), version_of_kernels())


class Listener(event.Listener):
    """Hears of each kernel that numba compiles."""

    def on_start(self, happening: Any) -> None:
        COMPILING.begin()

    def on_end(self, happening: Any) -> None:
        COMPILING.end()


event.register("numba:compile", Listener())  # type: ignore[no-untyped-call]


class Dispatcher(CPUDispatcher):
    """What numba compiles a marked function by."""

    part: Part
    targetctx: Any
    _cache: Any

    def compile(self, signature: Any) -> Any:
        with global_compiler_lock:
            tell_numba()
        return super().compile(signature)


class DispatcherForMany(Dispatcher):
    """As ``Dispatcher``, of a kernel that is compiled once that pays."""

    part: KernelForMany

    def _compile_for_args(self, *arguments: Any, **named: Any) -> Any:
        """The function to run: numba asks where nothing fits that is compiled."""
        types = tuple(map(self.typeof_pyval, arguments))
        spent = self.part.spent
        dear = self.part.dear(arguments) or spent.get(types, 0.0) > compile.PAYS
        if dear or self._cache.holds(types, self.targetctx.codegen()):
            return super()._compile_for_args(*arguments, **named)  # type: ignore[misc]

        def plain(*arguments: Any) -> Any:
            result, seconds = self.part.plain(arguments)
            spent[types] = spent.get(types, 0.0) + seconds
            return result

        return plain


LOCK = RLock()


def dispatcher_of(part: Part) -> Any:
    """What numba compiles a function by: one for each, whatever threads ask for it, and whole before any has it."""
    with LOCK:
        if "dispatcher" not in vars(part):
            vars(part)["dispatcher"] = _made(part)
        return vars(part)["dispatcher"]


def _made(part: Part) -> Any:
    kernel = isinstance(part, Kernel)
    options = {} if kernel else INLINE if part.inline else LINKED
    made: Any = numba.njit(**options, **FLAGS)(part.py_func)
    made.__class__ = DispatcherForMany if isinstance(part, KernelForMany) else Dispatcher
    made.part = part
    if kernel:
        made._cache = KernelCache(part.py_func, CACHE_FOLDER)
    return made


def machine_code(kernel: Reached) -> int:
    """The address of a kernel for arguments of given types."""
    arguments = [numba_type(kind) for kind in kernel.code.arguments]
    compiled = kernel.kernel.dispatcher.get_compile_result(numba_type(kernel.code.returns)(*arguments))
    address: int = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)
    return address
