"""Programs for the groove or the rib of a cylinder: a cutter in the place of a roller, while the cam turns below.

At each cam angle the axis of the roller is square to that of the cam: at a height along it, and beside it by
what an arm has swung away from the line of contact. A cutter of the roller's radius that takes these places cuts
the walls that the roller touches, at every depth. A smaller one cannot: shifted along the normal of the developed
curve it would cut walls that are true at the mean radius alone. So it roughs. Beside a rib it goes round twice, in
the place of each of both rollers.

The axis of the cam is along X of the machine, which turns it about A, and the cutter along Z; or along Z, C and X.
From one place to the next all axes move evenly. Over a step h of the cam angle the cutter is off its place by

    h²/8·max √(x''² + z''²)

at most, where x and z are its place beside and along the axis of the cam, by the cam angle. Feeds are those of the
cutter over the surface of the cam: as moves by the minute (G93), or as the control reckons them (M116).

Source: Smid, CNC Programming Handbook, ch. 22 (inverse time); for the linear interpolation error: de Boor, A
Practical Guide to Splines, ch. 3.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.core.numerics.interval import as_interval
from camopt.core.storage.files import write_text
from camopt.core.storage.version import VERSION
from camopt.show.exporting.cam_points import check_cutter
from camopt.show.exporting.machining import (
    CLEARANCE,
    LARGEST_RADIUS,
    MILLING_DIRECTIONS,
    RIB_NOTE,
    ROTARY_AXES,
    Milling,
    length_with_unit,
)
from camopt.show.exporting.program import CONTROL_DIALECTS, ControlDialect, Program
from camopt.show.exporting.workpiece import CurveInFile, Export, Workpiece
from camopt.solve.contour.curve import CamCurve, SmoothSpan, cylinder_ends

MOST_POSITIONS = 1_000_000


class MachineAxes(NamedTuple):
    """The axes of a machine: along the axis of the cam, from it to the cutter, and about it."""

    along: str
    radial: str
    rotary: str
    lateral: float
    """The sign of Y where the angle about the axis of the cam grows, where the cutter is."""
    plane: str
    """What says that the cutter is along ``radial``: its length counts there."""


AXES_BY_ROTARY = dict(
    zip(ROTARY_AXES, (MachineAxes("X", "Z", "A", -1.0, "G17"), MachineAxes("Z", "X", "C", 1.0, "G19")), strict=True)
)


@dataclass(frozen=True)
class CutterPositions:
    """Where the cutter is in the frame of the machine, lengths in mm, and how the cam is turned, deg."""

    along: FloatArray
    lateral: FloatArray
    rotation_deg: FloatArray
    deviation: float
    """How far the cutter is from the roller's true place at most, from one to the next, mm."""

    @property
    def reverse_order(self) -> "CutterPositions":
        return CutterPositions(self.along[::-1], self.lateral[::-1], self.rotation_deg[::-1], self.deviation)

    def __len__(self) -> int:
        return self.along.size


class _RotaryProgram(Program):
    """A program whose cam turns: moves go to places, at feeds over a surface of a radius (mm)."""

    def __init__(
        self, words: ControlDialect, decimals: int, axes: MachineAxes, outer: float, *, on_arm: bool
    ) -> None:
        super().__init__(words, decimals)
        self._axes, self._outer, self._on_arm = axes, outer, on_arm

    def move_above(self, places: CutterPositions) -> None:
        """Go above the first place as fast as the machine can."""
        self.add_lines(self.words.rapid.replace("X{x} Y{y}", self._position_words(places, 0)))

    def move_radially(self, radius: float, feed: float | None = None, distance: float = 0.0) -> None:
        """Move the cutter to a distance from the axis, fast or at a feed."""
        words = self.words.up if feed is None else self.words.down
        moved = words.replace("Z{z}", f"{self._axes.radial}{self.number(radius)}")
        self.add_lines(moved + ("" if feed is None else self._rate_word(feed, distance)))

    def cut_along_positions(self, places: CutterPositions, feed: float) -> None:
        """Move from the first place, where the machine stands, to the last."""
        around = np.diff(np.radians(places.rotation_deg) * self._outer + self._axes.lateral * places.lateral)
        lengths = np.hypot(np.diff(places.along), around)
        before = self._position_words(places, 0)
        for k, length in enumerate(lengths.tolist(), start=1):
            if (place := self._position_words(places, k)) != before:
                self.add_lines(self.words.line.replace("X{x} Y{y}", place) + self._rate_word(feed, length))
            before = place

    def _position_words(self, places: CutterPositions, k: int) -> str:
        beside = f" Y{self.number(places.lateral[k])}" if self._on_arm else ""
        turned = f"{np.round(places.rotation_deg[k], self.decimals) + 0.0:{self.words.sign}.{self.decimals}f}"
        return f"{self._axes.along}{self.number(places.along[k])}{beside} {self._axes.rotary}{turned}"

    def _rate_word(self, feed: float, length: float) -> str:
        if not self.words.by_time:
            return self._feed_word(feed)
        rate = np.format_float_positional(feed / length, 5, unique=False, fractional=False, trim="-")
        return self.words.feed.format(feed=rate)


