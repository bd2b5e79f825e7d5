"""Draws the train between follower and tool to scale: links with joints, guides and pivots."""

from typing import Any

import numpy as np

from camopt.core.numerics import ComplexArray
from camopt.model.trains.sketch import LinkSketch, Member, Support
from camopt.scene.problem.linkage import follower_pivot, linkage_sketch
from camopt.show.drawing.moving_bodies import FRAME_ANGLES
from camopt.show.drawing.picture import Picture, draw_circle, draw_line, fill_area
from camopt.show.drawing.style import BODY, FAINT, INK, MUTED

MEMBER_STYLE = {"facecolor": BODY, "edgecolor": INK, "lw": 1.1}
PIVOT = np.array([0, 0.055 - 0.075j, -0.055 - 0.075j])
BASE = np.array([-0.08 - 0.075j, 0.08 - 0.075j, 0.08 - 0.095j, -0.08 - 0.095j])
GUIDE_GAP, GUIDE_WIDTH, BAR_HALF = 0.037, 0.025, 0.022
"""Shares of the size of the cam."""


def train_sketch(picture: Picture, spans: list[ComplexArray], size: float) -> LinkSketch | None:
    """The train at the frames of a turn, on the pivot of the follower or the end of its stem; None without a train.

    The end of the stem is the highest point of ``spans``, the extent of the drawing without the train.
    """
    problem = picture.problem
    if problem.setup.angular:
        at = follower_pivot(problem)
    else:
        at = complex(problem.design.offset[0], max(float(span.imag.max()) for span in spans))
    return linkage_sketch(problem, FRAME_ANGLES % (2 * np.pi), at, size)


def draw_linkage(axes: Any, picture: Picture, spans: list[ComplexArray], size: float) -> list[ComplexArray]:
    """Draw the train at cam angle 0; return its extent over the turn."""
    if (train := train_sketch(picture, spans, size)) is None:
        return []
    draw_fixed_parts(axes, train, size)
    for member in train.members:
        draw_member(axes, member, size)
    return [sketch_extent_over_turn(train)]


def sketch_extent_over_turn(sketch: LinkSketch) -> ComplexArray:
    """The extent of a train over the turn, as points."""
    corners = [_member_corners(m)[:, None] * np.exp(1j * m.turned) + m.at for m in sketch.members]
    guides = [support.at + support.way * np.array([-1, 1]) for support in sketch.supports]
    return np.concatenate([points.ravel() for points in (*corners, *guides)])


def draw_fixed_parts(axes: Any, sketch: LinkSketch, size: float) -> None:
    """Draw the fixed supports, and the paths of the joints."""
    for support in sketch.supports:
        (_draw_pivot if support.ground == "pivot" else _draw_guide)(axes, support, size)
    for member in sketch.members:
        if member.shape == "bar":
            draw_line(axes, member.at, color=FAINT, lw=0.8, zorder=4.2)


def draw_member(axes: Any, member: Member, size: float) -> None:
    """Draw a rigid part at cam angle 0."""
    at = complex(member.at[0])
    if member.shape == "bar":
        _draw_bar(axes, at, at + complex(member.points[1]), BAR_HALF * size)
    elif member.shape == "belt":
        draw_line(axes, at + member.points, color=INK, lw=1.0, zorder=5)
    elif member.shape in ("wheel", "roller"):
        radius = float(abs(member.points[0]))
        fill_area(axes, at + radius * np.exp(1j * np.linspace(0.0, 2 * np.pi, 121)), zorder=5.2, **MEMBER_STYLE)
        draw_line(axes, [at, at + member.points[0]], color=INK, lw=0.9, zorder=5.3)
    else:
        fill_area(axes, at + member.points, zorder=5.0, **MEMBER_STYLE)


def _member_corners(member: Member) -> ComplexArray:
    if member.shape in ("wheel", "roller"):
        return np.asarray(abs(member.points[0]) * np.array([1, 1j, -1, -1j]))
    return member.points


def _draw_bar(axes: Any, start: complex, end: complex, half: float) -> None:
    """Draw a bar with round ends, and a pin at each end."""
    way = (end - start) / (abs(end - start) or 1.0)
    round_end = half * way * np.exp(1j * np.linspace(-np.pi / 2, np.pi / 2, 19))
    fill_area(axes, np.concatenate([end + round_end, start - round_end]), zorder=5.4, **MEMBER_STYLE)
    for pin in (start, end):
        draw_circle(axes, 0.4 * half, pin, color=INK, lw=0.9, zorder=5.6)


def _draw_pivot(axes: Any, pivot: Support, size: float) -> None:
    """Draw a fixed pivot on the ground."""
    fill_area(axes, pivot.at + size * PIVOT, facecolor="white", edgecolor=MUTED, lw=0.9, zorder=4.7)
    base = pivot.at + size * BASE
    fill_area(axes, base, facecolor="white", edgecolor=MUTED, hatch="//////", lw=0.0, zorder=4.6)
    draw_line(axes, base[:2], color=MUTED, lw=0.9, zorder=4.7)


def _draw_guide(axes: Any, guide: Support, size: float) -> None:
    """Draw a guide on both sides of a slider."""
    across = 1j * guide.way / abs(guide.way) * size
    for side in (-1.0, 1.0):
        inner = guide.at + side * GUIDE_GAP * across + guide.way * np.array([-1, 1])
        block = np.concatenate([inner, inner[::-1] + side * GUIDE_WIDTH * across])
        fill_area(axes, block, facecolor="white", edgecolor=MUTED, hatch="//////", lw=0.8, zorder=4.5)
