"""Oscillating followers: limits that are linear in the position of the cam centre, relative to the pivot.

Let the x axis run along the follower's lowest position. The cam centre then lies at (u, v) = c·(cos ψ₀, sin ψ₀).
Let w be the length l of the arm or the offset f of the face. At every cam angle the limits on the pressure angle,
and all limits of a flat face, are linear in (u, v, w), with q = 1 ± ψ':

    arm            |l·q − c·cos ψ| ≤ T·c·sin ψ                       prime radius √((u − l)² + v²)
    face           |f|·q ≤ T·c·cos ψ                                 base radius f + v
                   f + c·(sin ψ·(2q − 1)/q² + cos ψ·ψ''/q³) ≥ ρ
                   c·cos ψ ≤ t·q
    cylinder       |l·ψ' ± R_m·sin ψ| ≤ T·R_m·cos ψ                  mean radius u, with w = l

where c·cos ψ = u·cos y − v·sin y and c·sin ψ = u·sin y + v·cos y. For an arm these half-planes are Flocke's
construction (K. A. Flocke, Zur Konstruktion von Kurvengetrieben bei Verarbeitungsmaschinen, VDI-Forschungsheft 345,
1931).

The centre distance has a range, so (u, v) lies in a ring. The smallest cam within the planes is therefore not the
solution of a linear programme. With two or three unknowns, all points where the smallest cam can lie are listed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from math import inf
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import LARGEST, LEAST, Curve, FloatArray
from camopt.model.mechanisms import oscillating_flat
from camopt.model.mechanisms.design import SizeBounds
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES
from camopt.scene.problem.problem import Problem, constraints_on_curve
from camopt.solve.smallest.closed_form import pressure_tangents_by_stroke

PLANE_TOLERANCE = 1e-12  # relative: by how much rounding may exceed a plane
PARALLEL_SINE = 1e-13  # planes with a smaller sine between them count as parallel

Planes = FloatArray
"""(m, 4): a·u + b·v + c·w ≥ d, the normal (a, b, c) of length 1."""


class LinearLimit(NamedTuple):
    """A limit that is linear in (u, v, w) at each cam angle."""

    curve: Curve
    """The mechanism's curve that is limited."""
    kinds: int
    goals: tuple[int, ...]
    """The extremes of the curve that are limited."""
    plane: Callable[..., tuple[Any, Any, Any, Any]]
    """From +1 for the largest value or −1 for the least, and the motion (y, y', y''), to (a, b, c, d)."""

    def planes(self, motion: FloatArray) -> list[Planes]:
        """The planes at cam angles (m,), for each goal."""
        planes = []
        for goal in self.goals:
            parts = self.plane(1.0 if goal == LARGEST else -1.0, *motion)
            rows = np.stack(np.broadcast_arrays(*parts, motion[0])[:4], axis=1)
            lengths = np.linalg.norm(rows[:, :3], axis=1, keepdims=True)
            planes.append(rows / np.where(lengths > 0.0, lengths, 1.0))  # a groove at rest may give 0 ≥ 0
        return planes


@dataclass(frozen=True)
class LinearForm:
    """The limits and sizes of a mechanism in the unknowns (u, v, w)."""

    limits: Callable[[Problem], list[LinearLimit]]
    range_planes: Callable[[Programme, SizeBounds], Planes]
    """The planes that come from assembly and from ranges of sizes."""
    least_point: Callable[[Planes, SizeBounds], FloatArray | None]
    """The (u, v, w) of least size within planes and the ranges of the sizes; None if there is none."""
    sizes: Callable[[FloatArray, float], dict[str, float]]
    """The sizes at (u, v, w), for a roller radius."""


def _pressure_angle_limits(problem: Problem, plane: Callable[..., tuple[Any, ...]]) -> list[LinearLimit]:
    """The limits on the pressure angle; ``plane`` takes tan β, then the arguments of ``LinearLimit.plane``."""
    curve = problem.setup.mechanism.pressure
    return [
        LinearLimit(curve, kinds, (LARGEST, LEAST), partial(plane, tangent))
        for tangent, kinds in pressure_tangents_by_stroke(problem)
    ]


