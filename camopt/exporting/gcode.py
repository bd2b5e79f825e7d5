"""G-code (ISO 6983) for a mill, wire or laser: the path of a cutter's centre round a disc cam, in arcs.

The cutter comes in on a quarter of a circle, tangent to its path, and leaves on another: in the middle of the
longest dwell, where a mark does least harm. Climb milling with a cutter that turns clockwise has the part on its
right.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import isfinite
from pathlib import Path

import numpy as np

from camopt.contour.curve import CamCurve, curves_of
from camopt.contour.deviation import deviation_bound
from camopt.contour.follow import CHORD, Followed, follow
from camopt.contour.path import ArcPath
from camopt.exporting.exported import Export, told
from camopt.exporting.workpiece import Workpiece
from camopt.mistakes import BadInput, Mistake
from camopt.points.points import check_cutter
from camopt.scene.part import Part
from camopt.storage.files import write_text
from camopt.version import VERSION

AXIS_DIGITS, CENTRE_DIGITS = 4, 5  # decimals of mm
LEAST_CHORD = 0.0005  # mm: digits and all
DIGIT_SHARE = 3.0 * 10.0**-AXIS_DIGITS  # mm of the chord that are left to digits
MILLINGS = ("climb", "conventional")
CLEARANCE, OVERRUN = 5.0, 1.0  # mm above and below the plate


def write(
    work: Workpiece,
    path: Path,
    cutter_radius: float | None = None,
    feed: float | None = None,
    depth: float | None = None,
    roughing: float = 0.0,
    direction: str = "climb",
    chord: float = CHORD,
) -> Export:
    """Write a program that cuts the profile; the path in it, digits and all, is proved to be within the chord.

    ``cutter_radius`` in mm and ``feed`` in mm/min are needed. ``depth`` is how far below its top face the plate is
    cut, its thickness and 1 mm more if not given, or no more where a hub is below; with neither, the program has no
    Z, as for wires and lasers. ``roughing`` is what a first cut leaves (mm). Quarter circles have the radius of the
    cutter.
    """
    depth = _through(work.part) if depth is None else depth
    _check(work, cutter_radius, feed, depth, roughing, direction, chord)
    assert cutter_radius is not None
    assert feed is not None
    check_cutter(work.problem, cutter_radius)
    finished = curves_of(work.problem, cutter_radius)["cutter"]
    cuts = {"roughing": finished.distance + roughing} if roughing else {}
    cuts |= {"cutter": finished.distance}
    followed = {name: _rounded(replace(finished, distance=each), chord) for name, each in cuts.items()}
    lines = [
        f"({_plain(work.part.name or 'cam')})",
        f"(camopt {VERSION}; cutter radius {cutter_radius:g} mm, {direction} milling)",
        *(f"({name}: {len(each.path)} arcs, within {each.deviation:.6f} mm)" for name, each in followed.items()),
        "(zero: centre of the cam, top face of the plate, a hub below it; X and Y as in the cam's drawing)",
        "G21 G17 G90 G94 G40",
    ]
    if depth is not None:
        lines.append(f"G0 Z{CLEARANCE:g}")
    for each in followed.values():
        assert isinstance(each.path, ArcPath)
        wanted = (direction == "climb") == (work.problem.design.sense > 0)  # the path of a ccw cam runs clockwise
        lines += _cut(each.path if wanted else each.path.backwards, cutter_radius, depth, feed)
    write_text(path, "\n".join([*lines, "M30"]) + "\n")
    notes = () if depth is not None else ("neither a depth nor part.thickness is given: the program has no Z",)
    return Export(path, told(followed), notes=notes)


def _through(part: Part) -> float | None:
    """How deep the plate is cut, if its thickness is known: a little more, but not beside a hub."""
    return part.thickness if part.thickness is None or part.stands_on_hub else part.thickness + OVERRUN


def _check(
    work: Workpiece,
    cutter_radius: float | None,
    feed: float | None,
    depth: float | None,
    roughing: float,
    direction: str,
    chord: float,
) -> None:
    """BadInput for settings that are missing or out of range."""
    mistakes = []
    if work.problem.setup.mechanism.body.developed:
        why = "written for disc cams; a groove is cut from its .dxf, .csv or .step"
        mistakes.append(Mistake("camopt", "file", "….nc", why))
    for name, value in (("cutter_radius", cutter_radius), ("feed", feed)):
        if value is None:
            mistakes.append(Mistake("camopt", name, None, "missing: a .nc file needs it", bare=True))
    for name, value in (("feed", feed), ("depth", depth)):
        if value is not None and not (isfinite(value) and value > 0.0):
            mistakes.append(Mistake("camopt", name, value, "above 0"))
    part = work.part
    if depth is not None and part.thickness is not None and part.stands_on_hub and depth > part.thickness:
        mistakes.append(
            Mistake("camopt", "depth", depth, f"at most part.thickness ({part.thickness:g} mm): a hub is below")
        )
    if not 0.0 <= roughing <= 1e3:
        mistakes.append(Mistake("camopt", "roughing", roughing, "from 0 to 1000 mm"))
    if direction not in MILLINGS:
        mistakes.append(Mistake("camopt", "direction", direction, f"one of {', '.join(MILLINGS)}"))
    if not chord >= LEAST_CHORD:
        why = f"at least {LEAST_CHORD:g} mm: a program has {AXIS_DIGITS} decimals"
        mistakes.append(Mistake("camopt", "chord", chord, why))
    if mistakes:
        raise BadInput(mistakes)


def _plain(text: str) -> str:
    """A comment that any control takes."""
    return text.encode("ascii", "replace").decode().replace("(", "[").replace(")", "]")


def _rounded(curve: CamCurve, chord: float) -> Followed:
    """The path rounded to the digits of the program, and its deviation with the rounding of centres included."""
    found = follow(curve, "arcs", chord - DIGIT_SHARE).path
    assert isinstance(found, ArcPath)
    path = _from_dwell(found, curve)
    vertices = np.round(path.vertices.real, AXIS_DIGITS) + 1j * np.round(path.vertices.imag, AXIS_DIGITS)
    flat = np.abs(path.bulges * path.chords) / 2 < 10.0**-AXIS_DIGITS / 2
    path = replace(path, vertices=vertices, bulges=np.where(flat, 0.0, path.bulges))
    digits = 10.0**-CENTRE_DIGITS
    return Followed(path, deviation_bound(curve, path, chord - digits) + digits)


def _from_dwell(path: ArcPath, curve: CamCurve) -> ArcPath:
    """The closed path from the middle of the longest arc of a dwell on; as it is without dwells."""
    dwells = [k for k, span in enumerate(path.spans) if curve.spans[span].piece is None]
    if not dwells:
        return path
    longest = max(dwells, key=lambda k: float(np.abs(path.chords[k])))
    return path.halved(longest).starting(longest + 1)


def _cut(path: ArcPath, lead: float, depth: float | None, feed: float) -> Iterator[str]:
    """Down beside the part, round it, and up again."""
    around = np.sign((path.vertices[:-1].conjugate() * path.vertices[1:]).imag.sum())  # 1 anticlockwise
    start, tangent = path.vertices[0], path.tangents[0][0]
    outwards = -1j * around * tangent
    middle = start + lead * outwards
    before, after = middle - lead * tangent, middle + lead * tangent
    turn = 1.0 if around < 0 else -1.0  # the quarter circles bend away from the part
    quarter = turn * np.tan(np.pi / 8)
    yield f"G0 {_xy(before)}"
    if depth is not None:
        yield f"G1 Z{-depth:g} F{feed:g}"
    yield f"{_arc(before, start, quarter)} F{feed:g}"
    for one, other, bulge in zip(path.vertices, path.vertices[1:], path.bulges, strict=False):
        yield _arc(one, other, bulge)
    yield _arc(start, after, quarter)
    if depth is not None:
        yield f"G0 Z{CLEARANCE:g}"


def _arc(start: complex, end: complex, bulge: float) -> str:
    """One move of the machine; the centre of an arc is relative to its start."""
    if not bulge:
        return f"G1 {_xy(end)}"
    centre = (end - start) * (0.5 + 0.25j * (1.0 / bulge - bulge))
    i, j = (_number(part, CENTRE_DIGITS) for part in (centre.real, centre.imag))
    return f"G{3 if bulge > 0 else 2} {_xy(end)} I{i} J{j}"


def _xy(point: complex) -> str:
    return f"X{_number(point.real, AXIS_DIGITS)} Y{_number(point.imag, AXIS_DIGITS)}"


def _number(value: float, digits: int) -> str:
    return f"{value + 0.0:.{digits}f}".replace("-0." + "0" * digits, "0." + "0" * digits)
