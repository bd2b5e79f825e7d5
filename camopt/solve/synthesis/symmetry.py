"""Turns that are their own mirror image, or of which one half is the other upside down: which stroke is which."""

from collections.abc import Sequence
from math import pi

from camopt.model.motion.stroke import Stroke

EQUAL_SHARE = 1e-9  # of a turn or of the lift: what counts as equal


def find_mirror_strokes(strokes: Sequence[Stroke]) -> tuple[int, ...] | None:
    """For each stroke the one that mirrors it about some cam angle; None if the turn is no mirror image of itself.

    Angles and displacements count, not the laws: the middle of a stroke, or a joint, is where it is mirrored.
    """
    count = len(strokes)
    for total in range(2 * count):  # stroke k is mirrored by the stroke total − k, round the turn
        places = tuple((total - k) % count for k in range(count))
        if all(_is_mirror_image(stroke, strokes[place]) for stroke, place in zip(strokes, places, strict=True)):
            return places
    return None


def find_opposed_strokes(strokes: Sequence[Stroke]) -> tuple[int, ...] | None:
    """For each stroke the one that moves as much the other way half a turn later; None if not all have one.

    As for mirrored turns, angles and displacements count.
    """
    half, odd = divmod(len(strokes), 2)
    pairs = zip(strokes, strokes[half:], strict=False)
    if odd or not all(_is_upside_down(one, other) for one, other in pairs):
        return None
    return tuple((place + half) % len(strokes) for place in range(len(strokes)))


def _is_upside_down(one: Stroke, other: Stroke) -> bool:
    """Whether a stroke can be another one upside down."""
    change, back = one.high - one.low, other.high - other.low
    lift = max(abs(one.high), abs(other.high), abs(one.low), abs(other.low))
    alike = one.is_free == other.is_free and one.is_move == other.is_move
    return (
        alike
        and abs(change + back) <= EQUAL_SHARE * lift
        and abs(one.angle - other.angle) <= EQUAL_SHARE * 2.0 * pi
    )


def _is_mirror_image(one: Stroke, other: Stroke) -> bool:
    """Whether a stroke can be another from its end to its start."""
    lift = max(abs(one.high - one.low), abs(other.high - other.low), abs(one.high), abs(other.high))
    near = abs(one.low - other.high) + abs(one.high - other.low) <= EQUAL_SHARE * lift
    alike = one.is_free == other.is_free and one.is_move == other.is_move
    return alike and near and abs(one.angle - other.angle) <= EQUAL_SHARE * 2.0 * pi
