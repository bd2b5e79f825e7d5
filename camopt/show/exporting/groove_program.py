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
from camopt.show.exporting.exported import CurveInFile, Export, Workpiece
from camopt.show.exporting.machining import (
    BESIDE_A_RIB,
    CLEARANCE,
    LARGEST_RADIUS,
    MILLINGS,
    ROTARY_AXES,
    Milling,
    with_shown_unit,
)
from camopt.show.exporting.program import DIALECTS, Dialect, Program
from camopt.solve.contour.curve import CamCurve, SmoothPart, cylinder_ends

MOST_PLACES = 1_000_000


class Axes(NamedTuple):
    """The axes of a machine: along the axis of the cam, from it to the cutter, and about it."""

    along: str
    radial: str
    rotary: str
    lateral: float
    """The sign of Y where the angle about the axis of the cam grows, where the cutter is."""
    plane: str
    """What says that the cutter is along ``radial``: its length counts there."""


AXES = dict(zip(ROTARY_AXES, (Axes("X", "Z", "A", -1.0, "G17"), Axes("Z", "X", "C", 1.0, "G19")), strict=True))


@dataclass(frozen=True)
class Places:
    """Where the cutter is in the frame of the machine, lengths in mm, and how the cam is turned, deg."""

    along: FloatArray
    beside: FloatArray
    turned: FloatArray
    deviation: float
    """How far the cutter is from the roller's true place at most, from one to the next, mm."""

    @property
    def backwards(self) -> "Places":
        return Places(self.along[::-1], self.beside[::-1], self.turned[::-1], self.deviation)

    def __len__(self) -> int:
        return self.along.size


class _Turning(Program):
    """A program whose cam turns: moves go to places, at feeds over a surface of a radius (mm)."""

    def __init__(self, words: Dialect, decimals: int, axes: Axes, outer: float, *, on_arm: bool) -> None:
        super().__init__(words, decimals)
        self._axes, self._outer, self._on_arm = axes, outer, on_arm

    def over(self, places: Places) -> None:
        """Go above the first place as fast as the machine can."""
        self.say(self.words.rapid.replace("X{x} Y{y}", self._place_of(places, 0)))

    def radially(self, radius: float, feed: float | None = None, distance: float = 0.0) -> None:
        """Move the cutter to a distance from the axis, fast or at a feed."""
        words = self.words.up if feed is None else self.words.down
        moved = words.replace("Z{z}", f"{self._axes.radial}{self.number(radius)}")
        self.say(moved + ("" if feed is None else self._rate(feed, distance)))

    def through(self, places: Places, feed: float) -> None:
        """Move from the first place, where the machine stands, to the last."""
        around = np.diff(np.radians(places.turned) * self._outer + self._axes.lateral * places.beside)
        lengths = np.hypot(np.diff(places.along), around)
        before = self._place_of(places, 0)
        for k, length in enumerate(lengths.tolist(), start=1):
            if (place := self._place_of(places, k)) != before:
                self.say(self.words.line.replace("X{x} Y{y}", place) + self._rate(feed, length))
            before = place

    def _place_of(self, places: Places, k: int) -> str:
        beside = f" Y{self.number(places.beside[k])}" if self._on_arm else ""
        turned = f"{np.round(places.turned[k], self.decimals) + 0.0:{self.words.sign}.{self.decimals}f}"
        return f"{self._axes.along}{self.number(places.along[k])}{beside} {self._axes.rotary}{turned}"

    def _rate(self, feed: float, length: float) -> str:
        if not self.words.by_time:
            return self._fed(feed)
        rate = np.format_float_positional(feed / length, 5, unique=False, fractional=False, trim="-")
        return self.words.feed.format(feed=rate)


