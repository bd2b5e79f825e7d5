"""An exact curve of the cam: pitch curve, profile, a flank of a groove, or the path of a cutter.

With the trace point t and the unit normal n in the ground frame, a curve at a distance d along the normal is

    p(θ) = e^{∓iθ}·(t + d·n)    (disc; without the rotation where a cylindrical cam is developed)

and runs along ∓i·e^{∓iθ}·n. It is smooth on each span of the turn, where the motion is. Where the velocity jumps
the normal does, which tears a curve at a distance, and leaves a corner in a pitch curve.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import factorial
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import UNIT_ROUNDOFF, ComplexArray, FloatArray, IndexArray
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.motion_ranges import angle_over, derivatives_over
from camopt.core.numerics.sloped_interval import range_of
from camopt.core.numerics.taylor import Taylor
from camopt.model.mechanisms.design import Designs, Mechanism
from camopt.model.mechanisms.geometry import normal_distances
from camopt.model.motion.derived_laws import SkewedLaw
from camopt.model.motion.programme import Programme, weighted_range
from camopt.model.motion.scca import SCCALaw
from camopt.model.motion.stroke import ALL_STROKES, Stroke
from camopt.scene.problem.problem import Problem

REMAINDER_DERIVATIVES = 4
"""Of the motion: how many a remainder takes."""
CURVE_ANGLE_ROUNDING = 16.0 * np.pi * UNIT_ROUNDOFF
"""How far rounding may put a cam angle from the place in its stroke, rad."""


@dataclass(frozen=True)
class SmoothSpan:
    """A part of a stroke on which the motion is smooth, from one cam angle (rad) to another."""

    stroke: Stroke
    start: float
    end: float

    @property
    def is_dwell(self) -> bool:
        """Whether nothing moves there."""
        return self.stroke.law is None


class Expansion(NamedTuple):
    """x and y about the middles of some stretches of half widths ``reach`` (rad), as series in the angle from them.

    ``here`` has the terms at the middles, ``over`` those over whole stretches: the last one is the remainder.
    """

    at_middles: tuple[Taylor, Taylor]
    over_stretches: tuple[Taylor, Taylor]
    half_widths: FloatArray


@dataclass(frozen=True)
class CamCurve:
    """A curve at a distance (mm, outwards positive) along the normal of one design's pitch curve or face."""

    mechanism: Mechanism
    design: Designs
    programme: Programme
    distance: float
    spans: tuple[SmoothSpan, ...]
    mirror: float = 1.0
    """−1 where all this is of the mirror image in the x axis, as that of a second disc (``mechanisms.pairs``)."""

    @property
    def is_closed(self) -> bool:
        """Whether the last point is the first: on a disc cam, not on a developed cylinder."""
        return self.mechanism.body.closed

    @property
    def sense(self) -> float:
        """How the cam's frame turns: +1 against the sense of a ccw cam, 0 for a developed one."""
        return 0.0 if self.mechanism.body.developed else self.mirror * self.design.sense

    def coordinates(self, angle: Any, y: Any, y1: Any) -> tuple[Any, Any]:
        """x and y, mm, from the cam angle (rad), y and y': arrays, or series."""
        found = self.mechanism.contact(self.design, self.programme.lift, angle, y, y1)
        x, height = found.x, found.y
        if self.distance:
            length = np.sqrt(np.square(found.across) + np.square(found.up))
            x, height = x + found.across / length * self.distance, height + found.up / length * self.distance
        height = height * self.mirror
        if not self.sense:
            return x, height
        cosine, sine = np.cos(angle), np.sin(angle) * self.sense
        return x * cosine + height * sine, height * cosine - x * sine

    def points(self, span: SmoothSpan, angles: FloatArray) -> ComplexArray:
        """Points x + iy, mm, at cam angles (rad) of a span."""
        y, y1, *_ = span.stroke.motion(angles)
        x, height = self.coordinates(angles, y, y1)
        found: ComplexArray = x + 1j * height
        return found

    def points_with_derivatives(self, span: SmoothSpan, angles: FloatArray) -> tuple[ComplexArray, ...]:
        """Points, mm, and their first two derivatives by the cam angle, mm/rad, at cam angles (rad) of a span."""
        y, y1, y2, y3 = span.stroke.motion(angles)
        x, height = self.coordinates(Taylor([angles, 1.0, 0.0]), Taylor([y, y1, y2 / 2]), Taylor([y1, y2, y3 / 2]))
        return tuple(x.derivative(k) + 1j * height.derivative(k) for k in range(3))

    def evaluate_by_span(self, angles: FloatArray, of: Callable[[SmoothSpan, FloatArray], Any]) -> Any:
        """The values of ``of`` at cam angles (rad, in any order) of the turn; at a jump, the value after it."""
        place = self.span_numbers(angles)
        found = [(k, of(self.spans[k], angles[place == k])) for k in np.unique(place)]
        out = np.empty(angles.shape, dtype=found[0][1].dtype)
        for k, values in found:
            out[place == k] = values
        return out

    def span_numbers(self, angles: FloatArray) -> IndexArray:
        """The number of the span that each cam angle (rad) is in; where two spans meet, the second."""
        starts = np.array([span.start for span in self.spans])
        return np.maximum(np.searchsorted(starts, angles, side="right") - 1, 0)

    def curvatures(self, span: SmoothSpan, angles: FloatArray) -> FloatArray:
        """Im(p'*·p'')/|p'|³, 1/mm, positive where the curve turns to the left, at cam angles (rad) of a span."""
        _, first, second = self.points_with_derivatives(span, angles)
        found: FloatArray = (first.conjugate() * second).imag / np.abs(first) ** 3
        return found

    def tangents(self, span: SmoothSpan, angles: FloatArray) -> ComplexArray:
        """Unit tangents, as the cam angle grows, at cam angles (rad) of a span."""
        return -1j * (self.sense or self.mirror) * self.normals(span, angles)

    def normals(self, span: SmoothSpan, angles: FloatArray) -> ComplexArray:
        """Unit normals outwards, at cam angles (rad) of a span."""
        y, y1, *_ = span.stroke.motion(angles)
        found = self.mechanism.contact(self.design, self.programme.lift, angles, y, y1)
        normal = found.across + 1j * self.mirror * found.up + np.zeros(angles.shape)
        turned: ComplexArray = normal / np.abs(normal) * np.exp(-1j * self.sense * angles)
        return turned

    def expansion(self, spans: Sequence[SmoothSpan], lows: FloatArray, highs: FloatArray) -> Expansion:
        """The curve over some stretches, each of a span, from one cam angle (rad) to another.

        The remainders are sure, from ranges of the motion, up to the rounding of what is done with them.
        """
        middles = (lows + highs) / 2
        here, over = (enclose_motion(self.programme, spans, *ends) for ends in ((middles, middles), (lows, highs)))
        known = self._coordinate_series(middles, [(row.low + row.high) / 2 for row in here])
        return Expansion(known, self._coordinate_series(Interval(lows, highs), over), (highs - lows) / 2)

    def _coordinate_series(self, angle: Any, rows: list[Any]) -> tuple[Taylor, Taylor]:
        """x and y as series, from those of the motion and its velocity."""
        y, y1 = (Taylor([row / factorial(k) for k, row in enumerate(terms)]) for terms in (rows[:-1], rows[1:]))
        return self.coordinates(Taylor([angle, 1.0, *[0.0] * (len(rows) - 3)]), y, y1)


