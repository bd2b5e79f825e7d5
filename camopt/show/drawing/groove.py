"""Draws the groove or rib of a cylindrical cam, developed at the mean radius, with its rollers."""

from typing import Any

import numpy as np
from shapely import LineString

from camopt.core.numerics import ComplexArray
from camopt.core.quantities.unit_systems import from_shown_unit, to_shown_unit, unit_in_shown_system
from camopt.scene.problem.linkage import follower_pivot
from camopt.show.drawing.follower import FollowerAxes, draw_arm
from camopt.show.drawing.labels import Label
from camopt.show.drawing.linkage import draw_linkage
from camopt.show.drawing.picture import (
    STROKE_NAMES,
    Picture,
    draw_line,
    fill_area,
    fit_axes,
    four_digit_length_text,
    four_digit_text,
    round_down_to_1_2_5,
)
from camopt.show.drawing.style import (
    BODY,
    COLOURS,
    FAINT,
    FILL,
    INK,
    MUTED,
    PITCH_COLOUR,
    PROFILE_WIDTH,
    SMALL_SIZE,
    TEXT_SIZE,
)

ANGLE_OFFSETS = ((0.0, 2.0), (0.0, 11.0), (0.0, 20.0))  # points from the surface to a cam angle above it
STEM_WIDTH, STEM_OVERRUN = 0.05, 0.25
"""Width of a stem that drives a train, and its length above the surface, in mean radii."""


def draw_groove(axes: Any, picture: Picture) -> list[Label]:
    """Draw the developed groove or rib over one turn, with rollers at its start; return the labels to place."""
    size, (low, high) = float(picture.problem.design.size[0]), drawn_cylinder_ends(picture)
    around = 2 * np.pi * size
    sheet = np.array([low * 1j, around + low * 1j, around + high * 1j, high * 1j])
    (face,) = axes.fill(sheet.real, sheet.imag, facecolor=surface_colour(picture), edgecolor=INK, lw=1.0, zorder=1)
    draw_groove_or_rib(axes, picture, around)
    for artist in [*axes.patches[1:], *axes.lines]:
        artist.set_clip_path(face)
    labels, style = [], {"fontsize": SMALL_SIZE, "color": MUTED}
    for angle in [*(s.start for s in picture.problem.programme.strokes), 2 * np.pi]:
        draw_line(axes, size * angle + 1j * np.array([low, high]), color=FAINT, lw=0.7, zorder=1.5)
        text, point = f"{np.degrees(angle):.4g}°", (size * angle, high)
        labels.append(Label(axes, text, point, ANGLE_OFFSETS, style, PROFILE_WIDTH))
    arrow = {"arrowstyle": "-|>", "color": INK, "lw": 1.2, "mutation_scale": 11}
    axes.annotate("", (0.91, 1.14), (0.97, 1.14), xycoords="axes fraction", arrowprops=arrow)
    place = {"ha": "right", "va": "center", "fontsize": TEXT_SIZE, "color": INK, "transform": axes.transAxes}
    axes.text(0.905, 1.14, "the surface moves", **place)
    spans = [sheet, *draw_groove_follower(FollowerAxes(axes, axes, axes), picture)]
    spans += draw_linkage(axes, picture, spans, size)
    points, box, page = np.concatenate(spans), axes.get_position(), axes.figure.get_size_inches()
    needed = box.height * page[1] / page[0] * np.ptp(points.real) / np.ptp(points.imag)
    width = min(box.width, float(needed))  # the points at equal scales need no more
    axes.set_position((box.x0 + (box.width - width) / 2, box.y0, width, box.height))
    fit_axes(axes, points, 0.02)
    radius, unit = four_digit_length_text(size), unit_in_shown_system("mm")
    axes.spines[:].set_visible(False)
    step = _round_down_in_shown_unit((high - low) / 4)
    axes.set(
        xlabel=f"circumference at R {radius}, {unit}",
        ylabel=f"along the axis, {unit}",
        xticks=np.arange(0.0, around, _round_down_in_shown_unit(around / 4)),
        yticks=np.arange(np.ceil(low / step), np.floor(high / step) + 1.0) * step,
    )
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(lambda length, _: four_digit_text(to_shown_unit(length, "mm")))
    return labels


def _round_down_in_shown_unit(length: float) -> float:
    """A length [mm] that is round in the shown unit, and at most ``length``."""
    return float(from_shown_unit(round_down_to_1_2_5(to_shown_unit(length, "mm")), "mm"))


def surface_colour(picture: Picture) -> str:
    """The colour of the surface beside the flanks: metal beside a groove, cut away beside a rib."""
    return "white" if picture.problem.setup.mechanism.further_contacts else FILL


