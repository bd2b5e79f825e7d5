"""Programs for a mill, wire or laser: the path of a cutter's centre round a disc cam, or in its groove, in arcs.

The cutter goes down outside of the blank, comes in on a quarter of a circle, tangent to its path, and leaves on
another: in the middle of the longest dwell, where a mark does least harm. Climb milling with a cutter that turns
clockwise has the part on its right. Round a rib it goes so too, and then within it. Into a groove it plunges. One
as wide as the groove goes once along the middle; a narrower one goes there first, then on quarter circles to the
inner and to the outer wall. The words of each control are in ``program``.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import NamedTuple

import numpy as np
from shapely import LineString, Point, Polygon

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import ComplexArray
from camopt.core.storage.files import write_text
from camopt.core.storage.version import VERSION
from camopt.show.exporting.cam_points import check_cutter
from camopt.show.exporting.groove_program import write_groove
from camopt.show.exporting.machining import (
    CLEARANCE,
    LARGEST_RADIUS,
    RIB_NOTE,
    Milling,
    least_chord,
    length_with_unit,
    usual_decimals,
)
from camopt.show.exporting.program import CONTROL_BY_SUFFIX, CONTROL_DIALECTS, Program
from camopt.show.exporting.workpiece import Export, Workpiece, curves_in_file
from camopt.solve.contour.curve import CamCurve
from camopt.solve.contour.deviation import deviation_bound
from camopt.solve.contour.path import ArcPath
from camopt.solve.contour.path_fitting import DEFAULT_CHORD, FittedPath, fit_path

DIGIT_SHARE = 3.0  # last digits: what of the chord is left to them
DEPTH_OVERRUN, BLANK_CLEARANCE = 1.0, 2.0  # mm below the plate, and between cutter and blank
LEAST_CUTTER_SHARE = (
    1.0 / 3.0
)  # of the roller: cuts along the middle and along both walls leave nothing between them
OUTLINE_POINTS = 32  # points of an arc where it is looked at
FREE_SHARE = 1e-3  # of a quarter circle: it touches the path


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
    """Write a program that cuts the profile of a disc cam, or the groove in its face, or that of a cylinder.

    The paths in it, digits and all, are proved to be within the chord. ``cutter_radius`` in mm and ``feed`` in
    mm/min are needed. ``depth`` is how far below its top face the plate is cut: that of its groove, or its
    thickness and 1 mm more, or no more where a hub is below; with none of them the program has no Z, as for wires
    and lasers. ``roughing`` is what first cuts leave (mm), with ``roughing_feed`` if it is given. First cuts, or
    the last if there are none, go down by ``depth_step`` (mm) at most each time. The blank is a disc of
    ``blank_diameter``, or as wide as the cam. ``control`` is one of ``CONTROL_DIALECTS``, by default that of the
    ending; ``decimals`` are those of its coordinates; arcs of more than ``largest_radius`` (mm) are lines. ``tool``
    is a number, ``spindle`` its speed (rev/min). The chord is 0.001 mm by default, or five of the last decimal.
    Where results are shown in inch, so is the program.

    The groove of a cylinder is cut while the cam turns about an axis of the machine, ``rotary``: "A" or "C"
    (``groove_program``). The radius of its cutter is that of the roller; a smaller one roughs.
    """
    control = CONTROL_BY_SUFFIX[path.suffix.lower()] if control is None else control
    decimals = usual_decimals(control) if decimals is None else decimals
    chord = max(DEFAULT_CHORD, least_chord(decimals)) if chord is None else chord
    asked = Milling(**{name: value for name, value in locals().items() if name not in ("work", "path")})
    return (write_groove if work.problem.setup.mechanism.body.developed else _write_in_plane)(work, path, asked)


def _write_in_plane(work: Workpiece, path: Path, asked: Milling) -> Export:
    """Write a program that cuts the profile of a disc cam, or the groove in its face, or the rib on it."""
    mechanism, key = work.problem.setup.mechanism, work.problem.setup.mechanism.body.flank_height
    usual = getattr(work.part, key) if key else _plate_depth(work)
    asked = asked if asked.depth is not None else replace(asked, depth=usual)
    _check_milling(work, asked)
    assert asked.cutter_radius is not None
    assert asked.feed is not None
    for disc in work.discs:
        check_cutter(disc.problem, asked.cutter_radius)
    cuts_of = _groove_cuts if mechanism.two_sided else _rib_cuts if mechanism.has_rib else _profile_cuts
    made = cuts_of(work, asked.cutter_radius, asked.roughing)
    rounding = asked.chord, asked.last_digit, asked.largest_radius
    cuts = {name: _round_path(cut.curve, *rounding, work.is_cut_from_behind) for name, cut in made.items()}
    around = {name: cut for name, cut in cuts.items() if not made[name].within}
    blank = asked.blank_diameter or (work.part.outer_diameter if mechanism.has_rib else None)
    outside = _outside_radius(around, asked.cutter_radius, blank) if around else None
    program = Program(CONTROL_DIALECTS[asked.control], asked.decimals)
    how = f"cutter radius {length_with_unit(asked.cutter_radius, 'g')}, {asked.direction} milling"
    _write_head(program, work, cuts, how)
    program.start(asked.tool, asked.spindle, asked.coolant)
    clear = CLEARANCE + work.hub_height
    if asked.depth is not None:
        program.raise_cutter(clear)
    feeds, deep = {"roughing": asked.roughing_feed or asked.feed}, set[bool]()
    for name, each in cuts.items():
        assert isinstance(each.path, ArcPath)
        right = each.path.is_anticlockwise == (made[name].side < 0.0)
        followed = each.path if (asked.direction == "climb") == right else each.path.reversed_path
        feed = feeds.get(name.partition("_")[0], asked.feed)
        within = made[name].within
        way = _CutterWay(followed, made[name].lead, made[name].side, None if within else outside, feed)
        (_check_circular_approach if within else _check_straight_approach)(way, each)
        for level in asked.levels[-1:] if within in deep else asked.levels:
            way.cut(program, level, clear)
        deep.add(within)
    program.stop(asked.spindle, asked.coolant)
    write_text(path, program.text())
    flat = ("neither a depth nor that of the part is given: the program has no Z",) if asked.depth is None else ()
    left = (RIB_NOTE,) if mechanism.has_rib else ()
    return Export(path, curves_in_file(cuts), notes=(*flat, *asked.omissions, *left))


def _plate_depth(work: Workpiece) -> float | None:
    """How deep the plate is cut, if its thickness is known: a little more, but not into what is below."""
    thickness = work.part.thickness
    return None if thickness is None else thickness + min(DEPTH_OVERRUN, work.depth_below / 2)


# ----------------------------------------------------------------------------------------------------- settings


def _check_milling(work: Workpiece, asked: Milling) -> None:
    """BadInput for settings that are missing or out of range."""
    mistakes, part = list(asked.mistakes), work.part
    if asked.rotary is not None:
        why = "has no meaning for a disc cam: it is cut in a plane"
        mistakes.append(Mistake("camopt", "rotary", asked.rotary, why, bare=True))
    if work.problem.setup.mechanism.two_sided:
        mistakes += _groove_mistakes(work, asked)
    key = work.problem.setup.mechanism.body.flank_height
    high = getattr(part, key) if key else None
    if asked.depth is not None and high is not None and asked.depth > high:
        mistakes.append(Mistake("camopt", "depth", asked.depth, f"at most part.{key} ({high:g} mm)"))
    if asked.depth is not None and asked.depth > (most := (part.thickness or inf) + work.depth_below):
        below = "a hub" if work.disc is None else "the other disc"
        mistakes.append(Mistake("camopt", "depth", asked.depth, f"at most {most:g} mm: {below} is below"))
    if mistakes:
        raise BadInput(mistakes)


def _groove_mistakes(work: Workpiece, asked: Milling) -> Iterator[Mistake]:
    """A cutter clears a groove along its middle and its walls, to its depth, and leaves no more than there is."""
    half, cutter = work.problem.half_width, asked.cutter_radius
    if asked.blank_diameter is not None:
        yield Mistake("camopt", "blank_diameter", asked.blank_diameter, "means nothing to a groove", bare=True)
    if cutter is not None and 0.0 < cutter < half * LEAST_CUTTER_SHARE:
        least = half * LEAST_CUTTER_SHARE
        why = f"at least {least:.6g} mm, a third of the roller's, or it leaves steel in the groove"
        yield Mistake("camopt", "cutter_radius", cutter, why)
    elif cutter is not None and asked.roughing > 0.0 and asked.roughing >= half - cutter:
        why = f"below {half - cutter:.6g} mm, by which the cutter is narrower than the groove on either side"
        yield Mistake("camopt", "roughing", asked.roughing, why)


# --------------------------------------------------------------------------------------------------------- path


class _Cut(NamedTuple):
    """A cut along a curve of the cutter's centre."""

    curve: CamCurve
    lead: float
    """Radius of the quarter circles on which the cutter comes and goes, mm."""
    side: float = 1.0
    """1 where what is left of the part is inside the path, −1 where it is outside."""
    within: bool = False
    """Whether the cutter goes down within the part, and not outside of the blank."""


