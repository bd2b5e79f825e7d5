"""The record of speed.

Without an option: measure HEAD, add it to the record, and draw the record. ``--commit`` does so with another
commit, ``--check`` fails if the working tree costs 30 % more than the newest record, ``--draw`` draws. ``--quick``
takes the first part of the list alone: sweeps in process, and the smallest radius. ``.ci/against`` compares two
commits.

Kernels are compiled before anything is measured, for each commit in a folder of its own, which is kept.
Instructions are counted where valgrind is, unless ``--no-counts`` is given.
"""

import argparse
import os
import platform
import sys
from collections.abc import Callable, Iterable, Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from statistics import median
from typing import Any

import callgrind
from history_picture import drawn
from record import (
    Change,
    Measures,
    Record,
    cautious,
    changes,
    least,
    middle,
    records,
    table,
    written,
)
from rival_c import rival
from sides import HERE, Side, commit_of, git, say, side_of
from tasks import CORES, COUNTED, QUICK, TASKS

ROUNDS, CHECK_ROUNDS, MOST_ROUNDS = 5, 1, 15  # a check repeats what is too slow
COUNTINGS = 2  # the first of a new environment may count what compiles
SLOWER, MORE = 0.10, 0.03  # allowed of one commit against another: time, instructions
BESIDE_RECORD = 0.30  # allowed of instructions against the record, and of time on a machine like the record's
MUCH_SLOWER = 2.0  # allowed of time where the machine is another one
PACE = 1.3  # by which the rival may be faster or slower than in the record on a machine like the record's


def countable() -> list[str]:
    """The tasks whose instructions can be counted here."""
    absent = callgrind.missing()
    if absent:
        say(f"no instructions are counted, for lack of {absent}")
    return [] if absent else list(COUNTED)


def repeated(
    tasks: list[str],
    rounds: int,
    measure: Callable[[int, list[str]], None],
    suspects: Callable[[], list[str]],
) -> None:
    """Measure all tasks for a few rounds, and then those in doubt until there are none, or it is enough.

    The least of several times only falls: of equal commits it becomes equal, of a slower one it stays slower.
    """
    for turn in range(MOST_ROUNDS):
        names = tasks if turn < rounds else suspects()
        if not names:
            return
        say(f"round {turn + 1}: {len(names)} tasks")
        measure(turn, names)


def with_counts(times: Measures, counts: Measures) -> Measures:
    return {task: numbers | counts.get(task, {}) for task, numbers in times.items()}


def record_of(commit: str, tasks: list[str], to_count: list[str]) -> Record:
    """Measure a commit."""
    side = side_of(commit)
    side.warm(tasks)
    load = os.getloadavg()[0]
    times = least(side.timed(tasks) for _ in range(ROUNDS))
    counts = side.counted(to_count)
    second, subject = git("show", "-s", "--format=%ct%n%s", commit).decode().strip().split("\n", 1)
    made_with = {name: version(name) for name in ("numba", "llvmlite", "numpy")}
    return {
        "commit": commit,
        "date": datetime.fromtimestamp(int(second), UTC).isoformat(),
        "subject": subject,
        "machine": {**machine(), "load": round(load, 2)},
        "versions": {"python": platform.python_version(), **made_with},
        "rival": rival("float").name,
        "tasks": with_counts(times, counts),
    }


def machine() -> dict[str, Any]:
    """What a time depends on beside the code."""
    return {"processor": processor(), "cores": CORES}


def processor() -> str:
    """What the machine calls its processor."""
    about = Path("/proc/cpuinfo")
    lines = about.read_text(encoding="utf-8").splitlines() if about.is_file() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def compared(sides: Sequence[Side], tasks: list[str], to_count: list[str]) -> list[Change]:
    """Measure two commits in turns."""
    for side in sides:
        side.warm(tasks)
    rounds: list[list[Measures]] = [[], []]

    def measure(turn: int, names: list[str]) -> None:
        for k in (0, 1) if turn % 2 == 0 else (1, 0):
            rounds[k].append(sides[k].timed(names, "own"))

    repeated(tasks, ROUNDS, measure, lambda: named(each for each in seen(rounds) if each.doubtful))
    if lost := [task for task in least(rounds[0]) if task not in least(rounds[1])]:
        raise SystemExit(f"{sides[1].name} cannot do what {sides[0].name} can: {', '.join(lost)}")
    return seen(rounds, [least(side.counted(to_count) for _ in range(COUNTINGS)) for side in sides])


