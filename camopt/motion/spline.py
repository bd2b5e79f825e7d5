"""Laws of the user's own: a B-spline on the unit stroke, given as such or drawn through the points of a table.

Source: de Boor, A Practical Guide to Splines, ch. IX–XIII.
"""

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from camopt.motion.law import ByOrder
from camopt.numerics import FloatArray

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

    def _at(self, x: ArrayLike, order: int) -> FloatArray:
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


REST: Any = [(1, 0.0), (2, 0.0)]  # derivatives at an end that rests: zero velocity and acceleration
NATURAL: Any = [(3, 0.0), (4, 0.0)]  # at one that does not: those of the least ∫ s‴²


@lru_cache(maxsize=64)
def tabulated(
    name: str, x: tuple[float, ...], s: tuple[float, ...], rest: tuple[bool, bool] = (True, True)
) -> SplineLaw:
    """The quintic spline through the points of a table: at rest at an end, or of the least mean-square jerk."""
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(x, s, k=QUINTIC, bc_type=tuple(REST if each else NATURAL for each in rest))
    coefficients = spline.c
    at_start, at_end = (1 + len(REST) * each for each in rest)
    coefficients[:at_start], coefficients[-at_end:] = 0.0, 1.0  # which is what rest means, without rounding
    return SplineLaw(name, QUINTIC, tuple(spline.t.tolist()), tuple(coefficients.tolist()), sampled=True)
