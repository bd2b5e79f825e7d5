"""Ceilings that are not convex in the motion, by a sequence of convex steps.

Each step holds the tangent planes of the curves (``ceilings``) within a trust region around the last motion, with a
price on what is above its bound, and is taken where the priced objective truly falls. Curves that are minimised are
held below a level, which the objective has. It ends at a local optimum; the optimum without the ceilings bounds it
from below.

Source: Fletcher, Practical Methods of Optimization, ch. 14 (exact penalty, trust region).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camopt.numerics import LARGEST_MAGNITUDE, FloatArray
from camopt.problem.claims import Claim, Plain
from camopt.problem.problem import Problem
from camopt.problem.zones import Off
from camopt.synthesis.ceilings import Sampled, samples
from camopt.synthesis.conic import SOLVER_ENDS, ConicProgramme
from camopt.synthesis.convex import Convex
from camopt.synthesis.demand import CROSSING_JERK, TERM_ORDERS
from camopt.synthesis.iterate import Iterate, iterate_of, moving, sampled_motions
from camopt.synthesis.rows import (
    AffineRows,
    ConvexRows,
    LinearSum,
    Parameter,
    Unknown,
    negated,
    stacked,
    times,
    value_of,
)
from camopt.synthesis.spline_motion import SplineMotion

PRICES = 100.0, 1e4  # of a curve that is above its bound by all of it, in units of the objective: if one is too low
MOST_CONVEX_STEPS, FIRST_REACH = 60, 0.1
GOOD, POOR = 0.75, 0.25  # of what planes promise: if more comes true, steps go further; if less, less far
LEAST_FALL = 5e-5  # a fall of the priced objective, relative, that is worth a step
LEAST_MULTIPLIER = 1e-3  # of a multiplier of the reach: what a solver's error makes of none
HELD_CLOSER = 2e-4  # by which bounds are held closer than asked: between samples a curve rises a little more


@dataclass
class StrokePlanes:
    """The tangent planes of all curves over one stroke, curve by curve."""

    sampled: Sampled
    moves: list[LinearSum]
    """y to y''' at the samples of all curves, in units of the lift; e and s₀."""
    values: list[AffineRows]
    """The first four of these at the samples of one curve."""
    lowered: NDArray[np.bool_]
    """Which curves are minimised."""
    size: int
    """How many samples a curve has."""
    count: int
    """How many ceilings it has, the first ones."""
    below: ConvexRows = field(default_factory=ConvexRows)
    """Every plane below its bound, or below the level."""

    def state(self, unit: float) -> FloatArray:
        """y to y''' at the samples of one curve, mm, of coefficients set in the variables."""
        return unit * np.array([each.value for each in self.values])


class SequentialConvex:
    """The convex steps of a programme under ceilings.

    ``held`` ceilings stay below their bounds, and so do those of all cams that have to hold limits with this one;
    ``lowered`` ones are minimised, beside the objective of the model. What is given to its methods are the same
    ceilings with other bounds.
    """

    def __init__(self, model: Convex, held: Sequence[Claim], lowered: Sequence[Claim] = ()) -> None:
        self.model, self.count = model, len(held)
        self.missing, self.level = Unknown(), Unknown()
        self.reach, self.price = Parameter(), PRICES[0]
        self.places = [model.sizes.lead, model.sizes.height, *(m.coefficients for m in moving(model))]
        self.last = [Parameter(each.count if each.is_vector else None) for each in self.places]
        self.blocks = list(self._blocks(model.demand.problem, {}, [*held, *lowered]))
        for problem, off in model.demand.problem.others:
            self.blocks += self._blocks(problem, off, held)
        self.within_reach, self.above_0 = ConvexRows(), ConvexRows()
        away = [[(_one(u), u), (-_one(u), was)] for u, was in zip(self.places, self.last, strict=True)]
        for each in away:
            self.within_reach.at_least((1.0, self.reach), *each)
            self.within_reach.at_least((1.0, self.reach), *negated(each))
        for unknown in (self.missing, self.level) if lowered else (self.missing,):
            self.above_0.at_least((1.0, unknown))
        self.goal = [*model.goal, (1.0, self.level)] if lowered else model.goal
        self.nearest = ConicProgramme([], model.limits, squares=away)

    def _blocks(self, problem: Problem, off: Off, ceilings: Sequence[Claim]) -> Iterator[StrokePlanes]:
        """A block for each stroke on which a curve of a cam counts."""
        for stroke, motion in zip(self.model.demand.strokes, sampled_motions(self.model), strict=True):
            sampled = Sampled(self.model.demand, stroke, problem, off)
            sides = [1 + (c.goal == LARGEST_MAGNITUDE) for c in ceilings if sampled.counts(c)]
            lowered = [n >= self.count for n, c in enumerate(ceilings) if sampled.counts(c)]
            if sides:
                x = samples(self.model.demand, stroke)
                sizes = [[(1.0, size)] for size in (self.model.sizes.lead, self.model.sizes.height)]
                moves = [*motion.at(np.tile(x, sum(sides))), *sizes]
                values = [stacked([each]) for each in motion.at(x)]
                yield StrokePlanes(sampled, moves, values, np.repeat(lowered, sides), x.size, len(ceilings))

    def _step(self) -> ConicProgramme:
        """The programme of a step, with the planes of the last look."""
        rows = (self.model.limits, self.above_0, self.within_reach, *(block.below for block in self.blocks))
        return ConicProgramme([*self.goal, (self.price, self.missing)], *rows)

    def run(self, start: Iterate, held: Sequence[Claim], lowered: Sequence[Claim] = ()) -> Iterate:
        """The local optimum that convex steps reach from the motion nearest to a start within the convex limits."""
        self._set(start)
        last = iterate_of(self.model) if self.nearest.solve() in SOLVER_ENDS else start
        lowered = _scaled(lowered, self._levels(last, held, lowered)[1])
        reach = FIRST_REACH
        for self.price in PRICES:
            last, reach, enough = self._descended(last, reach, held, lowered)
            if enough:
                break
        self.price = PRICES[0]
        return last

    def _descended(
        self, last: Iterate, reach: float, held: Sequence[Claim], lowered: Sequence[Claim]
    ) -> tuple[Iterate, float, bool]:
        """Where steps end at one price, their reach there, and whether the price is high enough.

        It is too low where the steps end above a bound, or would leave bounds that the last motion holds.
        """
        cost, top = self._priced(last, held, lowered)
        if cost == inf:
            return last, reach, False
        self._look(last, held, lowered)
        for _ in range(MOST_CONVEX_STEPS):
            self.reach.value, step = reach, self._step()
            if step.solve() not in SOLVER_ENDS:
                break
            promise = cost - step.value
            if promise < LEAST_FALL * abs(cost):  # even the planes promise no more
                break
            if top <= 1.0 and self.missing.value > HELD_CLOSER and self.price < PRICES[-1]:
                return last, reach, False
            tried = iterate_of(self.model)
            found, above = self._priced(tried, held, lowered)
            gained = (cost - found) / promise
            reach *= 2.0 if gained > GOOD else 1.0 if gained > POOR else 0.25
            if gained > 0.0:
                last, cost, top = tried, found, above
                self._look(last, held, lowered)
            else:
                self._set(last)
        return last, max(reach, FIRST_REACH), top <= 1.0

    def multipliers(self, at: Iterate, held: Sequence[Claim]) -> list[FloatArray] | None:
        """The multipliers of all curves at a local optimum, block by block; the model's are in its limits.

        None if a step would go on as far as it may, or above a bound.
        """
        self._look(at, held, ())
        self.reach.value, self.price = FIRST_REACH, PRICES[-1]
        status, self.price = self._step().solve(), PRICES[0]
        if status not in SOLVER_ENDS or self.missing.value > HELD_CLOSER:
            return None
        pull = float(np.max(-self.within_reach.multipliers))
        return [-block.below.multipliers for block in self.blocks] if pull < LEAST_MULTIPLIER else None

    def curves(self, at: Iterate, held: Sequence[Claim]) -> list[FloatArray]:
        """All curves over their bounds at a solution, block by block."""
        self._set(at)
        scale = self.model.demand.scale
        return [block.sampled.values(held, block.state(scale), self._sizes(at)).ravel() for block in self.blocks]

    def ranked(
        self, starts: Sequence[Iterate], held: Sequence[Claim], lowered: Sequence[Claim] = ()
    ) -> list[Iterate]:
        """Starts by their priced objective, with the price of convex limits that they break."""
        lowered = _scaled(lowered, self._levels(starts[0], held, lowered)[1])

        def price(start: Iterate) -> float:
            cost, _ = self._priced(start, held, lowered)
            return cost + PRICES[0] * self.model.limits.broken_by

        return sorted(starts, key=price)

    def _set(self, at: Iterate) -> None:
        """A solution in the variables, and in the parameter that a step starts from."""
        self.model.sizes.lead.value, self.model.sizes.height.value = at.lead, at.height
        for motion, values in zip(moving(self.model), at.coefficients, strict=True):
            motion.coefficients.value = values
        for was, unknown in zip(self.last, self.places, strict=True):
            was.value = unknown.value

    def _look(self, at: Iterate, held: Sequence[Claim], lowered: Sequence[Claim]) -> None:
        """The planes at a solution."""
        self._set(at)
        ceilings, scale = [*held, *lowered], self.model.demand.scale
        for block in self.blocks:
            planes = block.sampled.planes(ceilings[: block.count], block.state(scale), self._sizes(at))
            slopes = (*planes.motion, planes.lead, planes.height)
            rise = [
                term for slope, move in zip(slopes, block.moves, strict=True) for term in times(slope.ravel(), move)
            ]
            constant = planes.values.ravel() - value_of(rise)
            minimised = np.repeat(block.lowered, block.size).astype(float)
            bound = [(1.0 - minimised, self.missing), ((1.0 - minimised) * (1.0 - HELD_CLOSER) - constant, 1.0)]
            bound += [(minimised, self.level)] if any(block.lowered) else []
            block.below = ConvexRows()
            block.below.at_least(*bound, *negated(rise))

    def _sizes(self, at: Iterate) -> tuple[float, float]:
        """e and s₀, mm."""
        length = self.model.demand.length
        return length * at.lead, length * at.height

    def _levels(self, at: Iterate, held: Sequence[Claim], lowered: Sequence[Claim]) -> tuple[float, float]:
        """The largest of the curves over their bounds: of those held, and of those minimised."""
        self._set(at)
        scale, tops = self.model.demand.scale, ([0.0], [0.0])
        for block in self.blocks:
            values = block.sampled.values([*held, *lowered][: block.count], block.state(scale), self._sizes(at))
            for row, which in zip(values, block.lowered, strict=True):
                tops[int(which)].append(float(row.max()))
        return max(tops[0]), max(tops[1])

    def _largest(self, term: str) -> float:
        """The largest of a derivative over the turn, or of the jerk where the force turns round."""
        motions = self.model.motions
        if term == CROSSING_JERK:
            turning = [(motions[each.stroke], each) for each in self.model.demand.crossings]
            return max(motion.turning_jerk(each) for motion, each in turning if isinstance(motion, SplineMotion))
        return float(max(np.abs(each.samples(TERM_ORDERS[term])).max() for each in sampled_motions(self.model)))

    def _priced(self, at: Iterate, held: Sequence[Claim], lowered: Sequence[Claim]) -> tuple[float, float]:
        """The objective at a solution, with the price of what is above its bound, and the highest of the curves."""
        top, self.level.value = self._levels(at, held, lowered)
        model, demand = self.model, self.model.demand
        reach = np.hypot(at.lead, at.height) if demand.traced else at.height
        model.sizes.prime.value = max(reach, demand.prime[0] / demand.length)
        for name, variable in model.largest.items():
            variable.value = self._largest(name)
        level = self.level.value if lowered else 0.0
        price = model.cost + level + self.price * max(0.0, top - 1.0 + HELD_CLOSER)
        return price if np.isfinite(price) else inf, top


def _one(unknown: Unknown) -> Any:
    """What gives an unknown as it is."""
    return np.eye(unknown.count) if unknown.is_vector else 1.0


def _scaled(ceilings: Sequence[Claim], level: float) -> tuple[Claim, ...]:
    """Ceilings whose curves are at most 1 of their bounds where they were at a level."""
    scale = level if 0.0 < level < inf else 1.0
    return tuple(ceiling._replace(bound=Plain(ceiling.allowed() * scale)) for ceiling in ceilings)
