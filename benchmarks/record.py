"""The record of speed: a JSON file for each commit that was measured, and what is compared of two of them.

Times are CPU seconds where they are compared: what else a machine does changes them least. A time means something
beside that of a rival, which is the same for every commit.
"""

import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

TIMES = ("seconds", "cpu_seconds", "rival_seconds", "rival_cpu_seconds")
COUNTS = {"instructions": "all instructions", "kernel_instructions": "those of kernels"}
Measures = dict[str, dict[str, float]]
"""By task: the least times, the designs of a call, and counts of instructions where they were counted."""
Record = dict[str, Any]


def least(rounds: Iterable[Measures]) -> Measures:
    """The least of each number of several rounds of measuring."""
    return _of_each(rounds, min)


def middle(rounds: Iterable[Measures]) -> Measures:
    """The median of each number of several rounds of measuring."""
    return _of_each(rounds, median)


def _of_each(rounds: Iterable[Measures], chosen: Callable[[list[float]], float]) -> Measures:
    """A number for each of several rounds, of which some may lack it."""
    values: dict[str, dict[str, list[float]]] = {}
    for measures in rounds:
        for task, numbers in measures.items():
            for name, value in numbers.items():
                values.setdefault(task, {}).setdefault(name, []).append(value)
    return {task: {name: chosen(some) for name, some in numbers.items()} for task, numbers in values.items()}


def with_counts(times: Measures, counts: Measures) -> Measures:
    """Times, and counts of the same tasks beside them."""
    return {task: numbers | counts.get(task, {}) for task, numbers in times.items()}


def ratio(numbers: Mapping[str, float]) -> float:
    """How many times as long the rival takes, or one second: below 1 where camopt takes longer."""
    return numbers.get("rival_cpu_seconds", 1.0) / numbers["cpu_seconds"]


class Change(NamedTuple):
    """One number of a task before and after. What it costs has risen by ``rise``, as a share."""

    task: str
    what: str
    before: float
    after: float
    rise: float
    allowed: float

    @property
    def failed(self) -> bool:
        return self.rise > self.allowed

    @property
    def doubtful(self) -> bool:
        """Whether it differs by more than is allowed, either way: where the side before had no quiet moment, what
        costs more may seem to cost less."""
        return self.failed or self.rise < 1.0 / (1.0 + self.allowed) - 1.0


def changes(before: Measures, after: Measures, slower: float, more: float) -> list[Change]:
    """What has changed in the tasks of both: ratios may fall to 1/(1 + slower), and counts rise by ``more``."""
    found = []
    for task in (name for name in after if name in before):
        old, new = before[task], after[task]
        found.append(Change(task, "ratio", ratio(old), ratio(new), ratio(old) / ratio(new) - 1.0, slower))
        for name in (name for name in COUNTS if name in old and name in new):
            found.append(Change(task, COUNTS[name], old[name], new[name], new[name] / old[name] - 1.0, more))
    return found


def cautious(one: list[Change], other: list[Change]) -> list[Change]:
    """Of two ways to see the same changes, for each the one that sees it cost less."""
    return [min(pair, key=lambda change: change.rise) for pair in zip(one, other, strict=True)]


def table(found: Iterable[Change]) -> str:
    """The changes as Markdown."""
    lines = ["| task | what | before | after | costs more by | allowed | |", "|---|---|---:|---:|---:|---:|---|"]
    for each in found:
        cells = (each.task, each.what, f"{each.before:.4g}", f"{each.after:.4g}", f"{each.rise:+.1%}")
        lines.append(f"| {' | '.join(cells)} | {each.allowed:.0%} | {'**fails**' if each.failed else ''} |")
    return "\n".join(lines)


def written(record: Record, folder: Path) -> Path:
    """Write the record of a commit to a file of its own, so that records merge without conflicts."""
    folder.mkdir(exist_ok=True)
    moment = "".join(mark for mark in record["date"][:19] if mark.isdigit())
    file = folder / f"{moment}-{record['commit'][:9]}.json"
    file.write_text(json.dumps(record, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return file


def records(folder: Path) -> list[Record]:
    """All records, in the order of their commits' dates."""
    return [json.loads(file.read_text(encoding="utf-8")) for file in sorted(folder.glob("*.json"))]
