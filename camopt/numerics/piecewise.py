"""Piecewise polynomials: the only form of motion that kernels know.

A turn is cut into *pieces* on which the motion is smooth, a piece into equal *panels*. On each panel y is a
polynomial of degree 10 in u ∈ [−1, 1]. Jumps of any derivative lie between pieces, so both one-sided values
are seen by construction. A piece of m panels has m + 1 nodes (panel ends) at which the motion is tabulated.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camopt.numerics import FloatArray
from camopt.numerics.compile import compiled

DEGREE = 10


class MotionTable(NamedTuple):
    """A programme for the kernels. P panels, Q pieces, N = P + Q nodes; cam angles in rad."""

    coefficients: FloatArray  # (P, DEGREE + 1) of y in powers of u
    centre: FloatArray  # (P,) cam angle at u = 0
    half_width: FloatArray  # (P,) cam angle from u = 0 to u = 1
    first_panel: NDArray[np.int64]  # (Q + 1,) of each piece; its first node is first_panel + its number
    kind: NDArray[np.int64]  # (Q,) a bit that says what the piece is
    nodes: FloatArray  # (N, 4) y, y', y'', y''' at panel ends, one-sided at the ends of a piece


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
