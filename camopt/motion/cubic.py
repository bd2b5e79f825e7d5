"""Cubic (2-3 polynomial): s = x²(3 − 2x).

Zero velocity at both ends. Peaks: velocity 1.5, acceleration 6 (at the ends, where it jumps).
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.motion.law import folded
from camopt.numerics import FloatArray

NAME = "cubic"
TITLE = "cubic (2-3 polynomial)"
SOURCE = "Rothbart, Cam Design Handbook, ch. 3"
BREAKS = (0.0, 1.0)


def displacement(x: ArrayLike) -> FloatArray:
    near, mirrored = folded(x)
    s = near**2 * (3.0 - 2.0 * near)
    return np.where(mirrored, 1.0 - s, s)


def velocity(x: ArrayLike) -> FloatArray:
    x = np.asarray(x, dtype=float)
    return 6.0 * x * (1.0 - x)


def acceleration(x: ArrayLike) -> FloatArray:
    return 12.0 * (0.5 - np.asarray(x, dtype=float))


def jerk(x: ArrayLike) -> FloatArray:
    return np.full_like(np.asarray(x, dtype=float), -12.0)