class Disc(NamedTuple):
    """One of the discs of a cam, or of the flanks of its rib: an ordinary cam on the common shaft."""

    problem: Problem
    """Of this disc alone; that of a second one as it is seen in the mirror."""
    number: int = 1
    """Which it is of the discs of a pair, from 1."""
    mirror: float = 1.0
    """−1 where that is the mirror image, in the x axis of the frame that both discs share."""

    @property
    def prefix(self) -> str:
        """What the names of its curves begin with."""
        return "second_" if self.number == SECOND_DISC else ""

    def curves(self, cutter_radius: float | None = None) -> dict[str, CamCurve]:
        """Its curves in that frame by name: ``pitch``, ``profile`` and, of a cutter, ``cutter``.

        Those of a groove are two of each, ``profile_left`` and ``profile_right``; a flat face has no pitch curve.
        """
        found = normal_distances(self.problem.setup.mechanism, self.problem.half_width, cutter_radius)
        curve = replace(offset_curve(self.problem, 0.0), mirror=self.mirror)
        return {name: replace(curve, distance=distance) for name, distance in found.items()}


def cam_discs(problem: Problem) -> tuple[Disc, ...]:
    """The discs of a problem's own design: the first one as it is, and that of a pair's second contact.

    Of a rib its flanks, each with its roller (``mechanisms.ribs``). The second disc of a pair is an ordinary cam of
    the reversed motion, seen in the mirror (``mechanisms.pairs``). So whatever is of one disc is asked of each.
    """
    if not problem.setup.mechanism.two_profiles:
        return (Disc(problem),)
    first, second = problem.contact_problems
    (contact,) = problem.setup.mechanism.further_contacts
    return Disc(first), Disc(second, number=SECOND_DISC, mirror=-1.0 if contact.mechanism.reverses else 1.0)


