"""Places labels at points of a finished drawing, so that they hide no text, no mark and, if possible, no line.

One label after the other takes the first free place, or the cheapest one. Leaving the figure or overlapping a text
costs most, leaving the axes or overlapping a mark or body costs less, crossing a line costs least, by its width.
"""

from collections.abc import Iterable, Sequence
from itertools import cycle
from math import cos, pi, sin
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray

TEXT_COST, MARK_COST = 1e6, 1e3  # costs of each overlap of a place; a line costs half its width in pixels
TEXT_ROOM = 2.5  # points around a text, free of other texts
MARK_ROOM = 2.4  # points around a text, free of centres of marks
LABEL_ORDER = 4.6  # drawing order: patches above it hide a label
LEAST_OFFSET = 1e-6  # points; a smaller offset counts as 0

LabelPlace = tuple[float, float]
"""Offset of the near edge of a label from its point [points]."""


def label_place_candidates(
    distances: Iterable[float], first_direction: float = 0.0, directions: int = 8
) -> list[LabelPlace]:
    """Places at each distance in turn, in ``directions`` directions, first near ``first_direction`` [rad]."""
    turns = [2.0 * pi * ((k + 1) // 2) * (-1) ** k / directions for k in range(directions)]
    return [(d * cos(first_direction + turn), d * sin(first_direction + turn)) for d in distances for turn in turns]


class Label(NamedTuple):
    """A text at a point of axes (in data units), and its possible places, the best first."""

    axes: Any
    text: str
    point: tuple[float, float]
    places: Sequence[LabelPlace]
    style: dict[str, Any]
    thinnest: float = 0.0
    """Thinner lines [points] may cross the text."""


def place_labels(figure: Any, labels: Sequence[Label]) -> None:
    """Draw labels into a figure whose other parts are already drawn."""
    from matplotlib.text import Text

    figure.draw_without_rendering()
    renderer = getattr(figure.canvas, "get_renderer", lambda: None)()  # other backends create it when needed
    texts = figure.findobj(lambda artist: isinstance(artist, Text) and artist.get_visible() and artist.get_text())
    occupied = [text.get_window_extent(renderer).get_points() for text in texts]
    room, clear = (points * figure.dpi / 72.0 for points in (TEXT_ROOM, MARK_ROOM))
    obstacles = {key: _label_obstacles(*key) for key in {(label.axes, label.thinnest) for label in labels}}
    for label in labels:
        text = label.axes.annotate(
            label.text,
            label.point,
            label.places[0],
            textcoords="offset points",
            annotation_clip=False,
            **label.style,
        )
        text.set_in_layout(False)
        costs: list[float] = []
        for place in label.places:
            _set_text_place(text, place)
            box, (marks, bodies, lines) = text.get_window_extent(renderer), obstacles[label.axes, label.thinnest]
            met = box.padded(room).count_overlaps(occupied) + _leaves_bounds(box, figure.bbox)
            marked = (
                box.padded(clear).count_contains(marks)
                + _leaves_bounds(box, label.axes.bbox)
                + sum(body.intersects_bbox(box, filled=True) for body in bodies)
            )
            crossed = sum(half for path, half in lines if path.intersects_bbox(box.padded(half), filled=False))
            costs.append(TEXT_COST * met + MARK_COST * marked + crossed)
            if costs[-1] == 0.0:
                break
        _set_text_place(text, label.places[int(np.argmin(costs))])
        occupied.append(text.get_window_extent(renderer).get_points())


def _set_text_place(text: Any, place: LabelPlace) -> None:
    """Move a text to a place, aligned by its edge or corner nearest to its point."""
    x, y = place
    text.set(
        position=place,
        ha="center" if abs(x) < LEAST_OFFSET else "left" if x > 0.0 else "right",
        va="center" if abs(y) < LEAST_OFFSET else "bottom" if y > 0.0 else "top",
    )


def _label_obstacles(axes: Any, least_width: float) -> tuple[FloatArray, list[Any], list[tuple[Any, float]]]:
    """Centres of marks, outlines of patches above labels, and lines with half their widths, of axes [pixels]."""
    from matplotlib.collections import LineCollection, PathCollection

    marked = [line for line in axes.lines if line.get_marker() not in (None, "None", "")]
    clouds = [points for points in axes.collections if isinstance(points, PathCollection)]
    centres = [
        np.zeros((0, 2)),
        *(line.get_transform().transform(line.get_xydata()) for line in marked),
        *(axes.transData.transform(points.get_offsets()) for points in clouds),
    ]
    over = (patch for patch in axes.patches if patch.get_zorder() > LABEL_ORDER)
    outlines = [patch.get_transform().transform_path(patch.get_path()) for patch in over]
    half, lines = axes.figure.dpi / 72.0 / 2.0, []  # half a point in pixels
    for line in axes.lines:
        if line.get_linestyle() != "None" and line.get_linewidth() >= least_width:
            path = line.get_transform().transform_path(line.get_path()).cleaned(remove_nans=True)
            lines.append((path, half * line.get_linewidth()))
    for several in axes.collections:
        if isinstance(several, LineCollection):
            widths = cycle(np.atleast_1d(several.get_linewidth()).tolist())
            for path, width in zip(several.get_paths(), widths, strict=False):
                lines.append((axes.transData.transform_path(path), half * width))
    return np.concatenate(centres), outlines, lines


def _leaves_bounds(box: Any, bounds: Any) -> bool:
    """Whether a box is not completely within bounds."""
    return bool(box.x0 < bounds.x0 or box.y0 < bounds.y0 or box.x1 > bounds.x1 or box.y1 > bounds.y1)
