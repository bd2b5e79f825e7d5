"""The table of costs and errors: one row for each quantity and method."""

import os
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from time import perf_counter
from typing import Any, ClassVar

import numpy as np
import pyarrow as pa

from camopt.drawing.plot import plot
from camopt.engines import Engine
from camopt.engines.progress import Progress, report_progress
from camopt.engines.threads import Threads
from camopt.numerics import FloatArray
from camopt.numerics.clock import timed
from camopt.problem.problem import Problem, resolve
from camopt.problem.settings import problems_of
from camopt.quantities.shown import Drawn
from camopt.scene.scene import Scene
from camopt.storage.tables import write_table
from camopt.storage.version import VERSION
from camopt.studies.accuracy.methods import METHODS
from camopt.studies.accuracy.reference import EQUAL_DIGITS
from camopt.studies.accuracy.subjects import REFERENCED, Subject, subjects_of
from camopt.tables.layout import Table, table_of
from camopt.tables.result import Result

ACCURACY = ("accuracy.parquet", "accuracy.png", "accuracy.svg")
TIMED_RUNS = 3
REFERENCE = "50 digits"
BEYOND_LIMIT = 1e-9  # relative: how far beyond its limit a design is put, to see whether it is accepted


@dataclass(frozen=True)
class Costs(Result, Drawn):
    """What accuracy costs: a row for each quantity and method."""

    scene: Scene
    methods: list[dict[str, Any]]
    picture: ClassVar[str] = "studies.accuracy.picture"
    main_rows: ClassVar[str] = "methods"

    def table(self) -> Table:
        """Cost and error of each method."""
        names = [*self.methods[0]]
        rows = [{n: f"{row[n]:.2g}" if n in names[4:] else row[n] for n in names} for row in self.methods]
        for row in rows:
            row |= {
                "setting": float(f"{row['setting']:.2g}"),
                "ns_per_design": float(f"{row['ns_per_design']:.3g}"),
            }
        return table_of(f"{self.scene.name}: what accuracy costs", rows, names)

    def document(self) -> dict[str, Any]:
        """A record for each quantity and method."""
        return {"scene": self.scene.name, "methods": self.methods}


def measure(scene: Scene, progress: Progress | None = None, engine: Engine | None = None) -> Costs:
    """One row for each quantity and method: cost, error, and how it judges designs at the edge of their limit.

    Over the laws that ``[search]`` names, or else the scene's own. ``ns_per_design`` is their mean, all else their
    worst: ``error_max`` and ``error_median`` (relative, against 50 digits); ``achieved`` (relative: the most that a
    method itself leaves open); ``false_accept``: the share of designs, each put 1e-9 beyond its limit, that the
    method calls feasible; ``undecided``: the share it leaves open. The smallest radius is that of the first
    quantity that the size of the cam decides. Laws are measured one after the other, or each on a worker of an
    engine.
    """
    found, count = [], len(problems_of(resolve(scene)))
    measured = (engine or Threads(1)).in_order(partial(_measured, scene.to_toml()), range(count))
    for done, rows in enumerate(chain.from_iterable(measured), start=1):
        found += rows
        report_progress(progress, done, count)
    return Costs(scene, _worst(found))


def _measured(scene: str, numbers: Sequence[int]) -> list[list[dict[str, Any]]]:
    """The rows of some of the programmes of a scene."""
    problems = problems_of(resolve(Scene.from_dict(tomllib.loads(scene))))
    return [_of_programme(problems[number]) for number in numbers]


def _of_programme(problem: Problem) -> list[dict[str, Any]]:
    """The rows of one programme."""
    return [row for subject in subjects_of(problem) for row in _rows(subject)]


def _rows(subject: Subject) -> list[dict[str, Any]]:
    """The rows of one quantity under one programme: 50 digits, which others are measured against, first."""
    some, start = range(max(min(REFERENCED // subject.dear, len(subject.designs)), 1)), perf_counter()
    expected = np.array([subject.reference(number) for number in some])
    spent, alike, none = perf_counter() - start, EQUAL_DIGITS, np.zeros(1, dtype=bool)
    rows = [_row((subject.name, REFERENCE, alike), spent / len(some), np.array([alike]), alike, none, none)]
    limit = subject.truth - subject.sign * BEYOND_LIMIT * np.abs(subject.truth)
    for method in METHODS:
        value, seconds = timed(partial(subject.answer, method), TIMED_RUNS)
        far, near = (
            (subject.answer(method, side) for side in (1.0, -1.0)) if method.setting < 1.0 else (value, value)
        )
        held, possible = (subject.sign * (each - limit) <= 0.0 for each in (far, near))
        errors = np.abs(value[: len(some)] / expected - 1.0)
        achieved = max(float(np.max(np.abs(end / value - 1.0))) for end in (far, near))
        asked = subject.name, method.name, method.setting
        rows.append(_row(asked, seconds / len(value), errors, achieved, held, possible))
    return rows


def _row(
    asked: tuple[str, str, float], seconds: float, errors: FloatArray, achieved: float, held: Any, possible: Any
) -> dict[str, Any]:
    """A row: what was asked is a quantity of a method at a setting."""
    return {
        **dict(zip(("quantity", "method", "setting"), asked, strict=True)),
        "ns_per_design": seconds * 1e9,
        "error_max": float(errors.max()),
        "error_median": float(np.median(errors)),
        "achieved": achieved,
        "false_accept": float(held.mean()),
        "undecided": float((possible & ~held).mean()),
    }


def _worst(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows of the same quantity, method and setting made one."""
    import pandas as pd

    groups = pd.DataFrame(rows).groupby(["quantity", "method", "setting"], sort=False)
    worst = groups.max().assign(ns_per_design=groups["ns_per_design"].mean()).reset_index()
    return [{str(name): value for name, value in row.items()} for row in worst.to_dict("records")]


def write_accuracy(costs: Costs, folder: str | os.PathLike[str]) -> list[Path]:
    """Write the table and its pictures to a folder; the files."""
    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    about = {"camopt_version": VERSION, "camopt_scene": costs.scene.to_toml()}
    table, *pictures = files = [out / name for name in ACCURACY]
    write_table(pa.Table.from_pylist(costs.methods, metadata=about), table)
    for picture in pictures:
        plot(costs, picture)
    return files
