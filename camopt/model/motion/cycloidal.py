"""Cycloidal motion: s = x − sin(2πx)/(2π).

Peak velocity 2, peak acceleration 2π, peak jerk 4π²; the acceleration is continuous, the jerk jumps at the ends.
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.core.numerics.stable_functions import angle_minus_sine
from camopt.model.motion.law import fold_to_half

NAME = "cycloidal"
TITLE = "cycloidal"
SOURCE = "Norton, Cam Design and Manufacturing Handbook, ch. 3"
BREAKS = (0.0, 1.0)


def displacement(x: ArrayLike) -> FloatArray:
    near, mirrored = fold_to_half(x)
    s = angle_minus_sine(2 * np.pi * near) / (2 * np.pi)
    return np.where(mirrored, 1.0 - s, s)


def velocity(x: ArrayLike) -> FloatArray:
    return 2.0 * np.sin(np.pi * fold_to_half(x)[0]) ** 2


def acceleration(x: ArrayLike) -> FloatArray:
    near, mirrored = fold_to_half(x)
    a = 2 * np.pi * np.sin(2 * np.pi * near)
    return np.where(mirrored, -a, a)


def jerk(x: ArrayLike) -> FloatArray:
    return 4 * np.pi**2 * np.cos(2 * np.pi * fold_to_half(x)[0])
