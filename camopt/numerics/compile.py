"""The compile decorators of the package, each flag with its reason."""

import hashlib
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from platformdirs import user_cache_path

from camopt.mistakes import BadInput, Mistake

try:
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "Environment variable")
        import llvmlite
        import numba
        from numba.core import config
        from numba.core.dispatcher import Dispatcher
except (RuntimeWarning, ValueError) as trouble:  # NUMBA_NUM_THREADS=0, NUMBA_OPT=fast
    why = f"numba does not start with its environment variables: {str(trouble).splitlines()[0]}"
    raise BadInput([Mistake("camopt", "NUMBA_…", None, why, bare=True)]) from None

from camopt.numerics.kernel_cache import KernelCache, opened_folder

FLAGS: dict[str, Any] = {
    "nogil": True,  # blocks of designs run on threads
    "error_model": "numpy",  # 1/0 is inf, as in the formulas; Python's model would add a branch to each division
    "fastmath": False,  # inf and signed zeros decide feasibility; and no reordering: results are bit-identical
}


INLINE: Any = {"forceinline": True}  # a call left standing would keep a kernel's loop out of vectors


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


UNWRAPPED: Any = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}  # never called from Python: compiles faster


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a function into each kernel that calls it."""
    return numba.njit(**INLINE, **UNWRAPPED, **FLAGS)(function)


def called(function: Callable[..., Any]) -> Any:
    """Compile a function that kernels call, but rarely."""
    return numba.njit(**UNWRAPPED, **FLAGS)(function)


def compiled(function: Callable[..., Any]) -> Any:
    """Compile a kernel with numba, cached on disk."""
    kernel: Any = numba.njit(**FLAGS)(function)
    if isinstance(kernel, Dispatcher):  # not with NUMBA_DISABLE_JIT
        kernel._cache = KernelCache(function, CACHE_FOLDER)  # type: ignore[attr-defined]
    return kernel
