"""Paths of lines, tangent arcs or cubics that follow a cam curve within a given deviation, with the proof.

Each element replaces a stretch of the curve between two of its points. The deviation of lines, arcs and cubics
falls with the square, cube and fourth power of the length of the stretch. With this order a few rounds find
stretches of equal deviation, so the number of elements is the least (equidistribution: de Boor, A Practical Guide
to Splines, ch. 12).

A biarc is two arcs that join with a common tangent and have the tangents t₀, t₁ at the points p₀, p₁. If their
control polygons have equal lengths d, the arcs meet half-way between p₀ + d·t₀ and p₁ − d·t₁, where

    d = |v|²/(v·T + √((v·T)² + |v|²·|t₁ − t₀|²)),    v = p₁ − p₀,  T = t₀ + t₁

Source: Bolton, Biarc curves, Computer-Aided Design 7 (1975); Meek and Walton, CAD 24 (1992).
"""

from collections.abc import Callable
from functools import partial
from math import isfinite
from typing import NamedTuple

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import ComplexArray, FloatArray
from camopt.solve.contour.curve import CamCurve, SmoothSpan
from camopt.solve.contour.deviation import deviation_upper_bound
from camopt.solve.contour.path import ArcPath, CubicPath

FIRST_STRETCHES, FIT_ROUNDS, END_HALVINGS = 8, 8, 40
JOINT_STEPS = 8  # steps that locate a joint to within rounding
LEAST_JOINT_DISTANCE = 1e-300  # mm: keeps a division from being by zero
WIDEST_ARC = 3.0  # rad: no arc is longer, so that its middle lies on the same side of the cam
CHECKED_SHARES = np.linspace(0.0, 1.0, 13)[1:-1, None]  # shares of a stretch at which its deviation is measured
ELEMENT_LIMIT = 1_000_000  # elements of a path
SAME_CURVATURE = 1e-9  # two arcs with a smaller relative difference of curvature become one
SAME_VERTEX_ANGLE = 1e-12  # rad
LEAST_RISE = 1e-9  # mm: an arc that rises less above its chord becomes a line


class Biarcs(NamedTuple):
    """Pairs of tangent arcs: first, middle and last points, and the bulges of both arcs."""

    first: ComplexArray
    joint: ComplexArray
    last: ComplexArray
    tangent: ComplexArray
    """Unit tangent at the joint."""
    bulges: tuple[FloatArray, FloatArray]


def biarcs(p0: ComplexArray, t0: ComplexArray, p1: ComplexArray, t1: ComplexArray) -> Biarcs:
    """The biarcs from points p0 with unit tangents t0 to points p1 with unit tangents t1."""
    v, both = p1 - p0, t0 + t1
    along = (v * both.conjugate()).real
    length = np.square(np.abs(v))
    d = length / (along + np.sqrt(np.square(along) + length * np.square(np.abs(t1 - t0))))
    joint = (p0 + p1 + d * (t0 - t1)) / 2
    tangent = (v - d * both) / (2.0 * d)
    bulges = np.tan(np.angle((joint - p0) / t0) / 2), np.tan(np.angle(t1 / (p1 - joint)) / 2)
    return Biarcs(p0, joint, p1, tangent / np.abs(tangent), bulges)


def distances_from_arc_circles(
    points: ComplexArray, first: ComplexArray, last: ComplexArray, bulges: FloatArray
) -> FloatArray:
    """Distance of points from the circles of arcs [mm]."""
    turn = 2.0 * np.arctan(bulges)
    chord = last - first
    local = (points - first) * (np.exp(1j * turn) * chord.conjugate() / np.abs(chord))
    curvature = 2.0 * np.sin(turn) / np.abs(chord)
    height = local.imag - curvature / 2 * np.square(np.abs(local))
    distance: FloatArray = 2.0 * np.abs(height) / (1.0 + np.sqrt(np.maximum(1.0 - 2.0 * curvature * height, 0.0)))
    return distance


