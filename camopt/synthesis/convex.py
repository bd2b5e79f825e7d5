"""The convex programme of a demand: sizes, motions of the strokes, limits and objective.

What a motion is made of is left open. ``free`` makes it of splines, whose limits hold at every cam angle: its
optimum is a cam. ``relaxation`` makes it of values at nodes that every motion has: its optimum is a bound.

The motion is in units of the highest lift and sizes in those of ``Demand.length``, so that numbers are near 1.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf, pi, sqrt
from typing import Any, NamedTuple

from camopt.mistakes import Unsolved
from camopt.motion.table import DWELL
from camopt.synthesis import residual
from camopt.synthesis.conic import INFEASIBLE, NO_SOLUTION, SOLVED, SOLVER_ENDS, ConicProgramme
from camopt.synthesis.demand import CROSSING_JERK, LOST_AREA, SQUARES, TERM_ORDERS, Demand
from camopt.synthesis.fixed_motion import FixedMotion
from camopt.synthesis.functions import ConvexFunction, LargestNorm, Linear, Magnitudes, Norm
from camopt.synthesis.means import MeanConstraint
from camopt.synthesis.rows import ConvexRows, LinearTerm, Parameter, Unknown, negated, times, value_of
from camopt.synthesis.stroke_motion import DerivativeRange, MakeMotion, Ranges, Sizes, StrokeMotion


class Epigraph(NamedTuple):
    """An unknown that is at least a function: the least objective has it just so."""

    top: Unknown
    function: ConvexFunction


@dataclass
class Convex:
    """A convex programme and its parts."""

    demand: Demand
    goal: list[LinearTerm]
    """The objective over ``unit``."""
    limits: ConvexRows
    unit: float
    """What the objective is divided by in the problem, so that it is near 1."""
    sizes: Sizes
    motions: list[StrokeMotion]
    largest: dict[str, Unknown]
    """What bounds a derivative over the turn, in units of the lift: those that something asks for."""
    epigraphs: list[Epigraph]
    """Of terms of the objective that are not linear."""

    @cached_property
    def programme(self) -> ConicProgramme:
        """The programme itself."""
        return ConicProgramme(self.goal, self.limits)

    def solve(self) -> float:
        """Solve it: the objective, in the units of the demand; infinite if nothing holds all limits.

        Raises
        ------
        Unsolved
            If the solver fails.
        """
        status = self.programme.solve()
        if status in NO_SOLUTION:
            return inf
        if status not in SOLVER_ENDS:
            raise Unsolved(failed(status))
        return self.unit * self.programme.value

    @property
    def cost(self) -> float:
        """The objective over ``unit`` at the values of the unknowns."""
        for each in self.epigraphs:
            each.top.value = each.function.value
        return float(value_of(self.goal)[0])

    @cached_property
    def gentle(self) -> tuple[ConicProgramme, Parameter]:
        """The programme of the least mean square of the jerk, and the parameter that bounds ``goal`` in it.

        Of a smooth motion it is the least variation of the jerk, from stroke to stroke as well.
        """
        most, least, more = Parameter(), Unknown(), ConvexRows()
        more.at_least((1.0, most), *negated(self.goal))
        jerk: ConvexFunction
        if self.demand.smooth:
            ends = [each.end(3, last) or [] for each in self.motions for last in (False, True)]
            joints = zip(ends[1::2], [*ends[2::2], ends[0]], strict=True)
            jumps = [[*after, *negated(before)] for before, after in joints]
            jerk = Magnitudes([*jumps, *(each for motion in self.motions for each in motion.variation())])
        else:
            jerk = Norm([each for motion in self.motions for each in motion.square(3)])
        jerk.below([(1.0, least)], more)
        return ConicProgramme([(1.0, least)], self.limits, more), most

    def enough(self, least: float) -> float:
        """An objective that is as good as the least: what a smooth motion may have."""
        return least + self.demand.smooth * abs(least)

    @property
    def exact(self) -> bool:
        """Whether the solver reached the residual asked."""
        return self.programme.status in (SOLVED, INFEASIBLE)


def failed(status: str) -> str:
    """A message of a solver's status, which is none of ``SOLVER_ENDS``."""
    words = re.sub(r"_|(?<=[a-z])(?=[A-Z])", " ", status).lower()
    return f"the convex solver found no solution (it says {words})"


SOLVER_ERROR = 1e-6  # relative, of an optimum


