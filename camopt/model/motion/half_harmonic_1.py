"""Half harmonic H-1, from a reversal to constant velocity: s = 1 − cos(πx/2).

The first half of a simple harmonic motion. It starts with its largest acceleration, π²/4, and ends with the
velocity π/2 and no acceleration.
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.model.motion.law import fold_to_half

NAME = "half-harmonic-1"
TITLE = "half harmonic H-1"
SOURCE = "Kloomok & Muffley, Product Engineering, Feb. 1955; Rothbart, Cam Design Handbook, ch. 3"
BREAKS = (0.0, 1.0)


def displacement(x: ArrayLike) -> FloatArray:
    near, mirrored = fold_to_half(x)
    return np.where(mirrored, 1.0 - np.sin(np.pi / 2 * near), 2.0 * np.sin(np.pi / 4 * near) ** 2)


def velocity(x: ArrayLike) -> FloatArray:
    return np.pi / 2 * np.sin(np.pi / 2 * np.asarray(x, dtype=float))


def acceleration(x: ArrayLike) -> FloatArray:
    return np.pi**2 / 4 * np.sin(np.pi / 2 * (1.0 - np.asarray(x, dtype=float)))


def jerk(x: ArrayLike) -> FloatArray:
    return -(np.pi**3) / 8 * np.sin(np.pi / 2 * np.asarray(x, dtype=float))