def write_groove(work: Workpiece, path: Path, asked: Milling) -> Export:
    """Write a program that cuts the groove or the rib of a cylinder, in steps of its depth, one turn each.

    The cutter goes down in the middle of the longest dwell, and every second turn is backwards. Of the settings of
    programs it has none of those of a profile: both walls of a groove are cut at once, and each flank of a rib in
    the place of its roller. What else is beside a rib is left.
    """
    asked = asked if asked.depth is not None else replace(asked, depth=_height(work))
    _check(work, asked)
    assert asked.cutter_radius is not None
    assert asked.feed is not None
    axes = AXES[asked.rotary or ROTARY_AXES[0]]
    mean, groove = float(work.problem.design.size[0]), _height(work)
    assert groove
    outer = mean + groove / 2
    every = {
        name.replace("pitch", "cutter"): _places(work, curve, axes, asked, outer)
        for name, curve in work.curves().items()
        if name.endswith("pitch")
    }
    on_arm = any(np.any(places.beside != 0.0) for places in every.values())
    program = _Turning(DIALECTS[asked.control], asked.decimals, axes, outer, on_arm=on_arm)
    _begin(program, work, asked, every, axes)
    program.start(asked.tool, asked.spindle, asked.coolant, axes.radial)
    program.radially(outer + CLEARANCE)
    for places in every.values():
        _cut_all(program, places, asked, outer)
    program.say(*program.words.straight)
    program.stop(asked.spindle, asked.coolant)
    write_text(path, program.text())
    curves = {name: CurveInFile(len(each) - 1, "lines", each.deviation) for name, each in every.items()}
    return Export(path, curves, notes=(*left_on_walls(work, asked.cutter_radius), *asked.left_out))


def _height(work: Workpiece) -> float | None:
    """The depth of the groove, or the height of the rib, mm."""
    height: float | None = getattr(work.part, work.problem.setup.mechanism.body.flank_height)
    return height


def _cut_all(program: _Turning, places: Places, asked: Milling, outer: float) -> None:
    """Cut in steps of the depth along places, from above the cam and back there."""
    assert asked.feed is not None
    program.over(places)
    above = -CLEARANCE
    for level in asked.levels:
        assert level is not None
        program.radially(outer - level, asked.feed, level - above)
        program.through(places, asked.feed)
        places, above = places.backwards, level
    program.radially(outer + CLEARANCE)


PLANE_ONLY = {
    "roughing": 0.0,
    "roughing_feed": None,
    "direction": MILLINGS[0],
    "blank_diameter": None,
    "largest_radius": LARGEST_RADIUS,
}
"""Settings that a groove has not, and what they are where they are not given."""


def _check(work: Workpiece, asked: Milling) -> None:
    """BadInput for settings that are missing, out of range or without a meaning here."""
    mistakes, depth, body = list(asked.mistakes), _height(work), work.problem.setup.mechanism.body
    for name, usual in PLANE_ONLY.items():
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


def _places(work: Workpiece, curve: CamCurve, axes: Axes, asked: Milling, outer: float) -> Places:
    """Places over one turn of the cam, so near to each other that the cutter keeps within the chord."""
    digit = asked.last_digit
    digits = np.hypot(digit, digit) / 2 + outer * np.radians(10.0**-asked.decimals) / 2
    if asked.chord <= digits:
        why = f"above {digits:.2g} mm: so much is in the digits of the program"
        raise BadInput([Mistake("camopt", "chord", asked.chord, why)])
    angles, deviation = _steps(curve, asked.chord - digits)
    design, (y, y1, *_) = curve.design, curve.programme.at(angles % (2 * np.pi))
    found = curve.mechanism.contact(design, curve.programme.lift, angles, y, y1)
    beside = (found.x - design.size * angles) * (-design.sense * axes.lateral)
    low = cylinder_ends(work.problem, work.part.thickness)[0] if work.part.thickness else 0.0
    height, turned = found.y, -design.sense * np.degrees(angles)
    return Places(height - low, beside + 0.0 * angles, turned, deviation + digits)


