"""Draws diagrams over the cam angle: shaded strokes, jumps as breaks, impulses as arrows, marked peaks."""

from collections.abc import Iterable, Sequence
from math import copysign, floor, log10, pi
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.show.drawing.labels import Label, label_place_candidates
from camopt.show.drawing.panels import NEGLIGIBLE, MarkedPeak, MoveMark, Panel, PieceValues
from camopt.show.drawing.picture import STROKE_NAMES, Picture
from camopt.show.drawing.style import (
    ALARM,
    COLOURS,
    FAINT,
    INK,
    LIMIT_STYLE,
    MUTED,
    PALE_ALARM,
    PITCH_COLOUR,
    SHADES,
    SMALL_SIZE,
    add_grid,
)

DEGREES_A_LETTER = 4.0  # deg: width of a letter above a diagram
PEAK_LABEL_DISTANCES = (3.5, 9.0, 16.0)  # points from a peak to its value
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
TITLE_GAP = 8.0  # points between the title of a diagram and its note


def draw_diagrams(
    axes: Sequence[Any],
    picture: Picture,
    panels: Sequence[Panel],
    stroke_name_indices: Iterable[int],
    angle_label_indices: Iterable[int],
) -> list[Label]:
    """Draw diagrams; return the labels to place.

    ``stroke_name_indices`` and ``angle_label_indices`` are indices of diagrams with names of strokes above and cam
    angles below.
    """
    labels = []
    for place, (each, panel) in enumerate(zip(axes, panels, strict=True)):
        labels += _draw_panel(each, picture, panel)
        if place in stroke_name_indices:
            _name_strokes(each, picture)
        if place in angle_label_indices:
            each.set_xlabel("cam angle, deg", labelpad=2)
        else:
            each.tick_params(labelbottom=False)
    return labels


def _draw_panel(axes: Any, picture: Picture, panel: Panel) -> list[Label]:
    factor, unit = short_number_factor_and_unit(panel.values, panel.unit)
    peaks = panel.peaks if factor == 1.0 else [peak.with_factor(factor) for peak in panel.peaks]
    angles = [np.degrees(piece) for piece in picture.angles_of_pieces]
    for kind, start, end in picture.stroke_kind_spans:
        axes.axvspan(*np.degrees([start, end]), color=SHADES[kind], lw=0, zorder=0)
    for low, high in panel.bands:
        axes.axhspan(low * factor, high * factor, color=FAINT, lw=0, zorder=0.5)
    add_grid(axes)
    axes.axhline(0.0, color=FAINT, lw=0.8, zorder=1)
    for angle, value in zip(angles, panel.reference or [], strict=panel.reference is not None):
        axes.plot(angle, value * factor, color=PITCH_COLOUR, lw=1.0, ls=(0, (9, 2.5, 1.5, 2.5)), zorder=2)
    for kind, angle, value in zip(
        picture.stroke_kind_of_each_piece, angles, panel.other or [], strict=panel.other is not None
    ):
        axes.plot(angle, value * factor, color=COLOURS[kind], lw=0.8, zorder=2.2)
    for kind, angle, value in zip(picture.stroke_kind_of_each_piece, angles, panel.values, strict=True):
        axes.plot(angle, value * factor, color=COLOURS[kind], lw=1.7, zorder=3, solid_capstyle="butt")
    for mark in panel.marks:
        draw_condition_mark(axes, mark, factor)
    span = _set_value_limits(axes, panel, factor)
    _draw_jumps(axes, angles, [v * factor for v in panel.values], span)
    _draw_limits(axes, picture, panel, factor)
    _draw_impulses(axes, panel)
    _draw_undercut(axes, angles, panel)
    _draw_title_and_note(axes, f"{panel.title}, {unit}" if unit else panel.title, panel.note)
    axes.set(xlim=(0, 360), xticks=range(0, 361, 30))
    return [_draw_peak(axes, peak) for peak in peaks]


