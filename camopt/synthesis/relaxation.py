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

from collections.abc import Sequence
from math import isfinite, sqrt
from typing import Any

import numpy as np
from scipy import sparse

from camopt.motion.stroke import Stroke
from camopt.numerics import FloatArray
from camopt.synthesis.demand import Crossing, Demand, LinearConstraint
from camopt.synthesis.rows import ConvexRows, LinearSum, LinearTerm, Unknown, negated, times
from camopt.synthesis.stroke_motion import DerivativeRange, Ranges, Sizes

AREA = {1: 1.0 / 4.0, 2: 1.0 / 12.0, 3: 1.0 / 192.0}
CUBIC = 2.0 / (9.0 * sqrt(3.0))
LEAST_PANEL = 0.25  # of a panel: the least length of one beside a condition


class RelaxedMotion:
    """A stroke with any law, by y, v and a at the nodes of its panels. Only jerks tie a to v.

    Derivatives are by x of the unit stroke, so that a stroke of a small angle has no huge numbers.
    """

    def __init__(self, panels: int, demand: Demand, stroke: Stroke, ranges: Ranges, sizes: Sizes) -> None:
        self.unit, self.angle, self.sizes = demand.scale, stroke.angle, sizes
        parts = [(each, part) for each in demand.conditions if (part := stroke.part(each)) is not None]
        turning = {end for each in demand.crossings_in(stroke) for end in each.ends}
        x = _nodes(panels, {end for _, part in parts for end in part} | turning)
        self.x, self.up = x, 1.0 if stroke.high > stroke.low else -1.0
        self.h = np.diff(x)
        self.each = sparse.eye_array(x.size, format="csr")
        self.first, self.last = self.each[:-1], self.each[1:]
        self.change, self.both = self.last - self.first, self.last + self.first
        self.y, self.v, self.a = (Unknown(x.size) for _ in range(3))
        self.whole = Unknown()
        self.rows = ConvexRows()
        self._area(ranges)
        if not stroke.is_move:
            self._unit_stroke(stroke, demand.monotone)
        whole = slice(0, x.size)
        for order, every in ranges.items():
            for each in every:
                self._range(order, each, whole)
        for condition, (start, end) in parts:
            nodes = slice(int(np.abs(x - start).argmin()), int(np.abs(x - end).argmin()) + 1)
            self._range(
                condition.order, DerivativeRange(condition.low / self.unit, condition.high / self.unit), nodes
            )
        for floor in demand.floors:
            if floor.bears_on(stroke):
                self._floor(floor, [each.times(self.angle**2) for each in ranges.get(2, [])])

    def _unit_stroke(self, stroke: Stroke, monotone: bool) -> None:
        """A rise or return goes from one end to the other, and not beyond."""
        start, end = stroke.low / self.unit, stroke.high / self.unit
        self.rows.zero((self.each[:1], self.y), (-start, 1.0))
        self.rows.zero((self.each[-1:], self.y), (-end, 1.0))
        self._between([(self.each, self.y)], DerivativeRange(min(start, end), max(start, end)))
        if monotone:
            up = 1.0 if end > start else -1.0
            self.rows.at_least((up * self.each, self.v))
            self.rows.at_least((up * self.change, self.y))

    def _range(self, order: int, limited: DerivativeRange, nodes: slice) -> None:
        """What nodes have if a derivative by rad is within a range from the first of them to the last."""
        limited, panels = limited.times(self.angle**order), slice(nodes.start, nodes.stop - 1)
        h, change = self.h[panels], self.change[panels]
        if order < 3:
            self._between([(self.each[nodes], (self.y, self.v, self.a)[order])], limited)
        if not h.size:
            return
        if order == 1:
            self._between([(_by(1 / h, change), self.y)], limited)
        elif order == 2:
            self._chained(self.y, self.v, limited, panels)
        elif order == 3:
            self._chained(self.v, self.a, limited, panels)
            first, both = self.first[panels], self.both[panels]
            off = [(change, self.y), (-_by(h, first), self.v), (-_by(h**2 / 6, first + both), self.a)]
            self._within(off, [(CUBIC * h**3 * limited.half, limited.unit)])

    def _chained(self, value: Any, slope: Any, limited: DerivativeRange, panels: slice) -> None:
        """What a value and its slope have at neighbouring nodes if the slope of the slope is within a range."""
        h, change = self.h[panels], self.change[panels]
        spent = Unknown(h.size)  # ≥ turned²/(4·half·h), a rotated cone
        used = (sparse.eye_array(h.size, format="csr"), spent)
        turned: list[LinearTerm] = [(change, slope), (-h * limited.middle, limited.unit)]
        off: list[LinearTerm] = [(_by(1 / h, change), value), (-0.5 * self.both[panels], slope)]
        self.rows.at_least(used)
        self._within(turned, [(h * limited.half, limited.unit)])
        self.rows.product([used], [(4 * h * limited.half, limited.unit)], turned)
        self._within(off, [(h / 4 * limited.half, limited.unit), *negated([used])])

    def _floor(self, floor: LinearConstraint, ranges: list[DerivativeRange]) -> None:
        """A linear limit at the nodes and over each panel; the ranges are those of a."""
        velocity, acceleration = floor.velocity / self.angle, floor.acceleration / self.angle**2
        sized = self.sizes.in_floor(floor, self.unit)
        moving = [(floor.displacement * self.each, self.y), (velocity * self.each, self.v)]
        if acceleration == 0.0:
            self.rows.at_least(*moving, *sized)
            if floor.displacement > 0.0 and velocity:
                self._groenwall(floor.displacement, velocity, sized)
            return
        self.rows.at_least(*moving, (acceleration * self.each, self.a), *sized)
        for each in ranges:
            largest = max(-each.low, each.high)
            self.rows.at_least(
                (floor.displacement * _by(self.h / 2, self.both), self.y),  # the mean
                (abs(floor.displacement) * self.h**3 / 12 * largest, each.unit),  # by which the area may differ
                (velocity * self.change, self.y),
                (acceleration * self.change, self.v),
                *((self.h * weight, size) for weight, size in sized),
            )

    def _groenwall(self, displacement: float, velocity: float, sized: list[LinearTerm]) -> None:
        """With z = w₀·y + S and z ∓ w₁·y' ≥ 0, z grows by e^(w₀·h/w₁) at most, or falls by no more."""
        decay = np.exp(-displacement / abs(velocity) * self.h)
        later, sooner = (self.first, self.last) if velocity < 0.0 else (self.last, self.first)
        grown = (displacement * (later - _by(decay, sooner)), self.y)
        self.rows.at_least(grown, *(((1.0 - decay) * weight, size) for weight, size in sized))

    def _within(self, values: Sequence[LinearTerm], most: Sequence[LinearTerm]) -> None:
        """Hold magnitudes."""
        self.rows.at_least(*negated(values), *most)
        self.rows.at_least(*values, *most)

    def _between(self, values: Sequence[LinearTerm], limited: DerivativeRange) -> None:
        """Hold values within a range whose ends may be infinite."""
        if limited.low == limited.high:
            self.rows.zero(*values, (-limited.low, limited.unit))
            return
        if isfinite(limited.low):
            self.rows.at_least(*values, (-limited.low, limited.unit))
        if isfinite(limited.high):
            self.rows.at_least(*negated(values), (limited.high, limited.unit))

    def end(self, order: int, last: bool) -> list[LinearTerm] | None:
        values = {0: self.y, 1: self.v, 2: self.a}.get(order)
        at = self.each[-1:] if last else self.each[:1]
        return None if values is None else [(at / self.angle**order, values)]

    def rests(self, rest: int, last: bool) -> None:
        at = self.each[-1:] if last else self.each[:1]
        for values in (self.v, self.a)[:rest]:
            self.rows.zero((at, values))

    def lowest(self, x: float) -> list[LinearTerm]:
        """Another motion may be lower elsewhere: its size has no bound."""
        return [(1.0, Unknown())]

    def mirrors(self, other: Any) -> None:
        """The bound is one for all motions."""

    def crosses(self, crossing: Crossing, jerk: Any) -> None:
        low, high, soon, late = (int(np.abs(self.x - end).argmin()) for end in crossing.ends)
        self._bent(slice(0, low), self.up)
        self._bent(slice(high, self.x.size - 1), -self.up)
        if high < soon:
            self._range(3, DerivativeRange(-1.0, 1.0, jerk), slice(high, soon + 1))
        start, end = self.each[[high]], self.each[[late]]
        self.rows.at_least((self.up / self.angle**2 * start, self.a), (crossing.pulled, jerk))
        gone: list[LinearTerm] = [(start - end, self.y), (crossing.window * start, self.v)]
        self.rows.at_least(*times(self.up, gone), (crossing.missing, jerk), (-crossing.gap, 1.0))
        self.rows.at_least((crossing.angle**3 / 6.0, jerk), (-crossing.gap, 1.0))

    def _bent(self, panels: slice, way: float) -> None:
        """Hold y'' at 0 or above, or below it, over some panels."""
        h, change = self.h[panels], self.change[panels]
        self.rows.at_least((way * self.each[panels.start : panels.stop + 1], self.a))
        if h.size:
            self.rows.at_least((way * change, self.v))
            self.rows.at_least((way * change, self.y), (-way * _by(h, self.first[panels]), self.v))
            self.rows.at_least((-way * change, self.y), (way * _by(h, self.last[panels]), self.v))

    def opposes(self, other: "RelaxedMotion", both: float) -> None:
        """At nodes; those of two strokes are the same unless conditions are asked of one alone."""
        if self.h.shape != other.h.shape or np.any(self.h != other.h):
            return
        for own, there, total in ((self.y, other.y, both), (self.v, other.v, 0.0), (self.a, other.a, 0.0)):
            self.rows.zero((self.each, own), (other.each, there), (-total, 1.0))

    def variation(self) -> list[LinearSum]:
        return []

    def area(self) -> list[LinearTerm]:
        return [(self.angle, self.whole)]

    def _area(self, ranges: Ranges) -> None:
        """How far the area below y may be from that below chords, or below cubics of the same ends and slopes."""
        h, sides = self.h, sparse.csr_array(self.h[None] / 2.0 @ self.both)
        chords: list[LinearTerm] = [(1.0, self.whole), (-sides, self.y)]
        bent: list[LinearTerm] = [*chords, (sparse.csr_array(h[None] ** 2 / 12.0 @ self.change), self.v)]
        for order, every in ranges.items():
            for each in every:
                limited = each.times(self.angle**order)
                largest = max(-limited.low, limited.high)
                if order in AREA and isfinite(largest):
                    most = AREA[order] * float(np.sum(h ** (order + 1))) * largest
                    self._within(bent if order == 3 else chords, [(most, limited.unit)])

    def left_over(self) -> None:
        """Between its nodes a motion may add anything."""

    def square(self, order: int) -> list[LinearSum]:
        value, slope = {2: (self.y, self.v), 3: (self.v, self.a)}[order]
        h, change, both = self.h, self.change, self.both
        off = [(_by(np.sqrt(12 / h**3), change), value), (-_by(np.sqrt(3 / h), both), slope)]
        parts: list[list[LinearTerm]] = [[(_by(1 / np.sqrt(h), change), slope)], off]
        if order == 3:
            bent = [(_by(12 / h**2, change), self.y), (-_by(6 / h, both), self.v), (change, self.a)]
            parts.append([(_by(np.sqrt(5 / h), matrix), values) for matrix, values in bent])
        return [times(self.angle ** (0.5 - order), part) for part in parts]


def _by(weights: FloatArray, matrix: Any) -> Any:
    """The rows of a matrix, each times its weight."""
    return sparse.diags_array(weights, format="csr") @ matrix


def _nodes(panels: int, ends: set[float]) -> FloatArray:
    """Equal panels of a unit stroke, cut where conditions start and end, but no equal one next to nothing."""
    plain = np.linspace(0.0, 1.0, panels + 1)[1:-1]
    apart = [x for x in plain if all(abs(x - end) > LEAST_PANEL / panels for end in ends)]
    return np.array(sorted({0.0, 1.0, *apart, *ends}))
