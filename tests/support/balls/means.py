"""Means over the turn in balls: the formula of the curve run on Taylor series by the cam angle, and integrated.

A part of the turn has K terms about its middle; the term of order K is taken over the whole part, and bounds what
is left out:

    ∫f dθ over ±h ∈ Σ 2·f_k·h^(k+1)/(k + 1), even k < K, + 2·[f_K]·h^(K+1)/(K + 1)

Of a polynomial of lower degree nothing is left out. Where a formula has a kink, as the friction of a guide where
the load changes sides, the part has no series, but the range of the curve. Parts that tell too little are halved.

Source: Moore, Kearfott and Cloud, Introduction to Interval Analysis, ch. 9.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from math import inf
from time import monotonic
from typing import Any, cast

from flint import arb, arb_series

from camopt.model.effects.mean import Mean
from camopt.model.effects.peak import MotionDerivative
from camopt.model.mechanisms import Designs
from camopt.model.motion.programme import Programme
from camopt.scene.problem.constraints import TurnMeanConstraint
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED
from support.balls.ball import Ball, NoSeries, as_arb, precisely
from support.balls.curves import BALL_NUMBERS, ExactCurve
from support.balls.deciding import Side
from support.balls.motion import ExactMotion, ExactStroke, TurnPart, series_of

TAYLOR_ORDER = 26
STATE_ROWS = 5  # y and its first derivatives, as curves take them
DISPLACEMENT_TERMS = TAYLOR_ORDER + STATE_ROWS  # of y: its last derivative has TAYLOR_ORDER + 1
MEAN_PARTS = 20_000
SMALLER = 4  # than the widest: parts that are halved with it
MEAN_ERROR = 2.0**-150  # of the mean: what balls may leave


class MeanPart(TurnPart):
    """A part of the turn with Taylor series about its middle."""

    def derivatives(self) -> tuple[list[arb], list[arb]]:
        """The displacement and its derivatives by the cam angle in its middle, and over all of it: mean values.

        f(x) = Σ f⁽ʲ⁾(m)·(x − m)ʲ/j!, whose last term alone is taken over the part, does not lose what cancels.
        """
        if self.piece is None:
            return [self.stroke.low], [self.stroke.low]
        middle, by = self.middle, self.whole - self.middle
        near, wide = (self.piece.derivatives(DISPLACEMENT_TERMS, x) for x in (middle, self.whole))
        terms = [arb(1)]
        for j in range(1, DISPLACEMENT_TERMS):
            terms.append(terms[-1] * by / j)
        whole = [wide[-1]]
        for k in reversed(range(DISPLACEMENT_TERMS - 1)):
            rest = sum((near[j] * terms[j - k] for j in range(k, DISPLACEMENT_TERMS - 1)), arb(0))
            whole.append(rest + wide[-1] * terms[DISPLACEMENT_TERMS - 1 - k])
        return self._by_angle(near), self._by_angle(whole[::-1])

    def _by_angle(self, rows: list[arb]) -> list[arb]:
        """Derivatives of the unit stroke by x as those of the displacement."""
        first, *rest = (self.stroke.size * row / self.stroke.angle**k for k, row in enumerate(rows))
        return [self.stroke.low + first, *rest]

    def load(self, x: arb, follower: arb_series) -> list[arb_series]:
        """What changes of a load about x, from the series of the displacement; nothing of one that does not."""
        return [] if self.line is None else self.line.series(x, self.stroke.angle, follower)

    def ranges(self, rows: list[arb], x: arb) -> list[Ball]:
        """The first derivatives and the load, as curves take them."""
        padded = rows[:STATE_ROWS] + [arb(0)] * (STATE_ROWS - len(rows))
        load = self.load(x, series_of(padded, STATE_ROWS))
        return [*map(Ball, padded), *(Ball(each[k]) for each in load for k in (0, 1))]

    def series(self, rows: list[arb], x: arb) -> list[Ball]:
        """As ``ranges``, as Taylor series."""
        found = [series_of(rows, DISPLACEMENT_TERMS)]
        for _ in range(STATE_ROWS - 1):
            found.append(found[-1].derivative())
        for each in self.load(x, found[0]):
            found += [each, each.derivative()]
        return [Ball(each) for each in found]


@dataclass(frozen=True)
class MeanOfPowers:
    """The mean over the turn of a curve of one design, in balls, to a power."""

    curves: Sequence[tuple[ExactCurve, int]]
    """The curve on pieces of some kinds."""
    power: int
    motion: ExactMotion

    @classmethod
    def of(cls, mean: Mean, design: Designs, motion: ExactMotion) -> "MeanOfPowers":
        """The mean of a quantity."""
        turn = cast(Programme, motion)
        if isinstance(derivative := mean.curves[0][0], MotionDerivative):
            motion = derivative.motion_of_tool_or_follower(motion)
        return cls([(ExactCurve(make(design, turn)), kinds) for make, kinds in mean.curves], mean.power, motion)

    def enclosures(self, until: float = inf) -> Iterator[arb]:
        """Balls that enclose it, each narrower than the one before, as long as that helps."""
        parts = [MeanPart(stroke, *smooth) for stroke in self.motion.strokes for smooth in stroke.smooth()]
        known = [(part, self._over(part)) for part in parts]
        while True:
            found = sum((ball for _, ball in known), arb(0)) / (2 * arb.pi())
            yield found
            widths = [_width(ball) for _, ball in known]
            widest = max(widths)
            done = widest <= MEAN_ERROR * float(abs(found).mid()) or len(known) > MEAN_PARTS or monotonic() > until
            if done:
                return
            kept = [each for each, width in zip(known, widths, strict=True) if width * SMALLER < widest]
            cut = [each for (each, _), width in zip(known, widths, strict=True) if width * SMALLER >= widest]
            known = [*kept, *((half, self._over(half)) for part in cut for half in part.halves)]

    def _over(self, part: MeanPart) -> arb:
        """The integral over a part; where the follower may move one way or the other, by the ranges of both."""
        near, whole = part.derivatives()
        moved = part.ranges(whole, part.whole)
        curves = [values for values, kinds in self.curves if _may_be(kinds, part.stroke, moved[1].arb)]
        ranged: arb = reduce(arb.union, [self._power(values(moved)[0]) * part.angle for values in curves])
        if len(curves) > 1 or (part.piece is None and part.line is None):
            return ranged
        try:
            about, rest = (
                self._power(curves[0](part.series(rows, x))[0])
                for rows, x in ((near, part.middle), (whole, part.whole))
            )
        except NoSeries:
            return ranged
        if isinstance(rest, arb_series) and rest.prec <= TAYLOR_ORDER:
            raise ArithmeticError("a series ends before the term that bounds what it leaves out")
        half = part.angle / 2
        found = sum((2 * about[k] * half ** (k + 1) / (k + 1) for k in range(0, TAYLOR_ORDER, 2)), arb(0))
        found += 2 * rest[TAYLOR_ORDER] * half ** (TAYLOR_ORDER + 1) / (TAYLOR_ORDER + 1)
        return ranged if _width(ranged) < _width(found) else found

    def _power(self, value: Any) -> Any:
        made = Ball(value).arb
        return made * made if self.power == 2 else made


def _may_be(kinds: int, stroke: ExactStroke, speed: arb) -> bool:
    """Whether a follower that moves with this y' may be on a piece of some kinds."""
    about = Side(ExactCurve(MotionDerivative(0)), kinds).on(stroke)
    return about is not None and about.applies(speed)[0]


def _width(ball: arb) -> float:
    """The width of a ball; infinite if it is not finite."""
    return float(ball.rad()) if ball.is_finite() else inf


@precisely(DISPLACEMENT_TERMS)
def mean_verdict(constraint: TurnMeanConstraint, design: Designs, motion: ExactMotion, until: float = inf) -> str:
    """The verdict on a limit's constraint on a mean, for a design (in balls)."""
    allowed, factor = constraint.upper_bound_of_each_side(BALL_NUMBERS), as_arb(constraint.factor(design))
    for found in MeanOfPowers.of(constraint.mean, design, motion).enclosures(until):
        over = (found * factor - allowed) * constraint.side
        if over <= 0 or over > 0:
            return HELD if over <= 0 else BROKEN
    return UNDECIDED
