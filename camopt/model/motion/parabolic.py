"""Uniform acceleration and retardation: s = 2x², then 1 − 2(1−x)².

Peak velocity 2, peak acceleration 4 (the least of any law); the acceleration jumps at 0, ½ and 1.
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.model.motion.law import fold_to_half

NAME = "parabolic"
TITLE = "parabolic (uniform acceleration and retardation)"
SOURCE = "Khurmi & Gupta, Theory of Machines, ch. 20"
BREAKS = (0.0, 0.5, 1.0)


def displacement(x: ArrayLike) -> FloatArray:
    near, mirrored = fold_to_half(x)
    return np.where(mirrored, 1.0 - 2.0 * near * near, 2.0 * near * near)


def velocity(x: ArrayLike) -> FloatArray:
    return 4.0 * fold_to_half(x)[0]


def acceleration(x: ArrayLike) -> FloatArray:
    return np.where(fold_to_half(x)[1], -4.0, 4.0)


def jerk(x: ArrayLike) -> FloatArray:
    return np.zeros_like(fold_to_half(x)[0])
