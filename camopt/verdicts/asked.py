"""Whether a motion meets the conditions of its moves, in ball arithmetic.

A condition holds if the motion, or its derivative, misses it by no more than a small share of its largest value:
a law of doubles cannot have one number exactly, nor does a solver find it.
"""

from collections.abc import Iterator
from math import inf, isfinite

from flint import arb

from camopt.motion.conditions import MISSED, Condition
from camopt.motion.programme import Programme, span
from camopt.motion.stroke import Stroke
from camopt.motion.table import ALL_STROKES
from camopt.verdicts.ball import precisely
from camopt.verdicts.deciding import Statement, decide_part
from camopt.verdicts.exact_motion import ExactMotion, ExactStroke
from camopt.verdicts.words import HELD, worst


@precisely()
def conditions_verdict(programme: Programme, motion: ExactMotion, until: float = inf) -> str | None:
    """Whether all conditions hold: held, broken or undecided; None if nothing is asked."""
    start, found = programme.strokes[0].low, []
    for stroke, exact in zip(programme.strokes, motion.strokes, strict=True):
        if stroke.key:
            found += [_verdict(each, stroke, exact, until) for each in stroke.asked(start)]
    return worst(found) if found else None


def _verdict(condition: Condition, stroke: Stroke, exact: ExactStroke, until: float) -> str:
    part = stroke.part(condition)
    assert part is not None
    first, last = map(arb, part)
    found = []
    for piece, line, start, end in exact.smooth():
        low, high = start.max(first), end.min(last)
        if low < high or (low <= high and first == last):
            sides = [decide_part(each, until, exact, piece, line, low, high) for each in _sides(condition, stroke)]
            found.append(worst(sides))
    if first == last:  # where two pieces meet either may have the jerk
        return HELD if HELD in found else found[0]
    return worst(found)


def _sides(condition: Condition, stroke: Stroke) -> Iterator[Statement]:
    """The statements of a condition: above one end of its range, and below the other."""
    order = condition.order
    least, most = span(Programme((stroke,)), (0.0,) * order + (1.0,), ALL_STROKES)
    room = MISSED[order] * max(abs(least), abs(most))
    for side, bound in ((1.0, condition.high), (-1.0, -condition.low)):
        if isfinite(bound):
            yield Statement(
                lambda moved: (moved[order], moved[order + 1]), ALL_STROKES, arb(side), arb(bound + room)
            )
