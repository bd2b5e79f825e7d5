"""Modified sine: a quarter sine of period 1/2 at each end, joined by a half sine of period 3/2.

On the first half, with A = 4π²/(4 + π): a = A·sin 4πx up to x = 1/8, then a = A·cos (4π/3)(x − 1/8).
Peaks: velocity 4π/(4 + π) = 1.7596, acceleration A = 5.5280, jerk 4πA = 69.466 (at the ends).
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.motion.law import folded
from camopt.numerics import FloatArray
from camopt.numerics.stable import angle_minus_sine

NAME = "modified-sine"
TITLE = "modified sine"
SOURCE = "Norton, Cam Design and Manufacturing Handbook, ch. 3"
BREAKS = (0.0, 0.125, 0.875, 1.0)

_A = 4 * np.pi**2 / (4 + np.pi)
_W = 4 * np.pi
_V = 4 * np.pi / 3  # of the slow sine in the middle
_V1, _S1 = 1 / _W, (np.pi / 2 - 1) / _W**2  # v/A and s/A at x = 1/8


def displacement(x: ArrayLike) -> FloatArray:
    near, mirrored = folded(x)
    d = near - 0.125
    middle = _S1 + _V1 * d + 2 * np.sin(_V / 2 * d) ** 2 / _V**2
    s = _A * np.where(near < 0.125, angle_minus_sine(_W * near) / _W**2, middle)
    return np.where(mirrored, 1.0 - s, s)


def velocity(x: ArrayLike) -> FloatArray:
    near, _ = folded(x)
    ramp = 2 * np.sin(_W / 2 * near) ** 2 / _W
    return _A * np.where(near < 0.125, ramp, _V1 + np.sin(_V * (near - 0.125)) / _V)


def acceleration(x: ArrayLike) -> FloatArray:
    near, mirrored = folded(x)
    a = _A * np.where(near < 0.125, np.sin(_W * near), np.sin(_V * (0.5 - near)))
    return np.where(mirrored, -a, a)


def jerk(x: ArrayLike) -> FloatArray:
    near, _ = folded(x)
    return _A * np.where(near < 0.125, _W * np.cos(_W * near), -_V * np.cos(_V * (0.5 - near)))
