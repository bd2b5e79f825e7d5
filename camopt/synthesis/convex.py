"""The convex programme of a demand: sizes, motions of the strokes, limits and objective.

What a motion is made of is left open. ``free`` makes it of splines, whose limits hold at every cam angle: its
optimum is a cam. ``relaxation`` makes it of values at nodes that every motion has: its optimum is a bound.

The motion is in units of the highest lift and sizes in those of ``Demand.length``, so that numbers are near 1.
"""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf, pi, sqrt
from typing import Any

from camopt.mistakes import Unsolved
from camopt.motion.table import DWELL
from camopt.synthesis import residual
from camopt.synthesis.demand import SQUARES, TERM_ORDERS, Demand
from camopt.synthesis.fixed_motion import FixedMotion
from camopt.synthesis.means import MeanConstraint
from camopt.synthesis.modelling import cp
from camopt.synthesis.rows import ConvexRows, LinearTerm, negated, stacked
from camopt.synthesis.stroke_motion import DerivativeRange, MakeMotion, Ranges, Sizes, StrokeMotion


@dataclass
class Convex:
    """A convex programme and its parts."""

    demand: Demand
    problem: Any
    unit: float
    """What the objective is divided by in the problem, so that it is near 1."""
    sizes: Sizes
    motions: list[StrokeMotion]
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
        if status not in SOLVER_ENDS:
            raise Unsolved(failed(status))
        return self.unit * float(self.problem.value)

    @property
    def goal(self) -> Any:
        """The objective over ``unit``, as an expression."""
        return self.problem.objective.args[0]

    @cached_property
    def gentle(self) -> tuple[Any, Any]:
        """The problem of the least mean square of the jerk, and the parameter that bounds ``goal`` in it.

        Of a smooth motion it is the least variation of the jerk, from stroke to stroke as well.
        """
        most = cp.Parameter()
        if self.demand.smooth:
            ends = [each.end(3, last) or [] for each in self.motions for last in (False, True)]
            joints = zip(ends[1::2], [*ends[2::2], ends[0]], strict=True)
            jumps = cp.norm1(stacked([[*after, *negated(before)] for before, after in joints]))
            jerk = jumps + sum(motion.variation() for motion in self.motions)
        else:
            jerk = cp.norm(cp.hstack([motion.square(3) for motion in self.motions]))
        return cp.Problem(cp.Minimize(jerk), [*self.problem.constraints, self.goal <= most]), most

    def enough(self, least: float) -> float:
        """An objective that is as good as the least: what a smooth motion may have."""
        return least + self.demand.smooth * abs(least)

    @property
    def exact(self) -> bool:
        """Whether the solver reached its tolerance."""
        return self.problem.status in (cp.OPTIMAL, cp.INFEASIBLE)


def failed(status: str) -> str:
    """A message of a solver's status, which is none of ``SOLVER_ENDS``."""
    return f"the convex solver found no solution (it says {status.replace('_', ' ')})"


SOLVER_ENDS = (cp.OPTIMAL, cp.OPTIMAL_INACCURATE)
SOLVER_ERROR = 1e-6  # relative, of an optimum


def solve(problem: Any) -> str:
    """Solve a problem: its status. What is inaccurate is looked at by whoever uses it."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Solution may be inaccurate")
        try:
            problem.solve(solver=cp.CLARABEL, warm_start=False)  # or digits depend on what was solved before
        except cp.SolverError:
            return str(cp.SOLVER_ERROR)
    return str(problem.status)


def convex(demand: Demand, make: MakeMotion, held: Mapping[str, Any] | None = None) -> Convex:
    """The programme of a demand with motions of one make.

    ``held`` bounds further terms of the kind that an objective has, in their units, by numbers or parameters.
    """
    held = held or {}
    sizes = Sizes(cp.Variable(), cp.Variable(), cp.Variable())
    names = dict.fromkeys((*demand.objective, *held, *([] if demand.residual is None else [residual.TERM])))
    largest = {name: cp.Variable() for name in names if name in TERM_ORDERS}
    motions = [
        (make if stroke.is_free else FixedMotion)(demand, stroke, _ranges(demand, number, largest), sizes)
        for number, stroke in enumerate(demand.strokes)
    ]
    terms = {name: _term(demand, name, sizes, motions, largest) for name in names}
    rows = ConvexRows()
    for each in (sizes.height, *largest.values()):  # as attributes they take cvxpy longer
        rows.at_least((1.0, each))
    reach = _of_sizes(demand, sizes, motions, rows)
    _join(demand, motions, rows)
    for number, partner in enumerate(demand.mirror or ()):
        if number <= partner:
            motions[number].mirrors(motions[partner])
    for motion in motions:
        rows.add(motion.rows)
    limits = [*rows.limits, *reach, *(terms[name] <= bound for name, bound in held.items())]
    if demand.residual is not None:
        limits.append(terms[residual.TERM] / demand.residual <= 1.0)
    lowest = _lowest(demand, motions)
    limits += [_on_mean(mean, motions, lowest, demand.scale) for mean in demand.means]
    unit = sum(weight * _order_of(demand, name) for name, weight in demand.objective.items()) or 1.0
    goal = sum([weight / unit * terms[name] for name, weight in demand.objective.items()])
    return Convex(demand, cp.Problem(cp.Minimize(goal), limits), unit, sizes, motions, largest)


def _ranges(demand: Demand, number: int, largest: Mapping[str, Any]) -> Ranges:
    """The ranges of a stroke's derivatives in units of the lift, its own and those over the turn."""
    found: Ranges = {
        TERM_ORDERS[name]: [DerivativeRange(-1.0, 1.0, variable)] for name, variable in largest.items()
    }
    for order, (low, high) in demand.ranges[number].items():
        found.setdefault(order, []).append(DerivativeRange(low / demand.scale, high / demand.scale))
    return found


