"""A bound that no motion whatever can pass: what every motion within the limits has at a few nodes.

Let a motion have its derivatives within ranges. Then its values y, v, a at nodes a distance h apart hold, with
Δ the change over a panel, m the middle and r half the width of the range of y'' (of y'''):

    |Δy/h − (v₀ + v₁)/2| ≤ r·h/4 − (Δv − m·h)²/(4·r·h)            |Δv − m·h| ≤ r·h
    |Δv/h − (a₀ + a₁)/2| ≤ r·h/4 − (Δa − m·h)²/(4·r·h)            |Δa − m·h| ≤ r·h
    |Δy − h·v₀ − h²·(2·a₀ + a₁)/6| ≤ 2·r·h³/(9·√3)

The first is the area between the two extreme paths from v₀ to v₁, up first or down first. By Bessel's inequality
with the first two Legendre polynomials, over a panel

    ∫ y''² ≥ Δv²/h + 12·(Δy − h·(v₀ + v₁)/2)²/h³

and so on for the jerk, with the third as well: 5·(Δa − 6·(v₀ + v₁)/h + 12·Δy/h²)²/h. A linear limit holds at each
node and on the mean over each panel, and one on y and y' alone as Grönwall's inequality. All of this is convex: the
optimum under it bounds every cam from below, and closes on the truth as h².
"""

from math import isfinite, sqrt
from typing import Any

import cvxpy as cp
import numpy as np

from camopt.motion.stroke import Stroke
from camopt.numerics import FloatArray
from camopt.synthesis.demand import Demand, LinearConstraint
from camopt.synthesis.stroke_motion import Ranges, Sizes

CUBIC = 2.0 / (9.0 * sqrt(3.0))
BESIDE = 0.25  # of a panel: the least length of one beside a condition


