"""Exact curves of the cam: pitch curve, profile, flank of a groove, or path of a cutter.

Each curve lies at a distance d along the normal of the pitch curve. With the trace point t and the unit normal n in
the ground frame it is

    p(θ) = e^{∓iθ}·(t + d·n)    (disc; the rotation is absent for a developed cylindrical cam)

and its tangent is ∓i·e^{∓iθ}·n. The curve is smooth on each span of the turn on which the motion is smooth. Where
the velocity jumps, the normal jumps. There a pitch curve has a corner and an offset curve a gap.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import factorial
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import UNIT_ROUNDOFF, ComplexArray, FloatArray, IndexArray, Number
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.motion_ranges import derivative_intervals_over_parts, part_middles_and_angle_intervals
from camopt.core.numerics.sloped_interval import range_of
from camopt.core.numerics.taylor import Taylor
from camopt.model.mechanisms.design import Designs, Mechanism
from camopt.model.mechanisms.geometry import curve_distances_along_normal
from camopt.model.motion.derived_laws import SkewedLaw
from camopt.model.motion.programme import Programme, weighted_derivative_range
from camopt.model.motion.scca import SCCALaw
from camopt.model.motion.stroke import ALL_STROKES, Stroke
from camopt.scene.problem.problem import Problem

REMAINDER_DERIVATIVES = 4
"""Number of derivatives of the motion that the remainder of a series needs."""
CURVE_ANGLE_ROUNDING = 16.0 * np.pi * UNIT_ROUNDOFF
"""Largest rounding error of a cam angle within its stroke [rad]."""


@dataclass(frozen=True)
class SmoothSpan:
    """A part of a stroke on which the motion is smooth, between the cam angles ``start`` and ``end`` (rad)."""

    stroke: Stroke
    start: float
    end: float

    @property
    def is_dwell(self) -> bool:
        """Whether the follower stands still over the span."""
        return self.stroke.law is None


class Expansion(NamedTuple):
    """Taylor series of x and y (mm) about the middles of stretches, in the cam angle (rad) from the middle.

    ``at_middles`` has the coefficients at the middles. ``over_stretches`` has ranges of the coefficients over the
    whole stretches; its last term is the remainder. ``half_widths`` are those of the stretches (rad).
    """

    at_middles: tuple[Taylor, Taylor]
    over_stretches: tuple[Taylor, Taylor]
    half_widths: FloatArray


@dataclass(frozen=True)
class CamCurve:
    """A curve of one design, at a distance (mm, positive outwards) along the normal of the pitch curve or face."""

    mechanism: Mechanism
    design: Designs
    programme: Programme
    distance: float
    spans: tuple[SmoothSpan, ...]
    mirror: float = 1.0
    """−1 for a curve that is mirrored in the x axis, as the second disc of a pair is (``mechanisms.pairs``)."""

    @property
    def is_closed(self) -> bool:
        """Whether the curve ends where it starts: true for a disc cam, false for a developed cylinder."""
        return self.mechanism.body.closed

    @property
    def frame_rotation_sense(self) -> float:
        """Sense in which the cam's frame turns: +1 opposite to a ccw cam, 0 for a developed cylinder."""
        return 0.0 if self.mechanism.body.developed else self.mirror * self.design.sense

    def coordinates(self, angle: Number, y: Number, y1: Number) -> tuple[Number, Number]:
        """x and y of the curve [mm] from the cam angle (rad), y and y', as arrays or as Taylor series."""
        contact = self.mechanism.contact(self.design, self.programme.lift, angle, y, y1)
        x, height = contact.x, contact.y
        if self.distance:
            length = np.sqrt(np.square(contact.across) + np.square(contact.up))
            x, height = x + contact.across / length * self.distance, height + contact.up / length * self.distance
        height = height * self.mirror
        if not self.frame_rotation_sense:
            return x, height
        cosine, sine = np.cos(angle), np.sin(angle) * self.frame_rotation_sense
        return x * cosine + height * sine, height * cosine - x * sine

    def points(self, span: SmoothSpan, angles: FloatArray) -> ComplexArray:
        """Points x + iy [mm] at cam angles (rad) of a span."""
        y, y1, *_ = span.stroke.motion(angles)
        x, height = self.coordinates(angles, y, y1)
        points: ComplexArray = x + 1j * height
        return points

    def points_with_derivatives(self, span: SmoothSpan, angles: FloatArray) -> tuple[ComplexArray, ...]:
        """Points [mm] and their first two derivatives by the cam angle, at cam angles (rad) of a span."""
        y, y1, y2, y3 = span.stroke.motion(angles)
        x, height = self.coordinates(Taylor([angles, 1.0, 0.0]), Taylor([y, y1, y2 / 2]), Taylor([y1, y2, y3 / 2]))
        return tuple(x.derivative(k) + 1j * height.derivative(k) for k in range(3))

    def evaluate_by_span(self, angles: FloatArray, function: Callable[[SmoothSpan, FloatArray], Any]) -> Any:
        """Values of a function of span and cam angles, at cam angles of the turn (rad, in any order).

        At a jump, the value after it.
        """
        numbers = self.span_index_at_each_angle(angles)
        by_span = [(k, function(self.spans[k], angles[numbers == k])) for k in np.unique(numbers)]
        out = np.empty(angles.shape, dtype=by_span[0][1].dtype)
        for k, values in by_span:
            out[numbers == k] = values
        return out

    def span_index_at_each_angle(self, angles: FloatArray) -> IndexArray:
        """Index of the span that contains each cam angle (rad); where two spans meet, of the second."""
        starts = np.array([span.start for span in self.spans])
        return np.maximum(np.searchsorted(starts, angles, side="right") - 1, 0)

    def curvatures(self, span: SmoothSpan, angles: FloatArray) -> FloatArray:
        """Curvature Im(p'*·p'')/|p'|³ [1/mm] at cam angles (rad) of a span, positive where the curve turns left."""
        _, first, second = self.points_with_derivatives(span, angles)
        curvature: FloatArray = (first.conjugate() * second).imag / np.abs(first) ** 3
        return curvature

    def tangents(self, span: SmoothSpan, angles: FloatArray) -> ComplexArray:
        """Unit tangents in the sense of growing cam angle, at cam angles (rad) of a span."""
        return -1j * (self.frame_rotation_sense or self.mirror) * self.normals(span, angles)

    def normals(self, span: SmoothSpan, angles: FloatArray) -> ComplexArray:
        """Outward unit normals at cam angles (rad) of a span."""
        y, y1, *_ = span.stroke.motion(angles)
        contact = self.mechanism.contact(self.design, self.programme.lift, angles, y, y1)
        normal = contact.across + 1j * self.mirror * contact.up + np.zeros(angles.shape)
        turned: ComplexArray = normal / np.abs(normal) * np.exp(-1j * self.frame_rotation_sense * angles)
        return turned

    def taylor_expansion(
        self, spans: Sequence[SmoothSpan], start_angles: FloatArray, end_angles: FloatArray
    ) -> Expansion:
        """Taylor series of the curve over stretches from ``start_angles`` to ``end_angles`` [rad].

        Each stretch lies in its span of ``spans``. The remainders come from ranges of the motion: they are proved,
        but for the rounding of later operations.
        """
        middles = (start_angles + end_angles) / 2
        here, over = (
            enclose_motion_derivatives(self.programme, spans, *ends)
            for ends in ((middles, middles), (start_angles, end_angles))
        )
        at_middles = self._coordinate_series(middles, [(row.low + row.high) / 2 for row in here])
        return Expansion(
            at_middles,
            self._coordinate_series(Interval(start_angles, end_angles), over),
            (end_angles - start_angles) / 2,
        )

    def _coordinate_series(self, angle: Any, rows: list[Any]) -> tuple[Taylor, Taylor]:
        """Taylor series of x and y, from y and its derivatives by the cam angle (``rows``)."""
        y, y1 = (Taylor([row / factorial(k) for k, row in enumerate(terms)]) for terms in (rows[:-1], rows[1:]))
        return self.coordinates(Taylor([angle, 1.0, *[0.0] * (len(rows) - 3)]), y, y1)


