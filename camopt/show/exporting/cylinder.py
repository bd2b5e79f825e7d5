"""The solid of a cylindrical cam: a cylinder with a groove or a rib whose walls touch the rollers.

It stands from z = 0 to ``part.thickness``, with the groove in the middle. The groove reaches from the mean radius
half of ``groove_depth`` inwards and outwards. Its bottom is a cylinder, which the roller does not touch. A rib
stands on a cylinder, with height ``rib_height``; its top is a cylinder too.

The solid is made of sectors round the cam. Each has a lower and an upper wall (B-spline surfaces), a bottom, and
two parts of the outer cylinder; for a rib, a top and two parts of the inner cylinder. Neighbours share edges, so
that no surfaces have to be intersected.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import FloatArray
from camopt.show.exporting import shapes
from camopt.show.exporting.groove import (
    WALL_SIDES,
    Groove,
    WallSurface,
    interpolating_spline,
    largest_undercut_radius,
    wall_surface,
    with_enough_sections,
    workpiece_groove,
)
from camopt.show.exporting.shapes import CadShape
from camopt.show.exporting.workpiece import Workpiece
from camopt.solve.contour.curve import pitch_curve_axial_extent

LOWER, UPPER = 0, 1  # index of walls, and of parts below or above the groove
INNER_EDGE, OUTER_EDGE = 0, -1  # index of edges of a wall


def _floor_edge_and_radius(groove: Groove) -> tuple[int, float]:
    """The wall edges at the bottom of a groove, or at the top of a rib, and their radius [mm]."""
    return (INNER_EDGE, groove.inner) if groove.below is None else (OUTER_EDGE, groove.outer)


def _surface_edge_and_radius(groove: Groove) -> tuple[int, float]:
    """Wall edges on the surface of the cylinder (top of a groove, foot of a rib), and their radius [mm]."""
    return (OUTER_EDGE, groove.outer) if groove.below is None else (INNER_EDGE, groove.inner)


WALL_SHARE = 0.1  # share of the chord allowed to walls, so that they meet cylinders well


def grooved_body_and_wall_deviation(work: Workpiece, chord: float) -> tuple[CadShape, float]:
    """The cam without its bore, and the largest measured distance of its walls from the true ones [mm].

    Raises
    ------
    BadInput
        If the groove or rib is so deep that the roller would cut away a part of a wall, or if the walls cannot come
        within ``chord`` [mm].
    """
    height = work.part.thickness
    assert height
    groove = with_enough_sections(_groove_checked_for_undercut(work), WALL_SHARE * chord)
    lift = (height - sum(pitch_curve_axial_extent(work.problem))) / 2
    walls = [
        [wall_surface(groove, sector, side, WALL_SHARE * chord).shifted_along_axis(lift) for side in WALL_SIDES]
        for sector in groove.sectors()
    ]
    deviation = max(wall.deviation for pair in walls for wall in pair)
    if deviation > chord:
        raise BadInput(
            [
                Mistake(
                    "camopt",
                    "chord",
                    chord,
                    f"at least {deviation:.2g} mm, the deviation of the walls of this groove",
                )
            ]
        )
    return shapes.sew_faces(_body_faces(groove, walls, height)), deviation


def _groove_checked_for_undercut(work: Workpiece) -> Groove:
    """The groove. Raises BadInput if it is undercut at some radius."""
    groove, part = workpiece_groove(work), work.part
    radius = largest_undercut_radius(groove)
    if radius is not None:
        why = f"smaller: at the radius {radius:.6g} mm the roller would cut away a part of a wall"
        key = work.problem.setup.mechanism.body.flank_height
        raise BadInput([Mistake(work.scene.file, f"part.{key}", getattr(part, key), why)])
    return groove


@dataclass(frozen=True)
class _SectorJoint:
    """The joint of two sectors: vertices on both walls and both ends of the cam, and the edges between them."""

    walls: list[dict[int, CadShape]]
    """Inner and outer vertices of the lower and the upper wall."""
    rims: list[CadShape]
    rulings: list[CadShape]
    bottom: CadShape
    lines: list[CadShape]
    """Edges on the cylinder from the walls to the ends."""


@dataclass(frozen=True)
class _SectorEdges:
    """Edges round the cam between two joints: of both walls and both ends."""

    skins: list[WallSurface]
    walls: list[dict[int, CadShape]]
    rims: list[CadShape]
    here: _SectorJoint
    there: _SectorJoint


def _sector_joint(groove: Groove, walls: list[WallSurface], height: float) -> _SectorJoint:
    """The joint at the start of walls."""
    corners, (between, _), (beside, _) = (
        [wall.poles[0] for wall in walls],
        _floor_edge_and_radius(groove),
        _surface_edge_and_radius(groove),
    )
    ends = [{at: shapes.make_vertex(corner[at]) for at in (INNER_EDGE, OUTER_EDGE)} for corner in corners]
    rims = [shapes.make_vertex([*corner[beside, :2], z]) for corner, z in zip(corners, (0.0, height), strict=True)]
    rulings = [
        shapes.spline_edge(wall.poles[0], wall.knots[1], (end[INNER_EDGE], end[OUTER_EDGE]))
        for wall, end in zip(walls, ends, strict=True)
    ]
    way = _floor_helix_poles_and_knots(groove, *(corner[between] for corner in corners))
    bottom = shapes.spline_edge(*way, [end[between] for end in ends])
    lines = [shapes.line_edge(end[beside], rim) for end, rim in zip(ends, rims, strict=True)]
    return _SectorJoint(ends, rims, rulings, bottom, lines)


def _floor_helix_poles_and_knots(
    groove: Groove, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Poles and knots of the helix between two points of the bottom of a groove (top of a rib)."""
    share = np.linspace(0.0, 1.0, 12)
    height, around = ((1.0 - share) * low[k] + share * high[k] for k in (2, 3))
    polar, (_, radius) = groove.polar_angle(around), _floor_edge_and_radius(groove)
    return interpolating_spline(share, np.stack([radius * np.cos(polar), radius * np.sin(polar), height], axis=-1))


