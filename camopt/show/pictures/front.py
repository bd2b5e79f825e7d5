"""The picture of a sweep: its Pareto front, with a panel for each pair of objectives that vary."""

from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.quantities.unit_systems import to_shown_unit
from camopt.scene.scene import Scene
from camopt.show.drawing.style import INK, PAGE_TITLE, SERIES, Figure, Target, add_grid, new_figure
from camopt.solve.front.result import Sweep
from camopt.solve.tables.cells import axis_label, unit_of_column
from camopt.solve.tables.designs import joined_laws

if TYPE_CHECKING:
    import pandas as pd

MOST_FRONT_PANELS = 3  # all pairs of three objectives
MOST_LAWS = len(SERIES) - 1  # laws with their own colour; further laws share the last colour
PANEL_WIDTH, PANEL_HEIGHT = 4.6, 4.4  # inches


def draw(what: "Sweep | pd.DataFrame", path: Target = None) -> "Figure":
    """Draw the Pareto front of a sweep, or a table of designs, by pairs of objectives, with the knee."""
    rows = what.to_pandas() if isinstance(what, Sweep) else what
    scene, pairs = Scene.embedded(rows.attrs["scene"], "table"), _objective_pairs(rows)
    with new_figure(path, (max(len(pairs), 2) * PANEL_WIDTH, PANEL_HEIGHT), layout="constrained") as figure:
        words = f" on the Pareto front of {what.designs:,}" if isinstance(what, Sweep) else ""
        title = f"{scene.name}: {len(rows):,} designs{words}"
        figure.suptitle(title, x=0.01, ha="left", fontsize=PAGE_TITLE, fontweight="bold")
        panels = figure.subplots(1, len(pairs), squeeze=False)[0]
        for axes, pair in zip(panels, pairs, strict=True):
            _draw_pair(axes, rows, pair)
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def draw_main_diagram(axes: Any, what: "Sweep | pd.DataFrame") -> None:
    """Draw the designs by the first two objectives that vary."""
    rows = what.to_pandas() if isinstance(what, Sweep) else what
    _draw_pair(axes, rows, _objective_pairs(rows)[0])
    axes.legend()


def _objective_pairs(rows: "pd.DataFrame") -> list[tuple[str, str]]:
    """Pairs of objectives that differ between designs."""
    search = Scene.embedded(rows.attrs["scene"], "table").search
    names = [name for name in (*search.minimise, *search.maximise) if name in rows]
    varied = [name for name in names if rows[name][np.isfinite(rows[name])].nunique() > 1]
    if len(varied) < 2:
        why = "a sweep with two objectives that vary on its Pareto front, or a table of such designs"
        raise BadInput([Mistake("camopt", "what", f"{len(rows)} designs", why)])
    return [*combinations(varied, 2)][:MOST_FRONT_PANELS]


def _draw_pair(axes: Any, rows: "pd.DataFrame", pair: tuple[str, str]) -> None:
    """Draw designs by two objectives, and the knee of the front."""
    scales = [to_shown_unit(1.0, unit_of_column(name)) for name in pair]
    points = rows[[*pair]].to_numpy(float) * scales
    laws = [joined_laws(*each) for each in zip(rows["law_rise"], rows["law_return"], strict=True)]
    for place, law in enumerate(dict.fromkeys(laws)):
        law_points = points[[each == law for each in laws]]
        label = law if place < MOST_LAWS else "_"
        axes.scatter(*law_points.T, s=18, color=SERIES[min(place, MOST_LAWS)], label=label or "designs", zorder=3)
    knee = (rows.attrs.get("front") or {}).get("knee", {})
    if all(knee.get(name) is not None for name in pair):
        place_of_knee = [knee[name] * scale for name, scale in zip(pair, scales, strict=True)]
        axes.scatter(*place_of_knee, s=90, facecolor="none", edgecolor=INK, label="knee", zorder=4)
    axes.set(xlabel=axis_label(pair[0]), ylabel=axis_label(pair[1]))
    add_grid(axes)
