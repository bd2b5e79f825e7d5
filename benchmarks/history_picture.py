"""The history of speed as a picture: a point for each commit in the record."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from record import Record, ratio
from tasks import SWEEPS

SIZE, DOTS = (11.0, 14.0), 110  # inches, and dots an inch
BESIDE_C = {*SWEEPS, "default sweep"}


def drawn(records: list[Record], picture: Path) -> Path:
    """Draw ratios to the rivals, instructions of kernels, and Python's share, commit by commit."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    ratios, others, kernels, python = figure.subplots(4, 1, sharex=True, height_ratios=(3, 3, 3, 2))
    series(ratios, records, ratio, BESIDE_C.__contains__)
    series(others, records, ratio, lambda task: task not in BESIDE_C)
    ratios.axhline(1.0, color="black", linewidth=0.8)
    ratios.set(title="Speed of sweeps beside 360 samples in C: higher is faster; 1 is as fast as C")
    others.set(title="Speed of commands beside importing numpy, of the rest beside numpy and scipy")
    for axes in (ratios, others):
        axes.set(yscale="log", ylabel="CPU time of the rival / of camopt")
        axes.legend(*axes.get_legend_handles_labels(), loc="center left", bbox_to_anchor=(1.0, 0.5))
    series(kernels, records, lambda numbers: numbers["kernel_instructions"] / numbers["designs"])
    kernels.set(
        yscale="log", ylabel="instructions a design", title="Instructions of compiled kernels: lower is faster"
    )
    series(python, records, python_percent)
    python.set(
        ylim=(0, 100),
        ylabel="% of all",
        title="Share of instructions outside compiled kernels: Python, numpy, other libraries",
    )
    python.set_xticks(range(len(records)), [f"{each['date'][:10]} {each['commit'][:7]}" for each in records])
    python.tick_params(axis="x", rotation=90)
    python.set_xlabel("commit")
    for axes in (ratios, others, kernels, python):
        axes.grid(alpha=0.3)
    figure.savefig(picture, dpi=DOTS)
    return picture


def python_percent(numbers: Mapping[str, float]) -> float:
    """Instructions outside compiled kernels: Python, numpy and other libraries, in % of all."""
    return 100.0 * (1.0 - numbers["kernel_instructions"] / numbers["instructions"])


def series(
    axes: Any,
    records: list[Record],
    value: Callable[[Mapping[str, float]], float],
    shown: Callable[[str], bool] = lambda task: True,
) -> None:
    """A line for each task that is shown, its points where the records have what the value needs."""
    names = dict.fromkeys(task for record in records for task in record["tasks"])
    for number, task in enumerate(filter(shown, names)):
        points = []
        for place, record in enumerate(records):
            with suppress(KeyError):  # not measured, or not counted
                points.append((place, value(record["tasks"][task])))
        if points:
            style = {"color": f"C{number % 10}", "linestyle": ("-", "--", ":")[number // 10]}
            axes.plot(*zip(*points, strict=True), marker="o", markersize=4, label=task, **style)
