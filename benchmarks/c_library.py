"""C files of this folder, compiled and loaded; ``CC`` names the compiler, as for make."""

import ctypes
import os
import shlex
import subprocess
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory


def _command() -> list[str]:
    return shlex.split(os.environ.get("CC", "cc"))


def c_compiler() -> str | None:
    """What the C compiler calls itself; None where there is none."""
    try:
        about = subprocess.run([*_command(), "--version"], check=True, capture_output=True, text=True).stdout
    except (FileNotFoundError, subprocess.CalledProcessError):
        return None
    return about.splitlines()[0]


def c_library(source: str, flags: Sequence[str]) -> ctypes.CDLL:
    """A C file of this folder as a library.

    It is linked without the flags: with ``-ffast-math``, gcc would link what makes the whole process take denormal
    numbers as 0.

    Raises
    ------
    subprocess.CalledProcessError
        If it cannot be compiled.
    """
    file = Path(__file__).with_name(source)
    with TemporaryDirectory() as folder:
        made, library = Path(folder, "made.o"), Path(folder, "made.so")
        subprocess.run([*_command(), *flags, "-fPIC", "-c", str(file), "-o", str(made)], check=True)
        subprocess.run([*_command(), "-shared", str(made), "-o", str(library), "-lm"], check=True)
        return ctypes.CDLL(str(library))
