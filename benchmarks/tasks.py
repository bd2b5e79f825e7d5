"""What the record of speed measures: tasks of camopt, each with a rival that does not change from commit to commit.

camopt is asked through its public functions and commands, so that the tasks of one commit measure the package of
another one.
"""

import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from functools import partial
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from random_cams import by_numpy, random_cams
from rival_c import MECHANISMS, rival
from smallest_cams import by_brentq, smallest_cam
from throughput import Job, carried_job, default_job, jobs, loaded_job

from camopt import evaluate_designs, optimise

STEPS, RUNS = 100, 15
CORES = os.cpu_count() or 1
IMPORT_NUMPY = [sys.executable, "-c", "import numpy"]
BILLION = ("--base-radius", "20:150:0.0005", "--keep", "front-only")
COMMANDS: dict[str, tuple[str, ...]] = {
    "help": ("--help",),
    "evaluate": ("evaluate", "exhaust-valve"),
    "certify": ("certify", "exhaust-valve"),
    "optimise": ("optimise", "exhaust-valve"),
    "sweep": ("sweep", "--rpm", "1000", "--max-pressure", "30"),
    "synthesise": ("synthesise", "roller-1000rpm", "--max-pressure", "30"),
    "laws": ("laws",),
    "effects": ("effects", "exhaust-valve"),
    "harmonics": ("harmonics", "exhaust-valve"),
    "tolerance": ("tolerance", "exhaust-valve", "--set", "tolerances.profile=0.02"),
    "points": ("evaluate", "exhaust-valve", "--points", "points.csv"),
    "front of 1e9": ("sweep", "--rpm", "1000", "--max-pressure", "30", *BILLION),
}
FIRST = ("evaluate", "certify", "optimise", "sweep", "synthesise", "tolerance")
COLD = {f"camopt {name}, first": name for name in FIRST}
"""Tasks that compile: the first answers after an installation. By task, the command."""


class Task(NamedTuple):
    """What is measured: two calls, of camopt and of its rival."""

    own: Callable[[], Any]
    rival: Callable[[], Any]
    designs: int = 1
    """Designs of one call."""
    runs: int = RUNS
    """In one round of measuring, after one that does not count; or 1, and none before it. Many short ones: only
    they fit into the quiet moments of a busy machine."""


def _sweep(job: Job, threads: int, runs: int = RUNS) -> Task:
    return Task(job.swept(threads), job.sampled(rival("float"), threads), job.designs, runs)


def _smallest() -> Task:
    """The smallest radius, against a root of 3600 samples."""
    scene = smallest_cam("cycloidal")
    return Task(lambda: optimise(scene), lambda: by_brentq("cycloidal"))


def _evaluation() -> Task:
    """Three extremes of each of many cams, against numpy at the same accuracy."""
    scene, frame = random_cams("cycloidal")
    return Task(lambda: evaluate_designs(scene, frame), lambda: by_numpy("cycloidal", frame), len(frame))


def _run(command: Sequence[str]) -> None:
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def _camopt(arguments: Sequence[str], first: bool) -> None:
    """A command in an empty folder; for a first answer, this is the home as well."""
    with TemporaryDirectory() as folder:
        home = dict.fromkeys(("HOME", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR"), folder) if first else {}
        command = [sys.executable, "-m", "camopt", *arguments]
        subprocess.run(command, check=True, cwd=folder, env=os.environ | home, stdout=subprocess.DEVNULL)


def _command(name: str, first: bool) -> Task:
    """A command as a process, against one that imports numpy."""
    return Task(partial(_camopt, COMMANDS[name], first), partial(_run, IMPORT_NUMPY), runs=1)


SWEEPS: dict[str, Callable[[], Task]] = {
    **{name.replace("_", " "): lambda name=name: _sweep(jobs(STEPS)[name], 1) for name in MECHANISMS},
    "limit on a load": lambda: _sweep(loaded_job(STEPS), 1),
    "through a train": lambda: _sweep(carried_job(STEPS), 1),
}
"""Sweeps of each mechanism on one thread, one with a limit on a load, and one through a train."""

COUNTED = {**SWEEPS, "default sweep": lambda: _sweep(default_job(), 1, runs=2)}
"""Tasks whose instructions can be counted: on one thread."""

QUICK: dict[str, Callable[[], Task]] = {**SWEEPS, "smallest radius": _smallest, "evaluation": _evaluation}

TASKS: dict[str, Callable[[], Task]] = {
    **QUICK,
    "default sweep": lambda: _sweep(default_job(), CORES, runs=2),
    **{f"camopt {name}": partial(_command, name, False) for name in COMMANDS},
    **{name: partial(_command, command, True) for name, command in COLD.items()},
}
"""All of them; those of ``QUICK`` first."""