def _profile_cuts(work: Workpiece, cutter_radius: float, roughing: float) -> dict[str, _Cut]:
    """The cuts round a cam by name, the last one on the profile."""
    curve = work.only_disc.curves(cutter_radius)["cutter"]
    cuts = {"roughing": replace(curve, distance=curve.distance + roughing)} if roughing else {}
    return {name: _Cut(each, cutter_radius) for name, each in (cuts | {"cutter": curve}).items()}


def _groove_cuts(work: Workpiece, cutter_radius: float, roughing: float) -> dict[str, _Cut]:
    """The cuts in a groove by name: along its middle, and for a narrower cutter along both walls."""
    pitch = work.only_disc.curves()["pitch"]
    room = work.problem.half_width - cutter_radius
    cuts = {"middle": _Cut(pitch, 0.0, within=True)}
    for name, left in {"roughing": roughing, "cutter": 0.0}.items() if room else ():
        for flank in work.problem.setup.mechanism.flanks if left or name == "cutter" else ():
            curve = replace(pitch, distance=flank.side * (room - left))
            cuts[f"{name}_{flank.name}"] = _Cut(curve, room - left, -flank.side, within=True)
    return cuts


def _rib_cuts(work: Workpiece, cutter_radius: float, roughing: float) -> dict[str, _Cut]:
    """The cuts about a rib by name: along its outer and its inner flank, first with what the last ones take."""
    curves, cuts = work.curves(cutter_radius), dict[str, _Cut]()
    for name, left in {"roughing": roughing, "cutter": 0.0}.items():
        for place, disc in zip(("outer", "inner"), work.discs, strict=True) if left or name == "cutter" else ():
            curve, side = curves[f"{disc.prefix}cutter"], disc.problem.setup.mechanism.flanks[0].side
            curve = replace(curve, distance=curve.distance - side * left)
            cuts[f"{name}_{place}"] = _Cut(curve, cutter_radius, -side, within=side > 0.0)
    return cuts


