"""The convex programme of a demand: sizes, motions of the strokes, limits and objective.

What a motion is made of is left open. ``free`` makes it of splines, whose limits hold at every cam angle: its
optimum is a cam. ``relaxation`` makes it of values at nodes that every motion has: its optimum is a bound.

The motion is in units of the highest lift and sizes in those of ``Demand.length``, so that numbers are near 1.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf, pi, sqrt
from typing import Any

import cvxpy as cp

from camopt.core.mistakes import Unsolved
from camopt.model.motion.stroke import DWELL
from camopt.solve.synthesis import residual
from camopt.solve.synthesis.demand import CROSSING_JERK, LOST_AREA, SQUARES, TERM_ORDERS, Demand, MeanConstraint
from camopt.solve.synthesis.solver import INFEASIBLE, NO_SOLUTION, SOLVED, SOLVER_ENDS, failed, solve
from camopt.solve.synthesis.stroke_motion import (
    DerivativeRange,
    FixedMotion,
    MakeMotion,
    Ranges,
    Sizes,
    StrokeMotion,
)


@dataclass
class Convex:
    """A convex programme and its parts."""

    demand: Demand
    objective: cp.Expression
    """The objective over ``unit``."""
    constraints: list[cp.Constraint]
    unit: float
    """What the objective is divided by in the problem, so that it is near 1."""
    sizes: Sizes
    motions: list[StrokeMotion]
    largest: dict[str, cp.Variable]
    """What bounds a derivative over the turn, in units of the lift: those that something asks for."""

    @cached_property
    def programme(self) -> cp.Problem:
        """The programme itself."""
        return cp.Problem(cp.Minimize(self.objective), self.constraints)

    def solve(self) -> float:
        """Solve it: the objective, in the units of the demand; infinite if nothing holds all limits.

        Raises
        ------
        Unsolved
            If the solver fails.
        """
        status = solve(self.programme)
        if status in NO_SOLUTION:
            return inf
        if status not in SOLVER_ENDS:
            raise Unsolved(failed(status))
        return self.unit * float(self.programme.value)

    @cached_property
    def gentle(self) -> tuple[cp.Problem, cp.Parameter]:
        """The programme of the least mean square of the jerk, and the parameter that bounds the objective in it.

        Of a smooth motion it is the least variation of the jerk, from stroke to stroke as well.
        """
        most = cp.Parameter()
        if self.demand.smooth:
            ends = [each.end(3, last) for each in self.motions for last in (False, True)]
            joints = zip(ends[1::2], [*ends[2::2], ends[0]], strict=True)
            jumps = [after - before for before, after in joints]
            jerk = cp.norm1(cp.hstack([*jumps, *(each for motion in self.motions for each in motion.variation())]))
        else:
            jerk = _root_of_squares(self.motions, 3)
        return cp.Problem(cp.Minimize(jerk), [*self.constraints, self.objective <= most]), most

    def enough(self, least: float) -> float:
        """An objective that is as good as the least: what a smooth motion may have."""
        return least + self.demand.smooth * abs(least)

    @property
    def exact(self) -> bool:
        """Whether the solver reached the residual asked."""
        return self.programme.status in (SOLVED, INFEASIBLE)


def convex(demand: Demand, make: MakeMotion, held: Mapping[str, Any] | None = None) -> Convex:
    """The programme of a demand with motions of one make.

    ``held`` bounds further terms of the kind that an objective has, in their units, by numbers or parameters.
    """
    held = held or {}
    sizes = Sizes(cp.Variable(), cp.Variable(), cp.Variable())
    names = dict.fromkeys((*demand.objective, *held, *([] if demand.residual is None else [residual.TERM])))
    largest = {name: cp.Variable() for name in names if name in (*TERM_ORDERS, CROSSING_JERK)}
    motions = [
        (make if stroke.is_free else FixedMotion)(demand, stroke, _ranges(demand, number, largest), sizes)
        for number, stroke in enumerate(demand.strokes)
    ]
    lowest = _lowest(demand, motions)
    terms = {name: _term(demand, name, sizes, motions, lowest, largest) for name in names}
    constraints = [each >= 0.0 for each in (sizes.height, *largest.values())]
    constraints += _of_sizes(demand, sizes, lowest) + _joints(demand, motions)
    for number, partner in enumerate(demand.mirror or ()):
        if number <= partner:
            motions[number].mirrors(motions[partner])
    for crossing in demand.crossings if CROSSING_JERK in largest else ():
        motions[crossing.stroke].crosses(crossing, largest[CROSSING_JERK])
        for end in demand.ranges[crossing.stroke].get(3, ()):  # with more of it there is no more allowed
            constraints.append(largest[CROSSING_JERK] <= abs(end) / demand.scale)
    for one, other in demand.opposed:
        motions[one].opposes(motions[other], demand.both_starts(one, other))
    for motion in motions:
        constraints += motion.constraints
    constraints += [terms[name] <= bound for name, bound in held.items()]
    if demand.residual is not None:
        constraints.append(terms[residual.TERM] / demand.residual <= 1.0)
    constraints += [_held_mean(mean, motions, lowest, demand.scale) for mean in demand.means]
    unit = sum(weight * _order_of(demand, name) for name, weight in demand.objective.items()) or 1.0
    objective = sum((w / unit * terms[name] for name, w in demand.objective.items()), start=cp.Constant(0.0))
    return Convex(demand, objective, constraints, unit, sizes, motions, largest)


def _ranges(demand: Demand, number: int, largest: Mapping[str, Any]) -> Ranges:
    """The ranges of a stroke's derivatives in units of the lift, its own and those over the turn."""
    found: Ranges = {
        TERM_ORDERS[name]: [DerivativeRange(-1.0, 1.0, variable)]
        for name, variable in largest.items()
        if name != CROSSING_JERK
    }
    for order, (low, high) in demand.ranges[number].items():
        found.setdefault(order, []).append(DerivativeRange(low / demand.scale, high / demand.scale))
    return found


