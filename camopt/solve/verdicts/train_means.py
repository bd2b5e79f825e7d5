"""Verdict on a limit on a mean over the turn, for all cams whose trains are within a box.

Over a part of the turn, the curve's formula gives a range, with slopes by each number, for all followers of a box
of trains (``verdicts.train_boxes``). The mean of these ranges over the turn encloses the mean of the box. At one
cam of the box the mean is known far better, by Gauss's rule on each part; with the slopes, this narrows the range
(``numerics.sloped_interval``). If the mean rises or falls with a number all over the box, only that end of the
number is kept. Slopes are closer for shorter parts, so the parts are cut if they are undecided.
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
"""Parts of each smooth piece of the turn: the second number if the first leaves the verdict undecided."""
MEAN_ERROR = 1e-11  # relative error of the mean at one design of a box; its range includes it


def mean_over_trains(
    problem: Problem, constraint: TurnMeanConstraint, design: Designs, ends: NumberRanges, until: float = inf
) -> BoxVerdict:
    """Verdict on a constraint on a mean for all designs and trains whose numbers lie between ``ends``.

    It is undecided if the curve has kinks that depend on the cam, as guide friction has.
    """
    if constraint.mean.smooth is not None or problem.programme.given_at_follower:
        return BoxVerdict(UNDECIDED)
    for cuts in PIECE_CUTS:
        verdict = TrainMeanSearch(problem, constraint, design, tuple(ends), until, cuts=cuts).run(
            whole_turn_parts(constraint, ends)
        )
        if verdict.verdict != UNDECIDED:
            return verdict
    return BoxVerdict(UNDECIDED)


@dataclass(frozen=True)
class TrainMeanSearch(TrainConstraintSearch):
    """The search for a cam, with a train of the box, that breaks a constraint on a mean."""

    at_once: ClassVar[int] = MEANS_AT_ONCE
    rounds: ClassVar[int] = MEAN_ROUNDS
    cuts: int = 1

    @cached_property
    def pieces(self) -> BoxParts:
        """Pieces of the turn on which motion and loads are smooth."""
        return self.whole_panels({})

    @cached_property
    def turn(self) -> BoxParts:
        """Parts of the pieces."""
        whole = self.pieces
        ends = np.linspace(whole.low[0], whole.high[0], self.cuts + 1)
        low, high = ends[:-1].reshape(1, -1), ends[1:].reshape(1, -1)
        return BoxParts(np.tile(whole.panel, self.cuts), np.tile(whole.side, self.cuts), low, high, whole.whole)

    @cached_property
    def weights(self) -> FloatArray:
        """Share of the turn of each part."""
        half = self.tool.table.half_width[self.turn.panel]
        return np.asarray(half * (self.turn.high[0] - self.turn.low[0]) / (2.0 * np.pi))

    def excess(self, parts: BoxParts) -> SlopedInterval:
        turn, count = self.turn, parts.size
        index = np.repeat(np.arange(turn.size), count)
        low, high = (
            np.vstack([getattr(turn, end)[0, index], np.tile(getattr(parts, end)[1:], turn.size)])
            for end in ("low", "high")
        )
        motion = self.motion_over(BoxParts(turn.panel[index], turn.side[index], low, high, parts.whole))
        designs, inside, like = boxes_of_parts(self.design, self.names, parts)
        shares = [self._curve_share(motion, make, kinds, count) for make, kinds in self.constraint.mean.curves]
        value, slopes = (sum((share[k] for share in shares[1:]), shares[0][k]) for k in (0, 1))
        slopes = Interval(*(np.vstack([0.0 * end[:1], end[1:]]) for end in (slopes.low, slopes.high)))
        excess = excess_of_mean(
            self.constraint, narrow_by_mean_value(value, self._mean_of_designs(inside), slopes, like), designs
        )
        return restrict_to_assembled(np.all(motion.assembled.reshape(-1, count), axis=0), excess)

    def _mean_of_designs(self, designs: Designs) -> Interval:
        """Means of single designs."""
        panel, (low, *_), (high, *_) = self.pieces.panel, self.pieces.low, self.pieces.high
        centre, half = (getattr(self.tool.table, column)[panel] for column in ("centre", "half_width"))
        middle = centre + half * (low + high) / 2.0
        return mean_of_designs(
            self.problem, self.constraint.mean, designs, middle, half * (high - low) / 2.0, self.kinds[panel]
        )

    def _curve_share(self, motion: Any, make: Any, kinds: int, count: int) -> tuple[Interval, Interval]:
        """Share of one curve's pieces in the mean: its range (n,) and its slopes (1 + d, n)."""
        value = value_of(make(motion.designs, motion.driven), ..., motion.driven.state)
        sloped = value.divide() if isinstance(value, Quotient) else as_sloped_interval(value, motion.angle)
        power = np.square(sloped) if self.constraint.mean.power == 2 else sloped
        chosen = has_chosen_kind(self.kinds[self.turn.panel], kinds, self.sense)
        weights = np.repeat(np.where(chosen, self.weights, 0.0)[:, None], count, axis=1)
        return weighted_sums(weights, power.value), weighted_sums(weights, power.slopes)


def has_chosen_kind(kinds: Any, chosen: int, sense: Any) -> Any:
    """Whether pieces of the tool have a chosen kind, for a follower that moves with the tool (1) or against it."""
    return (np.where(sense >= 0.0, kinds, reversed_kinds(kinds)) & chosen) != 0


def mean_of_designs(
    problem: Problem, mean: Mean, designs: Designs, middle: FloatArray, half: FloatArray, kinds: Any
) -> Interval:
    """Means of the curve to the power p for single designs, by Gauss's rule on parts of the tool's turn."""

    def integrals(rule: GaussRule, index: Any) -> FloatArray:
        batch = designs.take(index)
        angles = middle[:, None] + half[:, None] * rule.nodes
        motion: Any = motion_at_places(
            problem, batch, ToolPlaces.at_angles(problem.programme, angles.ravel(), MOTION_TERMS)
        )
        weights = (half[:, None] * rule.weights / (2.0 * np.pi)).reshape(-1, 1)
        node_kinds, total = np.repeat(kinds, rule.nodes.size)[:, None], np.zeros(len(batch))
        for make, chosen in mean.curves:
            value = value_of(make(batch, motion), ..., motion.state)
            total += np.sum(weights * has_chosen_kind(node_kinds, chosen, motion.sense) * value**mean.power, axis=0)
        return total[None]

    with np.errstate(all="ignore"):
        means = integrate_by_orders(integrals, np.abs, len(designs), MEAN_ERROR)
    value, error = means.value[0], means.error[0]
    finite = np.isfinite(value) & np.isfinite(error)
    return Interval(*(np.where(finite, value + side * error, side * np.inf) for side in (-1.0, 1.0)))
