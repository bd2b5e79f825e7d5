"""The states of a run of moves at its cuts: those of the least integral within linear limits, if there are any."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import perm
from typing import NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import BoolArray, FloatArray, IntArray
from camopt.core.numerics.quadratic import constrained_least_squares, least_violation, solve_equations

SINGLE_NUMBER = 1e-12  # of the run's largest number: ranges no wider are single numbers
CERTAIN_MISS = 1e-5  # of the numbers of a limit: states that must miss one by more do not exist


class LimitRows(NamedTuple):
    """Linear limits on the states, one after another: ``rows`` @ states ≥ ``least``, or equal to it."""

    rows: FloatArray
    least: FloatArray
    equal: bool


@dataclass(frozen=True)
class States:
    """States at cuts (joints, orders) within their ranges and limits; ``closed``, the last joint is the first."""

    low: FloatArray
    high: FloatArray
    along: Sequence[LimitRows]
    angles: FloatArray
    closed: bool

    @property
    def is_empty(self) -> bool:
        """Whether a range has no number."""
        return bool(np.any(self.low > self.high))

    def least_states(self) -> FloatArray | None:
        """The states of the least integral, if any meet all limits."""
        if self.is_empty:
            return None
        size = 1.0 / np.linalg.norm(self.factor[:, self.free_places], axis=0)
        (same, values), (rows, least) = (self._limits(equal) for equal in (True, False))
        solutions = solve_equations(same * size, values, self.largest)
        if solutions is None:
            return None
        (start, others), own = solutions, self.factor[:, self.free_places] * size
        offset, rows = self.factor @ self.fixed_numbers + own @ start, rows * size
        found = constrained_least_squares(own @ others, offset, rows @ others, least - rows @ start, self.largest)
        return None if found is None else self._full_states(size * (start + others @ found))

    def are_impossible(self) -> bool:
        """Whether any states miss a limit by more than a solver can."""
        if self.is_empty:
            return True
        size = 1.0 / np.linalg.norm(self.factor[:, self.free_places], axis=0)
        (same, values), (rows, least) = (self._limits(equal) for equal in (True, False))
        return least_violation(rows * size, least, same * size, values) > CERTAIN_MISS

    @property
    def _order_scale(self) -> FloatArray:
        """What makes numbers of all orders alike."""
        joints, count = self.low.shape
        return np.tile(self.angles.mean() ** np.arange(count), joints)

    @cached_property
    def place(self) -> IntArray:
        """The places of the states' numbers; the last joint of a closed run has those of the first."""
        joints, count = self.low.shape
        place = np.arange(joints * count).reshape(joints, count)
        if self.closed:
            place[-1, 1:] = place[0, 1:]
        return place

    @cached_property
    def factor(self) -> FloatArray:
        """The matrix from the numbers to what has the integral as its square."""
        count = self.low.shape[1]
        factor = np.zeros((self.angles.size * count, self.place.size))
        for i, share in enumerate(self.angles / self.angles.mean()):
            powers = np.tile(share ** np.arange(count), 2)
            rows = factor[i * count : (i + 1) * count]
            np.add.at(rows.T, self.place[i : i + 2].ravel(), (_integral_factor(count) * powers).T)
            rows *= share ** (0.5 - count)
        return factor

    @cached_property
    def number_ranges(self) -> tuple[FloatArray, FloatArray]:
        return self.low.ravel() * self._order_scale, self.high.ravel() * self._order_scale

    @property
    def largest(self) -> float:
        return float(np.abs(np.nan_to_num(self.number_ranges, posinf=0.0, neginf=0.0)).max())

    @cached_property
    def is_fixed(self) -> BoolArray:
        low, high = self.number_ranges
        return np.asarray(high - low <= SINGLE_NUMBER * self.largest)

    @property
    def fixed_numbers(self) -> FloatArray:
        """The numbers that are given, 0 for others."""
        return np.where(self.is_fixed, self.number_ranges[0], 0.0)

    @cached_property
    def free_places(self) -> IntArray:
        return np.unique(self.place.ravel()[~self.is_fixed])

    def _limits(self, equal: bool) -> tuple[FloatArray, FloatArray]:
        """Rows on the free numbers, and what they are at least, or equal to."""
        some = [each for each in self.along if each.equal == equal]
        onto = np.eye(self.place.size)[
            self.place.ravel()
        ]  # to all numbers of the states from those that are chosen
        rows = (
            np.concatenate([np.empty((0, self.place.size)), *(each.rows for each in some)])
            / self._order_scale
            @ onto
        )
        least = np.concatenate([np.empty(0), *(each.least for each in some)]) - rows @ self.fixed_numbers
        rows = rows[:, self.free_places]
        sides = (
            ()
            if equal
            else ((1.0, self.number_ranges[0][self.free_places]), (-1.0, -self.number_ranges[1][self.free_places]))
        )
        for side, end in sides:
            given = np.isfinite(end)
            rows = np.concatenate([rows, side * np.eye(self.free_places.size)[given]])
            least = np.concatenate([least, end[given]])
        return rows, least

    def _full_states(self, numbers: FloatArray) -> FloatArray:
        """The states with free numbers."""
        low, high = self.number_ranges
        states = self.fixed_numbers
        states[self.free_places] = np.clip(numbers, low[self.free_places], high[self.free_places])
        return np.asarray((states[self.place.ravel()] / self._order_scale).reshape(self.low.shape))


@cache
def _integral_factor(count: int) -> FloatArray:
    """From p, p', … at 0 and at 1, what has ∫₀¹ (p⁽ᵏ⁾)² dx as its square, k = ``count``, for p of degree 2k − 1."""
    orders, degrees = range(count), range(2 * count)
    ends = [[perm(n, k) * x ** max(n - k, 0) for n in degrees] for x in (0, 1) for k in orders]
    powers = np.linalg.inv(np.array(ends, dtype=float))  # in a column one of these derivatives is 1, the others 0
    nodes, weights = np.polynomial.legendre.leggauss(count)
    values = polynomial.polyval((nodes + 1) / 2, polynomial.polyder(powers, count))
    return np.asarray((values * np.sqrt(weights / 2)).T)