def equal_error_angles(
    errors: Callable[[FloatArray, FloatArray], FloatArray], start: float, end: float, error_order: int, chord: float
) -> FloatArray:
    """Cam angles from start to end that divide the span into stretches of about equal error, at most ``chord``.

    ``errors`` gives the deviation over stretches [mm], from their first and last cam angles. Raises BadInput if
    that needs more than ``ELEMENT_LIMIT`` stretches.
    """
    least = int(np.ceil((end - start) / WIDEST_ARC))
    angles = np.linspace(start, end, max(FIRST_STRETCHES, least) + 1)
    for attempt in range(FIT_ROUNDS):
        need = np.maximum((errors(angles[:-1], angles[1:]) / chord) ** (1.0 / error_order), 1e-3)
        if attempt and need.max() <= 1.0:
            return angles
        wanted = np.concatenate([[0.0], np.cumsum(need)])
        count = max(least, int(np.ceil(wanted[-1] * (1.0 + 0.02 * attempt))))
        _check_element_count(count, chord)
        angles = np.interp(np.linspace(0.0, wanted[-1], count + 1), wanted, angles)
        angles[0], angles[-1] = start, end
    for _ in range(END_HALVINGS):
        wide = errors(angles[:-1], angles[1:]) > chord
        if not wide.any():
            break
        angles = np.sort(np.concatenate([angles, ((angles[:-1] + angles[1:]) / 2)[wide]]))
        _check_element_count(angles.size, chord)
    return angles


def _check_element_count(count: int, chord: float) -> None:
    if count > ELEMENT_LIMIT:
        raise BadInput(
            [Mistake("camopt", "chord", chord, f"larger: this one needs over {ELEMENT_LIMIT:,} elements")]
        )


class Fitter(NamedTuple):
    """The functions that fit one kind of element."""

    order: int
    """Power of the length of a stretch with which the deviation falls."""
    errors: Callable[[CamCurve, SmoothSpan, FloatArray, FloatArray], FloatArray]
    """Largest deviation of each stretch at the checked angles [mm], from its first and last cam angles."""
    path: Callable[[CamCurve, list[FloatArray]], "ArcPath | CubicPath"]
    """The path, from the cam angles at the joints of each span."""


def fit_unproved_path(curve: CamCurve, kind: str, chord: float) -> "ArcPath | CubicPath":
    """A path of a kind of ``FITTERS`` whose deviation at the checked angles is at most ``chord`` (mm)."""
    fitter = FITTERS[kind]
    angles = [
        equal_error_angles(partial(fitter.errors, curve, span), span.start, span.end, fitter.order, chord)
        for span in curve.spans
    ]
    return fitter.path(curve, angles)


def _deviation_check_angles(starts: FloatArray, ends: FloatArray) -> FloatArray:
    """Cam angles at which stretches are checked, shape (angles, stretches)."""
    return starts + (ends - starts) * CHECKED_SHARES


def _sampled_line_errors(curve: CamCurve, span: SmoothSpan, starts: FloatArray, ends: FloatArray) -> FloatArray:
    first, last = curve.points(span, starts), curve.points(span, ends)
    points = curve.points(span, _deviation_check_angles(starts, ends))
    return np.asarray(distances_from_arc_circles(points, first, last, np.zeros(starts.size)).max(axis=0))


def _span_biarcs(curve: CamCurve, span: SmoothSpan, starts: FloatArray, ends: FloatArray) -> Biarcs:
    t0, t1 = curve.tangents(span, starts), curve.tangents(span, ends)
    return biarcs(curve.points(span, starts), t0, curve.points(span, ends), t1)


def _sampled_biarc_errors(curve: CamCurve, span: SmoothSpan, starts: FloatArray, ends: FloatArray) -> FloatArray:
    pair, points = (
        _span_biarcs(curve, span, starts, ends),
        curve.points(span, _deviation_check_angles(starts, ends)),
    )
    halves = zip((pair.first, pair.joint), (pair.joint, pair.last), pair.bulges, strict=True)
    before, after = (distances_from_arc_circles(points, *half) for half in halves)
    past_joint = ((points - pair.joint) * pair.tangent.conjugate()).real > 0.0
    return np.asarray(np.where(past_joint, after, before).max(axis=0))


def _hermite_cubics(curve: CamCurve, span: SmoothSpan, starts: FloatArray, ends: FloatArray) -> ComplexArray:
    """Control points of the cubics that have the curve's points and derivatives at both ends, shape (4, n)."""
    (p0, v0, _), (p1, v1, _) = (curve.points_with_derivatives(span, angles) for angles in (starts, ends))
    third = (ends - starts) / 3
    return np.array([p0, p0 + v0 * third, p1 - v1 * third, p1])


