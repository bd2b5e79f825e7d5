"""3-4-5 polynomial: s = x³(10 − 15x + 6x²).

The lowest polynomial with zero velocity and acceleration at both ends. Peaks: velocity 15/8,
acceleration 10/√3, jerk 60 (at the ends, where it jumps).
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.model.motion.law import fold_to_half

NAME = "poly345"
TITLE = "3-4-5 polynomial"
SOURCE = "Norton, Cam Design and Manufacturing Handbook, ch. 3"
BREAKS = (0.0, 1.0)


def displacement(x: ArrayLike) -> FloatArray:
    near, mirrored = fold_to_half(x)
    s = near**3 * (10.0 + near * (-15.0 + 6.0 * near))
    return np.where(mirrored, 1.0 - s, s)


def velocity(x: ArrayLike) -> FloatArray:
    x = np.asarray(x, dtype=float)
    return 30.0 * (x * (1.0 - x)) ** 2


def acceleration(x: ArrayLike) -> FloatArray:
    x = np.asarray(x, dtype=float)
    return 120.0 * x * (1.0 - x) * (0.5 - x)


def jerk(x: ArrayLike) -> FloatArray:
    x = np.asarray(x, dtype=float)
    return 60.0 - 360.0 * x * (1.0 - x)
