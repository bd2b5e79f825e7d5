"""Motions made of splines: what holds of their Bernstein coefficients holds at every cam angle."""

from math import inf, isfinite
from typing import Any

import numpy as np
from scipy import sparse

from camopt.motion.stroke import Stroke
from camopt.numerics import FloatArray
from camopt.numerics.quadratic import INDEPENDENT
from camopt.synthesis.demand import Crossing, Demand, LinearConstraint
from camopt.synthesis.rows import ConvexRows, LinearSum, LinearTerm, Unknown, negated, times, value_of
from camopt.synthesis.stroke_motion import DerivativeRange, Ranges, Sizes


class SplineMotion:
    """A stroke whose law is a free spline.

    The coefficients are those of its law, from 0 to 1; of a move they are displacements, in units of the lift.
    """

    def __init__(self, demand: Demand, stroke: Stroke, ranges: Ranges, sizes: Sizes) -> None:
        self.demand, self.stroke, self.unit = demand, stroke, demand.scale
        self.splines = demand.splines_of(stroke)
        self.low, self.change = demand.law_scale(stroke)
        self.coefficients = Unknown(self.splines.count)
        self.rows = ConvexRows()
        if not stroke.is_move:
            self._from_0_to_1(demand.monotone)
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

    @property
    def _each(self) -> Any:
        """The matrix to the coefficients themselves, of which each row is one."""
        return sparse.eye_array(self.splines.count, format="csr")

    def _from_0_to_1(self, monotone: bool) -> None:
        each, c = self._each, self.coefficients
        self.rows.zero((each[:1], c))
        self.rows.zero((each[-1:], c), (-1.0, 1.0))
        self.rows.at_least((each, c))
        self.rows.at_least((-each, c), (1.0, 1.0))
        if monotone:
            self.rows.at_least((each[1:] - each[:-1], c))

    def _part(self, order: int, low: float, high: float) -> Any:
        """The matrix to what encloses a derivative over a part of the unit stroke: at a point, its value."""
        if low == high:
            return self.splines.at(np.array([low]), order)
        if (low, high) == (0.0, 1.0):
            return self.splines.once(order, self.splines.degree - order)
        return self.splines.between(order, low, high)

    def _within(self, matrix: Any, order: int, limited: DerivativeRange) -> None:
        """Values of a derivative within a range; by x of the unit stroke, whose numbers are not huge."""
        per, rest = self.stroke.angle**order, self.low if order == 0 else 0.0
        for sign, end in ((1.0, limited.low), (-1.0, limited.high)):
            if isfinite(end):
                moved = (sign * self.change * matrix, self.coefficients)
                self.rows.at_least(moved, (-sign * per * end, limited.unit), (sign * rest, 1.0))

    def _above(self, floor: LinearConstraint, sized: list[LinearTerm]) -> None:
        """A linear limit on the motion and the sizes."""
        weights = (floor.displacement, floor.velocity, floor.acceleration)
        matrix = sum(
            weight * self.change / self.stroke.angle**order * self.splines.once(order, self.splines.degree)
            for order, weight in enumerate(weights)
        )
        self.rows.at_least((matrix, self.coefficients), (floor.displacement * self.low, 1.0), *sized)

    def _equal(self, matrix: Any, order: int, value: float) -> None:
        """A derivative that has one value: of the rows of its matrix those that do not follow from others."""
        rest = self.low if order == 0 else 0.0
        wanted = np.full(matrix.shape[0], (value - rest) * self.stroke.angle**order / self.change)
        left, sizes, right = np.linalg.svd(matrix.toarray(), full_matrices=False)
        kept = sizes > INDEPENDENT * sizes[0]
        self.rows.zero((right[kept], self.coefficients), (-(left.T @ wanted)[kept] / sizes[kept], 1.0))

    def _values(self, matrix: Any, order: int) -> list[LinearTerm]:
        """A derivative by the cam angle, in units of the lift, from a matrix for the unit stroke."""
        moved = (self.change / self.stroke.angle**order * matrix, self.coefficients)
        return [moved, (self.low, 1.0)] if order == 0 else [moved]

    def _at(self, x: float, order: int) -> list[LinearTerm]:
        """A derivative at x of the unit stroke."""
        return self._values(self.splines.at(np.array([x]), order), order)

    def end(self, order: int, last: bool) -> list[LinearTerm]:
        return self._at(1.0 if last else 0.0, order)

    def rests(self, rest: int, last: bool) -> None:
        """By its first or last coefficients."""
        each = self._each[::-1] if last else self._each
        self.rows.zero((each[1 : rest + 1] - each[np.zeros(rest, dtype=int)], self.coefficients))

    def mirrors(self, other: "SplineMotion") -> None:
        own = [(self.change * self._each, self.coefficients), (self.low, 1.0)]
        image = [(other.change * self._each[::-1], other.coefficients), (other.low, 1.0)]
        self.rows.zero(*own, *negated(image))

    def crosses(self, crossing: Crossing, jerk: Any) -> None:
        up, (low, high, soon, late) = np.sign(self.change), crossing.ends
        pushed, pulled = DerivativeRange(0.0, inf), DerivativeRange(-inf, 0.0)
        before, after = (pushed, pulled) if up > 0.0 else (pulled, pushed)
        self._within(self._part(2, 0.0, low), 2, before)
        self._within(self._part(2, high, 1.0), 2, after)
        if high < soon:
            self._within(self._part(3, high, soon), 3, DerivativeRange(-1.0, 1.0, jerk))
        gone = [*self._at(high, 0), *times(crossing.angle, self._at(high, 1)), *negated(self._at(late, 0))]
        self.rows.at_least(*times(up, gone), (crossing.missing, jerk), (-crossing.gap, 1.0))

    def turning_jerk(self, crossing: Crossing) -> float:
        """What encloses the jerk until the clearance is crossed, in units of the lift, of a solved programme."""
        _, high, soon, _ = crossing.ends
        return float(np.abs(value_of(self._values(self._part(3, high, soon), 3))).max())

    def opposes(self, other: "SplineMotion", both: float) -> None:
        every = [(each.change * each._each, each.coefficients) for each in (self, other)]
        self.rows.zero(*every, (self.low + other.low - both, 1.0))

    def variation(self) -> list[LinearSum]:
        """Its coefficients go up and down no less than it does."""
        coefficients = self.splines.bernstein(3)
        return [self._values(coefficients[1:] - coefficients[:-1], 3)]

    def lowest(self, x: float) -> list[LinearTerm]:
        return self._at(x, 0)

    def at(self, x: FloatArray) -> list[LinearSum]:
        """y to y''' at x of the unit stroke."""
        return [self._values(self.splines.at(x, order), order) for order in range(4)]

    def samples(self, order: int) -> FloatArray:
        """The Bernstein coefficients of a derivative, in units of the lift, of a solved programme."""
        return value_of(self._values(self.splines.bernstein(order), order))

    def square(self, order: int) -> list[LinearSum]:
        """By Gauss's rule, exact on each piece."""
        nodes, weights = np.polynomial.legendre.leggauss(self.splines.degree + 1 - order)
        starts, lengths = self.splines.ends[:-1, None], np.diff(self.splines.ends)[:, None]
        x = (starts + lengths * (nodes + 1) / 2).ravel()
        share = np.sqrt(weights / 2 * lengths * self.stroke.angle).ravel()
        return [times(share, self._values(self.splines.at(x, order), order))]

    def area(self) -> list[LinearTerm]:
        weights = sparse.csr_array(self.splines.integrals[None])
        return [(self.stroke.angle * self.change * weights, self.coefficients), (self.stroke.angle * self.low, 1.0)]

    def left_over(self) -> list[LinearSum]:
        found, place = self.demand.left_over, self.demand.free.index(self.stroke)
        constant = found.constant if place == 0 else np.zeros_like(found.constant)
        rows = zip(found.rows[place], constant, strict=True)
        return [[(each, self.coefficients), (rest, 1.0)] for each, rest in rows]