def seen(rounds: list[list[Measures]], counts: Sequence[Measures] = ({}, {})) -> list[Change]:
    """What has changed between two sides, by the least of their rounds and by the middle one.

    A quiet moment of a busy machine makes a least time, a few busy ones a median; only a slower commit makes both.
    """
    both = []
    for chosen in (least, middle):
        both.append(changes(*map(with_counts, map(chosen, rounds), counts), SLOWER, MORE))
    return cautious(*both)


def unlike(record: Record, times: Measures) -> str:
    """How this machine differs from that of a record; empty if it does not."""
    here, there = {**machine(), "rival": rival("float").name}, {**record["machine"], "rival": record["rival"]}
    differing = [f"{what} {there[what]}, here {here[what]}" for what in here if there[what] != here[what]]
    both = [(times[task], record["tasks"][task]) for task in times if task in record["tasks"]]
    pace = median(now["rival_cpu_seconds"] / then["rival_cpu_seconds"] for now, then in both)
    if not differing and not 1.0 / PACE < pace < PACE:
        differing = [f"the rival takes {pace:.2f} times as long here"]
    return "; ".join(differing)


def checked(tasks: list[str], to_count: list[str]) -> list[Change]:
    """Measure the working tree against the newest record."""
    *_, newest = records() or [None]
    if newest is None:
        raise SystemExit("there is no record to check against: python benchmarks/track.py makes one of HEAD")
    side, found = Side("working tree", HERE.parent), [Measures()]
    say(f"against {newest['commit'][:9]}")

    def against(counts: Measures | None = None) -> list[Change]:
        slower = MUCH_SLOWER if unlike(newest, found[0]) else BESIDE_RECORD
        return changes(newest["tasks"], with_counts(found[0], counts or {}), slower, BESIDE_RECORD)

    def measure(turn: int, names: list[str]) -> None:
        found[0] = least([found[0], side.timed(names)])

    repeated(tasks, CHECK_ROUNDS, measure, lambda: failing(against()))
    if why := unlike(newest, found[0]):
        say(f"the record is of another machine ({why}): only what takes three times as long fails")
    return against(side.counted(to_count))


def named(found: Iterable[Change]) -> list[str]:
    """The tasks of changes, each once."""
    return list(dict.fromkeys(each.task for each in found))


def failing(found: Iterable[Change]) -> list[str]:
    """The tasks that cost more than is allowed."""
    return named(each for each in found if each.failed)


def verdict(found: list[Change]) -> int:
    """Print a table of changes; the exit code."""
    print(table(found))
    failed = failing(found)
    print(f"\ncosts too much: {', '.join(failed)}" if failed else "\nnothing costs more than is allowed")
    return 1 if failed else 0


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    verbs = parser.add_mutually_exclusive_group()
    verbs.add_argument("--commit", metavar="REV", default="HEAD")
    verbs.add_argument("--check", action="store_true")
    verbs.add_argument("--draw", action="store_true")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--no-counts", action="store_true")
    return parser.parse_args()


def main() -> int:
    asked = arguments()
    tasks = list(QUICK if asked.quick else TASKS)
    if asked.draw:
        say(f"drawn: {drawn(records())}")
        return 0
    to_count = [] if asked.no_counts else countable()
    if asked.check:
        return verdict(checked(list(QUICK), to_count))
    say(f"written: {written(record_of(commit_of(asked.commit), tasks, to_count))}")
    say(f"drawn: {drawn(records())}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
