"""Draws the train between follower and tool to scale: links with joints, guides and pivots.

A stage that cannot be assembled, or reaches a dead point, is drawn by itself in the start position: the pivot of
its crank at the origin, the motion of its slide or the pivot of its rocker to the right. Positive angles turn
counterclockwise.
"""

from typing import Any

import numpy as np

from camopt.core.mistakes import BadInput
from camopt.core.numerics import ComplexArray, FloatArray
from camopt.model.trains import TRAIN_STAGES
from camopt.model.trains.link import AssemblyFault, formula_value_at_end
from camopt.model.trains.sketch import LinkSketch, Member, Port, Support, bar_member
from camopt.scene.problem.linkage import follower_pivot, linkage_sketch
from camopt.scene.train import train_without_loads
from camopt.show.drawing.moving_bodies import FRAME_ANGLES
from camopt.show.drawing.picture import (
    Picture,
    draw_circle,
    draw_line,
    fill_area,
    fit_axes,
    four_digit_text,
    value_with_unit,
)
from camopt.show.drawing.style import (
    ALARM,
    BODY,
    DASHES,
    FAINT,
    HEADING_SIZE,
    INK,
    MUTED,
    PAGE_TITLE,
    SERIES,
    STILL_KINDS,
    TITLE_SIZE,
    WHITE_BACKGROUND,
    Figure,
    Target,
    new_figure,
)

MEMBER_STYLE = {"facecolor": BODY, "edgecolor": INK, "lw": 1.1}
PIVOT = np.array([0, 0.055 - 0.075j, -0.055 - 0.075j])
BASE = np.array([-0.08 - 0.075j, 0.08 - 0.075j, 0.08 - 0.095j, -0.08 - 0.095j])
GUIDE_GAP, GUIDE_WIDTH, BAR_HALF = 0.037, 0.025, 0.022
"""Shares of the size of the cam."""


def train_sketch(
    picture: Picture, drawn_extent: list[ComplexArray], size: float, angles: FloatArray = FRAME_ANGLES
) -> LinkSketch | None:
    """The train at cam angles, on the pivot of the follower or the end of its stem; None without a train.

    The first angle is 0. The stem ends at the top of ``drawn_extent``, that of the drawing without the train.
    """
    problem = picture.problem
    top = max(float(span.imag.max()) for span in drawn_extent)
    at = follower_pivot(problem) if problem.setup.angular else complex(problem.design.offset[0], top)
    return linkage_sketch(problem, angles % (2 * np.pi), at, size)


def draw_linkage(axes: Any, picture: Picture, drawn_extent: list[ComplexArray], size: float) -> list[ComplexArray]:
    """Draw the train at cam angle 0; return its extent over the turn."""
    if (train := train_sketch(picture, drawn_extent, size)) is None:
        return []
    draw_fixed_parts(axes, train, size)
    for member in train.members:
        draw_member(axes, member, size)
    return [sketch_extent_over_turn(train)]


def sketch_extent_over_turn(sketch: LinkSketch) -> ComplexArray:
    """The extent of a train over the turn, as points."""
    cross, round_shapes = np.array([1, 1j, -1, -1j]), ("wheel", "roller")
    corners = [abs(m.points[0]) * cross if m.shape in round_shapes else m.points for m in sketch.members]
    moved = [c[:, None] * np.exp(1j * m.turned) + m.at for c, m in zip(corners, sketch.members, strict=True)]
    guides = [support.at + support.way * np.array([-1, 1]) for support in sketch.supports]
    return np.concatenate([points.ravel() for points in (*moved, *guides)])


def draw_fixed_parts(axes: Any, sketch: LinkSketch, size: float) -> None:
    """Draw the fixed supports (pivots on the ground, guides beside sliders), and the paths of the joints."""
    for support in sketch.supports:
        if support.ground == "pivot":
            fill_area(axes, support.at + size * PIVOT, facecolor="white", edgecolor=MUTED, lw=0.9, zorder=4.7)
            base = support.at + size * BASE
            fill_area(axes, base, facecolor="white", edgecolor=MUTED, hatch="//////", lw=0.0, zorder=4.6)
            draw_line(axes, base[:2], color=MUTED, lw=0.9, zorder=4.7)
            continue
        across = 1j * support.way / abs(support.way) * size
        for side in (-1.0, 1.0):
            inner = support.at + side * GUIDE_GAP * across + support.way * np.array([-1, 1])
            block = np.concatenate([inner, inner[::-1] + side * GUIDE_WIDTH * across])
            fill_area(axes, block, facecolor="white", edgecolor=MUTED, hatch="//////", lw=0.8, zorder=4.5)
    for member in sketch.members:
        if member.shape == "bar":
            draw_line(axes, member.at, color=FAINT, lw=0.8, zorder=4.2)


