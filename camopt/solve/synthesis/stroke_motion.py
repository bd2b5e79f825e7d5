"""Motion of one stroke in a convex programme: the interface of its representations, and a fixed law."""

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
    """The range of a derivative; its ends may be infinite, and its unit may be a cvxpy variable."""

    low: float
    high: float
    unit: Any = 1.0

    @property
    def middle(self) -> float:
        return (self.low + self.high) / 2.0

    @property
    def half_width(self) -> float:
        return (self.high - self.low) / 2.0

    def scale_by(self, factor: float) -> "DerivativeRange":
        return DerivativeRange(factor * self.low, factor * self.high, self.unit)

    def constraints(self, values: Expression) -> list[Constraint]:
        """Constraints that keep values within the range."""
        constraints = [values >= self.low * self.unit] if isfinite(self.low) else []
        return constraints + ([values <= self.high * self.unit] if isfinite(self.high) else [])


DerivativeRanges = dict[int, list[DerivativeRange]]
"""Ranges of a stroke's derivatives, by order; all ranges of a list hold."""


@dataclass(frozen=True)
class Sizes:
    """Lead e, height s₀ and prime radius, in units of ``SynthesisProblem.size_unit``; s₀ alone if oscillating."""

    lead: Any
    height: Any
    prime: Any

    def sizes_and_constant_part(self, constraint: LinearConstraint, unit: float) -> Expression | float:
        """The sizes and the constant in a linear constraint, with lengths in a unit."""
        terms = ((constraint.lead, self.lead), (constraint.height, self.height))
        return constraint.constant / unit + sum(weight * size for weight, size in terms if weight)


class StrokeMotion:
    """Motion of one stroke in units of the lift, per radᵏ: its constraints, and expressions of it."""

    constraints: list[Constraint]

    def end_derivative(self, order: int, at_stroke_end: bool) -> Any:
        """y or a derivative of it at an end of the stroke; None if the representation does not have it."""

    def impose_rest(self, zero_derivatives: int, at_stroke_end: bool) -> None:
        """Make the first ``zero_derivatives`` derivatives zero at an end, beside a dwell."""

    def displacement_at(self, x: float) -> Any:
        """y at x of the unit stroke, where the motion is lowest; a relaxation returns a free variable."""

    def impose_mirror(self, other: Any) -> None:
        """Make this motion the mirror image of another. A relaxation ignores it: it bounds all motions."""

    def impose_acceleration_sign_change(self, crossing: StrokeCrossing, jerk_bound: Any) -> None:
        """Change the sign of the force at a crossing, with a bounded jerk until the clearance is crossed."""

    def impose_displacement_sum(self, other: Any, total: float) -> None:
        """Make the displacements of this and another motion add up to a constant, in units of the lift."""

    def jerk_variation_vectors(self) -> list[Expression]:
        """Vectors whose magnitudes add up to the variation of the jerk over the stroke, or to more."""
        return []

    def integral_of_squares_vectors(self, order: int) -> list[Expression]:
        """Vectors whose squares add up to ∫ (y⁽ᵏ⁾)² dθ over the stroke, or to less."""
        return []

    def lift_area(self) -> Any:
        """∫ y dθ over the stroke; of a relaxation, a variable within bounds."""

    def residual_response(self) -> list[Expression] | None:
        """The stroke's part of the vibration at the start of each dwell, two rows [mm]; None if it is not known."""


MotionFactory = Callable[[SynthesisProblem, Stroke, DerivativeRanges, Sizes], StrokeMotion]


class FixedMotion(StrokeMotion):
    """A straight line over the cam angle. A linear constraint holds all along it if it holds at both ends.

    Rest, mirror and sum need no constraints: they hold already.
    """

    def __init__(self, problem: SynthesisProblem, stroke: Stroke, ranges: DerivativeRanges, sizes: Sizes) -> None:
        self.low, self.change = stroke.low / problem.motion_unit, (stroke.high - stroke.low) / problem.motion_unit
        self.angle = stroke.angle
        self.velocity = self.change / stroke.angle
        self.constraints: list[cp.Constraint] = []
        for derivative_range in ranges.get(1, []):
            self.constraints += derivative_range.constraints(cp.Constant(self.velocity))
        kind = DWELL if stroke.kind == DWELL else RISE if self.change > 0.0 else RETURN
        ends = self.low if kind == DWELL else np.array([self.low, self.low + self.change])
        for constraint in problem.linear_constraints:
            if constraint.kinds & kind:
                along = constraint.displacement * ends + constraint.velocity * self.velocity
                self.constraints.append(
                    cp.Constant(along) + sizes.sizes_and_constant_part(constraint, problem.motion_unit) >= 0.0
                )

    def end_derivative(self, order: int, at_stroke_end: bool) -> float:
        return (self.low + self.change * at_stroke_end, self.velocity, 0.0, 0.0)[order]

    def displacement_at(self, x: float) -> float:
        return self.low + self.change * x

    def derivative_matrices_at(self, x: FloatArray) -> list[tuple[Any, FloatArray]]:
        """y to y''' at x of the unit stroke, each as an empty matrix and a constant."""
        rows = [self.low + self.change * x, np.full_like(x, self.velocity), *np.zeros((2, x.size))]
        return [(sparse.csr_array((x.size, 0)), row) for row in rows]

    def solved_bernstein_coefficients(self, order: int) -> FloatArray:
        return np.array([self.end_derivative(order, last) for last in (False, True)])

    def lift_area(self) -> float:
        return (self.low + self.change / 2.0) * self.angle

    def residual_response(self) -> list[cp.Expression]:
        """Empty: its vibration is part of the constant of ``residual.ResidualResponse``."""
        return []
