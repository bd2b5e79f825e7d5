"""Ceilings that are not convex in the motion, by a sequence of convex steps.

Each step holds the tangent planes of the curves (``ceilings``) within a trust region around the last motion, with a
price on what is above its bound, and is taken where the priced objective truly falls. Curves that are minimised are
held below a level, which the objective has. It ends at a local optimum; the optimum without the ceilings bounds it
from below.

Source: Fletcher, Practical Methods of Optimization, ch. 14 (exact penalty, trust region).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from camopt.motion.table import DWELL
from camopt.numerics import LARGEST_MAGNITUDE, FloatArray
from camopt.problem.claims import Claim, Plain
from camopt.synthesis.ceilings import Sampled, TangentPlanes, samples
from camopt.synthesis.conic import SOLVED, Affine, Limit, Norm, Program, Variable, stacked, within
from camopt.synthesis.convex import Convex
from camopt.synthesis.demand import ORDERS
from camopt.synthesis.iterate import Iterate, iterate_of, moving

PRICES = 100.0, 1e4  # of a curve that is above its bound by all of it, in units of the objective: if one is too low
STEPS, FIRST_REACH = 60, 0.1
GOOD, POOR = 0.75, 0.25  # of what planes promise: if more comes true, steps go further; if less, less far
ENOUGH = 5e-5  # a fall of the priced objective, relative, that is worth a step
CLOSER = 2e-4  # by which bounds are held closer than asked: between samples a curve rises a little more


@dataclass
class SampledStroke:
    """The curves that count over one stroke, each with its samples one after another."""

    sampled: Sampled
    rows: list[Affine]
    """y to y''' at the samples of all curves, in units of the lift; none in a dwell."""
    bounds: Affine
    """What the curves are to stay below."""
    lowered: FloatArray
    """Which curves are minimised."""
    size: int
    """How many samples a curve has."""

    def state(self, unit: float) -> FloatArray:
        """y to y''' at the samples of one curve, mm, of coefficients set in the variables."""
        if self.rows:
            return unit * np.array([row.value[: self.size] for row in self.rows])
        rest = np.zeros((4, self.size))
        rest[0] = self.sampled.stroke.low
        return rest


class SequentialConvex:
    """The convex steps of a programme under ceilings, for all their bounds.

    ``held`` ceilings stay below their bounds; ``lowered`` ones are minimised, beside the objective of the model.
    What is given to its methods are the same ceilings with other bounds.
    """

    def __init__(self, model: Convex, held: Sequence[Claim], lowered: Sequence[Claim] = ()) -> None:
        self.model, self.count = model, len(held)
        self.missing, self.level = Variable(positive=True), Variable(positive=True)
        self.price = PRICES[0]
        self.variables = [model.sizes.lead, model.sizes.height, *(m.coefficients for m in moving(model))]
        self.strokes = list(self._strokes([*held, *lowered]))
        self.planes: list[Limit] = []
        self.goal = model.goal + self.level if lowered else model.goal

    def _strokes(self, ceilings: list[Claim]) -> Iterator[SampledStroke]:
        """Those on which a curve counts."""
        motions = iter(moving(self.model))
        for stroke in self.model.demand.strokes:
            motion = None if stroke.kind == DWELL else next(motions)
            sampled = Sampled(self.model.demand, stroke)
            sides = [1 + (c.goal == LARGEST_MAGNITUDE) for c in ceilings if sampled.counts(c)]
            lowered = [n >= self.count for n, c in enumerate(ceilings) if sampled.counts(c)]
            if sides:
                x = samples(self.model.demand, stroke)
                curves = np.repeat(lowered, sides)
                bounds = [self.level if each else 1.0 - CLOSER + self.missing for each in curves]
                rows = [stacked([row] * curves.size) for row in motion.at(x)] if motion else []
                below = stacked([bound.repeated(x.size) for bound in bounds])
                yield SampledStroke(sampled, rows, below, curves, x.size)

    def run(self, start: Iterate, held: Sequence[Claim], lowered: Sequence[Claim] = ()) -> Iterate:
        """The local optimum that convex steps reach from the motion nearest to a start within the convex limits."""
        self._set(start)
        nearest = Program(Norm(stacked(self._away())), self.model.limits)
        last = iterate_of(self.model) if nearest.solve() in SOLVED else start
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
        for _ in range(STEPS):
            step = self._step(reach)
            if step.solve() not in SOLVED:
                break
            promise = cost - step.value
            if promise < ENOUGH * abs(cost):  # even the planes promise no more
                break
            if top <= 1.0 and self.missing.value.item() > CLOSER and self.price < PRICES[-1]:
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

    def ranked(
        self, starts: Sequence[Iterate], held: Sequence[Claim], lowered: Sequence[Claim] = ()
    ) -> list[Iterate]:
        """Starts by their priced objective, with the price of convex limits that they break."""
        lowered = _scaled(lowered, self._levels(starts[0], held, lowered)[1])

        def price(start: Iterate) -> float:
            cost, _ = self._priced(start, held, lowered)
            broken = max(limit.broken_by for limit in self.model.limits)
            return cost + PRICES[0] * broken

        return sorted(starts, key=price)

    def _set(self, at: Iterate) -> None:
        """A solution in the variables, from which a step starts."""
        sizes = np.array([[at.lead], [at.height]])
        for variable, value in zip(self.variables, (*sizes, *at.coefficients), strict=True):
            variable.found = value

    def _away(self) -> list[Affine]:
        """How far the variables are from their values now."""
        return [variable - variable.value for variable in self.variables]

    def _step(self, reach: float) -> Program:
        """The programme of a step from the values of the variables, under the planes."""
        room = [limit for away in self._away() for limit in within(away, reach)]
        return Program(self.goal + self.price * self.missing, [*self.model.limits, *self.planes, *room])

    def _look(self, at: Iterate, held: Sequence[Claim], lowered: Sequence[Claim]) -> None:
        """Take the planes at a solution."""
        self._set(at)
        ceilings, scale = [*held, *lowered], self.model.demand.scale
        self.planes = [
            self._below(stroke, stroke.sampled.planes(ceilings, stroke.state(scale), self._sizes(at)))
            for stroke in self.strokes
        ]

    def _below(self, stroke: SampledStroke, planes: TangentPlanes) -> Limit:
        """Every plane below its bound, or below the level."""
        sizes = self.model.sizes
        slopes = (*planes.motion[: len(stroke.rows)], planes.lead, planes.height)
        below = stroke.bounds - planes.values.ravel()
        for each, slope in zip((*stroke.rows, sizes.lead, sizes.height), slopes, strict=True):
            below -= slope.ravel() * (each - each.value)
        return below >= 0.0

    def _sizes(self, at: Iterate) -> tuple[float, float]:
        """e and s₀, mm."""
        length = self.model.demand.length
        return length * at.lead, length * at.height

    def _levels(self, at: Iterate, held: Sequence[Claim], lowered: Sequence[Claim]) -> tuple[float, float]:
        """The largest of the curves over their bounds: of those held, and of those minimised."""
        self._set(at)
        scale, tops = self.model.demand.scale, ([0.0], [0.0])
        for stroke in self.strokes:
            values = stroke.sampled.values([*held, *lowered], stroke.state(scale), self._sizes(at))
            for row, which in zip(values, stroke.lowered, strict=True):
                tops[int(which)].append(float(row.max()))
        return max(tops[0]), max(tops[1])

    def _priced(self, at: Iterate, held: Sequence[Claim], lowered: Sequence[Claim]) -> tuple[float, float]:
        """The objective at a solution, with the price of what is above its bound, and the highest of the curves."""
        top, level = self._levels(at, held, lowered)
        self.level.found = np.array([level])
        model, demand = self.model, self.model.demand
        reach = np.hypot(at.lead, at.height) if demand.traced else at.height
        model.sizes.prime.found = np.array([max(reach, demand.prime[0] / demand.length)])
        for name, variable in model.largest.items():
            variable.found = np.array([max(np.abs(motion.samples(ORDERS[name])).max() for motion in moving(model))])
        price = self.goal.value.item() + self.price * max(0.0, top - 1.0 + CLOSER)
        return price if np.isfinite(price) else inf, top


def _scaled(ceilings: Sequence[Claim], level: float) -> tuple[Claim, ...]:
    """Ceilings whose curves are at most 1 of their bounds where they were at a level."""
    scale = level if 0.0 < level < inf else 1.0
    return tuple(ceiling._replace(bound=Plain(ceiling.allowed() * scale)) for ceiling in ceilings)