def _round_path(curve: CamCurve, chord: float, digit: float, largest: float, from_behind: bool) -> FittedPath:
    """The path with the digits of the program, and its deviation, what the centres' digits add included."""
    found = fit_path(curve, "arcs", chord - DIGIT_SHARE * digit).path
    assert isinstance(found, ArcPath)
    path = _straighten_wide_arcs(curve, _start_in_dwell(found, curve), digit, largest)
    vertices = np.round(path.vertices.real / digit) * digit + 1j * np.round(path.vertices.imag / digit) * digit
    flat = np.abs(path.bulges * path.chords) / 2 < digit / 2
    path = replace(path, vertices=vertices, bulges=np.where(flat, 0.0, path.bulges))
    seen = path.mirrored_path if from_behind else path
    return FittedPath(seen, deviation_bound(curve, path, chord - digit) + digit)


def _straighten_wide_arcs(curve: CamCurve, path: ArcPath, digit: float, largest: float) -> ArcPath:
    """The path with arcs of more than the largest radius as lines between points of the curve, a digit off it."""
    with np.errstate(divide="ignore"):
        radii = 1.0 / np.abs(path.curvatures)
    wide = radii > largest
    counts = np.where(wide, np.ceil(np.sqrt(np.abs(path.chords * path.bulges) / (2.0 * digit))), 1.0)
    counts = np.maximum(counts, 1.0).astype(int)
    fine, straight = path.divide_arcs(counts), np.repeat(wide, counts)
    inside = straight & (fine.angles[:, 0] != np.repeat(path.angles[:, 0], counts))
    vertices = fine.vertices.copy()
    vertices[:-1][inside] = curve.evaluate_by_span(fine.angles[inside, 0], curve.points) if inside.any() else ()
    return replace(fine, vertices=vertices, bulges=np.where(straight, 0.0, fine.bulges))


def _start_in_dwell(path: ArcPath, curve: CamCurve) -> ArcPath:
    """The closed path from the middle of the longest arc of a dwell on; as it is without dwells."""
    dwells = [k for k, span in enumerate(path.spans) if curve.spans[span].is_dwell]
    if not dwells:
        return path
    longest = max(dwells, key=lambda k: float(np.abs(path.chords[k])))
    return path.divide_arcs(np.where(np.arange(len(path)) == longest, 2, 1)).start_at_vertex(longest + 1)


def _outside_radius(cuts: Mapping[str, FittedPath], cutter_radius: float, blank_diameter: float | None) -> float:
    """The distance from the axis at which the cutter's centre is outside of the blank, mm."""
    reaches = [float(np.abs(_path_points(each)).max()) for each in cuts.values()]
    cam = 2.0 * (reaches[-1] - cutter_radius)
    if blank_diameter is not None and blank_diameter < cam:
        raise BadInput(
            [Mistake("camopt", "blank_diameter", blank_diameter, f"at least {cam:.6g} mm: the cam is as wide")]
        )
    return max(*reaches, (blank_diameter or 0.0) / 2 + cutter_radius) + BLANK_CLEARANCE


