"""The arithmetic of ``rival.c`` in Python for numba: where there is no C compiler, and a check on it elsewhere."""

from typing import Any

import numba
import numpy as np

NAME = f"numba {numba.__version__}, fastmath"
part = numba.njit(nogil=True, fastmath=True, error_model="numpy", inline="always")


@part
def curvature(s, w, s1, w1, q):
    """Curvature of a pitch curve that moves by (s, w) and turns by q with each radian of the cam."""
    square = s * s + w * w
    return (q * square - (w1 * s - w * s1)) / (square * np.sqrt(square))


@part
def turned(c, cosine, sine):
    """cos and sin of an angle, as (cos, sin) at the front of a tuple, turned by another one."""
    return c[0] * cosine - c[1] * sine, c[1] * cosine + c[0] * sine


@part
def disc_translating(size, roller, offset, arm, centre, face, sense, lift):
    return np.sqrt(max((size + roller) ** 2 - offset**2, 0.0)), sense * offset


@part
def at_disc_translating(c, y, y1, y2, cosine, sine):
    s, w = c[0] + y, y1 - c[1]
    return w / s, curvature(s, w, y1, y2, 1.0)


@part
def disc_translating_flat(size, roller, offset, arm, centre, face, sense, lift):
    return (size,)


@part
def at_disc_translating_flat(c, y, y1, y2, cosine, sine):
    return 0.0, c[0] + y + y2


@part
def disc_oscillating(size, roller, offset, arm, centre, face, sense, lift):
    cosine = (centre**2 + arm**2 - (size + roller) ** 2) / (2.0 * centre * arm)
    return cosine, np.sqrt(max(1.0 - cosine**2, 0.0)), arm, centre, sense


@part
def at_disc_oscillating(c, y, y1, y2, cosine, sine):
    (cosine, sine), arm, centre, sense = turned(c, cosine, sine), c[2], c[3], c[4]
    q, s = 1.0 + sense * y1, centre * sine
    w, w1 = arm * q - centre * cosine, sense * arm * y2 + s * y1
    return w / s, curvature(s, sense * w, centre * cosine * y1, sense * w1, q)


@part
def disc_oscillating_flat(size, roller, offset, arm, centre, face, sense, lift):
    sine = (size - face) / centre
    return np.sqrt(max(1.0 - sine**2, 0.0)), sine, centre, face, sense


@part
def at_disc_oscillating_flat(c, y, y1, y2, cosine, sine):
    (cosine, sine), centre, face = turned(c, cosine, sine), c[2], c[3]
    q = 1.0 + c[4] * y1
    bend = (sine * (2.0 * q - 1.0) * q + cosine * y2) / (q * q * q)
    return face * q / (centre * cosine), face + centre * bend


@part
def cylindrical_translating(size, roller, offset, arm, centre, face, sense, lift):
    return (size,)


@part
def at_cylindrical_translating(c, y, y1, y2, cosine, sine):
    return y1 / c[0], curvature(c[0], -y1, 0.0, -y2, 0.0)


@part
def cylindrical_oscillating(size, roller, offset, arm, centre, face, sense, lift):
    return np.cos(-0.5 * lift), np.sin(-0.5 * lift), size, arm, sense


@part
def at_cylindrical_oscillating(c, y, y1, y2, cosine, sine):
    (cosine, sine), size, arm, sense = turned(c, cosine, sine), c[2], c[3], c[4]
    s, w = size * cosine, arm * y1 + sense * size * sine
    s1, w1 = -size * sine * y1, arm * y2 + sense * s * y1
    return w / s, curvature(s, -w, s1, -w1, -sense * y1)


def work_of(mechanism: str) -> Any:
    """What ``rival.c`` calls ``mechanism_extremes``; compiled when it is first called."""
    prepared, point = globals()[mechanism], globals()[f"at_{mechanism}"]

    @numba.njit(nogil=True, fastmath=True, error_model="numpy")
    def work(sizes, sense, lift, motion, found):
        y, y1, y2, cosine, sine = motion
        for i in range(sizes.shape[0]):
            size, roller, offset, arm, centre, face = sizes[i]
            c = prepared(size, roller, offset, arm, centre, face, sense, lift)
            steepest, least, largest = 0.0, np.finfo(np.float64).max, np.finfo(np.float64).min
            for j in range(y.size):
                tangent, bend = point(c, y[j], y1[j], y2[j], cosine[j], sine[j])
                steepest = max(steepest, abs(tangent))
                least, largest = min(least, bend), max(largest, bend)
            found[i, 0], found[i, 1], found[i, 2] = steepest, least, largest

    return work
