"""The picture of a frontier: free laws as a front, the bound that no motion passes, known laws as points."""

import os
from math import isinf
from typing import Any

import numpy as np

from camopt.drawing.canvas import canvas
from camopt.drawing.picture import ALARM, COLOURS, FAINT, INK, MUTED
from camopt.motion.table import RISE
from camopt.quantities import DERIVATIVES, QUANTITIES, motion_quantity
from camopt.synthesis.frontier import Frontier

FREE = COLOURS[RISE]
BOUND = "no motion within the other limits passes this"
WIDE = 5.0  # a ratio of values that is shown on a logarithmic scale
PLAIN = str.maketrans({"·": "_", "/": "_", "µ": "u"})  # units as the names of quantities write them
WORDS = {
    "size": "radius of the cam, mm",
    "velocity": "peak velocity",
    "acceleration": "peak acceleration",
    "jerk": "peak jerk",
    "acceleration_rms": "acceleration, root mean square",
    "jerk_rms": "jerk, root mean square",
    "residual_vibration": "residual vibration in a dwell",
}


def plot_frontier(found: Frontier, path: str | os.PathLike[str]) -> None:
    """Draw a frontier to a PNG, SVG or PDF file: its first axis up, the second to the right, a third as colours."""
    with canvas(path, (10.5, 7.0), layout="constrained") as figure:
        axes = figure.subplots()
        (_cloud if len(found.axes) == 3 else _curve)(figure, axes, found)
        _known(axes, found)
        axes.set(xlabel=_label(found, found.axes[1]), ylabel=_label(found, found.axes[0]))
        axes.set_title(f"{found.scene.name}: what free motion laws trade", loc="left", fontsize=12, color=INK)
        axes.grid(True, lw=0.4, color=FAINT, alpha=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        figure.legend(loc="outside lower center", ncols=2, fontsize=9, frameon=False)


def _label(found: Frontier, axis: str) -> str:
    """What an axis shows, with its unit."""
    if axis in QUANTITIES:
        quantity = QUANTITIES[axis]
        words = axis.removesuffix(f"_{quantity.unit.translate(PLAIN)}").replace("_", " ")
        return f"{words}, {quantity.unit}" if quantity.unit else words
    derivative, scene = axis.removesuffix("_rms"), found.scene
    angular = scene.follower.motion == "oscillating"
    if axis == "residual_vibration":
        return f"{WORDS[axis]}, {'deg' if angular else 'mm'}"
    if derivative not in DERIVATIVES:
        return WORDS[axis]
    unit = QUANTITIES[motion_quantity(derivative, "", angular=angular, timed=scene.cam.rpm is not None)].unit
    return f"{WORDS[axis]}, {unit}"


def _curve(figure: Any, axes: Any, found: Frontier) -> None:
    """Two axes: the front as a curve, and the bound as the edge of what cannot be."""
    up, across = found.axes
    rows = sorted(found.rows, key=lambda row: float(row[across]))
    x, y = (np.array([row[axis] for row in rows]) for axis in (across, up))
    axes.plot(x, y, "-o", color=FREE, lw=1.8, ms=4, label=_free(found), zorder=4)
    low = np.array([np.nan if row["bound"] is None else row["bound"] for row in rows])
    if np.isfinite(low).any():
        axes.plot(
            x, low, color=ALARM, lw=1.0, ls="--", label="no motion within the other limits passes this", zorder=3
        )
        floor = min(np.nanmin(low), *(row[up] for row in found.known)) if found.known else np.nanmin(low)
        bottom = floor - 0.06 * (np.nanmax(y) - floor)
        axes.fill_between(x, bottom, low, color=ALARM, alpha=0.06, lw=0)
    least = found.least.get(across, (None, None))[1]
    if least is not None and least > 0.0:
        axes.axvline(least, color=ALARM, lw=1.0, ls="--", zorder=3)


def _free(found: Frontier) -> str:
    """What free laws are, by how they were found."""
    words = "free laws, proved to hold every limit"
    return f"{words}; local optima" if found.local else words


def _cloud(figure: Any, axes: Any, found: Frontier) -> None:
    """Three axes: the front as points, the third axis as their colour."""
    up, across, third = found.axes
    x, y, z = (np.array([row[axis] for row in found.rows]) for axis in (across, up, third))
    norm = "log" if z.min() > 0.0 and z.max() > WIDE * z.min() else "linear"
    points = axes.scatter(x, y, c=z, cmap="viridis", norm=norm, s=26, zorder=4, label=_free(found))
    bar = figure.colorbar(points, ax=axes, label=_label(found, third), pad=0.01, format="{x:.3g}")
    bar.ax.yaxis.set_minor_formatter("{x:.3g}")


def _known(axes: Any, found: Frontier) -> None:
    """The known laws that the picture has room for, by name; hollow where they are beyond the other limits."""
    up, across = found.axes[:2]
    labelled = {True: "known laws", False: "known laws beyond the other limits"}
    for row in found.known:
        if isinf(row[across]) or isinf(row[up]):
            continue
        fill = {"facecolor": MUTED if row["within"] else "white", "edgecolor": MUTED}
        label = labelled.pop(row["within"], None)
        axes.scatter(row[across], row[up], s=34, zorder=5, label=label, **fill)
        laws = " / ".join(dict.fromkeys((row["law_rise"], row["law_return"])))
        place = {"xytext": (-6, -4), "ha": "right", "va": "top", "textcoords": "offset points"}
        axes.annotate(laws, (row[across], row[up]), fontsize=8, color=INK, **place)
