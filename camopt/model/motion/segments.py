"""The segments of a turn as the scene gives them, and the strokes made from them."""

from collections.abc import Mapping, Sequence
from itertools import accumulate
from math import radians
from typing import NamedTuple

from camopt.model.motion.law import Law
from camopt.model.motion.polynomial import PolynomialLaw
from camopt.model.motion.stroke import (
    ALL_STROKES,
    DWELL,
    RETURN,
    RISE,
    ExactNumbers,
    PassingCondition,
    RequiredValue,
    Stroke,
)

MOVE, CONSTANT_VELOCITY = "move", "constant-velocity"
SEGMENT_KINDS = {"rise": RISE, "return": RETURN, "dwell": DWELL, MOVE: ALL_STROKES, CONSTANT_VELOCITY: ALL_STROKES}
LIFT_SIGNS = {"rise": 1.0, "return": -1.0, "dwell": 0.0, MOVE: 1.0, CONSTANT_VELOCITY: 1.0}
"""The sign of a segment's lift."""
NO_DWELL = 1e-12  # deg: a shorter dwell is a rounding error of the other angles
SAME_LIFT = 1e-9  # of a stroke: displacements nearer than this are the same but for rounding


class MotionSegment(NamedTuple):
    """A segment of the turn as the scene gives it: cam angle in deg, displacements in mm, or deg if angular."""

    segment: str
    angle: float
    lift: float = 0.0
    law: str | None = None
    to: float | None = None
    """The position at its end, in place of the lift."""
    wanted: tuple[RequiredValue, ...] = ()
    """The required values of y', y'' … at the end of a move, by the cam angle in rad."""
    between: tuple[float, float] | None = None
    """The range of positions at the end of a move between others, if no position is given."""
    through: tuple[PassingCondition, ...] = ()
    """The conditions on a move before its end, with positions."""
    key: str = ""
    """The key of the segment in its scene."""

    @property
    def signed_lift(self) -> float:
        """Change of displacement by its lift."""
        return LIFT_SIGNS[self.segment] * self.lift


def start_position(segments: Sequence[MotionSegment]) -> float:
    """Position at the start of a turn: the last given position plus the lifts after it; 0 without positions."""
    position = 0.0
    for segment in segments:
        position = position + segment.signed_lift if segment.to is None else segment.to
    return position if any(segment.to is not None for segment in segments) else 0.0


def segment_lifts(segments: Sequence[MotionSegment]) -> list[float]:
    """Change of displacement in each segment."""
    position, changes = start_position(segments), []
    for segment in segments:
        changes.append(segment.signed_lift if segment.to is None else segment.to - position)
        position = position + segment.signed_lift if segment.to is None else segment.to
    return changes


def segment_positions(segments: Sequence[MotionSegment]) -> list[float]:
    """Position at the start of the turn and at the end of each segment."""
    return [*accumulate(segment_lifts(segments), initial=start_position(segments))]


def start_position_and_strokes(
    segments: Sequence[MotionSegment], *, angular: bool, laws: Mapping[str, Law]
) -> tuple[float, list[Stroke]]:
    """Position at the start of the turn, and its strokes; moves get their laws later (module ``move_joints``)."""
    start = start_position(segments)
    strokes: list[Stroke] = []
    angle, y = 0.0, start * ExactNumbers(0.0, 0.0, angular).unit_in_mm_or_rad
    for segment, change in zip(segments, segment_lifts(segments), strict=True):
        if segment.angle < NO_DWELL:
            continue
        through = tuple(
            PassingCondition(radians(low), radians(high), (_relative_position(start, position), *others))
            for low, high, (position, *others) in segment.through
        )
        wanted = (_relative_position(start, segment.between), *segment.wanted)
        segment = segment._replace(wanted=wanted, through=through)
        strokes.append(_segment_stroke(segment, ExactNumbers(segment.angle, change, angular), angle, y, laws))
        angle, y = strokes[-1].end, strokes[-1].high
    return start, strokes


def _relative_position(start: float, required: RequiredValue) -> RequiredValue:
    """A position or range of positions, relative to ``start``."""
    if required is None:
        return None
    return (required[0] - start, required[1] - start) if isinstance(required, tuple) else required - start


def _segment_stroke(
    segment: MotionSegment,
    exact_numbers: ExactNumbers,
    start_angle: float,
    start_displacement: float,
    laws: Mapping[str, Law],
) -> Stroke:
    change = exact_numbers.change * exact_numbers.unit_in_mm_or_rad
    high = 0.0 if abs(start_displacement + change) <= SAME_LIFT * abs(change) else start_displacement + change
    wanted: tuple[RequiredValue, ...] | None = None
    law: Law | None = None
    if segment.segment == MOVE:
        wanted, law = segment.wanted, laws[segment.law] if segment.law else None
    elif segment.segment == CONSTANT_VELOCITY:
        law = PolynomialLaw(CONSTANT_VELOCITY.replace("-", " "), (0.0,), (exact_numbers.change,))
    elif segment.law is not None:
        law = laws[segment.law]
    kind, angle = SEGMENT_KINDS[segment.segment], radians(exact_numbers.angle)
    named = wanted is not None and law is not None
    return Stroke(
        kind,
        law,
        start_angle,
        angle,
        start_displacement,
        high,
        exact_numbers,
        wanted,
        segment.through,
        segment.key,
        named,
    )