def write_groove(work: Workpiece, path: Path, asked: Milling) -> Export:
    """Write a program that cuts the groove or the rib of a cylinder, in steps of its depth, one turn each.

    The cutter goes down in the middle of the longest dwell, and every second turn is backwards. Of the settings of
    programs it has none of those of a profile: both walls of a groove are cut at once, and each flank of a rib in
    the place of its roller. What else is beside a rib is left.
    """
    asked = asked if asked.depth is not None else replace(asked, depth=_flank_height(work))
    _check_groove_milling(work, asked)
    assert asked.cutter_radius is not None
    assert asked.feed is not None
    axes = AXES_BY_ROTARY[asked.rotary or ROTARY_AXES[0]]
    mean, groove = float(work.problem.design.size[0]), _flank_height(work)
    assert groove
    outer = mean + groove / 2
    every = {
        name.replace("pitch", "cutter"): _cutter_positions(work, curve, axes, asked, outer)
        for name, curve in work.curves().items()
        if name.endswith("pitch")
    }
    on_arm = any(np.any(places.lateral != 0.0) for places in every.values())
    program = _RotaryProgram(CONTROL_DIALECTS[asked.control], asked.decimals, axes, outer, on_arm=on_arm)
    _write_groove_head(program, work, asked, every, axes)
    program.start(asked.tool, asked.spindle, asked.coolant, axes.radial)
    program.move_radially(outer + CLEARANCE)
    for places in every.values():
        _cut_in_steps(program, places, asked, outer)
    program.add_lines(*program.words.straight)
    program.stop(asked.spindle, asked.coolant)
    write_text(path, program.text())
    curves = {name: CurveInFile(len(each) - 1, "lines", each.deviation) for name, each in every.items()}
    return Export(path, curves, notes=(*wall_notes(work, asked.cutter_radius), *asked.omissions))


def _flank_height(work: Workpiece) -> float | None:
    """The depth of the groove, or the height of the rib, mm."""
    height: float | None = getattr(work.part, work.problem.setup.mechanism.body.flank_height)
    return height


def _cut_in_steps(program: _RotaryProgram, places: CutterPositions, asked: Milling, outer: float) -> None:
    """Cut in steps of the depth along places, from above the cam and back there."""
    assert asked.feed is not None
    program.move_above(places)
    above = -CLEARANCE
    for level in asked.levels:
        assert level is not None
        program.move_radially(outer - level, asked.feed, level - above)
        program.cut_along_positions(places, asked.feed)
        places, above = places.reverse_order, level
    program.move_radially(outer + CLEARANCE)


PLANE_SETTINGS = {
    "roughing": 0.0,
    "roughing_feed": None,
    "direction": MILLING_DIRECTIONS[0],
    "blank_diameter": None,
    "largest_radius": LARGEST_RADIUS,
}
"""Settings that a groove has not, and what they are where they are not given."""


def _check_groove_milling(work: Workpiece, asked: Milling) -> None:
    """BadInput for settings that are missing, out of range or without a meaning here."""
    mistakes, depth, body = list(asked.mistakes), _flank_height(work), work.problem.setup.mechanism.body
    for name, usual in PLANE_SETTINGS.items():
        if getattr(asked, name) != usual:
            why = "has no meaning for a cylinder: a cutter as wide as the roller cuts what that touches in one turn"
            mistakes.append(Mistake("camopt", name, getattr(asked, name), why, bare=True))
    if depth is None:
        why = "missing: the cutter goes as deep, from a surface half of it outside of the mean radius"
        mistakes.append(Mistake(work.scene.file, f"part.{body.flank_height}", None, why, bare=True))
    elif asked.depth is not None and asked.depth > depth:
        mistakes.append(Mistake("camopt", "depth", asked.depth, f"at most part.{body.flank_height} ({depth:g} mm)"))
    if mistakes:
        raise BadInput(mistakes)
    check_cutter(work.problem, asked.cutter_radius)


