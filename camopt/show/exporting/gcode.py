"""Programs for a mill, wire or laser: the path of a cutter's centre round a disc cam, or in its groove, in arcs.

The cutter goes down outside of the blank. It enters and leaves its path on quarter circles, tangent to the path, in
the middle of the longest dwell, where a mark does least harm. In climb milling with a clockwise cutter, the part is
on its right. Round a rib the cutter does the same, and then goes round the inner flank. Into a groove it plunges. A
cutter as wide as the groove goes once along the middle. A narrower one then goes on quarter circles to the inner
and the outer wall. The module ``program`` has the words of each control.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import NamedTuple

import numpy as np
from shapely import LineString, Point, Polygon

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import ComplexArray
from camopt.core.quantities.unit_systems import MM, shown_system
from camopt.core.storage.files import write_text
from camopt.core.storage.version import VERSION
from camopt.show.exporting.cam_points import check_cutter
from camopt.show.exporting.groove_program import write_groove
from camopt.show.exporting.machining import (
    ALLOWED_DECIMALS,
    CLEARANCE,
    LARGEST_RADIUS,
    RIB_NOTE,
    Milling,
    last_decimal_in_mm,
    least_chord,
    length_with_unit,
)
from camopt.show.exporting.program import CONTROL_BY_SUFFIX, CONTROL_DIALECTS, Program
from camopt.show.exporting.workpiece import Export, Workpiece, curves_in_file
from camopt.solve.contour.curve import CamCurve
from camopt.solve.contour.deviation import deviation_upper_bound
from camopt.solve.contour.path import ArcPath
from camopt.solve.contour.path_fitting import DEFAULT_CHORD, FittedPath, fit_path

DIGIT_SHARE = 3.0  # last digits: part of the chord for rounding
DEPTH_OVERRUN, BLANK_CLEARANCE = 1.0, 2.0  # mm below the plate, and between cutter and blank
LEAST_CUTTER_SHARE = 1.0 / 3.0  # of the roller: cuts along the middle and both walls then leave nothing between
OUTLINE_POINTS = 32  # points on each arc for checks of the approach
FREE_SHARE = 1e-3  # share of a quarter circle not checked: it touches the path


def write(  # noqa: PLR0913
    work: Workpiece,
    path: Path,
    cutter_radius: float | None = None,
    feed: float | None = None,
    depth: float | None = None,
    roughing: float = 0.0,
    direction: str = "climb",
    chord: float | None = None,
    control: str | None = None,
    decimals: int | None = None,
    tool: int | None = None,
    spindle: float | None = None,
    coolant: bool = False,
    roughing_feed: float | None = None,
    depth_step: float | None = None,
    blank_diameter: float | None = None,
    largest_radius: float = LARGEST_RADIUS,
    rotary: str | None = None,
) -> Export:
    """Write a program that cuts the profile of a disc cam, the groove or rib on its face, or that of a cylinder.

    The paths in the program, with rounded digits, are proved to be within the chord. ``cutter_radius`` [mm] and
    ``feed`` [mm/min] are required. ``depth`` [mm] is measured from the top face of the plate. Default: the depth of
    the groove, or 1 mm more than the thickness, but not into a hub below. If these are unknown, the program has no
    Z, as for wires and lasers. ``roughing`` [mm] is the metal that roughing cuts leave, with ``roughing_feed`` if
    set. Roughing cuts, or the only cuts, go down by at most ``depth_step`` [mm]. The blank is a disc of
    ``blank_diameter``, by default as wide as the cam. ``control`` is one of ``CONTROL_DIALECTS``, by default that
    of the ending; ``decimals`` are those of coordinates. Arcs with a radius above ``largest_radius`` [mm] are
    written as lines. ``tool`` is the tool number, ``spindle`` its speed [rev/min]. The default chord is 0.001 mm,
    or five units of the last decimal. The program is in the shown unit, mm or inch.

    The groove of a cylinder is cut while the cam turns about the axis ``rotary`` of the machine, "A" or "C"
    (``groove_program``). Its cutter has the radius of the roller; a smaller one roughs.
    """
    control = CONTROL_BY_SUFFIX[path.suffix.lower()] if control is None else control
    if decimals is None and control in CONTROL_DIALECTS:  # one more in inch, the longer unit
        decimals = CONTROL_DIALECTS[control].decimals + int(shown_system() != MM)
    decimals = ALLOWED_DECIMALS[0] if decimals is None else decimals  # of an unknown control, which is refused
    chord = max(DEFAULT_CHORD, least_chord(decimals)) if chord is None else chord
    settings = Milling(**{name: value for name, value in locals().items() if name not in ("work", "path")})
    return (write_groove if work.problem.setup.mechanism.body.developed else _write_in_plane)(work, path, settings)


def _write_in_plane(work: Workpiece, path: Path, settings: Milling) -> Export:
    """Write a program that cuts the profile of a disc cam, or the groove or rib on its face."""
    mechanism, thickness = work.problem.setup.mechanism, work.part.thickness
    if settings.depth is None and mechanism.body.flank_height:
        settings = replace(settings, depth=work.flank_height)
    elif settings.depth is None and thickness is not None:  # through the plate, but not into parts below
        settings = replace(settings, depth=thickness + min(DEPTH_OVERRUN, work.free_depth_below_plate / 2))
    _check_milling(work, settings)
    assert settings.cutter_radius is not None
    assert settings.feed is not None
    for disc in work.discs:
        check_cutter(disc.problem, settings.cutter_radius)
    cuts_of = (
        _groove_cuts if mechanism.has_flanks_on_both_sides else _rib_cuts if mechanism.has_rib else _profile_cuts
    )
    planned = cuts_of(work, settings.cutter_radius, settings.roughing)
    rounding = settings.chord, last_decimal_in_mm(settings.decimals), settings.largest_radius
    cuts = {
        name: _fit_and_round_path(cut.curve, *rounding, work.is_cut_from_behind) for name, cut in planned.items()
    }
    around = {name: cut for name, cut in cuts.items() if not planned[name].within}
    blank = settings.blank_diameter or (work.part.outer_diameter if mechanism.has_rib else None)
    outside = _axis_distance_outside_blank(around, settings.cutter_radius, blank) if around else None
    program = Program(CONTROL_DIALECTS[settings.control], settings.decimals)
    how = f"cutter radius {length_with_unit(settings.cutter_radius, 'g')}, {settings.direction} milling"
    _write_head(program, work, cuts, how)
    program.start_cutter(settings.tool, settings.spindle, settings.coolant)
    clear = CLEARANCE + work.hub_height_above_plate
    if settings.depth is not None and not program.at_change_height:
        program.move_cutter_to_height(clear)
    feeds, deep = {"roughing": settings.roughing_feed or settings.feed}, set[bool]()
    for name, each in cuts.items():
        assert isinstance(each.path, ArcPath)
        right = each.path.is_anticlockwise == (planned[name].side < 0.0)
        followed = each.path if (settings.direction == "climb") == right else each.path.reversed_path
        feed = feeds.get(name.partition("_")[0], settings.feed)
        within = planned[name].within
        way = _CutterWay(followed, planned[name], None if within else outside, feed)
        _check_approach(way, each)
        for level in settings.cut_depths[-1:] if within in deep else settings.cut_depths:
            way.write(program, level, clear)
        deep.add(within)
    program.stop_cutter_and_end(settings.spindle, settings.coolant)
    write_text(path, program.text())
    flat = (
        ("the program has no Z, because neither depth nor the thickness of the part is set",)
        if settings.depth is None
        else ()
    )
    rib_notes = (RIB_NOTE,) if mechanism.has_rib else ()
    return Export(path, curves_in_file(cuts), notes=(*flat, *settings.notes_on_missing_actions, *rib_notes))


# ----------------------------------------------------------------------------------------------------- settings


def _check_milling(work: Workpiece, settings: Milling) -> None:
    """Raise BadInput for settings that are missing or out of range."""
    mistakes, part = list(settings.mistakes), work.part
    if settings.rotary is not None:
        why = "has no meaning for a disc cam: it is cut in a plane"
        mistakes.append(Mistake("camopt", "rotary", settings.rotary, why, bare=True))
    if work.problem.setup.mechanism.has_flanks_on_both_sides:
        half, cutter = work.problem.wall_distance_from_pitch_curve, settings.cutter_radius
        if settings.blank_diameter is not None:
            why = "has no meaning for a groove"
            mistakes.append(Mistake("camopt", "blank_diameter", settings.blank_diameter, why, bare=True))
        if cutter is not None and 0.0 < cutter < half * LEAST_CUTTER_SHARE:
            why = f"at least {half * LEAST_CUTTER_SHARE:.6g} mm, a third of the roller radius; "
            why += "a smaller cutter leaves steel in the groove"
            mistakes.append(Mistake("camopt", "cutter_radius", cutter, why))
        elif cutter is not None and settings.roughing > 0.0 and settings.roughing >= half - cutter:
            why = f"below {half - cutter:.6g} mm, the difference of the radii of roller and cutter"
            mistakes.append(Mistake("camopt", "roughing", settings.roughing, why))
    high, key = work.flank_height, work.problem.setup.mechanism.body.flank_height
    if settings.depth is not None and high is not None and settings.depth > high:
        mistakes.append(Mistake("camopt", "depth", settings.depth, f"at most part.{key} ({high:g} mm)"))
    if settings.depth is not None and settings.depth > (
        most := (part.thickness or inf) + work.free_depth_below_plate
    ):
        below = "the hub" if work.disc is None else "the other disc"
        mistakes.append(
            Mistake("camopt", "depth", settings.depth, f"at most {most:g} mm: a deeper cut reaches {below}")
        )
    if mistakes:
        raise BadInput(mistakes)


# --------------------------------------------------------------------------------------------------------- path


class _Cut(NamedTuple):
    """A cut along a curve of the cutter's centre."""

    curve: CamCurve
    lead: float
    """Radius of the quarter circles of approach and retreat [mm]."""
    side: float = 1.0
    """1 if the part is inside the path, −1 if it is outside."""
    within: bool = False
    """Whether the cutter plunges into the part, not outside of the blank."""


