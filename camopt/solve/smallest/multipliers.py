"""Lagrange multipliers of a smallest cam: how much each active limit adds to its size.

Let z be the free sizes and angles, among them the size R. Let c_i ≤ 0 be the active constraints: limits and ends of
ranges in ``[search]``. Then

    ∇R + Σ λ_i ∇c_i = 0,  λ_i ≥ 0   (Karush, Kuhn and Tucker),      dR/db = Σ λ_i ∂c_i/∂b   (envelope theorem)

where dR/db is the price of a bound b. If only the size is free and one limit is active, it is −(∂c/∂b)/(∂c/∂R).

The excess of a limit comes from the largest value of a curve. If a curve is equally large at two cam angles, the
excess has a kink with a gradient on each side. Each gradient has its own multiplier; camopt samples them at points
around the cam. If one of two active limits would be enough, the multipliers are not unique. Easing a bound then
saves the least that they allow, and tightening it costs the most. Both are linear programmes.

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

ACTIVE_DISTANCE = 1e-6  # a limit within this relative distance of its bound is active
KINK_LINES = 2  # sampled lines for each direction, to find the sides of kinks
KINK_STEPS = 10.0  # distance of the samples from the cam, in steps
STRAIGHT_BEND = 1e-3  # largest relative change of a slope over a step without a kink
GRADIENT_RESIDUAL = 1e-2  # relative to ∇R: largest residual; with more, another condition holds the cam
KINK_ERROR = 1e-4  # relative to ∇R: error of differences at kinks
FAINT_FACTOR = 10.0  # a multiplier that may be 0 counts as 0 up to this many times its error
EQUAL_PRICES = 1e-2  # relative: prices that differ by no more count as equal


@dataclass(frozen=True)
class ActiveConstraint:
    """An active bound, as a constraint c ≤ 0 on the cam's free variables."""

    key: str
    value: float
    unit: str
    relation: str
    gradients: FloatArray
    """Gradients of c along the free directions, one for each side of a kink (gradients, directions)."""
    bound_derivative: float
    """∂c/∂value."""
    limit: Limit | None = None
    """The limit of the scene; None for an end of a range in ``[search]``."""


class PriceRates(NamedTuple):
    """Change of the size per unit of a bound [mm per unit]; NaN if the multipliers do not explain the cam."""

    eased: float
    tightened: float


ZERO_RATES = PriceRates(0.0, 0.0)
"""The rates of a bound that the cam meets by chance, and which does not limit its size."""


def active_constraints(free_variables: FreeVariables) -> list[ActiveConstraint]:
    """The active bounds of a cam, from limits and from ``[search]``; limits without a value are left out."""
    problem = free_variables.problem
    limits = problem.without_deferred_limits.limits
    cams, columns, excesses = zip(*excesses_of_variants(problem, limits, problem.design), strict=True)
    excess = np.array(excesses)[:, :, 0]
    worst, most = excess.argmax(axis=0), excess.max(axis=0)
    active = [number for number, over in enumerate(most) if over > -ACTIVE_DISTANCE]
    bounds = []
    for number, gradients in zip(
        active, _excess_gradients(free_variables, [limits[k] for k in active]), strict=True
    ):
        limit, cam = limits[number], worst[number]
        unit = limit.quantity.unit if limit.quantity else "mm"
        by_value = float(limit.excess_derivative_by_bound(columns[cam], cams[cam])[0])
        bounds.append(ActiveConstraint(limit.key, limit.bound, unit, limit.relation, gradients, by_value, limit))
    for end in free_variables.range_ends:
        distance = end.side * (free_variables.values[end.variable] - end.value)
        if distance > -ACTIVE_DISTANCE * free_variables.scales[end.variable]:
            gradient = end.side * free_variables.independent_change_directions[[end.variable]]
            bounds.append(ActiveConstraint(end.key, end.value, end.unit, end.relation, gradient, -end.side))
    return bounds


def _excess_gradients(free_variables: FreeVariables, limits: Sequence[Limit]) -> Iterator[FloatArray]:
    """The gradients of each limit's excess by central differences: at the cam, or around it if there is a kink."""
    count = free_variables.independent_change_directions.shape[1]
    around = np.random.default_rng(0).normal(size=(KINK_LINES * count, count))
    around *= KINK_STEPS * EXCESS_STEP / np.linalg.norm(around, axis=1, keepdims=True)
    centres = np.vstack([np.zeros(count), around, -around])
    steps = EXCESS_STEP * np.vstack([np.zeros(count), np.eye(count), -np.eye(count)])
    points = (centres[:, None] + steps).reshape(-1, count)
    for values in free_variables.excesses_at_steps(limits, points).reshape(len(limits), len(centres), len(steps)):
        middle, ahead, behind = values[:, :1], values[:, 1 : count + 1], values[:, count + 1 :]
        with np.errstate(invalid="ignore"):  # excesses are infinite beyond an undercut
            slopes, bends = (
                (ahead - behind) / (2.0 * EXCESS_STEP),
                np.abs(ahead + behind - 2.0 * middle) / EXCESS_STEP,
            )
            straight = bends.max(axis=1) <= STRAIGHT_BEND * np.abs(slopes).max(axis=1)
        yield slopes[:1] if straight[0] else slopes[straight]


