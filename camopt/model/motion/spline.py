"""Laws of the user's own: a B-spline on the unit stroke, given as such or drawn through the points of a table.

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
from camopt.model.motion.law import ByOrder

QUINTIC = 5  # the least odd degree whose spline can rest (v = a = 0) at both ends and keeps the jerk continuous


@dataclass(frozen=True)
class SplineLaw(ByOrder):
    """A clamped B-spline with s(0) = 0 and s(1) = 1; ``sampled`` if it was drawn through the points of a table.

    An inner knot as often as the degree lets the velocity jump, once less the acceleration.
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
    def _derivatives(self) -> list[tuple[FloatArray, FloatArray]]:
        """Knots and coefficients of the spline and its first three derivatives, differenced exactly, rounded once.

        Differences of rounded coefficients cancel: the jerk of a table of 300 points would lose eight digits.
        """
        knots, values = ([Fraction(v) for v in row] for row in (self.knots, self.coefficients))
        found = []
        for degree in range(self.degree, self.degree - 4, -1):
            found.append((np.array(knots, dtype=float), np.array(values, dtype=float)))
            widths = [b - a for a, b in zip(knots[1:], knots[degree + 1 : -1], strict=False)]
            steps = [b - a for a, b in pairwise(values)]
            values = [degree * s / w if w else Fraction(0) for s, w in zip(steps, widths, strict=True)]
            knots = knots[1:-1]
        return found

    def _derivative(self, x: ArrayLike, order: int) -> FloatArray:
        """A derivative by de Boor's algorithm: steps between coefficients, which keep the digits."""
        (knots, values), degree, x = self._derivatives[order], self.degree - order, np.asarray(x, dtype=float)
        k = np.clip(np.searchsorted(knots, x, side="right") - 1, degree, values.size - 1)
        place = k - degree + np.arange(degree + 1).reshape(-1, *([1] * x.ndim))
        found: FloatArray = values[place]
        for level in range(1, degree + 1):
            left, right = knots[place[level:]], knots[place[level:] + degree + 1 - level]
            found = found[:-1] + (x - left) / (right - left) * (found[1:] - found[:-1])
        result: FloatArray = found[0]
        return result


class EndCondition(Enum):
    """What the law of a table does at an end; its value is which derivatives are zero there."""

    REST = (1, 2)
    """No velocity and no acceleration."""
    REVERSAL = (1, 3)
    """No velocity; the acceleration is that of the least ∫ s‴²."""
    FREE = (3, 4)
    """Velocity and acceleration are those of the least ∫ s‴²."""

    @property
    def level(self) -> int:
        """How many of the coefficients are the same as the one at the end: one more than the first derivatives."""
        return 1 + sum(order == place for place, order in enumerate(self.value, start=1))


@lru_cache(maxsize=64)
def fit_table_spline(
    name: str,
    x: tuple[float, ...],
    s: tuple[float, ...],
    ends: tuple[EndCondition, EndCondition] = (EndCondition.REST, EndCondition.REST),
) -> SplineLaw:
    """The quintic spline through the points of a table that has the least mean-square jerk with such ends."""
    from scipy.interpolate import make_interp_spline

    zero: Any = tuple([(order, 0.0) for order in end.value] for end in ends)
    spline = make_interp_spline(x, s, k=QUINTIC, bc_type=zero)
    coefficients = spline.c
    at_start, at_end = (end.level for end in ends)
    coefficients[:at_start], coefficients[-at_end:] = 0.0, 1.0  # what zero derivatives mean, without rounding
    return SplineLaw(name, QUINTIC, tuple(spline.t.tolist()), tuple(coefficients.tolist()), sampled=True)
