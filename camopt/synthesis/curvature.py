"""Curvature of a traced profile, which is not convex in the motion: a sequence of convex steps.

With a = s₀ + y, b = y' − e, N² = a² + b² and κ ≤ κ_max the limit on the pitch curve is

    G = (κ_max·N³ − N² − b·y' + a·y'') / N² ≥ 0

Each step holds G's tangent plane within a trust region around the last motion, with a price on what is missing,
and is taken where the priced objective truly falls. It ends at a local optimum; the optimum without this limit
bounds it from below.

Source: Fletcher, Practical Methods of Optimization, ch. 14 (exact penalty, trust region).
"""

from typing import Any, NamedTuple

import cvxpy as cp
import numpy as np

from camopt.motion.table import DWELL
from camopt.numerics import FloatArray
from camopt.synthesis.convex import SOLVED, Convex, solve
from camopt.synthesis.demand import ORDERS, Demand
from camopt.synthesis.free import FreeMotion

EACH = 6  # samples of a piece
PRICE = 100.0  # of a G below zero by 1, in units of the objective
STEPS, FIRST_REACH, LAST_REACH = 60, 0.1, 1e-6
ENOUGH = 1e-7  # a fall of the priced objective, relative, that is worth another step


class Iterate(NamedTuple):
    """A solution: e and s₀ in units of the lift, and the coefficients of each moving stroke."""

    lead: float
    height: float
    coefficients: tuple[FloatArray, ...]


def moving(model: Convex) -> list[FreeMotion]:
    """The free motions of a programme."""
    return [motion for motion in model.motions if isinstance(motion, FreeMotion)]


def iterate_of(model: Convex) -> Iterate:
    """The values of a solved programme."""
    sizes = float(model.sizes.lead.value), float(model.sizes.height.value)
    return Iterate(*sizes, joined(model.demand, [motion.coefficients.value for motion in moving(model)]))


def joined(demand: Demand, coefficients: list[FloatArray]) -> tuple[FloatArray, ...]:
    """Coefficients without a solver's error: at rest beside a dwell, smooth where two strokes meet, monotone.

    However small, an error there would be a jump of the acceleration, or a motion that turns back.
    """
    strokes = [stroke for stroke in demand.strokes if stroke.kind != DWELL]
    found: list[FloatArray] = [np.asarray(np.clip(each, 0.0, 1.0)) for each in coefficients]
    if demand.monotone:
        found = [np.maximum.accumulate(each) for each in found]
    turns = [stroke.kind != strokes[number - 1].kind for number, stroke in enumerate(strokes)]
    for number, (stroke, own) in enumerate(zip(strokes, found, strict=True)):
        first, last = (1 + demand.rest * beside for beside in demand.beside_dwells(stroke))
        own[:first], own[-last:] = 0.0, 1.0
        if turns[number]:  # no velocity: the motion does not leave the stroke
            own[1], found[number - 1][-2] = 0.0, 1.0
    for number, (stroke, own) in enumerate(zip(strokes, found, strict=True)):
        if demand.beside_dwells(stroke)[0]:
            continue
        before = strokes[number - 1]
        for order in range(2 if turns[number] else 1, demand.rest + 1):
            start, end = (demand.splines.at(np.array([x]), order).toarray()[0] for x in (0.0, 1.0))
            per, per_before = ((s.high - s.low) / s.angle**order for s in (stroke, before))
            wanted = per_before / per * (end @ found[number - 1])
            own[order] = (wanted - start[:order] @ own[:order]) / start[order]
    return tuple(found)


def sharpest_allowed(demand: Demand) -> float | None:
    """κ_max of the pitch curve in units of the lift; None if nothing limits it."""
    radii = [lim.bound for lim in demand.question.limits if lim.name in ("curvature_radius", "undercut")]
    return demand.scale / (demand.roller + max(radii)) if demand.traced and radii else None


def steps(model: Convex, start: Iterate, sharpest: float) -> Iterate:
    """The local optimum that convex steps reach from a start."""
    last, reach = start, FIRST_REACH
    price = _priced(model, last, sharpest)
    for _ in range(STEPS):
        if reach < LAST_REACH or solve(_step(model, last, sharpest, reach)) not in SOLVED:
            break
        tried = iterate_of(model)
        cost = _priced(model, tried, sharpest)
        if cost < price:
            small = price - cost < ENOUGH * abs(price)
            last, price, reach = tried, cost, 2.0 * reach
            if small:
                break
        else:
            reach /= 4.0
    return last


def _priced(model: Convex, at: Iterate, sharpest: float) -> float:
    """The objective at a solution, with the price of the curvature that it lacks."""
    missing = 0.0
    model.sizes.lead.value, model.sizes.height.value = at.lead, at.height
    for motion, coefficients in zip(moving(model), at.coefficients, strict=True):
        motion.coefficients.value = coefficients
        value, _ = _limit(model, motion, at, sharpest)
        missing = max(missing, -float(value.min()))
    model.sizes.prime.value = max(np.hypot(at.lead, at.height), model.demand.prime[0] / model.demand.scale)
    for name, variable in model.largest.items():
        variable.value = max(float(np.abs(motion.samples(ORDERS[name])).max()) for motion in moving(model))
    return float(model.goal.value) + PRICE * missing


def _limit(model: Convex, motion: FreeMotion, at: Iterate, sharpest: float) -> tuple[FloatArray, Any]:
    """G at samples of a stroke, and its tangent plane as an expression, at a solution set in the variables."""
    rows = motion.at((np.arange(model.demand.splines.pieces * EACH) + 0.5) / (model.demand.splines.pieces * EACH))
    y, y1, y2 = (np.asarray(row.value) for row in rows)
    a, b = at.height + y, y1 - at.lead
    n = np.hypot(a, b)
    value = sharpest * n - 1.0 + (a * y2 - b * y1) / n**2
    fall = 2.0 * (a * y2 - b * y1) / n**4
    by_a, by_b = sharpest * a / n + y2 / n**2 - fall * a, sharpest * b / n - y1 / n**2 - fall * b
    plane = (
        value
        + cp.multiply(by_a, model.sizes.height - at.height + rows[0] - y)
        + cp.multiply(by_b - b / n**2, rows[1] - y1)
        - cp.multiply(by_b, model.sizes.lead - at.lead)
        + cp.multiply(a / n**2, rows[2] - y2)
    )
    return value, plane


def _step(model: Convex, last: Iterate, sharpest: float, reach: float) -> Any:
    """The convex problem of one step."""
    missing = cp.Variable(nonneg=True)
    limits = [cp.abs(model.sizes.lead - last.lead) <= reach, cp.abs(model.sizes.height - last.height) <= reach]
    for motion, coefficients in zip(moving(model), last.coefficients, strict=True):
        motion.coefficients.value = coefficients
        limits.append(cp.abs(motion.coefficients - coefficients) <= reach)
        limits.append(_limit(model, motion, last, sharpest)[1] + missing >= 0)
    return cp.Problem(cp.Minimize(model.goal + PRICE * missing), [*model.problem.constraints, *limits])