def _of_sizes(demand: Demand, sizes: Sizes, lowest: Any) -> list[cp.Constraint]:
    """The intervals of the sizes; the size is that where the follower is lowest."""
    unit = demand.length
    height = sizes.height + demand.scale / unit * lowest
    found = [cp.norm(cp.hstack([sizes.lead, height])) <= sizes.prime if demand.traced else sizes.prime >= height]
    for size, (low, high) in ((sizes.lead, demand.lead), (sizes.prime, demand.prime)):
        found += DerivativeRange(low / unit, high / unit).constraints(size)
    return found


def _lowest(demand: Demand, motions: list[StrokeMotion]) -> Any:
    """The displacement where the follower is lowest, if no position that is given need be."""
    if demand.dip is None:
        return 0.0
    number, x = demand.place(demand.dip)
    return motions[number].lowest(x)


def _joints(demand: Demand, motions: list[StrokeMotion]) -> list[cp.Constraint]:
    """What holds where two strokes meet: rest beside a dwell, or else a motion as smooth as the demand says."""
    found = []
    for number, motion in enumerate(motions):
        before, stroke, last = motions[number - 1], demand.strokes[number], demand.strokes[number - 1]
        if not (stroke.is_free or last.is_free):
            continue
        if DWELL in (stroke.kind, last.kind):
            motion.rests(demand.rest, False)
            before.rests(demand.rest, True)
            smooth = 0
        else:
            smooth = demand.continuity_at(last.end)
        for order in range(0 if stroke.is_move or last.is_move else 1, smooth + 1):
            end, start = before.end(order, True), motion.end(order, False)
            if end is not None and start is not None:
                found.append(end == start)
    return found


def _order_of(demand: Demand, name: str) -> float:
    """What a term of the objective is of the order of, in its own unit."""
    if name == "size":
        return demand.length
    if name == LOST_AREA:
        return demand.largest_area * demand.per_unit[name]
    shortest = min(stroke.angle for stroke in demand.free)
    if name == residual.TERM:
        return demand.scale * demand.per_unit[name] / (1.0 + (demand.train[0] * shortest) ** 2)
    order = {**TERM_ORDERS, **SQUARES, CROSSING_JERK: 3}[name]
    return demand.scale * demand.per_unit[name] / shortest**order


def _term(
    demand: Demand,
    name: str,
    sizes: Sizes,
    motions: list[StrokeMotion],
    lowest: Any,
    largest: Mapping[str, cp.Variable],
) -> cp.Expression:
    """A term of the objective, in its own unit."""
    if name == "size":
        return demand.length * sizes.prime - demand.roller
    if name == residual.TERM:
        return demand.per_unit[name] * _left_over(motions)
    factor = demand.scale * demand.per_unit[name]
    if name in largest:
        return factor * largest[name]
    if name == LOST_AREA:
        return demand.largest_area * demand.per_unit[name] - factor * _area(motions, lowest)
    return factor / sqrt(2.0 * pi) * _root_of_squares(motions, SQUARES[name])


def _root_of_squares(motions: list[StrokeMotion], order: int) -> cp.Expression:
    """√∮(y⁽ᵏ⁾)² dθ, or no more than that."""
    return cp.norm(cp.hstack([each for motion in motions for each in motion.square(order)]))


def _left_over(motions: list[StrokeMotion]) -> cp.Expression:
    """The residual vibration, mm or rad: the largest over dwells; 0 where a motion does not say what it adds."""
    parts = [motion.left_over() for motion in motions]
    known = [part for part in parts if part]
    if not known or any(part is None for part in parts):
        return cp.Constant(0.0)
    return cp.max(cp.hstack([cp.norm(sum(dwell)) for dwell in zip(*known, strict=True)]))


def _held_mean(mean: MeanConstraint, motions: list[StrokeMotion], lowest: Any, unit: float) -> cp.Constraint:
    """The limit on motions in a unit; ``lowest`` is the displacement from which the area counts."""
    if mean.power == 1:
        return mean.side * _area(motions, lowest) <= mean.side * 2.0 * pi * mean.bound / unit
    return _root_of_squares(motions, mean.order) <= sqrt(2.0 * pi) * mean.bound / unit


def _area(motions: list[StrokeMotion], lowest: Any) -> Any:
    """∮y dθ from the lowest displacement, in units of the lift."""
    return sum(motion.area() for motion in motions) - 2.0 * pi * lowest
