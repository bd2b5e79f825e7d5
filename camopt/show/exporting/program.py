"""Programs for machines, line by line, with templates for the dialect of each control.

Sources: ISO 6983-1 and DIN 66025 (iso); the programming manuals of Fanuc (series 0i, milling), Siemens (Sinumerik
840D) and Heidenhain (TNC, conversational; M116 for feeds of rotary axes).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from camopt.core.quantities.unit_systems import INCH, MM, shown_system, to_shown_unit


@dataclass(frozen=True)
class ControlDialect:
    """Templates of lines. x, y, z: end of a move; cx, cy: its centre; i, j: the centre relative to its start."""

    start: tuple[str, ...]
    """Lines before the comments at the head."""
    modes: tuple[str, ...]
    """Modes for all moves: unit, plane XY, absolute, feed per minute, no compensation."""
    end: tuple[str, ...]
    comment: str
    units: Mapping[str, str] = field(default_factory={MM: "G21", INCH: "G20"}.copy)
    """Words for the unit of lengths."""
    rapid: str = "G0 X{x} Y{y}"
    line: str = "G1 X{x} Y{y}"
    arc: str = "G{way} X{x} Y{y} I{i} J{j}"
    ways: tuple[str, str] = ("2", "3")
    """Clockwise and anticlockwise."""
    up: str = "G0 Z{z}"
    down: str = "G1 Z{z}"
    feed: str = " F{feed}"
    """Words after a move if the feed changes."""
    tool: tuple[str, ...] = ("T{tool} M6",)
    spindle: str = "S{speed} M3"
    coolant: str = "M8"
    still: str = "M5"
    """Stop the spindle."""
    dry: str = "M9"
    """Stop the coolant."""
    sign: str = ""
    """Sign format of numbers; "+" if all numbers have a sign."""
    decimals: int = 4
    """Decimals of coordinates in mm; one more in inch."""
    by_time: bool = True
    """Whether moves that turn the part have inverse-time feeds [moves/min]; else lengths at its surface."""
    turning: tuple[str, ...] = ("G93",)
    """Modes for moves that turn the part, after ``modes``."""
    straight: tuple[str, ...] = ("G94",)
    """Modes after such moves."""
    numbered: bool = False
    """Whether lines have numbers, from 0."""


CONTROL_DIALECTS = {
    "iso": ControlDialect(start=(), modes=("{units} G17 G90 G94 G40",), end=("M30",), comment="({})"),
    "fanuc": ControlDialect(
        start=("%", "O0001"),
        modes=("{units} G17 G90 G94 G40 G49 G80 G54",),
        end=("M30", "%"),
        comment="({})",
        tool=("T{tool} M6", "G43 H{tool}"),
        decimals=3,
    ),
    "siemens": ControlDialect(
        start=(),
        modes=("{units} G17 G90 G94 G40 G54",),
        units={MM: "G71", INCH: "G70"},
        end=("M30",),
        comment="; {}",
        tool=("T{tool} D1", "M6"),
    ),
    "heidenhain": ControlDialect(
        start=("BEGIN PGM CAM {units}",),
        modes=(),
        end=("M30", "END PGM CAM {units}"),
        units={MM: "MM", INCH: "INCH"},
        comment="; {}",
        rapid="L X{x} Y{y} R0 FMAX",
        line="L X{x} Y{y} R0",
        arc="CC X{cx} Y{cy}\nC X{x} Y{y} DR{way}",
        ways=("-", "+"),
        up="L Z{z} R0 FMAX",
        down="L Z{z} R0",
        tool=("TOOL CALL {tool} {axis} S{speed}",),
        spindle="M3",
        sign="+",
        by_time=False,
        turning=("M116",),
        straight=("M117",),
        numbered=True,
    ),
}
"""Dialects by name of the control."""
CONTROL_BY_SUFFIX = {".nc": "iso", ".mpf": "siemens", ".h": "heidenhain"}
"""Default dialect, by ending of the file."""


@dataclass
class Program:
    """Lines of a program. Coordinates are given in mm and written in the shown unit."""

    words: ControlDialect
    decimals: int
    lines: list[str] = field(default_factory=list)
    feed: str = ""
    """The current feed as text."""
    position: tuple[str, str] | None = None
    """Current position of the machine, in the digits of the program."""
    at_change_height: bool = False
    """Whether the cutter is as high as where it was changed: it goes down beside the part only."""

    def add_lines(self, *templates: str, **values: object) -> None:
        """Add lines from templates of the dialect."""
        for template in templates:
            self.lines += template.format(units=self.words.units[shown_system()], **values).split("\n")

    def start_cutter(self, tool: int | None, spindle: float | None, coolant: bool, axis: str = "Z") -> None:
        """Call the cutter, which lies along an axis, and switch on spindle and coolant."""
        if tool is not None:
            self.add_lines(*self.words.tool, tool=tool, speed=f"{spindle or 0:g}", axis=axis)
            self.at_change_height = True
        if spindle is not None:
            self.add_lines(self.words.spindle, speed=f"{spindle:g}")
        if coolant:
            self.add_lines(self.words.coolant)

    def stop_cutter_and_end(self, spindle: float | None, coolant: bool) -> None:
        """Switch off coolant and spindle, and end the program."""
        if coolant:
            self.add_lines(self.words.dry)
        if spindle is not None:
            self.add_lines(self.words.still)
        self.add_lines(*self.words.end)

    def comment(self, text: str) -> None:
        """Add a comment in characters that any control accepts."""
        plain = text.encode("ascii", "replace").decode().replace("(", "[").replace(")", "]")
        self.lines.append(self.words.comment.format(plain))

    def rapid(self, point: complex) -> None:
        """Go to a point in rapid motion, above or outside of the part."""
        self.position = x, y = self._coordinates(point)
        self.add_lines(self.words.rapid, x=x, y=y)

    def move_cutter_to_height(self, height: float, feed: float | None = None) -> None:
        """Move the cutter along its axis, in rapid motion or at a feed."""
        words = self.words.up if feed is None else self.words.down + self._feed_word(feed)
        self.add_lines(words, z=self.coordinate_text(height))

    def line(self, point: complex, feed: float) -> None:
        """Go straight to a point; no line if the machine is there already, within its digits."""
        if (place := self._coordinates(point)) != self.position:
            self.position = x, y = place
            self.add_lines(self.words.line + self._feed_word(feed), x=x, y=y)

    def arc(self, start: complex, end: complex, bulge: float, feed: float) -> None:
        """Move from the current position by an arc, or by a line without a bulge."""
        if not bulge or self._coordinates(end) == self.position:  # an arc without length would be a full circle
            self.line(end, feed)
            return
        self.position = self._coordinates(end)
        way = (end - start) * (0.5 + 0.25j * (1.0 / bulge - bulge))
        numbers = {"x": end.real, "y": end.imag, "i": way.real, "j": way.imag}
        numbers |= {"cx": (start + way).real, "cy": (start + way).imag}
        texts = {name: self.coordinate_text(value) for name, value in numbers.items()}
        self.add_lines(self.words.arc + self._feed_word(feed), way=self.words.ways[int(bulge > 0.0)], **texts)

    def _coordinates(self, point: complex) -> tuple[str, str]:
        return self.coordinate_text(point.real), self.coordinate_text(point.imag)

    def coordinate_text(self, value: float) -> str:
        """A coordinate as text, without −0."""
        return f"{np.round(to_shown_unit(value, 'mm'), self.decimals) + 0.0:{self.words.sign}.{self.decimals}f}"

    def text(self) -> str:
        """The text of the program."""
        numbered = (f"{k} {line}" for k, line in enumerate(self.lines))
        return "\n".join([*(numbered if self.words.numbered else self.lines)]) + "\n"

    def _feed_word(self, feed: float) -> str:
        """The words of a feed; empty if it is the current one."""
        text = f"{to_shown_unit(feed, 'mm/min'):g}"
        before, self.feed = self.feed, text
        return "" if before == text else self.words.feed.format(feed=text)
