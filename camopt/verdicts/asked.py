"""Whether a motion meets what a scene asks of its moves, in ball arithmetic.

A condition holds if the motion, or its derivative, misses it by no more than a small share of its largest value:
a law of doubles cannot have one number exactly, nor does a solver find it.
"""

from math import inf, isfinite

from flint import arb

from camopt.motion.conditions import MISSED, Condition
from camopt.motion.programme import Programme, span
from camopt.motion.stroke import Stroke
from camopt.motion.table import TURN
from camopt.numerics.clock import now
from camopt.verdicts.ball import between, precisely
from camopt.verdicts.exact_laws import Stretch
from camopt.verdicts.exact_load import LoadLine
from camopt.verdicts.exact_motion import ExactMotion, ExactStroke, motion_at

HELD, BROKEN, UNDECIDED = "held", "broken", "undecided"
MOST_PARTS = 20_000


@precisely()
def conditions_verdict(programme: Programme, motion: ExactMotion, until: float = inf) -> str | None:
    """Whether all conditions hold: held, broken or undecided; None if nothing is asked."""
    start, found = programme.strokes[0].low, []
    for stroke, exact in zip(programme.strokes, motion.strokes, strict=True):
        if stroke.key:
            found += [_verdict(each, stroke, exact, until) for each in stroke.asked(start)]
    return next((v for v in (BROKEN, UNDECIDED, HELD) if v in found), None)


def _verdict(condition: Condition, stroke: Stroke, exact: ExactStroke, until: float) -> str:
    low, high = span(Programme((stroke,)), (0.0,) * condition.order + (1.0,), TURN)
    room = MISSED[condition.order] * max(abs(low), abs(high))
    ends = (condition.low - room, condition.high + room)
    places = ((angle - stroke.start) / stroke.angle for angle in (condition.start, condition.end))
    first, last = (min(max(x, 0.0), 1.0) for x in places)  # without rounding at the ends
    found = []
    for piece, line, start, end in exact.smooth():
        from_here, to_there = start.max(arb(first)), end.min(arb(last))
        if from_here < to_there or (first == last and from_here <= to_there):
            found.append(_over(condition.order, ends, exact, (piece, line), (from_here, to_there), until))
    if first == last:  # where two pieces meet either may have the jerk
        return HELD if HELD in found else found[0]
    return next((v for v in (BROKEN, UNDECIDED) if v in found), HELD)


def _over(
    order: int,
    ends: tuple[float, float],
    exact: ExactStroke,
    smooth: tuple[Stretch | None, LoadLine | None],
    stretch: tuple[arb, arb],
    until: float,
) -> str:
    """The verdict on a stretch where the motion is smooth."""
    stack, parts = [stretch], 0
    while stack:
        parts += 1
        low, high = stack.pop()
        middle = (low + high) / 2
        whole, here = (motion_at(exact, smooth[0], x, smooth[1])[order].arb for x in (between(low, high), middle))
        if _is_within(whole, ends):
            continue
        if here < ends[0] or here > ends[1]:
            return BROKEN
        if parts > MOST_PARTS or now() > until:
            return UNDECIDED
        stack += [(low, middle), (middle, high)]
    return HELD


def _is_within(value: arb, ends: tuple[float, float]) -> bool:
    above = not isfinite(ends[0]) or bool(value >= ends[0])
    return above and (not isfinite(ends[1]) or bool(value <= ends[1]))
