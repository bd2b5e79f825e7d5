"""Run the tests that know a mutated module best, quickest first, until one fails or the time is over.

The mutated module is the one that differs from the last commit; without one, the core tests show that all is well
(``cosmic-ray baseline``). Exit code 1 if a test fails, else 0.
"""

import os
import resource
import signal
import subprocess
import sys
from functools import cache
from pathlib import Path

TESTS = Path(__file__).parents[1]
CORE = ("published", "evaluation", "points", "tables", "bad_input")
"""Quick tests of what most modules have a part in."""
ENOUGH = 300
"""Seconds of CPU time for the tests of one mutant, whatever else the machine does."""


def changed_modules() -> list[str]:
    """The modules that differ from the last commit, as ``camopt.model.effects.force``."""
    command = ["git", "diff", "--name-only", "--", "camopt"]
    paths = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    return [".".join(Path(path).with_suffix("").parts) for path in paths]


@cache
def texts_of_tests() -> dict[Path, str]:
    return {path: path.read_text(encoding="utf-8") for path in sorted(TESTS.rglob("test_*.py"))}


@cache
def tests_that_name(word: str) -> list[Path]:
    return [path for path, text in texts_of_tests().items() if word in text]


@cache
def core() -> list[Path]:
    return [next(TESTS.rglob(f"test_{each}.py")) for each in CORE]


def killers(module: str) -> list[Path]:
    """Tests of a module's own name, of the core, those that import it, the shortest first, those of its folder."""
    room, _, name = module.rpartition(".")
    texts, near = texts_of_tests(), tests_that_name(room)
    direct = [
        path
        for path in near
        if module in texts[path] or (f"from {room} import" in texts[path] and name in texts[path])
    ]
    near = near if room != "camopt" else []
    own = [path for path in texts if path.stem.removeprefix("test_").startswith(name.rstrip("s"))]
    shortest = [path for found in (direct, near) for path in sorted(found, key=lambda path: len(texts[path]))]
    return list(dict.fromkeys([*own, *core(), *shortest]))


def main() -> int:
    found = [path for module in changed_modules() for path in killers(module)] or core()
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *map(str, found)]
    done = subprocess.run(
        command, env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, preexec_fn=_limit_cpu_time, check=False
    )
    return int(done.returncode not in (0, -signal.SIGXCPU))


def _limit_cpu_time() -> None:
    """End this process after its seconds."""
    resource.setrlimit(resource.RLIMIT_CPU, (ENOUGH, ENOUGH + 5))


if __name__ == "__main__":
    sys.exit(main())
