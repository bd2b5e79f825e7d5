"""Polynomials from boundary conditions: displacement, velocity, acceleration … at both ends of a stroke.

    uniform      s = x
    cubic        s = x²(3 − 2x)
    poly8        s = 6.09755x³ − 20.7804x⁵ + 26.73155x⁶ − 13.60965x⁷ + 2.56095x⁸

With uniform velocity the follower starts and stops at full speed: the velocity jumps at both ends, and the
acceleration there is an impulse. A knife edge can follow such a corner; a roller cannot, because the convex corner
undercuts. The cubic has zero velocity at its ends; its peaks are 1.5 of velocity and 6 of acceleration (at the
ends, where it jumps). The eighth-power polynomial is for a rise that a return follows at once.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 3 (polynomial functions); the Bernstein form is that of
Farin, Curves and Surfaces for CAGD, ch. 5.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from math import comb, perm
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.model.motion.law import LawByOrder

HIGHEST_DEGREE = 12  # the panels of a motion hold polynomials up to this degree without error


@dataclass(frozen=True)
class PolynomialLaw(LawByOrder):
    """The polynomial of least degree with given s, s', s'', … at x = 0 (``start``) and at x = 1 (``end``).

    Each end may have any number of conditions, both together at most ``HIGHEST_DEGREE`` + 1; s(1) may be any
    number. The Bernstein coefficients follow from the conditions without a system of equations. They are computed
    in rational numbers and rounded once. In this form a derivative that is zero at an end keeps all its digits near
    it.
    """

    NAME: str
    start: tuple[float, ...]
    end: tuple[float, ...]
    TITLE: str = "polynomial"
    SOURCE: str = "the scene"
    BREAKS: ClassVar[tuple[float, ...]] = (0.0, 1.0)

    @property
    def degree(self) -> int:
        return len(self.start) + len(self.end) - 1

    @cached_property
    def _bernstein_terms(self) -> list[FloatArray]:
        """Factors of xᵏ(1 − x)ⁿ⁻ᵏ for k = 0 … n, of s and its first three derivatives."""
        before = _first_bernstein_coefficients(self.start, self.degree)
        after = _first_bernstein_coefficients(
            [(-1.0) ** k * value for k, value in enumerate(self.end)], self.degree
        )
        values, terms = [*before, *reversed(after)], []
        for degree in range(self.degree, self.degree - 4, -1):
            terms.append(np.array([comb(degree, k) * value for k, value in enumerate(values)], dtype=float))
            values = [degree * (b - a) for a, b in pairwise(values)]
        return terms

    def _derivative(self, x: ArrayLike, order: int) -> FloatArray:
        x, terms = np.asarray(x, dtype=float)[..., None], self._bernstein_terms[order]
        power = np.arange(terms.size)
        return np.asarray((terms * x**power * (1.0 - x) ** power[::-1]).sum(axis=-1))


_ROTHBART = "Rothbart, Cam Design Handbook, ch. 3"
uniform = PolynomialLaw("uniform", (0.0,), (1.0,), "uniform velocity", "Khurmi & Gupta, Theory of Machines, ch. 20")
cubic = PolynomialLaw("cubic", (0.0, 0.0), (1.0, 0.0), "cubic (2-3 polynomial)", _ROTHBART)
poly8 = PolynomialLaw(
    "poly8",
    (0.0, 0.0, 0.0, 36.5853, 0.0),
    (1.0, 0.0, -5.2683, 0.0),
    "eighth-power polynomial",
    f"Kloomok & Muffley, Product Engineering, Feb. 1955; {_ROTHBART}",
)


def _first_bernstein_coefficients(derivatives: Iterable[float], degree: int) -> list[Fraction]:
    """The first Bernstein coefficients, one for each derivative at x = 0: Δᵏb₀ = s⁽ᵏ⁾(0)·(n − k)!/n!."""
    steps = [Fraction(value) / perm(degree, k) for k, value in enumerate(derivatives)]
    return [sum((comb(j, k) * steps[k] for k in range(j + 1)), Fraction(0)) for j in range(len(steps))]
