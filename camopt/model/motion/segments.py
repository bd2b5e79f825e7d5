"""The given segments of a turn, and the strokes made from them."""

from collections.abc import Mapping, Sequence
from math import radians
from typing import NamedTuple

from camopt.model.motion.law import Law
from camopt.model.motion.polynomial import PolynomialLaw
from camopt.model.motion.stroke import ALL_STROKES, DWELL, RETURN, RISE, AsGiven, AskedValue, Passing, Stroke

MOVE, CONSTANT_VELOCITY = "move", "constant-velocity"
SEGMENT_KINDS = {"rise": RISE, "return": RETURN, "dwell": DWELL, MOVE: ALL_STROKES, CONSTANT_VELOCITY: ALL_STROKES}
LIFT_SIGNS = {"rise": 1.0, "return": -1.0, "dwell": 0.0, MOVE: 1.0, CONSTANT_VELOCITY: 1.0}
"""Of the lift of a segment: which way it goes."""
NO_DWELL = 1e-12  # deg: a shorter dwell is the rounding of the other angles
SAME_LIFT = 1e-9  # displacements nearer than this share of a stroke are the same but for rounding


class GivenSegment(NamedTuple):
    """A given segment of the turn: cam angle in deg, displacements in mm, or deg if they are angular."""

    segment: str
    angle: float
    lift: float = 0.0
    law: str | None = None
    to: float | None = None
    """The position at its end, in place of the lift."""
    wanted: tuple[AskedValue, ...] = ()
    """Of a move: what is asked of y', y'' … at its end, by the cam angle in rad."""
    between: tuple[float, float] | None = None
    """Of a move between others: from where to where the position at its end may be, if it is not given."""
    through: tuple[Passing, ...] = ()
    """Of a move: what is asked of it on its way, with positions."""
    key: str = ""
    """Of the segment in its scene."""

    @property
    def change(self) -> float:
        """The change of displacement, if no position is given."""
        return LIFT_SIGNS[self.segment] * self.lift


def start_position(segments: Sequence[GivenSegment]) -> float:
    """The position at which a turn starts: the last that is given, and the lifts after it; 0 if none is given."""
    position = 0.0
    for segment in segments:
        position = position + segment.change if segment.to is None else segment.to
    return position if any(segment.to is not None for segment in segments) else 0.0


def lifts_of(segments: Sequence[GivenSegment]) -> list[float]:
    """The change of displacement in each segment."""
    position, found = start_position(segments), []
    for segment in segments:
        found.append(segment.change if segment.to is None else segment.to - position)
        position = position + segment.change if segment.to is None else segment.to
    return found


def positions_of(segments: Sequence[GivenSegment]) -> list[float]:
    """The position at the start of the turn, and at the end of each segment."""
    found = [start_position(segments)]
    for change in lifts_of(segments):
        found.append(found[-1] + change)
    return found


def strokes_from(
    segments: Sequence[GivenSegment], *, angular: bool, laws: Mapping[str, Law]
) -> tuple[float, list[Stroke]]:
    """The given position where the turn starts, and its strokes; moves get their laws later (``joints``)."""
    start = start_position(segments)
    strokes: list[Stroke] = []
    turned, y = 0.0, start * AsGiven(0.0, 0.0, angular).unit
    for segment, change in zip(segments, lifts_of(segments), strict=True):
        if segment.angle < NO_DWELL:
            continue
        through = tuple(_counted(each, start) for each in segment.through)
        segment = segment._replace(wanted=(_from(start, segment.between), *segment.wanted), through=through)
        strokes.append(_stroke(segment, AsGiven(segment.angle, change, angular), turned, y, laws))
        turned, y = strokes[-1].end, strokes[-1].high
    return start, strokes


def _from(start: float, asked: AskedValue) -> AskedValue:
    """A position, or a range of them, relative to another."""
    if asked is None:
        return None
    return (asked[0] - start, asked[1] - start) if isinstance(asked, tuple) else asked - start


def _counted(through: Passing, start: float) -> Passing:
    """Conditions at cam angles in rad, with positions relative to a given one."""
    position, *others = through.asked
    return Passing(radians(through.start), radians(through.end), (_from(start, position), *others))


def _stroke(segment: GivenSegment, given: AsGiven, start: float, low: float, laws: Mapping[str, Law]) -> Stroke:
    change = given.change * given.unit
    high = 0.0 if abs(low + change) <= SAME_LIFT * abs(change) else low + change
    wanted: tuple[AskedValue, ...] | None = None
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
