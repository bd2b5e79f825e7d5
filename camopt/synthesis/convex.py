"""The convex programme of a demand: sizes, motions of the strokes, limits and objective.

What a motion is made of is left open. ``free`` makes it of splines, whose limits hold at every cam angle: its
optimum is a cam. ``relaxation`` makes it of values at nodes that every motion has: its optimum is a bound.

The motion is in units of the highest lift and sizes in those of ``Demand.length``, so that numbers are near 1.
"""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf, pi, sqrt
from typing import Any, Protocol

import cvxpy as cp

from camopt.mistakes import Unsolved
from camopt.motion.stroke import Stroke
from camopt.motion.table import DWELL
from camopt.synthesis import residual
from camopt.synthesis.demand import ORDERS, Demand

Ranges = dict[int, list[tuple[Any, Any]]]
"""Ranges of a stroke's derivatives, by order; all of a list hold."""

SQUARES = {"acceleration_rms": 2, "jerk_rms": 3}


@dataclass(frozen=True)
class Sizes:
    """e, s₀ and the prime radius of the cam, in units of ``Demand.length``; those that oscillate have s₀ alone."""

    lead: Any
    height: Any
    prime: Any


class StrokeMotion(Protocol):
    """The motion of one stroke: its limits, and what its neighbours and the objective need of it."""

    limits: list[Any]

    def end(self, order: int, last: bool) -> Any:
        """A derivative at an end of the stroke, or None if it is not known there."""

    def at_rest(self, rest: int, last: bool) -> list[Any]:
        """What makes so many derivatives zero at an end, beside a dwell."""

    def square(self, order: int) -> Any:
        """√∫ (y⁽ᵏ⁾)² dθ over the stroke, or no more than that."""

    def left_over(self) -> Any:
        """What it adds to the vibration at the start of each dwell, mm (dwells, 2); None if that is not known."""


MakeMotion = Callable[[Demand, Stroke, Ranges, Sizes], StrokeMotion]


@dataclass
class Convex:
    """A convex programme and its parts."""

    demand: Demand
    problem: Any
    unit: float
    """What the objective is divided by in the problem, so that it is near 1."""
    sizes: Sizes
    motions: list[StrokeMotion | None]
    largest: dict[str, Any]
    """Variables that bound a derivative over the turn, in units of the lift: those that something asks for."""

    def solve(self) -> float:
        """Solve it: the objective, in the units of the demand; infinite if nothing holds all limits.

        Raises
        ------
        Unsolved
            If the solver fails.
        """
        status = solve(self.problem)
        if status in (cp.INFEASIBLE, cp.INFEASIBLE_INACCURATE):
            return inf
        if status not in SOLVED:
            raise Unsolved(f"the convex solver says {status}")
        return self.unit * float(self.problem.value)

    @property
    def goal(self) -> Any:
        """The objective over ``unit``, as an expression."""
        return self.problem.objective.args[0]

    @cached_property
    def gentle(self) -> tuple[Any, Any]:
        """The problem of the least mean square of the jerk, and the parameter that bounds ``goal`` in it."""
        most = cp.Parameter()
        jerk = cp.norm(cp.hstack([motion.square(3) for motion in self.motions if motion]))
        return cp.Problem(cp.Minimize(jerk), [*self.problem.constraints, self.goal <= most]), most

    @property
    def exact(self) -> bool:
        """Whether the solver reached its tolerance."""
        return self.problem.status in (cp.OPTIMAL, cp.INFEASIBLE)


SOLVED = (cp.OPTIMAL, cp.OPTIMAL_INACCURATE)


