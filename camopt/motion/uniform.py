"""Uniform velocity: s = x.

The follower starts and stops at full speed: the velocity jumps at both ends, so the acceleration there is an
impulse. A knife edge can follow the corner; a roller cannot (the convex corner undercuts).
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.numerics import FloatArray

NAME = "uniform"
TITLE = "uniform velocity"
SOURCE = "Khurmi & Gupta, Theory of Machines, ch. 20"
BREAKS = (0.0, 1.0)


def displacement(x: ArrayLike) -> FloatArray:
    return np.array(x, dtype=float)


def velocity(x: ArrayLike) -> FloatArray:
    return np.ones_like(displacement(x))


def acceleration(x: ArrayLike) -> FloatArray:
    return np.zeros_like(displacement(x))


def jerk(x: ArrayLike) -> FloatArray:
    return np.zeros_like(displacement(x))
