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

from math import sqrt
from typing import Any

import cvxpy as cp
import numpy as np

from camopt.motion.stroke import Stroke
from camopt.synthesis.convex import Ranges, Sizes
from camopt.synthesis.demand import ORDERS, Demand, LinearConstraint
from camopt.synthesis.spline_motion import points_inside

CUBIC = 2.0 / (9.0 * sqrt(3.0))
SAME = 1e-9  # of the stroke: nodes as close as that are one


class RelaxedMotion:
    """What a stroke with any law has at the nodes of so many panels: y, v and a. Only jerks tie a to v.

    Derivatives are by x of the unit stroke, so that a stroke of a small angle has no huge numbers.
    """

    def __init__(self, panels: int, demand: Demand, stroke: Stroke, ranges: Ranges, sizes: Sizes) -> None:
        self.unit, self.angle, self.sizes = demand.scale, stroke.angle, sizes
        points = dict(points_inside(demand, stroke))
        plain = np.linspace(0.0, 1.0, panels + 1)
        apart = [x for x in plain if all(abs(x - point) > SAME for point in points)]
        x = np.array(sorted([*apart, *points]))
        self.h = np.diff(x)
        self.y, self.v, self.a = (cp.Variable(x.size) for _ in range(3))
        low, high = sorted((stroke.low / self.unit, stroke.high / self.unit))
        self.limits = [self.y[0] == stroke.low / self.unit, self.y[-1] == stroke.high / self.unit]
        self.limits += [self.y >= low, self.y <= high]
        self.limits += [self.y[int(np.searchsorted(x, at))] == y / self.unit for at, y in points.items()]
        if demand.monotone:
            up = 1.0 if stroke.high > stroke.low else -1.0
            self.limits += [up * self.v >= 0.0, up * cp.diff(self.y) >= 0.0]
        unit = {
            k: [(low * stroke.angle**k, high * stroke.angle**k) for low, high in ranges.get(k, [])]
            for k in ORDERS.values()
        }
        for low, high in unit[1]:
            self.limits += [self.v >= low, self.v <= high]
            self.limits += [
                cp.diff(self.y) >= cp.multiply(self.h, low),
                cp.diff(self.y) <= cp.multiply(self.h, high),
            ]
        for low, high in unit[2]:
            self._chained(self.y, self.v, low, high)
            self.limits += [self.a >= low, self.a <= high]
        for low, high in unit[3]:
            self._chained(self.v, self.a, low, high)
            start = cp.multiply(self.h, self.v[:-1]) + cp.multiply(self.h**2 / 6, 2 * self.a[:-1] + self.a[1:])
            reach = cp.multiply(CUBIC * self.h**3, (high - low) / 2)
            self.limits += _within(cp.diff(self.y) - start, reach)
        for floor in demand.floors:
            if floor.kinds & stroke.kind:
                self._floor(floor, unit[2])

    def _chained(self, value: Any, slope: Any, low: Any, high: Any) -> None:
        """What a value and its slope have at neighbouring nodes if the slope of the slope is within a range."""
        h, middle, half = self.h, (low + high) / 2, (high - low) / 2
        turned = cp.diff(slope) - cp.multiply(h, middle)
        off = cp.multiply(1 / h, cp.diff(value)) - (slope[1:] + slope[:-1]) / 2
        spent = cp.Variable(h.size, nonneg=True)  # ≥ turned²/(4·half·h), a rotated cone
        most = cp.multiply(4 * h, half)
        self.limits += [
            *_within(turned, cp.multiply(h, half)),
            cp.SOC(spent + most, cp.vstack([2 * turned, spent - most])),
            *_within(off, cp.multiply(h / 4, half) - spent),
        ]

    def _floor(self, floor: LinearConstraint, ranges: list[tuple[Any, Any]]) -> None:
        """A linear limit at the nodes and over each panel; the ranges are those of a."""
        velocity, acceleration = floor.velocity / self.angle, floor.acceleration / self.angle**2
        sized = floor.lead * self.sizes.lead + floor.height * self.sizes.height + floor.constant / self.unit
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
        values = {1: self.v, 2: self.a}.get(order)
        return None if values is None else values[-1 if last else 0] / self.angle**order

    def at_rest(self, rest: int, last: bool) -> list[Any]:
        return [values[-1 if last else 0] == 0.0 for values in (self.v, self.a)[:rest]]

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
