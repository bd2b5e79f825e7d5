"""The picture of a batch of cams: how many have which largest errors and which quantities of limits."""

from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np

from camopt.drawing.style import (
    ALARM,
    INK,
    LIMIT,
    MUTED,
    ON_WHITE,
    PAGE_TITLE,
    SERIES,
    Figure,
    Target,
    canvas,
    dress,
)
from camopt.quantities import QUANTITIES
from camopt.quantities.unit_systems import shown, shown_unit
from camopt.tables.cells import number, suffix_of

if TYPE_CHECKING:
    from camopt.tolerances.batch import Batch

BINS, ACROSS = 60, 3
BEYOND = 0.0005
"""The share of the cams on either side that are beyond a histogram's range, in its outermost bins."""
NEARLY_ALL = 0.9973
SAME = 1e-9
"""Relative: numbers that differ by less are the same."""


def draw(what: "Batch", path: Target = None) -> "Figure":
    """Draw a histogram of each error of the motion, and of the quantity of each limit, with what is allowed."""
    columns = [(name, each) for name, each in what.samples.items() if "_off_" not in name]
    bounds = what.bounds
    rows = ceil(len(columns) / ACROSS)
    with canvas(path, (12.5, 1.0 + 2.4 * rows), layout="constrained") as figure:
        title = f"{what.scene.name}: {what.cams:,} cams drawn by the tolerances, {what.outside:,} of them outside"
        figure.suptitle(title, x=0.01, ha="left", fontsize=PAGE_TITLE, fontweight="bold")
        panels = figure.subplots(rows, ACROSS, squeeze=False).ravel()
        for axes, (name, column) in zip(panels, columns, strict=False):
            _histogram(axes, name, column, bounds.get(name))
        for axes in panels[: len(columns) : ACROSS]:
            axes.set_ylabel("cams")
        for axes in panels[len(columns) :]:
            axes.set_axis_off()
        pairs = (zip(*axes.get_legend_handles_labels(), strict=True) for axes in panels)
        handles = {label: handle for each in pairs for handle, label in each}
        figure.legend(handles.values(), handles.keys(), loc="outside lower left", ncols=4)
    return figure


def _histogram(axes: Any, name: str, column: Any, bound: float | None) -> None:
    """The cams by one of their numbers."""
    values = shown(column.values[np.isfinite(column.values)], column.unit)
    words = name.removesuffix(suffix_of(column.unit)).replace("_", " ").capitalize()
    axes.set_title(f"{words}, {shown_unit(column.unit)}", loc="left")
    low, high = np.quantile(values, [BEYOND, 1.0 - BEYOND]) if values.size else (0.0, 0.0)
    if high - low <= SAME * max(abs(low), abs(high), SAME):
        what = f"{number(float(high))} for all" if values.size else "none is put together"
        axes.text(0.5, 0.5, what, transform=axes.transAxes, ha="center", va="center", color=MUTED)
        axes.set(xticks=[], yticks=[])
    else:
        axes.hist(np.clip(values, low, high), BINS, range=(low, high), color=SERIES[0], zorder=3)
        least = name in QUANTITIES and QUANTITIES[name].side < 0.0
        share, label = (1.0 - NEARLY_ALL, "99.73 % are above") if least else (NEARLY_ALL, "99.73 % are below")
        median, nearly_all = np.quantile(values, [0.5, share])
        axes.axvline(median, color=INK, lw=1.0, label="half of the cams", zorder=4)
        axes.axvline(nearly_all, color=MUTED, lw=1.0, ls=":", label=label, zorder=4)
        axes.locator_params(axis="y", nbins=4, integer=True)
    if bound is not None:
        _limit(axes, shown(bound, column.unit), low, high)
    axes.locator_params(axis="x", nbins=5)
    dress(axes)


def _limit(axes: Any, bound: float, low: float, high: float) -> None:
    """A limit: a line where it is near the cams, else in words."""
    if low - (high - low) < bound < high + (high - low):
        axes.axvline(bound, **LIMIT, label="limit", zorder=5)
    else:
        said = number(float(bound))
        place, side, words = (
            (0.02, "left", f"← limit {said}") if bound < low else (0.98, "right", f"limit {said} →")
        )
        axes.text(place, 0.95, words, transform=axes.transAxes, ha=side, va="top", color=ALARM, **ON_WHITE)
