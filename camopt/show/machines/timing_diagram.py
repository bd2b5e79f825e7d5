"""The rows of a timing diagram: segments and lift of each station, clearances and torque over a turn of the shaft.

All lengths are mm on the paper. The axes have the size of the paper, so that a row is as high in every picture.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.model.motion.stroke import RETURN, RISE
from camopt.show.drawing.labels import Label, label_place_candidates, place_labels
from camopt.show.drawing.picture import four_digits, round_length, value_with_unit
from camopt.show.drawing.style import (
    ALARM,
    COLOURS,
    FAINT,
    FILL,
    INK,
    MUTED,
    PALE_ALARM,
    REFERENCE_COLOUR,
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
    curve_points,
    labelled_changes,
)
from camopt.show.sheet.marks import CAPITAL_HEIGHT, POINTS_PER_MM, MarkBox, fitted_words, text_width, wrap_text

NAMES_WIDTH, AXIS_WIDTH, ROOM = 58.0, 15.0, 1.5  # mm: column of names, of numbers at curves, and around texts
END_WIDTH, READING_WIDTH = 4.0, 22.0  # mm right of the curves, without and with a cursor's reading
SCALE_HEIGHT, TIME_HEIGHT = 6.0, 6.0  # mm of a scale of angles, and of times
BAR_HEIGHT, CLEARANCE_HEIGHT, GAP = 4.0, 5.6, 2.0  # mm
TOP_ROOM, LEAST_CURVE = 1.6, 2.0  # mm: above a curve, and its least height beside numbers on several levels
LEAST_TORQUE, MOST_TORQUE, TORQUE_ROWS = 26.0, 80.0, 2.4  # mm, and height over that of a station
MOST_CLEARANCES = 12  # drawn; a note counts the others
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
    CLEARANCE: {"fc": PALE_ALARM, "ec": ALARM},
}
"""Colours of a bar by the name of its span."""


def draw_words(axes: Any, x: float, y: float, text: str, height: float = TEXT, **style: Any) -> Any:
    """Draw a text with capitals of a height [mm]."""
    return axes.text(x, y, text, fontsize=height / CAPITAL_HEIGHT * POINTS_PER_MM, **{"color": INK, **style})


def fill_bar(axes: Any, x: float, low: float, width: float, height: float, name: str) -> None:
    """Draw the bar of a span with a name from its lower left corner."""
    style = {"lw": 0.8, "zorder": 2, "joinstyle": "miter", **BAR_STYLES[name]}
    axes.fill([x, x + width, x + width, x], [low, low, low + height, low + height], **style)


class Row(NamedTuple):
    """A row of the diagram [mm]."""

    low: float
    high: float

    @property
    def height(self) -> float:
        return self.high - self.low


DetailLine = tuple[str, dict[str, Any]]
"""A text below a name, and the style of the line that it describes; empty without a line."""


class ChangeLabel(NamedTuple):
    """The number of an angle at which segments change, above the bar."""

    x: float
    level: int
    text: str


@dataclass(frozen=True, eq=False)
class TimingDiagram:
    """The timing diagram of a machine within a box [mm]."""

    data: TimingData
    box: MarkBox
    has_readings: bool = False
    """Whether there is room for a cursor's reading at the right."""

    @property
    def left(self) -> float:
        """The place of 0°."""
        return self.box.low.real + NAMES_WIDTH + AXIS_WIDTH

    @property
    def right(self) -> float:
        """The place of 360°."""
        return self.box.high.real - (READING_WIDTH if self.has_readings else END_WIDTH)

    def x(self, angle: Any) -> Any:
        """The place of an angle [deg]."""
        return self.left + (self.right - self.left) * angle / 360.0

    @property
    def clearances(self) -> Sequence[tuple[str, Span]]:
        """The clearances that are drawn."""
        return self.data.clearances[:MOST_CLEARANCES]

    @cached_property
    def bottom(self) -> float:
        """The level of the lower scale of angles."""
        return self.box.low.imag + SCALE_HEIGHT + (TIME_HEIGHT if self.data.seconds else 0.0)

    @cached_property
    def top(self) -> float:
        """The level of the upper scale of angles."""
        return self.box.high.imag - SCALE_HEIGHT

    @cached_property
    def torque_row(self) -> Row | None:
        """The row of the torque; None without any."""
        if self.data.total_torque is None:
            return None
        each = self._rows_height / (len(self.data.stations) + TORQUE_ROWS)
        return Row(self.bottom, self.bottom + min(max(TORQUE_ROWS * each, LEAST_TORQUE), MOST_TORQUE))

    @property
    def _rows_height(self) -> float:
        """The height of all rows of stations and of the torque."""
        shown = len(self.clearances)
        return self.top - self.bottom - (shown * CLEARANCE_HEIGHT + GAP if shown else 0.0)

    @cached_property
    def clearance_rows(self) -> list[Row]:
        """The rows of the clearances, from the top."""
        low = self.torque_row.high if self.torque_row else self.bottom
        ends = low + CLEARANCE_HEIGHT * np.arange(len(self.clearances) + 1)[::-1] + GAP / 2
        return [Row(float(a), float(b)) for b, a in pairwise(ends)]

    @cached_property
    def station_rows(self) -> list[Row]:
        """The rows of the stations, from the top."""
        low = self.torque_row.high if self.torque_row else self.bottom
        low += len(self.clearances) * CLEARANCE_HEIGHT + GAP if self.clearances else 0.0
        ends = np.linspace(self.top, low, len(self.data.stations) + 1)
        return [Row(float(a), float(b)) for b, a in pairwise(ends)]

    @cached_property
    def row_height(self) -> float:
        """The height of the row of a station."""
        return self.station_rows[0].height

    @property
    def bar_height(self) -> float:
        """The height of the bars of segments."""
        return min(max(0.2 * self.row_height, 3.0), BAR_HEIGHT)

    @property
    def bar_text(self) -> float:
        """The height of texts in and above bars."""
        return min(max(0.11 * self.row_height, 1.55), SMALL_TEXT)

    @cached_property
    def changes(self) -> list[list[float]]:
        """The angles at which the segments of each station change [deg]."""
        return [labelled_changes(spans) for spans in self.data.spans]

    @cached_property
    def change_labels(self) -> list[list[ChangeLabel]]:
        """The angles at changes of each station's segments, on levels so that none overlap."""
        room = self.row_height - self.bar_height - ROOM - TOP_ROOM - LEAST_CURVE
        levels = min(max(1, int(room / (LINE_STEP * self.bar_text))), MOST_LEVELS)
        return [self._labels_on_levels(changes, levels) for changes in self.changes]

    def _labels_on_levels(self, angles: Iterable[float], levels: int) -> list[ChangeLabel]:
        """Numbers of angles, each on the lowest level with room; numbers without room are left out."""
        ends, labels = [-np.inf] * levels, list[ChangeLabel]()
        for angle in angles:
            text = angle_text(angle)
            half = text_width(text, self.bar_text) / 2
            x = float(np.clip(self.x(angle), self.left + half + LABEL_GAP, self.right - half - LABEL_GAP))
            level = next((k for k, end in enumerate(ends) if x - half >= end + LABEL_GAP), None)
            if level is not None:
                ends[level] = x + half
                labels.append(ChangeLabel(x, level, text))
        return labels

    def curve_room(self, number: int) -> tuple[float, float]:
        """The levels of lift 0 and of the largest lift in the row of a station."""
        row = self.station_rows[number]
        levels = 1 + max((label.level for label in self.change_labels[number]), default=0)
        low = row.low + ROOM / 2 + self.bar_height + levels * LINE_STEP * self.bar_text + 0.5
        return low, max(row.high - TOP_ROOM, low + 0.5)

    def lift_levels(self, number: int, lift: FloatArray) -> FloatArray:
        """The levels of lifts of a station."""
        low, high = self.curve_room(number)
        largest = self.data.stations[number].lift.largest().value
        return low + (high - low) * lift / largest if largest > 0.0 else np.full_like(lift, low)

    def draw(self, axes: Any) -> None:
        """Draw the diagram on axes in mm."""
        self._draw_scales(axes)
        for number, row in enumerate(self.station_rows):
            self._draw_station(axes, number, row)
        for row, (title, span) in zip(self.clearance_rows, self.clearances, strict=True):
            self._draw_clearance(axes, row, title, span)
        if self.torque_row and self.data.total_torque:
            self._draw_torques(axes, self.torque_row, self.data.total_torque)
        box = self.box.low.real, self.box.high.real
        rows = [*self.station_rows, *([self.torque_row] if self.torque_row else [])]
        for level in {self.top, self.bottom, *(row.low for row in rows), *(row.high for row in rows)}:
            axes.plot(box, [level, level], color=MUTED, lw=0.6, zorder=3)
        for x in (self.left, self.right):
            axes.plot([x, x], [self.bottom, self.top], color=MUTED, lw=0.6, zorder=3)

    def _draw_scales(self, axes: Any) -> None:
        """Scales of angles above and below, lines between them, and the scale of times."""
        for angle in range(0, 361, DEGREES_PER_TICK):
            x, labelled = self.x(angle), angle % DEGREES_PER_LINE == 0
            for level, away in ((self.top, 1.0), (self.bottom, -1.0)):
                tick = 1.8 if labelled else 1.0
                axes.plot([x, x], [level, level + away * tick], color=MUTED, lw=0.6 if labelled else 0.4)
                if labelled:
                    style = {"ha": "center", "va": "bottom" if away > 0.0 else "top"}
                    draw_words(axes, x, level + away * 2.3, f"{angle}°", TEXT, **style)
            if labelled:
                axes.plot([x, x], [self.bottom, self.top], color=FAINT, lw=0.5, zorder=0.5)
        column = self.box.low.real + ROOM
        for level, va in ((self.top + 2.3, "bottom"), (self.bottom - 2.3, "top")):
            draw_words(axes, column, level, "angle of the shaft", TEXT, color=MUTED, va=va)
        if seconds := self.data.seconds:
            factor, unit = (1.0, "s") if seconds >= 0.5 else (1e3, "ms")
            step = round_length(seconds * factor / MOST_TIMES * 2.0)
            low = self.bottom - SCALE_HEIGHT
            draw_words(axes, column, low - 2.3, f"time [{unit}]", TEXT, color=MUTED, va="top")
            axes.plot([self.left, self.right], [low, low], color=MUTED, lw=0.6)
            for time in step * np.arange(int(seconds * factor / step + 1e-9) + 1):
                x = self.x(360.0 * time / (seconds * factor))
                axes.plot([x, x], [low, low - 1.8], color=MUTED, lw=0.6)
                draw_words(axes, x, low - 2.3, f"{time:.6g}", TEXT, ha="center", va="top")

    def _draw_name(
        self,
        axes: Any,
        row: Row,
        name: str,
        lines: Sequence[tuple[str, dict[str, Any]]] = (),
        *,
        wide: bool = False,
    ) -> None:
        """Draw a name in full, and below it lines of details, with samples of the lines that they describe.

        A ``wide`` name is not bold and may reach to the curves.
        """
        below = len(lines) * LINE_STEP * SMALL_TEXT
        width = NAMES_WIDTH + AXIS_WIDTH - 2 * ROOM if wide else (NAMES_WIDTH - 2 * ROOM) / BOLD_WIDTH
        pad = ROOM / 3 if wide else ROOM
        room = row.height - 2 * pad - below
        fitting = (
            (wrapped, height)
            for height in NAME_TEXTS
            if len(wrapped := wrap_text(name, width, height)) * height * LINE_STEP <= room + 0.6 * height
        )
        most = max(1, int(room / (NAME_TEXTS[-1] * LINE_STEP)))
        wrapped, height = next(fitting, None) or fitted_words(name, width, most, NAME_TEXTS[-1:])
        x, level = self.box.low.real + ROOM, row.high - ROOM
        for text in wrapped:
            draw_words(
                axes, x, level - height, text, height, fontweight="normal" if wide else "bold", va="baseline"
            )
            level -= LINE_STEP * height
        for text, style in lines:
            level -= SMALL_TEXT
            if style:
                axes.plot([x, x + SWATCH], [level + SMALL_TEXT / 2] * 2, **style)
            at = x + (SWATCH + ROOM if style else 0.0)
            draw_words(axes, at, level, text, SMALL_TEXT, color=MUTED, va="baseline")
            level -= (LINE_STEP - 1.0) * SMALL_TEXT

    def _draw_station(self, axes: Any, number: int, row: Row) -> None:
        station, torque = self.data.stations[number], self.data.torques[number]
        details: list[DetailLine] = []
        if station.station.phase or station.station.ratio > 1:
            turns = f", {station.station.ratio} turns" if station.station.ratio > 1 else ""
            details.append((f"phase {angle_text(station.station.phase)}°{turns}", {}))
        if torque is not None:
            details.append((f"torque {torque.peak_words}", {**series_line_style(number), "lw": 1.4}))
        self._draw_name(axes, row, station.name, details)
        spans, (low, high) = self.data.spans[number], self.curve_room(number)
        for span in spans:
            self._draw_bar(axes, row.low + ROOM / 2, span)
        for angle in self.changes[number]:
            axes.plot([self.x(angle)] * 2, [low, high], color=MUTED, lw=0.4, ls=(0, (2, 2)), zorder=1)
        for label in self.change_labels[number]:
            foot = row.low + ROOM / 2 + self.bar_height + 0.9 + label.level * LINE_STEP * self.bar_text
            draw_words(axes, label.x, foot, label.text, self.bar_text, ha="center", va="baseline", zorder=4)
        angles, lift = curve_points(station.lift)
        levels_of_lift = self.lift_levels(number, lift)
        axes.fill_between(self.x(angles), low, levels_of_lift, color=FILL, lw=0, zorder=0.4)
        axes.plot([self.left, self.right], [low, low], color=MUTED, lw=0.5, zorder=2)
        axes.plot(self.x(angles), levels_of_lift, color=INK, lw=1.2, zorder=3, solid_joinstyle="round")
        style = {"ha": "right", "color": MUTED}
        largest = value_with_unit(station.lift.largest().value, station.unit)
        draw_words(axes, self.left - ROOM, row.high - 1.0, largest, TEXT, va="top", **style)
        if high - low > 2.4 * TEXT:
            draw_words(axes, self.left - ROOM, low, "0", TEXT, va="center", **style)

    def _draw_bar(self, axes: Any, low: float, span: Span) -> None:
        """Draw the bar of a segment with the longest text that fits in each part."""
        height, angle = self.bar_text, f"{angle_text(span.end - span.start)}°"
        texts = [f"{span.name} {angle}  {span.words}".strip(), f"{span.name} {angle}", angle]
        for start, end in span.parts:
            x, width = self.x(start), self.x(end) - self.x(start)
            fill_bar(axes, x, low, width, self.bar_height, span.name)
            text = next((text for text in texts if text_width(text, height) < width - 2 * LABEL_GAP), "")
            foot = low + (self.bar_height - height) / 2
            draw_words(axes, x + width / 2, foot, text, height, ha="center", va="baseline", zorder=4)

    def _draw_clearance(self, axes: Any, row: Row, title: str, span: Span) -> None:
        self._draw_name(axes, row, title, wide=True)
        low = row.low + (row.height - BAR_HEIGHT) / 2
        for start, end in span.parts:
            fill_bar(axes, self.x(start), low, self.x(end) - self.x(start), BAR_HEIGHT, CLEARANCE)
        start, end = max(span.parts, key=lambda part: part[1] - part[0])
        whole = span.end - span.start >= 360.0
        angles = "whole turn" if whole else f"{angle_text(span.start)}° to {angle_text(span.end_in_turn)}°"
        text = f"{angles}  {span.words}"
        wide, x, ha = text_width(text, SMALL_TEXT) + 2 * ROOM, self.x((start + end) / 2), "center"
        if wide > self.x(end) - self.x(start):
            right = self.x(end) + wide < self.right
            x, ha = (self.x(end) + ROOM, "left") if right else (self.x(start) - ROOM, "right")
        middle = low + (BAR_HEIGHT - SMALL_TEXT) / 2
        draw_words(axes, x, middle, text, SMALL_TEXT, ha=ha, va="baseline", zorder=4)

    def _draw_torques(self, axes: Any, row: Row, total: Torque) -> None:
        """Draw the torque of the shaft, its mean and peak, and the torque of each station."""
        curve, unit = total.curve, total.unit
        curves = [curve, *(torque.curve for torque in self.data.torques if torque is not None)]
        least = min(0.0, *(each.least().value for each in curves))
        most = max(0.0, *(each.largest().value for each in curves))
        if most == least:
            most = 1.0
        low, high = row.low + 2 * ROOM, row.high - 2 * ROOM
        scale = (high - low) / (most - least)

        def level(value: Any) -> Any:
            return low + scale * (value - least)

        mean = f"mean {four_digits(curve.mean)} {unit}, rms {four_digits(curve.rms)} {unit}"
        lines = [(f"sum: {total.peak_words}", {"color": INK, "lw": 1.6}), (mean, MEAN_STYLE)]
        self._draw_name(axes, row, f"Shaft torque [{unit}]", lines)
        step = round_length((most - least) * max(3.5 * TEXT / (high - low), 0.15) * 2.0)
        for place in range(int(np.ceil(least / step - 1e-9)), int(most / step + 1e-9) + 1):
            at = level(place * step)
            axes.plot([self.left, self.right], [at, at], color=MUTED if place == 0 else FAINT, lw=0.5, zorder=0.6)
            text = four_digits(place * step)
            draw_words(axes, self.left - ROOM, at, text, TEXT, ha="right", va="center", color=MUTED)
        for number, torque in enumerate(self.data.torques):
            if torque is not None:
                angles, values = curve_points(torque.curve)
                axes.plot(self.x(angles), level(values), lw=0.9, zorder=2, **series_line_style(number))
                self._draw_peak(axes, torque, level, ms=2.6, color=series_line_style(number)["color"])
        angles, values = curve_points(curve)
        axes.plot(self.x(angles), level(values), color=INK, lw=1.6, zorder=3)
        axes.plot([self.left, self.right], [level(curve.mean)] * 2, zorder=2.5, **MEAN_STYLE)
        self._draw_peak(axes, total, level, ms=4.5, color=INK)
        peak = self.x(np.degrees(total.peak.angle)), level(total.peak.value)
        style = {"fontsize": TEXT / CAPITAL_HEIGHT * POINTS_PER_MM, "color": INK, "fontweight": "bold"}
        places = label_place_candidates((6.0, 10.0, 16.0), np.pi)
        label = Label(axes, total.peak_words, peak, places, {**style, **WHITE_BACKGROUND}, thinnest=0.55)
        place_labels(axes.figure, [label])

    def _draw_peak(self, axes: Any, torque: Torque, level: Any, **style: Any) -> None:
        x = self.x(np.degrees(torque.peak.angle))
        axes.plot([x], [level(torque.peak.value)], marker="o", mec="white", mew=0.5, zorder=5, **style)


MEAN_STYLE: dict[str, Any] = {"color": INK, "lw": 0.9, "ls": (0, (6, 3))}
"""Style of the line of the mean torque."""
