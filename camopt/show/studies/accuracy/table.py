"""The cost of accuracy: a table of times and errors by quantity and method, and its picture."""

import os
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pyarrow as pa

from camopt.core.engines import Engine
from camopt.core.engines.progress import Progress, report_progress
from camopt.core.engines.threads import Threads
from camopt.core.numerics.clock import time_runs
from camopt.core.quantities.display import Drawable
from camopt.core.storage.tables import ARROW_TYPES, write_table
from camopt.core.storage.version import VERSION
from camopt.scene.problem.problem import resolve
from camopt.scene.problem.rows import DesignRows
from camopt.scene.problem.settings import problems_by_motion_and_setting
from camopt.scene.scene import Scene
from camopt.show.drawing.labels import Label, label_place_candidates, place_labels
from camopt.show.drawing.style import (
    FAINT,
    HEADING_SIZE,
    INK,
    MUTED,
    PAGE_TITLE,
    SERIES,
    SMALL_SIZE,
    Figure,
    Targets,
    add_grid,
    new_figure,
)
from camopt.show.studies.accuracy.methods import METHODS
from camopt.show.studies.accuracy.reference import EQUAL_DIGITS
from camopt.show.studies.accuracy.subjects import REFERENCE_COUNT, Subject, subjects_of
from camopt.solve.tables.result import Result, Table, table_of
from camopt.solve.tables.table import to_arrow_table

ACCURACY = ("accuracy.parquet", "accuracy.png", "accuracy.svg")
TIMED_RUNS, ENOUGH_SECONDS = 4, 2e-3  # of a method: at least two runs, more of a shorter one
REFERENCE_METHOD = "50 digits"
ROW_KEY = ("quantity", "method", "setting")
BEYOND_LIMIT = 1e-9  # relative excess over its limit of a test design, which should be refused


@dataclass(frozen=True)
class AccuracyCosts(Result, Drawable):
    """The cost of accuracy: a row for each quantity and method."""

    scene: Scene
    methods: list[dict[str, Any]]
    picture: ClassVar[str] = "studies.accuracy.table"
    main_rows: ClassVar[str] = "methods"

    def table(self) -> Table:
        """A table of time and error of each method."""
        names = [*self.methods[0]]
        rows = [{n: f"{row[n]:.2g}" if n in names[4:] else row[n] for n in names} for row in self.methods]
        for row in rows:
            row |= {
                "setting": float(f"{row['setting']:.2g}"),
                "ns_per_design": float(f"{row['ns_per_design']:.3g}"),
            }
        return table_of(f"{self.scene.name}: cost of accuracy", rows, names)

    def values_for_json(self) -> dict[str, Any]:
        """A record for each quantity and method."""
        return {"scene": self.scene.name, "methods": self.methods}


def measure_accuracy_costs(
    scene: Scene, progress: Progress | None = None, engine: Engine | None = None
) -> AccuracyCosts:
    """Measure time and error of each quantity and method, also for designs at the edge of a limit.

    Rows are over the laws of ``[search]``, or else of the scene. ``ns_per_design`` is the mean over the laws, the
    other columns are the worst: ``error_max`` and ``error_median``, relative, against 50 digits; ``achieved``, the
    relative error bound of the method itself; ``false_accept``, the share of designs with an excess of 1e-9 over
    their limit that the method calls feasible; ``undecided``, the share that it leaves undecided. The smallest
    radius is that of the first quantity that depends on the size of the cam. Laws are measured one after the other,
    or on workers of an engine.
    """
    found, count = [], len(problems_by_motion_and_setting(resolve(scene)))
    measured = (engine or Threads(1)).results_in_order(partial(_measure_programmes, scene.to_toml()), range(count))
    for done, rows in enumerate(chain.from_iterable(measured), start=1):
        found += rows
        report_progress(progress, done, count)
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for row in found:
        groups.setdefault(tuple(row[name] for name in ROW_KEY), []).append(row)
    worst = [
        {name: max(row[name] for row in group) for name in group[0]}
        | {"ns_per_design": sum(row["ns_per_design"] for row in group) / len(group)}
        for group in groups.values()
    ]
    return AccuracyCosts(scene, worst)


def _measure_programmes(scene_toml: str, programme_numbers: Sequence[int]) -> list[list[dict[str, Any]]]:
    """Rows of cost and error for some programmes of a scene (TOML), given by number."""
    problems = problems_by_motion_and_setting(resolve(Scene.from_dict(tomllib.loads(scene_toml))))
    return [
        [row for subject in subjects_of(problems[number]) for row in _subject_rows(subject)]
        for number in programme_numbers
    ]