def _profile_cuts(work: Workpiece, cutter_radius: float, roughing: float) -> dict[str, _Cut]:
    """Cuts round a cam by name; the last one is on the profile."""
    curve = work.only_disc.curves(cutter_radius)["cutter"]
    cuts = {"roughing": replace(curve, distance=curve.distance + roughing)} if roughing else {}
    return {name: _Cut(each, cutter_radius) for name, each in (cuts | {"cutter": curve}).items()}


def _groove_cuts(work: Workpiece, cutter_radius: float, roughing: float) -> dict[str, _Cut]:
    """Cuts in a groove by name: along its middle, and for a narrower cutter along both walls."""
    pitch = work.only_disc.curves()["pitch"]
    room = work.problem.wall_distance_from_pitch_curve - cutter_radius
    cuts = {"middle": _Cut(pitch, 0.0, within=True)}
    for name, left in {"roughing": roughing, "cutter": 0.0}.items() if room else ():
        for flank in work.problem.setup.mechanism.flanks if left or name == "cutter" else ():
            curve = replace(pitch, distance=flank.side * (room - left))
            cuts[f"{name}_{flank.name}"] = _Cut(curve, room - left, -flank.side, within=True)
    return cuts


def _rib_cuts(work: Workpiece, cutter_radius: float, roughing: float) -> dict[str, _Cut]:
    """Cuts round a rib by name: along its outer and inner flank, roughing cuts first."""
    curves, cuts = work.curves(cutter_radius), dict[str, _Cut]()
    for name, left in {"roughing": roughing, "cutter": 0.0}.items():
        for place, disc in zip(("outer", "inner"), work.discs, strict=True) if left or name == "cutter" else ():
            curve, side = curves[f"{disc.curve_name_prefix}cutter"], disc.problem.setup.mechanism.flanks[0].side
            curve = replace(curve, distance=curve.distance - side * left)
            cuts[f"{name}_{place}"] = _Cut(curve, cutter_radius, -side, within=side > 0.0)
    return cuts


