"""Programs for the groove or rib of a cylinder: a cutter in the place of a roller, while the cam turns.

At each cam angle the axis of the roller is square to the axis of the cam. It is at a height along this axis, and
beside it by the swing of an arm from the line of contact. A cutter of the roller's radius in these positions cuts
the walls that the roller touches, at every depth. A smaller cutter cannot do so: shifted along the normal of the
developed curve, it would cut walls that are true only at the mean radius. So it only roughs. Along a rib the cutter
goes round twice, in the place of each roller.

The cam lies along X of the machine, which turns it about A, with the cutter along Z; or along Z, C and X. Between
two positions all axes move evenly. Over a step h of the cam angle, the cutter deviates from its position by at most

    h²/8·max √(x''² + z''²),

where x and z are its positions beside and along the axis of the cam, as functions of the cam angle. Feeds are those
of the cutter over the surface of the cam: as inverse time (G93), or as the control computes them (M116).

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
    last_decimal_in_mm,
    length_with_unit,
)
from camopt.show.exporting.program import CONTROL_DIALECTS, ControlDialect, Program
from camopt.show.exporting.workpiece import CurveInFile, Export, Workpiece
from camopt.solve.contour.curve import CamCurve, SmoothSpan, centred_cylinder_ends

MOST_POSITIONS = 1_000_000


class MachineAxes(NamedTuple):
    """Names of machine axes: along the axis of the cam, from it to the cutter, and about it."""

    along: str
    radial: str
    rotary: str
    lateral: float
    """Sign of Y at the cutter in the direction of growing angle about the axis of the cam."""
    plane: str
    """Word for the plane square to the cutter: its length counts along ``radial``."""


AXES_BY_ROTARY = dict(
    zip(ROTARY_AXES, (MachineAxes("X", "Z", "A", -1.0, "G17"), MachineAxes("Z", "X", "C", 1.0, "G19")), strict=True)
)


@dataclass(frozen=True)
class CutterPositions:
    """Positions of the cutter in the frame of the machine [mm], and rotations of the cam [deg]."""

    along: FloatArray
    lateral: FloatArray
    rotation_deg: FloatArray
    deviation: float
    """Bound of the distance of the cutter from the true place of the roller, also between positions [mm]."""

    def __len__(self) -> int:
        return self.along.size


class _RotaryProgram(Program):
    """A program with a turning cam; feeds are over the surface at the radius ``outer_radius`` [mm]."""

    def __init__(
        self, words: ControlDialect, decimals: int, axes: MachineAxes, outer_radius: float, *, on_arm: bool
    ) -> None:
        super().__init__(words, decimals)
        self._axes, self._outer, self._on_arm = axes, outer_radius, on_arm

    def cut_in_steps(self, places: CutterPositions, settings: Milling) -> None:
        """Cut along positions in steps of the depth, from above the cam and back; odd steps are backwards."""
        assert settings.feed is not None
        self.add_lines(self.words.rapid.replace("X{x} Y{y}", self._position_words(places, 0)))
        above = -CLEARANCE
        for level in settings.cut_depths:
            assert level is not None
            self.move_radially(self._outer - level, settings.feed, level - above)
            self._cut_along_positions(places, settings.feed)
            backwards = places.along[::-1], places.lateral[::-1], places.rotation_deg[::-1]
            places, above = CutterPositions(*backwards, places.deviation), level
        self.move_radially(self._outer + CLEARANCE)

    def move_radially(self, radius: float, feed: float | None = None, move_length: float = 0.0) -> None:
        """Move the cutter to a distance from the axis, in rapid motion or at a feed."""
        words = self.words.up if feed is None else self.words.down
        move = words.replace("Z{z}", f"{self._axes.radial}{self.coordinate_text(radius)}")
        self.add_lines(move + ("" if feed is None else self._feed_word_for_length(feed, move_length)))

    def _cut_along_positions(self, places: CutterPositions, feed: float) -> None:
        """Move from the first position, the current one, to the last."""
        around = np.diff(np.radians(places.rotation_deg) * self._outer + self._axes.lateral * places.lateral)
        lengths = np.hypot(np.diff(places.along), around)
        before = self._position_words(places, 0)
        for k, length in enumerate(lengths.tolist(), start=1):
            if (place := self._position_words(places, k)) != before:
                self.add_lines(
                    self.words.line.replace("X{x} Y{y}", place) + self._feed_word_for_length(feed, length)
                )
            before = place

    def _position_words(self, places: CutterPositions, index: int) -> str:
        beside = f" Y{self.coordinate_text(places.lateral[index])}" if self._on_arm else ""
        turned = f"{np.round(places.rotation_deg[index], self.decimals) + 0.0:{self.words.sign}.{self.decimals}f}"
        return f"{self._axes.along}{self.coordinate_text(places.along[index])}{beside} {self._axes.rotary}{turned}"

    def _feed_word_for_length(self, feed: float, length: float) -> str:
        if not self.words.by_time:
            return self._feed_word(feed)
        rate = np.format_float_positional(feed / length, 5, unique=False, fractional=False, trim="-")
        return self.words.feed.format(feed=rate)


def write_groove(work: Workpiece, path: Path, settings: Milling) -> Export:
    """Write a program that cuts the groove or rib of a cylinder, with one turn of the cam for each depth step.

    The cutter goes down in the middle of the longest dwell; every second turn is backwards. Settings for profiles
    are refused: both walls of a groove are cut at once, and each flank of a rib in the place of its roller. Other
    metal beside a rib is not removed.
    """
    settings = settings if settings.depth is not None else replace(settings, depth=work.flank_height)
    _check_groove_milling(work, settings)
    assert settings.cutter_radius is not None
    assert settings.feed is not None
    axes = AXES_BY_ROTARY[settings.rotary or ROTARY_AXES[0]]
    assert work.flank_height
    outer = float(work.problem.design.size[0]) + work.flank_height / 2
    positions = {
        name.replace("pitch", "cutter"): _cutter_positions(work, curve, axes, settings, outer)
        for name, curve in work.curves().items()
        if name.endswith("pitch")
    }
    on_arm = any(np.any(places.lateral != 0.0) for places in positions.values())
    program = _RotaryProgram(CONTROL_DIALECTS[settings.control], settings.decimals, axes, outer, on_arm=on_arm)
    _write_groove_head(program, work, settings, positions, axes)
    program.start_cutter(settings.tool, settings.spindle, settings.coolant, axes.radial)
    program.move_radially(outer + CLEARANCE)
    for places in positions.values():
        program.cut_in_steps(places, settings)
    program.add_lines(*program.words.straight)
    program.stop_cutter_and_end(settings.spindle, settings.coolant)
    write_text(path, program.text())
    curves = {name: CurveInFile(len(each) - 1, "lines", each.deviation) for name, each in positions.items()}
    return Export(
        path,
        curves,
        notes=(*notes_on_metal_left_by_cutter(work, settings.cutter_radius), *settings.notes_on_missing_actions),
    )


PLANE_SETTINGS = {
    "roughing": 0.0,
    "roughing_feed": None,
    "direction": MILLING_DIRECTIONS[0],
    "blank_diameter": None,
    "largest_radius": LARGEST_RADIUS,
}
"""Settings that a groove does not have, with their defaults."""


def _check_groove_milling(work: Workpiece, settings: Milling) -> None:
    """Raise BadInput for settings that are missing, out of range or without a meaning here."""
    mistakes, depth, body = list(settings.mistakes), work.flank_height, work.problem.setup.mechanism.body
    for name, default in PLANE_SETTINGS.items():
        if getattr(settings, name) != default:
            why = "has no meaning for a cylinder: a cutter as wide as the roller cuts its flanks in one turn"
            mistakes.append(Mistake("camopt", name, getattr(settings, name), why, bare=True))
    if depth is None:
        why = "missing: it gives the depth of the cut, half of it outside of the mean radius"
        mistakes.append(Mistake(work.scene.file, f"part.{body.flank_height}", None, why, bare=True))
    elif settings.depth is not None and settings.depth > depth:
        why = f"at most part.{body.flank_height} ({depth:g} mm)"
        mistakes.append(Mistake("camopt", "depth", settings.depth, why))
    if mistakes:
        raise BadInput(mistakes)
    check_cutter(work.problem, settings.cutter_radius)


def _cutter_positions(
    work: Workpiece, curve: CamCurve, axes: MachineAxes, settings: Milling, outer_radius: float
) -> CutterPositions:
    """Positions over one turn of the cam, close enough for the chord."""
    digit = last_decimal_in_mm(settings.decimals)
    digits = np.hypot(digit, digit) / 2 + outer_radius * np.radians(10.0**-settings.decimals) / 2
    if settings.chord <= digits:
        why = f"above {digits:.2g} mm, the rounding error of the program"
        raise BadInput([Mistake("camopt", "chord", settings.chord, why)])
    angles, deviation = _angles_within_chord_and_deviation(curve, settings.chord - digits)
    design, (y, y1, *_) = curve.design, curve.programme.motion_at(angles % (2 * np.pi))
    contact = curve.mechanism.contact(design, curve.programme.lift, angles, y, y1)
    beside = (contact.x - design.size * angles) * (-design.sense * axes.lateral)
    low = centred_cylinder_ends(work.problem, work.part.thickness)[0] if work.part.thickness else 0.0
    height, turned = contact.y, -design.sense * np.degrees(angles)
    return CutterPositions(height - low, beside + 0.0 * angles, turned, deviation + digits)


def _angles_within_chord_and_deviation(curve: CamCurve, chord: float) -> tuple[FloatArray, float]:
    """Cam angles over one turn [rad], and the largest deviation of lines between their positions [mm]."""
    parts = [_span_part_ends_and_deviations(curve, span, chord) for span in curve.spans]
    angles = np.concatenate([np.zeros(1), *(ends for ends, _ in parts)])
    largest = max(float(deviations.max()) for _, deviations in parts)
    if angles.size > MOST_POSITIONS:
        raise BadInput(
            [Mistake("camopt", "chord", chord, f"larger: a program has at most {MOST_POSITIONS:,} lines")]
        )
    dwells = [span for span in curve.spans if span.is_dwell]
    longest = max(dwells, key=lambda span: span.end - span.start, default=None)
    start = (longest.start + longest.end) / 2 if longest else 0.0
    before, after = angles[1:][angles[1:] <= start], angles[:-1][angles[:-1] > start]
    whole = np.concatenate([[start], after, before + 2 * np.pi, [start + 2 * np.pi]])
    return whole - (2 * np.pi if start > np.pi else 0.0), largest


def _span_part_ends_and_deviations(
    curve: CamCurve, span: SmoothSpan, chord: float
) -> tuple[FloatArray, FloatArray]:
    """Ends of parts of a span on which a line is within the chord, and its deviations [mm]."""
    lows, highs = np.array([span.start]), np.array([span.end])
    while True:
        over = curve.taylor_expansion([span] * lows.size, lows, highs).over_stretches
        across, along = (as_interval(series.terms[2]).largest_magnitude for series in over)
        deviations = np.asarray(np.hypot(across, along) * (highs - lows) ** 2 / 4)  # bound of each line's
        wide = np.flatnonzero(deviations > chord)
        if not wide.size or lows.size > MOST_POSITIONS:
            order = np.argsort(lows)
            return highs[order], deviations[order]
        middles = (lows[wide] + highs[wide]) / 2
        lows, highs = np.append(lows, middles), np.append(highs, highs[wide])
        highs[wide] = middles


def _write_groove_head(
    program: Program, work: Workpiece, settings: Milling, positions: dict[str, CutterPositions], axes: MachineAxes
) -> None:
    """Write the head of the program: part, cutter, deviation and zero points."""
    zero = "lower end of the cylinder" if work.part.thickness else "middle of the roller at the start of the motion"
    assert settings.cutter_radius is not None
    deviation = max(each.deviation for each in positions.values())
    lines = sum(len(each) - 1 for each in positions.values())
    radius, largest = map(length_with_unit, (settings.cutter_radius, deviation))
    what = work.problem.setup.mechanism.body.flank_height.partition("_")[0]
    program.add_lines(*program.words.start)
    program.comment(work.part.name or "cam")
    program.comment(f"camopt {VERSION}; {what}, cutter radius {radius}")
    program.comment(f"cutter: {lines} lines, within {largest}")
    program.comment(f"{axes.along} zero: {zero}; Y and {axes.radial} zero: axis of the cam")
    program.comment(f"{axes.rotary} in deg: angle of the cutter on the cam, right-handed about {axes.along};")
    program.comment(f"{axes.rotary} zero: cam angle 0 below the cutter")
    program.add_lines(*(each.replace("G17", axes.plane) for each in program.words.modes), *program.words.turning)


def notes_on_metal_left_by_cutter(work: Workpiece, cutter_radius: float) -> Iterator[str]:
    """Notes on metal that the cutter leaves on walls, and beside a rib."""
    full_radius = work.problem.wall_distance_from_pitch_curve
    if work.problem.setup.mechanism.further_contacts:
        yield RIB_NOTE
    if full_radius > cutter_radius:
        rest, radius = map(length_with_unit, (full_radius - cutter_radius, full_radius))
        yield f"the cutter leaves {rest} on each wall; a cutter with radius {radius} cuts them to size"
