"""Whether a curve over the turn stays below a bound, decided in ball arithmetic.

Over a stretch of the turn the curve is below it if its ball is, or the ball of its mean-value form, or, where the
slope keeps its sign, both its ends; above it if one point is. What is neither is halved.
"""

from collections.abc import Callable
from itertools import pairwise
from math import inf
from typing import Any, NamedTuple

from flint import arb

from camopt.motion.table import ALL_STROKES, INWARD, OUTWARD, RESTING, WAYS, ways_of
from camopt.numerics.clock import now
from camopt.verdicts.ball import Ball, as_arb, ball_between, precisely
from camopt.verdicts.exact_laws import Stretch
from camopt.verdicts.exact_load import LoadPart
from camopt.verdicts.exact_motion import ExactMotion, ExactStroke, motion_at
from camopt.verdicts.words import BROKEN, HELD, UNDECIDED

FIRST_PARTS = 8  # of each piece of a law, and line of a load
DECIDING_PARTS = 20_000
NARROWEST_PART = arb(2) ** -90


class Statement(NamedTuple):
    """One side of a claim for one design in balls: factor · value ≤ bound, with ``values`` as of ``of_curve``."""

    values: Callable[[list[Ball]], tuple[Any, Any]]
    kinds: int
    factor: arb
    bound: arb

    def on(self, stroke: ExactStroke) -> "Statement | None":
        """The statement for one stroke, if it applies; for a move, by the follower's direction of motion."""
        if not self.kinds & (stroke.kind | WAYS):
            return None
        if stroke.kind != ALL_STROKES or self.kinds & ALL_STROKES == ALL_STROKES:
            return self
        return self._replace(kinds=self.kinds & WAYS | ways_of(self.kinds))

    def applies(self, speed: Any) -> tuple[bool, bool]:
        """Whether it may apply, and whether it surely applies, to a motion with this y'."""
        if not self.kinds & WAYS:
            return True, True
        outward, inward = bool(speed > 0), bool(speed < 0)
        still = not outward and not inward and bool(speed == 0)
        if outward or inward or still:
            sure = bool(self.kinds & (OUTWARD if outward else INWARD if inward else RESTING))
            return sure, sure
        return bool(self.kinds & (OUTWARD * (not speed <= 0) | INWARD * (not speed >= 0))), False


@precisely()
def decide(statement: Statement, motion: ExactMotion, until: float = inf) -> str:
    """Whether a statement holds; undecided if no proof is found before ``until`` (``clock.now``)."""
    verdict = HELD
    for stroke in motion.strokes:
        if (about := statement.on(stroke)) is not None:
            for part in stroke.smooth():
                found = decide_part(about, until, stroke, *part)
                if found == BROKEN:
                    return BROKEN
                verdict = found if found == UNDECIDED else verdict
    return verdict


def decide_part(
    statement: Statement,
    until: float,
    stroke: ExactStroke,
    piece: Stretch | None,
    line: LoadPart | None,
    start: arb,
    end: arb,
) -> str:
    """Whether a statement holds from one x of a stroke to another, where motion and load are smooth."""

    def over(x: arb) -> tuple[arb, arb, tuple[bool, bool]]:
        """By how much the curve is above the bound, its slope by x, and whether the statement applies."""
        motion = motion_at(stroke, piece, x, line)
        value, slope = statement.values(motion)
        above = as_arb(value) * statement.factor - statement.bound
        return above, as_arb(slope) * statement.factor * stroke.angle, statement.applies(motion[1].arb)

    if piece is None and line is None:
        above, _, (about, _) = over(arb(0))
        return sign_of(above) if about else HELD
    cuts = [start + (end - start) * k / FIRST_PARTS for k in range(FIRST_PARTS + 1)]
    stack, parts = list(pairwise(cuts)), 0
    while stack:
        parts += 1
        low, high = stack.pop()
        whole, slope, (about, everywhere) = over(ball_between(low, high))
        if not about or whole <= 0:
            continue
        middle = (low + high) / 2
        here, _, (_, surely) = over(middle)
        if here > 0 and surely:
            return BROKEN
        if here + abs(slope) * (high - low) / 2 <= 0:
            continue
        if slope > 0 or slope < 0:
            found = sign_of(over(high if slope > 0 else low)[0])
            if found == HELD:
                continue
            if everywhere:
                return found
        if high - low < NARROWEST_PART or parts > DECIDING_PARTS or now() > until:
            return UNDECIDED
        stack += [(low, middle), (middle, high)]
    return HELD


def sign_of(over: arb) -> str:
    """The verdict on an excess over a bound."""
    return HELD if over <= 0 else BROKEN if over > 0 else UNDECIDED
