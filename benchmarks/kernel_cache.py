"""What faults of the cache of compiled kernels do: ``python benchmarks/kernel_cache.py [FLIPS [RACERS [sweep]]]``.

Processes call a kernel, or do a small sweep, with a cache that is torn, has flipped bits, belongs to another user,
is not there, is of another processor, or is filled by many of them at once, some of which are killed. It is good if
they give the bytes that they give with a whole cache, say nothing (but that a folder is not private), and leave no
file that is not whole.
``kernel_cache.py --answer`` is one of the processes. Owners and homes need root and ``setpriv`` (util-linux).
"""

import os
import random
import resource
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from hashlib import sha256
from pathlib import Path
from shutil import copytree
from tempfile import TemporaryDirectory
from time import sleep
from typing import Any, NamedTuple

import numpy as np

import camopt
from camopt.core.kernels.compile import compiled
from camopt.core.kernels.compile_notice import compilation_notice
from camopt.core.kernels.compile_rule import compile_at_first_call
from camopt.core.kernels.kernel_cache import content_if_undamaged

SEED = 33
WHAT = "".join(sys.argv[3:4])
COLD, WARM = "compiled", "loaded"
OWNED = ["setpriv", "--bounding-set=-dac_override,-dac_read_search"]
"""Root as any other user: what belongs to others, and what it may not write to, is out of reach."""
NOBODY = [
    *("setpriv", "--reuid=54321", "--clear-groups"),
    *("--inh-caps=+dac_override,+dac_read_search", "--ambient-caps=+dac_override,+dac_read_search"),
]
"""A user whom the system does not know, as in a container, who can read this file all the same."""
PLACES = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME")


@compiled
def total(values, result):
    """A kernel that takes little time to compile."""
    for value in values:
        result[0] += value


def totals() -> list[float]:
    """What the kernel finds for two kinds of numbers."""
    found = np.zeros((2, 1))
    for kind, result in zip((float, np.int64), found, strict=True):
        total(np.arange(1, 9, dtype=kind), result)
    return found.tolist()


def answer(what: str) -> None:
    """Work, and print the digest of what is found, and whether kernels were compiled."""
    compile_at_first_call()
    notices: list[str] = []
    with compilation_notice(lambda: notices.append(COLD)):
        found = swept() if what == "sweep" else totals()
    print(sha256(repr(found).encode()).hexdigest(), *(notices or [WARM]))


def swept() -> Any:
    """What a small sweep finds."""
    sizes = {"start": 30, "stop": 100, "step": 0.1}
    scene = camopt.find_scene("roller-1000rpm").replace(search={"base_radius": sizes, "law": ["harmonic"]})
    found = camopt.sweep(scene, workers=1)
    return found.designs, found.feasible, found.pareto, found.best


class Answer(NamedTuple):
    """What a process printed, and how it ended."""

    digest: str
    kernels: str
    code: int
    words: str


