"""Counts of instructions by valgrind's callgrind: the same for the same code, whatever else the machine does.

numba is told a plain processor, since valgrind does not know the newest ones; so the counts hardly depend on the
machine. Instructions of machine code that is in no file are those of compiled kernels. They repeat to the last one;
all of them together, with those of Python and numpy, to 1e-4.
"""

import re
import shutil
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

PLAIN = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": "", "PYTHONHASHSEED": "0"}
"""The environment of what is counted, and of what compiles its kernels before."""
UNKNOWN = "???"  # what callgrind calls the file of code that is in none
HEADER = Path("/usr/include/valgrind/callgrind.h")
OBJECT = re.compile(r"(c?)ob=\((\d+)\)(?: (.*))?")


def missing() -> str:
    """What is not there that counting needs; empty if nothing is."""
    if shutil.which("valgrind") is None:
        return "valgrind"
    return "" if HEADER.is_file() else str(HEADER)


def command(out: Path) -> list[str]:
    """What runs a program under callgrind, not counting until it is told to."""
    return ["valgrind", "-q", "--tool=callgrind", "--instr-atstart=no", f"--callgrind-out-file={out}"]


def counts(out: Path) -> dict[str, dict[str, float]]:
    """By task: all instructions, and those of compiled kernels."""
    found = {}
    for part in out.parent.glob(f"{out.name}.*"):
        task, by_file = _read(part.read_text(encoding="utf-8").splitlines())
        total = float(by_file.total())
        found[task] = {"instructions": total, "kernel_instructions": float(by_file[UNKNOWN])}
    return found


def _read(lines: Iterable[str]) -> tuple[str, Counter[str]]:
    """The task of a file of callgrind, and the instructions by the files of the machine code.

    The line after ``calls=`` has the instructions of what was called, which stand elsewhere as well.
    """
    task, names, here, called = "", {}, "", False
    found: Counter[str] = Counter()
    for line in lines:
        if line.startswith("desc: Trigger: Client Request: "):
            task = line.split(": ", 3)[3]
        elif match := OBJECT.match(line):
            caller, number, name = match.groups()
            names[number] = name or names[number]
            here = here if caller else names[number]
        elif line.startswith("calls="):
            called = True
        elif line[:1] in set("0123456789+-*"):
            found[here] += 0 if called else int(line.split()[1])
            called = False
    return task, found
