"""Motions made of splines: what holds of their Bernstein coefficients holds at every cam angle."""

from math import inf
from typing import Any

import cvxpy as cp
import numpy as np
from scipy import sparse

from camopt.core.numerics import FloatArray
from camopt.core.numerics.quadratic import INDEPENDENT
from camopt.model.motion.stroke import Stroke
from camopt.solve.synthesis.demand import Crossing, Demand, LinearConstraint
from camopt.solve.synthesis.stroke_motion import DerivativeRange, Ranges, Sizes, StrokeMotion


class SplineMotion(StrokeMotion):
    """A stroke whose law is a free spline.

    The coefficients are those of its law, from 0 to 1; of a move they are displacements, in units of the lift.
    """

    def __init__(self, demand: Demand, stroke: Stroke, ranges: Ranges, sizes: Sizes) -> None:
        self.demand, self.stroke, self.unit = demand, stroke, demand.scale
        self.splines = demand.splines_of(stroke)
        self.low, self.change = demand.law_scale(stroke)
        self.coefficients = cp.Variable(self.splines.count)
        self.constraints: list[cp.Constraint] = []
        if not stroke.is_move:
            c = self.coefficients
            self.constraints += [c[0] == 0.0, c[-1] == 1.0, c >= 0.0, c <= 1.0]
            if demand.monotone:
                self.constraints.append(cp.diff(c) >= 0.0)
        for order, bounds in ranges.items():
            matrix = self.splines.once(order, self.splines.degree - order)
            for each in bounds:
                self._within(matrix, order, each)
        for condition in demand.conditions:
            if (part := stroke.part(condition)) is not None:
                matrix, order = self._part(condition.order, *part), condition.order
                low, high = condition.low / self.unit, condition.high / self.unit
                if low == high:
                    self._equal(matrix, order, low)
                else:
                    self._within(matrix, order, DerivativeRange(low, high))
        for floor in demand.floors:
            if floor.guards(stroke):
                self._above(floor, sizes.in_floor(floor, self.unit))

    def _part(self, order: int, low: float, high: float) -> Any:
        """The matrix to what encloses a derivative over a part of the unit stroke: at a point, its value."""
        if low == high:
            return self.splines.at(np.array([low]), order)
        if (low, high) == (0.0, 1.0):
            return self.splines.once(order, self.splines.degree - order)
        return self.splines.between(order, low, high)

    def _within(self, matrix: Any, order: int, limited: DerivativeRange) -> None:
        """Values of a derivative within a range; by x of the unit stroke, whose numbers are not huge."""
        values = self.change * matrix @ self.coefficients + (self.low if order == 0 else 0.0)
        self.constraints += limited.times(self.stroke.angle**order).constraints(values)

    def _above(self, floor: LinearConstraint, sized: Any) -> None:
        """A linear limit on the motion and the sizes."""
        weights = (floor.displacement, floor.velocity, floor.acceleration)
        matrix = sum(
            weight * self.change / self.stroke.angle**order * self.splines.once(order, self.splines.degree)
            for order, weight in enumerate(weights)
        )
        self.constraints.append(matrix @ self.coefficients + floor.displacement * self.low + sized >= 0.0)

    def _equal(self, matrix: Any, order: int, value: float) -> None:
        """A derivative that has one value: of the rows of its matrix those that do not follow from others."""
        rest = self.low if order == 0 else 0.0
        wanted = np.full(matrix.shape[0], (value - rest) * self.stroke.angle**order / self.change)
        left, sizes, right = np.linalg.svd(matrix.toarray(), full_matrices=False)
        kept = sizes > INDEPENDENT * sizes[0]
        self.constraints.append(right[kept] @ self.coefficients == (left.T @ wanted)[kept] / sizes[kept])

    def _linear(self, matrix: Any, order: int) -> tuple[Any, float]:
        """A derivative by the cam angle, in units of the lift, from a matrix for the unit stroke.

        As a matrix of the coefficients and a constant.
        """
        return self.change / self.stroke.angle**order * matrix, self.low if order == 0 else 0.0

    def _values(self, matrix: Any, order: int) -> cp.Expression:
        """The same as an expression."""
        by_coefficients, constant = self._linear(matrix, order)
        return by_coefficients @ self.coefficients + constant

    def _at(self, x: float, order: int) -> cp.Expression:
        """A derivative at x of the unit stroke."""
        return cp.sum(self._values(self.splines.at(np.array([x]), order), order))

    def end(self, order: int, last: bool) -> cp.Expression:
        return self._at(1.0 if last else 0.0, order)

    def rests(self, rest: int, last: bool) -> None:
        """By its first or last coefficients."""
        c = self.coefficients
        self.constraints.append(c[-1 - rest : -1] == c[-1] if last else c[1 : rest + 1] == c[0])

    def mirrors(self, other: "SplineMotion") -> None:
        image = other.change * other.coefficients[::-1] + other.low
        self.constraints.append(self.change * self.coefficients + self.low == image)

    def crosses(self, crossing: Crossing, jerk: Any) -> None:
        up, (low, high, soon, late) = np.sign(self.change), crossing.ends
        pushed, pulled = DerivativeRange(0.0, inf), DerivativeRange(-inf, 0.0)
        before, after = (pushed, pulled) if up > 0.0 else (pulled, pushed)
        self._within(self._part(2, 0.0, low), 2, before)
        self._within(self._part(2, high, 1.0), 2, after)
        if high < soon:
            self._within(self._part(3, high, soon), 3, DerivativeRange(-1.0, 1.0, jerk))
        gone = self._at(high, 0) + crossing.angle * self._at(high, 1) - self._at(late, 0)
        self.constraints.append(up * gone + crossing.missing * jerk >= crossing.gap)

    def turning_jerk(self, crossing: Crossing) -> float:
        """What encloses the jerk until the clearance is crossed, in units of the lift, of a solved programme."""
        _, high, soon, _ = crossing.ends
        return float(np.abs(self._solved(self._part(3, high, soon), 3)).max())

    def opposes(self, other: "SplineMotion", both: float) -> None:
        every = [each.change * each.coefficients + each.low for each in (self, other)]
        self.constraints.append(every[0] + every[1] == both)

    def variation(self) -> list[cp.Expression]:
        """Its coefficients go up and down no less than it does."""
        coefficients = self.splines.bernstein(3)
        return [self._values(coefficients[1:] - coefficients[:-1], 3)]

    def lowest(self, x: float) -> cp.Expression:
        return self._at(x, 0)

    def at(self, x: FloatArray) -> list[tuple[Any, FloatArray]]:
        """y to y''' at x of the unit stroke: each as a matrix of the coefficients and a constant."""
        found = (self._linear(self.splines.at(x, order), order) for order in range(4))
        return [(matrix, np.full(x.size, constant)) for matrix, constant in found]

    def _solved(self, matrix: Any, order: int) -> FloatArray:
        """A derivative of a solved programme, in units of the lift."""
        by_coefficients, constant = self._linear(matrix, order)
        return np.asarray(by_coefficients @ self.coefficients.value + constant)

    def samples(self, order: int) -> FloatArray:
        """The Bernstein coefficients of a derivative, in units of the lift, of a solved programme."""
        return self._solved(self.splines.bernstein(order), order)

    def square(self, order: int) -> list[cp.Expression]:
        """By Gauss's rule, exact on each piece."""
        nodes, weights = np.polynomial.legendre.leggauss(self.splines.degree + 1 - order)
        starts, lengths = self.splines.ends[:-1, None], np.diff(self.splines.ends)[:, None]
        x = (starts + lengths * (nodes + 1) / 2).ravel()
        share = np.sqrt(weights / 2 * lengths * self.stroke.angle).ravel()
        return [self._values(sparse.diags_array(share) @ self.splines.at(x, order), order)]

    def area(self) -> cp.Expression:
        return self.stroke.angle * (self.change * self.splines.integrals @ self.coefficients + self.low)

    def left_over(self) -> list[cp.Expression]:
        found, place = self.demand.left_over, self.demand.free.index(self.stroke)
        constant = found.constant if place == 0 else np.zeros_like(found.constant)
        return [each @ self.coefficients + rest for each, rest in zip(found.rows[place], constant, strict=True)]
