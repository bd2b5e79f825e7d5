"""The picture of a sweep: its Pareto front, a panel for each pair of objectives that vary."""

from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from camopt.drawing.canvas import Target, canvas
from camopt.drawing.style import INK, PAGE_TITLE, SERIES, dress
from camopt.front.result import Sweep
from camopt.mistakes import BadInput, Mistake
from camopt.quantities.unit_systems import shown
from camopt.tables.cells import axis_label, unit_of_column
from camopt.tables.columns import joined_laws

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

MOST_PANELS = 3  # all pairs of three objectives
MOST_LAWS = len(SERIES) - 1  # with a colour each; further laws share the last colour
PANEL_WIDTH, PANEL_HEIGHT = 4.6, 4.4  # inches


def draw(result: Sweep, path: Target = None) -> "Figure":
    """Draw the Pareto front of a sweep by pairs of its objectives, coloured by law, with its knee."""
    front = result.to_pandas()
    pairs = _pairs(result, front)
    with canvas(path, (max(len(pairs), 2) * PANEL_WIDTH, PANEL_HEIGHT), layout="constrained") as figure:
        title = f"{result.scene.name}: {len(front):,} designs on the Pareto front of {result.designs:,}"
        figure.suptitle(title, x=0.01, ha="left", fontsize=PAGE_TITLE, fontweight="bold")
        panels = figure.subplots(1, len(pairs), squeeze=False)[0]
        for axes, pair in zip(panels, pairs, strict=True):
            _draw_pair(axes, result, front, pair)
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def draw_in(axes: Any, result: Sweep) -> None:
    """Draw the front by the first two objectives that vary."""
    front = result.to_pandas()
    _draw_pair(axes, result, front, _pairs(result, front)[0])
    axes.legend()


def _pairs(result: Sweep, front: "pd.DataFrame") -> list[tuple[str, str]]:
    """The pairs of objectives that differ from design to design."""
    names = [*result.scene.search.minimise, *result.scene.search.maximise]
    varied = [name for name in names if front[name][np.isfinite(front[name])].nunique() > 1]
    if len(varied) < 2:
        why = "a sweep with two objectives that vary on its Pareto front"
        raise BadInput([Mistake("camopt", "what", repr(result), why)])
    return [*combinations(varied, 2)][:MOST_PANELS]


def _draw_pair(axes: Any, result: Sweep, front: "pd.DataFrame", pair: tuple[str, str]) -> None:
    """The front by two objectives, and its knee."""
    scales = [shown(1.0, unit_of_column(name)) for name in pair]
    points = front[[*pair]].to_numpy(float) * scales
    laws = [joined_laws(*each) for each in zip(front["law_rise"], front["law_return"], strict=True)]
    for place, law in enumerate(dict.fromkeys(laws)):
        own = points[[each == law for each in laws]]
        label = law if place < MOST_LAWS else "_"
        axes.scatter(*own.T, s=18, color=SERIES[min(place, MOST_LAWS)], label=label or "designs", zorder=3)
    if result.front and all(name in result.front.knee for name in pair):
        knee = [result.front.knee[name] * scale for name, scale in zip(pair, scales, strict=True)]
        axes.scatter(*knee, s=90, facecolor="none", edgecolor=INK, label="knee", zorder=4)
    axes.set(xlabel=axis_label(pair[0]), ylabel=axis_label(pair[1]))
    dress(axes)
