"""How long people wait for an answer: every command, shipped scenes, and cams with all their loads.

    python benchmarks/first_answers.py [RUNS [COMMAND …]]

prints Markdown tables, or the lines of some commands. Each command is a process of its own. "First" is the first
one after an installation: no kernel is on disk. "Warm" ones find in the user's folder what those before them have
compiled. The figure is the least of the runs (5), in wall seconds and, after the slash, in CPU seconds; in brackets
the wall time over that of a process that imports numpy.
"""

import os
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import tomli_w
from measuring import spent
from tasks import COMMANDS, IMPORT_NUMPY

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from support.cams import CONTACTS, SWUNG, UNGUIDED, WORN, cam_with

from camopt import shipped_scenes

RUNS = 5
SETTLING = 3
"""Runs that compile what pays, before the warm ones."""
EVERY = COMMANDS | {
    "scenes": ("scenes",),
    "laws": ("laws",),
    "effects": ("effects", "exhaust-valve"),
    "evaluate --plot": ("evaluate", "exhaust-valve", "--plot", "out.png"),
    "frontier": ("frontier", "exhaust-valve", "--values", "5"),
    "accuracy": ("accuracy", "exhaust-valve"),
    "report": ("report", "exhaust-valve", "--out", "out.html"),
    "export": ("export", "exhaust-valve", "out.dxf"),
}
LOADED = ("evaluate", "certify", "optimise")
"""Commands that are asked of cams with all their loads."""


def loaded_cams(folder: Path) -> Iterator[str]:
    """Write a scene for each contact, with every load that its mechanism knows; their names."""
    for contact, follower in CONTACTS.items():
        dynamics = SWUNG if follower["motion"] == "oscillating" else UNGUIDED
        scene = cam_with(contact, dynamics=dynamics, materials=WORN)
        (folder / f"{contact}.toml").write_text(tomli_w.dumps(scene), encoding="utf-8")
        yield contact


def seconds(command: Sequence[str], kernels: dict[str, str] | None = None) -> tuple[float, float]:
    """Wall and CPU seconds of one command, in a folder of its own."""
    with TemporaryDirectory() as folder:
        environment = os.environ | (kernels or {})
        return spent(lambda: subprocess.run(command, check=False, cwd=folder, env=environment, capture_output=True))


@cache
def of_numpy() -> float:
    """The least wall seconds of a process that imports numpy."""
    return min(seconds(IMPORT_NUMPY)[0] for _ in range(10))


def answers(arguments: tuple[str, ...], scenes: Path, runs: int) -> tuple[str, str]:
    """Cells of a table: the least first and the least warm time of a command."""
    words = [str(scenes / word) if word.endswith(".toml") else word for word in arguments]
    command, first = [sys.executable, "-m", "camopt", *words], []
    for _ in range(runs):
        with TemporaryDirectory() as kernels:
            first.append(seconds(command, {"NUMBA_CACHE_DIR": kernels}))
    warm = [seconds(command) for _ in range(SETTLING + runs)][SETTLING:]
    return cell(first), cell(warm)


def cell(times: list[tuple[float, float]]) -> str:
    """The least wall and CPU seconds of some runs, and times that of numpy."""
    wall, cpu = (min(each) for each in zip(*times, strict=True))
    return f"{wall:.2f} / {cpu:.2f} ({wall / of_numpy():.1f})"


def of_commands(names: Iterable[str], scenes: Path, runs: int) -> Iterator[str]:
    """Lines of a table of commands."""
    for name in names:
        yield f"| {name} | {' | '.join(answers(EVERY[name], scenes, runs))} |"


def lines(runs: int) -> Iterator[str]:
    """Three tables: commands, the smallest cam of every shipped scene, cams with all loads."""
    with TemporaryDirectory() as folder:
        scenes = Path(folder)
        yield from ("| command | first, s | warm, s |", "|---|---:|---:|")
        yield from of_commands(EVERY, scenes, runs)
        yield from ("", "| `optimise` of | first, s | warm, s |", "|---|---:|---:|")
        for name in shipped_scenes():
            yield f"| {name} | {' | '.join(answers(('optimise', name), scenes, runs))} |"
        heads = " | ".join(f"{name}: first | warm" for name in LOADED)
        yield from ("", f"| all loads, s | {heads} |", "|---|" + "---:|" * 2 * len(LOADED))
        for name in loaded_cams(scenes):
            cells = [cell for command in LOADED for cell in answers((command, f"{name}.toml"), scenes, runs)]
            yield f"| {name} | {' | '.join(cells)} |"


if __name__ == "__main__":
    number, names = int(sys.argv[1]) if len(sys.argv) > 1 else RUNS, sys.argv[2:]
    for line in of_commands(names, Path(), number) if names else lines(number):
        print(line, flush=True)
