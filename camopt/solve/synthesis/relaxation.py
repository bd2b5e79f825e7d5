"""A bound that no motion whatever can pass: what every motion within the limits has at a few nodes.

Let a motion have its derivatives within ranges. Then its values y, v, a at nodes a distance h apart hold, with
Δ the change over a panel, m the middle and r half the width of the range of y'' (of y'''):

    |Δy/h − (v₀ + v₁)/2| ≤ r·h/4 − (Δv − m·h)²/(4·r·h)            |Δv − m·h| ≤ r·h
    |Δv/h − (a₀ + a₁)/2| ≤ r·h/4 − (Δa − m·h)²/(4·r·h)            |Δa − m·h| ≤ r·h
    |Δy − h·v₀ − h²·(2·a₀ + a₁)/6| ≤ 2·r·h³/(9·√3)

The first is the area between the two extreme paths from v₀ to v₁, up first or down first. By Bessel's inequality
with the first two Legendre polynomials, over a panel

    ∫ y''² ≥ Δv²/h + 12·(Δy − h·(v₀ + v₁)/2)²/h³

and so on for the jerk, with the third as well: 5·(Δa − 6·(v₀ + v₁)/h + 12·Δy/h²)²/h.

The area below y over a panel is h·(y₀ + y₁)/2 to h²/4·|y'| or h³/12·|y''|, and, less h²·(v₁ − v₀)/12, to
h⁴/192·|y'''| at the largest of them (the Peano kernels of the trapezoidal rule and of the corrected one).

A linear limit holds at each node and on the mean over each panel, and one on y and y' alone as Grönwall's
inequality. All of this is convex: the optimum under it bounds every cam from below, and closes on the truth as h².
"""

from math import isfinite, sqrt
from typing import Any

import cvxpy as cp
import numpy as np

from camopt.core.numerics import FloatArray
from camopt.model.motion.stroke import Stroke
from camopt.solve.synthesis.stroke_motion import DerivativeRange, DerivativeRanges, Sizes, StrokeMotion
from camopt.solve.synthesis.synthesis_problem import LinearConstraint, StrokeCrossing, SynthesisProblem

AREA_ERRORS = {1: 1.0 / 4.0, 2: 1.0 / 12.0, 3: 1.0 / 192.0}
CUBIC_ERROR = 2.0 / (9.0 * sqrt(3.0))
LEAST_PANEL = 0.25  # of a panel: the least length of one beside a condition


