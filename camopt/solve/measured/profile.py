"""The lift of a follower on a measured profile: each point gives one cam angle and the lift there.

A round follower of the radius R_r touches the profile at p, where the outward normal is n. Its centre is

    T = p + R_r·n,

as high as on the base circle of a cam with the prime radius |T| (``geometry.cam_curves`` inverted). A flat face
there is at the distance p·n from the axis, as on a cam with this base radius. The cam has turned until T, or n, is
in its place on that cam. The position of a translating follower is the height of its trace point or face above the
axis. That of an oscillating follower is the angle ψ of its arm or face.

The follower touches each point of a profile at one cam angle, so each row of the file is one lift. An error δ of
the point along the normal is an error δ/cos β of the lift (δ under a flat face). So errors of the lifts are as
independent as those of the points, and noise, outliers and band are as for a table of lifts. The outward normal is
that of the closed curve of least jerk within the noise of the distances; an error of its direction hardly matters.
The follower does not reach some points, because it would cut into the profile elsewhere. These points are left out:
those of hollows narrower than the roller, or of any hollow under a flat face.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 7, inverted.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite
from numbers import Real
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from camopt.core.mistakes import BadInput, Mistake, Unsolved
from camopt.core.numerics import BoolArray, ComplexArray, FloatArray, IntArray
from camopt.model.mechanisms.design import Designs
from camopt.model.mechanisms.geometry import profile_points
from camopt.model.mechanisms.oscillating_flat import sine_of_start_face_angle
from camopt.scene.problem.problem import Problem
from camopt.solve.measured.columns import PROFILE_KINDS, TableReadingOptions
from camopt.solve.measured.drawing_points import is_drawing
from camopt.solve.measured.least_jerk import AllowedDeviation, LeastJerkCurve, least_jerk_curve
from camopt.solve.measured.measured_points import FEWEST_MEASURED, TURN_DEG, MeasuredPoints, forward_angle_deg
from camopt.solve.measured.number_table import file_mistake
from camopt.solve.measured.outline import gap_mistake, places_before_gaps

CURVE_POINTS = 7200  # approximate number of points of a curve in a search for the nearest one
DIRECTIONS_AT_ONCE = 64  # directions that are searched at once for the furthest point
LARGEST_PROBE = 1e3  # mm


class Contacts(NamedTuple):
    """A follower on a profile: cam angles [rad], positions [mm or rad], and whether it can be there."""

    angles: FloatArray
    positions: FloatArray
    possible: BoolArray


def contacts_at_points(problem: Problem, profile: ComplexArray, normals: ComplexArray) -> Contacts:
    """Contacts of a problem's follower, without its motion, at points with outward normals."""
    mechanism, design = problem.setup.mechanism, problem.design
    trace = profile + design.roller_radius[0] * normals
    flat = mechanism.flat_faced
    reach = (profile * normals.conjugate()).real if flat else np.abs(trace) - design.roller_radius[0]
    designs = replace(design.take(np.zeros(profile.size, dtype=int)), size=reach)
    possible = mechanism.can_assemble(designs, problem.programme)
    with np.errstate(invalid="ignore"):
        ground = mechanism.trace_and_normal(designs, problem.programme, np.zeros(profile.size))
        directions = (ground.normal, normals) if flat else (ground.trace, trace)
        angles = design.sense * np.angle(directions[0] * directions[1].conjugate())
        return Contacts(angles, follower_position_on_base_circle(problem, designs), possible)


def follower_position_on_base_circle(problem: Problem, designs: Designs) -> FloatArray:
    """Position of the follower on the base circles of designs [mm or rad]."""
    if problem.setup.mechanism.start is not None:
        return np.asarray(problem.setup.mechanism.start(designs))
    return np.arcsin(sine_of_start_face_angle(designs)) if problem.setup.angular else designs.size


def base_radius_at(problem: Problem, position: float) -> float:
    """Base radius for a position of the follower on the base circle [mm].

    Inverse of ``follower_position_on_base_circle``.
    """
    mechanism, design = problem.setup.mechanism, problem.design
    if mechanism.trace_point is not None:
        return float(np.hypot(*mechanism.trace_point(design, position))[0] - design.roller_radius[0])
    if problem.setup.angular:
        return float(design.face_offset[0] + design.centre_distance[0] * np.sin(position))
    return position


