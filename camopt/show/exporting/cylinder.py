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
from scipy.interpolate import make_interp_spline

from camopt.core.mistakes import BadInput, Mistake
from camopt.show.exporting import shapes
from camopt.show.exporting.groove import (
    SPLINE_DEGREE,
    WALL_SIDES,
    Groove,
    WallSurface,
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


def _floor_and_surface_edges(groove: Groove) -> tuple[tuple[int, float], tuple[int, float]]:
    """The wall edges at the bottom of a groove (top of a rib), and those on the surface of the cylinder.

    Each with its radius [mm].
    """
    inner, outer = (INNER_EDGE, groove.inner), (OUTER_EDGE, groove.outer)
    return (inner, outer) if groove.below is None else (outer, inner)


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
    groove = workpiece_groove(work)
    if (radius := largest_undercut_radius(groove)) is not None:
        why = f"smaller: at the radius {radius:.6g} mm the roller would cut away a part of a wall"
        key = f"part.{work.problem.setup.mechanism.body.flank_height}"
        raise BadInput([Mistake(work.scene.file, key, work.flank_height, why)])
    groove = with_enough_sections(groove, WALL_SHARE * chord)
    lift = np.array([0.0, 0.0, (height - sum(pitch_curve_axial_extent(work.problem))) / 2, 0.0])
    walls = []
    for sector in groove.sectors():
        pair = [wall_surface(groove, sector, side, WALL_SHARE * chord) for side in WALL_SIDES]
        walls.append([wall._replace(poles=wall.poles + lift) for wall in pair])
    deviation = max(wall.deviation for pair in walls for wall in pair)
    if deviation > chord:
        why = f"at least {deviation:.2g} mm, the deviation of the walls of this groove"
        raise BadInput([Mistake("camopt", "chord", chord, why)])
    return shapes.sew_faces(_body_faces(groove, walls, height)), deviation


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


def _sector_joint(groove: Groove, walls: list[WallSurface], height: float) -> _SectorJoint:
    """The joint at the start of walls."""
    corners = [wall.poles[0] for wall in walls]
    (between, radius), (beside, _) = _floor_and_surface_edges(groove)
    ends = [{at: shapes.make_vertex(corner[at]) for at in (INNER_EDGE, OUTER_EDGE)} for corner in corners]
    rims = [shapes.make_vertex([*corner[beside, :2], z]) for corner, z in zip(corners, (0.0, height), strict=True)]
    rulings = [
        shapes.spline_edge(wall.poles[0], wall.knots[1], (end[INNER_EDGE], end[OUTER_EDGE]))
        for wall, end in zip(walls, ends, strict=True)
    ]
    # the bottom edge is a helix
    share = np.linspace(0.0, 1.0, 12)
    low, high = (corner[between] for corner in corners)
    axial, around = ((1.0 - share) * low[k] + share * high[k] for k in (2, 3))
    polar = groove.polar_angle(around)
    helix = make_interp_spline(
        share, np.stack([radius * np.cos(polar), radius * np.sin(polar), axial], axis=-1), k=SPLINE_DEGREE
    )
    bottom = shapes.spline_edge(helix.c, helix.t, [end[between] for end in ends])
    lines = [shapes.line_edge(end[beside], rim) for end, rim in zip(ends, rims, strict=True)]
    return _SectorJoint(ends, rims, rulings, bottom, lines)


def _body_faces(groove: Groove, walls: list[list[WallSurface]], height: float) -> Iterator[CadShape]:
    """All faces of the body, from its walls."""
    joints = [_sector_joint(groove, pair, height) for pair in walls]
    _, (_, radius) = _floor_and_surface_edges(groove)
    centres = [shapes.gp_point(0.0, 0.0, z) for z in (0.0, height)]
    all_rims = []
    for surfaces, (here, there) in zip(walls, pairwise([*joints, joints[0]]), strict=True):
        rims = [
            shapes.arc_edge(centre, radius, -groove.sense, *ends)
            for centre, *ends in zip(centres, here.rims, there.rims, strict=True)
        ]
        yield from _sector_faces(groove, surfaces, rims, here, there)
        all_rims.append(rims)
    for edges in zip(*all_rims, strict=True):
        yield shapes.plane_face(shapes.make_wire(edges))


def _sector_faces(
    groove: Groove, surfaces: list[WallSurface], rims: list[CadShape], here: _SectorJoint, there: _SectorJoint
) -> Iterator[CadShape]:
    """Walls, bottom and outside of a sector between two joints; ``rims`` are its edges at both ends of the cam."""
    low, high = walls = [
        {
            at: shapes.spline_edge(wall.poles[:, at], wall.knots[0], (here.walls[side][at], there.walls[side][at]))
            for at in (INNER_EDGE, OUTER_EDGE)
        }
        for side, wall in enumerate(surfaces)
    ]
    for wall, edges, start, end in zip(surfaces, walls, here.rulings, there.rulings, strict=True):
        surface = shapes.spline_surface(wall.poles, *wall.knots)
        yield shapes.surface_face(surface, [edges[INNER_EDGE], end, edges[OUTER_EDGE], start])
    seam = float(groove.polar_angle(surfaces[0].poles[0, 0, 3])) + np.pi
    (between, bottom), (beside, outside) = _floor_and_surface_edges(groove)
    for radius, loop in (
        (bottom, [low[between], there.bottom, high[between], here.bottom]),
        (outside, [rims[LOWER], there.lines[LOWER], low[beside], here.lines[LOWER]]),
        (outside, [high[beside], there.lines[UPPER], rims[UPPER], here.lines[UPPER]]),
    ):
        yield shapes.surface_face(shapes.cylinder_surface(radius, seam), loop, is_clockwise=groove.sense > 0.0)
