"""Kernels compiled by a process of its own, while this one goes on without them.

It is this package run as a program, at a lower priority, and ends when the kernels are on disk. Whatever goes
wrong in it, this process computes the same without them.
"""

import os
import pickle
import subprocess
import sys
from contextlib import suppress
from importlib import import_module
from threading import Lock
from typing import Any

NICE = 5  # less than the priority of this process

PROCESSES: list[subprocess.Popen[bytes]] = []
"""Of this process: the one that compiles, or did last."""
ONE = Lock()


def compile_beside(kernels: list[tuple[Any, Any]]) -> None:
    """Have a kernel compiled, the last of some, after those that it calls; not while others are being compiled."""
    with ONE:
        busy = any(process.poll() is None for process in PROCESSES)
        if busy or not sys.executable or not kernels[-1][0].file(kernels[-1][1]).claim():
            return
        asked = [(kernel.__module__, kernel.__qualname__, kinds) for kernel, kinds in kernels]
        with suppress(OSError):
            PROCESSES[:] = [_begun(pickle.dumps(asked).hex())]


def _begun(asked: str) -> subprocess.Popen[bytes]:
    """The program, which imports what this process does, and nothing from the folder where it is."""
    nowhere = subprocess.DEVNULL
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-P", "-m", __name__, asked]
    return subprocess.Popen(command, stdin=nowhere, stdout=nowhere, stderr=nowhere, env=environment)


def main(asked: str) -> None:
    """Compile what another process asks for."""
    if hasattr(os, "nice"):
        os.nice(NICE)
    for module, name, kinds in pickle.loads(bytes.fromhex(asked)):
        getattr(import_module(module), name).machine_code(kinds)


if __name__ == "__main__":
    main(sys.argv[1])
