"""The picture of what accuracy costs: error against time, log-log, the losing methods in it."""

import os
from collections.abc import Callable, Sequence
from typing import Any

from camopt.drawing.canvas import canvas
from camopt.drawing.picture import FAINT, INK

COLOURS = {"sampling": "#b3261e", "sampling, polished": "#c2781a", "enclosure": "#0b6e99", "balls": INK}
NAMED = (36, 360, 720, 3600)  # angles that are written at their points
LABELS: dict[str, Callable[[dict[str, Any]], str]] = {
    "sampling": lambda row: f"{row['setting']:g} angles" if row["setting"] in NAMED else "",
    "sampling, polished": lambda row: "",
    "enclosure": lambda row: f"to {row['setting']:.0e}",
    "balls": lambda row: "any digits, proved",
}
PLACES = {
    "sampling": ((8, 4), "left"),
    "sampling, polished": ((-7, -5), "right"),
    "enclosure": ((8, 0), "left"),
    "balls": ((-8, 0), "right"),
}
FLOOR = 3e-17  # errors below a double's rounding are drawn there


def plot_accuracy(rows: Sequence[dict[str, Any]], title: str, path: str | os.PathLike[str]) -> None:
    """Draw the rows of ``accuracy.measure`` to a PNG or SVG file."""
    names = list(dict.fromkeys(row["quantity"] for row in rows))
    with canvas(path, (6.4 * len(names), 5.2), powers=True, layout="constrained") as figure:
        figure.suptitle(f"What accuracy costs: {title}", x=0.01, ha="left", fontsize=13, weight="bold", color=INK)
        panels = figure.subplots(1, len(names), squeeze=False, sharey=True)[0]
        for axes, name in zip(panels, names, strict=True):
            _draw(axes, name, [row for row in rows if row["quantity"] == name])
        panels[-1].legend(loc="center right", fontsize=8.5, frameon=False)
        panels[0].set_ylabel("largest relative error, against ball arithmetic")


def _draw(axes: Any, name: str, rows: list[dict[str, Any]]) -> None:
    axes.set(xscale="log", yscale="log", xlabel="time for each design, ns", ylim=(FLOOR / 3, 3.0))
    axes.set_title(name, loc="left", color=INK)
    axes.axhspan(FLOOR / 3, 2.2e-16, color=FAINT, alpha=0.15, lw=0)
    axes.text(0.01, 0.01, "below a double's rounding", transform=axes.transAxes, fontsize=8, color=FAINT)
    for method, colour in COLOURS.items():
        points = sorted((row for row in rows if row["method"] == method), key=lambda row: float(row["setting"]))
        times = [row["ns_per_design"] for row in points]
        errors = [max(row["error_max"], FLOOR) for row in points]
        axes.plot(times, errors, "o-", color=colour, lw=1.4, ms=5, label=method)
        for row, time, error in zip(points, times, errors, strict=True):
            words, (x, y), side = LABELS[method](row), *PLACES[method]
            style = {"ha": side, "va": "center", "fontsize": 7.5, "color": colour}
            axes.annotate(words, (time, error), (x, y), textcoords="offset points", **style)
        if method == "enclosure":
            asked = [row["setting"] for row in points]
            axes.plot(times, asked, "o", mfc="white", color=colour, ms=5, label="enclosure, error asked for")
            axes.vlines(times, errors, asked, color=colour, lw=0.8, alpha=0.6)
    axes.set_xlim(left=20)
    axes.grid(True, which="major", lw=0.4, color=FAINT, alpha=0.5)
    axes.spines[["top", "right"]].set_visible(False)