def _path_points(followed: FittedPath) -> ComplexArray:
    """Dense points of a path."""
    path = followed.path
    assert isinstance(path, ArcPath)
    return path.divide_arcs(np.full(len(path), OUTLINE_POINTS)).vertices


def _check_straight_approach(way: "_CutterWay", followed: FittedPath) -> None:
    """BadInput if the cutter cannot come in straight from outside, or go out, without meeting the part."""
    part = Polygon(np.column_stack([(points := _path_points(followed)).real, points.imag]))
    for inner in way.ends[:2]:
        outer = way.point_outside(inner)
        if part.intersects(LineString([(inner.real, inner.imag), (outer.real, outer.imag)])):
            why = "smaller: a cutter that comes in straight from outside of the blank would meet the part"
            raise BadInput([Mistake("camopt", "cutter_radius", way.lead, why)])


def _check_circular_approach(way: "_CutterWay", followed: FittedPath) -> None:
    """BadInput if the quarter circles on which the cutter comes and goes within the part meet it."""
    points = _path_points(followed)
    room, reach = Polygon(np.column_stack([points.real, points.imag])), way.lead * (1.0 - FREE_SHARE)
    middle = (way.ends[0] + way.ends[1]) / 2
    if way.side < 0.0 and way.outside is None and not room.contains(Point(middle.real, middle.imag).buffer(reach)):
        why = "smaller: one that comes in on a quarter circle of its radius would meet the part"
        raise BadInput([Mistake("camopt", "cutter_radius", way.lead, why)])


class _CutterWay(NamedTuple):
    """A way round the part, from outside of the blank and back."""

    path: ArcPath
    lead: float
    """Radius of the quarter circles, mm."""
    side: float
    """1 where the part is inside the path, −1 where it is outside."""
    outside: float | None
    """How far from the axis the cutter is outside of the blank, mm; None for one that plunges."""
    feed: float

    @property
    def ends(self) -> tuple[complex, complex, float]:
        """Where the quarter circles begin and end, and their bulge: they bend away from the part."""
        start, tangent = self.path.vertices[0], self.path.tangents[0][0]
        around = self.side if self.path.is_anticlockwise else -self.side
        middle = start - 1j * around * tangent * self.lead
        return middle - self.lead * tangent, middle + self.lead * tangent, -around * np.tan(np.pi / 8)

    def point_outside(self, point: complex) -> complex:
        """The point outside of the blank in the same direction from the axis; that itself for one that plunges."""
        if self.outside is None:
            return point
        return point / abs(point) * max(self.outside, abs(point))

    def cut(self, program: Program, depth: float | None, clear: float) -> None:
        """Down, outside of the blank or into the groove, along the path, and up again to where all is clear."""
        start, (before, after, quarter) = self.path.vertices[0], self.ends
        program.rapid(self.point_outside(before))
        if depth is not None:
            if clear > CLEARANCE:  # of a hub that stands out in front, and not here
                program.raise_cutter(CLEARANCE)
            program.lower_cutter(-depth, self.feed)
        program.line(before, self.feed)
        program.arc(before, start, quarter, self.feed)
        program.follow_path(self.path, self.feed)
        program.arc(start, after, quarter, self.feed)
        program.line(self.point_outside(after), self.feed)
        if depth is not None:
            program.raise_cutter(clear)


def _write_head(program: Program, work: Workpiece, cuts: Mapping[str, FittedPath], how: str) -> None:
    """The head of the program: what it is of, what is about the plate, and how timing mark and keyway are seen."""
    program.add_lines(*program.words.start)
    program.comment(work.title)
    program.comment(f"camopt {VERSION}; {how}")
    for name, each in cuts.items():
        program.comment(
            f"{name}: {len(each.path)} {each.path.element_kind}, within {length_with_unit(each.deviation, '.6f')}"
        )
    around = f", the hub stands {length_with_unit(work.hub_height, 'g')} above it" if work.hub_height else ""
    around += "" if work.depth_below == inf else f", the {'hub' if work.disc is None else 'other disc'} below it"
    program.comment(f"zero: centre of the cam, top face of the plate{around}")
    program.comment(f"X and Y {FROM_BEHIND if work.is_cut_from_behind else AS_DRAWN}")
    anticlockwise, keyway = (work.problem.design.sense > 0.0) != work.is_cut_from_behind, work.part.keyway_angle
    seen = keyway if keyway is None or not work.is_cut_from_behind else 180.0 - keyway
    mark = "" if seen is None else f", keyway at {seen:g} deg from X"
    program.comment(f"timing mark along Y{mark}; the cam turns {'ccw' if anticlockwise else 'cw'}")
    program.add_lines(*program.words.modes)


AS_DRAWN, FROM_BEHIND = "as in the cam's drawing", "from behind the cam's drawing, turned over about Y"
