"""Whether a motion meets the conditions of its moves, in ball arithmetic.

A condition holds if the motion, or its derivative, misses it by no more than a small share of its largest value:
a law of doubles cannot have one number exactly, nor does a solver find it.
"""

from math import inf, isfinite

from flint import arb

from camopt.effects.peak import Derivative
from camopt.motion.conditions import MISSED, Condition
from camopt.motion.programme import Programme, span
from camopt.motion.stroke import Stroke
from camopt.motion.table import ALL_STROKES
from camopt.verdicts.ball import precisely
from camopt.verdicts.deciding import Largest, Side
from camopt.verdicts.exact_curve import ExactCurve
from camopt.verdicts.exact_motion import ExactMotion, ExactStroke, TurnPart
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
            found.append(_within(TurnPart(exact, piece, line, low, high), condition, stroke, until))
    if first == last:  # where two pieces meet either may have the jerk
        return HELD if HELD in found else found[0]
    return worst(found)


def _within(part: TurnPart, condition: Condition, stroke: Stroke, until: float) -> str:
    """Whether a condition holds over a part: above one end of its range, and below the other."""
    order = condition.order
    least, most = span(Programme((stroke,)), (0.0,) * order + (1.0,), ALL_STROKES)
    room = MISSED[order] * max(abs(least), abs(most))
    curve = ExactCurve(Derivative(order))
    return worst(
        Largest([(Side(curve, sign=sign), part)]).verdict(arb(bound + room), until=until)
        for sign, bound in ((1.0, condition.high), (-1.0, -condition.low))
        if isfinite(bound)
    )
