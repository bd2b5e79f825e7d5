"""The picture of two Pareto fronts: points on both, and points on one of them only."""

from itertools import combinations
from typing import Any

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import BoolArray, FloatArray
from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.show.comparing.compare import Comparison, TableComparison
from camopt.show.drawing.style import MUTED, PAGE_TITLE, SERIES, Figure, Target, add_grid, new_figure
from camopt.solve.tables.cells import axis_label

MOST_OBJECTIVE_PAIRS = 3  # side by side: all pairs of three objectives
PANEL_WIDTH, PANEL_HEIGHT = 4.6, 4.4  # inches: of a panel


def draw(comparison: Comparison, path: Target = None) -> "Figure":
    """Draw both Pareto fronts: a row of panels for each table, a panel for each pair of objectives that vary."""
    rows = {
        name: table
        for name, table in comparison.by_table.items()
        if table.fronts and _varying_objective_pairs(table)
    }
    if not rows:
        why = "results with Pareto fronts of the same objectives, at least two of which vary"
        raise BadInput([Mistake("camopt", "what", repr(comparison), why)])
    many = max(len(_varying_objective_pairs(table)) for table in rows.values())
    with new_figure(path, (max(many, 2) * PANEL_WIDTH, len(rows) * PANEL_HEIGHT), layout="constrained") as figure:
        title = f"Pareto fronts: {comparison.a} (A) and {comparison.b} (B)"
        figure.suptitle(title, x=0.01, ha="left", fontsize=PAGE_TITLE, fontweight="bold")
        for panels, (name, table) in zip(
            figure.subplots(len(rows), many, squeeze=False), rows.items(), strict=True
        ):
            pairs = _varying_objective_pairs(table)
            for axes in panels[len(pairs) :]:
                axes.set_axis_off()
            for axes, pair in zip(panels, pairs, strict=False):
                _draw_fronts(axes, table, pair)
            panels[0].set_title(name, loc="left")
        drawn = [axes.get_legend_handles_labels() for axes in figure.axes]
        once = {label: handle for handles, labels in drawn for handle, label in zip(handles, labels, strict=True)}
        figure.legend(once.values(), once.keys(), loc="outside lower center", ncols=3)
    return figure


def _front_objectives_in_shown_units(table: TableComparison) -> tuple[FloatArray, FloatArray]:
    """Objectives of the points of both fronts, in shown units."""
    assert table.fronts is not None
    signs = np.array([1.0 if aim == "minimise" else -1.0 for aim in table.objectives[0].values()])
    scales = signs * [to_shown_unit(1.0, table.units[name]) for name in table.objectives[0]]
    a, b = table.fronts.costs
    return a * scales, b * scales


def _varying_objective_pairs(table: TableComparison) -> list[tuple[int, int]]:
    """Pairs of objectives that differ between points."""
    every = np.concatenate(_front_objectives_in_shown_units(table))
    varied = [k for k, column in enumerate(every.T) if np.unique(column[np.isfinite(column)]).size > 1]
    return list(combinations(varied, 2))[:MOST_OBJECTIVE_PAIRS]


def _draw_fronts(axes: Any, table: TableComparison, pair: tuple[int, int]) -> None:
    """Draw both fronts in two objectives: common points, points only of A and only of B."""
    a, b = _front_objectives_in_shown_units(table)
    in_both = _are_among_points(a, b)
    for points, label, look in (
        (a[in_both], "on both fronts", {"color": MUTED, "marker": ".", "s": 16}),
        (a[~in_both], "only on A's front", {"facecolor": "none", "edgecolor": SERIES[0], "marker": "o", "s": 22}),
        (b[~_are_among_points(b, a)], "only on B's front", {"color": SERIES[1], "marker": "x", "s": 18, "lw": 1.0}),
    ):
        if len(points):
            axes.scatter(points[:, pair[0]], points[:, pair[1]], label=label, zorder=3, **look)
    names = [*table.objectives[0]]
    across, up = (axis_label(names[k], table.units[names[k]]) for k in pair)
    axes.set(xlabel=across, ylabel=up)
    add_grid(axes)


def _are_among_points(points: FloatArray, reference_points: FloatArray) -> BoolArray:
    """Mask of points that are also in ``reference_points``."""
    known = {tuple(each) for each in reference_points.tolist()}
    return np.array([tuple(each) in known for each in points.tolist()], dtype=bool)
