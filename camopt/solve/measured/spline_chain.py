"""A quintic spline whose coefficients are variables together with those of its derivatives up to the jerk.

Coefficients of a spline on n points give its jerk with a factor of n³, which a solver's rounding does not survive.
So c₀ … c₃ of y … y''' are variables together. Their relation cₖ₊₁ = (5 − k)·Δcₖ/Δt has a factor of n only.

The motion of least ∫ (y''')² dθ within a band of points is such a spline, with knots at the points (theorems of
Reinsch for smoothing splines and of Laurent for convex sets).

Source: de Boor, A Practical Guide to Splines, ch. IX, X and XIV; Laurent, Approximation et optimisation, ch. IV.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.interpolate import BSpline

from camopt.core.numerics import FloatArray

CHAIN_DEGREE, JOINED_ORDERS = 5, 4


@dataclass(frozen=True)
class SplineChain:
    """Clamped quintic splines on 0 ≤ x ≤ 1 with single inner knots."""

    inner_knots: tuple[float, ...]

    @property
    def clamped_knot_vector(self) -> FloatArray:
        ends = CHAIN_DEGREE + 1
        return np.concatenate([np.zeros(ends), self.inner_knots, np.ones(ends)])

    @property
    def coefficient_count(self) -> int:
        """Number of coefficients of the spline itself; each derivative has one less."""
        return len(self.inner_knots) + CHAIN_DEGREE + 1

    @cached_property
    def difference_factors(self) -> list[FloatArray]:
        """Δt/(5 − k): factors from cₖ₊₁ to the differences of cₖ."""
        inside = [
            self.clamped_knot_vector[1 + k : self.clamped_knot_vector.size - 1 - k]
            for k in range(JOINED_ORDERS - 1)
        ]
        degrees = [CHAIN_DEGREE - k for k in range(JOINED_ORDERS - 1)]
        return [(t[p:] - t[:-p]) / p for t, p in zip(inside, degrees, strict=True)]

    def value_matrix(self, x: ArrayLike, order: int = 0) -> sparse.csr_array:
        """Matrix from the coefficients of a derivative to its values at x."""
        knots = self.clamped_knot_vector[order : self.clamped_knot_vector.size - order]
        return BSpline.design_matrix(x, knots, CHAIN_DEGREE - order, extrapolate=True)

    @cached_property
    def jerk_norm_matrix(self) -> sparse.csr_array:
        """Matrix W with |W·c₃|² = ∫ (y''')² dx, by Gauss's rule, which is exact here."""
        nodes, weights = np.polynomial.legendre.leggauss(CHAIN_DEGREE - 2)
        ends = np.array([0.0, *self.inner_knots, 1.0])
        half = np.diff(ends)[:, None] / 2
        x = (ends[:-1, None] + half * (1.0 + nodes)).ravel()
        return sparse.csr_array(sparse.diags_array(np.sqrt(half * weights).ravel()) @ self.value_matrix(x, 3))

    def integrate_jerk(self, jerk: FloatArray, start_state: tuple[float, float, float]) -> list[FloatArray]:
        """c₀ … c₃ from c₃ and from y, y', y'' at x = 0; for several columns of ``jerk`` at once."""
        coefficients = [jerk]
        for k in reversed(range(JOINED_ORDERS - 1)):
            steps = self.difference_factors[k].reshape(-1, *(1,) * (jerk.ndim - 1)) * coefficients[0]
            first = np.full_like(steps[:1], start_state[k])
            coefficients.insert(0, np.concatenate([first, first + np.cumsum(steps, axis=0)]))
        return coefficients

    def adjust_jerk_to_end_state(
        self, jerk: FloatArray, start_state: tuple[float, float, float], end_state: FloatArray
    ) -> FloatArray:
        """c₃ with the least change that leads from y, y', y'' at x = 0 to those at x = 1."""
        error = end_state - np.array([c[-1] for c in self.integrate_jerk(jerk, start_state)[:-1]])
        responses = np.array([c[-1] for c in self.integrate_jerk(np.eye(jerk.size), (0.0, 0.0, 0.0))[:-1]])
        return np.asarray(jerk + np.linalg.lstsq(responses, error, rcond=None)[0])