class Disc(NamedTuple):
    """One disc of a cam, or one flank of its rib, as an ordinary cam on the common shaft."""

    problem: Problem
    """The problem of this disc alone; for a mirrored disc, that of its mirror image."""
    number: int = 1
    """Number of the disc in a pair, from 1."""
    mirror: float = 1.0
    """−1 where ``problem`` has the mirror image, in the x axis of the frame that both discs share."""

    @property
    def curve_name_prefix(self) -> str:
        return "second_" if self.number == SECOND_DISC else ""

    def curves(self, cutter_radius: float | None = None) -> dict[str, CamCurve]:
        """The disc's curves by name, in the cam's frame: ``pitch``, ``profile`` and, with a cutter, ``cutter``.

        A groove has two profiles, ``profile_left`` and ``profile_right``, and two cutter paths. A flat face has no
        pitch curve.
        """
        distances = curve_distances_along_normal(
            self.problem.setup.mechanism, self.problem.wall_distance_from_pitch_curve, cutter_radius
        )
        curve = replace(pitch_or_face_curve(self.problem), mirror=self.mirror)
        return {name: replace(curve, distance=distance) for name, distance in distances.items()}


def cam_discs(problem: Problem) -> tuple[Disc, ...]:
    """The discs of a problem's design, each as an ordinary cam: one, or two for a pair.

    The discs of a rib are its flanks, each with its roller (``mechanisms.ribs``). The second disc of a conjugate
    pair is the mirror image of an ordinary cam with the reversed motion (``mechanisms.pairs``). So code for one
    disc serves both.
    """
    if not problem.setup.mechanism.has_two_profiles:
        return (Disc(problem),)
    first, second = problem.problem_of_each_contact
    (contact,) = problem.setup.mechanism.further_contacts
    return Disc(first), Disc(second, number=SECOND_DISC, mirror=-1.0 if contact.mechanism.reverses else 1.0)


