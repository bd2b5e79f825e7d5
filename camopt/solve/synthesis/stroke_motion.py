"""The motion of a stroke for convex programmes, whatever it is made of; and that of one that keeps its law."""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from typing import Any, NamedTuple

import cvxpy as cp
import numpy as np
from cvxpy import Constraint, Expression
from scipy import sparse

from camopt.core.numerics import FloatArray
from camopt.model.motion.stroke import DWELL, RETURN, RISE, Stroke
from camopt.solve.synthesis.synthesis_problem import LinearConstraint, StrokeCrossing, SynthesisProblem


class DerivativeRange(NamedTuple):
    """The ends of a range of a derivative, each possibly infinite, in a unit that may be a variable."""

    low: float
    high: float
    unit: Any = 1.0

    @property
    def middle(self) -> float:
        return (self.low + self.high) / 2.0

    @property
    def half_width(self) -> float:
        """Half its width."""
        return (self.high - self.low) / 2.0

    def scale_by(self, factor: float) -> "DerivativeRange":
        return DerivativeRange(factor * self.low, factor * self.high, self.unit)

    def constraints(self, values: Expression) -> list[Constraint]:
        """Values within the range."""
        below = [values >= self.low * self.unit] if isfinite(self.low) else []
        return below + ([values <= self.high * self.unit] if isfinite(self.high) else [])


DerivativeRanges = dict[int, list[DerivativeRange]]
"""Ranges of a stroke's derivatives, by order; all of a list hold."""


@dataclass(frozen=True)
class Sizes:
    """Offset e, s₀ and prime radius, in units of ``SynthesisProblem.size_unit``; s₀ alone if oscillating."""

    lead: Any
    height: Any
    prime: Any

    def linear_part(self, floor: LinearConstraint, unit: float) -> Any:
        """The sizes and the constant in a linear limit, whose lengths are in a unit."""
        parts = ((floor.lead, self.lead), (floor.height, self.height))
        return floor.constant / unit + sum(weight * size for weight, size in parts if weight)


class StrokeMotion:
    """The motion of one stroke in units of the lift, by rad: its limits, and what others need of it."""

    constraints: list[Constraint]
    """Its limits."""

    def end_derivative(self, order: int, last: bool) -> Any:
        """y or a derivative at an end of the stroke, or None if it is not known there."""

    def impose_rest(self, rest: int, last: bool) -> None:
        """Make so many derivatives zero at an end, beside a dwell."""

    def displacement_at(self, x: float) -> Any:
        """y at x of the unit stroke, where the motion is lowest; of a bound, anything."""

    def impose_mirror(self, other: Any) -> None:
        """Make it the mirror image of another such motion; not a bound, which is one for all motions."""

    def impose_crossing(self, crossing: StrokeCrossing, jerk: Any) -> None:
        """Turn the force of a mass round there, with at most so much jerk until the clearance is crossed."""

    def impose_sum(self, other: Any, both: float) -> None:
        """Make the displacements of it and of another such motion have a sum, in units of the lift."""

    def jerk_variation(self) -> list[Expression]:
        """Vectors whose magnitudes are together the variation of the jerk over the stroke, or no less than that."""
        return []

    def square_vectors(self, order: int) -> list[Expression]:
        """Vectors whose squares are together ∫ (y⁽ᵏ⁾)² dθ over the stroke, or no more than that."""
        return []

    def lift_area(self) -> Any:
        """∫ y dθ over the stroke; of a bound, what it may be."""

    def residual_response(self) -> list[Expression] | None:
        """What it adds to the vibration at the start of each dwell, mm, two rows; None if that is not known."""


MotionFactory = Callable[[SynthesisProblem, Stroke, DerivativeRanges, Sizes], StrokeMotion]


class FixedMotion(StrokeMotion):
    """A straight line over the cam angle: what is linear in the motion holds along it if it does at both ends.

    It rests, mirrors another and opposes another as it is.
    """

    def __init__(self, problem: SynthesisProblem, stroke: Stroke, ranges: DerivativeRanges, sizes: Sizes) -> None:
        self.low, self.change = stroke.low / problem.motion_unit, (stroke.high - stroke.low) / problem.motion_unit
        self.angle = stroke.angle
        self.velocity = self.change / stroke.angle
        self.constraints: list[cp.Constraint] = []
        for each in ranges.get(1, []):
            self.constraints += each.constraints(cp.Constant(self.velocity))
        kind = DWELL if stroke.kind == DWELL else RISE if self.change > 0.0 else RETURN
        ends = self.low if kind == DWELL else np.array([self.low, self.low + self.change])
        for floor in problem.linear_constraints:
            if floor.kinds & kind:
                along = floor.displacement * ends + floor.velocity * self.velocity
                self.constraints.append(cp.Constant(along) + sizes.linear_part(floor, problem.motion_unit) >= 0.0)

    def end_derivative(self, order: int, last: bool) -> float:
        return (self.low + self.change * last, self.velocity, 0.0, 0.0)[order]

    def displacement_at(self, x: float) -> float:
        return self.low + self.change * x

    def derivatives_at(self, x: FloatArray) -> list[tuple[Any, FloatArray]]:
        """y to y''' at x of the unit stroke: of no coefficients."""
        rows = [self.low + self.change * x, np.full_like(x, self.velocity), *np.zeros((2, x.size))]
        return [(sparse.csr_array((x.size, 0)), row) for row in rows]

    def derivative_samples(self, order: int) -> FloatArray:
        return np.array([self.end_derivative(order, last) for last in (False, True)])

    def lift_area(self) -> float:
        return (self.low + self.change / 2.0) * self.angle

    def residual_response(self) -> list[cp.Expression]:
        """What it leaves is part of the constant (``residual.ResidualResponse``)."""
        return []
