"""Half cycloidal C-2, from constant velocity to rest: s = x + sin(πx)/π.

The second half of a cycloidal motion: C-1 from its other end. Its velocity is 2 at the start, where the
acceleration is zero. Peaks of acceleration π and of jerk π².
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.model.motion.law import fold_to_half

NAME = "half-cycloidal-2"
TITLE = "half cycloidal C-2"
SOURCE = "Kloomok & Muffley, Product Engineering, Feb. 1955; Rothbart, Cam Design Handbook, ch. 3"
BREAKS = (0.0, 1.0)


def displacement(x: ArrayLike) -> FloatArray:
    return np.asarray(x, dtype=float) + np.sin(np.pi * fold_to_half(x)[0]) / np.pi


def velocity(x: ArrayLike) -> FloatArray:
    return 2.0 * np.sin(np.pi / 2 * (1.0 - np.asarray(x, dtype=float))) ** 2


def acceleration(x: ArrayLike) -> FloatArray:
    return -np.pi * np.sin(np.pi * fold_to_half(x)[0])


def jerk(x: ArrayLike) -> FloatArray:
    return -(np.pi**2) * np.sin(np.pi * (0.5 - np.asarray(x, dtype=float)))
