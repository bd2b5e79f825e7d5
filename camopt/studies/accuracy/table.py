"""The table of costs and errors: one row for each quantity and method."""

import os
import tomllib
from collections.abc import Callable, Sequence
from functools import partial
from itertools import chain
from pathlib import Path
from time import perf_counter
from typing import Any, TypeVar

import numpy as np
import pyarrow as pa

from camopt.drawing.plot import plot
from camopt.engines import Engine
from camopt.engines.threads import Threads
from camopt.mechanisms import Designs
from camopt.numerics import FloatArray
from camopt.numerics.extremes import Precision, extremes
from camopt.problem.problem import EXACT, Problem, resolve
from camopt.problem.settings import problems_of
from camopt.progress import Progress, report_progress
from camopt.scene.scene import Scene
from camopt.shown import Drawn
from camopt.storage.sealed import write_table
from camopt.studies.accuracy.methods import METHODS, Method, enclosed
from camopt.studies.accuracy.radius import bracketed, reference_radius, smallest_radii
from camopt.studies.accuracy.reference import ALIKE, reference
from camopt.studies.accuracy.subjects import DESIGNS, REFERENCED, Subject, designs_of, subjects_of
from camopt.version import VERSION

ACCURACY = ("accuracy.parquet", "accuracy.png", "accuracy.svg")
RUNS = 3
NEAR = 1e-9  # relative: how far beyond its limit a design is put, to see whether it is accepted
SMALLEST = "smallest radius"
Result = TypeVar("Result")


class Costs(Drawn, list[dict[str, Any]]):
    """What accuracy costs: the rows of ``measure``."""

    picture = "accuracy"


def measure(scene: Scene, progress: Progress | None = None, engine: Engine | None = None) -> Costs:
    """One row for each quantity and method: cost, error, and how it judges designs at the edge of their limit.

    Over the laws that ``[search]`` names, or else the scene's own. ``ns_per_design`` is their mean, all else their
    worst: ``error_max`` and ``error_median`` (relative, against balls); ``achieved`` (largest half-width of an
    enclosure); ``false_accept``: the share of designs, each put 1e-9 beyond its limit, that the method calls
    feasible; ``undecided``: the share it leaves open. The smallest radius is that of the first quantity that
    the size of the cam decides. Laws are measured one after the other, or each on a worker of an engine.
    """
    found, count = [], len(problems_of(resolve(scene)))
    measured = (engine or Threads(1)).in_order(partial(_measured, scene.to_toml()), range(count))
    for done, rows in enumerate(chain.from_iterable(measured), start=1):
        found += rows
        report_progress(progress, done, count)
    return Costs(_worst(found))


def _measured(scene: str, numbers: Sequence[int]) -> list[list[dict[str, Any]]]:
    """The rows of some of the programmes of a scene."""
    problems = problems_of(resolve(Scene.from_dict(tomllib.loads(scene))))
    return [_of_programme(problems[number]) for number in numbers]


def _of_programme(problem: Problem) -> list[dict[str, Any]]:
    """The rows of one programme."""
    found: list[dict[str, Any]] = []
    designs, table, sized = designs_of(problem), problem.programme.table, False
    for subject in subjects_of(problem):
        f = subject.make(designs, problem.programme)
        exact, where, _ = extremes(f, len(designs), table, subject.questions, Precision(EXACT, 1e-9))
        truth = subject.answer(exact)
        if np.all(np.abs(truth) > 0.0):  # a flat face that translates has no pressure angle
            found += _extremes(subject, problem, designs, truth, where)
            rows = [] if sized else _radii(subject, problem, designs, truth, where)
            found, sized = found + rows, sized or bool(rows)
    return found


