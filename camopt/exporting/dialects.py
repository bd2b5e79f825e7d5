"""What controllers of machines take: the words of a program, as templates, a record for each dialect.

Sources: ISO 6983-1 and DIN 66025 (iso); the programming manuals of Fanuc (series 0i, milling), Siemens (Sinumerik
840D) and Heidenhain (TNC, conversational; M116 for feeds of rotary axes).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from camopt.quantities.unit_systems import INCH, MM


@dataclass(frozen=True)
class Dialect:
    """Templates of lines: x, y, z are where a move goes, cx and cy its centre, i and j that from its start."""

    start: tuple[str, ...]
    """Before what the program tells of itself."""
    modes: tuple[str, ...]
    """What holds for all moves: mm or inch, the plane XY, absolute, feed by the minute, no compensation."""
    end: tuple[str, ...]
    comment: str
    units: Mapping[str, str] = field(default_factory={MM: "G21", INCH: "G20"}.copy)
    """What says in which units lengths are."""
    rapid: str = "G0 X{x} Y{y}"
    line: str = "G1 X{x} Y{y}"
    arc: str = "G{way} X{x} Y{y} I{i} J{j}"
    ways: tuple[str, str] = ("2", "3")
    """Clockwise and anticlockwise."""
    up: str = "G0 Z{z}"
    down: str = "G1 Z{z}"
    feed: str = " F{feed}"
    """What follows a move where the feed changes."""
    tool: tuple[str, ...] = ("T{tool} M6",)
    spindle: str = "S{speed} M3"
    coolant: str = "M8"
    still: str = "M5"
    """The spindle stops."""
    dry: str = "M9"
    """The coolant stops."""
    sign: str = ""
    """Of numbers: "+" where they all have one."""
    decimals: int = 4
    """Of coordinates in mm; in inch one more."""
    by_time: bool = True
    """Whether feeds of moves that turn the part are moves by the minute, else lengths at its surface."""
    turning: tuple[str, ...] = ("G93",)
    """What holds for such moves, after ``modes``."""
    straight: tuple[str, ...] = ("G94",)
    """And what holds again after them."""
    numbered: bool = False
    """Whether lines have numbers, from 0."""


DIALECTS = {
    "iso": Dialect(start=(), modes=("{units} G17 G90 G94 G40",), end=("M30",), comment="({})"),
    "fanuc": Dialect(
        start=("%", "O0001"),
        modes=("{units} G17 G90 G94 G40 G49 G80 G54",),
        end=("M30", "%"),
        comment="({})",
        tool=("T{tool} M6", "G43 H{tool}"),
        decimals=3,
    ),
    "siemens": Dialect(
        start=(),
        modes=("{units} G17 G90 G94 G40 G54",),
        units={MM: "G71", INCH: "G70"},
        end=("M30",),
        comment="; {}",
        tool=("T{tool} D1", "M6"),
    ),
    "heidenhain": Dialect(
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
"""By the name of the control."""
BY_ENDING = {".nc": "iso", ".mpf": "siemens", ".h": "heidenhain"}
"""The dialect of a file whose control is not named."""
