"""The segments of a scene's turn as the motion takes them: derivatives by the cam angle in rad."""

from collections.abc import Mapping, Sequence
from math import inf, pi, radians
from typing import Any

from camopt.motion.conditions import NAMES
from camopt.motion.segments import CONSTANT_VELOCITY, MOVE, Segment
from camopt.motion.stroke import Asked, Through, range_of
from camopt.quantities import DERIVATIVES
from camopt.scene.mapping import number, tables_in

NOTHING = 1e-100  # mm or deg: a position no further from 0 is there


def segments_of(rows: Sequence[Mapping[str, Any]], rpm: float | None) -> list[Segment]:
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


def after_each(rows: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """The segment after each, round the turn."""
    return [*rows[1:], *rows[:1]]


def starts_itself(row: Mapping[str, Any], after: Mapping[str, Any]) -> bool:
    """Whether a segment is a move before a constant velocity that gives both its velocity and its position.

    It then ends where that starts, which a move with a law of its own says again.
    """
    stretch = after.get("segment") == CONSTANT_VELOCITY
    both = after.get("to") is not None and after.get("velocity") is not None
    return stretch and both and row.get("segment") == MOVE and (row.get("to") is None or row.get("law") is not None)


def _per_rad(row: Mapping[str, Any], rpm: float | None) -> float:
    """What a velocity of a segment is multiplied by, to be by the cam angle in rad."""
    return {"rad": 1.0, "deg": 180 / pi, "s": 30 / (pi * rpm) if rpm else 1.0}[row.get("per") or "rad"]


def _through_of(row: Mapping[str, Any], rpm: float | None) -> tuple[Through, ...]:
    """What a move is asked for on its way, its angles in deg of the turn, its derivatives by rad."""
    per, found = _per_rad(row, rpm), []
    for each in tables_in(row.get("through")):
        start, end = range_of(as_asked(each["angle"]))
        asked = (_times(as_asked(each.get(name)), per**order) for order, name in enumerate(NAMES))
        found.append(Through(start, end, tuple(asked)))
    return tuple(found)


def as_asked(value: Any) -> Asked:
    """A number or a range from the mapping of a scene, where a range may be a list."""
    return tuple(value) if isinstance(value, (list, tuple)) else value


def _segment_of(row: Mapping[str, Any], rpm: float | None) -> Segment:
    per = _per_rad(row, rpm)
    wanted = [row.get(key) for key in DERIVATIVES]
    by_angle = tuple(_times(value, per**order) for order, value in enumerate(wanted, start=1))
    kind, angle, lift, to = row["segment"], row["angle"], row.get("lift") or 0.0, row.get("to")
    if kind == CONSTANT_VELOCITY:
        lift = (row.get("velocity") or 0.0) * per * radians(angle)
    if kind != MOVE:
        return Segment(kind, angle, lift, row.get("law"), to)
    if (position := number(to)) is not None:
        to = position if abs(position) > NOTHING else 0.0
        return Segment(kind, angle, law=row.get("law"), to=to, wanted=by_angle)
    return Segment(kind, angle, wanted=by_angle, between=(-inf, inf) if to is None else tuple(to))


def _times(asked: Asked, factor: float) -> Asked:
    """A number or a range in another unit."""
    if asked is None:
        return None
    return (asked[0] * factor, asked[1] * factor) if isinstance(asked, (list, tuple)) else asked * factor
