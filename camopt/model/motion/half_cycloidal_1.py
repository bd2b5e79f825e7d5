"""Half cycloidal C-1, from rest to constant velocity: s = x − sin(πx)/π.

The first half of a cycloidal motion. Its velocity is 2 at the end, where the acceleration is zero. Peaks of
acceleration π and of jerk π².
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.core.numerics.stable_functions import angle_minus_sine
from camopt.model.motion.law import fold_to_half

NAME = "half-cycloidal-1"
TITLE = "half cycloidal C-1"
SOURCE = "Kloomok & Muffley, Product Engineering, Feb. 1955; Rothbart, Cam Design Handbook, ch. 3"
BREAKS = (0.0, 1.0)


def displacement(x: ArrayLike) -> FloatArray:
    return angle_minus_sine(np.pi * np.asarray(x, dtype=float)) / np.pi


def velocity(x: ArrayLike) -> FloatArray:
    return 2.0 * np.sin(np.pi / 2 * np.asarray(x, dtype=float)) ** 2


def acceleration(x: ArrayLike) -> FloatArray:
    return np.pi * np.sin(np.pi * fold_to_half(x)[0])


def jerk(x: ArrayLike) -> FloatArray:
    return np.pi**2 * np.sin(np.pi * (0.5 - np.asarray(x, dtype=float)))
