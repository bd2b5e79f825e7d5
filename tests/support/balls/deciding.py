"""Whether a curve over the turn stays below a bound, decided in ball arithmetic.

Over a part of the turn the largest value is at most that of its ball, or of its ball about the middle
(``exact_curve``), or, where the slope keeps its sign, that of one end. The part with the largest bound is looked at
more closely, then halved, until a bound on all is below the one asked, or a point above it. What is known of parts
serves further questions.

Source: Moore, Kearfott and Cloud, Introduction to Interval Analysis, ch. 6 and 11 (Moore and Skelboe's algorithm).
"""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from heapq import heappop, heappush
from itertools import count
from math import inf
from time import monotonic
from typing import Any, NamedTuple

from flint import arb

from camopt.model.motion.stroke import ALL_STROKES, INWARD, OUTWARD, RESTING, WAY_OF, WAYS
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED
from support.balls.ball import ball_between
from support.balls.curves import ExactCurve
from support.balls.motion import ExactMotion, ExactStroke, TurnPart

DECIDING_PARTS = 20_000
ONE, INFINITE = arb(1), arb(inf)
Look = Callable[[arb], None]
"""At a part of the turn, from what it is known not to exceed."""


class Side(NamedTuple):
    """A curve of one design in balls, times 1 or −1, on pieces of some kinds."""

    curve: ExactCurve
    kinds: int = ALL_STROKES
    sign: float = 1.0

    def on(self, stroke: ExactStroke) -> "Side | None":
        """The same for one stroke, if it applies; for a move, by the follower's direction of motion."""
        if not self.kinds & (stroke.kind | WAYS):
            return None
        if stroke.kind != ALL_STROKES or self.kinds & ALL_STROKES == ALL_STROKES:
            return self
        ways = sum(way for kind, way in WAY_OF.items() if kind & self.kinds)
        return self._replace(kinds=self.kinds & WAYS | ways)

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

    def parts(self, motion: ExactMotion) -> "Iterator[tuple[Side, TurnPart]]":
        """The smooth parts of a turn to which it applies."""
        for part in motion.parts:
            if (about := self.on(part.stroke)) is not None:
                yield about, part


class Largest:
    """The largest value of sides of curves over parts of the turn, known more closely with each question."""

    def __init__(self, parts: Iterable[tuple[Side, TurnPart]]) -> None:
        self.least = -INFINITE
        """What is reached."""
        self._looks: list[tuple[arb, int, Look | None]] = []
        """Of each part minus what it does not exceed, a number for order, and how to know it better, if at all."""
        self._number = count()
        for side, part in parts:
            for each in part.first:
                self._over(side, each)

    @property
    def most(self) -> arb:
        """What is not exceeded; −∞ where the sides apply to nothing."""
        return -self._looks[0][0] if self._looks else -INFINITE

    def verdict(self, bound: arb, factor: arb = ONE, until: float = inf) -> str:
        """Whether factor·largest ≤ bound, factor ≥ 0.

        Undecided if not proved before ``until`` (``monotonic``).
        """
        for _ in range(DECIDING_PARTS):
            if self.least * factor > bound:
                return BROKEN
            if not self._looks or self.most * factor <= bound:
                return HELD
            if monotonic() > until or not self._closer():
                break
        return UNDECIDED

    def within(self, share: float) -> arb:
        """A ball of it, as narrow relative to it as that, or as can be."""
        for _ in range(DECIDING_PARTS):
            known = self.least.is_finite() and self.most - self.least <= abs(self.least) * share
            if known or not self._looks or not self._closer():
                break
        return ball_between(self.least, self.most)

    def _closer(self) -> bool:
        """Know the part with the largest bound better; false where that cannot be."""
        bound, number, look = heappop(self._looks)
        if look is None:
            heappush(self._looks, (bound, number, look))
            return False
        look(-bound)
        return True

    def _put(self, value: arb, bound: arb, look: Look | None) -> None:
        """What a part does not exceed, by its ball or an earlier bound."""
        high = value.upper()
        heappush(self._looks, (-(high if high < bound else bound), next(self._number), look))

    def _reached(self, value: arb) -> None:
        low = value.lower()
        if low > self.least:
            self.least = low

    def _over(self, side: Side, part: TurnPart) -> None:
        """Look at a part by its balls."""
        if side.applies(part.over[1].arb)[0]:
            value, _ = side.curve(part.over)
            self._put(value * side.sign, INFINITE, partial(self._around, side, part))

    def _around(self, side: Side, part: TurnPart, bound: arb) -> None:
        """Look at a part by its balls about the middle, and at the middle."""
        may, everywhere = side.applies(part.over[1].arb)
        if not may:
            return
        here = side.curve.in_middle(part.in_middle)
        if everywhere or side.applies(part.in_middle[1].arb)[1]:
            self._reached(here * side.sign)
        value, slope = side.curve.around(part.over, part.away)
        rises, falls = (slope * sign * side.sign > 0 for sign in (1, -1))
        if rises or falls:
            look: Look | None = partial(self._at, side, part, part.high if rises else part.low)
        else:
            look = None if part.narrow else partial(self._halved, side, part)
        self._put(value * side.sign, bound, look)

    def _at(self, side: Side, part: TurnPart, x: arb, bound: arb) -> None:
        """Look at the end where a part has its largest value, which is reached if the side applies there."""
        motion = part.at(x)
        value = side.curve(motion)[0] * side.sign
        if side.applies(motion[1].arb)[1]:
            self._reached(value)
            self._put(value, bound, None)
        elif part.piece is not None:
            self._put(value, bound, None if part.narrow else partial(self._halved, side, part))

    def _halved(self, side: Side, part: TurnPart, bound: arb) -> None:
        """Look at the halves of a part."""
        for each in part.halves:
            self._around(side, each, bound)


def sign_of(over: arb) -> str:
    """The verdict on an excess over a bound."""
    return HELD if over <= 0 else BROKEN if over > 0 else UNDECIDED
