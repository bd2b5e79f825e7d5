"""Motions made of splines: what holds of their Bernstein coefficients holds at every cam angle."""

from typing import Any

import cvxpy as cp
import numpy as np

from camopt.motion.stroke import Stroke
from camopt.numerics import FloatArray
from camopt.synthesis.convex import Ranges, Sizes
from camopt.synthesis.demand import Demand
from camopt.synthesis.residual import left_over
from camopt.synthesis.splines import elevated


class SplineMotion:
    """A stroke whose law is a free spline."""

    def __init__(self, demand: Demand, stroke: Stroke, ranges: Ranges, sizes: Sizes) -> None:
        self.demand, self.splines, self.stroke, self.unit = demand, demand.splines, stroke, demand.scale
        first, last = (1 + demand.rest * beside for beside in demand.beside_dwells(stroke))
        self.coefficients = c = cp.Variable(self.splines.count)
        self.limits = [c[:first] == 0, c[-last:] == 1, c >= 0, c <= 1]
        if demand.monotone:
            self.limits.append(c[1:] >= c[:-1])
        self.limits += [self._of(x, 0) == y / self.unit for x, y in points_inside(demand, stroke)]
        for order, bounds in ranges.items():
            per = stroke.angle**order  # by x of the unit stroke, whose numbers are not huge
            fresh = self.splines.fresh(order, self.splines.degree - order)
            rows = per * self._rows(self.splines.bernstein(order)[fresh], order)
            self.limits += [limit for low, high in bounds for limit in (rows >= per * low, rows <= per * high)]
        degree = self.splines.degree
        fresh = self.splines.fresh(2, degree)
        y, y1, y2 = (
            self._rows(elevated(self.splines.bernstein(order), degree - order, order)[fresh], order)
            for order in range(3)
        )
        for floor in demand.floors:
            if floor.kinds & stroke.kind:
                moving = floor.displacement * y + floor.velocity * y1 + floor.acceleration * y2
                sized = floor.lead * sizes.lead + floor.height * sizes.height + floor.constant / self.unit
                self.limits.append(moving + sized >= 0)

    def _rows(self, matrix: Any, order: int) -> Any:
        """A derivative by the cam angle, in units of the lift, from a matrix for the unit stroke."""
        low, change = self.stroke.low / self.unit, (self.stroke.high - self.stroke.low) / self.unit
        moved = change / self.stroke.angle**order * (matrix @ self.coefficients)
        return moved + low if order == 0 else moved

    def _of(self, x: float, order: int) -> Any:
        return self._rows(self.splines.at(np.array([x]), order), order)[0]

    def end(self, order: int, last: bool) -> Any:
        return self._of(1.0 if last else 0.0, order)

    def at_rest(self, rest: int, last: bool) -> list[Any]:
        """By its first and last coefficients."""
        return []

    def at(self, x: FloatArray) -> list[Any]:
        """y to y''' at x of the unit stroke."""
        return [self._rows(self.splines.at(x, order), order) for order in range(4)]

    def samples(self, order: int) -> FloatArray:
        """The Bernstein coefficients of a derivative, in units of the lift, of a solved programme."""
        return np.asarray(self._rows(self.splines.bernstein(order), order).value)

    def square(self, order: int) -> Any:
        """By Gauss's rule, exact on each piece."""
        nodes, weights = np.polynomial.legendre.leggauss(self.splines.degree + 1 - order)
        pieces = np.arange(self.splines.pieces)[:, None]
        x = ((pieces + (nodes + 1) / 2) / self.splines.pieces).ravel()
        share = np.tile(np.sqrt(weights / 2 / self.splines.pieces * self.stroke.angle), self.splines.pieces)
        return cp.norm(cp.multiply(share, self._rows(self.splines.at(x, order), order)))

    def left_over(self) -> Any:
        rows = left_over(self.demand.strokes, self.splines, *self.demand.train)[self.demand.place(self.stroke)]
        return cp.vstack([each @ self.coefficients for each in rows])


def points_inside(demand: Demand, stroke: Stroke) -> list[tuple[float, float]]:
    """The points inside a stroke that the motion has to go through: x of the unit stroke, and y."""
    inside = [((angle - stroke.start) / stroke.angle, y) for angle, y in demand.points]
    return [(x, y) for x, y in inside if 0.0 < x < 1.0]
