"""The cam as a solid in its own frame: x and y as in the profile, z towards the viewer of the front view.

A disc cam is a plate from z = 0 to its thickness, with a hub on the side of larger z. Bore and keyway go through
both. In a conjugate pair, the second disc stands on z = 0, and the first disc in front of it with a gap
(``Part.plate_extents``). With a hub, both discs are one solid, which cannot twist. Without a hub they are two
solids, each keyed to the shaft. An export of the first disc alone has the whole hub, one of the second disc has
none. A groove or rib is on the face at larger z of a round plate. Profiles and walls are true arcs, B-splines or
lines, within a proven deviation. For cylinders see ``camopt.show.exporting.cylinder``.
"""

from collections.abc import Iterator, Mapping
from functools import reduce
from itertools import pairwise
from typing import Any, NamedTuple

from OCP.Standard import Standard_ConstructionError, Standard_Failure
from OCP.StdFail import StdFail_NotDone

from camopt.core.mistakes import BadInput, Mistake
from camopt.model.effects import EvaluationBlock
from camopt.model.effects.outline import OUTER_RADIUS
from camopt.model.mechanisms.elements import CYLINDER, DISC, FACE_GROOVE, RIBBED_CYLINDER, RIBBED_DISC
from camopt.scene.part import Part
from camopt.show.exporting import shapes
from camopt.show.exporting.cylinder import grooved_body_and_wall_deviation
from camopt.show.exporting.shapes import CadShape
from camopt.show.exporting.workpiece import CurveInFile, Workpiece, curves_in_file
from camopt.solve.contour.curve import SECOND_DISC
from camopt.solve.contour.hole import bore_with_keyway
from camopt.solve.contour.path_fitting import FittedPath, check_path_options, fit_path
from camopt.solve.verdicts.effect_runs import run_effects

OVERCUT = 1.0  # mm by which a bore is cut longer than the part, at both ends

CAD_ERRORS = (Standard_ConstructionError, Standard_Failure, StdFail_NotDone)
"""Errors of Open CASCADE for invalid edges and faces; they have no common base class."""


class CadSolid(NamedTuple):
    """A solid of Open CASCADE, with the report on it."""

    shape: CadShape
    curves: Mapping[str, CurveInFile]
    """Profile or walls of a disc cam, with their proven deviation."""
    about: dict[str, Any]


def solid_of(work: Workpiece, chord: float, curves: str) -> CadSolid:
    """The solid of a cam, or the solids of a pair, within ``chord`` [mm] of the true cam.

    Raises
    ------
    BadInput
        For missing sizes of ``[part]``, a groove that is undercut at some depth, a ``chord`` as large as a wall, or
        a solid that Open CASCADE finds invalid.
    """
    mistakes = list(_solid_mistakes(work))
    if mistakes:
        raise BadInput(mistakes)
    try:
        found = _SOLID_MAKERS[work.problem.setup.mechanism.body](work, chord, curves)
    except CAD_ERRORS:
        found = None
    joined = work.part.hub_diameter or work.problem.setup.mechanism.has_rib  # flanks of a rib are on one body
    if found is None or not shapes.has_valid_solids(found.shape, 1 if joined else len(work.discs)):
        faults = f"faces cross each other, or are smaller than {shapes.TOUCHING_MM} mm"
        why = f"makes no valid solid at a chord of {chord:g} mm: {faults}"
        raise BadInput([Mistake(work.scene.file, "part", None, why, bare=True)])
    return found._replace(about=found.about | shapes.shape_counts_and_volume(found.shape))


def _fitted_profile_paths(work: Workpiece, chord: float, curves: str) -> dict[str, FittedPath]:
    """Paths fitted to the profiles, walls or flanks, by name.

    Flat arcs drawn as lines stay within the chord too.
    """
    check_path_options(curves, chord)
    own = {name: curve for name, curve in work.curves().items() if not name.endswith("pitch")}
    found = {name: fit_path(curve, curves, chord - shapes.FLAT_ARC) for name, curve in own.items()}
    return {name: each._replace(deviation=each.deviation + shapes.FLAT_ARC) for name, each in found.items()}


def _disc_solid(work: Workpiece, chord: float, curves: str) -> CadSolid:
    part, followed = work.part, _fitted_profile_paths(work, chord, curves)
    _check_wall(work, chord, max(each.deviation for each in followed.values()))
    plates = [
        shapes.extrude_wire(shapes.closed_wire(profile.path), *part.plate_extents[disc.number - 1])
        for disc, profile in zip(work.discs, followed.values(), strict=True)
    ]
    if (
        part.hub_diameter and work.disc != SECOND_DISC
    ):  # its parts between the plates, and in front of the first one
        for (_, foot), (end, _) in pairwise([*sorted(part.plate_extents), (part.hub_length or 0.0, 0.0)]):
            if end - foot > shapes.TOUCHING_MM:
                plates.append(shapes.extrude_wire(shapes.circle_wire(part.hub_diameter / 2), foot, end))
    body = _cut_bore_and_keyway(part, reduce(shapes.fuse_solids, plates))
    return CadSolid(body, curves_in_file(followed), {})