@dataclass(frozen=True)
class MeasuredProfile:
    """Points of the profile of a disc cam, measured with a ball probe; ``fit`` takes it in place of lifts.

    Parameters
    ----------
    points : str, os.PathLike or array_like
        A file, or an array of rows, as for ``fit``: in mm, or in the unit of the lifts. Or a drawing (DXF), with
        the cam's axis at 0, 0.
    form : str, optional
        "polar": cam angle, and distance from the cam's axis; the angle is the one at which a radial follower meets
        the point, as in a table of lifts. "xy": coordinates with the cam's axis at 0, 0, seen as the cam turns in
        the scene, as in a drawing. The place of the angle 0 or the x-axis on the cam does not matter. Only a
        drawing needs no form.
    probe : float, default 0
        Radius of the ball in mm, if the points are its centres; 0 if they are on the profile itself.
    layer : str, optional
        Layer of the profile in a drawing, if it has several curves about the axis and none is on the layer PROFILE.

    Raises
    ------
    BadInput
        For another form, or for a radius that is not allowed.

    Examples
    --------
    >>> turn = np.radians(np.arange(0, 360, 2))
    >>> circle = np.column_stack([4 + 22 * np.cos(turn), 22 * np.sin(turn)])  # of 20 mm, 4 mm off the axis
    >>> cam = {"cam": {"form": "disc"}, "follower": {"motion": "translating", "contact": "flat"}}
    >>> fitted = camopt.fit(camopt.MeasuredProfile(circle, "xy", probe=2), cam, band=0.001)
    >>> round(fitted.scene.cam.base_radius, 2)
    16.0
    """

    points: str | os.PathLike[str] | ArrayLike
    form: str = ""
    probe: float = 0.0
    layer: str | None = None

    def __post_init__(self) -> None:
        mistakes = []
        if not self.form and is_drawing(self.points):
            object.__setattr__(self, "form", "xy")
        if self.form not in PROFILE_KINDS:
            missing = f"missing: {' or '.join(PROFILE_KINDS)}, points of the profile; fit reads files of lifts"
            mistakes.append(
                Mistake("camopt", "profile", self.form, f"one of {', '.join(PROFILE_KINDS)}")
                if self.form
                else Mistake("camopt", "profile", None, missing, bare=True)
            )
        if not (isinstance(self.probe, Real) and isfinite(self.probe) and 0.0 <= self.probe <= LARGEST_PROBE):
            mistakes.append(Mistake("camopt", "probe", self.probe, f"a radius from 0 to {LARGEST_PROBE:g} mm"))
        if self.layer is not None and not is_drawing(self.points):
            mistakes.append(Mistake("camopt", "layer", self.layer, "belongs to a drawing (DXF)", bare=True))
        if mistakes:
            raise BadInput(mistakes)

    def with_profile_kind_and_layer(self, reading_options: TableReadingOptions) -> TableReadingOptions:
        """Columns of a table of lifts as those of the points."""
        return replace(reading_options, kind=PROFILE_KINDS[self.form], layer=self.layer)

    def mirrored(self, points: MeasuredPoints) -> MeasuredPoints:
        """Its points mirrored, y → −y, as on a cam that turns the other way."""
        half, way = TURN_DEG / 2.0, -1.0 if self.form == "xy" else 1.0
        angles = forward_angle_deg(0.0, half + way * points.angles)
        order = np.argsort(angles, kind="stable")
        return replace(points, angles=angles[order], lifts=points.lifts[order], rows=points.rows[order])

    def check(self, points: MeasuredPoints) -> None:
        """BadInput for points that cannot be those of a ball on a cam."""
        for place in np.flatnonzero(points.lifts <= self.probe):
            least = f"the probe's radius {self.probe:g}" if self.probe else "0"
            what = f"must be further from the axis of the cam than {least}"
            raise file_mistake(points.file, f"row {points.rows[place]}", float(points.lifts[place]), what)


class FollowedProfile(NamedTuple):
    """A profile and its follower at each point.

    ``positions`` are points with positions of the follower in place of lifts. ``outlier_places`` are the places of
    outliers among them. ``centres`` are all centres of the probe, as x + iy in the frame of the cam at cam angle 0,
    by ``rows``. ``unreached`` are rows.
    """

    problem: Problem
    probe: float
    positions: MeasuredPoints
    outlier_places: list[int]
    centres: ComplexArray
    rows: IntArray
    unreached: IntArray

    def probe_centres_at(self, problem: Problem, start_angle_deg: float, rows: IntArray) -> ComplexArray:
        """Centres of some rows, in the frame of a cam whose angle 0 is at ``start_angle_deg`` of the points."""
        turn = np.exp(1j * problem.design.sense * np.radians(start_angle_deg))
        return np.asarray(turn * self.centres[np.isin(self.rows, rows)])

    def distances_outside_profile(self, problem: Problem, start_angle_deg: float, rows: IntArray) -> FloatArray:
        """Distances of points outside the profile of that cam, along its normal [mm]; negative inside."""
        centres = self.probe_centres_at(problem, start_angle_deg, rows)
        angles = np.linspace(0.0, 2.0 * np.pi, CURVE_POINTS + 1)
        profile = profile_points(problem.setup.mechanism, problem.design, problem.programme, angles)
        ring = shapely.linearrings(_xy_coordinates(profile))
        away = shapely.distance(ring, shapely.points(_xy_coordinates(centres)))
        inside = shapely.contains_xy(shapely.polygons(ring), centres.real, centres.imag)
        return np.asarray(np.where(inside, -away, away) - self.probe)