def price_rates(
    free_variables: FreeVariables,
    bounds: Sequence[ActiveConstraint],
    other_derivatives: Mapping[str, FloatArray] | None = None,
) -> dict[str, PriceRates]:
    """The price of each bound, by its key, and of the numbers in ``other_derivatives`` (derivatives of each c)."""
    names, slopes = dict.fromkeys(bound.key for bound in bounds), dict(other_derivatives or {})
    larger, *other = free_variables.indices_of_disc_sizes
    goal = free_variables.independent_change_directions[larger]
    if (
        other
        and free_variables.values[larger] - free_variables.values[other[0]]
        <= ACTIVE_DISTANCE * free_variables.scales[larger]
    ):
        bounds = [
            *bounds,
            ActiveConstraint("", 0.0, "mm", "≤", free_variables.independent_change_directions[other] - goal, 0.0),
        ]  # the other disc is not the larger one
        slopes = {key: np.append(by_bound, 0.0) for key, by_bound in slopes.items()}
    slopes = {
        key: np.array([bound.bound_derivative if bound.key == key else 0.0 for bound in bounds]) for key in names
    } | slopes
    columns = np.vstack([np.empty((0, goal.size)), *(bound.gradients for bound in bounds)]).T
    lengths = np.linalg.norm(columns, axis=0)
    lengths[lengths == 0.0] = 1.0
    columns = columns / lengths
    bound_indices = np.repeat(np.arange(len(bounds)), [len(bound.gradients) for bound in bounds])
    weights, residual = _multipliers_and_residual(columns, goal)
    if residual > GRADIENT_RESIDUAL * np.linalg.norm(goal):
        return dict.fromkeys(slopes, PriceRates(nan, nan))
    error = float(residual + KINK_ERROR * np.linalg.norm(goal))
    rates = {}
    for key, by_bound in slopes.items():
        slope = by_bound[bound_indices] / lengths
        price = float(weights @ slope)
        low, high = sorted(
            (
                _least_price_within_residual(slope, columns, goal, error),
                -_least_price_within_residual(-slope, columns, goal, error),
            ),
            key=abs,
        )
        noise = error * np.abs(slope).max()
        if abs(price) <= noise and abs(high) <= FAINT_FACTOR * noise:
            rates[key] = ZERO_RATES
        else:
            is_unique = abs(high - low) <= EQUAL_PRICES * abs(high)
            rates[key] = PriceRates(price, price) if is_unique else PriceRates(low, high)
    return rates


def _multipliers_and_residual(
    constraint_gradients: FloatArray, size_gradient: FloatArray
) -> tuple[FloatArray, float]:
    """The multipliers λ ≥ 0 of least residual |∇R + Σ λ·∇c|, and this residual."""
    if not constraint_gradients.size:
        return np.zeros(0), inf
    if constraint_gradients.shape == (1, 1):  # one variable and one limit need no scipy, which is slow to import
        weights = np.maximum(-size_gradient / constraint_gradients[0], 0.0)
        return weights, float(np.abs(size_gradient + constraint_gradients[0] * weights)[0])
    weights, residual = scipy.optimize.nnls(constraint_gradients, -size_gradient)
    return weights, residual


def _least_price_within_residual(
    slopes: FloatArray, constraint_gradients: FloatArray, size_gradient: FloatArray, largest_residual: float
) -> float:
    """The least Σ λ·slope over all multipliers whose residuals are within an error; −∞ if it is unbounded."""
    if constraint_gradients.shape == (1, 1):
        middle, reach = (
            -size_gradient[0] / constraint_gradients[0, 0],
            largest_residual / abs(constraint_gradients[0, 0]),
        )
        return float(min(slopes[0] * max(middle + side * reach, 0.0) for side in (-1.0, 1.0)))
    both, most = (
        np.vstack([constraint_gradients, -constraint_gradients]),
        np.concatenate([largest_residual - size_gradient, largest_residual + size_gradient]),
    )
    answer = scipy.optimize.linprog(slopes, both, most)
    return float(answer.fun) if answer.status == 0 else -inf
