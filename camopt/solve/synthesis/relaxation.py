"""A lower bound of the objective for any motion: a convex relaxation at the nodes of panels.

Consider any motion whose derivatives stay within ranges. Let y, v, a be its values at nodes a distance h apart, Δ
the change over a panel, and m and r the middle and half the width of the range of y'' (of y''' in the second row).
Then

    |Δy/h − (v₀ + v₁)/2| ≤ r·h/4 − (Δv − m·h)²/(4·r·h)            |Δv − m·h| ≤ r·h
    |Δv/h − (a₀ + a₁)/2| ≤ r·h/4 − (Δa − m·h)²/(4·r·h)            |Δa − m·h| ≤ r·h
    |Δy − h·(v₀ + v₁)/2 + h²·Δa/12| ≤ r·h³/(18·√3)

The first bound is the area between the two extreme paths from v₀ to v₁: up first, or down first. The last one is
the error of the corrected trapezoidal rule, whose Peano kernel is the second Legendre polynomial. Bessel's
inequality with the first two Legendre polynomials gives, over a panel,

    ∫ y''² ≥ Δv²/h + 12·(Δy − h·(v₀ + v₁)/2)²/h³

The same holds for the jerk, with a third term: 5·(Δa − 6·(v₀ + v₁)/h + 12·Δy/h²)²/h.

The area below y over a panel differs from h·(y₀ + y₁)/2 by at most h²/4·|y'| or h³/12·|y''|, with the largest value
over the panel. Less h²·(v₁ − v₀)/12, it differs by at most h⁴/192·|y'''|. These are the Peano kernels of the
trapezoidal rule and of the corrected one.

A linear constraint holds at each node and for the mean over each panel. One on y and y' alone also holds as
Grönwall's inequality. All these constraints are convex. So the optimum is a lower bound for every cam, and
converges to the true optimum as h².
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
CUBIC_ERROR = 1.0 / (18.0 * sqrt(3.0))
LEAST_JUMP = 0.125  # least jump of the jerk that counts, as a share of the largest jerk
LEAST_SWITCH = 0.25  # least sum of neighbouring jumps for which the motion is cut, as a share of the largest jerk
JUMP_PANELS = 4  # jumps so many panels apart, or fewer, are one; so many give the mean jerk beside it
LEAST_PANEL = 0.25  # least length of a panel beside a condition, as a share of a panel


class RelaxedMotion(StrokeMotion):
    """A stroke with any law, by y, v and a at the nodes of its panels. Only a jerk range ties a to v.

    Derivatives are by x of the unit stroke, so that a stroke of a small angle has no huge numbers.
    """

    def __init__(
        self, panels: int, problem: SynthesisProblem, stroke: Stroke, ranges: DerivativeRanges, sizes: Sizes
    ) -> None:
        self.unit, self.angle, self.sizes = problem.motion_unit, stroke.angle, sizes
        parts = [
            (item, part) for item in problem.conditions if (part := stroke.part_under_condition(item)) is not None
        ]
        crossing_ends = {end for item in problem.crossings_in(stroke) for end in item.ends}
        # equal panels, cut where conditions start and end; no equal node near such a cut
        ends = {end for _, part in parts for end in part} | crossing_ends
        equal_nodes = np.linspace(0.0, 1.0, panels + 1)[1:-1]
        plain_nodes = [x for x in equal_nodes if all(abs(x - end) > LEAST_PANEL / panels for end in ends)]
        x = np.array(sorted({0.0, 1.0, *plain_nodes, *ends}))
        self.x, self.up = x, 1.0 if stroke.high > stroke.low else -1.0
        self.h = np.diff(x)
        self.y, self.v, self.a = (cp.Variable(x.size) for _ in range(3))
        self.whole = cp.Variable()
        self.constraints: list[cp.Constraint] = []
        self._bound_lift_area(ranges)
        if not stroke.is_move:
            self._impose_unit_stroke(stroke, problem.monotone)
        for order, derivative_ranges in ranges.items():
            for item in derivative_ranges:
                self._impose_range(order, item, slice(0, x.size))
        for condition, (start, end) in parts:
            nodes = slice(int(np.abs(x - start).argmin()), int(np.abs(x - end).argmin()) + 1)
            self._impose_range(
                condition.order, DerivativeRange(condition.low / self.unit, condition.high / self.unit), nodes
            )
        for constraint in problem.linear_constraints:
            if constraint.must_hold_on_stroke_or_move(stroke):
                self._impose_linear(constraint, [item.scale_by(self.angle**2) for item in ranges.get(2, [])])

    def _impose_unit_stroke(self, stroke: Stroke, monotone: bool) -> None:
        """A rise or return starts at one end, stops at the other and stays between them."""
        start, end = stroke.low / self.unit, stroke.high / self.unit
        y, up = self.y, 1.0 if end > start else -1.0
        self.constraints += [y[0] == start, y[-1] == end, y >= min(start, end), y <= max(start, end)]
        self.constraints.append(up * self.v[[0, -1]] >= 0.0)  # else it would not stay between them
        if monotone:
            self.constraints += [up * self.v >= 0.0, up * cp.diff(y) >= 0.0]

    def _impose_range(self, order: int, limit: DerivativeRange, nodes: slice) -> None:
        """Constraints on nodes whose derivative, by rad, is within a range from the first node to the last."""
        limit, panels = limit.scale_by(self.angle**order), slice(nodes.start, nodes.stop - 1)
        h, (y, v, a) = self.h[panels], (each[nodes] for each in (self.y, self.v, self.a))
        if order < 3:
            self._impose_value_range((y, v, a)[order], limit)
        if not h.size:
            return
        if order == 1:
            self._impose_value_range(cp.multiply(1 / h, cp.diff(y)), limit)
        elif order == 2:
            self._impose_second_derivative_range(y, v, h, limit)
        elif order == 3:
            self._impose_second_derivative_range(v, a, h, limit)
            error = cp.diff(y) - cp.multiply(h / 2, v[:-1] + v[1:]) + cp.multiply(h**2 / 12, cp.diff(a))
            self.constraints.append(cp.abs(error) <= CUBIC_ERROR * h**3 * limit.half_width * limit.unit)

    def _impose_second_derivative_range(
        self, value: Any, slope: Any, h: FloatArray, limit: DerivativeRange
    ) -> None:
        """Constraints on a value and its slope at neighbouring nodes, for a range of the second derivative."""
        largest_change = h * limit.half_width * limit.unit
        slope_error = cp.diff(slope) - h * limit.middle * limit.unit
        error = cp.multiply(1 / h, cp.diff(value)) - (slope[:-1] + slope[1:]) / 2
        slack = cp.Variable(h.size)  # ≥ slope_error²/(4·largest_change)
        product = cp.SOC(slack + 4 * largest_change, cp.vstack([2 * slope_error, slack - 4 * largest_change]))
        self.constraints += [
            cp.abs(slope_error) <= largest_change,
            product,
            cp.abs(error) <= largest_change / 4 - slack,
        ]

    def _impose_linear(self, constraint: LinearConstraint, acceleration_ranges: list[DerivativeRange]) -> None:
        """A linear constraint at the nodes and over each panel; ``acceleration_ranges`` are those of a."""
        displacement, velocity = constraint.displacement, constraint.velocity / self.angle
        acceleration = constraint.acceleration / self.angle**2
        size_part, (h, y, v, a) = (
            self.sizes.sizes_and_constant_part(constraint, self.unit),
            (self.h, self.y, self.v, self.a),
        )
        node_values = displacement * y + velocity * v
        if acceleration == 0.0:
            self.constraints.append(node_values + size_part >= 0.0)
            if displacement > 0.0 and velocity:
                # with z = w₀·y + S and z ∓ w₁·y' ≥ 0, z grows or falls at most by e^(w₀·h/w₁)
                decay = np.exp(-displacement / abs(velocity) * self.h)
                later, sooner = (self.y[:-1], self.y[1:]) if velocity < 0.0 else (self.y[1:], self.y[:-1])
                grown = displacement * (later - cp.multiply(decay, sooner))
                self.constraints.append(grown + (1.0 - decay) * size_part >= 0.0)
            return
        self.constraints.append(node_values + acceleration * a + size_part >= 0.0)
        for derivative_range in acceleration_ranges:
            mean = displacement * cp.multiply(h / 2, y[:-1] + y[1:])
            area_error = (
                abs(displacement)
                * h**3
                / 12
                * max(-derivative_range.low, derivative_range.high)
                * derivative_range.unit
            )  # at most, by the error of the area
            change = velocity * cp.diff(y) + acceleration * cp.diff(v)
            self.constraints.append(mean + area_error + change + h * size_part >= 0.0)

    def _impose_value_range(self, values: Any, limit: DerivativeRange) -> None:
        """Keep values within a range whose ends may be infinite."""
        if limit.low == limit.high:
            self.constraints.append(values == limit.low * limit.unit)
        else:
            self.constraints += limit.constraints(values)

    def end_derivative(self, order: int, at_stroke_end: bool) -> cp.Expression | None:
        values = {0: self.y, 1: self.v, 2: self.a}.get(order)
        return None if values is None else values[-1 if at_stroke_end else 0] / self.angle**order

    def impose_rest(self, zero_derivatives: int, at_stroke_end: bool) -> None:
        self.constraints += [
            values[-1 if at_stroke_end else 0] == 0.0 for values in (self.v, self.a)[:zero_derivatives]
        ]

    def displacement_at(self, x: float) -> cp.Expression:
        """A free variable: another motion may be lower elsewhere, so the size has no bound."""
        return cp.Variable()

    def impose_acceleration_sign_change(self, crossing: StrokeCrossing, jerk_bound: Any) -> None:
        low, high, soon, late = (int(np.abs(self.x - end).argmin()) for end in crossing.ends)
        self._impose_acceleration_sign(slice(0, low), self.up)
        self._impose_acceleration_sign(slice(high, self.x.size - 1), -self.up)
        if high < soon:
            self._impose_range(3, DerivativeRange(-1.0, 1.0, jerk_bound), slice(high, soon + 1))
        fall = self.y[high] - self.y[late] + crossing.window * self.v[high]
        self.constraints += [
            self.up / self.angle**2 * self.a[high] + crossing.acceleration_allowance * jerk_bound >= 0.0,
            self.up * fall + crossing.clearance_allowance * jerk_bound >= crossing.gap,
            crossing.angle**3 / 6.0 * jerk_bound >= crossing.gap,
        ]

    def _impose_acceleration_sign(self, panels: slice, way: float) -> None:
        """Keep y'' ≥ 0 (way = 1) or ≤ 0 (way = −1) over some panels."""
        nodes, h = slice(panels.start, panels.stop + 1), self.h[panels]
        y, v, a = (way * each[nodes] for each in (self.y, self.v, self.a))
        self.constraints.append(a >= 0.0)
        if h.size:
            along_first, along_last = (cp.multiply(h, each) for each in (v[:-1], v[1:]))
            self.constraints += [cp.diff(v) >= 0.0, cp.diff(y) >= along_first, cp.diff(y) <= along_last]

    def impose_displacement_sum(self, other: "RelaxedMotion", total: float) -> None:
        """Make the sums equal at the nodes, if both strokes have the same nodes.

        A condition on one stroke alone makes the nodes differ.
        """
        if self.h.shape != other.h.shape or np.any(self.h != other.h):
            return
        self.constraints += [self.y + other.y == total, self.v + other.v == 0.0, self.a + other.a == 0.0]

    def jerk_jumps(self) -> tuple[float, ...]:
        """The x at which the jerk of the solution jumps, as it does between limits that hold over arcs.

        The mean jerk over panels overshoots beside a jump, has a middle value in the panel of the jump, and may
        alternate along an arc. So the place is that between the mean jerks before and after, for the same change
        of the acceleration.
        """
        if self.a.value is None:
            return ()
        x, a, jerk = self.x, self.a.value, np.diff(self.a.value) / self.h
        largest = np.abs(jerk).max()
        nodes = 1 + np.flatnonzero(np.abs(np.diff(jerk)) > LEAST_JUMP * largest)
        places = []
        for group in np.split(nodes, np.flatnonzero(np.diff(nodes) > JUMP_PANELS) + 1) if nodes.size else ():
            first, last = max(group[0] - JUMP_PANELS // 2, 1), min(group[-1] + JUMP_PANELS // 2, x.size - 2)
            before, after = jerk[max(first - JUMP_PANELS, 0) : first].mean(), jerk[last : last + JUMP_PANELS].mean()
            if abs(jump := after - before) > LEAST_SWITCH * largest:
                places.append(float((after * x[last] - before * x[first] - (a[last] - a[first])) / jump))
        return tuple(places)

    def cuts_beside_jerk_jumps(self) -> tuple[float, ...]:
        """The x half a panel before and after each jump of the jerk."""
        return tuple(place + side * self.h.max() / 2.0 for place in self.jerk_jumps() for side in (-1.0, 1.0))

    def lift_area(self) -> cp.Expression:
        return self.angle * self.whole

    def _bound_lift_area(self, ranges: DerivativeRanges) -> None:
        """Bound the area under y by the area under its chords, or under cubics with the same ends and slopes."""
        h, y, v = self.h, self.y, self.v
        chords = self.whole - h / 2.0 @ (y[:-1] + y[1:])
        cubics = chords + h**2 / 12.0 @ cp.diff(v)
        for order, derivative_ranges in ranges.items():
            for derivative_range in derivative_ranges:
                scaled = derivative_range.scale_by(self.angle**order)
                largest = max(-scaled.low, scaled.high)
                if order in AREA_ERRORS and isfinite(largest):
                    area_error = AREA_ERRORS[order] * float(np.sum(h ** (order + 1))) * largest * scaled.unit
                    self.constraints.append(cp.abs(cubics if order == 3 else chords) <= area_error)

    def integral_of_squares_vectors(self, order: int) -> list[cp.Expression]:
        h, (value, slope) = self.h, {2: (self.y, self.v), 3: (self.v, self.a)}[order]
        rise, slope_sum, change = cp.diff(value), slope[:-1] + slope[1:], cp.diff(slope)
        middle_part = cp.multiply(np.sqrt(12 / h**3), rise) - cp.multiply(np.sqrt(3 / h), slope_sum)
        parts = [cp.multiply(1 / np.sqrt(h), change), middle_part]
        if order == 3:
            means = cp.multiply(12 / h**2, cp.diff(self.y)) - cp.multiply(6 / h, self.v[:-1] + self.v[1:])
            parts.append(cp.multiply(np.sqrt(5 / h), means + change))
        return [self.angle ** (0.5 - order) * part for part in parts]
