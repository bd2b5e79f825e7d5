"""The picture of a frontier: free laws as a front, values that no motion can reach, known laws as points."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isinf, pi
from typing import Any, cast

import numpy as np

from camopt.core.quantities.unit_systems import to_shown_unit, unit_in_shown_system
from camopt.model.motion.stroke import RISE
from camopt.show.drawing.labels import Label, label_place_candidates, place_labels
from camopt.show.drawing.style import (
    ALARM,
    COLOURS,
    INK,
    LIMIT_STYLE,
    MUTED,
    PAGE_TITLE,
    TEXT_SIZE,
    Figure,
    Target,
    add_grid,
    new_figure,
)
from camopt.solve.synthesis.frontier_result import Frontier
from camopt.solve.synthesis.term_units import term_unit
from camopt.solve.tables.designs import joined_laws

FREE_COLOUR = COLOURS[RISE]
LOG_RATIO = 5.0  # a larger ratio of values gets a logarithmic scale
AXES_MARGIN = 0.06  # margin around the points, as share of their span
LAW_LABEL_DISTANCES = (6.0, 10.0, 16.0)  # points from a point to its label
LEFT_BELOW = 1.25 * pi
UNIT_LETTERS = str.maketrans({"·": "_", "/": "_", "µ": "u"})  # units as in names of quantities
AXIS_NAMES = {
    "size": "size (radius of the cam)",
    "velocity": "velocity (largest)",
    "acceleration": "acceleration (largest)",
    "jerk": "jerk (largest)",
    "acceleration_rms": "acceleration rms (root mean square)",
    "jerk_rms": "jerk rms (root mean square)",
    "residual_vibration": "residual vibration (in a dwell)",
    "lost_lift_area": "lost lift area (of the highest lift all round)",
}
"""Labels of terms; each begins with the name of the term in tables."""


def draw_main_diagram(axes: Any, frontier: Frontier) -> None:
    """Draw a frontier in axes: first axis vertical, second horizontal, third as colours."""
    labels = _draw_frontier(axes, _frontier_in_shown_units(frontier))
    axes.legend()
    place_labels(axes.figure, labels)


def _draw_frontier(axes: Any, frontier: Frontier) -> list[Label]:
    """Draw the frontier, the known laws and the excluded region; return the labels to place.

    A front of two axes is a curve; one of three axes has points, with the third axis as colour.
    """
    up, across, *third = frontier.axes
    label = f"free laws, proved to meet every limit{'; local optima' if frontier.local else ''}"
    if third:
        x, y, z = (np.array([row[axis] for row in frontier.rows]) for axis in (across, up, *third))
        norm = "log" if z.min() > 0.0 and z.max() > LOG_RATIO * z.min() else "linear"
        marks = axes.scatter(x, y, c=z, cmap="viridis", norm=norm, s=26, zorder=4, label=label)
        bar = axes.figure.colorbar(marks, ax=axes, label=_axis_label(frontier, *third), pad=0.01, format="{x:.3g}")
        bar.ax.yaxis.set_minor_formatter("{x:.3g}")
    else:
        rows = sorted(frontier.rows, key=lambda row: float(row[across]))
        points = ([row[axis] for row in rows] for axis in (across, up))
        axes.plot(*points, "-o", color=FREE_COLOUR, lw=1.8, ms=4, label=label, zorder=4)
    known = [row for row in frontier.known if not isinf(row[across]) and not isinf(row[up])]
    labels = _draw_known_laws(axes, known, across, up)
    axes.set(xlabel=_axis_label(frontier, across), ylabel=_axis_label(frontier, up))
    add_grid(axes)
    # around all points, and around the lower bound over all motions if it is near
    for set_limits, name in ((axes.set_xlim, across), (axes.set_ylim, up)):
        values = [float(row[name]) for row in (*frontier.rows, *known)]
        low, high = min(values), max(values)
        span = (high - low) or abs(high) or 1.0
        least = frontier.least[name][1]
        low = min(low, least) if least is not None and least > low - span else low
        set_limits(low - AXES_MARGIN * span, high + AXES_MARGIN * span)
    _shade_excluded_region(axes, frontier)
    return labels


def draw(frontier: Frontier, path: Target = None) -> "Figure":
    """Draw a frontier on a new figure."""
    frontier = _frontier_in_shown_units(frontier)
    with new_figure(path, (10.5, 7.0), layout="constrained") as figure:
        axes = figure.subplots()
        title = f"{frontier.scene.name}: the trade-off with free motion laws"
        axes.set_title(title, loc="left", fontsize=PAGE_TITLE, weight="bold")
        labels = _draw_frontier(axes, frontier)
        figure.legend(loc="outside lower center", ncols=2)
        place_labels(figure, labels)
    return figure


def _axis_label(frontier: Frontier, axis: str) -> str:
    """The label of an axis, with its unit."""
    unit = term_unit(axis, frontier.scene)
    words = AXIS_NAMES.get(axis) or axis.removesuffix(f"_{unit.translate(UNIT_LETTERS)}").replace("_", " ")
    return f"{words}, {unit_in_shown_system(unit)}" if unit else words


def _frontier_in_shown_units(frontier: Frontier) -> Frontier:
    """The frontier with the values of its axes in shown units."""
    units = frontier.units

    def convert_row(row: Mapping[str, Any]) -> Any:
        known = {name: unit for name, unit in units.items() if row.get(name) is not None}
        return {**row, **{name: to_shown_unit(row[name], unit) for name, unit in known.items()}}

    least = {
        axis: tuple(end and to_shown_unit(end, units[axis]) for end in ends)
        for axis, ends in frontier.least.items()
    }
    rows, known = ([convert_row(row) for row in each] for each in (frontier.rows, frontier.known))
    return replace(frontier, rows=rows, known=known, least=cast("dict[str, tuple[float, float | None]]", least))


def _shade_excluded_region(axes: Any, frontier: Frontier) -> None:
    """Shade the values that no motion can reach: a rectangle for each bound, with one outline."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    corners = [(min(a, right), min(b, top)) for a, b in frontier.excluded if a > left and b > bottom]
    if not corners:
        return
    x = [left, *(a for a, _ in corners)]
    y = [b for _, b in corners]
    axes.stairs(y, x, baseline=bottom, fill=True, color=ALARM, alpha=0.07, lw=0, zorder=1)
    outline = [point for b, a, c in zip(y, x, x[1:], strict=False) for point in ((a, b), (c, b))]
    outline = outline[int(y[0] == top) :]  # the edge of the picture is not a bound
    outline += [] if corners[-1][0] == right else [(corners[-1][0], bottom)]
    axes.plot(
        *zip(*outline, strict=True),
        label="shaded: no motion within the other limits reaches this region",
        zorder=3,
        **LIMIT_STYLE,
    )


def _draw_known_laws(axes: Any, known: Sequence[Mapping[str, Any]], across: str, up: str) -> list[Label]:
    """Draw the known laws as points, hollow if they break another limit; return their labels."""
    words = {True: "known laws, each on its smallest cam", False: "known laws that break another limit"}
    labels = []
    for within, label in words.items():
        rows = [row for row in known if row["within"] == within]
        points = [(row[across], row[up]) for row in rows]
        if points:
            face = MUTED if within else "white"
            axes.scatter(*zip(*points, strict=True), s=34, zorder=5, label=label, facecolor=face, edgecolor=MUTED)
        for row, point in zip(rows, points, strict=True):
            laws = joined_laws(row["law_rise"], row["law_return"])
            style = {"fontsize": TEXT_SIZE, "color": INK, "zorder": 6}
            labels.append(Label(axes, laws, point, label_place_candidates(LAW_LABEL_DISTANCES, LEFT_BELOW), style))
    return labels
