"""The segments of a scene's turn as the motion takes them: derivatives by the cam angle in rad."""

from collections.abc import Sequence
from math import pi, radians
from typing import Any, TypeVar

from camopt.core.quantities import DERIVATIVES
from camopt.model.motion.segments import CONSTANT_VELOCITY, MOVE, GivenSegment
from camopt.model.motion.stroke import DERIVATIVE_NAMES, AskedValue, Passing, asked_range
from camopt.scene import tables
from camopt.scene.mapping import number_of

SegmentRow = TypeVar("SegmentRow")
LEAST_POSITION = 1e-100  # mm or deg: a position no further from 0 is there


def given_segments(rows: Sequence[tables.Segment], rpm: float | None) -> list[GivenSegment]:
    """Faultless segments of a scene as the motion takes them: derivatives by the cam angle in rad.

    A move that gives no position ends where the constant velocity after it has to start, or, before another move,
    where the jerk is least.
    """
    found = [
        _segment_of(row, rpm)._replace(key=f"motion.{k}", through=_through_of(row, rpm))
        for k, row in enumerate(rows, start=1)
    ]
    for k, (row, after) in enumerate(zip(rows, after_each(rows), strict=True)):
        if starts_itself(row, after):
            following = found[(k + 1) % len(found)]
            found[k] = found[k]._replace(to=(following.to or 0.0) - following.lift, between=None)
    return found


def after_each(rows: Sequence[SegmentRow]) -> list[SegmentRow]:
    """The segment after each, round the turn."""
    return [*rows[1:], *rows[:1]]


def starts_itself(row: tables.Segment, after: tables.Segment) -> bool:
    """Whether a segment is a move before a constant velocity that gives both its velocity and its position.

    It then ends where that starts, which a move with a law of its own says again.
    """
    stretch = after.segment == CONSTANT_VELOCITY
    both = after.to is not None and after.velocity is not None
    return stretch and both and row.segment == MOVE and (row.to is None or row.law is not None)


def _per_rad(row: tables.Segment, rpm: float | None) -> float:
    """The factor that converts a velocity of a segment to one by the cam angle in rad."""
    return {"rad": 1.0, "deg": 180 / pi, "s": 30 / (pi * rpm) if rpm else 1.0}[row.per or "rad"]


def _through_of(row: tables.Segment, rpm: float | None) -> tuple[Passing, ...]:
    """The conditions on the way of a move, at angles in deg of the turn, with derivatives by rad."""
    per, found = _per_rad(row, rpm), []
    for each in row.through:
        start, end = asked_range(asked_value(each.angle))
        asked = (
            _times(asked_value(getattr(each, name)), per**order) for order, name in enumerate(DERIVATIVE_NAMES)
        )
        found.append(Passing(start, end, tuple(asked)))
    return tuple(found)


def asked_value(value: Any) -> AskedValue:
    """A number or a range from the mapping of a scene, where a range may be a list."""
    return tuple(value) if isinstance(value, (list, tuple)) else value


def _segment_of(row: tables.Segment, rpm: float | None) -> GivenSegment:
    per = _per_rad(row, rpm)
    wanted = [getattr(row, key) for key in DERIVATIVES]
    by_angle = tuple(_times(value, per**order) for order, value in enumerate(wanted, start=1))
    kind, angle, lift, to = row.segment, row.angle, row.lift or 0.0, asked_value(row.to)
    position = None if isinstance(to, tuple) else to
    if kind == CONSTANT_VELOCITY:
        lift = (number_of(row.velocity) or 0.0) * per * radians(angle)
    if kind != MOVE:
        return GivenSegment(kind, angle, lift, row.law, position)
    if position is not None:
        position = float(position) if abs(position) > LEAST_POSITION else 0.0
        return GivenSegment(kind, angle, law=row.law, to=position, wanted=by_angle)
    return GivenSegment(kind, angle, wanted=by_angle, between=asked_range(to))


def _times(asked: AskedValue, factor: float) -> AskedValue:
    """A number or a range in another unit."""
    if asked is None:
        return None
    return (asked[0] * factor, asked[1] * factor) if isinstance(asked, (list, tuple)) else asked * factor