# Arms with a trace point


def _linear_arm_limits(problem: Problem) -> list[LinearLimit]:
    sense = problem.design.sense

    def pressure_angle_plane(tangent: float, sign: float, y: Any, y1: Any, y2: Any) -> tuple[Any, ...]:
        s, c = np.sin(y), np.cos(y)
        return tangent * s + sign * c, tangent * c - sign * s, -sign * (1.0 + sense * y1), 0.0

    return _pressure_angle_limits(problem, pressure_angle_plane)


def _arm_end_position_planes(programme: Programme, bounds: SizeBounds) -> Planes:
    """The planes of the ranges: sin ψ ≥ 0 in both end positions of the arm."""
    return np.array([[0.0, 1.0, 0.0, 0.0], [np.sin(programme.lift), np.cos(programme.lift), 0.0, 0.0]])


def _smallest_arm_cam_point(planes: Planes, bounds: SizeBounds) -> FloatArray | None:
    """The cam centre and arm of least prime radius: found for an arm of length 1, then scaled.

    The arm is as short as the ranges allow, so the prime radius is |O − 1|·max(l₁, c₁/|O|). Its least value lies on
    a line where one of the two factors is stationary, where two lines meet, or where a line meets a circle on which
    a range ends.
    """
    arms, (nearest, farthest) = bounds["arm_length"], bounds["centre_distance"]
    lengths = np.linalg.norm(planes[:, :2], axis=1)
    normal, height = planes[:, :2] / lengths[:, None], (planes[:, 3] / arms[0] - planes[:, 2]) / lengths
    circles = np.array([nearest / arms[1], nearest / arms[0], farthest / arms[0]])
    along, ahead, square = np.stack([-normal[:, 1], normal[:, 0]], axis=1), -normal[:, 1], height**2
    foot = normal * height[:, None]
    spread = square - np.sum((foot - [1.0, 0.0]) ** 2, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(spread**2 + 4.0 * ahead**2 * square)
        steps = [ahead, *((spread + sign * root) / (-2.0 * ahead) for sign in (1.0, -1.0))]
        steps += [sign * np.sqrt(r * r - square) for r in circles for sign in (1.0, -1.0)]
    points = np.concatenate(
        [*(foot + t[:, None] * along for t in steps), _line_crossings(normal, height), [[r, 0.0] for r in circles]]
    )
    distance = np.linalg.norm(points, axis=1)
    held = (distance >= circles[0] * (1.0 - PLANE_TOLERANCE)) & (distance <= circles[2] * (1.0 + PLANE_TOLERANCE))
    points, distance = points[held], distance[held]
    held = np.all(points @ normal.T >= height - PLANE_TOLERANCE * (1.0 + distance[:, None]), axis=1)
    points, distance = points[held], distance[held]
    if not len(points):
        return None
    arm = np.clip(nearest / distance, *arms)
    best = np.argmin(np.hypot(points[:, 0] - 1.0, points[:, 1]) * arm)
    return np.asarray(arm[best] * np.array([*points[best], 1.0]))


def _line_crossings(normal: FloatArray, height: FloatArray) -> FloatArray:
    i, j = np.triu_indices(len(height), 1)
    cross = normal[i, 0] * normal[j, 1] - normal[i, 1] * normal[j, 0]
    i, j, cross = (each[np.abs(cross) > PARALLEL_SINE] for each in (i, j, cross))
    x = (height[i] * normal[j, 1] - height[j] * normal[i, 1]) / cross
    y = (normal[i, 0] * height[j] - normal[j, 0] * height[i]) / cross
    return np.stack([x, y], axis=1)


def _arm_cam_sizes_at_point(point: FloatArray, roller_radius: float) -> dict[str, float]:
    u, v, w = map(float, point)
    return {
        "arm_length": w,
        "centre_distance": float(np.hypot(u, v)),
        "size": float(np.hypot(u - w, v)) - roller_radius,
    }


# Flat faces


def _linear_face_limits(problem: Problem) -> list[LinearLimit]:
    mechanism, sense = oscillating_flat.MECHANISM, problem.design.sense
    if not oscillating_flat.least_relative_turning_rate(sense, problem.programme) > 0.0:
        return []  # no face of any size stays in contact

    def pressure_angle_plane(tangent: float, sign: float, y: Any, y1: Any, y2: Any) -> tuple[Any, ...]:
        return tangent * np.cos(y), -tangent * np.sin(y), -sign * (1.0 + sense * y1), 0.0

    limits = _pressure_angle_limits(problem, pressure_angle_plane)
    for constraint in constraints_on_curve(problem, mechanism.profile_radius):

        def curvature_radius_plane(
            sign: float, y: Any, y1: Any, y2: Any, least: float = -constraint.upper_bound_of_each_side()
        ) -> tuple[Any, ...]:
            s, c, q = np.sin(y), np.cos(y), 1.0 + sense * y1
            a, b = (2.0 * q - 1.0) / q**2, y2 / q**3
            return s * a + c * b, c * a - s * b, 1.0, least

        limits.append(LinearLimit(mechanism.profile_radius, ALL_STROKES, (LEAST,), curvature_radius_plane))
    for constraint in (each for each in constraints_on_curve(problem, mechanism.reach) if each.goal != LEAST):

        def reach_plane(
            sign: float, y: Any, y1: Any, y2: Any, most: float = constraint.upper_bound_of_each_side()
        ) -> tuple[Any, ...]:
            return -np.cos(y), np.sin(y), 0.0, -most * (1.0 + sense * y1)

        limits.append(LinearLimit(mechanism.reach, ALL_STROKES, (LARGEST,), reach_plane))
    return limits


def _face_range_planes(programme: Programme, bounds: SizeBounds) -> Planes:
    """cos ψ ≥ 0 in both end positions, the range of the offset, and the least base radius."""
    (low, high), least = bounds["face_offset"], bounds["size"][0]
    s, c = np.sin(programme.lift), np.cos(programme.lift)
    half = np.sqrt(0.5)
    return np.array(
        [
            [1.0, 0.0, 0.0, 0.0],
            [c, -s, 0.0, 0.0],
            [0.0, 0.0, 1.0, low],
            [0.0, 0.0, -1.0, -high],
            [0.0, half, half, half * least],
        ]
    )


def _smallest_face_cam_point(planes: Planes, bounds: SizeBounds) -> FloatArray | None:
    """The point of least base radius v + w.

    It lies where three planes meet, where two planes meet a cylinder of the least or largest centre distance, or
    where v + w is stationary on the ellipse in which a plane cuts such a cylinder.
    """
    nearest, farthest = bounds["centre_distance"]
    candidates = [_plane_corners(planes)]
    for radius in {nearest, farthest}:
        candidates += [_edge_cylinder_crossings(planes, radius), _stationary_ellipse_points(planes, radius)]
    points = np.concatenate(candidates)
    distance = np.hypot(points[:, 0], points[:, 1])
    held = (distance >= nearest * (1.0 - PLANE_TOLERANCE)) & (distance <= farthest * (1.0 + PLANE_TOLERANCE))
    points = points[held]
    scale = 1.0 + np.linalg.norm(points, axis=1)
    points = points[np.all(points @ planes[:, :3].T >= planes[:, 3] - PLANE_TOLERANCE * scale[:, None], axis=1)]
    return points[np.argmin(points[:, 1] + points[:, 2])] if len(points) else None


def _plane_corners(planes: Planes) -> FloatArray:
    """The points where three planes meet."""
    triples = planes[np.array(list(combinations(range(len(planes)), 3)))]
    triples = triples[np.abs(np.linalg.det(triples[:, :, :3])) > PARALLEL_SINE]
    return np.asarray(np.linalg.solve(triples[:, :, :3], triples[:, :, 3:])[:, :, 0])


def _edge_cylinder_crossings(planes: Planes, radius: float) -> FloatArray:
    """The points where the line common to two planes pierces the cylinder |(u, v)| = radius."""
    i, j = np.triu_indices(len(planes), 1)
    along = np.cross(planes[i, :3], planes[j, :3])
    steep = np.sum(along[:, :2] ** 2, axis=1) > PARALLEL_SINE**2
    i, j, along = i[steep], j[steep], along[steep]
    first = np.linalg.solve(
        np.stack([planes[i, :3], planes[j, :3], along], axis=1),
        np.stack([planes[i, 3], planes[j, 3], np.zeros(len(i))], axis=1)[:, :, None],
    )[:, :, 0]
    a, b = np.sum(along[:, :2] ** 2, axis=1), np.sum(along[:, :2] * first[:, :2], axis=1)
    room = b * b - a * (np.sum(first[:, :2] ** 2, axis=1) - radius**2)
    index = np.flatnonzero(room >= 0.0)
    steps = [(-b[index] + sign * np.sqrt(room[index])) / a[index] for sign in (1.0, -1.0)]
    return np.concatenate([first[index] + t[:, None] * along[index] for t in steps])


def _stationary_ellipse_points(planes: Planes, radius: float) -> FloatArray:
    """The points where v + w is stationary on the cut of a plane with the cylinder |(u, v)| = radius."""
    sloped = planes[np.abs(planes[:, 2]) > PARALLEL_SINE]
    slope = np.stack([-sloped[:, 0] / sloped[:, 2], 1.0 - sloped[:, 1] / sloped[:, 2]], axis=1)
    slope = slope / np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), PARALLEL_SINE)
    both = np.concatenate([radius * slope, -radius * slope])
    twice = np.concatenate([sloped, sloped])
    offset = (twice[:, 3] - np.sum(twice[:, :2] * both, axis=1)) / twice[:, 2]
    return np.concatenate([both, offset[:, None]], axis=1)


