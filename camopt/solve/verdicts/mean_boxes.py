"""Means over the turn of boxes of designs: their range, their value at one design of each box, and their slopes.

On each panel the motion has a range, and the formula of the curve, on it and on the box, one too: the mean of
these over the turn encloses that of every design of the box, and the mean of their slopes its slopes. At one design
of each box it is far better known (``effects.mean_columns``); with the slopes, that narrows the range
(``numerics.sloped_interval``).
"""

from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.load_tables import TrainLoadTable
from camopt.core.numerics.sloped_interval import (
    Quotient,
    SlopedInterval,
    as_sloped_interval,
    narrow_by_mean_value,
    value_at_point,
)
from camopt.core.numerics.state import Load, State, TrainForces
from camopt.model.effects import EvaluationBlock
from camopt.model.effects.mean import Mean
from camopt.model.effects.mean_columns import power_means
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms import Designs
from camopt.model.motion.programme import Programme
from camopt.scene.problem.constraints import TurnMeanConstraint
from camopt.scene.problem.problem import Problem, at_rounding_error
from camopt.solve.verdicts.sloped_designs import sloped_boxes
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED

SUM_ROUNDING = 1e-13  # of the sum of magnitudes: what sums over panels lose


def mean_power_over(problem: Problem, mean: Mean, box: Designs, inside: Designs, free: list[str]) -> SlopedInterval:
    """The mean of the curve to the power p over n boxes of designs, seen from one design of each."""
    if isinstance(mean.curves[0][0], Derivative):
        same = power_means(EvaluationBlock(problem.setup, problem.programme, inside), mean).value
        return as_sloped_interval(same, sloped_boxes(box, inside, free, 1)[1])
    parts = [_share_of_curve(problem.programme, mean, k, box, inside, free) for k in range(len(mean.curves))]
    value, slopes = (sum((part[k] for part in parts[1:]), parts[0][k]) for k in (0, 1))
    found = power_means(EvaluationBlock(at_rounding_error(problem).setup, problem.programme, inside), mean)
    known = np.isfinite(found.value)
    at = Interval(*(np.where(known, found.value + side * found.error, side * np.inf) for side in (-1.0, 1.0)))
    return narrow_by_mean_value(value, at, slopes, sloped_boxes(box, inside, free, 1)[1])


def _share_of_curve(
    programme: Programme, mean: Mean, number: int, box: Designs, inside: Designs, free: list[str]
) -> tuple[Interval, Interval]:
    """The share of the pieces of one curve: its range (n,) and its slopes (d, n)."""
    make, kinds = mean.curves[number]
    panels, count = np.flatnonzero(programme.panels_of(kinds)), len(box)
    designs, like = sloped_boxes(box, inside, free, max(panels.size, 1))
    weights = programme.table.half_width[panels] / np.pi
    if not panels.size:
        return 0.0 * like.value, 0.0 * like.slopes
    value = value_of(make(designs, programme), ..., _state_over_panels(programme, np.repeat(panels, count)))
    made = value.divide() if isinstance(value, Quotient) else as_sloped_interval(value, like)
    power = np.square(made) if mean.power == 2 else made
    shares = np.broadcast_to(weights[:, None], (panels.size, count))
    return weighted_sums(shares, power.value), weighted_sums(shares, power.slopes)


def _state_over_panels(programme: Programme, panels: Any) -> State:
    """The state over whole panels, in ranges; no jerk, so that slopes by the cam angle mean nothing."""
    table, load = programme.table, programme.table.load
    error = table.error[panels]
    y, y1, y2 = (
        Interval(table.low[panels, k] - error[:, k], table.high[panels, k] + error[:, k]) for k in range(3)
    )
    if load is None:
        return State(y, y1, y2, 0.0)
    if isinstance(load, TrainLoadTable):
        value, carried = (
            Interval(each.low[panels, 0] - each.error[panels, 0], each.high[panels, 0] + each.error[panels, 0])
            for each in load
        )
        return State(y, y1, y2, 0.0, TrainForces(value, 0.0, carried, 0.0))
    off = load.error[panels, 0]
    return State(y, y1, y2, 0.0, Load(Interval(load.low[panels] - off, load.high[panels] + off), 0.0))


def weighted_sums(weights: FloatArray, ranges: Interval) -> Interval:
    """Sums (…, n) of ranges (…, m·n), each with its weight (m, n), and their rounding."""
    rows = ranges.reshape(*ranges.low.shape[:-1], *weights.shape)
    low, high = (np.einsum("mn,...mn->...n", weights, end) for end in (rows.low, rows.high))
    room = SUM_ROUNDING * np.einsum("mn,...mn->...n", weights, rows.largest_magnitude)
    return Interval(low - room, high + room)


def mean_excess(
    problem: Problem, constraint: TurnMeanConstraint, box: Designs, inside: Designs, free: list[str]
) -> SlopedInterval:
    """The excess over a limit on a mean, relative to its terms: above 0 it does not hold."""
    designs, _ = sloped_boxes(box, inside, free, 1)
    return excess_of_mean(constraint, mean_power_over(problem, constraint.mean, box, inside, free), designs)


def excess_of_mean(constraint: TurnMeanConstraint, powers: SlopedInterval, designs: Designs) -> SlopedInterval:
    """The excess of designs of boxes from the mean of their curve to the power p."""
    found, allowed = powers * constraint.factor(designs), constraint.upper_bound()
    scale = value_at_point(found).least_magnitude + abs(allowed)
    excess: SlopedInterval = (found - allowed) * constraint.side / np.where(scale > 0.0, scale, 1.0)
    return excess


def mean_verdict(problem: Problem, constraint: TurnMeanConstraint, design: Designs) -> str:
    """The verdict on a limit on a mean for one design."""
    found = power_means(
        EvaluationBlock(at_rounding_error(problem).setup, problem.programme, design), constraint.mean
    )
    powers = Interval(found.value - found.error, found.value + found.error)
    over = (powers * constraint.factor(design) - constraint.upper_bound()) * constraint.side
    return HELD if over.high[0] <= 0.0 else BROKEN if over.low[0] > 0.0 else UNDECIDED