def _extremes(
    subject: Subject,
    problem: Problem,
    designs: Designs,
    truth: FloatArray,
    where: FloatArray,
) -> list[dict[str, Any]]:
    """The rows of one quantity under one programme."""
    some, f = range(min(REFERENCED, len(designs))), subject.make(designs, problem.programme)
    start = perf_counter()
    balls = [reference(subject, problem, designs.take([i]), where[:, i]) for i in some]
    rows = [_in_balls(subject.name, (perf_counter() - start) / len(some))]
    expected = np.array([subject.answer(np.array([[float(subject.sign * ball)]]))[0] for ball in balls])
    limit = truth - subject.sign * NEAR * np.abs(truth)

    for method in METHODS:

        def run(method: Method = method) -> tuple[FloatArray, FloatArray]:
            return method.run(f, len(designs), problem.programme, subject.questions)

        (value, width), seconds = _timed(run)
        accepted = subject.excess(value, width, limit) <= 0.0
        possible = subject.excess(value, -width, limit) <= 0.0
        errors = np.abs(subject.answer(value)[: len(some)] / expected - 1.0)
        achieved = float((width.max(axis=0) / np.abs(value).max(axis=0)).max())
        rows.append(_row(subject.name, method, seconds / len(designs), errors, achieved, accepted, possible))
    return rows


def _radii(
    subject: Subject,
    problem: Problem,
    designs: Designs,
    truth: FloatArray,
    where: FloatArray,
) -> list[dict[str, Any]]:
    """The rows of the smallest radius; none where no design has one near."""
    inside = np.flatnonzero(bracketed(problem, subject, Method("", EXACT, enclosed(EXACT)), designs, truth))[
        : DESIGNS // 4
    ]
    if not inside.size:
        return []
    designs, limit, where = designs.take(inside), truth[inside], where[:, inside]
    some, start = range(min(max(REFERENCED // 4, 1), len(designs))), perf_counter()
    balls = [reference_radius(subject, problem, designs.take([i]), float(limit[i]), where[:, i]) for i in some]
    rows = [_in_balls(SMALLEST, (perf_counter() - start) / len(some))]
    expected = np.array([float(ball) for ball in balls])
    for method in METHODS:

        def run(method: Method = method, side: float = 1.0) -> tuple[FloatArray, FloatArray]:
            return smallest_radii(subject, method, problem.programme, designs, limit, side)

        (_, radius), seconds = _timed(run)
        errors = np.abs(radius[: len(some)] / expected - 1.0)
        width = radius - run(side=-1.0)[0]
        accepted = radius < designs.size * (1.0 - NEAR)
        achieved = float((width / radius).max()) if method.setting < 1.0 else 0.0
        possible = accepted | ((width > NEAR * radius) & (method.setting < 1.0))
        rows.append(_row(SMALLEST, method, seconds / len(designs), errors, achieved, accepted, possible))
    return rows


def _row(
    quantity: str,
    method: Method,
    seconds: float,
    errors: FloatArray,
    achieved: float,
    accepted: Any,
    possible: Any,
) -> dict[str, Any]:
    return {
        "quantity": quantity,
        "method": method.name,
        "setting": method.setting,
        "ns_per_design": seconds * 1e9,
        "error_max": float(errors.max()),
        "error_median": float(np.median(errors)),
        "achieved": achieved,
        "false_accept": float(accepted.mean()),
        "undecided": float((possible & ~accepted).mean()),
    }


def _in_balls(quantity: str, seconds: float) -> dict[str, Any]:
    """The row of ball arithmetic, which is what the others are measured against."""
    alike, none = float(ALIKE), np.zeros(1, dtype=bool)
    method = Method("balls", alike, lambda *_: (none, none))
    return _row(quantity, method, seconds, np.array([alike]), alike, none, none)


def _worst(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows of the same quantity, method and setting made one."""
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault((row["quantity"], row["method"], row["setting"]), []).append(row)
    merged = []
    for group in groups.values():
        worst = {name: max(row[name] for row in group) for name in group[0]}
        merged.append(worst | {"ns_per_design": float(np.mean([row["ns_per_design"] for row in group]))})
    return merged


def _timed(run: Callable[[], Result]) -> tuple[Result, float]:
    """What a run gives, and the least of a few times in seconds; the first run may compile."""
    result, times = run(), []
    for _ in range(RUNS):
        start = perf_counter()
        run()
        times.append(perf_counter() - start)
    return result, min(times)


def write_accuracy(rows: Costs, scene: Scene, folder: str | os.PathLike[str]) -> list[Path]:
    """Write the table and its pictures to a folder; the files."""
    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    about = {"camopt_version": VERSION, "camopt_scene": scene.to_toml()}
    table, *pictures = files = [out / name for name in ACCURACY]
    write_table(pa.Table.from_pylist(rows, metadata=about), table)
    for picture in pictures:
        plot(rows, picture, title=scene.name)
    return files
