"""5-6-7-8-9 polynomial: s = x⁵(126 − 420x + 540x² − 315x³ + 70x⁴).

Zero derivatives up to the fourth at both ends; v = 630 x⁴(1−x)⁴. Peaks: velocity 315/128, acceleration 9.372,
jerk 78.75.
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.model.motion.law import fold_to_half

NAME = "poly56789"
TITLE = "5-6-7-8-9 polynomial"
SOURCE = "Rothbart, Cam Design Handbook, ch. 3 (polynomials by boundary conditions)"
BREAKS = (0.0, 1.0)


def displacement(x: ArrayLike) -> FloatArray:
    near, mirrored = fold_to_half(x)
    s = near**5 * (126.0 + near * (-420.0 + near * (540.0 + near * (-315.0 + 70.0 * near))))
    return np.where(mirrored, 1.0 - s, s)


def velocity(x: ArrayLike) -> FloatArray:
    x = np.asarray(x, dtype=float)
    return 630.0 * (x * (1.0 - x)) ** 4


def acceleration(x: ArrayLike) -> FloatArray:
    x = np.asarray(x, dtype=float)
    return 5040.0 * (x * (1.0 - x)) ** 3 * (0.5 - x)


def jerk(x: ArrayLike) -> FloatArray:
    x = np.asarray(x, dtype=float)
    u = x * (1.0 - x)
    return 2520.0 * u * u * (3.0 - 14.0 * u)