def _of_sizes(demand: Demand, sizes: Sizes, motions: list[StrokeMotion], rows: ConvexRows) -> list[Any]:
    """The intervals of the sizes, but for what is no row; the size is that where the follower is lowest."""
    unit, height = demand.length, [(1.0, sizes.height)]
    height += [(weight * (demand.scale / unit), lowest) for weight, lowest in _lowest(demand, motions)]
    for size, (low, high) in ((sizes.lead, demand.lead), (sizes.prime, demand.prime)):
        rows.at_least((1.0, size), (-low / unit, 1.0))
        if high < inf:
            rows.at_least((-1.0, size), (high / unit, 1.0))
    if not demand.traced:
        rows.at_least((1.0, sizes.prime), *negated(height))
        return []
    return [sizes.prime >= cp.norm(stacked([[(1.0, sizes.lead)], height]))]


def _lowest(demand: Demand, motions: list[StrokeMotion]) -> list[LinearTerm]:
    """The displacement where the follower is lowest, if no position that is given need be."""
    if demand.dip is None:
        return []
    number, x = demand.place(demand.dip)
    return motions[number].lowest(x)


def _join(demand: Demand, motions: list[StrokeMotion], rows: ConvexRows) -> None:
    """Hold together where two strokes meet: at rest beside a dwell, or else as smooth as the demand says."""
    for number, motion in enumerate(motions):
        before, stroke, last = motions[number - 1], demand.strokes[number], demand.strokes[number - 1]
        if not (stroke.is_free or last.is_free):
            continue
        if stroke.is_move or last.is_move:
            _equal(before, motion, 0, rows)
        if DWELL in (stroke.kind, last.kind):
            motion.rests(demand.rest, False)
            before.rests(demand.rest, True)
            continue
        for order in range(1, demand.continuity_at(last.end) + 1):
            _equal(before, motion, order, rows)


def _equal(before: StrokeMotion, after: StrokeMotion, order: int, rows: ConvexRows) -> None:
    """Of two motions that meet, a derivative that goes on, if it is known."""
    end, start = before.end(order, True), after.end(order, False)
    if end is not None and start is not None:
        rows.zero(*end, *negated(start))


def _order_of(demand: Demand, name: str) -> float:
    """What a term of the objective is of the order of, in its own unit."""
    if name == "size":
        return demand.length
    shortest = min(stroke.angle for stroke in demand.free)
    if name == residual.TERM:
        return demand.scale * demand.per_unit[name] / (1.0 + (demand.train[0] * shortest) ** 2)
    order = {**TERM_ORDERS, **SQUARES}[name]
    return demand.scale * demand.per_unit[name] / shortest**order


def _term(demand: Demand, name: str, sizes: Sizes, motions: list[StrokeMotion], largest: Mapping[str, Any]) -> Any:
    """A term of the objective, in its own unit."""
    if name == "size":
        return demand.length * sizes.prime - demand.roller
    if name == residual.TERM:
        return demand.per_unit[name] * _left_over([motion.left_over() for motion in motions])
    factor = demand.scale * demand.per_unit[name]
    if name in largest:
        return factor * largest[name]
    squares = [motion.square(SQUARES[name]) for motion in motions]
    return factor / sqrt(2.0 * pi) * cp.norm(cp.hstack(squares))


def _left_over(parts: list[Any]) -> Any:
    """The residual vibration, mm or rad: the largest over dwells; 0 where a motion does not say what it adds."""
    if any(part is None for part in parts):
        return cp.Constant(0.0)
    return cp.max(cp.norm(sum(parts), axis=1))


def _on_mean(mean: MeanConstraint, motions: list[StrokeMotion], lowest: list[LinearTerm], unit: float) -> Any:
    """The limit on motions in a unit; ``lowest`` is the displacement from which the area counts."""
    if mean.power == 1:
        return mean.side * _area(motions, lowest) <= mean.side * 2.0 * pi * mean.bound / unit
    squares = cp.norm(cp.hstack([motion.square(mean.order) for motion in motions]))
    return squares <= sqrt(2.0 * pi) * mean.bound / unit


def _area(motions: list[StrokeMotion], lowest: list[LinearTerm]) -> Any:
    """∮y dθ from the lowest displacement, in units of the lift."""
    every = [term for motion in motions for term in motion.area()]
    return cp.sum(stacked([[*every, *((2.0 * pi * weight, each) for weight, each in negated(lowest))]]))
