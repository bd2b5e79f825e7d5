"""Half harmonic H-2, from constant velocity to a reversal: s = sin(πx/2).

The second half of a simple harmonic motion: H-1 from its other end. It starts with the velocity π/2 and no
acceleration, and ends with its largest deceleration, π²/4.
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray

NAME = "half-harmonic-2"
TITLE = "half harmonic H-2"
SOURCE = "Kloomok & Muffley, Product Engineering, Feb. 1955; Rothbart, Cam Design Handbook, ch. 3"
BREAKS = (0.0, 1.0)


def displacement(x: ArrayLike) -> FloatArray:
    return np.sin(np.pi / 2 * np.asarray(x, dtype=float))


def velocity(x: ArrayLike) -> FloatArray:
    return np.pi / 2 * np.sin(np.pi / 2 * (1.0 - np.asarray(x, dtype=float)))


def acceleration(x: ArrayLike) -> FloatArray:
    return -(np.pi**2) / 4 * np.sin(np.pi / 2 * np.asarray(x, dtype=float))


def jerk(x: ArrayLike) -> FloatArray:
    return -(np.pi**3) / 8 * np.sin(np.pi / 2 * (1.0 - np.asarray(x, dtype=float)))