def _steps(curve: CamCurve, wanted: float) -> tuple[FloatArray, float]:
    """Cam angles (rad) over one turn, and how far lines between their places are off the true ones at most, mm."""
    edges, furthest = [np.zeros(1)], 0.0
    for span in curve.spans:
        ends, off = _cut(curve, span, wanted)
        edges.append(ends)
        furthest = max(furthest, float(off.max()))
    angles = np.concatenate(edges)
    if angles.size > MOST_PLACES:
        raise BadInput([Mistake("camopt", "chord", wanted, f"larger: a program has {MOST_PLACES:,} lines at most")])
    start = _middle_of_dwell(curve)
    before, after = angles[1:][angles[1:] <= start], angles[:-1][angles[:-1] > start]
    whole = np.concatenate([[start], after, before + 2 * np.pi, [start + 2 * np.pi]])
    return whole - (2 * np.pi if start > np.pi else 0.0), furthest


def _cut(curve: CamCurve, span: SmoothPart, wanted: float) -> tuple[FloatArray, FloatArray]:
    """A span in parts on which a line is near enough: where they end, and how far it is off."""
    lows, highs = np.array([span.start]), np.array([span.end])
    while True:
        off = _off_line(curve, span, lows, highs)
        wide = np.flatnonzero(off > wanted)
        if not wide.size or lows.size > MOST_PLACES:
            order = np.argsort(lows)
            return highs[order], off[order]
        middles = (lows[wide] + highs[wide]) / 2
        lows, highs = np.append(lows, middles), np.append(highs, highs[wide])
        highs[wide] = middles


def _off_line(curve: CamCurve, span: SmoothPart, lows: FloatArray, highs: FloatArray) -> FloatArray:
    """How far the place of the roller is off a line over some stretches of a span at most, mm."""
    over = curve.expansion([span] * lows.size, lows, highs).over
    across, along = (as_interval(series.terms[2]).largest_magnitude for series in over)
    return np.asarray(np.hypot(across, along) * (highs - lows) ** 2 / 4)


def _middle_of_dwell(curve: CamCurve) -> float:
    """The cam angle in the middle of the longest dwell, rad; 0 without one."""
    dwells = [span for span in curve.spans if span.is_dwell]
    if not dwells:
        return 0.0
    longest = max(dwells, key=lambda span: span.end - span.start)
    return (longest.start + longest.end) / 2


def _begin(program: Program, work: Workpiece, asked: Milling, every: dict[str, Places], axes: Axes) -> None:
    """The head of the program, with what it is of."""
    zero = "lower end of the cylinder" if work.part.thickness else "middle of the roller at the start of the motion"
    assert asked.cutter_radius is not None
    furthest, lines = max(each.deviation for each in every.values()), sum(len(each) - 1 for each in every.values())
    radius, off = map(with_shown_unit, (asked.cutter_radius, furthest))
    what = work.problem.setup.mechanism.body.flank_height.partition("_")[0]
    program.say(*program.words.start)
    program.comment(work.part.name or "cam")
    program.comment(f"camopt {VERSION}; {what}, cutter radius {radius}")
    program.comment(f"cutter: {lines} lines, within {off}")
    program.comment(f"{axes.along} zero: {zero}; Y and {axes.radial} zero: axis of the cam")
    program.comment(f"{axes.rotary} in deg: where the cutter is on the cam, right-handed about {axes.along};")
    program.comment(f"{axes.rotary} zero: cam angle 0 below the cutter")
    modes = (each.replace("G17", axes.plane) for each in program.words.modes)
    program.say(*modes, *program.words.turning)


def left_on_walls(work: Workpiece, cutter_radius: float) -> Iterator[str]:
    """Notes on a cutter that leaves something on walls of a groove or a rib, and on what a rib has beside it."""
    whole = work.problem.half_width
    if work.problem.setup.mechanism.further:
        yield BESIDE_A_RIB
    if whole > cutter_radius:
        left, radius = map(with_shown_unit, (whole - cutter_radius, whole))
        yield f"the cutter leaves {left} on each wall: one with a radius of {radius} cuts them to size"