def _face_cam_sizes_at_point(point: FloatArray, roller_radius: float) -> dict[str, float]:
    u, v, w = map(float, point)
    return {"face_offset": w, "centre_distance": float(np.hypot(u, v)), "size": v + w}


# Cylindrical cams


def _linear_groove_limits(problem: Problem) -> list[LinearLimit]:
    sense, half = problem.design.sense, problem.programme.lift / 2

    def pressure_angle_plane(tangent: float, sign: float, y: Any, y1: Any, y2: Any) -> tuple[Any, ...]:
        return tangent * np.cos(y - half) - sign * sense * np.sin(y - half), 0.0, -sign * y1, 0.0

    return _pressure_angle_limits(problem, pressure_angle_plane)


def _groove_range_planes(programme: Programme, bounds: SizeBounds) -> Planes:
    return np.array([[1.0, 0.0, 0.0, bounds["size"][0]]])


def _smallest_groove_cam_point(planes: Planes, bounds: SizeBounds) -> FloatArray | None:
    """The point of least mean radius, with the shortest arm: longer arms need larger mean radii."""
    arm = bounds["arm_length"][0]
    a, rest = planes[:, 0], planes[:, 3] - planes[:, 2] * arm
    rising, falling = a > PARALLEL_SINE, a < -PARALLEL_SINE
    least = float(np.max(rest[rising] / a[rising]))
    most = float(np.min(rest[falling] / a[falling], initial=inf))
    possible = least <= most and bool(np.all(rest[~(rising | falling)] <= PLANE_TOLERANCE * arm))
    return np.array([least, 0.0, arm]) if possible else None


def _groove_cam_sizes_at_point(point: FloatArray, roller_radius: float) -> dict[str, float]:
    return {"size": float(point[0]), "arm_length": float(point[2])}


ARM_FORM = LinearForm(
    _linear_arm_limits, _arm_end_position_planes, _smallest_arm_cam_point, _arm_cam_sizes_at_point
)
FACE_FORM = LinearForm(_linear_face_limits, _face_range_planes, _smallest_face_cam_point, _face_cam_sizes_at_point)
GROOVE_FORM = LinearForm(
    _linear_groove_limits, _groove_range_planes, _smallest_groove_cam_point, _groove_cam_sizes_at_point
)