def convex(demand: Demand, make: MakeMotion, held: Mapping[str, Any] | None = None) -> Convex:  # noqa: C901
    """The programme of a demand with motions of one make.

    ``held`` bounds further terms of the kind that an objective has, in their units, by numbers or parameters.
    """
    held = held or {}
    sizes = Sizes(Unknown(), Unknown(), Unknown())
    names = dict.fromkeys((*demand.objective, *held, *([] if demand.residual is None else [residual.TERM])))
    largest = {name: Unknown() for name in names if name in (*TERM_ORDERS, CROSSING_JERK)}
    motions = [
        (make if stroke.is_free else FixedMotion)(demand, stroke, _ranges(demand, number, largest), sizes)
        for number, stroke in enumerate(demand.strokes)
    ]
    terms = {name: _term(demand, name, sizes, motions, largest) for name in names}
    rows = ConvexRows()
    for each in (sizes.height, *largest.values()):
        rows.at_least((1.0, each))
    _of_sizes(demand, sizes, motions, rows)
    _join(demand, motions, rows)
    for number, partner in enumerate(demand.mirror or ()):
        if number <= partner:
            motions[number].mirrors(motions[partner])
    for crossing in demand.crossings if CROSSING_JERK in largest else ():
        motions[crossing.stroke].crosses(crossing, largest[CROSSING_JERK])
        for end in demand.ranges[crossing.stroke].get(3, ()):  # with more of it there is no more allowed
            rows.at_least((-1.0, largest[CROSSING_JERK]), (abs(end) / demand.scale, 1.0))
    for one, other in demand.opposed:
        motions[one].opposes(motions[other], demand.both_starts(one, other))
    for motion in motions:
        rows.add(motion.rows)
    for name, bound in held.items():
        terms[name].below([(1.0, bound)], rows)
    if demand.residual is not None:
        terms[residual.TERM].times(1.0 / demand.residual).below([(1.0, 1.0)], rows)
    lowest = _lowest(demand, motions)
    for mean in demand.means:
        _hold_mean(mean, motions, lowest, demand.scale, rows)
    unit = sum(weight * _order_of(demand, name) for name, weight in demand.objective.items()) or 1.0
    goal, epigraphs = list[LinearTerm](), list[Epigraph]()
    for name, weight in demand.objective.items():
        term = terms[name].times(weight / unit)
        if isinstance(term, Linear):
            goal += term.terms
        else:
            top = Unknown()
            term.below([(1.0, top)], rows)
            goal.append((1.0, top))
            epigraphs.append(Epigraph(top, term))
    return Convex(demand, goal, rows, unit, sizes, motions, largest, epigraphs)


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


def _of_sizes(demand: Demand, sizes: Sizes, motions: list[StrokeMotion], rows: ConvexRows) -> None:
    """The intervals of the sizes; the size is that where the follower is lowest."""
    unit, height = demand.length, [(1.0, sizes.height)]
    height += [(weight * (demand.scale / unit), lowest) for weight, lowest in _lowest(demand, motions)]
    for size, (low, high) in ((sizes.lead, demand.lead), (sizes.prime, demand.prime)):
        rows.at_least((1.0, size), (-low / unit, 1.0))
        if high < inf:
            rows.at_least((-1.0, size), (high / unit, 1.0))
    if demand.traced:
        rows.cone([(1.0, sizes.prime)], [[(1.0, sizes.lead)], height])
    else:
        rows.at_least((1.0, sizes.prime), *negated(height))


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
    if name == LOST_AREA:
        return demand.largest_area * demand.per_unit[name]
    shortest = min(stroke.angle for stroke in demand.free)
    if name == residual.TERM:
        return demand.scale * demand.per_unit[name] / (1.0 + (demand.train[0] * shortest) ** 2)
    order = {**TERM_ORDERS, **SQUARES, CROSSING_JERK: 3}[name]
    return demand.scale * demand.per_unit[name] / shortest**order


def _term(
    demand: Demand, name: str, sizes: Sizes, motions: list[StrokeMotion], largest: Mapping[str, Unknown]
) -> ConvexFunction:
    """A term of the objective, in its own unit."""
    if name == "size":
        return Linear([(demand.length, sizes.prime), (-demand.roller, 1.0)])
    if name == residual.TERM:
        return _left_over(motions).times(demand.per_unit[name])
    factor = demand.scale * demand.per_unit[name]
    if name in largest:
        return Linear([(factor, largest[name])])
    if name == LOST_AREA:
        area = times(-factor, _area(motions, _lowest(demand, motions)))
        return Linear([(demand.largest_area * demand.per_unit[name], 1.0), *area])
    squares = [each for motion in motions for each in motion.square(SQUARES[name])]
    return Norm(squares).times(factor / sqrt(2.0 * pi))


def _left_over(motions: list[StrokeMotion]) -> ConvexFunction:
    """The residual vibration, mm or rad: the largest over dwells; 0 where a motion does not say what it adds."""
    parts = [motion.left_over() for motion in motions]
    known = [part for part in parts if part]
    if not known or any(part is None for part in parts):
        return Linear([(0.0, 1.0)])
    return LargestNorm([Norm([[term for part in dwell for term in part]]) for dwell in zip(*known, strict=True)])


def _hold_mean(
    mean: MeanConstraint, motions: list[StrokeMotion], lowest: list[LinearTerm], unit: float, rows: ConvexRows
) -> None:
    """The limit on motions in a unit; ``lowest`` is the displacement from which the area counts."""
    if mean.power == 1:
        area = Linear(_area(motions, lowest)).times(mean.side)
        area.below([(mean.side * 2.0 * pi * mean.bound / unit, 1.0)], rows)
        return
    squares = Norm([each for motion in motions for each in motion.square(mean.order)])
    squares.below([(sqrt(2.0 * pi) * mean.bound / unit, 1.0)], rows)


def _area(motions: list[StrokeMotion], lowest: list[LinearTerm]) -> list[LinearTerm]:
    """∮y dθ from the lowest displacement, in units of the lift."""
    every = [term for motion in motions for term in motion.area()]
    return [*every, *times(-2.0 * pi, lowest)]
