"""The version of the kernels, known without numba: whoever asks whether a result is his needs no compiler."""

import hashlib
import sys
from functools import cache
from importlib.metadata import version
from pathlib import Path

KERNEL_FOLDERS = ("effects", "kernels", "mechanisms", "motion", "numerics")


@cache
def version_of_kernels() -> str:
    """Fingerprint of the sources of kernels, the compiler and the interpreter.

    numba renews a cached kernel only when the kernel's own file changes, not when a formula that it inlines does. A
    cache folder per version closes that hole, and survives an edit of any other file.
    """
    package = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256(f"{version('numba')} {version('llvmlite')} {sys.version}".encode())
    for folder in KERNEL_FOLDERS:
        for path in sorted((package / folder).rglob("*.py")):
            digest.update(f"{path.relative_to(package)}:".encode() + path.read_bytes())
    return digest.hexdigest()[:16]
