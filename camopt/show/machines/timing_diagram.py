"""The rows of a timing diagram: segments and lift of each station, clearances and torque over a turn of the shaft.

All lengths are mm on the paper. The axes have the size of the paper, so that a row is as high in every picture.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, Number
from camopt.model.motion.stroke import RETURN, RISE
from camopt.show.drawing.labels import Label, label_place_candidates, place_labels
from camopt.show.drawing.picture import four_digit_text, round_down_to_1_2_5, value_with_unit
from camopt.show.drawing.style import (
    ALARM,
    COLOURS,
    FAINT,
    FILL,
    INK,
    MUTED,
    PALE_ALARM,
    PITCH_COLOUR,
    REFERENCE_COLOUR,
    SECOND_COLOUR,
    WHITE_BACKGROUND,
    series_line_style,
)
from camopt.show.machines.timing_spans import (
    CLEARANCE,
    MOVE,
    Span,
    TimingData,
    Torque,
    angle_text,
    curve_angles_deg_and_values,
    phase_and_ratio_text,
)
from camopt.show.sheet.marks import CAPITAL_HEIGHT, POINTS_PER_MM, MarkBox, fitted_lines_and_height, text_width
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED

NAMES_WIDTH, AXIS_WIDTH, ROOM = 58.0, 15.0, 1.5  # mm: column of names, of numbers at curves, and around texts
END_WIDTH, READING_WIDTH = 4.0, 22.0  # mm right of the curves, without and with a cursor's reading
SCALE_HEIGHT, TIME_HEIGHT = 6.0, 6.0  # mm of a scale of angles, and of times
BAR_HEIGHT, CLEARANCE_HEIGHT, GAP = 4.0, 5.6, 2.0  # mm
TOP_ROOM, LEAST_CURVE = 1.6, 1.6  # mm: above a curve, and its least height beside numbers on several levels
LEAST_TORQUE, MOST_TORQUE, TORQUE_ROWS = 26.0, 80.0, 2.4  # mm, and height over that of a station
TEXT, SMALL_TEXT, NAME_TEXTS = 1.9, 1.7, (2.6, 2.3, 2.0, 1.7, 1.5)  # mm: heights of capitals
SWATCH, BOLD_WIDTH = 5.0, 1.14  # mm; width of bold letters over that of others
LINE_STEP, MOST_LEVELS, LABEL_GAP = 1.6, 4, 0.7  # in heights of letters; levels of angles; mm between angles
DEGREES_PER_LINE, DEGREES_PER_TICK = 30, 10
MOST_TIMES = 12  # numbers of the scale of times

BAR_STYLES: dict[str, dict[str, Any]] = {
    "rise": {"fc": "#b9d6ec", "ec": COLOURS[RISE]},
    "return": {"fc": "#f2cbab", "ec": COLOURS[RETURN]},
    "dwell": {"fc": FILL, "ec": FAINT},
    MOVE: {"fc": "#d9d1e6", "ec": REFERENCE_COLOUR},
    CLEARANCE: {"fc": "#f3e9cf", "ec": SECOND_COLOUR},
    f"{CLEARANCE} {HELD}": {"fc": "#d5e8dc", "ec": PITCH_COLOUR},
    f"{CLEARANCE} {UNDECIDED}": {"fc": "#f3e9cf", "ec": SECOND_COLOUR},
    f"{CLEARANCE} {BROKEN}": {"fc": PALE_ALARM, "ec": ALARM},
}
"""Colours of a bar by the name of its span."""


def draw_words(axes: Any, x: float, y: float, text: str, height: float = TEXT, **style: Any) -> Any:
    """Draw a text with capitals of a height [mm]."""
    size = height / CAPITAL_HEIGHT * POINTS_PER_MM
    return axes.text(x, y, text, fontsize=size, **{"color": INK, "va": "baseline", **style})


def fill_bar(axes: Any, x: float, low: float, width: float, height: float, span_name: str) -> None:
    """Draw the bar of a span with a name from its lower left corner."""
    style = {"lw": 0.8, "zorder": 2, "joinstyle": "miter", **BAR_STYLES[span_name]}
    axes.fill([x, x + width, x + width, x], [low, low, low + height, low + height], **style)


class Row(NamedTuple):
    """A row of the diagram [mm]."""

    low: float
    high: float


def equal_rows(top: float, bottom: float, count: int) -> list[Row]:
    """Rows of equal height, from the top."""
    return [Row(float(low), float(high)) for high, low in pairwise(np.linspace(top, bottom, count + 1))]


DetailLine = tuple[str, dict[str, Any]]
"""A text below a name, and the style of the line that it describes; empty without a line."""


@dataclass(frozen=True, eq=False)
class TimingDiagram:
    """The timing diagram of a machine within a box [mm]."""

    data: TimingData
    box: MarkBox
    end_width: float = END_WIDTH
    """Room right of the curves."""

    @property
    def left(self) -> float:
        """The place of 0°."""
        return self.box.low.real + NAMES_WIDTH + AXIS_WIDTH

    @property
    def right(self) -> float:
        """The place of 360°."""
        return self.box.high.real - self.end_width

    @property
    def bottom(self) -> float:
        """The level of the lower scale of angles."""
        return self.box.low.imag + SCALE_HEIGHT + (TIME_HEIGHT if self.data.seconds_per_turn else 0.0)

    @property
    def top(self) -> float:
        """The level of the upper scale of angles."""
        return self.box.high.imag - SCALE_HEIGHT

    def x(self, angle: Number) -> Number:
        """The place of an angle [deg]."""
        return self.left + (self.right - self.left) * angle / 360.0

    @cached_property
    def station_clearance_and_torque_rows(self) -> tuple[list[Row], list[Row], Row]:
        """The rows of the stations and of the clearances, from the top, and the row of the torque."""
        stations, shown = len(self.data.stations), len(self.data.clearances)
        clearances = shown * CLEARANCE_HEIGHT + (GAP if shown else 0.0)
        room, torque = self.top - self.bottom - clearances, self.bottom
        if self.data.total_torque:
            torque += min(max(room * TORQUE_ROWS / (stations + TORQUE_ROWS), LEAST_TORQUE), MOST_TORQUE)
        middle = torque + clearances
        return (
            equal_rows(self.top, middle, stations),
            equal_rows(middle - GAP / 2, torque + GAP / 2, shown),
            Row(self.bottom, torque),
        )

    @cached_property
    def bar_and_text_heights(self) -> tuple[float, float]:
        """The heights of the bars of segments, and of the texts in and above them."""
        low, high = self.station_clearance_and_torque_rows[0][0]
        return float(np.clip(0.2 * (high - low), 3.0, BAR_HEIGHT)), float(
            np.clip(0.11 * (high - low), 1.55, SMALL_TEXT)
        )

    @cached_property
    def change_labels(self) -> list[list[tuple[float, int, str]]]:
        """Place, level and text of the angles at which each station's segments change.

        No texts overlap, since each is on the lowest level with room. Texts without room are left out.
        """
        (low, high), (bar, text_height) = self.station_clearance_and_torque_rows[0][0], self.bar_and_text_heights
        room = high - low - bar - ROOM - TOP_ROOM - LEAST_CURVE
        levels = min(max(1, int(room / (LINE_STEP * text_height))), MOST_LEVELS)
        labels = []
        for spans in self.data.spans:
            ends = [-np.inf] * levels
            labels.append(list[tuple[float, int, str]]())
            for span in spans:
                half = text_width(text := angle_text(span.start), text_height) / 2 + LABEL_GAP
                x = float(np.clip(self.x(span.start), self.left + half, self.right - half))
                if (level := next((k for k, end in enumerate(ends) if x - half >= end), None)) is not None:
                    ends[level] = x + half - LABEL_GAP
                    labels[-1].append((x, level, text))
        return labels

    def lift_curve_levels(self, station_index: int) -> Row:
        """The levels of lift 0 and of the largest lift in the row of a station."""
        (low, high), (bar, text) = (
            self.station_clearance_and_torque_rows[0][station_index],
            self.bar_and_text_heights,
        )
        levels = 1 + max(level for _, level, _ in self.change_labels[station_index])
        low += ROOM / 2 + bar + levels * LINE_STEP * text + 0.5
        return Row(low, max(high - TOP_ROOM, low + 0.5))

    def lift_levels(self, station_index: int, lift: FloatArray) -> FloatArray:
        """The levels of lifts of a station."""
        low, high = self.lift_curve_levels(station_index)
        return low + (high - low) * lift / (self.data.stations[station_index].lift.largest().value or 1.0)

    def draw(self, axes: Any) -> None:
        """Draw the diagram on axes in mm."""
        stations, clearances, torque = self.station_clearance_and_torque_rows
        self._draw_scales(axes)
        for number, row in enumerate(stations):
            self._draw_station(axes, number, row)
        for row, (title, span) in zip(clearances, self.data.clearances, strict=True):
            self._draw_clearance(axes, row, title, span)
        if self.data.total_torque:
            self._draw_torques(axes, torque, self.data.total_torque)
        levels = sorted({self.top, self.bottom, torque.high, *(row.low for row in stations)})
        axes.hlines(levels, self.box.low.real, self.box.high.real, color=MUTED, lw=0.6, zorder=3)
        axes.vlines([self.left, self.right], self.bottom, self.top, color=MUTED, lw=0.6, zorder=3)

    def _draw_scales(self, axes: Any) -> None:
        """Scales of angles above and below, lines between them, and the scale of times."""
        angles, ticks = np.arange(0, 361, DEGREES_PER_LINE), np.arange(0, 361, DEGREES_PER_TICK)
        axes.vlines(self.x(angles), self.bottom, self.top, color=FAINT, lw=0.5, zorder=0.5)
        name, style = self.box.low.real + ROOM, dict[str, Any](ha="center")
        for level, away, va in ((self.top, 1.0, "bottom"), (self.bottom, -1.0, "top")):
            axes.vlines(self.x(ticks), level, level + away, color=MUTED, lw=0.4)
            axes.vlines(self.x(angles), level, level + 1.8 * away, color=MUTED, lw=0.6)
            draw_words(axes, name, level + 2.3 * away, "angle of the shaft", color=MUTED, va=va)
            for angle in angles:
                draw_words(axes, self.x(angle), level + 2.3 * away, f"{angle}°", va=va, **style)
        if self.data.seconds_per_turn:
            factor, unit = (1.0, "s") if self.data.seconds_per_turn >= 0.5 else (1e3, "ms")
            whole, low = self.data.seconds_per_turn * factor, self.bottom - SCALE_HEIGHT
            step = round_down_to_1_2_5(2.0 * whole / MOST_TIMES)
            times = step * np.arange(int(whole / step + 1e-9) + 1)
            axes.hlines(low, self.left, self.right, color=MUTED, lw=0.6)
            axes.vlines(self.x(360.0 * times / whole), low - 1.8, low, color=MUTED, lw=0.6)
            draw_words(axes, name, low - 2.3, f"time [{unit}]", color=MUTED, va="top")
            for time in times:
                draw_words(axes, self.x(360.0 * time / whole), low - 2.3, f"{time:.6g}", va="top", **style)

    def _draw_row_name(
        self, axes: Any, row: Row, name: str, detail_lines: Sequence[DetailLine] = (), *, wide: bool = False
    ) -> None:
        """Draw a name in the largest letters that fit, and lines of details with samples of what they describe.

        A ``wide`` name is not bold and may reach to the curves.
        """
        width = NAMES_WIDTH + AXIS_WIDTH - 2 * ROOM if wide else (NAMES_WIDTH - 2 * ROOM) / BOLD_WIDTH
        room = row.high - row.low - (ROOM if wide else 2 * ROOM) - len(detail_lines) * LINE_STEP * SMALL_TEXT
        for height in NAME_TEXTS:
            most = max(1, int((room + (LINE_STEP - 1.0) * height) / (LINE_STEP * height)))
            texts, _ = fitted_lines_and_height(name, width, most, (height,))
            if not texts[-1].endswith("…"):
                break
        used = (len(texts) * LINE_STEP - LINE_STEP + 1.0) * height
        x, level = self.box.low.real + ROOM, row.high - ((row.high - row.low - used) / 2 if wide else ROOM)
        for text in texts:
            draw_words(axes, x, level - height, text, height, fontweight="normal" if wide else "bold")
            level -= LINE_STEP * height
        for text, style in detail_lines:
            level -= SMALL_TEXT
            axes.plot([x, x + SWATCH] if style else [], [level + SMALL_TEXT / 2] * 2 if style else [], **style)
            draw_words(axes, x + (SWATCH + ROOM if style else 0.0), level, text, SMALL_TEXT, color=MUTED)
            level -= (LINE_STEP - 1.0) * SMALL_TEXT

    def _draw_station(self, axes: Any, station_index: int, row: Row) -> None:
        station, torque = self.data.stations[station_index], self.data.torques[station_index]
        line = {**series_line_style(station_index), "lw": 1.4}
        details: list[DetailLine] = [
            (phase_and_ratio_text(station), {}),
            *([(f"torque {torque.peak_words}", line)] if torque is not None else []),
        ]
        self._draw_row_name(axes, row, station.name, details)
        spans, (low, high), (bar, height) = (
            self.data.spans[station_index],
            self.lift_curve_levels(station_index),
            self.bar_and_text_heights,
        )
        foot = row.low + ROOM / 2
        for span in spans:
            angle = f"{angle_text(span.end - span.start)}°"
            texts = [f"{span.name} {angle}  {span.words}".strip(), f"{span.name} {angle}", angle, ""]
            for start, end in span.ranges_within_turn:
                x, width = self.x(start), self.x(end) - self.x(start)
                fill_bar(axes, x, foot, width, bar, span.name)
                text = next(text for text in texts if not text or text_width(text, height) < width - 2 * LABEL_GAP)
                draw_words(axes, x + width / 2, foot + (bar - height) / 2, text, height, ha="center", zorder=4)
        changes = [self.x(span.start) for span in spans]
        axes.vlines(changes, low, high, color=MUTED, lw=0.4, ls=(0, (2, 2)), zorder=1)
        for x, level, text in self.change_labels[station_index]:
            draw_words(axes, x, foot + bar + 0.9 + level * LINE_STEP * height, text, height, ha="center", zorder=4)
        angles, lift = curve_angles_deg_and_values(station.lift)
        levels = self.lift_levels(station_index, lift)
        axes.fill_between(self.x(angles), low, levels, color=FILL, lw=0, zorder=0.4)
        axes.hlines(low, self.left, self.right, color=MUTED, lw=0.5, zorder=2)
        axes.plot(self.x(angles), levels, color=INK, lw=1.2, zorder=3, solid_joinstyle="round")
        largest = value_with_unit(station.lift.largest().value, station.unit)
        draw_words(axes, self.left - ROOM, row.high - 1.0, largest, va="top", ha="right", color=MUTED)
        if high - low > 2.4 * TEXT:
            draw_words(axes, self.left - ROOM, low, "0", va="center", ha="right", color=MUTED)

    def _draw_clearance(self, axes: Any, row: Row, title: str, span: Span) -> None:
        """Draw the range of a clearance, with its condition in the bar or beside it."""
        self._draw_row_name(axes, row, title, wide=True)
        low = row.low + (row.high - row.low - BAR_HEIGHT) / 2
        for start, end in span.ranges_within_turn:
            fill_bar(axes, self.x(start), low, self.x(end) - self.x(start), BAR_HEIGHT, span.name)
        first, last = (self.x(angle) for angle in max(span.ranges_within_turn, key=lambda part: part[1] - part[0]))
        angles = f"{angle_text(span.start)}° to {angle_text(span.end % 360.0 or 360.0)}°"
        angles = "whole turn" if span.end - span.start >= 360.0 else angles
        condition, _, least = span.words.partition(", ")
        texts = [f"{angles}  {span.words}", f"{angles}  {condition}", least or condition]
        for text, place in product(texts, ("center", "left", "right")):
            room = {"center": last - first, "left": self.right - last, "right": first - self.left}[place]
            if text_width(text, SMALL_TEXT) + 2 * ROOM < room:
                break
        x = {"center": (first + last) / 2, "left": last + ROOM, "right": first - ROOM}[place]
        draw_words(axes, x, low + (BAR_HEIGHT - SMALL_TEXT) / 2, text, SMALL_TEXT, ha=place, zorder=4)

    def _draw_torques(self, axes: Any, row: Row, total: Torque) -> None:
        """Draw the torque of the shaft, its mean and peak, and the torque of each station."""
        curve, unit = total.curve, total.unit
        mean = f"mean {four_digit_text(curve.mean)} {unit}, rms {four_digit_text(curve.rms)} {unit}"
        lines = [(f"sum: {total.peak_words}", {"color": INK, "lw": 1.6}), (mean, MEAN_STYLE)]
        self._draw_row_name(axes, row, f"Shaft torque [{unit}]", lines)
        curves = [each.curve for each in (total, *self.data.torques) if each]
        least = min(0.0, *(each.least().value for each in curves))
        most = max(0.0, *(each.largest().value for each in curves)) or least + 1.0
        low, height = row.low + 2.5 * ROOM, row.high - row.low - 5.5 * ROOM

        def level(value: Number) -> Number:
            return low + height * (value - least) / (most - least)

        step = round_down_to_1_2_5((most - least) * max(7.0 * TEXT / height, 0.3))
        for place in range(int(np.ceil(least / step - 1e-9)), int(most / step + 1e-9) + 1):
            at = level(place * step)
            axes.hlines(at, self.left, self.right, color=FAINT if place else MUTED, lw=0.5, zorder=0.6)
            draw_words(
                axes, self.left - ROOM, at, four_digit_text(place * step), va="center", ha="right", color=MUTED
            )
        sum_style = {"color": INK, "lw": 1.6, "ms": 4.5, "zorder": 3}
        styles = [{"lw": 0.9, "ms": 2.6, **series_line_style(k)} for k in range(len(self.data.torques))]
        for torque, style in zip((*self.data.torques, total), (*styles, sum_style), strict=True):
            if torque is not None:
                angles, values = curve_angles_deg_and_values(torque.curve)
                peak = self.x(np.degrees(torque.peak.angle)), level(torque.peak.value)
                axes.plot(self.x(angles), level(values), **style)
                axes.plot(*peak, marker="o", mec="white", mew=0.5, **{**style, "zorder": 5})
        axes.plot([self.left, self.right], [level(curve.mean)] * 2, zorder=2.5, **MEAN_STYLE)
        style = {"fontsize": TEXT / CAPITAL_HEIGHT * POINTS_PER_MM, "color": INK, "fontweight": "bold"}
        inward = 1.0 if total.peak.angle < np.pi else -1.0
        places = label_place_candidates((6.0, 10.0, 16.0), 0.0 if inward > 0.0 else np.pi)
        places = [place for place in places if place[0] * inward > -1e-6]
        label = Label(axes, total.peak_words, peak, places, {**style, **WHITE_BACKGROUND}, thinnest=0.55)
        place_labels(axes.figure, [label])


MEAN_STYLE: dict[str, Any] = {"color": INK, "lw": 0.9, "ls": (0, (6, 3))}
"""Style of the line of the mean torque."""