def _sampled_cubic_errors(curve: CamCurve, span: SmoothSpan, starts: FloatArray, ends: FloatArray) -> FloatArray:
    share = CHECKED_SHARES[:, None]
    weights = (1 - share) ** 3, 3 * share * (1 - share) ** 2, 3 * share**2 * (1 - share), share**3
    cubics = sum(w * p for w, p in zip(weights, _hermite_cubics(curve, span, starts, ends)[:, None], strict=True))
    return np.asarray(
        np.abs(
            curve.points(span, _deviation_check_angles(starts, ends)) - cubics.reshape(CHECKED_SHARES.size, -1)
        ).max(axis=0)
    )


def _fit_lines(curve: CamCurve, angles: list[FloatArray]) -> ArcPath:
    points = [curve.points(span, joints[:-1]) for span, joints in zip(curve.spans, angles, strict=True)]
    vertices = _append_last_or_closing_vertex(curve, np.concatenate(points))
    return ArcPath(vertices, np.zeros(vertices.size - 1), *_element_angles_and_spans(angles))


def polyline_through_angles(curve: CamCurve, angles: FloatArray) -> ArcPath:
    """The lines through the curve's points at rising cam angles (rad).

    A line that passes from one span to the next has an additional vertex there, on the line beside the curve.
    """
    points = curve.evaluate_by_span(angles, curve.points)
    inner = np.array([span.start for span in curve.spans[1:]])
    is_new = np.abs(inner[:, None] - angles).min(axis=1, initial=np.inf) > SAME_VERTEX_ANGLE
    inner = inner[is_new & (inner > angles[0]) & (inner < angles[-1])]
    if inner.size:
        line = np.searchsorted(angles, inner) - 1
        first, along = points[line], np.diff(points)[line]
        share = ((curve.evaluate_by_span(inner, curve.points) - first) * along.conjugate()).real / np.square(
            np.abs(along)
        )
        points = np.concatenate([points, first + share * along])
    places = np.concatenate([angles, inner])
    order = np.argsort(places, kind="stable")
    places, vertices = places[order], points[order]
    spans = curve.span_index_at_each_angle((places[:-1] + places[1:]) / 2)
    pairs = np.stack([places[:-1], places[1:]], axis=1)
    return ArcPath(vertices, np.zeros(vertices.size - 1), pairs, tuple(spans.tolist()))


def _fit_arcs(curve: CamCurve, angles: list[FloatArray]) -> ArcPath:
    """Both arcs of each biarc, or one arc where both have the same curvature."""
    vertices, bulges, joints = [], [], []
    for span, ends in zip(curve.spans, angles, strict=True):
        pair = _span_biarcs(curve, span, ends[:-1], ends[1:])
        first, second = (np.arctan(b) for b in pair.bulges)
        lengths = np.abs(pair.joint - pair.first), np.abs(pair.last - pair.joint)
        bend = np.sin(2 * first) / lengths[0], np.sin(2 * second) / lengths[1]
        one = np.abs(bend[0] - bend[1]) <= SAME_CURVATURE * np.maximum(np.abs(bend[0]), 1.0 / (lengths[0] * 1e3))
        keep = np.stack([np.ones(one.size, dtype=bool), ~one], axis=1)
        whole = np.stack([np.where(one, np.tan(first + second), pair.bulges[0]), pair.bulges[1]], axis=1)
        chords = np.stack([np.abs(np.where(one, pair.last, pair.joint) - pair.first), lengths[1]], axis=1)
        whole = np.where(np.abs(whole) * chords / 2 < LEAST_RISE, 0.0, whole)
        middles = _biarc_joint_angles(curve, span, pair, ends[:-1], ends[1:])
        vertices.append(np.stack([pair.first, pair.joint], axis=1)[keep])
        bulges.append(whole[keep])
        joints.append(np.append(np.stack([ends[:-1], middles], axis=1)[keep], ends[-1]))
    return ArcPath(
        _append_last_or_closing_vertex(curve, np.concatenate(vertices)),
        np.concatenate(bulges),
        *_element_angles_and_spans(joints),
    )


