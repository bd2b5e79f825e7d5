"""Motions made of splines: what holds of their Bernstein coefficients holds at every cam angle."""

from math import inf
from typing import Any

import cvxpy as cp
import numpy as np
from scipy import sparse

from camopt.core.numerics import FloatArray
from camopt.core.numerics.quadratic import RANK_TOLERANCE
from camopt.model.motion.stroke import Stroke
from camopt.solve.synthesis.stroke_motion import DerivativeRange, DerivativeRanges, Sizes, StrokeMotion
from camopt.solve.synthesis.synthesis_problem import LinearConstraint, StrokeCrossing, SynthesisProblem


class SplineMotion(StrokeMotion):
    """A stroke whose law is a free spline.

    The coefficients are those of its law, from 0 to 1; of a move they are displacements, in units of the lift.
    """

    def __init__(self, problem: SynthesisProblem, stroke: Stroke, ranges: DerivativeRanges, sizes: Sizes) -> None:
        self.problem, self.stroke, self.unit = problem, stroke, problem.motion_unit
        self.splines = problem.splines_of(stroke)
        self.low, self.change = problem.law_offset_and_scale(stroke)
        self.coefficients = cp.Variable(self.splines.count)
        self.constraints: list[cp.Constraint] = []
        if not stroke.is_move:
            c = self.coefficients
            self.constraints += [c[0] == 0.0, c[-1] == 1.0, c >= 0.0, c <= 1.0]
            if problem.monotone:
                self.constraints.append(cp.diff(c) >= 0.0)
        for order, bounds in ranges.items():
            matrix = self.splines.distinct_bernstein_matrix(order, self.splines.degree - order)
            for each in bounds:
                self._impose_range(matrix, order, each)
        for condition in problem.conditions:
            if (part := stroke.part_under(condition)) is not None:
                matrix, order = self._part_matrix(condition.order, *part), condition.order
                low, high = condition.low / self.unit, condition.high / self.unit
                if low == high:
                    self._impose_value(matrix, order, low)
                else:
                    self._impose_range(matrix, order, DerivativeRange(low, high))
        for floor in problem.linear_constraints:
            if floor.is_imposed_on(stroke):
                self._impose_linear(floor, sizes.linear_part(floor, self.unit))

    def _part_matrix(self, order: int, low: float, high: float) -> Any:
        """The matrix to what encloses a derivative over a part of the unit stroke: at a point, its value."""
        if low == high:
            return self.splines.value_matrix(np.array([low]), order)
        if (low, high) == (0.0, 1.0):
            return self.splines.distinct_bernstein_matrix(order, self.splines.degree - order)
        return self.splines.bernstein_matrix_between(order, low, high)

    def _impose_range(self, matrix: Any, order: int, limited: DerivativeRange) -> None:
        """Values of a derivative within a range; by x of the unit stroke, whose numbers are not huge."""
        values = self.change * matrix @ self.coefficients + (self.low if order == 0 else 0.0)
        self.constraints += limited.scale_by(self.stroke.angle**order).constraints(values)

    def _impose_linear(self, floor: LinearConstraint, sized: Any) -> None:
        """A linear limit on the motion and the sizes."""
        weights = (floor.displacement, floor.velocity, floor.acceleration)
        matrix = sum(
            weight
            * self.change
            / self.stroke.angle**order
            * self.splines.distinct_bernstein_matrix(order, self.splines.degree)
            for order, weight in enumerate(weights)
        )
        self.constraints.append(matrix @ self.coefficients + floor.displacement * self.low + sized >= 0.0)

    def _impose_value(self, matrix: Any, order: int, value: float) -> None:
        """A derivative that has one value: of the rows of its matrix those that do not follow from others."""
        rest = self.low if order == 0 else 0.0
        wanted = np.full(matrix.shape[0], (value - rest) * self.stroke.angle**order / self.change)
        left, sizes, right = np.linalg.svd(matrix.toarray(), full_matrices=False)
        kept = sizes > RANK_TOLERANCE * sizes[0]
        self.constraints.append(right[kept] @ self.coefficients == (left.T @ wanted)[kept] / sizes[kept])

    def _scaled_matrix(self, matrix: Any, order: int) -> tuple[Any, float]:
        """A derivative by the cam angle, in units of the lift, from a matrix for the unit stroke.

        As a matrix of the coefficients and a constant.
        """
        return self.change / self.stroke.angle**order * matrix, self.low if order == 0 else 0.0

    def _derivative_expression(self, matrix: Any, order: int) -> cp.Expression:
        """The same as an expression."""
        by_coefficients, constant = self._scaled_matrix(matrix, order)
        return by_coefficients @ self.coefficients + constant

    def _derivative_at(self, x: float, order: int) -> cp.Expression:
        """A derivative at x of the unit stroke."""
        return cp.sum(self._derivative_expression(self.splines.value_matrix(np.array([x]), order), order))

    def end_derivative(self, order: int, last: bool) -> cp.Expression:
        return self._derivative_at(1.0 if last else 0.0, order)

    def impose_rest(self, rest: int, last: bool) -> None:
        """By its first or last coefficients."""
        c = self.coefficients
        self.constraints.append(c[-1 - rest : -1] == c[-1] if last else c[1 : rest + 1] == c[0])

    def impose_mirror(self, other: "SplineMotion") -> None:
        image = other.change * other.coefficients[::-1] + other.low
        self.constraints.append(self.change * self.coefficients + self.low == image)

    def impose_crossing(self, crossing: StrokeCrossing, jerk: Any) -> None:
        up, (low, high, soon, late) = np.sign(self.change), crossing.ends
        pushed, pulled = DerivativeRange(0.0, inf), DerivativeRange(-inf, 0.0)
        before, after = (pushed, pulled) if up > 0.0 else (pulled, pushed)
        self._impose_range(self._part_matrix(2, 0.0, low), 2, before)
        self._impose_range(self._part_matrix(2, high, 1.0), 2, after)
        if high < soon:
            self._impose_range(self._part_matrix(3, high, soon), 3, DerivativeRange(-1.0, 1.0, jerk))
        gone = (
            self._derivative_at(high, 0)
            + crossing.angle * self._derivative_at(high, 1)
            - self._derivative_at(late, 0)
        )
        self.constraints.append(up * gone + crossing.clearance_allowance * jerk >= crossing.gap)

    def jerk_at_crossing(self, crossing: StrokeCrossing) -> float:
        """What encloses the jerk until the clearance is crossed, in units of the lift, of a solved programme."""
        _, high, soon, _ = crossing.ends
        return float(np.abs(self._solved_derivative(self._part_matrix(3, high, soon), 3)).max())

    def impose_sum(self, other: "SplineMotion", both: float) -> None:
        every = [each.change * each.coefficients + each.low for each in (self, other)]
        self.constraints.append(every[0] + every[1] == both)

    def jerk_variation(self) -> list[cp.Expression]:
        """Its coefficients go up and down no less than it does."""
        coefficients = self.splines.bernstein_matrix(3)
        return [self._derivative_expression(coefficients[1:] - coefficients[:-1], 3)]

    def displacement_at(self, x: float) -> cp.Expression:
        return self._derivative_at(x, 0)

    def derivatives_at(self, x: FloatArray) -> list[tuple[Any, FloatArray]]:
        """y to y''' at x of the unit stroke: each as a matrix of the coefficients and a constant."""
        found = (self._scaled_matrix(self.splines.value_matrix(x, order), order) for order in range(4))
        return [(matrix, np.full(x.size, constant)) for matrix, constant in found]

    def _solved_derivative(self, matrix: Any, order: int) -> FloatArray:
        """A derivative of a solved programme, in units of the lift."""
        by_coefficients, constant = self._scaled_matrix(matrix, order)
        return np.asarray(by_coefficients @ self.coefficients.value + constant)

    def derivative_samples(self, order: int) -> FloatArray:
        """The Bernstein coefficients of a derivative, in units of the lift, of a solved programme."""
        return self._solved_derivative(self.splines.bernstein_matrix(order), order)

    def square_vectors(self, order: int) -> list[cp.Expression]:
        """By Gauss's rule, exact on each piece."""
        nodes, weights = np.polynomial.legendre.leggauss(self.splines.degree + 1 - order)
        starts, lengths = self.splines.piece_ends[:-1, None], np.diff(self.splines.piece_ends)[:, None]
        x = (starts + lengths * (nodes + 1) / 2).ravel()
        share = np.sqrt(weights / 2 * lengths * self.stroke.angle).ravel()
        return [self._derivative_expression(sparse.diags_array(share) @ self.splines.value_matrix(x, order), order)]

    def lift_area(self) -> cp.Expression:
        return self.stroke.angle * (self.change * self.splines.integrals @ self.coefficients + self.low)

    def residual_response(self) -> list[cp.Expression]:
        found, place = self.problem.residual_response, self.problem.free_strokes.index(self.stroke)
        constant = found.constant if place == 0 else np.zeros_like(found.constant)
        return [each @ self.coefficients + rest for each, rest in zip(found.rows[place], constant, strict=True)]
