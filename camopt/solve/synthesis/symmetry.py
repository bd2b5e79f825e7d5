"""Symmetric turns: which stroke mirrors which, and which is the negative of which half a turn later."""

from collections.abc import Sequence
from math import pi

from camopt.model.motion.stroke import Stroke

EQUAL_SHARE = 1e-9  # differences below this share of a turn or of the lift count as equal


def find_mirror_strokes(strokes: Sequence[Stroke]) -> tuple[int, ...] | None:
    """For each stroke the one that mirrors it about some cam angle; None if the turn is not symmetric.

    Only angles and displacements count, not the laws. The axis is the middle of a stroke or a joint.
    """
    count = len(strokes)
    for total in range(2 * count):  # stroke k is mirrored by the stroke total − k, round the turn
        partners = tuple((total - k) % count for k in range(count))
        if all(_is_mirror_image(stroke, strokes[place]) for stroke, place in zip(strokes, partners, strict=True)):
            return partners
    return None


def find_opposed_strokes(strokes: Sequence[Stroke]) -> tuple[int, ...] | None:
    """For each stroke the one with the opposite displacement half a turn later; None if not all have one.

    Only angles and displacements count, not the laws.
    """
    half, odd = divmod(len(strokes), 2)
    if odd or not all(_is_upside_down(one, other) for one, other in zip(strokes, strokes[half:], strict=False)):
        return None
    return tuple((place + half) % len(strokes) for place in range(len(strokes)))


def _is_upside_down(one: Stroke, other: Stroke) -> bool:
    """Whether one stroke can be the negative of another."""
    change, back = one.high - one.low, other.high - other.low
    lift = max(abs(one.high), abs(other.high), abs(one.low), abs(other.low))
    alike = one.is_law_replaceable == other.is_law_replaceable and one.is_move == other.is_move
    return (
        alike
        and abs(change + back) <= EQUAL_SHARE * lift
        and abs(one.angle - other.angle) <= EQUAL_SHARE * 2.0 * pi
    )


def _is_mirror_image(one: Stroke, other: Stroke) -> bool:
    """Whether one stroke can be another from its end to its start."""
    lift = max(abs(one.high - one.low), abs(other.high - other.low), abs(one.high), abs(other.high))
    are_ends_equal = abs(one.low - other.high) + abs(one.high - other.low) <= EQUAL_SHARE * lift
    alike = one.is_law_replaceable == other.is_law_replaceable and one.is_move == other.is_move
    return alike and are_ends_equal and abs(one.angle - other.angle) <= EQUAL_SHARE * 2.0 * pi
