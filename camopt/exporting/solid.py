"""The cam as a solid in its own frame: x and y as in the profile, z towards the viewer of the front view.

A disc cam is a plate from z = 0 to its thickness, with a hub on the far side of that; bore and keyway go through
both. Its profile is followed by true arcs, by B-splines or by lines, within a deviation that is proved. For a
cylindrical cam see ``camopt.exporting.cylinder``.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from OCP.Standard import Standard_ConstructionError, Standard_Failure
from OCP.StdFail import StdFail_NotDone

from camopt.contour.curve import curves_of
from camopt.contour.follow import check_kind, follow
from camopt.contour.hole import bore_with_keyway
from camopt.exporting import shapes
from camopt.exporting.cylinder import grooved_body
from camopt.exporting.exported import CurveInFile, told
from camopt.exporting.shapes import Shape
from camopt.exporting.workpiece import Workpiece
from camopt.mechanisms.body import CYLINDER, DISC
from camopt.mistakes import BadInput, Mistake
from camopt.scene.part import Part

OVERCUT = 1.0  # mm: by how much a bore is cut longer than the part, at both ends

CAD_ERRORS = (Standard_ConstructionError, Standard_Failure, StdFail_NotDone)
"""What Open CASCADE raises for edges and faces that are none; they have no common base here."""


class CadSolid(NamedTuple):
    """A solid of Open CASCADE, with the report on it."""

    shape: Shape
    curves: Mapping[str, CurveInFile]
    """Of a disc cam its profile, with the deviation that is proved."""
    about: dict[str, Any]


def solid_of(work: Workpiece, chord: float, curves: str) -> CadSolid:
    """The solid of a cam, its profile or groove within ``chord`` mm of the true one.

    Raises
    ------
    BadInput
        For each size of ``[part]`` that a solid needs and the scene has not, for a groove that is undercut at some
        depth, for a ``chord`` as large as a wall, and where Open CASCADE finds that the solid is none.
    """
    mistakes = list(_lacks(work))
    if mistakes:
        raise BadInput(mistakes)
    try:
        found = _MAKERS[work.problem.setup.mechanism.body](work, chord, curves)
    except CAD_ERRORS:
        found = None
    if found is None or not shapes.is_closed(found.shape):
        faults = f"faces cross each other, or are smaller than {shapes.TOUCHING_MM} mm"
        why = f"makes no valid solid at a chord of {chord:g} mm: {faults}"
        raise BadInput([Mistake(work.scene.file, "part", None, why, bare=True)])
    return found._replace(about=found.about | shapes.measures(found.shape))


def _disc(work: Workpiece, chord: float, curves: str) -> CadSolid:
    check_kind(curves, chord)
    profile = follow(curves_of(work.problem)["profile"], curves, chord - shapes.FLAT_ARC)
    profile = profile._replace(deviation=profile.deviation + shapes.FLAT_ARC)
    _check_wall(work, chord, profile.deviation)
    body = _plate(work.part, shapes.closed_wire(profile.path))
    return CadSolid(_with_bore(work.part, body), told({"profile": profile}), {})


def _cylinder(work: Workpiece, chord: float, curves: str) -> CadSolid:
    body, off = grooved_body(work, chord)
    return CadSolid(_with_bore(work.part, body), {}, {"wall_deviation_measured_mm": off})


_MAKERS = {DISC: _disc, CYLINDER: _cylinder}
"""By body."""


def _lacks(work: Workpiece) -> Iterator[Mistake]:
    scene, part, body = work.scene, work.part, work.problem.setup.mechanism.body
    for key in body.solid:
        if getattr(part, key) is None:
            yield Mistake(scene.file, f"part.{key}", None, "missing; a solid needs it", bare=True)
    base = float(work.problem.design.size[0])
    if body.closed and part.bore_reach >= base:
        why = f"must leave a wall to the base circle (radius {base:g}); a bore as wide leaves no solid"
        yield Mistake(scene.file, "cam.shaft_diameter", scene.cam.shaft_diameter, why, bare=True)


def _check_wall(work: Workpiece, chord: float, deviation: float) -> None:
    """BadInput if the profile may be so far off that it meets the bore."""
    wall = float(work.problem.design.size[0]) - work.part.bore_reach
    if deviation >= wall:
        raise BadInput([Mistake("camopt", "chord", chord, f"smaller: the wall about the bore has {wall:.3g} mm")])


def _plate(part: Part, profile: Shape) -> Shape:
    """The plate with its hub."""
    assert part.thickness
    plate = shapes.extruded(profile, 0.0, part.thickness)
    if not part.hub_diameter or not part.hub_length or part.hub_length - part.thickness <= shapes.TOUCHING_MM:
        return plate
    hub = shapes.extruded(shapes.circle_wire(part.hub_diameter / 2), part.thickness, part.hub_length)
    return shapes.fused(plate, hub)


def _with_bore(part: Part, body: Shape) -> Shape:
    """A body that stands on z = 0, less its bore and keyway."""
    if not part.bore:
        return body
    outline = shapes.closed_wire(bore_with_keyway(part)) if part.keyway_width else shapes.circle_wire(part.bore / 2)
    whole = max(part.thickness or 0.0, part.hub_length or 0.0)
    return shapes.cut(body, shapes.extruded(outline, -OVERCUT, whole + OVERCUT))