def begun(places: dict[str, str], before: list[str] | None = None, **options: Any) -> subprocess.Popen[str]:
    """A process that sweeps; where its cache is, is said by ``places`` alone."""
    environment = {name: value for name, value in os.environ.items() if name not in PLACES}
    return subprocess.Popen(
        [*(before or []), sys.executable, __file__, "--answer", WHAT],
        env={**environment, **places},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def ended(process: subprocess.Popen[str]) -> Answer:
    printed, words = process.communicate()
    digest, kernels = printed.split() or ("", "")
    return Answer(digest, kernels, process.returncode, words)


class Trial:
    """Counts what is good."""

    def __init__(self, digest: str) -> None:
        self.digest = digest
        self.tried: dict[str, int] = {}
        self.wrong: list[str] = []

    def expect(self, name: str, found: Answer, kernels: str = COLD, also: bool = True) -> None:
        """Count a case: the same answer without a word, kernels loaded or compiled as they should be."""
        self.tried[name] = self.tried.get(name, 0) + 1
        if found != (self.digest, kernels, 0, "") or not also:
            self.wrong.append(name)
            print(f"  {name}: {found.kernels}, exit {found.code}, {found.words.strip()[-300:]}", flush=True)

    def tell(self, name: str) -> None:
        """Print a line on the cases of a name."""
        tried = self.tried[name]
        print(f"{name}: {tried} tried, {tried - self.wrong.count(name)} good", flush=True)


def kernels_of(cache: Path) -> list[Path]:
    return sorted(cache.rglob("*.kernel"))


def flipped(data: bytes, bit: int) -> bytes:
    changed = bytearray(data)
    changed[bit // 8] ^= 1 << bit % 8
    return bytes(changed)


DAMAGE: dict[str, Callable[[bytes, random.Random], bytes]] = {
    "emptied": lambda data, chance: b"",
    "cut": lambda data, chance: data[: chance.randrange(len(data))],
    "zeros at the end": lambda data, chance: data[: (n := chance.randrange(len(data)))] + bytes(len(data) - n),
    "a flipped bit": lambda data, chance: flipped(data, chance.randrange(8 * len(data))),
}


def damaged(trial: Trial, whole: Path, folder: Path, flips: int) -> None:
    """One file is damaged, or all are; the next run finds the cache whole again."""
    chance = random.Random(SEED)
    for name, damage in DAMAGE.items():
        for number in range(flips):
            cache = copytree(whole, folder / f"{name} {number}")
            files = kernels_of(cache)
            for file in files if number == 0 else [chance.choice(files)]:
                file.write_bytes(damage(file.read_bytes(), chance))
            trial.expect(name, ended(begun({"NUMBA_CACHE_DIR": str(cache)})))
            trial.expect(
                f"the run after: {name}", ended(begun({"NUMBA_CACHE_DIR": str(cache)})), WARM, only_whole(cache)
            )
        trial.tell(name)
        trial.tell(f"the run after: {name}")


def only_whole(cache: Path) -> bool:
    """Whether every file in a cache is a kernel as it was written."""
    files = [path for path in cache.rglob("*") if path.is_file()]
    return all(file.suffix == ".kernel" and content_if_undamaged(file.read_bytes()) is not None for file in files)


def in_other_places(trial: Trial, whole: Path, folder: Path) -> None:
    """Caches that cannot be written to or read, and no place for one."""
    modes = {"open to all": 0o777, "read-only": 0o500, "another's": 0o755, "another's, closed": 0o700}
    for name, mode in modes.items():
        cache = copytree(whole, folder / name)
        for path in sorted([cache, *cache.rglob("*")], reverse=True):
            path.chmod(mode)
            os.chown(path, *((12345, 12345) if "another" in name else (0, 0)))
        found = ended(begun({"NUMBA_CACHE_DIR": str(cache)}, OWNED))
        said = found.words.count("\n") == 1 and "is not used: it is not a folder of yours" in found.words
        trial.expect(name, found._replace(words=""), COLD, said)
        trial.tell(name)
    file = folder / "a file"
    file.touch()
    (folder / "loop").symlink_to("loop")
    homes: dict[str, tuple[dict[str, str], list[str]]] = {
        "a file in place of the cache": ({"NUMBA_CACHE_DIR": str(file)}, []),
        "a device in place of the cache": ({"NUMBA_CACHE_DIR": "/dev/null"}, []),
        "a loop of links in place of the cache": ({"NUMBA_CACHE_DIR": str(folder / "loop")}, []),
        "a name that is too long": ({"NUMBA_CACHE_DIR": str(folder / ("a" * 300))}, []),
        "a home that does not exist": ({"HOME": "/proc/none"}, []),
        "no home, and an unknown user": ({}, NOBODY),
        "an empty home, and an unknown user": ({"HOME": ""}, NOBODY),
        "a relative home, and an unknown user": ({"HOME": "home"}, NOBODY),
        "a home of the root's, and an unknown user": ({"HOME": "/proc/1"}, NOBODY),
    }
    for name, (places, before) in homes.items():
        here = folder / "here"
        here.mkdir(exist_ok=True)
        answer = ended(begun(places, before, cwd=here))
        trial.expect(name, answer, COLD, not any(here.iterdir()))
        trial.tell(name)
    for name, limit in (("a full disk", 0), ("a disk that fills up", 20_000)):
        bound = partial(resource.setrlimit, resource.RLIMIT_FSIZE, (limit, limit))
        cache = folder / name
        answer = ended(begun({"NUMBA_CACHE_DIR": str(cache)}, preexec_fn=bound))
        trial.expect(name, answer, COLD, only_whole(cache))
        trial.tell(name)


def of_processors(trial: Trial, whole: Path, folder: Path) -> None:
    """Kernels for one processor are none for another one."""
    cache = copytree(whole, folder / "processors")
    for name in ("generic", "x86-64-v2", "nehalem"):
        here = {"NUMBA_CACHE_DIR": str(cache), "NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": ""}
        trial.expect("another processor", ended(begun(here)), COLD)
        trial.expect("another processor, again", ended(begun(here)), WARM)
        trial.expect(
            "the first processor after it", ended(begun({"NUMBA_CACHE_DIR": str(cache)})), WARM, only_whole(cache)
        )
    for name in ("another processor", "another processor, again", "the first processor after it"):
        trial.tell(name)


def racing(trial: Trial, folder: Path, racers: int) -> None:
    """Many processes fill a cache at once; and again, while each second one is killed at some moment."""
    cache = {"NUMBA_CACHE_DIR": str(folder / "race")}
    for found in map(ended, [begun(cache) for _ in range(racers)]):
        trial.expect("at once", found, found.kernels or COLD)  # whoever comes late loads
    trial.tell("at once")
    trial.expect("after a race", ended(begun(cache)), WARM, only_whole(folder / "race"))
    trial.tell("after a race")
    killed(trial, folder / "killed", racers)


def killed(trial: Trial, cache: Path, racers: int) -> None:
    """Processes die while the cache is filled: when its number of files grows."""
    places, runs = {"NUMBA_CACHE_DIR": str(cache)}, []
    for number in range(racers):
        run, before = begun(places), len([*cache.rglob("*")])
        while run.poll() is None and len([*cache.rglob("*")]) <= before + number % 2:
            sleep(0.001)
        run.kill()
        runs.append(run.communicate())
    found = ended(begun(places))
    trial.expect("after deaths", found, found.kernels or COLD)  # loaded if all of them got that far
    trial.expect("after deaths", ended(begun(places)), WARM)
    trial.tell("after deaths")
    left = len([*cache.rglob("*.partial")])
    print(f"half written files that stay: {left}")


def main(flips: int = 5, racers: int = 8) -> int:
    """Try all, and print a line for each."""
    with TemporaryDirectory() as name:
        whole = Path(name) / "whole"
        first = ended(begun({"NUMBA_CACHE_DIR": str(whole)}))
        trial = Trial(first.digest)
        trial.expect("an empty cache", first)
        trial.expect("a whole cache", ended(begun({"NUMBA_CACHE_DIR": str(whole)})), WARM, only_whole(whole))
        print(f"{len(kernels_of(whole))} kernels")
        in_other_places(trial, whole, Path(name))
        of_processors(trial, whole, Path(name))
        racing(trial, Path(name), racers)
        damaged(trial, whole, Path(name), flips)
        return min(len(trial.wrong), 1)


if __name__ == "__main__":
    sys.exit(answer(sys.argv[2]) if sys.argv[1:2] == ["--answer"] else main(*map(int, sys.argv[1:3])))
