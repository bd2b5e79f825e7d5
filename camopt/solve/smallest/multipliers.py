"""Multipliers: how much each bound that a smallest cam just meets adds to its size.

With z the free sizes and angles, among them the size R, and c ≤ 0 what binds, limits and ends of ``[search]``,

    ∇R + Σ λ_i ∇c_i = 0,  λ_i ≥ 0   (Karush, Kuhn and Tucker),      dR/db = Σ λ_i ∂c_i/∂b   (envelope theorem)

for a bound b, the price of b. With the size alone free, and one limit, that is −(∂c/∂b)/(∂c/∂R).

The excess of a limit is that of the largest value of a curve. Where a curve is as large at two cam angles, the
excess has a kink, with a gradient on each side, and each has a multiplier: they are looked for at points around the
cam. Where multipliers are not unique, as when one of two limits that bind would be enough, easing a bound saves the
least that they allow, and tightening it costs the most: linear programmes.

Sources: J. Nocedal, S. J. Wright, Numerical Optimization, ch. 12; J. Gauvin, F. Dubeau, Differential properties of
the marginal function in mathematical programming, Mathematical Programming Study 19 (1982); J. V. Burke, A. S.
Lewis, M. L. Overton, A robust gradient sampling algorithm, SIAM Journal on Optimization 15 (2005).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf, nan
from typing import NamedTuple

import numpy as np
import scipy

from camopt.core.numerics import FloatArray
from camopt.scene.problem.limit import Limit
from camopt.solve.smallest.free_variables import EXCESS_STEP, FreeVariables
from camopt.solve.verdicts.limit_verdicts import excesses_of_variants

ACTIVE_DISTANCE = 1e-6  # a limit within this relative distance of its bound holds the optimum
KINK_LINES = 2  # lines by direction along which the sides of kinks are sought
KINK_STEPS = 10.0  # steps from the cam to points on them
STRAIGHT_BEND = 1e-3  # of its slope: by which a slope may change over a step, where there is no kink
GRADIENT_RESIDUAL = 1e-2  # of ∇R: what multipliers may leave of it; more, and something else holds the cam
KINK_ERROR = 1e-4  # of ∇R: what differences err by at kinks
FAINT_FACTOR = 10.0  # times that room: a multiplier that may be 0 and is no larger is 0
EQUAL_PRICES = 1e-2  # relative: prices that differ by no more are one


@dataclass(frozen=True)
class ActiveConstraint:
    """A bound that a cam just meets, as a limit c ≤ 0 on the cam's free variables."""

    key: str
    value: float
    unit: str
    relation: str
    gradients: FloatArray
    """Of c, along the directions of a freedom: one, or one for each side of a kink (gradients, directions)."""
    bound_derivative: float
    """∂c/∂value."""
    limit: Limit | None = None
    """The limit of the scene; None for an end of a range of ``[search]``."""


class PriceRates(NamedTuple):
    """mm of size per unit of a bound; not a number where the multipliers do not explain the cam."""

    eased: float
    tightened: float


ZERO_RATES = PriceRates(0.0, 0.0)
"""Of a bound that holds nothing: the cam just happens to meet it."""


def active_constraints(freedom: FreeVariables) -> list[ActiveConstraint]:
    """The bounds that a cam just meets, of limits and of ``[search]``; not of limits that are held or not."""
    problem = freedom.problem
    limits = problem.without_deferred_limits.limits
    cams, columns, found = zip(*excesses_of_variants(problem, limits, problem.design), strict=True)
    excess = np.array(found)[:, :, 0]
    worst, most = excess.argmax(axis=0), excess.max(axis=0)
    met = [number for number, over in enumerate(most) if over > -ACTIVE_DISTANCE]
    bounds = []
    for number, gradients in zip(met, _excess_gradients(freedom, [limits[k] for k in met]), strict=True):
        limit, of = limits[number], worst[number]
        unit = limit.quantity.unit if limit.quantity else "mm"
        by_value = float(limit.excess_derivative(columns[of], cams[of])[0])
        bounds.append(ActiveConstraint(limit.key, limit.bound, unit, limit.relation, gradients, by_value, limit))
    return [*bounds, *_active_range_ends(freedom)]


def _active_range_ends(freedom: FreeVariables) -> Iterator[ActiveConstraint]:
    for end in freedom.range_ends:
        if end.side * (freedom.values[end.variable] - end.value) > -ACTIVE_DISTANCE * freedom.scales[end.variable]:
            gradient = end.side * freedom.directions[[end.variable]]
            yield ActiveConstraint(end.key, end.value, end.unit, end.relation, gradient, -end.side)


