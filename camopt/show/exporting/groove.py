"""The walls of the groove of a cylindrical cam, or of its rib: the envelope of its rollers, at every depth.

The roller of radius ρ is a cylinder. Its axis meets the cam's where a translating follower moves; on an arm it is
parallel to that of the arm's pivot, and beside the cam's axis by what the arm has swung away from the line of
contact. At the distance s from the cam's axis, along its own, the roller moves over the cam by s + x' round it and
by z' along it for each radian (x: how far it is beside the line of contact), so that it touches at its axis plus

    ±ρ·(−z', s + x')/√(z'² + (s + x')²)

round and along the cam. At the mean radius that is the normal of the developed curve; nearer to the axis the roller
moves more steeply, and touches further round. A developed groove that is wound up would not fit the roller there.

Source: Litvin and Fuentes, Gear Geometry and Applied Theory, ch. 6 (the relative velocity is normal to n).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from camopt.core.numerics import BoolArray, ComplexArray, FloatArray
from camopt.show.exporting.workpiece import Workpiece
from camopt.solve.contour.curve import CamCurve, SmoothSpan, cam_discs, offset_curve

WALL_SIDES = (-1.0, 1.0)  # of the lower and the upper wall
SECTOR_ANGLE = 1.6  # rad: of a sector of the turn
GROOVE_ROUNDS = 100
NO_CHANGE = 1e-15  # relative change of a radius that is none
SPLINE_DEGREE = 5  # of the splines round the cam
FIRST_POINTS, SECTOR_POINTS = 12, 6000  # points of a sector round the cam
SECTIONS, MOST_SECTIONS = 4, 16  # radii with points of their own
WALL_SAMPLES = 500  # cam angles of a sector at which a wall may run back
PARTS_BETWEEN = 4  # parts of the stretches between points at which surfaces are compared


@dataclass(frozen=True)
class Sector:
    """A part of one span of the turn, between two cam angles (rad)."""

    span: SmoothSpan
    start: float
    end: float


class WallPoints(NamedTuple):
    """Points of a wall (angles, radii): angle round the cam (rad, as the cam angle), radius, and height (mm).

    ``pitch_tangent`` is where the roller moves there: round the cam, and along it as the imaginary part, mm/rad.
    """

    round: FloatArray
    radius: FloatArray
    height: FloatArray
    pitch_tangent: ComplexArray


@dataclass(frozen=True)
class Groove:
    """A groove, or a rib, between two radii (mm).

    At the height 0 a translating follower starts, or an arm is at mid-swing.
    """

    curve: CamCurve
    inner: float
    outer: float
    half_width: float
    """Radius of the roller and half its clearance, mm."""
    sections: int = SECTIONS
    below: CamCurve | None = None
    """Of a rib the pitch curve of the roller below it, that of the one above being ``curve``."""

    @property
    def sense(self) -> float:
        return self.curve.design.sense

    @property
    def radii(self) -> FloatArray:
        """Of the sections, mm: Chebyshev's points and both ends."""
        share = (1.0 - np.cos(np.linspace(0.0, np.pi, self.sections))) / 2
        return (1.0 - share) * self.inner + share * self.outer

    def sectors(self) -> Iterator[Sector]:
        for span in self.curve.spans:
            count = int(np.ceil((span.end - span.start) / SECTOR_ANGLE))
            for start, end in pairwise(np.linspace(span.start, span.end, count + 1).tolist()):
                yield Sector(span, start, end)

    def wall(self, span: SmoothSpan, angles: FloatArray, radii: FloatArray, side: float) -> WallPoints:
        """Where the roller touches the upper (side +1) or lower (−1) wall at cam angles (rad) and radii (mm).

        Not a number where it does not reach so near to the axis.
        """
        curve = self.curve
        if self.below is not None:  # the rollers of a rib are beside it
            curve, side = (self.below if side < 0.0 else curve), -side
            span = curve.spans[int(curve.span_numbers(np.array([span.start + span.end]) / 2)[0])]
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

    def points(self, places: WallPoints) -> FloatArray:
        """x, y and z of places in the cam's own frame, (…, 3), mm."""
        polar = self.polar(places.round)
        return np.stack([places.radius * np.cos(polar), places.radius * np.sin(polar), places.height], axis=-1)

    def polar(self, around: FloatArray) -> FloatArray:
        """Angle from the x axis, rad, ccw: the follower is on the y axis at cam angle 0."""
        return np.pi / 2 - self.sense * around


