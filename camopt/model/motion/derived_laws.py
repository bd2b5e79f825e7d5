"""Laws made from other laws: skewed, with another zero of the acceleration, and mirrored, run from the other end.

Source: Rothbart, Cam Design Handbook, ch. 3 (skewed curves).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import BoolArray, FloatArray
from camopt.model.motion.law import Law


@dataclass(frozen=True)
class SkewedLaw:
    """A symmetric law S whose acceleration crosses zero at x = c in place of ½; its velocity there is the same.

        s = 2c·S(x/2c) up to c,   s = 1 − 2(1 − c)·S((1 − x)/2(1 − c)) beyond

    The largest acceleration is that of S times 1/2c, the largest deceleration that of S times 1/2(1 − c). For the
    ratio a : d of both, c = d/(a + d). The jerk jumps at c unless the jerk of S is zero in the middle.
    """

    NAME: str
    law: Law
    crossing: float

    @property
    def TITLE(self) -> str:  # noqa: N802
        return f"{self.law.TITLE}, crossing at {self.crossing:g}"

    @property
    def SOURCE(self) -> str:  # noqa: N802
        return self.law.SOURCE

    @cached_property
    def BREAKS(self) -> tuple[float, ...]:  # noqa: N802
        before, after = 2.0 * self.crossing, 2.0 * (1.0 - self.crossing)
        inner = [x for x in self.law.BREAKS if x < 0.5]
        return (*(before * x for x in inner), self.crossing, *(1.0 - after * x for x in reversed(inner)))

    def _map_to_first_half(self, x: ArrayLike) -> tuple[BoolArray, FloatArray, FloatArray]:
        """A mask of x beyond the crossing, the stretch factor there, and x mapped to the first half of S."""
        x = np.asarray(x, dtype=float)
        beyond = x > self.crossing
        stretch = 2.0 * np.where(beyond, 1.0 - self.crossing, self.crossing)
        return beyond, stretch, np.where(beyond, 1.0 - x, x) / stretch

    def displacement(self, x: ArrayLike, /) -> FloatArray:
        beyond, stretch, near = self._map_to_first_half(x)
        s = stretch * self.law.displacement(near)
        return np.where(beyond, 1.0 - s, s)

    def velocity(self, x: ArrayLike, /) -> FloatArray:
        return self.law.velocity(self._map_to_first_half(x)[2])

    def acceleration(self, x: ArrayLike, /) -> FloatArray:
        beyond, stretch, near = self._map_to_first_half(x)
        a = self.law.acceleration(near) / stretch
        return np.where(beyond, -a, a)

    def jerk(self, x: ArrayLike, /) -> FloatArray:
        _, stretch, near = self._map_to_first_half(x)
        return self.law.jerk(near) / stretch**2


@dataclass(frozen=True)
class MirroredLaw:
    """A law S run from its other end: s = 1 − S(1 − x).

    Near the start s has the rounding error of a whole stroke.
    """

    NAME: str
    law: Law

    @property
    def TITLE(self) -> str:  # noqa: N802
        return f"{self.law.TITLE}, mirrored"

    @property
    def SOURCE(self) -> str:  # noqa: N802
        return self.law.SOURCE

    @cached_property
    def BREAKS(self) -> tuple[float, ...]:  # noqa: N802
        return tuple(1.0 - x for x in reversed(self.law.BREAKS))

    def displacement(self, x: ArrayLike, /) -> FloatArray:
        return 1.0 - self.law.displacement(1.0 - np.asarray(x, dtype=float))

    def velocity(self, x: ArrayLike, /) -> FloatArray:
        return self.law.velocity(1.0 - np.asarray(x, dtype=float))

    def acceleration(self, x: ArrayLike, /) -> FloatArray:
        return -self.law.acceleration(1.0 - np.asarray(x, dtype=float))

    def jerk(self, x: ArrayLike, /) -> FloatArray:
        return self.law.jerk(1.0 - np.asarray(x, dtype=float))
