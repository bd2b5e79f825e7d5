"""Limits on means over the turn, of boxes of sizes and trains: as ``verdicts.mean_boxes`` has those of sizes alone.

On each panel of its turn the tool's motion has a range, which links take to one of the followers of all trains of a
box (``driven_boxes``), and the formula of the curve to its range and slopes. At one design of each box the mean is
far better known, by Gauss's rule; with the slopes, that narrows the range.
"""

from typing import Any

import numpy as np

from camopt.effects.mean import Mean
from camopt.effects.peak import Derivative
from camopt.mechanisms import Designs
from camopt.motion.driven import travel
from camopt.motion.load import ExternalLoad
from camopt.motion.train_load import TrainLoad
from camopt.numerics import FloatArray
from camopt.numerics.curves import value_of
from camopt.numerics.interval import Interval
from camopt.numerics.sloped import Quotient, Sloped, as_sloped, by_mean_value
from camopt.problem.claims import MeanClaim
from camopt.problem.problem import Problem
from camopt.smallest.excesses import Excesses
from camopt.verdicts.driven_boxes import TERMS, Driven, over_ranges
from camopt.verdicts.mean_boxes import excess_of_mean, weighted
from camopt.verdicts.train_means import counts, mean_at


def means_of_trains(problem: Problem) -> list[MeanClaim]:
    """The claims on means that differ between cams and trains; of loads that are the same all over the turn."""
    load = problem.programme.load
    if isinstance(load, ExternalLoad) or (isinstance(load, TrainLoad) and load.loads):
        return []
    means = [limit.mean for limit in problem.limits if limit.mean is not None]
    return [
        each for each in means if each.mean.smooth is None and not isinstance(each.mean.curves[0][0], Derivative)
    ]


def mean_excesses(
    problem: Problem, claim: MeanClaim, boxes: Designs, inside: Designs, like: Sloped
) -> tuple[Excesses, FloatArray]:
    """The excess over a limit on a mean, and of which boxes it is known: where the followers go one way."""
    table, count = problem.programme.tool.table, like.size
    every = np.tile(np.arange(count), len(table.centre))
    designs, panels = boxes.take(every), np.repeat(np.arange(len(table.centre)), count)
    driven = over_ranges(problem, designs, *_tool_on(problem, panels))
    known = np.all(driven.sense.reshape(-1, count) != 0.0, axis=0)
    parts = [
        _share(problem, claim.mean, number, designs, driven, like[every], count)
        for number in range(len(claim.mean.curves))
    ]
    value, slopes = (sum((part[k] for part in parts[1:]), parts[0][k]) for k in (0, 1))
    at = mean_at(problem, claim.mean, inside, table.centre, table.half_width, _kinds(problem))
    found = by_mean_value(value, at, slopes, like)
    return Excesses.of(excess_of_mean(claim, found, boxes)), known


def _tool_on(problem: Problem, panels: Any) -> tuple[list[Interval], Any]:
    """The motion of the tool over panels of its turn, from the start of trains, and the kinds of these."""
    turn = problem.programme
    table, zero = turn.tool.table, travel(turn)[0] - turn.tool.levels[0]
    low, high, error = (rows[panels, :TERMS].T.copy() for rows in (table.low, table.high, table.error))
    low[0], high[0] = low[0] + zero, high[0] + zero
    return [Interval(a - off, b + off) for a, b, off in zip(low, high, error, strict=True)], _kinds(problem)[panels]


def _kinds(problem: Problem) -> Any:
    """Of each panel of the tool's turn."""
    table = problem.programme.tool.table
    return np.repeat(table.kind, np.diff(table.first_panel))


def _share(
    problem: Problem, mean: Mean, number: int, designs: Designs, driven: Driven, like: Sloped, count: int
) -> tuple[Interval, Interval]:
    """The share of the pieces of one curve of a mean: its range (n,) and its slopes (d, n)."""
    make: Any
    make, kinds = mean.curves[number]
    value = value_of(make(designs, driven), ..., driven.state)
    made = value.divided() if isinstance(value, Quotient) else as_sloped(value, like)
    power = np.square(made) if mean.power == 2 else made
    weights = np.repeat(problem.programme.tool.table.half_width / np.pi, count)
    of = np.repeat(_kinds(problem), count)
    shares = np.where(counts(of, kinds, driven.sense), weights, 0.0).reshape(-1, count)
    return weighted(shares, power.value), weighted(shares, power.slopes)
