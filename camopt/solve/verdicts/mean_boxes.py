"""Means over the turn of boxes of designs: their range, their value at one design of each box, and their slopes.

On each panel the motion has a range, and the formula of the curve, on it and on the box, one too: the mean of
these over the turn encloses that of every design of the box, and the mean of their slopes its slopes. At one design
of each box it is far better known (``effects.mean_columns``); with the slopes, that narrows the range
(``numerics.sloped``).
"""

from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.curves import value_of
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.loading import TrainLoadTable
from camopt.core.numerics.sloped import Quotient, Sloped, as_sloped, at_point, by_mean_value
from camopt.core.numerics.state import Load, State, TrainForces
from camopt.model.effects import Case
from camopt.model.effects.mean import Mean
from camopt.model.effects.mean_columns import powers_of
from camopt.model.effects.peak import Derivative
from camopt.model.mechanisms import Designs
from camopt.model.motion.programme import Programme
from camopt.scene.problem.claims import MeanClaim
from camopt.scene.problem.problem import Problem, exactly
from camopt.solve.verdicts.sloped_designs import sloped_boxes
from camopt.solve.verdicts.words import BROKEN, HELD, UNDECIDED

ROUNDED = 1e-13  # of the sum of magnitudes: what sums over panels lose


def powers_over(problem: Problem, mean: Mean, box: Designs, inside: Designs, free: list[str]) -> Sloped:
    """The mean of the curve to the power p over n boxes of designs, seen from one design of each."""
    if isinstance(mean.curves[0][0], Derivative):
        same = powers_of(Case(problem.setup, problem.programme, inside), mean).value
        return as_sloped(same, sloped_boxes(box, inside, free, 1)[1])
    parts = [_of_curve(problem.programme, mean, k, box, inside, free) for k in range(len(mean.curves))]
    value, slopes = (sum((part[k] for part in parts[1:]), parts[0][k]) for k in (0, 1))
    found = powers_of(Case(exactly(problem).setup, problem.programme, inside), mean)
    known = np.isfinite(found.value)
    at = Interval(*(np.where(known, found.value + side * found.error, side * np.inf) for side in (-1.0, 1.0)))
    return by_mean_value(value, at, slopes, sloped_boxes(box, inside, free, 1)[1])


def _of_curve(
    programme: Programme, mean: Mean, number: int, box: Designs, inside: Designs, free: list[str]
) -> tuple[Interval, Interval]:
    """The share of the pieces of one curve: its range (n,) and its slopes (d, n)."""
    make, kinds = mean.curves[number]
    panels, count = np.flatnonzero(programme.panels_of(kinds)), len(box)
    designs, like = sloped_boxes(box, inside, free, max(panels.size, 1))
    weights = programme.table.half_width[panels] / np.pi
    if not panels.size:
        return 0.0 * like.value, 0.0 * like.slopes
    value = value_of(make(designs, programme), ..., _ranges(programme, np.repeat(panels, count)))
    made = value.divided() if isinstance(value, Quotient) else as_sloped(value, like)
    power = np.square(made) if mean.power == 2 else made
    shares = np.broadcast_to(weights[:, None], (panels.size, count))
    return weighted(shares, power.value), weighted(shares, power.slopes)


def _ranges(programme: Programme, panels: Any) -> State:
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


def weighted(weights: FloatArray, ranges: Interval) -> Interval:
    """Sums (…, n) of ranges (…, m·n), each with its weight (m, n), and their rounding."""
    rows = ranges.reshaped(*ranges.low.shape[:-1], *weights.shape)
    low, high = (np.einsum("mn,...mn->...n", weights, end) for end in (rows.low, rows.high))
    room = ROUNDED * np.einsum("mn,...mn->...n", weights, rows.largest_magnitude)
    return Interval(low - room, high + room)


def mean_excess(problem: Problem, claim: MeanClaim, box: Designs, inside: Designs, free: list[str]) -> Sloped:
    """The excess over a limit on a mean, relative to its terms: above 0 it does not hold."""
    designs, _ = sloped_boxes(box, inside, free, 1)
    return excess_of_mean(claim, powers_over(problem, claim.mean, box, inside, free), designs)


def excess_of_mean(claim: MeanClaim, powers: Sloped, designs: Designs) -> Sloped:
    """The excess of designs of boxes from the mean of their curve to the power p."""
    found, allowed = powers * claim.factor(designs), claim.allowed()
    scale = at_point(found).least_magnitude + abs(allowed)
    excess: Sloped = (found - allowed) * claim.side / np.where(scale > 0.0, scale, 1.0)
    return excess


def mean_verdict(problem: Problem, claim: MeanClaim, design: Designs) -> str:
    """The verdict on a limit on a mean for one design."""
    found = powers_of(Case(exactly(problem).setup, problem.programme, design), claim.mean)
    powers = Interval(found.value - found.error, found.value + found.error)
    over = (powers * claim.factor(design) - claim.allowed()) * claim.side
    return HELD if over.high[0] <= 0.0 else BROKEN if over.low[0] > 0.0 else UNDECIDED
