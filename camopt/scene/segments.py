"""The segments of a scene in the form of ``model.motion``, with derivatives by cam angle in rad."""

from collections.abc import Sequence
from math import pi, radians
from typing import Any, TypeVar

from camopt.core.quantities import DERIVATIVE_UNITS
from camopt.model.motion.segments import CONSTANT_VELOCITY, MOVE, MotionSegment
from camopt.model.motion.stroke import DERIVATIVE_NAMES, PassingCondition, RequiredValue, required_range
from camopt.scene import tables
from camopt.scene.mapping import finite_number_or_none

SegmentRow = TypeVar("SegmentRow")
LEAST_POSITION = 1e-100  # mm or deg: a position nearer to 0 is taken as 0


def motion_segments_of_rows(rows: Sequence[tables.Segment], rpm: float | None) -> list[MotionSegment]:
    """Faultless segments of a scene in the form of ``model.motion``, with derivatives by cam angle in rad.

    A move without a position ends where the constant velocity after it starts; before another move it ends where
    the jerk is least.
    """
    segments = [
        _motion_segment_of_row(row, rpm)._replace(key=f"motion.{k}", through=_move_conditions(row, rpm))
        for k, row in enumerate(rows, start=1)
    ]
    for k, (row, after) in enumerate(zip(rows, following_segments(rows), strict=True)):
        if ends_at_constant_velocity_start(row, after):
            following = segments[(k + 1) % len(segments)]
            segments[k] = segments[k]._replace(to=(following.to or 0.0) - following.lift, between=None)
    return segments


def following_segments(rows: Sequence[SegmentRow]) -> list[SegmentRow]:
    """For each segment, the one that follows it in the turn."""
    return [*rows[1:], *rows[:1]]


def ends_at_constant_velocity_start(row: tables.Segment, after: tables.Segment) -> bool:
    """Whether a segment is a move before a constant velocity with both velocity and position.

    The move then ends where the constant velocity starts; a move with a law also gives this position itself.
    """
    stretch = after.segment == CONSTANT_VELOCITY
    both = after.to is not None and after.velocity is not None
    return stretch and both and row.segment == MOVE and (row.to is None or row.law is not None)


def _velocity_factor_to_per_rad(row: tables.Segment, rpm: float | None) -> float:
    """Factor that converts a velocity of a segment to one per rad of cam angle."""
    return {"rad": 1.0, "deg": 180 / pi, "s": 30 / (pi * rpm) if rpm else 1.0}[row.per or "rad"]


def _move_conditions(row: tables.Segment, rpm: float | None) -> tuple[PassingCondition, ...]:
    """The conditions within a move, at cam angles of the turn in deg, with derivatives by rad."""
    per, conditions = _velocity_factor_to_per_rad(row, rpm), []
    for each in row.through:
        start, end = required_range(as_number_or_range(each.angle))
        values = (
            _scale_value(as_number_or_range(getattr(each, name)), per**order)
            for order, name in enumerate(DERIVATIVE_NAMES)
        )
        conditions.append(PassingCondition(start, end, tuple(values)))
    return tuple(conditions)


def as_number_or_range(value: Any) -> RequiredValue:
    """A number, or a range as a tuple."""
    return tuple(value) if isinstance(value, (list, tuple)) else value


def _motion_segment_of_row(row: tables.Segment, rpm: float | None) -> MotionSegment:
    per = _velocity_factor_to_per_rad(row, rpm)
    wanted = [getattr(row, key) for key in DERIVATIVE_UNITS]
    by_angle = tuple(_scale_value(value, per**order) for order, value in enumerate(wanted, start=1))
    kind, angle, lift, to = row.segment, row.angle, row.lift or 0.0, as_number_or_range(row.to)
    position = None if isinstance(to, tuple) else to
    if kind == CONSTANT_VELOCITY:
        lift = (finite_number_or_none(row.velocity) or 0.0) * per * radians(angle)
    if kind != MOVE:
        return MotionSegment(kind, angle, lift, row.law, position)
    if position is not None:
        position = float(position) if abs(position) > LEAST_POSITION else 0.0
        return MotionSegment(kind, angle, law=row.law, to=position, wanted=by_angle)
    return MotionSegment(kind, angle, wanted=by_angle, between=required_range(to))


def _scale_value(value: RequiredValue, factor: float) -> RequiredValue:
    """A number or a range in another unit."""
    if value is None:
        return None
    return (value[0] * factor, value[1] * factor) if isinstance(value, (list, tuple)) else value * factor
