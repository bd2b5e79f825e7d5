"""Tabulated motion for rivals that sample: the laws of the default sweep in closed form, at even cam angles.

Nothing of camopt is used, so that its answers and theirs are independent.
Source of the modified laws: Norton, Cam Design and Manufacturing Handbook, ch. 3; integrated piece by piece.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial
from rival_numpy import LAWS, Array, Motion, Stroke


def parabolic(x: Array) -> Motion:
    late = x > 0.5
    u = np.where(late, 1 - x, x)
    return np.where(late, 1 - 2 * u**2, 2 * u**2), 4 * u, np.where(late, -4.0, 4.0)


def modified_trapezoid(x: Array) -> Motion:
    """Acceleration: a quarter of a sine, constant, a quarter of a cosine; then the same mirrored."""
    late = x > 0.5
    u = np.where(late, 1 - x, x)
    k, top = 4 * np.pi, 8 * np.pi / (2 + np.pi)
    pieces = [u < 1 / 8, u < 3 / 8]
    flat, last = u - 1 / 8, u - 3 / 8
    height = (1 / 8 - 1 / k) / k
    s = np.select(
        pieces,
        [(u - np.sin(k * u) / k) / k, height + flat / k + flat**2 / 2],
        height + 1 / (4 * k) + 1 / 32 + (1 / k + 1 / 4) * last + (1 - np.cos(k * last)) / k**2,
    )
    v = np.select(pieces, [(1 - np.cos(k * u)) / k, 1 / k + flat], 1 / k + 1 / 4 + np.sin(k * last) / k)
    a = np.select(pieces, [np.sin(k * u), np.ones_like(u)], np.cos(k * last))
    return np.where(late, 1 - top * s, top * s), top * v, np.where(late, -top, top) * a


def modified_sine(x: Array) -> Motion:
    """Acceleration: a quarter of a sine, a half of a slower one, and a quarter of the first."""
    k, slow = 4 * np.pi, np.pi / 3 + 4 * np.pi / 3 * x
    pieces = [x < 1 / 8, x < 7 / 8]
    s = np.select(
        pieces,
        [np.pi * x - np.sin(k * x) / 4, 2 + np.pi * x - 9 / 4 * np.sin(slow)],
        4 + np.pi * x - np.sin(k * x) / 4,
    )
    v = np.where(pieces[1] & ~pieces[0], 1 - 3 * np.cos(slow), 1 - np.cos(k * x))
    a = np.where(pieces[1] & ~pieces[0], np.sin(slow), np.sin(k * x))
    return s / (4 + np.pi), np.pi * v / (4 + np.pi), 4 * np.pi**2 * a / (4 + np.pi)


ALL_LAWS: dict[str, Callable[[Array], Motion]] = {
    **LAWS,
    "parabolic": parabolic,
    "modified-trapezoid": modified_trapezoid,
    "modified-sine": modified_sine,
}
Segment = tuple[float, float]
"""Angle in deg, and lift: positive up, negative down, 0 for a dwell."""


def motion_table(law: str, segments: Sequence[Segment], samples: int) -> Array:
    """y, y', y'', cos y and sin y at even angles of each segment with both its ends, (5, about ``samples``)."""
    counts = [max(2, round(samples * angle / 360)) for angle, _ in segments]
    strokes = zip(_strokes(law, segments), counts, strict=True)
    return _table([stroke.motion(np.linspace(0.0, 1.0, count)) for stroke, count in strokes])


def motion_cells(law: str, segments: Sequence[Segment], each: int, terms: int) -> tuple[Array, Array]:
    """The motion at samples, and as polynomials in eighths of the strokes, where all laws have their joints.

    The samples are rows as those of ``motion_table``, ``each`` of them in a cell, and one of each dwell after them.
    The polynomials are as ``rival.c`` takes them, (cells, 1 + ``terms``).
    """
    samples, dwells, cells = [], [], []
    t = np.linspace(-1.0, 1.0, each)
    for stroke in _strokes(law, segments):
        if stroke.lift == 0.0:
            dwells.append(stroke.motion(np.zeros(1)))
            continue
        rate = 16 / stroke.angle
        for start in np.arange(8) / 8:
            fit = Chebyshev.interpolate(lambda x: stroke.motion(x)[0], terms - 1, [start, start + 1 / 8])  # noqa: B023
            y = Polynomial(np.polynomial.chebyshev.cheb2poly(fit.coef))
            samples.append((y(t), rate * y.deriv()(t), rate**2 * y.deriv(2)(t)))
            cells.append([rate, *y.coef, *[0.0] * (terms - y.coef.size)])
    return _table([*samples, *dwells]), np.array(cells)


def _strokes(law: str, segments: Sequence[Segment]) -> list[Stroke]:
    heights = np.cumsum([0.0, *(lift for _, lift in segments)])
    return [
        Stroke(ALL_LAWS[law], np.radians(angle), height, lift)
        for (angle, lift), height in zip(segments, heights[:-1], strict=True)
    ]


def _table(parts: Sequence[Motion]) -> Array:
    y, y1, y2 = (np.concatenate(each) for each in zip(*parts, strict=True))
    return np.array([y, y1, y2, np.cos(y), np.sin(y)])
