"""Whether every cam whose train is within tolerances holds a limit on a mean over the turn.

Over a part of the turn the formula of the curve has a range, and slopes by each number, for all followers of a box
of trains (``verdicts.train_boxes``): the mean of these over the turn is that of the box. At one cam of the box it
is far better known, by Gauss's rule on each part; with the slopes, that narrows the range (``numerics.sloped``).
Where the mean surely rises or falls with a number, only that end of it is left. What slopes are too wide by falls
with the width of the parts, so that these are cut where they do not tell.
"""

from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any, ClassVar

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.quadrature import Rule, by_orders
from camopt.core.numerics.sloped import Quotient, Sloped, as_sloped, by_mean_value
from camopt.model.effects.mean import Mean
from camopt.model.mechanisms import Designs
from camopt.model.motion.stroke import turned_kinds
from camopt.scene.problem.claims import MeanClaim
from camopt.scene.problem.problem import Problem
from camopt.solve.verdicts.claim_boxes import (
    MEAN_ROUNDS,
    MEANS_AT_ONCE,
    Answer,
    Ends,
    Parts,
    boxes_of,
    over_turn,
)
from camopt.solve.verdicts.driven_boxes import TERMS, ToolPlaces, at_places
from camopt.solve.verdicts.mean_boxes import excess_of_mean, weighted
from camopt.solve.verdicts.train_boxes import TrainSearch, where_known
from camopt.solve.verdicts.words import UNDECIDED

CUTS = 1, 8
"""Of each piece of the turn that a panel or a load gives: the second where the first does not tell."""
MEAN_ERROR = 1e-11  # of the mean at one design of a box, relative; it is part of its range there


def mean_over_trains(problem: Problem, claim: MeanClaim, design: Designs, ends: Ends, until: float = inf) -> Answer:
    """Whether all designs between ends, with the numbers of trains among them, hold a claim on a mean.

    Undecided where the curve has kinks that depend on the cam, as the friction of a guide.
    """
    if claim.mean.smooth is not None or problem.programme.given_at_follower:
        return Answer(UNDECIDED)
    for cuts in CUTS:
        found = TrainMeans(problem, claim, design, tuple(ends), until, cuts=cuts).run(over_turn(claim, ends))
        if found.verdict != UNDECIDED:
            return found
    return Answer(UNDECIDED)


@dataclass(frozen=True)
class TrainMeans(TrainSearch):
    """The search for a cam with a train of a box that breaks a claim on a mean."""

    at_once: ClassVar[int] = MEANS_AT_ONCE
    rounds: ClassVar[int] = MEAN_ROUNDS
    cuts: int = 1

    @cached_property
    def pieces(self) -> Parts:
        """The pieces of the turn, on which motion and loads are smooth."""
        return self.first({})

    @cached_property
    def turn(self) -> Parts:
        """The parts of these."""
        whole = self.pieces
        ends = np.linspace(whole.low[0], whole.high[0], self.cuts + 1)
        low, high = ends[:-1].reshape(1, -1), ends[1:].reshape(1, -1)
        return Parts(np.tile(whole.panel, self.cuts), np.tile(whole.side, self.cuts), low, high, whole.whole)

    @cached_property
    def weights(self) -> FloatArray:
        """The share of the turn that each has."""
        half = self.tool.table.half_width[self.turn.panel]
        return np.asarray(half * (self.turn.high[0] - self.turn.low[0]) / (2.0 * np.pi))

    def excess(self, parts: Parts) -> Sloped:
        turn, count = self.turn, parts.size
        every = np.repeat(np.arange(turn.size), count)
        low, high = (
            np.vstack([getattr(turn, end)[0, every], np.tile(getattr(parts, end)[1:], turn.size)])
            for end in ("low", "high")
        )
        known = self.over(Parts(turn.panel[every], turn.side[every], low, high, parts.whole))
        designs, inside, like = boxes_of(self.design, self.names, parts)
        shares = [self._share(known, make, kinds, count) for make, kinds in self.claim.mean.curves]
        value, slopes = (sum((each[k] for each in shares[1:]), shares[0][k]) for k in (0, 1))
        slopes = Interval(*(np.vstack([0.0 * end[:1], end[1:]]) for end in (slopes.low, slopes.high)))
        excess = excess_of_mean(self.claim, by_mean_value(value, self._at(inside), slopes, like), designs)
        return where_known(np.all(known.assembled.reshape(-1, count), axis=0), excess)

    def _at(self, designs: Designs) -> Interval:
        """The mean of single designs."""
        panel, (low, *_), (high, *_) = self.pieces.panel, self.pieces.low, self.pieces.high
        centre, half = (getattr(self.tool.table, each)[panel] for each in ("centre", "half_width"))
        middle = centre + half * (low + high) / 2.0
        return mean_at(self.problem, self.claim.mean, designs, middle, half * (high - low) / 2.0, self.kinds[panel])

    def _share(self, known: Any, make: Any, kinds: int, count: int) -> tuple[Interval, Interval]:
        """The share of the pieces of one curve: its range (n,) and its slopes (1 + d, n)."""
        value = value_of(make(known.designs, known.driven), ..., known.driven.state)
        made = value.divided() if isinstance(value, Quotient) else as_sloped(value, known.angle)
        power = np.square(made) if self.claim.mean.power == 2 else made
        of = counts(self.kinds[self.turn.panel], kinds, self.sense)
        weights = np.repeat(np.where(of, self.weights, 0.0)[:, None], count, axis=1)
        return weighted(weights, power.value), weighted(weights, power.slopes)


def counts(kinds: Any, chosen: int, sense: Any) -> Any:
    """Whether pieces of the tool are some of the follower's that goes with it (1), or against it."""
    return (np.where(sense >= 0.0, kinds, turned_kinds(kinds)) & chosen) != 0


def mean_at(
    problem: Problem, mean: Mean, designs: Designs, middle: FloatArray, half: FloatArray, kinds: Any
) -> Interval:
    """The mean of the curve to the power p of single designs, by Gauss's rule on parts of the tool's turn."""

    def integrals(rule: Rule, index: Any) -> FloatArray:
        some = designs.take(index)
        angles = middle[:, None] + half[:, None] * rule.nodes
        motion: Any = at_places(problem, some, ToolPlaces.of(problem.programme, angles.ravel(), TERMS))
        weights = (half[:, None] * rule.weights / (2.0 * np.pi)).reshape(-1, 1)
        of, total = np.repeat(kinds, rule.nodes.size)[:, None], np.zeros(len(some))
        for make, chosen in mean.curves:
            value = value_of(make(some, motion), ..., motion.state)
            total += np.sum(weights * counts(of, chosen, motion.sense) * value**mean.power, axis=0)
        return total[None]

    with np.errstate(all="ignore"):
        found = by_orders(integrals, np.abs, len(designs), MEAN_ERROR)
    value, error = found.value[0], found.error[0]
    known = np.isfinite(value) & np.isfinite(error)
    return Interval(*(np.where(known, value + side * error, side * np.inf) for side in (-1.0, 1.0)))