def _grooved_disc_solid(work: Workpiece, chord: float, curves: str) -> CadSolid:
    part, walls = work.part, _fitted_profile_paths(work, chord, curves)
    inner, outer = (walls[name] for name in ("profile_inner", "profile_outer"))
    _check_wall(work, chord, inner.deviation)
    assert part.thickness
    assert part.groove_depth
    assert part.outer_diameter
    top, bottom = part.thickness + OVERCUT, part.thickness - part.groove_depth
    core = shapes.extrude_wire(shapes.closed_wire(inner.path), bottom - OVERCUT, top + OVERCUT)
    groove = shapes.subtract_solid(shapes.extrude_wire(shapes.closed_wire(outer.path), bottom, top), core)
    plate = shapes.extrude_wire(shapes.circle_wire(part.outer_diameter / 2), 0.0, part.thickness)
    return CadSolid(_cut_bore_and_keyway(part, shapes.subtract_solid(plate, groove)), curves_in_file(walls), {})


def _ribbed_disc_solid(work: Workpiece, chord: float, curves: str) -> CadSolid:
    part, flanks = work.part, _fitted_profile_paths(work, chord, curves)
    assert part.thickness
    assert part.rib_height
    assert part.outer_diameter
    face = part.thickness - part.rib_height
    outer, inner = (shapes.closed_wire(each.path) for each in flanks.values())
    within = shapes.extrude_wire(inner, face, part.thickness + OVERCUT)
    rib = shapes.subtract_solid(shapes.extrude_wire(outer, 0.0, part.thickness), within)
    plate = shapes.extrude_wire(shapes.circle_wire(part.outer_diameter / 2), 0.0, face)
    return CadSolid(_cut_bore_and_keyway(part, shapes.fuse_solids(plate, rib)), curves_in_file(flanks), {})


def _cylinder_solid(work: Workpiece, chord: float, curves: str) -> CadSolid:
    body, deviation = grooved_body_and_wall_deviation(work, chord)
    return CadSolid(_cut_bore_and_keyway(work.part, body), {}, {"wall_deviation_measured_mm": deviation})


_SOLID_MAKERS = {
    DISC: _disc_solid,
    FACE_GROOVE: _grooved_disc_solid,
    RIBBED_DISC: _ribbed_disc_solid,
    CYLINDER: _cylinder_solid,
    RIBBED_CYLINDER: _cylinder_solid,
}
"""Makers of solids, by body."""


def _solid_mistakes(work: Workpiece) -> Iterator[Mistake]:
    scene, part, body = work.scene, work.part, work.problem.setup.mechanism.body
    for key in body.solid:
        if getattr(part, key) is None:
            yield Mistake(scene.file, f"part.{key}", None, "missing; a solid needs it", bare=True)
    base = _smallest_base_radius(work)
    if body.closed and part.bore_reach >= base:
        why = f"must leave a wall to the base circle (radius {base:g} mm); this bore leaves none"
        yield Mistake(scene.file, "cam.shaft_diameter", scene.cam.shaft_diameter, why, bare=True)
    if part.outer_diameter is not None:
        problem = work.problem
        found = run_effects(EvaluationBlock(problem.setup, problem.programme, problem.design), [OUTER_RADIUS])
        far = 2.0 * float(found.column(OUTER_RADIUS)[0])
        if part.outer_diameter <= far:
            what = body.flank_height.partition("_")[0]
            why = f"above {far:.6g} mm: the {what} breaks through the edge"
            yield Mistake(scene.file, "part.outer_diameter", part.outer_diameter, why)


def _check_wall(work: Workpiece, chord: float, deviation: float) -> None:
    """Raise BadInput if the deviation of the profile may reach the bore."""
    wall = _smallest_base_radius(work) - work.part.bore_reach
    if deviation >= wall:
        raise BadInput([Mistake("camopt", "chord", chord, f"smaller: the wall around the bore has {wall:.3g} mm")])


def _smallest_base_radius(work: Workpiece) -> float:
    """Radius of the smallest base circle [mm]."""
    return min(float(each.problem.design.size[0]) for each in work.discs)


def _cut_bore_and_keyway(part: Part, body: CadShape) -> CadShape:
    """A body that stands on z = 0, with its bore and keyway cut."""
    if not part.bore:
        return body
    outline = shapes.closed_wire(bore_with_keyway(part)) if part.keyway_width else shapes.circle_wire(part.bore / 2)
    whole = max(part.width, part.hub_length or 0.0)
    return shapes.subtract_solid(body, shapes.extrude_wire(outline, -OVERCUT, whole + OVERCUT))