def _draw_title_and_note(axes: Any, title: str, note: str) -> None:
    """Write the title of a diagram and the note beside it, which shrinks until both fit on one line."""
    renderer = axes.figure.canvas.get_renderer()
    left = axes.set_title(title, loc="left", pad=2.5)
    right = axes.set_title(note, loc="right", fontsize=SMALL_SIZE, pad=2.5, color=MUTED)
    room = axes.bbox.width - left.get_window_extent(renderer).width - TITLE_GAP * axes.figure.dpi / 72.0
    right.set_fontsize(SMALL_SIZE * min(1.0, room / max(right.get_window_extent(renderer).width, 1.0)))


def short_number_factor_and_unit(values: Sequence[FloatArray], unit: str) -> tuple[float, str]:
    """A factor for short numbers in a diagram, and the unit with its power of ten."""
    every = np.abs(np.concatenate(values))
    largest = float(np.nanmax(np.append(every[np.isfinite(every)], 0.0)))
    if largest == 0.0 or 1e-2 <= largest < 1e4:
        return 1.0, unit
    power = 3 * floor(log10(largest) / 3)
    return 10.0**-power, f"10{str(power).translate(SUPERSCRIPT)} {unit}"


def _set_value_limits(axes: Any, panel: Panel, factor: float) -> float:
    """Set the vertical limits, with room for texts at peaks; return the range of values."""
    every = np.concatenate([*panel.values, *(panel.reference or [])]) * factor
    every = every[np.isfinite(every)]
    low, high = min(every.min(initial=0.0), 0.0), max(every.max(initial=0.0), 0.0)
    if panel.span is not None:
        low, high = panel.span[0] * factor, panel.span[1] * factor
    reach = max(-low, high)
    near = [(kinds, bound * factor) for kinds, bound in panel.limits if abs(bound * factor) <= 2.5 * reach]
    below = [-n if kinds else n for kinds, n in near if low < 0.0 or not kinds]
    low, high = min([low, *below]), max([high, *(n for _, n in near)])
    if panel.impulses or high == low:
        high = max(high, -low) or 1.0
        low = -high
        axes.set_yticks([0.0]) if reach == 0.0 else None
    room = 0.26 * (high - low)
    written_below = low < 0.0 or any(peak.least for peak in panel.peaks)
    axes.set_ylim(low - (room if written_below else room / 4), high + room)
    axes.locator_params(axis="y", nbins=5) if reach else None
    return float(high - low)


def _draw_jumps(axes: Any, angles: PieceValues, values: PieceValues, value_range: float) -> None:
    """Draw a dotted line at each jump, also from the end of the turn to its start."""
    for k, value in enumerate(values):
        before, after = values[k - 1][-1], value[0]
        if abs(after - before) > NEGLIGIBLE * value_range:
            for at in {round(float(angles[k][0]), 6), round(float(angles[k - 1][-1]), 6)}:
                axes.plot([at, at], [before, after], color=MUTED, lw=0.9, ls=(0, (1, 1.6)), zorder=2.5)


def draw_condition_mark(axes: Any, mark: MoveMark, factor: float) -> None:
    """Mark a condition: a square or bar at one angle, a line or band over a range of angles."""
    low, high = mark.low * factor, mark.high * factor
    if mark.end > mark.start:
        if low == high:  # thick and pale, to be seen under a curve that follows it
            axes.plot([mark.start, mark.end], [low, low], color=INK, lw=5.0, alpha=0.3, zorder=1.5)
            return
        axes.fill_between([mark.start, mark.end], low, high, ec=INK, fc=(0.0, 0.0, 0.0, 0.08), lw=1.1, zorder=1.5)
        return
    style = {"marker": "s", "ms": 3.4, "mfc": "white", "mec": INK, "mew": 0.9}
    axes.plot([mark.start, mark.start], [low, high], color=INK, lw=1.1, zorder=4, **style)


