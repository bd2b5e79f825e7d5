"""Modified trapezoid: a trapezoidal acceleration whose ramps are quarter sines.

On the first half, with A = 8π/(2 + π): a = A·sin 4πx up to x = 1/8, a = A up to 3/8, then
a = A·cos 4π(x − 3/8). Peaks: velocity 2, acceleration A = 4.8881, jerk 4πA = 61.426.
"""

import numpy as np
from numpy.typing import ArrayLike

from camopt.motion.law import folded
from camopt.numerics import FloatArray
from camopt.numerics.stable import angle_minus_sine

NAME = "modified-trapezoid"
TITLE = "modified trapezoid"
SOURCE = "Norton, Cam Design and Manufacturing Handbook, ch. 3"
BREAKS = (0.0, 0.125, 0.375, 0.625, 0.875, 1.0)

_A = 8 * np.pi / (2 + np.pi)
_W = 4 * np.pi
_V1, _S1 = 1 / _W, (np.pi / 2 - 1) / _W**2  # v/A and s/A at x = 1/8
_V2, _S2 = _V1 + 0.25, _S1 + _V1 / 4 + 1 / 32  # and at x = 3/8


def _piecewise(near: FloatArray, ramp: FloatArray, flat: FloatArray, fall: FloatArray) -> FloatArray:
    return _A * np.where(near < 0.125, ramp, np.where(near < 0.375, flat, fall))


def displacement(x: ArrayLike) -> FloatArray:
    near, mirrored = folded(x)
    d, e = near - 0.125, near - 0.375
    fall = _S2 + _V2 * e + 2 * np.sin(_W / 2 * e) ** 2 / _W**2
    s = _piecewise(near, angle_minus_sine(_W * near) / _W**2, _S1 + _V1 * d + d * d / 2, fall)
    return np.where(mirrored, 1.0 - s, s)


def velocity(x: ArrayLike) -> FloatArray:
    near, _ = folded(x)
    ramp = 2 * np.sin(_W / 2 * near) ** 2 / _W
    return _piecewise(near, ramp, _V1 + (near - 0.125), _V2 + np.sin(_W * (near - 0.375)) / _W)


def acceleration(x: ArrayLike) -> FloatArray:
    near, mirrored = folded(x)
    a = _piecewise(near, np.sin(_W * near), np.ones_like(near), np.sin(_W * (0.5 - near)))
    return np.where(mirrored, -a, a)


def jerk(x: ArrayLike) -> FloatArray:
    near, _ = folded(x)
    return _piecewise(near, _W * np.cos(_W * near), np.zeros_like(near), -_W * np.cos(_W * (0.5 - near)))
