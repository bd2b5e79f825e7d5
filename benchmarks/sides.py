"""A package to measure, and the processes that measure it."""

import json
import os
import subprocess
import sys
import tarfile
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import callgrind
from record import Measures
from tasks import COLD

HERE = Path(__file__).resolve().parent
PATIENT = 10  # niceness of what compiles and counts


@dataclass(frozen=True)
class Side:
    """A package to measure, and the folder of its kernels; None where they always are."""

    name: str
    files: Path
    kernels: Path | None = None

    def run(self, *arguments: str, under: Sequence[str] = (), more: dict[str, str] | None = None) -> dict[str, Any]:
        """What ``measuring.py`` prints, run with this package."""
        kernels = {"NUMBA_CACHE_DIR": str(self.kernels)} if self.kernels else {}
        environment = os.environ | {"PYTHONPATH": str(self.files)} | kernels | (more or {})
        command = [*under, sys.executable, str(HERE / "measuring.py"), *arguments]
        done = subprocess.run(command, check=True, env=environment, text=True, stdout=subprocess.PIPE)
        told: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
        if Path(told["package"]) != self.files / "camopt":
            raise RuntimeError(f"{told['package']} was measured in place of {self.files}")
        return told

    def timed(self, tasks: Sequence[str]) -> Measures:
        """One round of those that the package can do."""
        times: Measures = self.run("time", *tasks)["tasks"]
        return times

    def warm(self, tasks: Sequence[str], more: dict[str, str] | None = None) -> None:
        """Have the kernels of tasks on disk."""
        say(f"{self.name}: compiling")
        self.run("warm", *(name for name in tasks if name not in COLD), under=patient(), more=more)

    def counted(self, tasks: Sequence[str]) -> Measures:
        """The instructions of tasks."""
        if not tasks:
            return {}
        self.warm(tasks, callgrind.PLAIN)
        say(f"{self.name}: counting")
        with TemporaryDirectory() as folder:
            out = Path(folder, "callgrind")
            self.run("count", *tasks, under=[*patient(), *callgrind.command(out)], more=callgrind.PLAIN)
            return callgrind.counts(out)


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def patient() -> list[str]:
    """What makes a command give way to others."""
    return ["nice", "-n", str(PATIENT)] if os.name == "posix" else []


def git(*arguments: str) -> bytes:
    return subprocess.run(["git", *arguments], cwd=HERE.parent, check=True, stdout=subprocess.PIPE).stdout


def side_of(commit: str, stack: ExitStack, kernels: Path | None) -> Side:
    """The package of a commit in a folder that goes with the stack; its kernels, too, unless they are kept."""
    folder = Path(stack.enter_context(TemporaryDirectory())).resolve()
    with tarfile.open(fileobj=BytesIO(git("archive", commit, "camopt"))) as archive:
        archive.extractall(folder, filter="data")
    return Side(commit[:9], folder, (kernels or folder / "kernels") / commit)