def _draw_limits(axes: Any, picture: Picture, panel: Panel, factor: float) -> None:
    low, high = axes.get_ylim()
    for kinds, bound in panel.limits:
        level = bound * factor
        if kinds == 0 and low < level < high:
            axes.axhline(level, zorder=2, **LIMIT_STYLE)
        for kind, start, end in picture.stroke_kind_spans:
            if kind & kinds and level < high:
                axes.hlines([level, -level], *np.degrees([start, end]), zorder=2, **LIMIT_STYLE)
    shown = [f"{bound:.4g}" for _, bound in panel.limits if low < bound * factor < high]
    if shown:
        words = f"red: limit {' and '.join(dict.fromkeys(shown))} {panel.unit}".rstrip()
        panel.note = f"{panel.note}  ·  {words}" if panel.note else words


def _draw_impulses(axes: Any, panel: Panel) -> None:
    """Draw an arrow for each impulse, with a length in proportion."""
    top = axes.get_ylim()[1]
    largest = max([abs(size) for _, size in panel.impulses], default=0.0)
    style = {"arrowstyle": "-|>", "color": INK, "lw": 1.2, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 9}
    for at, size in panel.impulses:
        length = (0.35 + 0.5 * abs(size) / largest) * top * np.sign(size)
        axes.annotate("", (at, length), (at, 0.0), arrowprops=style, zorder=4, annotation_clip=False)


def _draw_undercut(axes: Any, angles: PieceValues, panel: Panel) -> None:
    """Shade the cam angles with undercut, with one text."""
    low, high = axes.get_ylim()
    style = {"fontsize": SMALL_SIZE, "color": ALARM, "ha": "center", "va": "top"}
    middles = []
    for angle, bad in zip(angles, panel.alarm or [], strict=panel.alarm is not None):
        if np.any(bad):
            axes.fill_between(angle, low, high, where=bad, color=PALE_ALARM, lw=0, zorder=0.5)
            inside = np.flatnonzero(bad)
            (ends,) = np.nonzero(np.diff(inside, append=len(bad) + 1) > 1)
            middles.append(float(np.mean(angle[inside[: ends[0] + 1]])))
    if middles:
        axes.text(min(max(middles[0], 18.0), 342.0), high - 0.04 * (high - low), "undercut", **style)


def _draw_peak(axes: Any, peak: MarkedPeak) -> Label:
    """Mark a peak; return the label with its value."""
    axes.plot([peak.angle], [peak.value], marker="o", ms=3.2, color=peak.colour, zorder=5, clip_on=False)
    style = {"fontsize": SMALL_SIZE, "color": peak.colour, "zorder": 5}
    places = label_place_candidates(PEAK_LABEL_DISTANCES, copysign(pi / 2, -1.0 if peak.least else peak.value))
    return Label(axes, peak.text, (peak.angle, peak.value), places, style)


def _name_strokes(axes: Any, picture: Picture) -> None:
    """Write name, angle and law of each stroke above a diagram, shortened if there is little room."""
    for stroke in picture.problem.programme.tool.strokes:
        start, angle = np.degrees([stroke.start, stroke.angle])
        law, size = stroke.law.NAME if stroke.law else "", f"{angle:.4g}°"
        name, law = (law, "") if stroke.is_move else (STROKE_NAMES[stroke.kind], law)
        lines = [f"{name} {size}", law]
        if len(lines[0]) * DEGREES_A_LETTER > angle:
            lines = [name, size]
        lines = [text for text in lines if text and len(text) * DEGREES_A_LETTER <= angle * 1.15]
        style = {"ha": "center", "va": "top", "fontsize": SMALL_SIZE, "color": COLOURS.get(stroke.kind, INK)}
        place = {"textcoords": "offset points", "xycoords": ("data", "axes fraction")}
        axes.annotate("\n".join(lines), (start + angle / 2, 1.0), (0, 34), **place, **style)
