"""Whether a motion meets the conditions of its moves, in intervals.

A condition holds if the motion, or its derivative, misses it by no more than a small share of its largest value:
a law of doubles cannot have one number exactly, nor does a solver find it.
"""

import numpy as np

from camopt.motion.programme import Programme, span
from camopt.motion.stroke import ALL_STROKES, MISSED, Condition, Stroke
from camopt.numerics import FloatArray, IntArray
from camopt.numerics.motion_ranges import angle_over, derivatives_over
from camopt.verdicts.words import BROKEN, HELD, UNDECIDED, worst

PARTS = 512
"""Of each panel: the range of a part is then too wide by far less than what a motion may miss."""
TOUCHING = 1e-9
"""Of half a panel: a panel that a range of cam angles enters by less is left out."""


def conditions_verdict(programme: Programme) -> str | None:
    """Whether all conditions hold: held, broken or undecided; None if nothing is asked."""
    start = programme.strokes[0].low
    found = [_verdict(each, stroke) for stroke in programme.strokes if stroke.key for each in stroke.asked(start)]
    return worst(found) if found else None


def _verdict(condition: Condition, stroke: Stroke) -> str:
    part, alone = stroke.part(condition), Programme((stroke,))
    assert part is not None
    table = alone.table
    low, high = ((stroke.start + stroke.angle * x - table.centre) / table.half_width for x in part)
    if part[0] == part[1]:  # where two pieces meet either may have the jerk
        found = [
            _within(condition, alone, np.array([k]), *[np.clip(low[[k]], -1.0, 1.0)] * 2)
            for k in np.flatnonzero(np.abs(low) <= 1.0 + TOUCHING)
        ]
        return HELD if HELD in found else found[0]
    low, high = np.maximum(low, -1.0), np.minimum(high, 1.0)
    panels = np.flatnonzero(high - low > TOUCHING)
    ends = low[panels, None] + (high - low)[panels, None] * (np.arange(PARTS + 1) / PARTS)
    starts, ends = np.hstack([ends[:, :-1], ends[:, [0, -1]]]), np.hstack([ends[:, 1:], ends[:, [0, -1]]])
    return _within(condition, alone, np.repeat(panels, PARTS + 2), starts.ravel(), ends.ravel())


def _within(condition: Condition, alone: Programme, panels: IntArray, start: FloatArray, end: FloatArray) -> str:
    """Whether a condition holds over parts of panels: below one end of its range, and above the other."""
    order, moved = (
        condition.order,
        derivatives_over(alone.table, panels, *angle_over(alone.table, panels, start, end), 4)[condition.order],
    )
    least, most = span(alone, (0.0,) * order + (1.0,), ALL_STROKES)
    room = MISSED[order] * max(abs(least), abs(most))
    low, high = condition.low - room, condition.high + room
    if np.any(moved.at.low > high) or np.any(moved.at.high < low):
        return BROKEN
    return HELD if np.all((moved.value.low >= low) & (moved.value.high <= high)) else UNDECIDED
