"""Double harmonic: s = ½(1 − cos πx) − ⅛(1 − cos 2πx) = sin⁴(πx/2).

It starts smoothly (zero acceleration and jerk) and stops hard: the acceleration at the end is −π². It suits a rise
that a return follows at once. Peaks: velocity 3√3π/8, acceleration π² (at the end, where it jumps).
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray

NAME = "double-harmonic"
TITLE = "double harmonic"
SOURCE = "Rothbart, Cam Design Handbook, ch. 3"
BREAKS = (0.0, 1.0)


def displacement(x: ArrayLike) -> FloatArray:
    return np.sin(np.pi / 2 * np.asarray(x, dtype=float)) ** 4


def velocity(x: ArrayLike) -> FloatArray:
    x = np.asarray(x, dtype=float)
    return 2 * np.pi * np.sin(np.pi / 2 * x) ** 3 * np.sin(np.pi / 2 * (1.0 - x))


def acceleration(x: ArrayLike) -> FloatArray:
    square = np.sin(np.pi / 2 * np.asarray(x, dtype=float)) ** 2
    return np.pi**2 * square * (3.0 - 4.0 * square)


def jerk(x: ArrayLike) -> FloatArray:
    x = np.asarray(x, dtype=float)
    rise, rest = np.sin(np.pi / 2 * x), np.sin(np.pi / 2 * (1.0 - x))
    return np.pi**3 * rise * rest * (3.0 - 8.0 * rise**2)