class RelaxedMotion:
    """What a stroke with any law has at the nodes of so many panels: y, v and a. Only jerks tie a to v.

    Derivatives are by x of the unit stroke, so that a stroke of a small angle has no huge numbers.
    """

    def __init__(self, panels: int, demand: Demand, stroke: Stroke, ranges: Ranges, sizes: Sizes) -> None:
        self.unit, self.angle, self.sizes = demand.scale, stroke.angle, sizes
        parts = [(each, part) for each in demand.conditions if (part := stroke.part(each)) is not None]
        x = _nodes(panels, {end for _, part in parts for end in part})
        self.h = np.diff(x)
        self.y, self.v, self.a = (cp.Variable(x.size) for _ in range(3))
        self.limits: list[Any] = [] if stroke.is_move else self._unit_stroke(stroke, demand.monotone)
        whole = slice(0, x.size)
        for order, every in ranges.items():
            for low, high in every:
                self._range(order, low, high, whole)
        for condition, (start, end) in parts:
            nodes = slice(int(np.abs(x - start).argmin()), int(np.abs(x - end).argmin()) + 1)
            self._range(condition.order, condition.low / self.unit, condition.high / self.unit, nodes)
        for floor in demand.floors:
            if floor.bears_on(stroke):
                self._floor(floor, [(low * self.angle**2, high * self.angle**2) for low, high in ranges.get(2, [])])

    def _unit_stroke(self, stroke: Stroke, monotone: bool) -> list[Any]:
        """A rise or return goes from one end to the other, and not beyond."""
        start, end = stroke.low / self.unit, stroke.high / self.unit
        limits = [self.y[0] == start, self.y[-1] == end, self.y >= min(start, end), self.y <= max(start, end)]
        if monotone:
            up = 1.0 if end > start else -1.0
            limits += [up * self.v >= 0.0, up * cp.diff(self.y) >= 0.0]
        return limits

    def _range(self, order: int, low: Any, high: Any, nodes: slice) -> None:
        """What nodes have if a derivative by rad is within a range from the first of them to the last."""
        low, high = low * self.angle**order, high * self.angle**order
        y, v, a = (values[nodes] for values in (self.y, self.v, self.a))
        h = self.h[nodes.start : nodes.stop - 1]
        if order < 3:
            self.limits += _between((y, v, a)[order], low, high)
        if not h.size:
            return
        if order == 1:
            self.limits += _between(cp.multiply(1 / h, cp.diff(y)), low, high)
        elif order == 2:
            self._chained(y, v, low, high, h)
        elif order == 3:
            self._chained(v, a, low, high, h)
            start = cp.multiply(h, v[:-1]) + cp.multiply(h**2 / 6, 2 * a[:-1] + a[1:])
            reach = cp.multiply(CUBIC * h**3, (high - low) / 2)
            self.limits += _within(cp.diff(y) - start, reach)

    def _chained(self, value: Any, slope: Any, low: Any, high: Any, h: FloatArray) -> None:
        """What a value and its slope have at neighbouring nodes if the slope of the slope is within a range."""
        middle, half = (low + high) / 2, (high - low) / 2
        turned = cp.diff(slope) - cp.multiply(h, middle)
        off = cp.multiply(1 / h, cp.diff(value)) - (slope[1:] + slope[:-1]) / 2
        spent = cp.Variable(h.size)  # ≥ turned²/(4·half·h), a rotated cone
        most = cp.multiply(4 * h, half)
        self.limits += [
            spent >= 0.0,
            *_within(turned, cp.multiply(h, half)),
            cp.SOC(spent + most, cp.vstack([2 * turned, spent - most])),
            *_within(off, cp.multiply(h / 4, half) - spent),
        ]

    def _floor(self, floor: LinearConstraint, ranges: list[tuple[Any, Any]]) -> None:
        """A linear limit at the nodes and over each panel; the ranges are those of a."""
        velocity, acceleration = floor.velocity / self.angle, floor.acceleration / self.angle**2
        sized = self.sizes.in_floor(floor, self.unit)
        moving = floor.displacement * self.y + velocity * self.v
        if acceleration == 0.0:
            self.limits.append(moving + sized >= 0)
            if floor.displacement > 0.0 and velocity:
                self._groenwall(floor.displacement, velocity, sized)
            return
        self.limits.append(moving + acceleration * self.a + sized >= 0)
        for low, high in ranges:
            largest = (high - low) / 2 + abs((high + low) / 2) if isinstance(low, float) else high
            mean = cp.multiply(self.h / 2, self.y[1:] + self.y[:-1])
            off = cp.multiply(self.h**3 / 12, largest)  # by which the area under y may differ
            self.limits.append(
                floor.displacement * mean
                + abs(floor.displacement) * off
                + velocity * cp.diff(self.y)
                + acceleration * cp.diff(self.v)
                + cp.multiply(self.h, sized)
                >= 0
            )

    def _groenwall(self, displacement: float, velocity: float, sized: Any) -> None:
        """With z = w₀·y + S and z ∓ w₁·y' ≥ 0, z grows by e^(w₀·h/w₁) at most, or falls by no more."""
        z = displacement * self.y + sized
        decay = np.exp(-displacement / abs(velocity) * self.h)
        later, sooner = (z[:-1], z[1:]) if velocity < 0.0 else (z[1:], z[:-1])
        self.limits.append(later >= cp.multiply(decay, sooner))

    def end(self, order: int, last: bool) -> Any:
        values = {0: self.y, 1: self.v, 2: self.a}.get(order)
        return None if values is None else values[-1 if last else 0] / self.angle**order

    def at_rest(self, rest: int, last: bool) -> list[Any]:
        return [values[-1 if last else 0] == 0.0 for values in (self.v, self.a)[:rest]]

    def lowest(self, x: float) -> Any:
        """Another motion may be lower elsewhere: its size has no bound."""
        return cp.Variable()

    def mirrors(self, other: Any) -> list[Any]:
        return []

    def variation(self) -> Any:
        return cp.Constant(0.0)

    def left_over(self) -> None:
        """Between its nodes a motion may add anything."""

    def square(self, order: int) -> Any:
        value, slope = {2: (self.y, self.v), 3: (self.v, self.a)}[order]
        off = cp.diff(value) - cp.multiply(self.h / 2, slope[1:] + slope[:-1])
        first = cp.multiply(1 / np.sqrt(self.h), cp.diff(slope))
        parts = [first, cp.multiply(np.sqrt(12 / self.h**3), off)]
        if order == 3:
            bent = cp.multiply(12 / self.h**2, cp.diff(self.y)) - cp.multiply(6 / self.h, self.v[1:] + self.v[:-1])
            parts.append(cp.multiply(np.sqrt(5 / self.h), cp.diff(self.a) + bent))
        return self.angle ** (0.5 - order) * cp.norm(cp.hstack(parts))


def _within(values: Any, most: Any) -> list[Any]:
    """The limits of their magnitudes, without the variables that cvxpy would add for an absolute value."""
    return [values <= most, values >= -most]


def _between(values: Any, low: Any, high: Any) -> list[Any]:
    """The limits of values within a range whose ends may be infinite."""
    if isinstance(low, float) and low == high:
        return [values == low]
    ends = ((values, low), (-values, -high))
    return [value >= end for value, end in ends if isinstance(end, cp.Expression) or isfinite(end)]


def _nodes(panels: int, ends: set[float]) -> FloatArray:
    """Equal panels of a unit stroke, cut where conditions start and end, but no equal one next to nothing."""
    plain = np.linspace(0.0, 1.0, panels + 1)[1:-1]
    apart = [x for x in plain if all(abs(x - end) > BESIDE / panels for end in ends)]
    return np.array(sorted({0.0, 1.0, *apart, *ends}))
