"""Motion tables: a programme as piecewise polynomials, the only form of motion that kernels know.

A turn is cut into *pieces* on which the motion is smooth, a piece into equal *panels*. On each panel y is a
polynomial of degree 10 in u ∈ [−1, 1]. Jumps of any derivative lie between pieces, so both one-sided values
are seen by construction. A piece of m panels has m + 1 nodes (panel ends) at which the motion is tabulated.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev, polynomial
from numpy.typing import NDArray

from camopt.motion.law import Law
from camopt.numerics import FloatArray
from camopt.numerics.compile import compiled

RISE, RETURN, DWELL = 1, 2, 4  # bits, so that a question can ask for several kinds at once
TURN = RISE | RETURN | DWELL

JERK_DEGREE = 7
DEGREE = JERK_DEGREE + 3


class MotionTable(NamedTuple):
    """A programme for the kernels. P panels, Q pieces, N = P + Q nodes; cam angles in rad."""

    coefficients: FloatArray  # (P, DEGREE + 1) of y in powers of u
    centre: FloatArray  # (P,) cam angle at u = 0
    half_width: FloatArray  # (P,) cam angle from u = 0 to u = 1
    first_panel: NDArray[np.int64]  # (Q + 1,) of each piece; its first node is first_panel + its number
    kind: NDArray[np.int64]  # (Q,) RISE, RETURN or DWELL
    nodes: FloatArray  # (N, 4) y, y', y'', y''' at panel ends, one-sided at the ends of a piece


def _chebyshev_projection() -> tuple[FloatArray, FloatArray]:
    """Nodes inside (−1, 1) and the matrix from values there to power-basis coefficients."""
    count = JERK_DEGREE + 1
    u = chebyshev.chebpts1(count)
    to_chebyshev = np.linalg.inv(chebyshev.chebvander(u, JERK_DEGREE))
    to_powers = np.array([np.pad(chebyshev.cheb2poly(row), (0, count))[:count] for row in np.eye(count)]).T
    return u, to_powers @ to_chebyshev


NODES, TO_POWERS = _chebyshev_projection()


@lru_cache(maxsize=256)
def stroke_coefficients(law: Law, panels: int) -> tuple[FloatArray, FloatArray, tuple[int, ...]]:
    """A law as panel polynomials on the unit stroke.

    The jerk is interpolated at Chebyshev points strictly inside each panel and integrated three times, with
    the constants taken from the law at the panel's centre: so no derivative loses digits to differentiation.

    Returns the coefficients (P, DEGREE + 1) of s in powers of u, the panel ends (P + 1,), and the number of
    panels in each piece. ``panels`` is the least number in a stroke.
    """
    counts = [max(1, round(panels * (b - a))) for a, b in zip(law.BREAKS, law.BREAKS[1:], strict=False)]
    ends = [np.linspace(a, b, m + 1) for a, b, m in zip(law.BREAKS, law.BREAKS[1:], counts, strict=False)]
    low = np.concatenate([e[:-1] for e in ends])
    high = np.concatenate([e[1:] for e in ends])
    centre, half = (low + high) / 2, (high - low) / 2
    series = law.jerk(centre[:, None] + half[:, None] * NODES) @ TO_POWERS.T
    for constant in (law.acceleration(centre), law.velocity(centre), law.displacement(centre)):
        series = polynomial.polyint(series, axis=1) * half[:, None]
        series[:, 0] = constant
    series.flags.writeable = False
    return series, np.append(low, 1.0), tuple(counts)


def motion(table, panel, u):
    """(y, y', y'', y''') by cam angle on a panel, by Horner's scheme for a polynomial and its derivatives."""
    y = table.coefficients[panel, DEGREE]
    d1 = d2 = d3 = 0.0
    for k in range(DEGREE - 1, -1, -1):
        d3 = d3 * u + d2
        d2 = d2 * u + d1
        d1 = d1 * u + y
        y = y * u + table.coefficients[panel, k]
    h = table.half_width[panel]
    return y, d1 / h, 2.0 * d2 / (h * h), 6.0 * d3 / (h * h * h)


motion = compiled(motion)


@compiled
def fill_nodes(table):
    """Tabulate the motion at the ends of all panels."""
    for q in range(table.kind.size):
        for p in range(table.first_panel[q], table.first_panel[q + 1]):
            for side in range(2):
                y, y1, y2, y3 = motion(table, p, 2.0 * side - 1.0)
                node = table.nodes[p + q + side]
                node[0], node[1], node[2], node[3] = y, y1, y2, y3