def _fit_and_round_path(
    curve: CamCurve, chord: float, digit_mm: float, largest_radius: float, from_behind: bool
) -> FittedPath:
    """The path rounded to the digits of the program, and its deviation, with rounding of the centres included."""
    fitted = fit_path(curve, "arcs", chord - DIGIT_SHARE * digit_mm).path
    assert isinstance(fitted, ArcPath)
    dwells = [k for k, span in enumerate(fitted.spans) if curve.spans[span].is_dwell]
    if dwells:  # start in the middle of the longest one
        longest = dwells[int(np.argmax(np.abs(fitted.chords[dwells])))]
        fitted = fitted.divide_arcs(np.where(np.arange(len(fitted)) == longest, 2, 1)).start_at_vertex(longest + 1)
    path = _straighten_wide_arcs(curve, fitted, digit_mm, largest_radius)
    vertices = (
        np.round(path.vertices.real / digit_mm) * digit_mm + 1j * np.round(path.vertices.imag / digit_mm) * digit_mm
    )
    flat = np.abs(path.bulges * path.chords) / 2 < digit_mm / 2
    path = replace(path, vertices=vertices, bulges=np.where(flat, 0.0, path.bulges))
    seen = path.mirrored_path if from_behind else path
    return FittedPath(seen, deviation_upper_bound(curve, path, chord - digit_mm) + digit_mm)


