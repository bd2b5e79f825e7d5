"""The given segments of a turn, and the strokes made from them."""

from collections.abc import Mapping, Sequence
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
"""Of the lift of a segment: which way it goes."""
NO_DWELL = 1e-12  # deg: a shorter dwell is the rounding of the other angles
SAME_LIFT = 1e-9  # displacements nearer than this share of a stroke are the same but for rounding


class MotionSegment(NamedTuple):
    """A given segment of the turn: cam angle in deg, displacements in mm, or deg if they are angular."""

    segment: str
    angle: float
    lift: float = 0.0
    law: str | None = None
    to: float | None = None
    """The position at its end, in place of the lift."""
    wanted: tuple[RequiredValue, ...] = ()
    """Of a move: what is asked of y', y'' … at its end, by the cam angle in rad."""
    between: tuple[float, float] | None = None
    """Of a move between others: from where to where the position at its end may be, if it is not given."""
    through: tuple[PassingCondition, ...] = ()
    """Of a move: what is asked of it on its way, with positions."""
    key: str = ""
    """Of the segment in its scene."""

    @property
    def change(self) -> float:
        """The change of displacement, if no position is given."""
        return LIFT_SIGNS[self.segment] * self.lift


def start_position(segments: Sequence[MotionSegment]) -> float:
    """The position at which a turn starts: the last that is given, and the lifts after it; 0 if none is given."""
    position = 0.0
    for segment in segments:
        position = position + segment.change if segment.to is None else segment.to
    return position if any(segment.to is not None for segment in segments) else 0.0


def segment_lifts(segments: Sequence[MotionSegment]) -> list[float]:
    """The change of displacement in each segment."""
    position, found = start_position(segments), []
    for segment in segments:
        found.append(segment.change if segment.to is None else segment.to - position)
        position = position + segment.change if segment.to is None else segment.to
    return found


def segment_positions(segments: Sequence[MotionSegment]) -> list[float]:
    """The position at the start of the turn, and at the end of each segment."""
    found = [start_position(segments)]
    for change in segment_lifts(segments):
        found.append(found[-1] + change)
    return found


def build_strokes(
    segments: Sequence[MotionSegment], *, angular: bool, laws: Mapping[str, Law]
) -> tuple[float, list[Stroke]]:
    """The given position where the turn starts, and its strokes; moves get their laws later (``joints``)."""
    start = start_position(segments)
    strokes: list[Stroke] = []
    turned, y = 0.0, start * ExactNumbers(0.0, 0.0, angular).unit
    for segment, change in zip(segments, segment_lifts(segments), strict=True):
        if segment.angle < NO_DWELL:
            continue
        through = tuple(_relative_passing(each, start) for each in segment.through)
        segment = segment._replace(
            wanted=(_relative_position(start, segment.between), *segment.wanted), through=through
        )
        strokes.append(_segment_stroke(segment, ExactNumbers(segment.angle, change, angular), turned, y, laws))
        turned, y = strokes[-1].end, strokes[-1].high
    return start, strokes


def _relative_position(start: float, asked: RequiredValue) -> RequiredValue:
    """A position, or a range of them, relative to another."""
    if asked is None:
        return None
    return (asked[0] - start, asked[1] - start) if isinstance(asked, tuple) else asked - start


def _relative_passing(through: PassingCondition, start: float) -> PassingCondition:
    """Conditions at cam angles in rad, with positions relative to a given one."""
    position, *others = through.required_values
    return PassingCondition(
        radians(through.start), radians(through.end), (_relative_position(start, position), *others)
    )


def _segment_stroke(
    segment: MotionSegment, given: ExactNumbers, start: float, low: float, laws: Mapping[str, Law]
) -> Stroke:
    change = given.change * given.unit
    high = 0.0 if abs(low + change) <= SAME_LIFT * abs(change) else low + change
    wanted: tuple[RequiredValue, ...] | None = None
    law: Law | None = None
    if segment.segment == MOVE:
        wanted, law = segment.wanted, laws[segment.law] if segment.law else None
    elif segment.segment == CONSTANT_VELOCITY:
        law = PolynomialLaw(CONSTANT_VELOCITY.replace("-", " "), (0.0,), (given.change,))
    elif segment.law is not None:
        law = laws[segment.law]
    kind, angle, named = (
        SEGMENT_KINDS[segment.segment],
        radians(given.angle),
        wanted is not None and law is not None,
    )
    return Stroke(kind, law, start, angle, low, high, given, wanted, segment.through, segment.key, named)
