"""The compile decorators of the package, each flag with its reason."""

import hashlib
import sys
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import thread_time
from typing import Any

import numpy as np
from platformdirs import user_cache_path

from camopt.mistakes import BadInput, Mistake

try:
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "Environment variable")
        import llvmlite
        import numba
        from numba.core import config
        from numba.core.codegen import JITCodeLibrary
        from numba.core.compiler import Compiler
        from numba.core.registry import CPUDispatcher
except (RuntimeWarning, ValueError) as trouble:  # NUMBA_NUM_THREADS=0, NUMBA_OPT=fast
    why = f"numba does not start with its environment variables: {str(trouble).splitlines()[0]}"
    raise BadInput([Mistake("camopt", "NUMBA_…", None, why, bare=True)]) from None

from camopt.numerics.kernel_cache import KernelCache, opened_folder

types: Any = numba.types  # from here, so that no module that needs them meets numba before this one has tried it

FLAGS: dict[str, Any] = {
    "nogil": True,  # blocks of designs run on threads
    "error_model": "numpy",  # 1/0 is inf, as in the formulas; Python's model would add a branch to each division
    "fastmath": False,  # inf and signed zeros decide feasibility; and no reordering: results are bit-identical
}


class PartLibrary(JITCodeLibrary):
    """The code of what only kernels call: it becomes machine code with them, and not once more for itself."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()  # type: ignore[no-untyped-call]
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """None, which numba writes as 0."""
        self._ensure_finalized()  # type: ignore[no-untyped-call]
        return 0

    @property
    def codegen(self) -> Any:
        """What numba gives a function's environment to, with which machine code reaches the interpreter."""
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Nothing: without machine code there is no place to put it."""


class PartCompiler(Compiler):
    """Compiles a function into a ``PartLibrary``."""

    def __init__(self, typing: Any, target: Any, library: Any, *others: Any) -> None:
        own = PartLibrary(target.codegen(), "part")  # type: ignore[no-untyped-call]
        super().__init__(typing, target, own, *others)  # type: ignore[no-untyped-call]


UNWRAPPED: Any = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}  # never called from Python: compiles faster
LINKED: Any = {"pipeline_class": PartCompiler, **UNWRAPPED}
INLINE: Any = {"forceinline": True, **LINKED}  # a call left standing would keep a kernel's loop out of vectors


FEW = 48  # numbers in the largest array to fill: for more, a kernel is compiled at once
PAYS = 1.0  # seconds of plain runs, after which it is compiled

KERNEL_FOLDERS = ("effects", "mechanisms", "motion", "numerics")


def _version_of_kernels() -> str:
    """Fingerprint of what kernels are made of and with: their sources, the compiler, the interpreter.

    numba renews a cached kernel only when the kernel's own file changes, not when a formula that it inlines does. A
    cache folder per version closes that hole, and survives an edit of any other file.
    """
    package = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256(f"{numba.__version__} {llvmlite.__version__} {sys.version}".encode())
    for folder in KERNEL_FOLDERS:
        for path in sorted((package / folder).rglob("*.py")):
            digest.update(f"{path.relative_to(package)}:".encode() + path.read_bytes())
    return digest.hexdigest()[:16]


CACHE_DIR: str = vars(config)["CACHE_DIR"]  # NUMBA_CACHE_DIR
CACHE_FOLDER = opened_folder(Path(CACHE_DIR or user_cache_path("camopt")), _version_of_kernels())


class Part(CPUDispatcher):
    """A function that kernels compile into themselves; called from Python it runs as it is written."""

    def __call__(self, *arguments: Any) -> Any:
        return self.py_func(*arguments)


class Kernel(CPUDispatcher):
    """A kernel that is compiled once that pays: for many designs, or when plain runs have taken as long.

    Both give the same bits. A kernel that is on disk is not compiled, so it is taken at once.
    """

    spent: dict[Any, float]
    """Seconds of plain runs, by the types of the arguments."""
    targetctx: Any
    _cache: Any

    def _compile_for_args(self, *arguments: Any, **named: Any) -> Any:
        """The function to run: numba asks where nothing fits that is compiled."""
        types = tuple(map(self.typeof_pyval, arguments))
        work = max((values.size for values in arguments if isinstance(values, np.ndarray)), default=0)
        if work > FEW or self.spent.get(types, 0.0) > PAYS or self._cache.holds(types, self.targetctx.codegen()):
            return super()._compile_for_args(*arguments, **named)  # type: ignore[misc]
        return partial(self._plain, types)

    def _plain(self, types: Any, *arguments: Any) -> Any:
        start = thread_time()
        with np.errstate(all="ignore"):  # as machine code
            result = self.py_func(*arguments)
        self.spent[types] = self.spent.get(types, 0.0) + thread_time() - start
        return result


def _dispatched(function: Callable[..., Any], kind: type, **options: Any) -> Any:
    """A function for numba to compile, of one of the kinds above; with NUMBA_DISABLE_JIT the function itself."""
    made: Any = numba.njit(**options, **FLAGS)(function)
    if isinstance(made, CPUDispatcher):  # not with NUMBA_DISABLE_JIT
        made.__class__ = kind
    return made


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a function into each kernel that calls it."""
    return _dispatched(function, Part, **INLINE)


def called_by_kernels(function: Callable[..., Any]) -> Any:
    """Compile a function that kernels call, but not for each number."""
    return _dispatched(function, Part, **LINKED)


def compiled(function: Callable[..., Any]) -> Any:
    """Compile a kernel with numba, cached on disk."""
    kernel: Any = _dispatched(function, CPUDispatcher)
    if isinstance(kernel, CPUDispatcher):
        kernel._cache = KernelCache(function, CACHE_FOLDER)  # type: ignore[attr-defined]
    return kernel


def compiled_for_many(function: Callable[..., Any]) -> Any:
    """As ``compiled``, but plain Python where a call fills arrays of a few numbers."""
    kernel: Any = compiled(function)
    if isinstance(kernel, CPUDispatcher):
        kernel.__class__, vars(kernel)["spent"] = Kernel, {}
    return kernel