def _sector_edges(
    groove: Groove,
    wall_surfaces: list[WallSurface],
    start_joint: _SectorJoint,
    end_joint: _SectorJoint,
    height: float,
) -> _SectorEdges:
    walls = [
        {
            at: shapes.spline_edge(
                wall.poles[:, at], wall.knots[0], (start_joint.walls[side][at], end_joint.walls[side][at])
            )
            for at in (INNER_EDGE, OUTER_EDGE)
        }
        for side, wall in enumerate(wall_surfaces)
    ]
    rims = [
        shapes.arc_edge(shapes.gp_point(0.0, 0.0, z), _surface_edge_and_radius(groove)[1], -groove.sense, *ends)
        for z, ends in zip((0.0, height), zip(start_joint.rims, end_joint.rims, strict=True), strict=True)
    ]
    return _SectorEdges(wall_surfaces, walls, rims, start_joint, end_joint)


def _body_faces(groove: Groove, walls: list[list[WallSurface]], height: float) -> Iterator[CadShape]:
    """All faces of the body, from its walls."""
    joints = [_sector_joint(groove, pair, height) for pair in walls]
    ends = pairwise([*joints, joints[0]])
    sectors = [_sector_edges(groove, pair, *each, height) for pair, each in zip(walls, ends, strict=True)]
    for sector in sectors:
        yield from _sector_faces(groove, sector)
    for side in (LOWER, UPPER):
        yield shapes.plane_face(shapes.make_wire(sector.rims[side] for sector in sectors))


def _sector_faces(groove: Groove, sector: _SectorEdges) -> Iterator[CadShape]:
    """Walls, bottom and outside of a sector."""
    here, there, (low, high), rims = sector.here, sector.there, sector.walls, sector.rims
    for wall, edges, start, end in zip(sector.skins, sector.walls, here.rulings, there.rulings, strict=True):
        surface = shapes.spline_surface(wall.poles, *wall.knots)
        yield shapes.surface_face(surface, [edges[INNER_EDGE], end, edges[OUTER_EDGE], start])
    seam = float(groove.polar_angle(sector.skins[0].poles[0, 0, 3])) + np.pi
    (between, bottom), (beside, outside) = _floor_edge_and_radius(groove), _surface_edge_and_radius(groove)
    for radius, loop in (
        (bottom, [low[between], there.bottom, high[between], here.bottom]),
        (outside, [rims[LOWER], there.lines[LOWER], low[beside], here.lines[LOWER]]),
        (outside, [high[beside], there.lines[UPPER], rims[UPPER], here.lines[UPPER]]),
    ):
        yield shapes.surface_face(shapes.cylinder_surface(radius, seam), loop, is_clockwise=groove.sense > 0.0)
