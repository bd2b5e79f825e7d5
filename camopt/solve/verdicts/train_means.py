"""Whether every cam whose train is within tolerances holds a limit on a mean over the turn.

Over a part of the turn the formula of the curve has a range, and slopes by each number, for all followers of a box
of trains (``verdicts.train_boxes``): the mean of these over the turn is that of the box. At one cam of the box it
is far better known, by Gauss's rule on each part; with the slopes, that narrows the range
(``numerics.sloped_interval``). Where the mean surely rises or falls with a number, only that end of it is left.
What slopes are too wide by falls with the width of the parts, so that these are cut where they do not tell.
"""

from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any, ClassVar

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.quadrature import GaussRule, integrate_by_orders
from camopt.core.numerics.sloped_interval import Quotient, SlopedInterval, as_sloped_interval, narrow_by_mean_value
from camopt.model.effects.mean import Mean
from camopt.model.mechanisms import Designs
from camopt.model.motion.stroke import reversed_kinds
from camopt.scene.problem.constraints import TurnMeanConstraint
from camopt.scene.problem.problem import Problem
from camopt.solve.verdicts.constraint_boxes import (
    MEAN_ROUNDS,
    MEANS_AT_ONCE,
    BoxParts,
    BoxVerdict,
    NumberRanges,
    boxes_of_parts,
    whole_turn_parts,
)
from camopt.solve.verdicts.driven_boxes import MOTION_TERMS, ToolPlaces, motion_at_places
from camopt.solve.verdicts.mean_boxes import excess_of_mean, weighted_sums
from camopt.solve.verdicts.train_boxes import TrainConstraintSearch, restrict_to_assembled
from camopt.solve.verdicts.verdict_words import UNDECIDED

PIECE_CUTS = 1, 8
"""Of each piece of the turn that a panel or a load gives: the second where the first does not tell."""
MEAN_ERROR = 1e-11  # of the mean at one design of a box, relative; it is part of its range there


def mean_over_trains(
    problem: Problem, constraint: TurnMeanConstraint, design: Designs, ends: NumberRanges, until: float = inf
) -> BoxVerdict:
    """Whether all designs between ends, with the numbers of trains among them, hold a constraint on a mean.

    Undecided where the curve has kinks that depend on the cam, as the friction of a guide.
    """
    if constraint.mean.smooth is not None or problem.programme.given_at_follower:
        return BoxVerdict(UNDECIDED)
    for cuts in PIECE_CUTS:
        found = TrainMeanSearch(problem, constraint, design, tuple(ends), until, cuts=cuts).run(
            whole_turn_parts(constraint, ends)
        )
        if found.verdict != UNDECIDED:
            return found
    return BoxVerdict(UNDECIDED)


