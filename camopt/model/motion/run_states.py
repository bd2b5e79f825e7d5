"""The states of a run of moves at its cuts that have the least integral within linear limits (``move_run``)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import perm
from typing import NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import BoolArray, FloatArray, IntArray
from camopt.core.numerics.quadratic import (
    constrained_least_squares,
    least_relative_violation,
    shortest_solution_and_null_space,
)

SINGLE_NUMBER = 1e-12  # of the run's largest number: ranges no wider than this are single numbers
CERTAIN_MISS = 1e-5  # of the numbers of a limit: if every state misses one by more, none exists


class LimitRows(NamedTuple):
    """Linear limits on the states: ``rows`` @ states ≥ ``least``, or equal to it if ``equal``."""

    rows: FloatArray
    least: FloatArray
    equal: bool


@dataclass(frozen=True)
class AllowedMoveStates:
    """States at cuts (joints, orders) within ranges and limits; in a ``closed`` run the last joint is the first."""

    low: FloatArray
    high: FloatArray
    limits: Sequence[LimitRows]
    angles: FloatArray
    closed: bool

    @property
    def is_empty(self) -> bool:
        """Whether any range is empty."""
        return bool(np.any(self.low > self.high))

    def smoothest_allowed_states(self) -> FloatArray | None:
        """The states of the least integral that meet all limits, or None."""
        if self.is_empty:
            return None
        size = 1.0 / np.linalg.norm(self.integral_square_root_matrix[:, self.free_number_index], axis=0)
        (same, values), (rows, least) = (self._free_number_limits(equal) for equal in (True, False))
        solutions = shortest_solution_and_null_space(same * size, values, self.largest_scaled_range_end)
        if solutions is None:
            return None
        (start, basis), factor = solutions, self.integral_square_root_matrix[:, self.free_number_index] * size
        offset, rows = self.integral_square_root_matrix @ self.fixed_numbers + factor @ start, rows * size
        best = constrained_least_squares(
            factor @ basis, offset, rows @ basis, least - rows @ start, self.largest_scaled_range_end
        )
        if best is None:
            return None
        low, high = self.scaled_number_ranges
        states, free = self.fixed_numbers, self.free_number_index
        states[free] = np.clip(size * (start + basis @ best), low[free], high[free])
        numbers = states[self.number_index_by_joint_and_order.ravel()] / self._scale_factors_by_order
        return np.asarray(numbers.reshape(self.low.shape))

    def are_proved_impossible(self) -> bool:
        """Whether all states miss a limit by more than the error of a solver."""
        if self.is_empty:
            return True
        size = 1.0 / np.linalg.norm(self.integral_square_root_matrix[:, self.free_number_index], axis=0)
        (same, values), (rows, least) = (self._free_number_limits(equal) for equal in (True, False))
        return least_relative_violation(rows * size, least, same * size, values) > CERTAIN_MISS

    @property
    def _scale_factors_by_order(self) -> FloatArray:
        """Factors that bring numbers of all orders to one scale."""
        joints, count = self.low.shape
        return np.tile(self.angles.mean() ** np.arange(count), joints)

    @cached_property
    def number_index_by_joint_and_order(self) -> IntArray:
        """Index of each of the states' numbers; the last joint of a closed run has the indices of the first."""
        joints, count = self.low.shape
        place = np.arange(joints * count).reshape(joints, count)
        if self.closed:
            place[-1, 1:] = place[0, 1:]
        return place

    @cached_property
    def integral_square_root_matrix(self) -> FloatArray:
        """Matrix from the numbers to a vector whose square is the integral."""
        count = self.low.shape[1]
        factor = np.zeros((self.angles.size * count, self.number_index_by_joint_and_order.size))
        for i, share in enumerate(self.angles / self.angles.mean()):
            powers = np.tile(share ** np.arange(count), 2)
            rows = factor[i * count : (i + 1) * count]
            np.add.at(
                rows.T,
                self.number_index_by_joint_and_order[i : i + 2].ravel(),
                (_unit_integral_square_root_matrix(count) * powers).T,
            )
            rows *= share ** (0.5 - count)
        return factor

    @cached_property
    def scaled_number_ranges(self) -> tuple[FloatArray, FloatArray]:
        return self.low.ravel() * self._scale_factors_by_order, self.high.ravel() * self._scale_factors_by_order

    @property
    def largest_scaled_range_end(self) -> float:
        return float(np.abs(np.nan_to_num(self.scaled_number_ranges, posinf=0.0, neginf=0.0)).max())

    @cached_property
    def is_number_fixed(self) -> BoolArray:
        low, high = self.scaled_number_ranges
        return np.asarray(high - low <= SINGLE_NUMBER * self.largest_scaled_range_end)

    @property
    def fixed_numbers(self) -> FloatArray:
        """The fixed numbers; 0 for others."""
        return np.where(self.is_number_fixed, self.scaled_number_ranges[0], 0.0)

    @cached_property
    def free_number_index(self) -> IntArray:
        return np.unique(self.number_index_by_joint_and_order.ravel()[~self.is_number_fixed])

    def _free_number_limits(self, only_equalities: bool) -> tuple[FloatArray, FloatArray]:
        """Linear limits on the free numbers, as rows and their least (or equal) values; ranges are among them."""
        limits = [limit for limit in self.limits if limit.equal == only_equalities]
        spread = np.eye(self.number_index_by_joint_and_order.size)[
            self.number_index_by_joint_and_order.ravel()
        ]  # from distinct numbers to all numbers of the states
        rows = np.concatenate(
            [np.empty((0, self.number_index_by_joint_and_order.size)), *(limit.rows for limit in limits)]
        )
        rows = rows / self._scale_factors_by_order @ spread
        least = np.concatenate([np.empty(0), *(limit.least for limit in limits)]) - rows @ self.fixed_numbers
        rows = rows[:, self.free_number_index]
        low, high = (end[self.free_number_index] for end in self.scaled_number_ranges)
        for side, end in () if only_equalities else ((1.0, low), (-1.0, -high)):
            bounded = np.isfinite(end)
            rows = np.concatenate([rows, side * np.eye(self.free_number_index.size)[bounded]])
            least = np.concatenate([least, end[bounded]])
        return rows, least


@cache
def _unit_integral_square_root_matrix(numbers_per_state: int) -> FloatArray:
    """Matrix from p, p', … at 0 and at 1 to a vector with the square ∫₀¹ (p⁽ᵏ⁾)² dx.

    k is ``numbers_per_state``, and the polynomial p has the degree 2k − 1.
    """
    orders, degrees = range(numbers_per_state), range(2 * numbers_per_state)
    ends = [[perm(n, k) * x ** max(n - k, 0) for n in degrees] for x in (0, 1) for k in orders]
    powers = np.linalg.inv(np.array(ends, dtype=float))  # in a column one of these derivatives is 1, the others 0
    nodes, weights = np.polynomial.legendre.leggauss(numbers_per_state)
    values = polynomial.polyval((nodes + 1) / 2, polynomial.polyder(powers, numbers_per_state))
    return np.asarray((values * np.sqrt(weights / 2)).T)
