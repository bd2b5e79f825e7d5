"""Verdict on a limit on a mean over the turn, for all cams whose trains are within a box.

Over a part of the turn, the curve's formula gives a range, with slopes by each number, for all followers of a box
of trains (``verdicts.train_boxes``). The mean of these ranges over the turn encloses the mean of the box. At one
cam of the box the mean is known far better, by Gauss's rule on each part; with the slopes, this narrows the range
(``numerics.sloped_interval``). If the mean rises or falls with a number all over the box, only that end of the
number is kept. Slopes are closer for shorter parts, so the parts are cut if they are undecided.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.budget import Budget
from camopt.core.numerics.curves import curve_value
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.quadrature import GaussRule, integrate_with_rising_order
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
    whole_turn_parts,
)
from camopt.solve.verdicts.driven_boxes import MOTION_TERMS, ToolPlaces, driven_motion_at_places
from camopt.solve.verdicts.mean_boxes import enclose_weighted_sums, excess_from_mean_of_curve_power
from camopt.solve.verdicts.train_boxes import TrainConstraintSearch, excess_unbounded_if_unassembled
from camopt.solve.verdicts.verdict_words import UNDECIDED

PIECE_CUTS = 1, 8
"""Parts of each smooth piece of the turn: the second number if the first leaves the verdict undecided."""
MEAN_ERROR = 1e-11  # relative error of the mean at one design of a box; its range includes it


def mean_verdict_over_trains(
    problem: Problem,
    constraint: TurnMeanConstraint,
    design: Designs,
    number_ranges: NumberRanges,
    budget: Budget,
) -> BoxVerdict:
    """Verdict on a constraint on a mean for all designs and trains whose numbers lie between ``number_ranges``.

    It is undecided if the curve has kinks that depend on the cam, as guide friction has.
    """
    if constraint.mean.smooth is not None or problem.programme.given_at_follower:
        return BoxVerdict(UNDECIDED)
    for cuts in PIECE_CUTS:
        verdict = TrainMeanSearch(
            problem, constraint, design, tuple(number_ranges), budget, cuts=cuts
        ).search_for_violation(whole_turn_parts(constraint, number_ranges))
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
    def smooth_pieces(self) -> BoxParts:
        """Pieces of the turn on which motion and loads are smooth."""
        return self.tool_panels_split_at_load_corners({})

    @cached_property
    def equal_parts_of_smooth_pieces(self) -> BoxParts:
        """Parts of the pieces."""
        whole = self.smooth_pieces
        ends = np.linspace(whole.low[0], whole.high[0], self.cuts + 1)
        low, high = ends[:-1].reshape(1, -1), ends[1:].reshape(1, -1)
        return BoxParts(np.tile(whole.panel, self.cuts), np.tile(whole.side, self.cuts), low, high, whole.whole)

    def enclose_excess(self, parts: BoxParts) -> SlopedInterval:
        turn, count = self.equal_parts_of_smooth_pieces, parts.size
        index = np.repeat(np.arange(turn.size), count)
        low, high = (
            np.vstack([getattr(turn, end)[0, index], np.tile(getattr(parts, end)[1:], turn.size)])
            for end in ("low", "high")
        )
        motion = self.enclose_motion(BoxParts(turn.panel[index], turn.side[index], low, high, parts.whole))
        designs, inside, like = self.box_and_middle_designs(parts)
        shares = [
            self._mean_range_and_slopes_of_curve(motion, make, kinds, count)
            for make, kinds in self.constraint.mean.curves
        ]
        value, slopes = (sum((share[k] for share in shares[1:]), shares[0][k]) for k in (0, 1))
        slopes = Interval(*(np.vstack([0.0 * end[:1], end[1:]]) for end in (slopes.low, slopes.high)))
        panel, (low, *_), (high, *_) = self.smooth_pieces.panel, self.smooth_pieces.low, self.smooth_pieces.high
        centre, half = (getattr(self.tool_programme.table, column)[panel] for column in ("centre", "half_width"))
        at = estimate_mean_curve_power_of_designs(
            self.problem,
            self.constraint.mean,
            inside,
            centre + half * (low + high) / 2.0,
            half * (high - low) / 2.0,
            self.panel_stroke_kinds[panel],
        )
        excess = excess_from_mean_of_curve_power(
            self.constraint, narrow_by_mean_value(value, at, slopes, like), designs
        )
        return excess_unbounded_if_unassembled(np.all(motion.assembled.reshape(-1, count), axis=0), excess)

    def _mean_range_and_slopes_of_curve(
        self, motion: Any, make_curve: Any, stroke_kinds: int, box_count: int
    ) -> tuple[Interval, Interval]:
        """Share of one curve's pieces in the mean: its range (n,) and its slopes (1 + d, n)."""
        value = curve_value(make_curve(motion.designs, motion.driven), ..., motion.driven.state)
        sloped = value.divide() if isinstance(value, Quotient) else as_sloped_interval(value, motion.angle)
        power = np.square(sloped) if self.constraint.mean.power == 2 else sloped
        turn = self.equal_parts_of_smooth_pieces
        chosen = is_of_chosen_stroke_kind(self.panel_stroke_kinds[turn.panel], stroke_kinds, self.follower_sense)
        # the share of the turn of each part
        share = self.tool_programme.table.half_width[turn.panel] * (turn.high[0] - turn.low[0]) / (2.0 * np.pi)
        weights = np.repeat(np.where(chosen, share, 0.0)[:, None], box_count, axis=1)
        return enclose_weighted_sums(weights, power.value), enclose_weighted_sums(weights, power.slopes)


def is_of_chosen_stroke_kind(tool_stroke_kinds: Any, chosen_kinds: int, follower_sense: Any) -> Any:
    """Whether pieces of the tool have a chosen kind, for a follower that moves with the tool (1) or against it."""
    return (
        np.where(follower_sense >= 0.0, tool_stroke_kinds, reversed_kinds(tool_stroke_kinds)) & chosen_kinds
    ) != 0


def estimate_mean_curve_power_of_designs(
    problem: Problem,
    mean: Mean,
    designs: Designs,
    part_middles: FloatArray,
    part_half_widths: FloatArray,
    part_stroke_kinds: Any,
) -> Interval:
    """Means of the curve to the power p for single designs, by Gauss's rule on parts of the tool's turn."""

    def mean_of_curve_power_by_gauss_rule(rule: GaussRule, index: Any) -> FloatArray:
        batch = designs.take(index)
        angles = part_middles[:, None] + part_half_widths[:, None] * rule.nodes
        motion: Any = driven_motion_at_places(
            problem, batch, ToolPlaces.at_angles(problem.programme, angles.ravel(), MOTION_TERMS)
        )
        weights = (part_half_widths[:, None] * rule.weights / (2.0 * np.pi)).reshape(-1, 1)
        node_kinds, total = np.repeat(part_stroke_kinds, rule.nodes.size)[:, None], np.zeros(len(batch))
        for make, chosen in mean.curves:
            value = curve_value(make(batch, motion), ..., motion.state)
            total += np.sum(
                weights * is_of_chosen_stroke_kind(node_kinds, chosen, motion.sense) * value**mean.power, axis=0
            )
        return total[None]

    with np.errstate(all="ignore"):
        means = integrate_with_rising_order(mean_of_curve_power_by_gauss_rule, np.abs, len(designs), MEAN_ERROR)
    value, error = means.value[0], means.error[0]
    finite = np.isfinite(value) & np.isfinite(error)
    return Interval(*(np.where(finite, value + side * error, side * np.inf) for side in (-1.0, 1.0)))