def solve(problem: Any) -> str:
    """Solve a problem: its status. What is inaccurate is looked at by whoever uses it."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Solution may be inaccurate")
        try:
            problem.solve(solver=cp.CLARABEL)
        except cp.SolverError:
            return str(cp.SOLVER_ERROR)
    return str(problem.status)


def convex(demand: Demand, make: MakeMotion, held: Mapping[str, Any] | None = None) -> Convex:
    """The programme of a demand with motions of one make.

    ``held`` bounds further terms of the kind that an objective has, in their units, by numbers or parameters.
    """
    held = held or {}
    sizes = Sizes(cp.Variable(), cp.Variable(nonneg=True), cp.Variable())
    names = dict.fromkeys((*demand.objective, *held, *([] if demand.residual is None else [residual.TERM])))
    largest = {name: cp.Variable(nonneg=True) for name in names if name in ORDERS}
    motions = [
        None if stroke.kind == DWELL else make(demand, stroke, _ranges(demand, number, largest), sizes)
        for number, stroke in enumerate(demand.strokes)
    ]
    terms = {name: _term(demand, name, sizes, motions, largest) for name in names}
    limits = [*_of_sizes(demand, sizes), *_joints(demand, motions)]
    limits += [limit for motion in motions if motion for limit in motion.limits]
    limits += [terms[name] <= bound for name, bound in held.items()]
    if demand.residual is not None:
        limits.append(terms[residual.TERM] / demand.residual <= 1.0)
    unit = sum(weight * _order_of(demand, name) for name, weight in demand.objective.items()) or 1.0
    goal = sum([weight / unit * terms[name] for name, weight in demand.objective.items()])
    return Convex(demand, cp.Problem(cp.Minimize(goal), limits), unit, sizes, motions, largest)


def _ranges(demand: Demand, number: int, largest: Mapping[str, Any]) -> Ranges:
    """The ranges of a stroke's derivatives in units of the lift, its own and those over the turn."""
    found: Ranges = {ORDERS[name]: [(-variable, variable)] for name, variable in largest.items()}
    for order, (low, high) in demand.ranges[number].items():
        found.setdefault(order, []).append((low / demand.scale, high / demand.scale))
    return found


def _of_sizes(demand: Demand, sizes: Sizes) -> list[Any]:
    """The intervals of the sizes, and what a dwell asks of them."""
    unit = demand.length
    limits = [sizes.lead >= demand.lead[0] / unit, sizes.lead <= demand.lead[1] / unit]
    reach = cp.norm(cp.hstack([sizes.lead, sizes.height])) if demand.traced else sizes.height
    limits += [sizes.prime >= demand.prime[0] / unit, sizes.prime >= reach]
    if demand.prime[1] < inf:
        limits.append(sizes.prime <= demand.prime[1] / unit)
    for stroke in demand.strokes:
        if stroke.kind == DWELL:
            for floor in demand.floors:
                if floor.kinds & DWELL:
                    rest = (floor.displacement * stroke.low + floor.constant) / demand.scale
                    limits.append(rest + floor.lead * sizes.lead + floor.height * sizes.height >= 0)
    return limits


def _joints(demand: Demand, motions: list[StrokeMotion | None]) -> list[Any]:
    """At rest beside a dwell; smooth where two strokes meet."""
    limits = []
    for number, motion in enumerate(motions):
        before = motions[number - 1]
        if motion and before:
            ends = [(motion.end(k, False), before.end(k, True)) for k in range(1, demand.rest + 1)]
            limits += [start == end for start, end in ends if start is not None and end is not None]
        elif motion:
            limits += motion.at_rest(demand.rest, False)
        elif before:
            limits += before.at_rest(demand.rest, True)
    return limits


def _order_of(demand: Demand, name: str) -> float:
    """What a term of the objective is of the order of, in its own unit."""
    if name == "size":
        return demand.length
    shortest = min(stroke.angle for stroke in demand.strokes if stroke.kind != DWELL)
    if name == residual.TERM:
        return demand.scale * demand.per_unit[name] / (1.0 + (demand.train[0] * shortest) ** 2)
    order = {**ORDERS, **SQUARES}[name]
    return demand.scale * demand.per_unit[name] / shortest**order


def _term(
    demand: Demand, name: str, sizes: Sizes, motions: list[StrokeMotion | None], largest: Mapping[str, Any]
) -> Any:
    """A term of the objective, in its own unit."""
    if name == "size":
        return demand.length * sizes.prime - demand.roller
    if name == residual.TERM:
        return demand.per_unit[name] * _left_over([motion.left_over() for motion in motions if motion])
    factor = demand.scale * demand.per_unit[name]
    if name in largest:
        return factor * largest[name]
    squares = [motion.square(SQUARES[name]) for motion in motions if motion]
    return factor / sqrt(2.0 * pi) * cp.norm(cp.hstack(squares))


def _left_over(parts: list[Any]) -> Any:
    """The residual vibration, mm or rad: the largest over dwells; 0 where a motion does not say what it adds."""
    if any(part is None for part in parts):
        return cp.Constant(0.0)
    return cp.max(cp.norm(sum(parts), axis=1))