def draw_member(axes: Any, member: Member, size: float) -> None:
    """Draw a rigid part at cam angle 0; a bar has round ends and a pin at each end."""
    at = complex(member.at[0])
    if member.shape == "bar":
        end, half = at + complex(member.points[1]), BAR_HALF * size
        way = (end - at) / (abs(end - at) or 1.0)
        round_end = half * way * np.exp(1j * np.linspace(-np.pi / 2, np.pi / 2, 19))
        fill_area(axes, np.concatenate([end + round_end, at - round_end]), zorder=5.4, **MEMBER_STYLE)
        for pin in (at, end):
            draw_circle(axes, 0.4 * half, pin, color=INK, lw=0.9, zorder=5.6)
    elif member.shape == "belt":
        draw_line(axes, at + member.points, color=INK, lw=1.0, zorder=5)
    elif member.shape in ("wheel", "roller"):
        radius = float(abs(member.points[0]))
        fill_area(axes, at + radius * np.exp(1j * np.linspace(0.0, 2 * np.pi, 121)), zorder=5.2, **MEMBER_STYLE)
        draw_line(axes, [at, at + member.points[0]], color=INK, lw=0.9, zorder=5.3)
    else:
        fill_area(axes, at + member.points, zorder=5.0, **MEMBER_STYLE)


SIGNS = (
    ("+ angle", (0.11, 0.09), (0.07, 0.16), 0.4, "Angles count from the line to the right and grow as the follower moves outward. "),  # noqa: E501
    ("+ offset", (0.18, 0.09), (0.18, 0.16), 0.0, "A positive offset is on the side to which positive angles turn."),  # noqa: E501
)  # fmt: skip
"""Positive senses: name, start and end of its arrow in shares of the figure, bend of the arrow, meaning."""


def draw_stage_of_refused_scene(refused: BadInput, path: Target = None) -> "Figure | None":
    """Draw the stage of a train for which a scene was refused, in the start position, as far as it goes.

    Nothing is drawn without a stage that has a crank, and with a path that does not end in .png, .svg or .pdf.
    """
    reasons = {m.key[6:]: m.allowed for m in refused.mistakes if m.key[:6] == "train." and m.key[6:].isdecimal()}
    number = next(map(int, reasons), 0)
    row = refused.scene.train[number - 1] if number and refused.scene else None
    needs = TRAIN_STAGES[row.stage].needs if row else ()
    drawable = "crank" in needs and all(getattr(row, key) is not None for key in needs)
    if not (row and drawable and str(path or ".png").lower().endswith(STILL_KINDS)):
        return None
    signs = SIGNS[: 1 if row.ground else 2]
    stage = f"Train, stage {number} of {len(refused.scene.train)}: {TRAIN_STAGES[row.stage].words}"
    small: dict[str, Any] = {"fontsize": HEADING_SIZE, "color": MUTED}
    with new_figure(path, (10.0, 8.0)) as figure:
        lines: list[tuple[float, str, dict[str, Any]]] = [
            (0.95, refused.scene.name, {"fontsize": PAGE_TITLE, "fontweight": "bold"}),
            (0.92, stage, small),
            (0.9, reasons[str(number)], {"fontsize": TITLE_SIZE, "color": ALARM, "va": "top", "wrap": True}),
            (0.03, "".join(sign[-1] for sign in signs), small),
        ]
        for height, text, style in lines:
            figure.text(0.04, height, text, **style)
        axes = figure.add_axes((0.04, 0.18, 0.92, 0.66))
        axes.set_axis_off()
        for name, start, end, bend, _ in signs:
            arrow = {"arrowstyle": "-|>", "color": INK, "connectionstyle": f"arc3,rad={bend}"}
            axes.annotate("", end, start, "figure fraction", arrowprops=arrow)
            figure.text(end[0], start[1] - 0.025, name, **small)
        _draw_train_stage(axes, refused.scene, number)
        figure.legend(loc="lower right", bbox_to_anchor=(0.97, 0.05))
    return figure


