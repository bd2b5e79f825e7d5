"""Turns that are their own mirror image: which stroke mirrors which."""

from collections.abc import Sequence
from math import pi

from camopt.motion.stroke import Stroke

EQUAL_SHARE = 1e-9  # of a turn or of the lift: what counts as equal


def mirrored(strokes: Sequence[Stroke]) -> tuple[int, ...] | None:
    """For each stroke the one that mirrors it about some cam angle; None if the turn is no mirror image of itself.

    Angles and displacements count, not the laws: the middle of a stroke, or a joint, is where it is mirrored.
    """
    count = len(strokes)
    for total in range(2 * count):  # stroke k is mirrored by the stroke total − k, round the turn
        places = tuple((total - k) % count for k in range(count))
        if all(_mirror(stroke, strokes[place]) for stroke, place in zip(strokes, places, strict=True)):
            return places
    return None


def _mirror(one: Stroke, other: Stroke) -> bool:
    """Whether a stroke can be another from its end to its start."""
    lift = max(abs(one.high - one.low), abs(other.high - other.low), abs(one.high), abs(other.high))
    near = abs(one.low - other.high) + abs(one.high - other.low) <= EQUAL_SHARE * lift
    alike = one.is_free == other.is_free and one.is_move == other.is_move
    return alike and near and abs(one.angle - other.angle) <= EQUAL_SHARE * 2.0 * pi
