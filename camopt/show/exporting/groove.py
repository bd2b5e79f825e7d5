"""Walls of the groove or rib of a cylindrical cam: the envelope of its rollers, at every depth.

The roller of radius ρ is a cylinder. With a translating follower, its axis meets the axis of the cam. On an arm,
its axis is parallel to the pivot of the arm, and passes the axis of the cam at the distance x by which the arm has
swung from the line of contact. At the distance s from the axis of the cam, along its own axis, the roller moves
over the cam by s + x' round it and by z' along it for each radian of cam angle. It touches at its axis plus

    ±ρ·(−z', s + x')/√(z'² + (s + x')²)

round and along the cam. At the mean radius this is the normal of the developed curve. Nearer to the axis the roller
moves more steeply and touches further round. A developed groove wound onto the cylinder would not fit there.

Source: Litvin and Fuentes, Gear Geometry and Applied Theory, ch. 6 (the relative velocity is normal to n).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise, product
from math import inf
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.show.exporting.workpiece import Workpiece
from camopt.solve.contour.curve import CamCurve, SmoothSpan, cam_discs, pitch_or_face_curve

WALL_SIDES = (-1.0, 1.0)  # lower and upper wall
SECTOR_ANGLE = 1.6  # rad: largest angle of a sector
GROOVE_ROUNDS = 100
NO_CHANGE = 1e-15  # relative change of a radius that counts as converged
SPLINE_DEGREE = 5  # degree of the splines round the cam
FIRST_POINTS, SECTOR_POINTS = 12, 6000  # points of a sector round the cam
SECTIONS, MOST_SECTIONS = 4, 16  # number of radii with points
WALL_SAMPLES = 500  # cam angles of a sector at which undercut of a wall is checked
PARTS_BETWEEN = 4  # intervals between two points at which a surface is compared


@dataclass(frozen=True)
class Sector:
    """A part of one span of the turn, between two cam angles (rad)."""

    span: SmoothSpan
    start: float
    end: float


class WallPoints(NamedTuple):
    """Points of a wall (angles, radii): angle round the cam [rad, like the cam angle], radius and height [mm].

    ``pitch_tangent`` is the velocity of the roller there [mm/rad]: round the cam, and along it as imaginary part.
    """

    round: FloatArray
    radius: FloatArray
    height: FloatArray
    pitch_tangent: ComplexArray


@dataclass(frozen=True)
class Groove:
    """A groove or rib between two radii [mm].

    The height 0 is the start of a translating follower, or the mid-swing of an arm.
    """

    curve: CamCurve
    inner: float
    outer: float
    half_width: float
    """Radius of the roller plus half its clearance [mm]."""
    sections: int = SECTIONS
    below: CamCurve | None = None
    """For a rib, the pitch curve of the roller below it; ``curve`` is that of the roller above."""

    @property
    def sense(self) -> float:
        return self.curve.design.sense

    @property
    def section_radii(self) -> FloatArray:
        """Radii of the sections [mm]: Chebyshev points with both ends."""
        share = (1.0 - np.cos(np.linspace(0.0, np.pi, self.sections))) / 2
        return (1.0 - share) * self.inner + share * self.outer

    def sectors(self) -> Iterator[Sector]:
        for span in self.curve.spans:
            count = int(np.ceil((span.end - span.start) / SECTOR_ANGLE))
            for start, end in pairwise(np.linspace(span.start, span.end, count + 1).tolist()):
                yield Sector(span, start, end)

    def wall_points(self, span: SmoothSpan, angles: FloatArray, radii: FloatArray, side: float) -> WallPoints:
        """Contact points on the upper (side +1) or lower (−1) wall, at cam angles [rad] and radii [mm].

        NaN where the roller does not reach this radius.
        """
        curve = self.curve
        if self.below is not None:  # the rollers are outside of the rib
            curve, side = (self.below if side < 0.0 else curve), -side
            span = curve.spans[int(curve.span_index_at_each_angle(np.array([span.start + span.end]) / 2)[0])]
        design, lift = curve.design, curve.programme.lift
        angles, radii = angles[:, None], radii[None, :]
        y, y1, *_ = (row[:, None] for row in span.stroke.motion(angles[:, 0]))
        found = curve.mechanism.contact(design, lift, angles, y, y1)
        mean, reach = design.size, side * self.half_width
        beside = found.x - mean * angles
        station = radii + 0.0 * angles
        for _ in range(GROOVE_ROUNDS):
            across, along = found.across, found.up + (station - mean)
            touched = beside + reach * across / np.hypot(across, along)
            with np.errstate(invalid="ignore"):
                before, station = station, np.sqrt((radii - touched) * (radii + touched))
            if np.abs(station - before).max() <= NO_CHANGE * self.outer:
                break
        height = found.y + reach * along / np.hypot(across, along)
        return WallPoints(angles + np.arctan2(touched, station), radii + 0.0 * angles, height, along - 1j * across)

    def xyz_points(self, places: WallPoints) -> FloatArray:
        """x, y and z of wall points in the frame of the cam [mm], (…, 3)."""
        polar = self.polar_angle(places.round)
        return np.stack([places.radius * np.cos(polar), places.radius * np.sin(polar), places.height], axis=-1)

    def polar_angle(self, angle_round_cam: FloatArray) -> FloatArray:
        """Angle from the x axis, ccw [rad]; the follower is on the y axis at cam angle 0."""
        return np.pi / 2 - self.sense * angle_round_cam


def workpiece_groove(work: Workpiece) -> Groove:
    """The groove or rib of a cylindrical cam, with the depth of ``[part]`` and the mean radius in its middle."""
    problem = work.problem
    mean, depth = float(problem.design.size[0]), work.flank_height
    assert depth
    curve, *others = (pitch_or_face_curve(each.problem) for each in cam_discs(problem))
    below = others[0] if others else None
    return Groove(curve, mean - depth / 2, mean + depth / 2, problem.wall_distance_from_pitch_curve, below=below)


def largest_undercut_radius(groove: Groove) -> float | None:
    """The largest radius of a section with undercut [mm], where a wall runs back as the cam turns; None without."""
    undercut, radii = list[float](), groove.section_radii
    for sector, side in product(groove.sectors(), WALL_SIDES):
        wall = groove.wall_points(sector.span, np.linspace(sector.start, sector.end, WALL_SAMPLES), radii, side)
        moved = radii * np.diff(wall.round, axis=0) + 1j * np.diff(wall.height, axis=0)
        runs_on = ((moved * wall.pitch_tangent[1:].conjugate()).real >= 0.0).all(axis=0)
        undercut += radii[~runs_on].tolist()  # also where the wall does not exist
    return max(undercut, default=None)


class WallSurface(NamedTuple):
    """A B-spline surface through sections of a wall, over cam angle [rad] and radius [mm].

    ``poles`` are (n, m, 4): x, y, z of the surface, and the angle round the cam.
    """

    poles: FloatArray
    knots: tuple[FloatArray, FloatArray]
    degrees: tuple[int, int]
    deviation: float = inf
    """Largest distance from the true wall at the compared points [mm]."""
    section_deviation: float = inf
    """As ``deviation``, only at cam angles of the points: the deviation between sections [mm]."""

    def points_at(self, angles: FloatArray, radii: FloatArray) -> FloatArray:
        """Points of the surface, (angles, radii, 4)."""
        rows = BSpline(self.knots[0], self.poles, self.degrees[0])(angles)
        return np.asarray(BSpline(self.knots[1], rows, self.degrees[1], axis=1)(radii))


def with_enough_sections(groove: Groove, largest_deviation: float) -> Groove:
    """The groove with enough sections for surfaces within half of ``largest_deviation`` [mm] between them."""
    for count in range(SECTIONS, MOST_SECTIONS):
        finer = replace(groove, sections=count)
        walls = (_interpolate_wall(finer, *place, FIRST_POINTS) for place in product(finer.sectors(), WALL_SIDES))
        if all(wall.section_deviation <= largest_deviation / 2 for wall in walls):
            return finer
    return replace(groove, sections=MOST_SECTIONS)


def wall_surface(groove: Groove, sector: Sector, side: float, largest_deviation: float) -> WallSurface:
    """The surface of a wall over a sector, through enough points to be within ``largest_deviation`` [mm]."""
    count = FIRST_POINTS
    while True:
        surface = _interpolate_wall(groove, sector, side, count)
        if surface.deviation <= largest_deviation or count >= SECTOR_POINTS:
            return surface
        count *= 2


def _interpolate_wall(groove: Groove, sector: Sector, side: float, count: int) -> WallSurface:
    angles, radii = np.linspace(sector.start, sector.end, count), groove.section_radii
    rows = make_interp_spline(
        angles, _exact_wall_points(groove, sector, side, angles, radii), k=SPLINE_DEGREE, axis=0
    )
    across = make_interp_spline(radii, rows.c, k=radii.size - 1, axis=1)
    found = WallSurface(np.moveaxis(across.c, 0, 1), (rows.t, across.t), (SPLINE_DEGREE, radii.size - 1))
    fine = np.linspace(sector.start, sector.end, PARTS_BETWEEN * (count - 1) + 1)
    deep = np.linspace(groove.inner, groove.outer, PARTS_BETWEEN * (radii.size - 1) + 1)
    gap = np.linalg.norm(
        (found.points_at(fine, deep) - _exact_wall_points(groove, sector, side, fine, deep))[..., :3], axis=-1
    )
    return found._replace(deviation=float(gap.max()), section_deviation=float(gap[::PARTS_BETWEEN].max()))


def _exact_wall_points(
    groove: Groove, sector: Sector, side: float, angles: FloatArray, radii: FloatArray
) -> FloatArray:
    places = groove.wall_points(sector.span, angles, radii, side)
    return np.concatenate([groove.xyz_points(places), places.round[..., None]], axis=-1)
