"""The version of the kernels, computed without numba, so that checking a result needs no compiler."""

import os
import sys
from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

COMPILERS = ("numba", "llvmlite")
KERNEL_FOLDERS = (
    *(f"core/{part}" for part in ("kernels", "numerics", "quantities")),
    *(f"model/{part}" for part in ("effects", "mechanisms", "motion", "trains")),
)


@cache
def version_of_kernels() -> str:
    """Digest of the sources of kernels, the compiler and the interpreter.

    A kernel inlines formulas of other files, so its own file does not tell whether it is up to date. Each version
    has its own cache folder. An edit of a file without kernels does not change the version.
    """
    digest = sha256(sys.version.encode())
    for compiler in COMPILERS:
        # a package's file with its version: importlib.metadata takes ten times as long
        spec = find_spec(compiler)
        digest.update(Path(spec.origin).with_name("_version.py").read_bytes() if spec and spec.origin else b"")
    package = Path(__file__).resolve().parents[2]
    for folder in KERNEL_FOLDERS:
        for name in sorted(os.listdir(package / folder)):
            if name.endswith(".py"):
                with open(f"{package}/{folder}/{name}", "rb") as file:
                    digest.update(f"{folder}/{name}:".encode() + file.read())
    return digest.hexdigest()[:16]