def disc_curves(
    problem: Problem, cutter_radius: float | None = None, disc_number: int | None = None
) -> dict[str, CamCurve]:
    """Curves of all discs by name, as in ``Disc.curves``; names of the second disc begin with ``second_``.

    ``disc_number`` selects the disc with that number.
    """
    return {
        f"{disc.curve_name_prefix}{name}": curve
        for disc in cam_discs(problem)
        if disc_number in (None, disc.number)
        for name, curve in disc.curves(cutter_radius).items()
    }


SECOND_DISC = 2
"""The number of the second disc of a pair."""


def pitch_or_face_curve(problem: Problem) -> CamCurve:
    """The pitch curve of a problem's design; for a flat face, the curve of the face itself."""
    spans = tuple(smooth_spans(problem.programme))
    return CamCurve(problem.setup.mechanism, problem.design, problem.programme, 0.0, spans)


def pitch_curve_axial_extent(problem: Problem) -> tuple[float, float]:
    """Lowest and highest position of the pitch curves along the cam's axis [mm], from the ends of the motion."""
    curves = [(disc, pitch_or_face_curve(disc.problem)) for disc in cam_discs(problem)]
    places = [
        curve.coordinates(0.0, y, 0.0)
        for disc, curve in curves
        for y in weighted_derivative_range(disc.problem.programme, (1,), ALL_STROKES)
    ]
    ends = [float(np.mean(height)) for _, height in places]
    return min(ends), max(ends)


def centred_cylinder_ends(problem: Problem, length: float) -> tuple[float, float]:
    """Positions of the two ends of a cylinder along its axis [mm]; the groove or rib is in its middle."""
    middle = sum(pitch_curve_axial_extent(problem)) / 2
    return middle - length / 2, middle + length / 2


def smooth_spans(programme: Programme) -> Iterator[SmoothSpan]:
    for stroke in programme.strokes:
        for ends in pairwise(
            (0.0, 1.0)
            if stroke.law is None
            else sorted({*stroke.law.BREAKS, *_joint_between_wave_halves(stroke.law)})
        ):
            yield SmoothSpan(stroke, *(stroke.start + stroke.angle * x for x in ends))


def _joint_between_wave_halves(law: Any) -> tuple[float, ...]:
    """The joint between the halves of a law of waves (share of the stroke): paths have a joint there."""
    if not isinstance(law, SkewedLaw) and hasattr(law, "law"):
        return _joint_between_wave_halves(law.law)
    return (0.5,) if isinstance(law, SCCALaw) and not law.shares[-1] else ()


def enclose_motion_derivatives(
    programme: Programme, spans: Sequence[SmoothSpan], start_angles: FloatArray, end_angles: FloatArray
) -> list[Interval]:
    """Ranges of y and its first four derivatives over stretches between cam angles (rad), each within its span."""
    table = replace(programme, load=None).table
    begin, end = table.centre - table.half_width, table.centre + table.half_width
    inside = (table.centre > np.array([[s.start] for s in spans])) & (
        table.centre < np.array([[s.end] for s in spans])
    )
    first_angles, last_angles = start_angles - CURVE_ANGLE_ROUNDING, end_angles + CURVE_ANGLE_ROUNDING
    meets = inside & (begin <= last_angles[:, None]) & (end >= first_angles[:, None])  # also between rounded ends
    stretch, panel = np.nonzero(meets)
    centre, half = table.centre[panel], table.half_width[panel]
    ends = (np.clip((angle[stretch] - centre) / half, -1.0, 1.0) for angle in (first_angles, last_angles))
    derivatives = derivative_intervals_over_parts(
        table, panel, *part_middles_and_angle_intervals(table, panel, *ends), REMAINDER_DERIVATIVES
    )
    first = np.flatnonzero(np.diff(stretch, prepend=-1))
    return [
        Interval(np.minimum.reduceat(row.low, first), np.maximum.reduceat(row.high, first))
        for row in map(range_of, derivatives)
    ]
