"""Laws of the user as B-splines on the unit stroke: given by knots and coefficients, or fitted to a table.

Source: de Boor, A Practical Guide to Splines, ch. IX–XIII.
"""

from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.model.motion.law import LawByOrder

QUINTIC = 5  # the least odd degree with a continuous jerk whose spline can rest (v = a = 0) at both ends


@dataclass(frozen=True)
class SplineLaw(LawByOrder):
    """A clamped B-spline with s(0) = 0 and s(1) = 1; ``sampled`` if it was fitted to the points of a table.

    At an inner knot with the multiplicity of the degree the velocity jumps; with one less, the acceleration.
    """

    NAME: str
    degree: int
    knots: tuple[float, ...]
    coefficients: tuple[float, ...]
    sampled: bool = False
    TITLE: ClassVar[str] = "spline"
    SOURCE: ClassVar[str] = "the scene"

    @cached_property
    def BREAKS(self) -> tuple[float, ...]:  # noqa: N802
        return tuple(dict.fromkeys(self.knots))

    @cached_property
    def _derivative_knots_and_coefficients(self) -> list[tuple[FloatArray, FloatArray]]:
        """Knots and coefficients of the spline and its first three derivatives.

        The differences are exact and rounded once. Differences of rounded coefficients would cancel: the jerk of a
        table of 300 points would lose eight digits.
        """
        knots, values = ([Fraction(v) for v in row] for row in (self.knots, self.coefficients))
        derivatives = []
        for degree in range(self.degree, self.degree - 4, -1):
            derivatives.append((np.array(knots, dtype=float), np.array(values, dtype=float)))
            widths = [b - a for a, b in zip(knots[1:], knots[degree + 1 : -1], strict=False)]
            steps = [b - a for a, b in pairwise(values)]
            values = [degree * s / w if w else Fraction(0) for s, w in zip(steps, widths, strict=True)]
            knots = knots[1:-1]
        return derivatives

    def _derivative(self, x: ArrayLike, order: int) -> FloatArray:
        """A derivative by de Boor's algorithm, as steps between coefficients, which keep the digits."""
        (knots, values), degree, x = (
            self._derivative_knots_and_coefficients[order],
            self.degree - order,
            np.asarray(x, dtype=float),
        )
        k = np.clip(np.searchsorted(knots, x, side="right") - 1, degree, values.size - 1)
        place = k - degree + np.arange(degree + 1).reshape(-1, *([1] * x.ndim))
        points: FloatArray = values[place]
        for level in range(1, degree + 1):
            left, right = knots[place[level:]], knots[place[level:] + degree + 1 - level]
            points = points[:-1] + (x - left) / (right - left) * (points[1:] - points[:-1])
        result: FloatArray = points[0]
        return result


class EndCondition(Enum):
    """The end condition of a table's law; the value has the orders of the derivatives that are zero there."""

    REST = (1, 2)
    """Zero velocity and acceleration."""
    REVERSAL = (1, 3)
    """Zero velocity; the acceleration makes ∫ s‴² least."""
    FREE = (3, 4)
    """Velocity and acceleration make ∫ s‴² least."""


@lru_cache(maxsize=64)
def fit_table_spline(
    name: str,
    x: tuple[float, ...],
    s: tuple[float, ...],
    ends: tuple[EndCondition, EndCondition] = (EndCondition.REST, EndCondition.REST),
) -> SplineLaw:
    """The quintic spline of least mean-square jerk through the points of a table, with these end conditions."""
    from scipy.interpolate import make_interp_spline

    zero: Any = tuple([(order, 0.0) for order in end.value] for end in ends)
    spline = make_interp_spline(x, s, k=QUINTIC, bc_type=zero)
    coefficients = spline.c
    # equal coefficients at each end: 1 plus the number of leading derivatives that are zero
    at_start, at_end = (1 + sum(order == place for place, order in enumerate(end.value, start=1)) for end in ends)
    coefficients[:at_start], coefficients[-at_end:] = 0.0, 1.0  # as zero derivatives require, without rounding
    return SplineLaw(name, QUINTIC, tuple(spline.t.tolist()), tuple(coefficients.tolist()), sampled=True)