def _cutter_positions(
    work: Workpiece, curve: CamCurve, axes: MachineAxes, asked: Milling, outer: float
) -> CutterPositions:
    """Places over one turn of the cam, so near to each other that the cutter keeps within the chord."""
    digit = asked.last_digit
    digits = np.hypot(digit, digit) / 2 + outer * np.radians(10.0**-asked.decimals) / 2
    if asked.chord <= digits:
        why = f"above {digits:.2g} mm: so much is in the digits of the program"
        raise BadInput([Mistake("camopt", "chord", asked.chord, why)])
    angles, deviation = _angle_steps(curve, asked.chord - digits)
    design, (y, y1, *_) = curve.design, curve.programme.motion_at(angles % (2 * np.pi))
    found = curve.mechanism.contact(design, curve.programme.lift, angles, y, y1)
    beside = (found.x - design.size * angles) * (-design.sense * axes.lateral)
    low = cylinder_ends(work.problem, work.part.thickness)[0] if work.part.thickness else 0.0
    height, turned = found.y, -design.sense * np.degrees(angles)
    return CutterPositions(height - low, beside + 0.0 * angles, turned, deviation + digits)


def _angle_steps(curve: CamCurve, wanted: float) -> tuple[FloatArray, float]:
    """Cam angles (rad) over one turn, and how far lines between their places are off the true ones at most, mm."""
    edges, furthest = [np.zeros(1)], 0.0
    for span in curve.spans:
        ends, off = _divide_span(curve, span, wanted)
        edges.append(ends)
        furthest = max(furthest, float(off.max()))
    angles = np.concatenate(edges)
    if angles.size > MOST_POSITIONS:
        raise BadInput(
            [Mistake("camopt", "chord", wanted, f"larger: a program has {MOST_POSITIONS:,} lines at most")]
        )
    start = _dwell_middle(curve)
    before, after = angles[1:][angles[1:] <= start], angles[:-1][angles[:-1] > start]
    whole = np.concatenate([[start], after, before + 2 * np.pi, [start + 2 * np.pi]])
    return whole - (2 * np.pi if start > np.pi else 0.0), furthest


def _divide_span(curve: CamCurve, span: SmoothSpan, wanted: float) -> tuple[FloatArray, FloatArray]:
    """A span in parts on which a line is near enough: where they end, and how far it is off."""
    lows, highs = np.array([span.start]), np.array([span.end])
    while True:
        off = _line_deviation(curve, span, lows, highs)
        wide = np.flatnonzero(off > wanted)
        if not wide.size or lows.size > MOST_POSITIONS:
            order = np.argsort(lows)
            return highs[order], off[order]
        middles = (lows[wide] + highs[wide]) / 2
        lows, highs = np.append(lows, middles), np.append(highs, highs[wide])
        highs[wide] = middles


def _line_deviation(curve: CamCurve, span: SmoothSpan, lows: FloatArray, highs: FloatArray) -> FloatArray:
    """How far the place of the roller is off a line over some stretches of a span at most, mm."""
    over = curve.expansion([span] * lows.size, lows, highs).over_stretches
    across, along = (as_interval(series.terms[2]).largest_magnitude for series in over)
    return np.asarray(np.hypot(across, along) * (highs - lows) ** 2 / 4)


def _dwell_middle(curve: CamCurve) -> float:
    """The cam angle in the middle of the longest dwell, rad; 0 without one."""
    dwells = [span for span in curve.spans if span.is_dwell]
    if not dwells:
        return 0.0
    longest = max(dwells, key=lambda span: span.end - span.start)
    return (longest.start + longest.end) / 2


def _write_groove_head(
    program: Program, work: Workpiece, asked: Milling, every: dict[str, CutterPositions], axes: MachineAxes
) -> None:
    """The head of the program, with what it is of."""
    zero = "lower end of the cylinder" if work.part.thickness else "middle of the roller at the start of the motion"
    assert asked.cutter_radius is not None
    furthest, lines = max(each.deviation for each in every.values()), sum(len(each) - 1 for each in every.values())
    radius, off = map(length_with_unit, (asked.cutter_radius, furthest))
    what = work.problem.setup.mechanism.body.flank_height.partition("_")[0]
    program.add_lines(*program.words.start)
    program.comment(work.part.name or "cam")
    program.comment(f"camopt {VERSION}; {what}, cutter radius {radius}")
    program.comment(f"cutter: {lines} lines, within {off}")
    program.comment(f"{axes.along} zero: {zero}; Y and {axes.radial} zero: axis of the cam")
    program.comment(f"{axes.rotary} in deg: where the cutter is on the cam, right-handed about {axes.along};")
    program.comment(f"{axes.rotary} zero: cam angle 0 below the cutter")
    modes = (each.replace("G17", axes.plane) for each in program.words.modes)
    program.add_lines(*modes, *program.words.turning)


def wall_notes(work: Workpiece, cutter_radius: float) -> Iterator[str]:
    """Notes on a cutter that leaves something on walls of a groove or a rib, and on what a rib has beside it."""
    whole = work.problem.half_width
    if work.problem.setup.mechanism.further_contacts:
        yield RIB_NOTE
    if whole > cutter_radius:
        left, radius = map(length_with_unit, (whole - cutter_radius, whole))
        yield f"the cutter leaves {left} on each wall: one with a radius of {radius} cuts them to size"