@dataclass(frozen=True)
class TrainMeanSearch(TrainConstraintSearch):
    """The search for a cam with a train of a box that breaks a constraint on a mean."""

    at_once: ClassVar[int] = MEANS_AT_ONCE
    rounds: ClassVar[int] = MEAN_ROUNDS
    cuts: int = 1

    @cached_property
    def pieces(self) -> BoxParts:
        """The pieces of the turn, on which motion and loads are smooth."""
        return self.whole_panels({})

    @cached_property
    def turn(self) -> BoxParts:
        """The parts of these."""
        whole = self.pieces
        ends = np.linspace(whole.low[0], whole.high[0], self.cuts + 1)
        low, high = ends[:-1].reshape(1, -1), ends[1:].reshape(1, -1)
        return BoxParts(np.tile(whole.panel, self.cuts), np.tile(whole.side, self.cuts), low, high, whole.whole)

    @cached_property
    def weights(self) -> FloatArray:
        """The share of the turn that each has."""
        half = self.tool.table.half_width[self.turn.panel]
        return np.asarray(half * (self.turn.high[0] - self.turn.low[0]) / (2.0 * np.pi))

    def excess(self, parts: BoxParts) -> SlopedInterval:
        turn, count = self.turn, parts.size
        every = np.repeat(np.arange(turn.size), count)
        low, high = (
            np.vstack([getattr(turn, end)[0, every], np.tile(getattr(parts, end)[1:], turn.size)])
            for end in ("low", "high")
        )
        known = self.motion_over(BoxParts(turn.panel[every], turn.side[every], low, high, parts.whole))
        designs, inside, like = boxes_of_parts(self.design, self.names, parts)
        shares = [self._curve_share(known, make, kinds, count) for make, kinds in self.constraint.mean.curves]
        value, slopes = (sum((each[k] for each in shares[1:]), shares[0][k]) for k in (0, 1))
        slopes = Interval(*(np.vstack([0.0 * end[:1], end[1:]]) for end in (slopes.low, slopes.high)))
        excess = excess_of_mean(
            self.constraint, narrow_by_mean_value(value, self._mean_of_designs(inside), slopes, like), designs
        )
        return restrict_to_assembled(np.all(known.assembled.reshape(-1, count), axis=0), excess)

    def _mean_of_designs(self, designs: Designs) -> Interval:
        """The mean of single designs."""
        panel, (low, *_), (high, *_) = self.pieces.panel, self.pieces.low, self.pieces.high
        centre, half = (getattr(self.tool.table, each)[panel] for each in ("centre", "half_width"))
        middle = centre + half * (low + high) / 2.0
        return mean_of_designs(
            self.problem, self.constraint.mean, designs, middle, half * (high - low) / 2.0, self.kinds[panel]
        )

    def _curve_share(self, known: Any, make: Any, kinds: int, count: int) -> tuple[Interval, Interval]:
        """The share of the pieces of one curve: its range (n,) and its slopes (1 + d, n)."""
        value = value_of(make(known.designs, known.driven), ..., known.driven.state)
        made = value.divide() if isinstance(value, Quotient) else as_sloped_interval(value, known.angle)
        power = np.square(made) if self.constraint.mean.power == 2 else made
        of = has_chosen_kind(self.kinds[self.turn.panel], kinds, self.sense)
        weights = np.repeat(np.where(of, self.weights, 0.0)[:, None], count, axis=1)
        return weighted_sums(weights, power.value), weighted_sums(weights, power.slopes)


def has_chosen_kind(kinds: Any, chosen: int, sense: Any) -> Any:
    """Whether pieces of the tool are some of the follower's that goes with it (1), or against it."""
    return (np.where(sense >= 0.0, kinds, reversed_kinds(kinds)) & chosen) != 0


def mean_of_designs(
    problem: Problem, mean: Mean, designs: Designs, middle: FloatArray, half: FloatArray, kinds: Any
) -> Interval:
    """The mean of the curve to the power p of single designs, by Gauss's rule on parts of the tool's turn."""

    def integrals(rule: GaussRule, index: Any) -> FloatArray:
        some = designs.take(index)
        angles = middle[:, None] + half[:, None] * rule.nodes
        motion: Any = motion_at_places(
            problem, some, ToolPlaces.at_angles(problem.programme, angles.ravel(), MOTION_TERMS)
        )
        weights = (half[:, None] * rule.weights / (2.0 * np.pi)).reshape(-1, 1)
        of, total = np.repeat(kinds, rule.nodes.size)[:, None], np.zeros(len(some))
        for make, chosen in mean.curves:
            value = value_of(make(some, motion), ..., motion.state)
            total += np.sum(weights * has_chosen_kind(of, chosen, motion.sense) * value**mean.power, axis=0)
        return total[None]

    with np.errstate(all="ignore"):
        found = integrate_by_orders(integrals, np.abs, len(designs), MEAN_ERROR)
    value, error = found.value[0], found.error[0]
    known = np.isfinite(value) & np.isfinite(error)
    return Interval(*(np.where(known, value + side * error, side * np.inf) for side in (-1.0, 1.0)))