def workpiece_groove(work: Workpiece) -> Groove:
    """The groove or rib of a cylindrical cam, as deep as in ``[part]``, with the mean radius in its middle."""
    problem = work.problem
    mean, depth = float(problem.design.size[0]), getattr(work.part, problem.setup.mechanism.body.flank_height)
    assert depth
    curve, *others = (offset_curve(each.problem, 0.0) for each in cam_discs(problem))
    below = others[0] if others else None
    return Groove(curve, mean - depth / 2, mean + depth / 2, problem.half_width, below=below)


def undercut_radius(groove: Groove) -> float | None:
    """The outermost of given radii (mm) at which a wall runs back as the cam turns, at the angles checked."""
    found = [
        radius
        for sector in groove.sectors()
        for side in WALL_SIDES
        for radius, back in zip(groove.radii, _runs_back(groove, sector, side), strict=True)
        if back
    ]
    return max(found, default=None)


def _runs_back(groove: Groove, sector: Sector, side: float) -> BoolArray:
    """Whether at each radius a wall runs back somewhere, or does not exist."""
    wall = groove.wall(sector.span, np.linspace(sector.start, sector.end, WALL_SAMPLES), groove.radii, side)
    moved = groove.radii * np.diff(wall.round, axis=0) + 1j * np.diff(wall.height, axis=0)
    return np.asarray(~((moved * wall.pitch_tangent[1:].conjugate()).real >= 0.0).all(axis=0))


class WallSurface(NamedTuple):
    """A B-spline surface through sections of a wall, over cam angle (rad) and radius (mm).

    ``poles`` are (n, m, 4): x, y, z, and the angle round the cam, of which the first three make the surface.
    """

    poles: FloatArray
    knots: tuple[FloatArray, FloatArray]
    degrees: tuple[int, int]
    deviation: float = inf
    """The largest distance from the true wall among the points compared, mm."""
    section_deviation: float = inf
    """The same at cam angles of its own points, so between the sections alone."""

    def shifted_along_axis(self, height: float) -> "WallSurface":
        """The surface moved along the axis."""
        return self._replace(poles=self.poles + np.array([0.0, 0.0, height, 0.0]))

    def points_at(self, angles: FloatArray, radii: FloatArray) -> FloatArray:
        """Points (angles, radii, 4)."""
        rows = BSpline(self.knots[0], self.poles, self.degrees[0])(angles)
        return np.asarray(BSpline(self.knots[1], rows, self.degrees[1], axis=1)(radii))


def with_enough_sections(groove: Groove, aim: float) -> Groove:
    """The groove with as many sections as its surfaces need to be within half of ``aim`` mm between them."""
    for count in range(SECTIONS, MOST_SECTIONS):
        found = replace(groove, sections=count)
        if all(
            _interpolate_wall(found, each, side, FIRST_POINTS).section_deviation <= aim / 2
            for each in found.sectors()
            for side in WALL_SIDES
        ):
            return found
    return replace(groove, sections=MOST_SECTIONS)


def wall_surface(groove: Groove, sector: Sector, side: float, aim: float) -> WallSurface:
    """The surface of a wall over a sector, through as many points as it needs to be within ``aim`` mm."""
    count = FIRST_POINTS
    while True:
        found = _interpolate_wall(groove, sector, side, count)
        if found.deviation <= aim or count >= SECTOR_POINTS:
            return found
        count *= 2


def _interpolate_wall(groove: Groove, sector: Sector, side: float, count: int) -> WallSurface:
    angles, radii = np.linspace(sector.start, sector.end, count), groove.radii
    rows = make_interp_spline(angles, _exact_wall(groove, sector, side, angles, radii), k=SPLINE_DEGREE, axis=0)
    across = make_interp_spline(radii, rows.c, k=radii.size - 1, axis=1)
    found = WallSurface(np.moveaxis(across.c, 0, 1), (rows.t, across.t), (SPLINE_DEGREE, radii.size - 1))
    fine = np.linspace(sector.start, sector.end, PARTS_BETWEEN * (count - 1) + 1)
    deep = np.linspace(groove.inner, groove.outer, PARTS_BETWEEN * (radii.size - 1) + 1)
    gap = np.linalg.norm(
        (found.points_at(fine, deep) - _exact_wall(groove, sector, side, fine, deep))[..., :3], axis=-1
    )
    return found._replace(deviation=float(gap.max()), section_deviation=float(gap[::PARTS_BETWEEN].max()))


def interpolating_spline(shares: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Poles and knots of the spline through points (n, 3) at some shares of its length."""
    found = make_interp_spline(shares, points, k=SPLINE_DEGREE)
    return found.c, found.t


def _exact_wall(groove: Groove, sector: Sector, side: float, angles: FloatArray, radii: FloatArray) -> FloatArray:
    places = groove.wall(sector.span, angles, radii, side)
    return np.concatenate([groove.points(places), places.round[..., None]], axis=-1)