def _excess_gradients(freedom: FreeVariables, limits: Sequence[Limit]) -> Iterator[FloatArray]:
    """The gradients of each limit's excess, by central differences: at the cam, or around it if it has a kink."""
    count = freedom.directions.shape[1]
    around = np.random.default_rng(0).normal(size=(KINK_LINES * count, count))
    around *= KINK_STEPS * EXCESS_STEP / np.linalg.norm(around, axis=1, keepdims=True)
    centres = np.vstack([np.zeros(count), around, -around])
    steps = EXCESS_STEP * np.vstack([np.zeros(count), np.eye(count), -np.eye(count)])
    points = (centres[:, None] + steps).reshape(-1, count)
    for values in freedom.excesses_at_steps(limits, points).reshape(len(limits), len(centres), len(steps)):
        middle, ahead, behind = values[:, :1], values[:, 1 : count + 1], values[:, count + 1 :]
        with np.errstate(invalid="ignore"):  # infinite beyond an undercut
            slopes, bends = (
                (ahead - behind) / (2.0 * EXCESS_STEP),
                np.abs(ahead + behind - 2.0 * middle) / EXCESS_STEP,
            )
            straight = bends.max(axis=1) <= STRAIGHT_BEND * np.abs(slopes).max(axis=1)
        yield slopes[:1] if straight[0] else slopes[straight]


def price_rates(
    freedom: FreeVariables, bounds: Sequence[ActiveConstraint], others: Mapping[str, FloatArray] | None = None
) -> dict[str, PriceRates]:
    """What each bound costs, by its key; and other numbers, by which each bound's c has the derivatives given."""
    names, slopes = dict.fromkeys(bound.key for bound in bounds), dict(others or {})
    larger, *other = freedom.disc_indices
    goal = freedom.directions[larger]
    if other and freedom.values[larger] - freedom.values[other[0]] <= ACTIVE_DISTANCE * freedom.scales[larger]:
        bounds = [
            *bounds,
            ActiveConstraint("", 0.0, "mm", "≤", freedom.directions[other] - goal, 0.0),
        ]  # not larger
        slopes = {key: np.append(each, 0.0) for key, each in slopes.items()}
    own = {key: np.array([each.bound_derivative if each.key == key else 0.0 for each in bounds]) for key in names}
    slopes = own | slopes
    columns = np.vstack([np.empty((0, goal.size)), *(bound.gradients for bound in bounds)]).T
    size = np.linalg.norm(columns, axis=0)
    size[size == 0.0] = 1.0
    columns = columns / size
    whose = np.repeat(np.arange(len(bounds)), [len(bound.gradients) for bound in bounds])
    weights, left = _fit_multipliers(columns, goal)
    if left > GRADIENT_RESIDUAL * np.linalg.norm(goal):
        return dict.fromkeys(slopes, PriceRates(nan, nan))
    room = float(left + KINK_ERROR * np.linalg.norm(goal))
    found = {}
    for key, by_bound in slopes.items():
        of_key = by_bound[whose] / size
        one = float(weights @ of_key)
        low, high = sorted(
            (_least_price(of_key, columns, goal, room), -_least_price(-of_key, columns, goal, room)), key=abs
        )
        noise = room * np.abs(of_key).max()
        if abs(one) <= noise and abs(high) <= FAINT_FACTOR * noise:
            found[key] = ZERO_RATES
            continue
        found[key] = PriceRates(one, one) if abs(high - low) <= EQUAL_PRICES * abs(high) else PriceRates(low, high)
    return found


def _fit_multipliers(columns: FloatArray, goal: FloatArray) -> tuple[FloatArray, float]:
    """Multipliers that leave the least of ∇R, and how much that is."""
    if not columns.size:
        return np.zeros(0), inf
    if columns.shape == (1, 1):  # of the size alone, and one limit: scipy takes longer to import than all the rest
        weights = np.maximum(-goal / columns[0], 0.0)
        return weights, float(np.abs(goal + columns[0] * weights)[0])
    weights, left = scipy.optimize.nnls(columns, -goal)
    return weights, left


def _least_price(slopes: FloatArray, columns: FloatArray, goal: FloatArray, room: float) -> float:
    """The least sum of multipliers times slopes, of all that leave no more than some room; −∞ if it has none."""
    if columns.shape == (1, 1):
        middle, reach = -goal[0] / columns[0, 0], room / abs(columns[0, 0])
        return float(min(slopes[0] * max(middle + side * reach, 0.0) for side in (-1.0, 1.0)))
    both, most = np.vstack([columns, -columns]), np.concatenate([room - goal, room + goal])
    answer = scipy.optimize.linprog(slopes, both, most)
    return float(answer.fun) if answer.status == 0 else -inf