def _straighten_wide_arcs(curve: CamCurve, path: ArcPath, digit_mm: float, largest_radius: float) -> ArcPath:
    """The path with arcs above the largest radius as lines between points of the curve, within one digit."""
    with np.errstate(divide="ignore"):
        radii = 1.0 / np.abs(path.curvatures)
    wide = radii > largest_radius
    counts = np.where(wide, np.ceil(np.sqrt(np.abs(path.chords * path.bulges) / (2.0 * digit_mm))), 1.0)
    counts = np.maximum(counts, 1.0).astype(int)
    fine, straight = path.divide_arcs(counts), np.repeat(wide, counts)
    inside = straight & (fine.angles[:, 0] != np.repeat(path.angles[:, 0], counts))
    vertices = fine.vertices.copy()
    vertices[:-1][inside] = curve.evaluate_by_span(fine.angles[inside, 0], curve.points) if inside.any() else ()
    return replace(fine, vertices=vertices, bulges=np.where(straight, 0.0, fine.bulges))


def _axis_distance_outside_blank(
    cuts: Mapping[str, FittedPath], cutter_radius: float, blank_diameter: float | None
) -> float:
    """Distance from the axis at which the cutter is outside of the blank [mm]."""
    reaches = [float(np.abs(_dense_path_points(each)).max()) for each in cuts.values()]
    cam = 2.0 * (reaches[-1] - cutter_radius)
    if blank_diameter is not None and blank_diameter < cam:
        raise BadInput(
            [Mistake("camopt", "blank_diameter", blank_diameter, f"at least {cam:.6g} mm, the diameter of the cam")]
        )
    return max(*reaches, (blank_diameter or 0.0) / 2 + cutter_radius) + BLANK_CLEARANCE


def _dense_path_points(fitted_path: FittedPath) -> ComplexArray:
    """Dense points of a path."""
    path = fitted_path.path
    assert isinstance(path, ArcPath)
    return path.divide_arcs(np.full(len(path), OUTLINE_POINTS)).vertices


def _check_approach(way: "_CutterWay", fitted_path: FittedPath) -> None:
    """Raise BadInput if the cutter meets the part on its straight way from or to outside of the blank.

    Or on the quarter circles of approach and retreat, if it plunges inside of its path.
    """
    points, (before, after, _) = _dense_path_points(fitted_path), way.approach_and_retreat_ends
    outline = Polygon(np.column_stack([points.real, points.imag]))
    if way.outside is None:
        place, middle, reach = "quarter circle of approach", (before + after) / 2, way.cut.lead * (1.0 - FREE_SHARE)
        hits = way.cut.side < 0.0 and not outline.contains(Point(middle.real, middle.imag).buffer(reach))
    else:
        place = "straight way from outside of the blank"
        ends = [(inner, way.point_outside_blank(inner)) for inner in (before, after)]
        hits = any(outline.intersects(LineString([(z.real, z.imag) for z in line])) for line in ends)
    if hits:
        why = f"smaller: on its {place}, this cutter would meet the part"
        raise BadInput([Mistake("camopt", "cutter_radius", way.cut.lead, why)])


