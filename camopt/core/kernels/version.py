"""The version of the kernels, known without numba: whoever asks whether a result is his needs no compiler."""

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
    """Fingerprint of the sources of kernels, the compiler and the interpreter.

    numba renews a cached kernel only when the kernel's own file changes, not when a formula that it inlines does. A
    cache folder per version closes that hole, and survives an edit of any other file.
    """
    digest = sha256(sys.version.encode())
    for compiler in COMPILERS:
        # the file that has the version of a package: importlib.metadata takes ten times as long to tell it
        found = find_spec(compiler)
        digest.update(Path(found.origin).with_name("_version.py").read_bytes() if found and found.origin else b"")
    package = Path(__file__).resolve().parents[2]
    for folder in KERNEL_FOLDERS:
        for name in sorted(os.listdir(package / folder)):
            if name.endswith(".py"):
                with open(f"{package}/{folder}/{name}", "rb") as file:
                    digest.update(f"{folder}/{name}:".encode() + file.read())
    return digest.hexdigest()[:16]