def drawn_cylinder_ends(picture: Picture) -> tuple[float, float]:
    """Ends of the drawn surface of a cylindrical cam along its axis [mm], beyond the whole groove."""
    radius, size = float(picture.problem.design.roller_radius[0]), float(picture.problem.design.size[0])
    pitch = np.concatenate([c.pitch.imag for each in picture.contacts for c in each.curves])
    low, high = float(pitch.min()) - radius, float(pitch.max()) + radius
    edge = 0.1 * (high - low) + 0.01 * np.pi * size
    return low - edge, high + edge


def draw_groove_or_rib(axes: Any, picture: Picture, circumference: float) -> None:
    """Draw a groove or rib with coloured flanks and pitch curves, also on the neighbouring turns."""
    radius, contacts = float(picture.problem.design.roller_radius[0]), [each.curves for each in picture.contacts]
    shifts = (-circumference, 0.0, circumference)
    pitches = [np.concatenate([c.pitch for c in curves]) for curves in contacts]
    pitches = [np.concatenate([pitch + shift for shift in shifts]) for pitch in pitches]
    if len(contacts) > 1:
        upper, lower = (np.concatenate([c.profile[0] for c in curves]) for curves in contacts)
        for shift in shifts:
            between = np.concatenate([upper, lower[::-1]]) + shift
            fill_area(axes, between, facecolor=FILL, edgecolor=FILL, lw=0.6, zorder=2)
    elif radius > 0.0:  # the region that the roller sweeps
        swept = LineString(np.column_stack([pitches[0].real, pitches[0].imag])).buffer(radius, quad_segs=32)
        for part in getattr(swept, "geoms", [swept]):
            for ring, colour in [(part.exterior, "white"), *((hole, FILL) for hole in part.interiors)]:
                axes.fill(*np.asarray(ring.coords).T, facecolor=colour, edgecolor=INK, lw=0.6, zorder=2)
    labelled = set()
    width = 0.9 if picture.undercut else 2.0
    for kind, curves in (
        (kind, c) for each in contacts for kind, c in zip(picture.stroke_kind_of_each_piece, each, strict=True)
    ):
        for side in curves.profile[: 2 if radius > 0.0 else 1]:
            label = f"profile, {STROKE_NAMES[kind]}" if kind not in labelled else None
            labelled.add(kind)
            for shift in (0.0, -circumference, circumference):
                draw_line(axes, side + shift, color=COLOURS[kind], lw=width, label=label, zorder=4)
                label = None
    dashes = {"color": PITCH_COLOUR, "lw": 1.0, "ls": (0, (9, 2.5, 1.5, 2.5)), "zorder": 3}
    for number, pitch in enumerate(pitches if radius > 0.0 else ()):
        draw_line(axes, pitch, label=None if number else "pitch curve", **dashes)


def draw_groove_follower(follower_axes: FollowerAxes, picture: Picture) -> list[ComplexArray]:
    """Draw the rollers at the start of the turn, and the arm of an oscillating follower; return their extent."""
    axes, design, angular = follower_axes.follower, picture.problem.design, picture.problem.setup.angular
    starts = [complex(each.curves[0].pitch[0]) for each in picture.contacts]
    start, radius, spans = starts[0], float(design.roller_radius[0]), [np.array(starts)]
    size = max(picture.problem.programme.lift * (float(design.arm_length[0]) if angular else 1.0), 2 * radius)
    if angular:
        pivot = follower_pivot(picture.problem)
        for each in starts:
            draw_arm(follower_axes, pivot, each, 1.5 * size)
        spans.append(pivot + 0.1 * size * np.array([-1, 1]))
    else:
        reach = start - (radius + 0.25 * size) - 1j * picture.start_displacement
        ends = reach + 1j * picture.problem.programme.lift * np.array([0.0, 1.0])
        draw_line(follower_axes.ground, ends, color=MUTED, lw=1.0, marker="_", ms=8)
        style = {"rotation": 90, "ha": "right", "va": "center", "fontsize": SMALL_SIZE, "color": MUTED}
        follower_axes.ground.annotate(
            "travel", (reach.real, ends.imag.mean()), (-4, 0), textcoords="offset points", **style
        )
        spans.append(np.array([reach - 0.3 * size]))
        draw_line(axes, starts, color=INK, lw=1.6, alpha=0.5, zorder=5.5)
        if picture.problem.setup.train is not None:
            mean_radius, top = float(design.size[0]), drawn_cylinder_ends(picture)[1]
            half, end = STEM_WIDTH * mean_radius / 2, start.real + 1j * (top + STEM_OVERRUN * mean_radius)
            spans.append(np.array([start - half, end - half, end + half, start + half]))
            fill_area(axes, spans[-1], facecolor=BODY, edgecolor=INK, lw=1.1, zorder=5)
    turn = np.exp(1j * np.linspace(0.0, 2 * np.pi, 181))
    for each in starts:
        if radius > 0.0:
            fill_area(axes, each + radius * turn, facecolor=BODY, edgecolor=INK, lw=1.3, zorder=6)
            spans.append(each + radius * turn)
        draw_line(axes, [each], marker="o", ms=3, color=INK, zorder=6.5)
    return spans
