"""What limits say of boxes of sizes and angles: each holds at every share of every stroke, whatever its angle.

At a share of a stroke the displacement is known; y', y'' and y''' fall with the angle, its square and its cube. So
the formula of a limit there, run on a box of sizes and angles with its slopes (``enclosure``), bounds the excess of
all cams of the box, in all turns that have the stroke.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from camopt.effects import Case
from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.motion.stroke import Stroke
from camopt.numerics import LARGEST, LEAST, FloatArray
from camopt.numerics.curves import value_of
from camopt.numerics.sloped import Sloped, as_quotient, as_sloped
from camopt.numerics.state import State
from camopt.problem.claims import Claim
from camopt.problem.problem import Problem
from camopt.smallest.enclosure import rounded
from camopt.smallest.excesses import Excesses
from camopt.verdicts.claim_boxes import excess_of

IDLE = -0.5  # a limit that no point of a box exceeds by more, relative, is not looked at more closely
STROKE_SHARES = 17  # of a stroke at which every box is looked at, even
ADDED = 64  # and so many more at most, where cams that were looked at exceed a limit the most


@dataclass
class StrokeLimit:
    """One claim of a limit on one stroke, and the places at which boxes are looked at."""

    claim: Claim
    stroke: Stroke
    """From a cam angle of 0."""
    turn: Programme
    """A turn that has the stroke."""
    name: str | None
    """Under which designs bring its angle (deg); None where it is the stroke's own."""
    even: FloatArray
    """y, y', y'' and y''' by the share of the stroke, at places (4, places)."""
    added: FloatArray
    """As ``even``, where a cam exceeds the limit the most."""

    @classmethod
    def of(cls, claim: Claim, stroke: Stroke, turn: Programme, name: str | None) -> "StrokeLimit":
        stroke = replace(stroke, start=0.0)
        shares = np.linspace(0.0, 1.0, STROKE_SHARES if stroke.law else 1)
        return cls(claim, stroke, turn, name, _beside(stroke, shares, claim.kinds), np.empty((4, 0)))

    def look_at(self, problem: Problem, design: Designs) -> None:
        """Add the place at which one design exceeds the limit the most."""
        angle = self.stroke.angle if self.name is None else float(np.radians(design.numbers[self.name][0]))
        stroke, kinds = replace(self.stroke, angle=angle), self.claim.kinds
        goals = [(kinds, LARGEST if side > 0.0 else LEAST) for side in self.claim.sides]
        where = Case(problem.setup, Programme((stroke,)), design).extremes(self._curve, goals).where[:, 0]
        new = _beside(stroke, where / angle, kinds)
        self.added = np.concatenate([self.added, new], axis=1)[:, -ADDED:]

    def _curve(self, designs: Designs, alone: Programme) -> Any:
        return self.claim.curve(designs, self.turn)

    def excesses(self, box: Designs, inside: Designs, like: Sloped) -> Iterator[Excesses]:
        """The excess at the place where one design of each box exceeds the limit the most, if a limit is near.

        Boxes are designs of ranges with slopes, as ``like`` is.
        """
        places, count = np.concatenate([self.even, self.added], axis=1), like.size
        points = inside.take(np.tile(np.arange(count), places.shape[1]))
        for side in self.claim.sides:
            state = np.repeat(places, count, axis=1)
            excess = self._excess(side, state, points)
            excess = np.nan_to_num(excess + np.zeros(len(points)), nan=-np.inf).reshape(-1, count)
            if np.max(excess) < IDLE:
                continue
            worst = rounded(State(*places[:, np.argmax(excess, axis=0)]), _by_share(self.stroke))
            yield Excesses.of(as_sloped(self._excess(side, worst, box), like))

    def _excess(self, side: float, state: Any, designs: Designs) -> Any:
        """What is above 0 where designs exceed the limit."""
        y, y1, y2, y3 = state[:4]
        angle: Any = self.stroke.angle if self.name is None else designs.numbers[self.name] * (np.pi / 180.0)
        fast = 1.0 / angle
        square = np.square(fast)
        made = self.claim.curve(designs, self.turn)
        value = value_of(made, ..., State(y, y1 * fast, y2 * square, y3 * (fast * square)))
        return excess_of(self.claim, np.full(y.size, side), as_quotient(value), designs)


def _beside(stroke: Stroke, shares: FloatArray, kinds: int) -> FloatArray:
    """The motion by the share of a stroke on both sides of some shares, where it moves in ways of some kinds."""
    alone = _by_share(stroke)
    return np.asarray(alone.at(alone.one_sided(shares, kinds).ravel()))


def _by_share(stroke: Stroke) -> Programme:
    """The stroke alone, over an angle of 1."""
    return Programme((replace(stroke, angle=1.0, given=None),))


def stroke_limits(
    claims: Sequence[Claim], strokes: Mapping[Stroke, str | None], turn: Programme
) -> list[StrokeLimit]:
    """Each limit on each stroke that it is about."""
    found = (StrokeLimit.of(claim, stroke, turn, name) for claim in claims for stroke, name in strokes.items())
    return [each for each in found if each.even.size]
