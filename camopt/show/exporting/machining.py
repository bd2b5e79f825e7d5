"""Settings of programs for machines, with their allowed ranges."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, isfinite

from camopt.core.mistakes import Mistake
from camopt.core.quantities.unit_systems import from_shown_unit, to_shown_unit, unit_in_shown_system
from camopt.show.exporting.program import CONTROL_DIALECTS
from camopt.solve.contour.path_fitting import DEFAULT_CHORD

ALLOWED_DECIMALS = range(3, 7)
MILLING_DIRECTIONS = ("climb", "conventional")
ROTARY_AXES = ("A", "C")
MOST_DEPTH_CUTS = 1000  # largest number of depth steps
LEAST_CHORD = 5.0  # in units of the last digit
CLEARANCE = 5.0  # mm above the part
RIB_NOTE = "the cutter removes only metal near the rib: turn or mill the rest away before"
LARGEST_RADIUS = 10_000.0  # mm


@dataclass(frozen=True)
class Milling:
    """Settings of a program, lengths in mm; None if not set."""

    control: str
    decimals: int
    chord: float
    """Largest distance of the path from the true path [mm]."""
    cutter_radius: float | None
    feed: float | None
    """mm/min."""
    depth: float | None
    depth_step: float | None
    roughing: float
    """Metal that roughing cuts leave [mm]."""
    roughing_feed: float | None
    direction: str
    tool: int | None
    spindle: float | None
    """rev/min."""
    coolant: bool
    blank_diameter: float | None
    largest_radius: float
    """Largest radius of arcs [mm]; larger arcs are written as lines."""
    rotary: str | None
    """The axis about which the cam turns."""

    @property
    def cut_depths(self) -> list[float | None]:
        """Depths of the cuts [mm], in even steps."""
        if self.depth is None:
            return [None]
        count = ceil(self.depth / self.depth_step * (1.0 - 1e-12)) if self.depth_step else 1
        return [self.depth * (k + 1) / count for k in range(count)]

    @property
    def mistakes(self) -> Iterator[Mistake]:
        """Settings that are missing, need another setting, or are out of range."""
        for name in ("cutter_radius", "feed"):
            if getattr(self, name) is None:
                yield Mistake("camopt", name, None, "missing; a program for a CNC machine needs it", bare=True)
        for name, other in (("spindle", "tool"), ("roughing_feed", "roughing"), ("depth_step", "depth")):
            if getattr(self, name) is not None and not getattr(self, other):
                yield Mistake("camopt", name, getattr(self, name), f"needs {other}", bare=True)
        yield from self._range_mistakes()
        least = least_chord(self.decimals)
        if not self.chord >= least:
            why = f"at least {least:g} mm: a program has {self.decimals} decimals"
            yield Mistake("camopt", "chord", self.chord, why)

    @property
    def notes_on_missing_actions(self) -> Iterator[str]:
        """Notes on actions of the machine that the program does not contain."""
        if self.spindle is None:
            yield "spindle is not set: the program does not start the spindle (set spindle and tool)"

    def _range_mistakes(self) -> Iterator[Mistake]:
        for name in POSITIVE_SETTINGS:
            value = getattr(self, name)
            if value is not None and not (isfinite(value) and value > 0.0):
                yield Mistake("camopt", name, value, "above 0")
        for name, allowed in ALLOWED_SETTINGS.items():
            value = getattr(self, name)
            if value not in allowed and (name, value) != ("rotary", None):
                yield Mistake("camopt", name, value, f"one of {', '.join(map(str, allowed))}")
        if not 0.0 <= self.roughing <= 1e3:
            yield Mistake("camopt", "roughing", self.roughing, "from 0 to 1000 mm")
        if self.tool is not None and not 1 <= self.tool <= 99_999:
            yield Mistake("camopt", "tool", self.tool, "from 1 to 99999")
        least = self.depth / MOST_DEPTH_CUTS if self.depth else 0.0
        if self.depth_step and self.depth_step < least:
            why = f"at least {least:g} mm: at most {MOST_DEPTH_CUTS} steps are allowed"
            yield Mistake("camopt", "depth_step", self.depth_step, why)


POSITIVE_SETTINGS = ("feed", "roughing_feed", "depth", "depth_step", "spindle", "blank_diameter", "largest_radius")
ALLOWED_SETTINGS = {
    "direction": MILLING_DIRECTIONS,
    "control": tuple(CONTROL_DIALECTS),
    "decimals": ALLOWED_DECIMALS,
    "rotary": ROTARY_AXES,
}


def last_decimal_in_mm(decimals: int) -> float:
    """Value of the last decimal of coordinates in the shown unit [mm]."""
    return float(from_shown_unit(10.0**-decimals, "mm"))


def least_chord(decimals: int) -> float:
    """Smallest chord for a number of decimals: five units of the last one [mm]."""
    return LEAST_CHORD * last_decimal_in_mm(decimals) if decimals in ALLOWED_DECIMALS else DEFAULT_CHORD


def length_with_unit(length: float, format_spec: str = ".6g") -> str:
    """A length given in mm, as text in the shown unit."""
    return f"{to_shown_unit(length, 'mm'):{format_spec}} {unit_in_shown_system('mm')}"