def _biarc_joint_angles(
    curve: CamCurve, span: SmoothSpan, pair: Biarcs, starts: FloatArray, ends: FloatArray
) -> FloatArray:
    """Cam angles at which the curve passes the joints of biarcs [rad], by the Illinois method.

    False position, in which the value at an end that stays is halved each time (Dowell and Jarratt, BIT 11, 1971).
    ``scipy.optimize.elementwise`` gives the same roots, but its import takes longer than an export.
    """

    def distance_past_joint(angles: FloatArray) -> FloatArray:
        return np.asarray(((curve.points(span, angles) - pair.joint) * pair.tangent.conjugate()).real)

    low, high = starts, ends
    before, after = distance_past_joint(low), distance_past_joint(high)
    side = np.zeros(low.size)  # of the last angle: 1 past the joint, −1 before it
    for _ in range(JOINT_STEPS):
        angle = low + np.clip(before / np.minimum(before - after, -LEAST_JOINT_DISTANCE), 0.0, 1.0) * (high - low)
        distance = distance_past_joint(angle)
        is_past = distance > 0.0
        before = np.where(is_past, np.where(side > 0.0, before / 2, before), distance)
        after = np.where(is_past, distance, np.where(side < 0.0, after / 2, after))
        low, high = np.where(is_past, low, angle), np.where(is_past, angle, high)
        side = np.where(is_past, 1.0, -1.0)
    return np.asarray(angle)


def _fit_cubics(curve: CamCurve, angles: list[FloatArray]) -> CubicPath:
    cubics = [
        _hermite_cubics(curve, span, ends[:-1], ends[1:]).T for span, ends in zip(curve.spans, angles, strict=True)
    ]
    return CubicPath(np.concatenate(cubics), *_element_angles_and_spans(angles))


def _append_last_or_closing_vertex(curve: CamCurve, vertices: ComplexArray) -> ComplexArray:
    """The vertices with the last one appended; for a closed curve it is exactly the first one."""
    last = curve.spans[-1]
    return np.append(vertices, vertices[:1] if curve.is_closed else curve.points(last, np.array([last.end])))


def _element_angles_and_spans(angles: list[FloatArray]) -> tuple[FloatArray, tuple[int, ...]]:
    """Pairs of cam angles of all elements, and the indices of their spans."""
    pairs = [np.stack([joints[:-1], joints[1:]], axis=1) for joints in angles]
    return np.concatenate(pairs), tuple(k for k, joints in enumerate(angles) for _ in joints[1:])


FITTERS = {
    "arcs": Fitter(3, _sampled_biarc_errors, _fit_arcs),
    "spline": Fitter(4, _sampled_cubic_errors, _fit_cubics),
    "polyline": Fitter(2, _sampled_line_errors, _fit_lines),
}
"""The fitters by the option ``curves`` of an export."""


DEFAULT_CHORD = 0.001  # mm
SHORTEST_CHORD, LONGEST_CHORD = 1e-6, 10.0  # mm
CHORD_AIM, SMALLER_AIM = 0.95, 0.8  # share of the chord that the first fit aims at; factor after a failed proof
PROOF_ROUNDS = 6


class FittedPath(NamedTuple):
    """A path with its proved deviation (mm): no point of path or curve is further from the other."""

    path: ArcPath | CubicPath
    deviation: float


def fit_path(curve: CamCurve, kind: str = "arcs", chord: float = DEFAULT_CHORD) -> FittedPath:
    """A path of a kind of ``FITTERS`` that is proved to be within ``chord`` (mm) of a curve.

    ``check_path_options`` has the permitted values.

    Raises
    ------
    BadInput
        If the chord needs over a million elements.
    """
    aim = CHORD_AIM * chord
    for _ in range(PROOF_ROUNDS):
        path = fit_unproved_path(curve, kind, aim)
        fitted = FittedPath(path, deviation_upper_bound(curve, path, chord))
        if fitted.deviation <= chord:
            break
        aim *= SMALLER_AIM
    return fitted


def check_path_options(kind: str, chord: float) -> None:
    """Raises BadInput for an unknown kind of path, or a chord outside 1e-6 to 10 mm."""
    mistakes = []
    if kind not in FITTERS:
        mistakes.append(Mistake("camopt", "curves", kind, f"one of {', '.join(FITTERS)}"))
    if not (isfinite(chord) and SHORTEST_CHORD <= chord <= LONGEST_CHORD):
        mistakes.append(Mistake("camopt", "chord", chord, f"from {SHORTEST_CHORD:g} to {LONGEST_CHORD:g} mm"))
    if mistakes:
        raise BadInput(mistakes)
