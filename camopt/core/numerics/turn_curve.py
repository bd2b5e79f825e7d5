"""Curves over a turn as piecewise polynomials, which can be shifted, sped up, added and enclosed.

A curve has P panels from 0 to 2π and repeats after each turn. On each panel it is a polynomial in u ∈ [−1, 1], so
sums of shifted curves are such curves again, on the panels between the ends of both. Extremes and enclosures are
found from polynomials and never sampled. A curve may jump between panels; both values count as values there.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from math import inf, pi, sqrt
from operator import add
from typing import NamedTuple, Self

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import UNIT_ROUNDOFF, FloatArray, IndexArray
from camopt.core.numerics.interval import Interval
from camopt.core.numerics.panel_series import (
    WORK_ERROR,
    integrate_series,
    multiply_series,
    sum_series,
    turn_integral,
)
from camopt.core.numerics.piecewise import halve_bernstein, powers_to_bernstein_matrix, sign_changes
from camopt.core.numerics.stable_functions import matrix_product

TURN = 2.0 * pi
EQUAL_ENDS = 1e-14 * TURN  # rad: ends of panels that are closer are one end, since sums of angles are rounded
EQUAL_ROOTS = 1e-12  # rad: closer roots are one root, at the end of a panel
EQUAL_SHARE = 1e-9  # extremes of opposite sign that differ by less, relatively, are equal


class CurveExtreme(NamedTuple):
    """The largest or least value of a curve and the angle where it is reached."""

    value: float
    angle: float
    """[rad], from the start of the range to its end."""
    room: float
    """The true extreme differs from ``value`` by at most this much."""


@dataclass(frozen=True, eq=False)
class TurnCurve:
    """A curve over a turn: a polynomial in u ∈ [−1, 1] on each panel.

    Examples
    --------
    >>> import numpy as np
    >>> from camopt.core.numerics.turn_curve import TurnCurve
    >>> saw = TurnCurve(np.array([0.0, np.pi, 2 * np.pi]), np.array([[0.5, 0.5], [0.5, -0.5]]))
    >>> saw.largest().value, (saw + saw.shifted(np.pi)).largest().value
    (1.0, 1.0)
    """

    ends: FloatArray
    """Ends of the panels from 0 to 2π [rad] (P + 1,)."""
    series: FloatArray
    """Coefficients of the powers of u (powers, P)."""
    error: float = 0.0
    """A bound of the error of all values, by rounding and by the polynomials themselves."""

    @classmethod
    def constant(cls, value: float) -> Self:
        """The curve with one value."""
        return cls(np.array([0.0, TURN]), np.array([[value]]))

    @property
    def half_width(self) -> FloatArray:
        """Half the width of each panel [rad]."""
        return np.asarray(0.5 * np.diff(self.ends))

    @property
    def centre(self) -> FloatArray:
        """The middle of each panel [rad]."""
        return np.asarray(0.5 * (self.ends[:-1] + self.ends[1:]))

    @cached_property
    def derivative(self) -> "TurnCurve":
        """The slope of the polynomials by the angle, without jumps; its error is that of rounding only."""
        slopes = polynomial.polyder(self.series) if len(self.series) > 1 else 0.0 * self.series
        magnitudes = np.abs(slopes).sum(axis=0) / self.half_width
        rounding = 8.0 * len(self.series) ** 2 * UNIT_ROUNDOFF * magnitudes.max()
        return TurnCurve(self.ends, slopes / self.half_width, float(rounding))

    def integral_from_start(self) -> "TurnCurve":
        """The integral over the angle from the start of the turn. It repeats only if the mean of the curve is 0."""
        series = integrate_series(self.half_width, self.series)
        error = TURN * self.error + 4.0 * UNIT_ROUNDOFF * series.shape[1] * np.abs(series).sum(axis=0).max()
        return TurnCurve(self.ends, series, float(error))

    @cached_property
    def mean(self) -> float:
        """The mean over the turn; 0 if it is smaller than the error of the curve."""
        mean = float(turn_integral(self.half_width, self.series) / TURN)
        return 0.0 if abs(mean) <= self.error else mean

    @property
    def rms(self) -> float:
        """The root mean square over the turn."""
        return sqrt((self * self).mean)

    def __mul__(self, other: "TurnCurve | float") -> "TurnCurve":
        """The curve times a number, or times another curve."""
        if not isinstance(other, TurnCurve):
            return replace(self, series=self.series * other, error=self.error * abs(other))
        a, b = on_common_panels((self, other))
        series = multiply_series(a.series, b.series)
        most_a, most_b = (float(np.abs(each.series).sum(axis=0).max()) for each in (a, b))
        error = a.error * most_b + b.error * most_a + a.error * b.error
        return TurnCurve(a.ends, series, error + 2.0 * len(series) * UNIT_ROUNDOFF * most_a * most_b)

    __rmul__ = __mul__

    def __add__(self, other: "TurnCurve") -> "TurnCurve":
        a, b = on_common_panels((self, other))
        series = sum_series(a.series, b.series)
        rounding = UNIT_ROUNDOFF * float(np.abs(series).sum(axis=0).max())
        return TurnCurve(a.ends, series, a.error + b.error + rounding)

    def plus_number(self, number: float) -> "TurnCurve":
        """The curve plus a number."""
        return self + TurnCurve.constant(number)

    def shifted(self, start_rad: float) -> "TurnCurve":
        """The curve that starts at an angle [rad]: f(θ − angle)."""
        start = start_rad % TURN
        at = TURN - start  # of this curve, at the angle 0 of the shifted one
        if min(start, at) <= EQUAL_ENDS:
            return self._with_angle_rounding(self, min(start, at))
        whole = self.on_panels(np.union1d(self.ends[np.abs(self.ends - at) > EQUAL_ENDS], [at]))
        first = int(np.searchsorted(whole.ends, at))
        ends = np.concatenate([whole.ends[first:] - at, whole.ends[1 : first + 1] + start])
        ends[0], ends[-1] = 0.0, TURN
        return self._with_angle_rounding(
            TurnCurve(ends, np.concatenate([whole.series[:, first:], whole.series[:, :first]], axis=1), whole.error)
        )

    def sped_up(self, turns: int) -> "TurnCurve":
        """The curve of a part that turns several times in one turn: f(turns·θ)."""
        ends = np.concatenate([[0.0], *((self.ends[1:] + k * TURN) / turns for k in range(turns))])
        return self._with_angle_rounding(TurnCurve(ends, np.tile(self.series, turns), self.error))

    def _with_angle_rounding(
        self, curve: "TurnCurve", angle_error_rad: float = 4.0 * UNIT_ROUNDOFF * TURN
    ) -> "TurnCurve":
        """A curve with room for the rounding of its angles [rad]."""
        slope = np.abs(polynomial.polyder(curve.series)).sum(axis=0) / curve.half_width
        return replace(curve, error=curve.error + float(angle_error_rad * slope.max()))

    def on_panels(self, panel_ends: FloatArray) -> "TurnCurve":
        """The same curve on smaller panels, none of which crosses an end of a panel of this curve."""
        if np.array_equal(panel_ends, self.ends):
            return self
        low, high = panel_ends[:-1], panel_ends[1:]
        panel = self._panels_at(0.5 * (low + high))
        centre, half = self.centre[panel], self.half_width[panel]
        middle, scale = (0.5 * (low + high) - centre) / half, 0.5 * (high - low) / half
        series = compose_with_line(self.series[:, panel], middle, scale)
        magnitude = float(np.abs(self.series).sum(axis=0).max())
        slope = np.abs(polynomial.polyder(self.series)).sum(axis=0) / self.half_width
        rounding = 4.0 * len(series) * UNIT_ROUNDOFF * magnitude + EQUAL_ENDS * float(slope.max())
        return TurnCurve(panel_ends, series, self.error + rounding)

    def _panels_at(self, angles: FloatArray) -> IndexArray:
        return np.clip(np.searchsorted(self.ends, angles, side="right") - 1, 0, len(self.ends) - 2)

    def value(self, angles: FloatArray) -> FloatArray:
        """Values at any angles [rad]; where the curve jumps, those after the jump."""
        angles = np.mod(np.asarray(angles, dtype=float), TURN)
        panel = self._panels_at(angles)
        u = (angles - self.centre[panel]) / self.half_width[panel]
        value = np.zeros_like(u)
        for row in self.series[::-1]:
            value = value * u + row[panel]
        return value

    @cached_property
    def _evaluation_error(self) -> float:
        """A bound of the rounding error of a value: of Horner's scheme, and of the angle in it."""
        magnitude = np.abs(self.series).sum(axis=0).max()
        slope = (np.abs(polynomial.polyder(self.series)).sum(axis=0) / self.half_width).max()
        return float(4.0 * UNIT_ROUNDOFF * (len(self.series) * magnitude + TURN * slope))

    @cached_property
    def _panel_ranges(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Least and largest value of each panel, and a bound of the second derivative by u."""
        bernstein = matrix_product(powers_to_bernstein_matrix(len(self.series) - 1), self.series)
        powers = np.arange(len(self.series))
        return (
            bernstein.min(axis=0),
            bernstein.max(axis=0),
            np.abs(self.series * (powers * (powers - 1))[:, None]).sum(axis=0),
        )

    @cached_property
    def _ranges_of_panel_runs(self) -> tuple[list[FloatArray], list[FloatArray]]:
        """Least and largest values of runs of 1, 2, 4 … panels of two turns, by their first panel."""
        low, high, _ = self._panel_ranges
        lows, highs = [np.tile(low, 2)], [np.tile(high, 2)]
        step = 1
        while 2 * step <= len(lows[0]):
            lows.append(np.minimum(lows[-1][:-step], lows[-1][step:]))
            highs.append(np.maximum(highs[-1][:-step], highs[-1][step:]))
            step *= 2
        return lows, highs

    def range_over(self, low: FloatArray, high: FloatArray) -> Interval:
        """Enclosures of the values over ranges of angles [rad], each at most a turn wide."""
        low, high = np.broadcast_arrays(np.asarray(low, dtype=float), np.asarray(high, dtype=float))
        start = np.floor(low / TURN) * TURN
        low, high = low - start, np.minimum(high, low + TURN) - start
        count = self.series.shape[1]
        first = self._panels_at(low)
        after = np.where(high > TURN, high - TURN, high)
        last = np.clip(np.searchsorted(self.ends, after, side="left") - 1, 0, count - 1)
        last = np.where(high > TURN, last + count, np.maximum(last, first))
        one = self._range_over_part(first, low, np.where(first == last, high, inf))
        two = self._range_over_part(last % count, np.where(first == last, low, -inf), after)
        least, most = np.minimum(one.low, two.low), np.maximum(one.high, two.high)
        between = last - first - 1
        lows, highs = self._ranges_of_panel_runs
        for level in range(len(lows)):
            here = between >= 2**level
            here &= between < 2 ** (level + 1) if level < len(lows) - 1 else here
            begin, end = first[here] + 1, last[here] - 2**level
            least[here] = np.minimum(least[here], np.minimum(lows[level][begin], lows[level][end]))
            most[here] = np.maximum(most[here], np.maximum(highs[level][begin], highs[level][end]))
        room = self.error + self._evaluation_error
        return Interval(least - room, most + room)

    def _range_over_part(self, panel: IndexArray, low: FloatArray, high: FloatArray) -> Interval:
        """Enclosures over the parts of panels between two angles, by Taylor's formula in their middles."""
        centre, half = self.centre[panel], self.half_width[panel]
        begin, end = (np.clip((each - centre) / half, -1.0, 1.0) for each in (low, high))
        middle, radius = 0.5 * (begin + end), np.abs(0.5 * (end - begin)) + 4.0 * UNIT_ROUNDOFF
        value = slope = np.zeros_like(middle)
        for row in self.series[::-1]:
            slope = slope * middle + value
            value = value * middle + row[panel]
        least, most, bend = (each[panel] for each in self._panel_ranges)
        room = radius * np.abs(slope) + 0.5 * bend * radius * radius
        return Interval(np.maximum(value - room, least), np.minimum(value + room, most))

    def largest(self, start: float = 0.0, width: float = TURN) -> CurveExtreme:
        """The largest value over a range of angles, and the first angle where it is reached to rounding.

        The range begins at ``start`` and is ``width`` wide [rad], at most a turn.
        """
        curve = self.shifted(-start)
        curve = curve.on_panels(np.union1d(curve.ends[np.abs(curve.ends - width) > EQUAL_ENDS], [0.0, width]))
        panels = int(np.searchsorted(curve.ends, width))
        parts = matrix_product(powers_to_bernstein_matrix(len(curve.series) - 1), curve.series[:, :panels])
        panel, low, high = np.arange(panels), np.full(panels, -1.0), np.ones(panels)
        room = WORK_ERROR * np.abs(parts).max()
        best, angle = -inf, 0.0
        while panel.size:
            ends = parts[[0, -1]]
            most = float(ends.max())
            if most > best + (room if best > -inf else 0.0):
                side, where = divmod(int(np.argmax(ends)), ends.shape[1])
                at = panel[where]
                best, angle = most, float(curve.centre[at] + curve.half_width[at] * (high if side else low)[where])
            above = parts.max(axis=0) > best + room
            middle = 0.5 * (low[above] + high[above])
            panel, low = np.tile(panel[above], 2), np.concatenate([low[above], middle])
            high = np.concatenate([middle, high[above]])
            parts = np.concatenate(halve_bernstein(parts[:, above]), axis=1)
        return CurveExtreme(best, start + angle, float(2.0 * room + curve.error))

    def spans_above(self, level: float) -> list[tuple[float, float]]:
        """The ranges of angles [rad] in which the curve is above a level, in the order of the turn.

        Each starts in the turn; one across the end of the turn ends beyond 2π. A curve that rests at the level is
        not above it.
        """
        series = self.series.copy()
        series[0] -= level
        roots = [self.centre[panel] + self.half_width[panel] * u for panel, u in sign_changes(series)]
        places = np.unique(np.concatenate([self.ends, roots]))
        places = places[np.diff(places, prepend=-inf) > EQUAL_ROOTS]
        above = self.value(0.5 * (places[:-1] + places[1:])) > level
        if above.all():
            return [(0.0, TURN)]
        outward, inward = np.flatnonzero(above & ~np.roll(above, 1)), np.flatnonzero(~above & np.roll(above, 1))
        starts = places[outward]
        later = (places[inward][None, :] - starts[:, None]) % TURN
        return [*zip(starts.tolist(), (starts + later.min(axis=1, initial=TURN)).tolist(), strict=True)]

    def least(self, start: float = 0.0, width: float = TURN) -> CurveExtreme:
        """The least value over a range of angles, as ``largest``."""
        found = (self * -1.0).largest(start, width)
        return found._replace(value=-found.value)


def extreme_of_larger_magnitude(largest: CurveExtreme, least: CurveExtreme) -> CurveExtreme:
    """The extreme of larger magnitude; the largest value if both are equal to rounding."""
    return least if -least.value > largest.value + EQUAL_SHARE * abs(largest.value) else largest


def compose_with_line(series: FloatArray, middle: FloatArray, scale: FloatArray) -> FloatArray:
    """Polynomials (powers, panels) of middle + scale·v, as polynomials of v."""
    result = np.zeros_like(series)
    for row in series[::-1]:
        raised = middle * result
        raised[1:] += scale * result[:-1]
        raised[0] += row
        result = raised
    return result


def on_common_panels(curves: Sequence[TurnCurve]) -> list[TurnCurve]:
    """The curves on the panels between all their ends."""
    ends = np.unique(np.concatenate([curve.ends for curve in curves]))
    ends = ends[np.diff(ends, prepend=-inf) > EQUAL_ENDS]
    ends[-1] = TURN
    return [curve.on_panels(ends) for curve in curves]


def sum_curves(curves: Sequence[TurnCurve]) -> TurnCurve:
    """The sum of curves; 0 without any."""
    return reduce(add, curves, TurnCurve.constant(0.0))
