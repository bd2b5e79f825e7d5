"""Means over the turn for boxes of designs: their ranges, their values at one design of each box, and their slopes.

On each panel the motion has a range. With it and the box, the curve's formula gives a range of the curve. The mean
of these ranges encloses the mean of every design of the box, and the mean of their slopes encloses its slopes. At
one design of each box the mean is known far better (``effects.mean_columns``); with the slopes, this narrows the
range (``numerics.sloped_interval``).
"""

from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.curves import curve_value
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.load_tables import TrainLoadTable
from camopt.core.numerics.sloped_interval import (
    Quotient,
    SlopedInterval,
    as_sloped_interval,
    narrow_by_mean_value,
    value_at_box_point,
)
from camopt.core.numerics.state import Load, State, TrainForces
from camopt.model.effects import EvaluationBlock
from camopt.model.effects.mean import Mean
from camopt.model.effects.mean_columns import power_means
from camopt.model.effects.peak import MotionDerivative
from camopt.model.mechanisms import Designs
from camopt.model.motion.programme import Programme
from camopt.scene.problem.constraints import TurnMeanConstraint
from camopt.scene.problem.problem import Problem, with_rounding_relative_error
from camopt.solve.verdicts.sloped_designs import designs_of_sloped_intervals
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, UNDECIDED

SUM_ROUNDING = 1e-13  # rounding of sums over panels, relative to the sum of magnitudes


def enclose_mean_of_curve_power(
    problem: Problem, mean: Mean, box: Designs, inner_designs: Designs, free_names: list[str]
) -> SlopedInterval:
    """Enclosure of a curve's mean p-th power over n boxes, with a value and slopes in each box."""
    if isinstance(mean.curves[0][0], MotionDerivative):
        of_motion = power_means(EvaluationBlock(problem.setup, problem.programme, inner_designs), mean).value
        return as_sloped_interval(of_motion, designs_of_sloped_intervals(box, inner_designs, free_names, 1)[1])
    parts = [
        _mean_range_and_slopes_of_curve(problem.programme, mean, k, box, inner_designs, free_names)
        for k in range(len(mean.curves))
    ]
    value, slopes = (sum((part[k] for part in parts[1:]), parts[0][k]) for k in (0, 1))
    point = power_means(
        EvaluationBlock(with_rounding_relative_error(problem).setup, problem.programme, inner_designs), mean
    )
    finite = np.isfinite(point.value)
    at = Interval(*(np.where(finite, point.value + side * point.error, side * np.inf) for side in (-1.0, 1.0)))
    return narrow_by_mean_value(
        value, at, slopes, designs_of_sloped_intervals(box, inner_designs, free_names, 1)[1]
    )


def _mean_range_and_slopes_of_curve(
    programme: Programme, mean: Mean, curve_number: int, box: Designs, inner_designs: Designs, free_names: list[str]
) -> tuple[Interval, Interval]:
    """Share of one curve's pieces in the mean: its range (n,) and its slopes (d, n)."""
    make, kinds = mean.curves[curve_number]
    panels, count = np.flatnonzero(programme.panels_with_kinds(kinds)), len(box)
    designs, like = designs_of_sloped_intervals(box, inner_designs, free_names, max(panels.size, 1))
    weights = programme.table.half_width[panels] / np.pi
    if not panels.size:
        return 0.0 * like.value, 0.0 * like.slopes
    value = curve_value(
        make(designs, programme), ..., _state_range_over_panels(programme, np.repeat(panels, count))
    )
    sloped = value.divide() if isinstance(value, Quotient) else as_sloped_interval(value, like)
    power = np.square(sloped) if mean.power == 2 else sloped
    shares = np.broadcast_to(weights[:, None], (panels.size, count))
    return enclose_weighted_sums(shares, power.value), enclose_weighted_sums(shares, power.slopes)


def _state_range_over_panels(programme: Programme, panels: Any) -> State:
    """Range of the state over whole panels, without the jerk; slopes by the cam angle have no meaning."""
    table, load = programme.table, programme.table.load
    error = table.error[panels]
    y, y1, y2 = (
        Interval(table.low[panels, k] - error[:, k], table.high[panels, k] + error[:, k]) for k in range(3)
    )
    if load is None:
        return State(y, y1, y2, 0.0)
    if isinstance(load, TrainLoadTable):
        value, carried = (
            Interval(part.low[panels, 0] - part.error[panels, 0], part.high[panels, 0] + part.error[panels, 0])
            for part in load
        )
        return State(y, y1, y2, 0.0, TrainForces(value, 0.0, carried, 0.0))
    rounding = load.error[panels, 0]
    return State(y, y1, y2, 0.0, Load(Interval(load.low[panels] - rounding, load.high[panels] + rounding), 0.0))


def enclose_weighted_sums(weights: FloatArray, ranges: Interval) -> Interval:
    """Weighted sums (…, n) of ranges (…, m·n) with weights (m, n), widened by their rounding."""
    rows = ranges.reshape(*ranges.low.shape[:-1], *weights.shape)
    low, high = (np.einsum("mn,...mn->...n", weights, end) for end in (rows.low, rows.high))
    room = SUM_ROUNDING * np.einsum("mn,...mn->...n", weights, rows.largest_magnitude)
    return Interval(low - room, high + room)


def enclose_mean_excess(
    problem: Problem, constraint: TurnMeanConstraint, box: Designs, inner_designs: Designs, free_names: list[str]
) -> SlopedInterval:
    """Excess over a limit on a mean for boxes of designs, relative to its terms; above 0 the limit is broken."""
    designs, _ = designs_of_sloped_intervals(box, inner_designs, free_names, 1)
    return excess_from_mean_of_curve_power(
        constraint, enclose_mean_of_curve_power(problem, constraint.mean, box, inner_designs, free_names), designs
    )


def excess_from_mean_of_curve_power(
    constraint: TurnMeanConstraint, powers: SlopedInterval, designs: Designs
) -> SlopedInterval:
    """Excess over a limit on a mean, from the mean of the curve to the power p."""
    quantity, allowed = powers * constraint.factor(designs), constraint.upper_bound_of_each_side()
    scale = value_at_box_point(quantity).least_magnitude + abs(allowed)
    excess: SlopedInterval = (quantity - allowed) * constraint.side / np.where(scale > 0.0, scale, 1.0)
    return excess


def mean_verdict_of_design(problem: Problem, constraint: TurnMeanConstraint, design: Designs) -> str:
    """Verdict on a limit on a mean for one design."""
    mean = power_means(
        EvaluationBlock(with_rounding_relative_error(problem).setup, problem.programme, design), constraint.mean
    )
    powers = Interval(mean.value - mean.error, mean.value + mean.error)
    over = (powers * constraint.factor(design) - constraint.upper_bound_of_each_side()) * constraint.side
    return HELD if over.high[0] <= 0.0 else BROKEN if over.low[0] > 0.0 else UNDECIDED