def follower_on_profile(
    problem: Problem,
    profile: MeasuredProfile,
    points: MeasuredPoints,
    outlier_places: Sequence[int],
    allowed: AllowedDeviation,
    gaps_anywhere: bool,
) -> FollowedProfile:
    """The follower at each of the points (angles and distances), with the deviation that their noise allows.

    Outliers, at ``outlier_places``, do not shape the curve. Points may be missing on the base circle, or anywhere
    if the motion is known.

    Raises
    ------
    BadInput
        For a point that the follower cannot touch, for missing points outside the base circle, or for too few
        contacts.
    Unsolved
        If the convex solver fails.
    """
    kept_points = points.drop_places(outlier_places)
    dense_angles = _dense_angles(kept_points, np.inf if gaps_anywhere else allowed.band)
    curve, side = (
        _least_jerk_polar_curve(kept_points, allowed),
        1.0 if profile.form == "xy" else problem.design.sense,
    )
    smooth, normals = _polar_curve_points_and_normals(curve, points.angles, side)
    centres = points.lifts * smooth / np.abs(smooth)
    contacts = contacts_at_points(problem, centres - profile.probe * normals, normals)
    for place in np.flatnonzero(~contacts.possible):
        what = f"the follower cannot touch this point: {problem.setup.mechanism.assembly}"
        raise file_mistake(points.file, f"row {points.rows[place]}", None, what)
    dense, dense_normals = _polar_curve_points_and_normals(curve, dense_angles, side)
    is_reached = _cutting_depth(
        problem, smooth - profile.probe * normals, normals, dense - profile.probe * dense_normals
    ) <= (allowed.rms or allowed.band)
    if is_reached.sum() < FEWEST_MEASURED:
        what = f"the follower touches {is_reached.sum()} of {is_reached.size} points; it needs {FEWEST_MEASURED}"
        raise file_mistake(points.file, "points", None, what)
    positions = np.degrees(contacts.positions) if problem.setup.angular else contacts.positions
    angles = forward_angle_deg(0.0, np.degrees(contacts.angles))
    order = np.flatnonzero(is_reached)[np.argsort(angles[is_reached], kind="stable")]
    step = points.step * float(np.ptp(positions) / np.ptp(points.lifts))
    followed_points = MeasuredPoints(
        points.file, angles[order], positions[order], points.rows[order], step, TURN_DEG
    )
    outliers = np.flatnonzero(np.isin(followed_points.rows, points.rows[list(outlier_places)])).tolist()
    unreached = np.sort(points.rows[~is_reached])
    return FollowedProfile(problem, profile.probe, followed_points, outliers, centres, points.rows, unreached)


def _least_jerk_polar_curve(points: MeasuredPoints, allowed: AllowedDeviation) -> LeastJerkCurve:
    """The closed curve of least jerk of the distances, within the allowed deviation from the points."""
    try:
        return least_jerk_curve(points, allowed)
    except Unsolved as error:
        raise Unsolved(
            f"{points.file}: no smooth curve within {allowed.band:.4g} mm of the points: {error}"
        ) from None


def _polar_curve_points_and_normals(
    curve: LeastJerkCurve, angles: FloatArray, angle_sense: float
) -> tuple[ComplexArray, ComplexArray]:
    """Points x + iy of a curve by its distance R from the axis, and outward normals R + R'·i·side."""
    up = np.exp(1j * (np.pi / 2.0 - angle_sense * np.radians(angles)))
    distances = curve.lifts_at(angles)
    normals = (distances + 1j * angle_sense * curve.slopes_at(angles)) * up
    return distances * up, normals / np.abs(normals)


def _dense_angles(points: MeasuredPoints, band: float) -> FloatArray:
    """Angles close to each other, except in gaps without points.

    Raises
    ------
    BadInput
        If a gap is not on the base circle.
    """
    missing = places_before_gaps(points)
    for k in missing:
        if max(points.lifts[k], points.lifts[(k + 1) % points.angles.size]) - points.lifts.min() > 2.0 * band:
            raise gap_mistake(points, k, "this is not on the base circle")
    starts = np.delete(points.angles, missing)
    steps = np.delete(np.diff(points.angles, append=points.angles[0] + TURN_DEG), missing)
    parts = -(-CURVE_POINTS // points.angles.size)
    return np.asarray((starts[:, None] + steps[:, None] * np.arange(parts) / parts).ravel())


def _cutting_depth(
    problem: Problem, profile: ComplexArray, normals: ComplexArray, other_profile_points: ComplexArray
) -> FloatArray:
    """Depth to which a follower at points of a profile cuts into the rest of it [mm]."""
    if not problem.setup.mechanism.flat_faced:
        radius = problem.design.roller_radius[0]
        centres = profile + radius * normals
        nearest, _ = cKDTree(_xy_coordinates(other_profile_points)).query(_xy_coordinates(centres))
        return np.asarray(radius - nearest)
    furthest = [
        np.max((other_profile_points * directions[:, None].conjugate()).real, axis=1)
        for directions in np.array_split(normals, -(-normals.size // DIRECTIONS_AT_ONCE))
    ]
    return np.concatenate(furthest) - (profile * normals.conjugate()).real


def _xy_coordinates(points: ComplexArray) -> FloatArray:
    return np.column_stack([points.real, points.imag])