def _draw_train_stage(axes: Any, scene: Any, stage_number: int) -> None:
    """Draw a stage: with its dead points if it can be assembled, else its crank and the gap to the other links."""
    row = scene.train[stage_number - 1]
    size, up = 2.0 * max(row.crank, row.coupler), 1j * (row.offset or 0.0)
    sketch = _sketch_with_dead_points(axes, scene, stage_number, size) or _sketch_with_gap(axes, row, size)
    draw_fixed_parts(axes, sketch, size)
    for member in sketch.members:
        draw_member(axes, member, size)
    arc = 0.45 * row.crank * np.exp(1j * np.radians(row.angle) * np.linspace(0.0, 1.0, 181))
    draw_line(axes, np.append([0.6 * size, 0.0, np.nan], arc), color=INK, lw=1.0)
    style = {"arrowstyle": "-|>", "color": INK, "shrinkA": 0, "shrinkB": 0}
    offset = (0j, up, 0.6 * up, f" offset {value_with_unit(row.offset or 0.0)} ", np.cos(np.radians(row.angle)))
    turned = (arc[-2], arc[-1], 1.15 * arc[90], f"angle {four_digit_text(row.angle)}°", -1.0)
    for start, end, place, text, beside in (turned, offset) if up else (turned,):
        axes.annotate("", (end.real, end.imag), (start.real, start.imag), arrowprops=style, zorder=6)
        _write_text_beside(axes, place, text, INK, beside)
    grounds = [each.at + 0.1 * size * np.array([-1j, 1j]) for each in sketch.supports]
    lines = [line.get_xdata() + 1j * line.get_ydata() for line in axes.lines]
    fit_axes(axes, np.concatenate([sketch_extent_over_turn(sketch), *grounds, *lines]), 0.02)


def _sketch_with_dead_points(axes: Any, scene: Any, stage_number: int, size: float) -> LinkSketch | None:
    """The stage if it can be assembled, after drawing its bars at both dead points; else None."""
    try:
        train: Any = train_without_loads(scene)
    except AssemblyFault:
        return None
    link: Any = [link for stage, link in zip(train.stages, train.links, strict=True) if stage == stage_number][-1]
    driver = np.array([0.0, *(end.at for end in link.dead_points)])
    driven = np.array([formula_value_at_end(link.driven_displacement, each) for each in driver])
    sketch: LinkSketch = link.sketch(driver, driven, size)
    bars = [member for member in sketch.members if member.shape == "bar"]
    for place, end in enumerate(link.dead_points, start=1):
        shown = [[*(bar.at[place] + bar.points * np.exp(1j * bar.turned[place])), np.nan] for bar in bars]
        style = {"color": SERIES[place], "ls": DASHES[1], "lw": 1.6, "zorder": 5.8}
        draw_line(axes, np.concatenate(shown), label=f"dead point: {end.why}", **style)
    return sketch


def _sketch_with_gap(axes: Any, row: Any, size: float) -> LinkSketch:
    """The crank and the supports, after drawing what the other links reach and the gap between them."""
    pin, reach = row.crank * np.exp(1j * np.radians(row.angle)), row.rocker or 0.0
    far = complex(row.ground) if row.ground else complex(pin.real, row.offset or 0.0)
    apart, longer = abs(far - pin), row.coupler - reach
    inside = bool(row.ground) and apart < abs(longer)
    signs = np.sign([longer, longer]) if inside else np.array([1.0, -1.0])
    ends = np.array([pin, far]) + signs * [row.coupler, reach] * ((far - pin) / apart if apart else 1.0)
    draw_circle(axes, row.coupler, pin, color=SERIES[0], lw=1.2, ls=DASHES[1], label="reach of the coupler")
    line = (
        far + reach * np.exp(1j * np.linspace(0.0, 2 * np.pi, 361))
        if row.ground
        else far + size * np.array([-0.6, 0.6])
    )
    name = "reach of the rocker" if row.ground else "line of the slide"
    draw_line(axes, line, color=SERIES[1], lw=1.2, ls=DASHES[2], label=name)
    if inside or apart >= row.coupler + reach:
        gap = f"gap {value_with_unit(abs(ends[1] - ends[0]))}"
        draw_line(axes, [pin, ends[0], np.nan, far, ends[1]], color=MUTED, lw=1.2)
        draw_line(axes, ends, color=ALARM, lw=3.0, marker="o", ms=4, label=gap, zorder=6)
        _write_text_beside(axes, ends.mean(), f" {gap} ", ALARM, -1.0 if row.ground else -pin.real)
    support = Support("pivot", far) if row.ground else Support("guide", far, complex(0.15 * size))
    bar = bar_member((np.zeros(1, complex), np.array([pin])))
    return LinkSketch([bar], [Support("pivot", 0.0), support], Port(0.0), Port(0.0))


def _write_text_beside(axes: Any, point: complex, text: str, colour: str, left_if_positive: float) -> None:
    """Write a text to the right of a place if ``left_if_positive`` is negative, else to its left."""
    style = {"ha": "left" if left_if_positive < 0.0 else "right", "color": colour, "fontsize": TITLE_SIZE}
    axes.text(point.real, point.imag, text, **style, **WHITE_BACKGROUND)