class RelaxedMotion(StrokeMotion):
    """A stroke with any law, by y, v and a at the nodes of its panels. Only jerks tie a to v.

    Derivatives are by x of the unit stroke, so that a stroke of a small angle has no huge numbers.
    """

    def __init__(
        self, panels: int, problem: SynthesisProblem, stroke: Stroke, ranges: DerivativeRanges, sizes: Sizes
    ) -> None:
        self.unit, self.angle, self.sizes = problem.motion_unit, stroke.angle, sizes
        parts = [(each, part) for each in problem.conditions if (part := stroke.part_under(each)) is not None]
        turning = {end for each in problem.crossings_in(stroke) for end in each.ends}
        # equal panels of a unit stroke, cut where conditions start and end, but no equal one next to nothing
        ends = {end for _, part in parts for end in part} | turning
        plain = np.linspace(0.0, 1.0, panels + 1)[1:-1]
        apart = [x for x in plain if all(abs(x - end) > LEAST_PANEL / panels for end in ends)]
        x = np.array(sorted({0.0, 1.0, *apart, *ends}))
        self.x, self.up = x, 1.0 if stroke.high > stroke.low else -1.0
        self.h = np.diff(x)
        self.y, self.v, self.a = (cp.Variable(x.size) for _ in range(3))
        self.whole = cp.Variable()
        self.constraints: list[cp.Constraint] = []
        self._limit_area(ranges)
        if not stroke.is_move:
            self._impose_unit_stroke(stroke, problem.monotone)
        whole = slice(0, x.size)
        for order, every in ranges.items():
            for each in every:
                self._impose_range(order, each, whole)
        for condition, (start, end) in parts:
            nodes = slice(int(np.abs(x - start).argmin()), int(np.abs(x - end).argmin()) + 1)
            self._impose_range(
                condition.order, DerivativeRange(condition.low / self.unit, condition.high / self.unit), nodes
            )
        for floor in problem.linear_constraints:
            if floor.holds_along(stroke):
                self._impose_linear(floor, [each.scale_by(self.angle**2) for each in ranges.get(2, [])])

    def _impose_unit_stroke(self, stroke: Stroke, monotone: bool) -> None:
        """A rise or return goes from one end to the other, and not beyond."""
        start, end = stroke.low / self.unit, stroke.high / self.unit
        y = self.y
        self.constraints += [y[0] == start, y[-1] == end, y >= min(start, end), y <= max(start, end)]
        if monotone:
            up = 1.0 if end > start else -1.0
            self.constraints += [up * self.v >= 0.0, up * cp.diff(y) >= 0.0]

    def _impose_range(self, order: int, limited: DerivativeRange, nodes: slice) -> None:
        """What nodes have if a derivative by rad is within a range from the first of them to the last."""
        limited, panels = limited.scale_by(self.angle**order), slice(nodes.start, nodes.stop - 1)
        h, (y, v, a) = self.h[panels], (each[nodes] for each in (self.y, self.v, self.a))
        if order < 3:
            self._limit_values((y, v, a)[order], limited)
        if not h.size:
            return
        if order == 1:
            self._limit_values(cp.multiply(1 / h, cp.diff(y)), limited)
        elif order == 2:
            self._impose_slope_range(y, v, h, limited)
        elif order == 3:
            self._impose_slope_range(v, a, h, limited)
            off = cp.diff(y) - cp.multiply(h, v[:-1]) - cp.multiply(h**2 / 6, 2 * a[:-1] + a[1:])
            self.constraints.append(cp.abs(off) <= CUBIC_ERROR * h**3 * limited.half_width * limited.unit)

    def _impose_slope_range(self, value: Any, slope: Any, h: FloatArray, limited: DerivativeRange) -> None:
        """What a value and its slope have at neighbouring nodes if the slope of the slope is within a range."""
        most = h * limited.half_width * limited.unit
        turned = cp.diff(slope) - h * limited.middle * limited.unit
        off = cp.multiply(1 / h, cp.diff(value)) - (slope[:-1] + slope[1:]) / 2
        spent = cp.Variable(h.size)  # ≥ turned²/(4·most)
        product = cp.SOC(spent + 4 * most, cp.vstack([2 * turned, spent - 4 * most]))
        self.constraints += [cp.abs(turned) <= most, product, cp.abs(off) <= most / 4 - spent]

    def _impose_linear(self, floor: LinearConstraint, ranges: list[DerivativeRange]) -> None:
        """A linear limit at the nodes and over each panel; the ranges are those of a."""
        displacement, velocity = floor.displacement, floor.velocity / self.angle
        acceleration = floor.acceleration / self.angle**2
        sized, (h, y, v, a) = self.sizes.linear_part(floor, self.unit), (self.h, self.y, self.v, self.a)
        moving = displacement * y + velocity * v
        if acceleration == 0.0:
            self.constraints.append(moving + sized >= 0.0)
            if displacement > 0.0 and velocity:
                # with z = w₀·y + S and z ∓ w₁·y' ≥ 0, z grows by e^(w₀·h/w₁) at most, or falls by no more
                decay = np.exp(-displacement / abs(velocity) * self.h)
                later, sooner = (self.y[:-1], self.y[1:]) if velocity < 0.0 else (self.y[1:], self.y[:-1])
                grown = displacement * (later - cp.multiply(decay, sooner))
                self.constraints.append(grown + (1.0 - decay) * sized >= 0.0)
            return
        self.constraints.append(moving + acceleration * a + sized >= 0.0)
        for each in ranges:
            mean = displacement * cp.multiply(h / 2, y[:-1] + y[1:])
            missed = abs(displacement) * h**3 / 12 * max(-each.low, each.high) * each.unit  # by the area at most
            change = velocity * cp.diff(y) + acceleration * cp.diff(v)
            self.constraints.append(mean + missed + change + h * sized >= 0.0)

    def _limit_values(self, values: Any, limited: DerivativeRange) -> None:
        """Hold values within a range whose ends may be infinite."""
        if limited.low == limited.high:
            self.constraints.append(values == limited.low * limited.unit)
        else:
            self.constraints += limited.constraints(values)

    def end_derivative(self, order: int, last: bool) -> Any:
        values = {0: self.y, 1: self.v, 2: self.a}.get(order)
        return None if values is None else values[-1 if last else 0] / self.angle**order

    def impose_rest(self, rest: int, last: bool) -> None:
        self.constraints += [values[-1 if last else 0] == 0.0 for values in (self.v, self.a)[:rest]]

    def displacement_at(self, x: float) -> Any:
        """Another motion may be lower elsewhere: its size has no bound."""
        return cp.Variable()

    def impose_crossing(self, crossing: StrokeCrossing, jerk: Any) -> None:
        low, high, soon, late = (int(np.abs(self.x - end).argmin()) for end in crossing.ends)
        self._impose_acceleration_sign(slice(0, low), self.up)
        self._impose_acceleration_sign(slice(high, self.x.size - 1), -self.up)
        if high < soon:
            self._impose_range(3, DerivativeRange(-1.0, 1.0, jerk), slice(high, soon + 1))
        gone = self.y[high] - self.y[late] + crossing.window * self.v[high]
        self.constraints += [
            self.up / self.angle**2 * self.a[high] + crossing.acceleration_allowance * jerk >= 0.0,
            self.up * gone + crossing.clearance_allowance * jerk >= crossing.gap,
            crossing.angle**3 / 6.0 * jerk >= crossing.gap,
        ]

    def _impose_acceleration_sign(self, panels: slice, way: float) -> None:
        """Hold y'' at 0 or above, or below it, over some panels."""
        nodes, h = slice(panels.start, panels.stop + 1), self.h[panels]
        y, v, a = (way * each[nodes] for each in (self.y, self.v, self.a))
        self.constraints.append(a >= 0.0)
        if h.size:
            along_first, along_last = (cp.multiply(h, each) for each in (v[:-1], v[1:]))
            self.constraints += [cp.diff(v) >= 0.0, cp.diff(y) >= along_first, cp.diff(y) <= along_last]

    def impose_sum(self, other: "RelaxedMotion", both: float) -> None:
        """At nodes; those of two strokes are the same unless conditions are asked of one alone."""
        if self.h.shape != other.h.shape or np.any(self.h != other.h):
            return
        sums = [self.y + other.y == both, self.v + other.v == 0.0, self.a + other.a == 0.0]
        self.constraints += sums

    def lift_area(self) -> Any:
        return self.angle * self.whole

    def _limit_area(self, ranges: DerivativeRanges) -> None:
        """How far the area below y may be from that below chords, or below cubics of the same ends and slopes."""
        h, y, v = self.h, self.y, self.v
        chords = self.whole - h / 2.0 @ (y[:-1] + y[1:])
        cubics = chords + h**2 / 12.0 @ cp.diff(v)
        for order, every in ranges.items():
            for each in every:
                limited = each.scale_by(self.angle**order)
                largest = max(-limited.low, limited.high)
                if order in AREA_ERRORS and isfinite(largest):
                    most = AREA_ERRORS[order] * float(np.sum(h ** (order + 1))) * largest * limited.unit
                    self.constraints.append(cp.abs(cubics if order == 3 else chords) <= most)

    def square_vectors(self, order: int) -> list[cp.Expression]:
        h, (value, slope) = self.h, {2: (self.y, self.v), 3: (self.v, self.a)}[order]
        rise, both, change = cp.diff(value), slope[:-1] + slope[1:], cp.diff(slope)
        off = cp.multiply(np.sqrt(12 / h**3), rise) - cp.multiply(np.sqrt(3 / h), both)
        parts = [cp.multiply(1 / np.sqrt(h), change), off]
        if order == 3:
            means = cp.multiply(12 / h**2, cp.diff(self.y)) - cp.multiply(6 / h, self.v[:-1] + self.v[1:])
            parts.append(cp.multiply(np.sqrt(5 / h), means + change))
        return [self.angle ** (0.5 - order) * part for part in parts]
