"""Motions made of splines: what holds of their Bernstein coefficients holds at every cam angle."""

from math import isfinite
from typing import Any

import cvxpy as cp
import numpy as np

from camopt.motion.stroke import Stroke
from camopt.numerics import FloatArray
from camopt.synthesis.demand import Demand, LinearConstraint
from camopt.synthesis.stroke_motion import Ranges, Sizes

INDEPENDENT = 1e-10  # of the largest singular value: a row with less follows from others


class SplineMotion:
    """A stroke whose law is a free spline.

    The coefficients are those of its law, from 0 to 1; of a move they are displacements, in units of the lift.
    """

    def __init__(self, demand: Demand, stroke: Stroke, ranges: Ranges, sizes: Sizes) -> None:
        self.demand, self.stroke, self.unit = demand, stroke, demand.scale
        self.splines = demand.splines_of(stroke)
        self.low, self.change = demand.law_scale(stroke)
        self.coefficients = c = cp.Variable(self.splines.count)
        self.limits: list[Any] = [] if stroke.is_move else [c[0] == 0, c[-1] == 1, c >= 0, c <= 1]
        if demand.monotone and not stroke.is_move:
            self.limits.append(c[1:] >= c[:-1])
        for order, bounds in ranges.items():
            matrix = self.splines.once(order, self.splines.degree - order)
            self.limits += [limit for low, high in bounds for limit in self._within(matrix, order, low, high)]
        for condition in demand.conditions:
            if (part := stroke.part(condition)) is not None:
                matrix, order = self._part(condition.order, *part), condition.order
                low, high = condition.low / self.unit, condition.high / self.unit
                if low == high:
                    self.limits.append(self._equal(matrix, order, low))
                else:
                    self.limits += self._within(matrix, order, low, high)
        for floor in demand.floors:
            if floor.guards(stroke):
                self.limits.append(self._above(floor, sizes.in_floor(floor, self.unit)))

    def _part(self, order: int, low: float, high: float) -> Any:
        """The matrix to what encloses a derivative over a part of the unit stroke: at a point, its value."""
        if low == high:
            return self.splines.at(np.array([low]), order)
        if (low, high) == (0.0, 1.0):
            return self.splines.once(order, self.splines.degree - order)
        return self.splines.between(order, low, high)

    def _within(self, matrix: Any, order: int, low: Any, high: Any) -> list[Any]:
        """Values of a derivative within a range; by x of the unit stroke, whose numbers are not huge."""
        per, rest = self.stroke.angle**order, self.low if order == 0 else 0.0
        ends = ((1.0, low), (-1.0, high))
        finite = [(sign, end) for sign, end in ends if not isinstance(end, float) or isfinite(end)]
        return [
            (sign * self.change * matrix) @ self.coefficients >= sign * (per * end - rest) for sign, end in finite
        ]

    def _above(self, floor: LinearConstraint, sized: Any) -> Any:
        """A linear limit on the motion and the sizes, in one matrix: cvxpy takes long over sums."""
        weights = (floor.displacement, floor.velocity, floor.acceleration)
        matrix = sum(
            weight * self.change / self.stroke.angle**order * self.splines.once(order, self.splines.degree)
            for order, weight in enumerate(weights)
        )
        return matrix @ self.coefficients + (floor.displacement * self.low + sized) >= 0

    def _equal(self, matrix: Any, order: int, value: float) -> Any:
        """A derivative that has one value: of the rows of its matrix those that do not follow from others."""
        rest = self.low if order == 0 else 0.0
        wanted = np.full(matrix.shape[0], (value - rest) * self.stroke.angle**order / self.change)
        left, sizes, right = np.linalg.svd(matrix.toarray(), full_matrices=False)
        kept = sizes > INDEPENDENT * sizes[0]
        return right[kept] @ self.coefficients == (left.T @ wanted)[kept] / sizes[kept]

    def _rows(self, matrix: Any, order: int) -> Any:
        """A derivative by the cam angle, in units of the lift, from a matrix for the unit stroke."""
        moved = (self.change / self.stroke.angle**order * matrix) @ self.coefficients
        return moved + self.low if order == 0 else moved

    def _of(self, x: float, order: int) -> Any:
        return self._rows(self.splines.at(np.array([x]), order), order)[0]

    def end(self, order: int, last: bool) -> Any:
        return self._of(1.0 if last else 0.0, order)

    def at_rest(self, rest: int, last: bool) -> list[Any]:
        """By its first or last coefficients."""
        c = self.coefficients
        return [c[-1 - rest : -1] == c[-1]] if last else [c[1 : rest + 1] == c[0]]

    def mirrors(self, other: "SplineMotion") -> list[Any]:
        own, others = (each.low + each.change * each.coefficients for each in (self, other))
        return [own == others[::-1]]

    def variation(self) -> Any:
        """Its coefficients go up and down no less than it does."""
        return cp.norm1(cp.diff(self._rows(self.splines.bernstein(3), 3)))

    def lowest(self, x: float) -> Any:
        return self._of(x, 0)

    def at(self, x: FloatArray) -> list[Any]:
        """y to y''' at x of the unit stroke."""
        return [self._rows(self.splines.at(x, order), order) for order in range(4)]

    def samples(self, order: int) -> FloatArray:
        """The Bernstein coefficients of a derivative, in units of the lift, of a solved programme."""
        return np.asarray(self._rows(self.splines.bernstein(order), order).value)

    def square(self, order: int) -> Any:
        """By Gauss's rule, exact on each piece."""
        nodes, weights = np.polynomial.legendre.leggauss(self.splines.degree + 1 - order)
        starts, lengths = self.splines.ends[:-1, None], np.diff(self.splines.ends)[:, None]
        x = (starts + lengths * (nodes + 1) / 2).ravel()
        share = np.sqrt(weights / 2 * lengths * self.stroke.angle).ravel()
        return cp.norm(cp.multiply(share, self._rows(self.splines.at(x, order), order)))

    def left_over(self) -> Any:
        found, place = self.demand.left_over, self.demand.free.index(self.stroke)
        own = cp.vstack([each @ self.coefficients for each in found.rows[place]])
        return own + found.constant if place == 0 else own