class _CutterWay(NamedTuple):
    """The way of the cutter round the part, from outside of the blank and back."""

    path: ArcPath
    cut: _Cut
    outside: float | None
    """Distance from the axis outside of the blank [mm]; None for a cutter that plunges."""
    feed: float

    @property
    def approach_and_retreat_ends(self) -> tuple[complex, complex, float]:
        """Start and end of the quarter circles, and their bulge; they bend away from the part."""
        start, tangent = self.path.vertices[0], self.path.tangents[0][0]
        around, lead = self.cut.side if self.path.is_anticlockwise else -self.cut.side, self.cut.lead
        middle = start - 1j * around * tangent * lead
        return middle - lead * tangent, middle + lead * tangent, -around * np.tan(np.pi / 8)

    def point_outside_blank(self, point: complex) -> complex:
        """The point outside of the blank, in the same direction; the same point if the cutter plunges."""
        if self.outside is None:
            return point
        return point / abs(point) * max(self.outside, abs(point))

    def write(self, program: Program, depth: float | None, clear_height: float) -> None:
        """Go down outside of the blank or into the groove, cut along the path, and go up to ``clear_height``."""
        start, (before, after, quarter) = self.path.vertices[0], self.approach_and_retreat_ends
        program.rapid(self.point_outside_blank(before))
        if depth is not None:
            if clear_height > CLEARANCE or program.at_change_height:  # above a hub, which is not here
                program.move_cutter_to_height(CLEARANCE)
                program.at_change_height = False
            program.move_cutter_to_height(-depth, self.feed)
        program.line(before, self.feed)
        program.arc(before, start, quarter, self.feed)
        for one, other, bulge in zip(self.path.vertices, self.path.vertices[1:], self.path.bulges, strict=False):
            program.arc(one, other, bulge, self.feed)
        program.arc(start, after, quarter, self.feed)
        program.line(self.point_outside_blank(after), self.feed)
        if depth is not None:
            program.move_cutter_to_height(clear_height)


def _write_head(program: Program, work: Workpiece, cuts: Mapping[str, FittedPath], cut_description: str) -> None:
    """Write the head of the program: part, deviations, zero point, timing mark and keyway."""
    program.add_lines(*program.words.start)
    program.comment(work.title)
    program.comment(f"camopt {VERSION}; {cut_description}")
    for name, each in cuts.items():
        program.comment(
            f"{name}: {len(each.path)} {each.path.element_kind}, within {length_with_unit(each.deviation, '.6f')}"
        )
    around = (
        f", the hub stands {length_with_unit(work.hub_height_above_plate, 'g')} above it"
        if work.hub_height_above_plate
        else ""
    )
    around += (
        ""
        if work.free_depth_below_plate == inf
        else f", the {'hub' if work.disc is None else 'other disc'} below it"
    )
    program.comment(f"zero: centre of the cam, top face of the plate{around}")
    program.comment(f"X and Y {FROM_BEHIND if work.is_cut_from_behind else AS_DRAWN}")
    anticlockwise, keyway = (work.problem.design.sense > 0.0) != work.is_cut_from_behind, work.part.keyway_angle
    seen = keyway if keyway is None or not work.is_cut_from_behind else 180.0 - keyway
    mark = "" if seen is None else f", keyway at {seen:g} deg from X"
    program.comment(f"timing mark along Y{mark}; the cam turns {'ccw' if anticlockwise else 'cw'}")
    program.add_lines(*program.words.modes)


AS_DRAWN, FROM_BEHIND = "as in the cam's drawing", "from behind the cam's drawing, turned over about Y"
