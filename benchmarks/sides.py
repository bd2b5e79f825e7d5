"""A package to measure, and the processes that measure it."""

import json
import os
import subprocess
import sys
import tarfile
from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from sysconfig import get_path
from tempfile import TemporaryDirectory
from typing import Any
from venv import create

import callgrind
from record import Measures
from tasks import COLD

HERE = Path(__file__).resolve().parent
ENVIRONMENTS = HERE.parent / ".venv-against"
PATIENT = 10  # niceness of what compiles and counts


@dataclass(frozen=True)
class Side:
    """A package to measure, the folder of its kernels (None where they always are), and its interpreter."""

    name: str
    files: Path
    kernels: Path | None = None
    python: str = sys.executable

    def start(self, script: str, *arguments: str, under: Sequence[str] = (), **more: Any) -> subprocess.Popen[str]:
        """Begin a script of this folder with this package; ``env`` is beside what the process has."""
        kernels = {"NUMBA_CACHE_DIR": str(self.kernels)} if self.kernels else {}
        fixed = {"PYTHONPATH": str(self.files), "PYTHONHASHSEED": "0"}
        environment = os.environ | fixed | kernels | more.pop("env", {})
        command = [*under, self.python, str(HERE / script), *arguments]
        return subprocess.Popen(command, env=environment, text=True, **more)

    def run(self, *arguments: str, under: Sequence[str] = (), more: dict[str, str] | None = None) -> dict[str, Any]:
        """What ``measuring.py`` prints, run with this package."""
        process = self.start("measuring.py", *arguments, under=under, env=more or {}, stdout=subprocess.PIPE)
        printed, _ = process.communicate()
        if process.returncode:
            raise subprocess.CalledProcessError(process.returncode, process.args)
        told: dict[str, Any] = json.loads(printed.splitlines()[-1])
        if Path(told["package"]) != self.files / "camopt":
            raise RuntimeError(f"{told['package']} was measured in place of {self.files}")
        return told

    def timed(self, tasks: Sequence[str], verb: str = "time") -> Measures:
        """One round of those that the package can do, with the rival or without (``own``)."""
        times: Measures = self.run(verb, *tasks)["tasks"]
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


def side_of(commit: str) -> Side:
    """The package of a commit, installed from the repository in an environment of its own, which is kept.

    The environment sees the packages of this one, and has others where the commit asks for them.
    """
    folder = ENVIRONMENTS / commit
    python, library = folder / "bin" / "python", Path(get_path("purelib", vars={"base": str(folder)}))
    if not (folder / "kernels").is_dir():
        say(f"{commit[:9]}: installing")
        create(folder, clear=True, symlinks=True)
        (library / "packages.pth").write_text(get_path("purelib"), encoding="utf-8")
        with TemporaryDirectory() as source:
            with tarfile.open(fileobj=BytesIO(git("archive", commit))) as archive:
                archive.extractall(source, filter="data")
            install = [sys.executable, "-m", "pip", "--python", str(python), "install", "--quiet"]
            subprocess.run([*install, f"{source}[excel,cad,video]"], check=True)
        (folder / "kernels").mkdir()
    return Side(commit[:9], library, folder / "kernels", str(python))


def commit_of(revision: str) -> str:
    return git("rev-parse", "--verify", f"{revision}^{{commit}}").decode().strip()
