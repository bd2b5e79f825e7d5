"""4-5-6-7 polynomial: s = x⁴(35 − 84x + 70x² − 20x³).

Zero velocity, acceleration and jerk at both ends. Peaks: velocity 35/16, acceleration 84√5/25, jerk 52.5.
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.model.motion.law import fold_to_half

NAME = "poly4567"
TITLE = "4-5-6-7 polynomial"
SOURCE = "Norton, Cam Design and Manufacturing Handbook, ch. 3"
BREAKS = (0.0, 1.0)


def displacement(x: ArrayLike) -> FloatArray:
    near, mirrored = fold_to_half(x)
    s = near**4 * (35.0 + near * (-84.0 + near * (70.0 - 20.0 * near)))
    return np.where(mirrored, 1.0 - s, s)


def velocity(x: ArrayLike) -> FloatArray:
    x = np.asarray(x, dtype=float)
    return 140.0 * (x * (1.0 - x)) ** 3


def acceleration(x: ArrayLike) -> FloatArray:
    x = np.asarray(x, dtype=float)
    return 840.0 * (x * (1.0 - x)) ** 2 * (0.5 - x)


def jerk(x: ArrayLike) -> FloatArray:
    x = np.asarray(x, dtype=float)
    u = x * (1.0 - x)
    return 840.0 * u * (1.0 - 5.0 * u)
