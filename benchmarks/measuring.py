"""A process that measures tasks with the package on ``PYTHONPATH``; the last line that it prints is JSON.

    python measuring.py time|own|count|warm TASK …

``time`` tells the least wall and CPU seconds of camopt and of its rival, ``own`` those of camopt alone. ``count``
runs under callgrind, which writes the instructions of each task to a file. ``warm`` runs each task so long that its
kernels are compiled, which camopt does once that pays, and on disk.
"""

import json
import resource
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from subprocess import CalledProcessError
from time import perf_counter
from typing import Any

from c_library import c_library
from compiled import compile_early
from record import TIMES
from tasks import COUNTED, TASKS, Task

import camopt

WARM = 1.0  # seconds of a task, after which camopt has its kernels from disk, or has compiled them


def cpu_seconds() -> float:
    """CPU time of this process and of the children it has waited for."""
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(each.ru_utime + each.ru_stime for each in used)


def spent(run: Callable[[], Any]) -> tuple[float, float]:
    """Wall and CPU seconds of a call."""
    wall, cpu = perf_counter(), cpu_seconds()
    run()
    return perf_counter() - wall, cpu_seconds() - cpu


def warmed(task: Task) -> None:
    """Run a task that is run several times until it is warm; any other one once."""
    start = cpu_seconds()
    task.own()
    while task.runs > 1 and cpu_seconds() - start < WARM:
        task.own()


def timed(task: Task, beside: bool = True) -> dict[str, float]:
    """The least of a few runs, camopt and its rival in turns, or camopt alone."""
    calls = [task.own, task.rival][: 1 + beside]
    if task.runs > 1:
        warmed(task)
        calls[-1]()
    rounds = [[number for call in calls for number in spent(call)] for _ in range(task.runs)]
    return {**dict(zip(TIMES, map(min, zip(*rounds, strict=True)), strict=False)), "designs": task.designs}


def counted(task: Task, name: str) -> None:
    """A task once more after it has run, for callgrind to count."""
    library = c_library("counting.c", ())
    warmed(task)
    library.counting_begins()
    task.own()
    library.counting_ends(name.encode())


def measured(verb: str, names: Iterable[str]) -> dict[str, Any]:
    """What is found of each task; a commit that cannot do a task, being older, has nothing for it, and says so."""
    found = {}
    for name in names:
        try:
            task = (COUNTED if verb == "count" else TASKS)[name]()
            if verb in ("time", "own"):
                found[name] = timed(task, verb == "time")
            elif verb == "count":
                counted(task, name)
            else:
                warmed(task)
        except (camopt.BadInput, CalledProcessError) as refused:
            print(f"{name}: {refused}", file=sys.stderr)
    return found


def main(verb: str, *names: str) -> None:
    package = str(Path(camopt.__file__).parent)
    print(json.dumps({"package": package, "tasks": measured(verb, names)}))


if __name__ == "__main__":
    compile_early()
    main(*sys.argv[1:])
