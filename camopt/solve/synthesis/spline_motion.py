"""Motions made of splines: what holds for their Bernstein coefficients holds at every cam angle."""

from math import inf
from typing import Any

import cvxpy as cp
import numpy as np
from scipy import sparse

from camopt.core.numerics import FloatArray
from camopt.core.numerics.quadratic import RANK_TOLERANCE
from camopt.model.motion.stroke import Stroke
from camopt.solve.synthesis.splines import distinct_bernstein_matrix
from camopt.solve.synthesis.stroke_motion import DerivativeRange, DerivativeRanges, Sizes, StrokeMotion
from camopt.solve.synthesis.synthesis_problem import LinearConstraint, StrokeCrossing, SynthesisProblem


class SplineMotion(StrokeMotion):
    """A stroke whose law is a free spline.

    Coefficients are those of its law, from 0 to 1. Those of a move are displacements, in units of the lift.
    """

    def __init__(self, problem: SynthesisProblem, stroke: Stroke, ranges: DerivativeRanges, sizes: Sizes) -> None:
        self.problem, self.stroke, self.unit = problem, stroke, problem.motion_unit
        self.splines = problem.splines_by_stroke[stroke]
        self.low, self.change = problem.law_offset_and_scale(stroke)
        self.coefficients = cp.Variable(self.splines.count)
        self.constraints: list[cp.Constraint] = []
        if not stroke.is_move:
            c = self.coefficients
            self.constraints += [c[0] == 0.0, c[-1] == 1.0, c >= 0.0, c <= 1.0]
            if problem.monotone:
                self.constraints.append(cp.diff(c) >= 0.0)
        for order, bounds in ranges.items():
            matrix = distinct_bernstein_matrix(self.splines, order, self.splines.degree - order)
            for derivative_range in bounds:
                self._impose_range(matrix, order, derivative_range)
        for condition in problem.conditions:
            if (part := stroke.part_under_condition(condition)) is not None:
                matrix, order = self._derivative_matrix_on_part(condition.order, *part), condition.order
                low, high = condition.low / self.unit, condition.high / self.unit
                if low == high:
                    self._impose_value(matrix, order, low)
                else:
                    self._impose_range(matrix, order, DerivativeRange(low, high))
        for constraint in problem.linear_constraints:
            if constraint.must_hold_on_stroke_or_move(stroke):
                self._impose_linear(constraint, sizes.sizes_and_constant_part(constraint, self.unit))

    def _derivative_matrix_on_part(self, order: int, low: float, high: float) -> Any:
        """Matrix to Bernstein coefficients of a derivative over a part of the stroke; at a point, to its value."""
        if low == high:
            return self.splines.value_matrix(np.array([low]), order)
        if (low, high) == (0.0, 1.0):
            return distinct_bernstein_matrix(self.splines, order, self.splines.degree - order)
        return self.splines.bernstein_matrix(order, low, high)

    def _impose_range(self, matrix: Any, order: int, limit: DerivativeRange) -> None:
        """Keep values of a derivative within a range; by x of the unit stroke, so that numbers are not huge."""
        values = self.change * matrix @ self.coefficients + (self.low if order == 0 else 0.0)
        self.constraints += limit.scale_by(self.stroke.angle**order).constraints(values)

    def _impose_linear(self, constraint: LinearConstraint, size_part: Any) -> None:
        """A linear constraint on the motion and the sizes."""
        weights = (constraint.displacement, constraint.velocity, constraint.acceleration)
        matrix = sum(
            weight
            * self.change
            / self.stroke.angle**order
            * distinct_bernstein_matrix(self.splines, order, self.splines.degree)
            for order, weight in enumerate(weights)
        )
        self.constraints.append(matrix @ self.coefficients + constraint.displacement * self.low + size_part >= 0.0)

    def _impose_value(self, matrix: Any, order: int, value: float) -> None:
        """Fix a derivative at one value, by the independent rows of its matrix."""
        offset = self.low if order == 0 else 0.0
        values = np.full(matrix.shape[0], (value - offset) * self.stroke.angle**order / self.change)
        left_vectors, singular_values, right_vectors = np.linalg.svd(matrix.toarray(), full_matrices=False)
        is_independent = singular_values > RANK_TOLERANCE * singular_values[0]
        self.constraints.append(
            right_vectors[is_independent] @ self.coefficients
            == (left_vectors.T @ values)[is_independent] / singular_values[is_independent]
        )

    def _derivative_matrix_and_constant(self, matrix: Any, order: int) -> tuple[Any, float]:
        """A derivative by the cam angle, in units of the lift: a matrix of the coefficients and a constant.

        ``matrix`` gives the derivative by x of the unit stroke.
        """
        return self.change / self.stroke.angle**order * matrix, self.low if order == 0 else 0.0

    def _derivative_expression(self, matrix: Any, order: int) -> cp.Expression:
        """The derivative of ``_derivative_matrix_and_constant`` as an expression."""
        by_coefficients, constant = self._derivative_matrix_and_constant(matrix, order)
        return by_coefficients @ self.coefficients + constant

    def _derivative_at(self, x: float, order: int) -> cp.Expression:
        """A derivative at x of the unit stroke, in units of the lift."""
        return cp.sum(self._derivative_expression(self.splines.value_matrix(np.array([x]), order), order))

    def end_derivative(self, order: int, at_stroke_end: bool) -> cp.Expression:
        return self._derivative_at(1.0 if at_stroke_end else 0.0, order)

    def impose_rest(self, zero_derivatives: int, at_stroke_end: bool) -> None:
        """Make its first or last coefficients equal."""
        c = self.coefficients
        self.constraints.append(
            c[-1 - zero_derivatives : -1] == c[-1] if at_stroke_end else c[1 : zero_derivatives + 1] == c[0]
        )

    def impose_mirror(self, other: "SplineMotion") -> None:
        image = other.change * other.coefficients[::-1] + other.low
        self.constraints.append(self.change * self.coefficients + self.low == image)

    def impose_acceleration_sign_change(self, crossing: StrokeCrossing, jerk_bound: Any) -> None:
        up, (low, high, soon, late) = np.sign(self.change), crossing.ends
        positive, negative = DerivativeRange(0.0, inf), DerivativeRange(-inf, 0.0)
        before, after = (positive, negative) if up > 0.0 else (negative, positive)
        self._impose_range(self._derivative_matrix_on_part(2, 0.0, low), 2, before)
        self._impose_range(self._derivative_matrix_on_part(2, high, 1.0), 2, after)
        if high < soon:
            self._impose_range(
                self._derivative_matrix_on_part(3, high, soon), 3, DerivativeRange(-1.0, 1.0, jerk_bound)
            )
        fall = (
            self._derivative_at(high, 0)
            + crossing.angle * self._derivative_at(high, 1)
            - self._derivative_at(late, 0)
        )
        self.constraints.append(up * fall + crossing.clearance_allowance * jerk_bound >= crossing.gap)

    def solved_jerk_bound_after_crossing(self, crossing: StrokeCrossing) -> float:
        """Upper bound of the jerk until the clearance is crossed, in units of the lift, after a solution."""
        _, high, soon, _ = crossing.ends
        return float(np.abs(self._solved_derivative(self._derivative_matrix_on_part(3, high, soon), 3)).max())

    def impose_displacement_sum(self, other: "SplineMotion", total: float) -> None:
        displacements = [motion.change * motion.coefficients + motion.low for motion in (self, other)]
        self.constraints.append(displacements[0] + displacements[1] == total)

    def jerk_variation_vectors(self) -> list[cp.Expression]:
        """The variation of the jerk's Bernstein coefficients, which is no less than that of the jerk."""
        coefficients = self.splines.bernstein_matrix(3)
        return [self._derivative_expression(coefficients[1:] - coefficients[:-1], 3)]

    def displacement_at(self, x: float) -> cp.Expression:
        return self._derivative_at(x, 0)

    def derivative_matrices_at(self, x: FloatArray) -> list[tuple[Any, FloatArray]]:
        """y to y''' at x of the unit stroke, each as a matrix of the coefficients and a constant."""
        scaled = (
            self._derivative_matrix_and_constant(self.splines.value_matrix(x, order), order) for order in range(4)
        )
        return [(matrix, np.full(x.size, constant)) for matrix, constant in scaled]

    def _solved_derivative(self, matrix: Any, order: int) -> FloatArray:
        """A derivative in units of the lift, after a solution."""
        by_coefficients, constant = self._derivative_matrix_and_constant(matrix, order)
        return np.asarray(by_coefficients @ self.coefficients.value + constant)

    def solved_bernstein_coefficients(self, order: int) -> FloatArray:
        """Bernstein coefficients of a derivative of the solved motion, in units of the lift.

        They bound the derivative.
        """
        return self._solved_derivative(self.splines.bernstein_matrix(order), order)

    def integral_of_squares_vectors(self, order: int) -> list[cp.Expression]:
        """By Gauss's rule, exact on each piece."""
        nodes, weights = np.polynomial.legendre.leggauss(self.splines.degree + 1 - order)
        starts, lengths = self.splines.piece_ends[:-1, None], np.diff(self.splines.piece_ends)[:, None]
        x = (starts + lengths * (nodes + 1) / 2).ravel()
        share = np.sqrt(weights / 2 * lengths * self.stroke.angle).ravel()
        return [self._derivative_expression(sparse.diags_array(share) @ self.splines.value_matrix(x, order), order)]

    def lift_area(self) -> cp.Expression:
        return self.stroke.angle * (self.change * self.splines.coefficient_integrals @ self.coefficients + self.low)

    def residual_response(self) -> list[cp.Expression]:
        response, place = self.problem.residual_response, self.problem.free_strokes.index(self.stroke)
        constant = response.constant if place == 0 else np.zeros_like(response.constant)
        return [
            each @ self.coefficients + offset for each, offset in zip(response.rows[place], constant, strict=True)
        ]
