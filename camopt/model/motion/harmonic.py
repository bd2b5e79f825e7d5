"""Simple harmonic motion: s = (1 − cos πx)/2 = sin²(πx/2).

Peak velocity π/2, peak acceleration π²/2; the acceleration jumps at both ends.
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.model.motion.law import fold_to_half

NAME = "harmonic"
TITLE = "simple harmonic"
SOURCE = "Khurmi & Gupta, Theory of Machines, ch. 20"
BREAKS = (0.0, 1.0)


def displacement(x: ArrayLike) -> FloatArray:
    near, mirrored = fold_to_half(x)
    s = np.sin(np.pi / 2 * near) ** 2
    return np.where(mirrored, 1.0 - s, s)


def velocity(x: ArrayLike) -> FloatArray:
    return np.pi / 2 * np.sin(np.pi * fold_to_half(x)[0])


def acceleration(x: ArrayLike) -> FloatArray:
    # cos πx = sin π(½ − x): full digits at mid-stroke, where it passes through zero
    return np.pi**2 / 2 * np.sin(np.pi * (0.5 - np.asarray(x, dtype=float)))


def jerk(x: ArrayLike) -> FloatArray:
    return -(np.pi**3) / 2 * np.sin(np.pi * fold_to_half(x)[0])
