"""Labels at points of a finished drawing, each where it hides least: no text, no mark and, if possible, no line.

One label after the other takes the cheapest of its places: the first that is free, if one is. A place costs most
where it leaves the figure or meets another text, less where it leaves its axes or meets a mark or a body, and least
where a line runs through it.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import cycle
from math import cos, pi, sin
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray

TEXT_COST, MARK_COST, LINE_COST = 1e6, 1e3, 1.0  # what a place costs for each that it meets
TEXT_ROOM = 2.5  # points around a text without another
MARK_ROOM = 2.4  # and without the middle of a mark
LABEL_ORDER = 4.6  # the order of drawing: what is above hides a label
LEAST_OFFSET = 1e-6  # of a point: an offset that is none

LabelPlace = tuple[float, float]
"""Where the near edge of a label is, in points from its point."""


def label_places(distances: Iterable[float], first: float = 0.0, directions: int = 8) -> list[LabelPlace]:
    """Places in so many directions, those near to ``first`` (rad) first, at each distance in turn."""
    turns = [2.0 * pi * ((k + 1) // 2) * (-1) ** k / directions for k in range(directions)]
    return [(d * cos(first + turn), d * sin(first + turn)) for d in distances for turn in turns]


class Label(NamedTuple):
    """A text at a point of axes, in data, and the places that it may have, the best first."""

    axes: Any
    text: str
    point: tuple[float, float]
    places: Sequence[LabelPlace]
    style: dict[str, Any]
    thinnest: float = 0.0
    """Lines thinner than that (points) may run through the text."""


def place_labels(figure: Any, labels: Sequence[Label]) -> None:
    """Draw labels into a figure in which everything else is drawn already."""
    from matplotlib.text import Text

    figure.draw_without_rendering()
    renderer = getattr(figure.canvas, "get_renderer", lambda: None)()  # other backends make one when they need it
    texts = figure.findobj(lambda artist: isinstance(artist, Text) and artist.get_visible() and artist.get_text())
    taken = [text.get_window_extent(renderer).get_points() for text in texts]
    room, clear = (points * figure.dpi / 72.0 for points in (TEXT_ROOM, MARK_ROOM))
    every = {(label.axes, label.thinnest) for label in labels}
    seen = {
        (axes, pen): (_mark_points(axes), _body_outlines(axes), list(_line_paths(axes, pen))) for axes, pen in every
    }
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
            box, (marks, bodies, lines) = text.get_window_extent(renderer), seen[label.axes, label.thinnest]
            met = box.padded(room).count_overlaps(taken) + _leaves_bounds(box, figure.bbox)
            marked = box.padded(clear).count_contains(marks) + _leaves_bounds(box, label.axes.bbox)
            marked += sum(body.intersects_bbox(box, filled=False) for body in bodies)
            crossed = sum(path.intersects_bbox(box.padded(half), filled=False) for path, half in lines)
            costs.append(TEXT_COST * met + MARK_COST * marked + LINE_COST * crossed)
            if costs[-1] == 0.0:
                break
        _set_text_place(text, label.places[int(np.argmin(costs))])
        taken.append(text.get_window_extent(renderer).get_points())


def _set_text_place(text: Any, place: LabelPlace) -> None:
    """A text at a place, with the edge or corner that is nearest to its point there."""
    x, y = place
    text.set_position(place)
    text.set_horizontalalignment("center" if abs(x) < LEAST_OFFSET else "left" if x > 0.0 else "right")
    text.set_verticalalignment("center" if abs(y) < LEAST_OFFSET else "bottom" if y > 0.0 else "top")


def _mark_points(axes: Any) -> FloatArray:
    """Where axes have marks, in pixels (n, 2)."""
    from matplotlib.collections import PathCollection

    marked = [line for line in axes.lines if line.get_marker() not in (None, "None", "")]
    found = [line.get_transform().transform(line.get_xydata()) for line in marked]
    clouds = [points for points in axes.collections if isinstance(points, PathCollection)]
    found += [axes.transData.transform(points.get_offsets()) for points in clouds]
    return np.concatenate([np.zeros((0, 2)), *found])


def _line_paths(axes: Any, thinnest: float) -> Iterator[tuple[Any, float]]:
    """The lines of axes and half their widths, in pixels."""
    from matplotlib.collections import LineCollection

    half = axes.figure.dpi / 72.0 / 2.0  # of a point, in pixels
    for line in axes.lines:
        if line.get_linestyle() != "None" and line.get_linewidth() >= thinnest:
            path = line.get_transform().transform_path(line.get_path()).cleaned(remove_nans=True)
            yield path, half * line.get_linewidth()
    for several in axes.collections:
        if isinstance(several, LineCollection):
            widths = cycle(np.atleast_1d(several.get_linewidth()).tolist())
            for path, width in zip(several.get_paths(), widths, strict=False):
                yield axes.transData.transform_path(path), half * width


def _body_outlines(axes: Any) -> list[Any]:
    """The outlines of what is drawn over the lines of axes, in pixels."""
    over = (patch for patch in axes.patches if patch.get_zorder() > LABEL_ORDER)
    return [patch.get_transform().transform_path(patch.get_path()) for patch in over]


def _leaves_bounds(box: Any, bounds: Any) -> bool:
    """Whether a box is not wholly within bounds."""
    return bool(box.x0 < bounds.x0 or box.y0 < bounds.y0 or box.x1 > bounds.x1 or box.y1 > bounds.y1)