def _subject_rows(subject: Subject) -> list[dict[str, Any]]:
    """Rows of one quantity under one programme; the reference of 50 digits first."""
    some = range(max(min(REFERENCE_COUNT // subject.cost_factor, len(subject.designs)), 1))
    numbers, spent = time_runs(lambda: [subject.reference_with_50_digits(number) for number in some], 1)
    expected, alike, none = np.array(numbers), EQUAL_DIGITS, np.zeros(1, dtype=bool)
    measured = [((subject.name, REFERENCE_METHOD, alike), spent / len(some), np.array([alike]), alike, none, none)]
    limit = subject.truth - subject.sign * BEYOND_LIMIT * np.abs(subject.truth)
    for method in METHODS:
        value, seconds = time_runs(partial(subject.result_by_method, method), TIMED_RUNS, ENOUGH_SECONDS)
        far, near = (
            (subject.result_by_method(method, side) for side in (1.0, -1.0))
            if method.setting < 1.0
            else (value, value)
        )
        held, possible = (subject.sign * (each - limit) <= 0.0 for each in (far, near))
        errors = np.abs(value[: len(some)] / expected - 1.0)
        achieved = max(float(np.max(np.abs(end / value - 1.0))) for end in (far, near))
        asked = subject.name, method.name, float(method.setting)
        measured.append((asked, seconds / len(value), errors, achieved, held, possible))
    return [
        {
            **dict(zip(ROW_KEY, row_key, strict=True)),
            "ns_per_design": seconds * 1e9,
            "error_max": float(errors.max()),
            "error_median": float(np.median(errors)),
            "achieved": achieved,
            "false_accept": float(held.mean()),
            "undecided": float((possible & ~held).mean()),
        }
        for row_key, seconds, errors, achieved, held, possible in measured
    ]


def write_accuracy(costs: AccuracyCosts, folder: str | os.PathLike[str]) -> list[Path]:
    """Write the table and its pictures to a folder; return the files."""
    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    about = {"camopt_version": VERSION, "camopt_scene": costs.scene.to_toml()}
    table, *pictures = files = [out / name for name in ACCURACY]
    columns = {name: np.array([row[name] for row in costs.methods]) for name in costs.methods[0]}
    kinds = [(name, ARROW_TYPES[type(value)]) for name, value in costs.methods[0].items()]
    write_table(to_arrow_table(DesignRows(columns, len(costs.methods)), pa.schema(kinds, about)), table)
    draw(costs, pictures)
    return files


METHOD_PENS: dict[str, dict[str, Any]] = {
    "sampling": {"color": SERIES[1], "marker": "o"},
    "sampling, polished": {"color": SERIES[4], "marker": "s"},
    "enclosure": {"color": SERIES[0], "marker": "D"},
    "50 digits": {"color": INK, "marker": "^"},
}
POINT_LABELS: dict[Any, str] = {
    "50 digits": "50 digits",
    ("sampling", 36): "36 angles",
    ("sampling", 360): "360",
    ("sampling", 3600): "3600 angles",
    **{("enclosure", 10.0**-k): f"setting 1e-{k:02}" for k in (4, 6, 9, 12)},
}
LABEL_DISTANCES = (6.0, 12.0, 20.0, 30.0)  # points from a point to its label
LEAST_ERROR_DRAWN = 3e-17  # smaller errors are drawn here
EPSILON = 2.2e-16
USUAL_ERROR = 1e-9  # default relative error of scenes


def draw(costs: "AccuracyCosts", path: Targets = None) -> "Figure":
    """Draw the largest error of each method against its time, with a diagram for each quantity."""
    rows = costs.methods
    names = list(dict.fromkeys(row["quantity"] for row in rows))
    with new_figure(path, (4.3 * len(names), 4.6), layout="constrained") as figure:
        figure.suptitle(
            f"Cost of accuracy: {costs.scene.name}", x=0.01, ha="left", fontsize=PAGE_TITLE, weight="bold"
        )
        panels = figure.subplots(1, len(names), squeeze=False, sharey=True)[0]
        labels: list[Label] = []
        for axes, name in zip(panels, names, strict=True):
            labels += _draw_costs(axes, name, [row for row in rows if row["quantity"] == name])
        panels[0].set_ylabel("largest relative error, against 50 digits")
        handles = dict(zip(*reversed(panels[0].get_legend_handles_labels()), strict=True))
        figure.legend(handles.values(), handles, loc="outside lower center", ncols=len(handles))
        place_labels(figure, labels)
    return figure


def _draw_costs(axes: Any, name: str, rows: list[dict[str, Any]]) -> list[Label]:
    """Draw the methods of one quantity; return the labels of points."""
    from matplotlib.ticker import EngFormatter

    axes.set(xscale="log", yscale="log", xlabel="time for each design", ylim=(LEAST_ERROR_DRAWN / 3, 3.0))
    axes.xaxis.set_major_formatter(EngFormatter("s"))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.minorticks_off()
    axes.set_title(f"{name}\n{_default_accuracy_time_text(rows)}", loc="left", fontsize=HEADING_SIZE)
    axes.axhspan(LEAST_ERROR_DRAWN / 3, EPSILON, color=FAINT, alpha=0.2, lw=0)
    axes.text(0.01, 0.01, "below double precision", transform=axes.transAxes, fontsize=SMALL_SIZE, color=MUTED)
    labels = []
    for method, pen in METHOD_PENS.items():
        points = sorted((row for row in rows if row["method"] == method), key=lambda row: float(row["setting"]))
        times, errors = (
            [row["ns_per_design"] / 1e9 for row in points],
            [max(row["error_max"], LEAST_ERROR_DRAWN) for row in points],
        )
        axes.plot(times, errors, "-", lw=1.4, ms=5, label=method, **pen)
        texts = [POINT_LABELS.get((method, row["setting"]), POINT_LABELS.get(method, "")) for row in points]
        style, places = {"fontsize": SMALL_SIZE, "color": pen["color"]}, label_place_candidates(LABEL_DISTANCES)
        placed = zip(texts, zip(times, errors, strict=True), strict=True)
        labels += [Label(axes, text, at, places, style) for text, at in placed if text]
    add_grid(axes)
    return labels


def _default_accuracy_time_text(rows: list[dict[str, Any]]) -> str:
    """A text on the time of the default accuracy, compared with sampling; empty if it was not measured."""
    samples = sorted((row["ns_per_design"], row["setting"]) for row in rows if row["method"] == "sampling")
    found = [row["ns_per_design"] for row in rows if (row["method"], row["setting"]) == ("enclosure", USUAL_ERROR)]
    if not samples or not found:
        return ""
    times, angles = zip(*samples, strict=True)
    return f"1e-9, proved: {found[0] / 1e3:.2g} µs, as {np.interp(found[0], times, angles):.0f} samples"