def disc_curves(
    problem: Problem, cutter_radius: float | None = None, only: int | None = None
) -> dict[str, CamCurve]:
    """The curves of all discs by name, as ``Disc.curves`` has them; those of a second one as ``second_profile``.

    Of a pair that is asked for, those of the disc with the number ``only``.
    """
    return {
        f"{disc.prefix}{name}": curve
        for disc in cam_discs(problem)
        if only in (None, disc.number)
        for name, curve in disc.curves(cutter_radius).items()
    }


SECOND_DISC = 2
"""The number of the second disc of a pair."""


def offset_curve(problem: Problem, distance: float) -> CamCurve:
    """The curve at a distance (mm) along the normal of the pitch curve, or face, of a problem's own design."""
    spans = tuple(smooth_spans(problem.programme))
    return CamCurve(problem.setup.mechanism, problem.design, problem.programme, distance, spans)


def groove_heights(problem: Problem) -> tuple[float, float]:
    """From where to where pitch curves run along the cam's axis, mm: at the ends of the motion."""
    curves = [(each, offset_curve(each.problem, 0.0)) for each in cam_discs(problem)]
    places = [
        curve.coordinates(0.0, y, 0.0)
        for each, curve in curves
        for y in weighted_range(each.problem.programme, (1,), ALL_STROKES)
    ]
    ends = [float(np.mean(height)) for _, height in places]
    return min(ends), max(ends)


def cylinder_ends(problem: Problem, length: float) -> tuple[float, float]:
    """From where to where a cylinder of a length is along its axis, mm: the groove (rib) runs in its middle."""
    middle = sum(groove_heights(problem)) / 2
    return middle - length / 2, middle + length / 2


def smooth_spans(programme: Programme) -> Iterator[SmoothSpan]:
    """The spans of a turn."""
    for stroke in programme.strokes:
        for ends in pairwise(
            (0.0, 1.0) if stroke.law is None else sorted({*stroke.law.BREAKS, *_half_wave_joints(stroke.law)})
        ):
            yield SmoothSpan(stroke, *(stroke.start + stroke.angle * x for x in ends))


def _half_wave_joints(law: Any) -> tuple[float, ...]:
    """Where the halves of a law of waves meet: paths have a joint there."""
    if not isinstance(law, SkewedLaw) and hasattr(law, "law"):
        return _half_wave_joints(law.law)
    return (0.5,) if isinstance(law, SCCALaw) and not law.shares[-1] else ()


def enclose_motion(
    programme: Programme, spans: Sequence[SmoothSpan], lows: FloatArray, highs: FloatArray
) -> list[Interval]:
    """Ranges of y and its first four derivatives over stretches, each of a span, between cam angles (rad)."""
    table = replace(programme, load=None).table
    begin, end = table.centre - table.half_width, table.centre + table.half_width
    inside = (table.centre > np.array([[s.start] for s in spans])) & (
        table.centre < np.array([[s.end] for s in spans])
    )
    meets = inside & (begin <= highs[:, None]) & (end >= lows[:, None])
    stretch, panel = np.nonzero(meets)
    centre, half = table.centre[panel], table.half_width[panel]
    ends = (
        np.clip((angle[stretch] - centre) / half, -1.0, 1.0)
        for angle in (lows - CURVE_ANGLE_ROUNDING, highs + CURVE_ANGLE_ROUNDING)
    )
    found = derivatives_over(table, panel, *angle_over(table, panel, *ends), REMAINDER_DERIVATIVES)
    first = np.flatnonzero(np.diff(stretch, prepend=-1))
    return [
        Interval(np.minimum.reduceat(row.low, first), np.maximum.reduceat(row.high, first))
        for row in map(range_of, found)
    ]
