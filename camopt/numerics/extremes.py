"""Extremes of a curve over the continuous turn, for many designs at once.

Two steps. All designs of a tile are evaluated at the table's nodes (designs innermost, so that the loop runs
in vector registers). Then, for each design, every node that is a local maximum and could still lead to the
largest value is followed to the true maximum inside its panel: a bracketed root of the slope.
"""

import numpy as np

from camopt.motion.table import motion
from camopt.numerics.compile import compiled
from camopt.numerics.curves import curve

LARGEST, LEAST, LARGEST_MAGNITUDE = 0, 1, 2
TILE = 256  # designs whose node values (about 70 × 256 × 8 bytes) stay in the second-level cache
MOST_STEPS = 60
CLOSE = 1e-10  # a bracket this narrow, in panel half-widths, leaves the value exact to rounding


@compiled
def node_values(f, first, count, table, values):  # type: ignore[no-untyped-def]
    """values[t, i] = curve of design first + i at node t."""
    for t in range(table.nodes.shape[0]):
        y, y1, y2, y3 = table.nodes[t, 0], table.nodes[t, 1], table.nodes[t, 2], table.nodes[t, 3]
        row = values[t]
        for i in range(count):
            row[i] = curve(f, first + i, y, y1, y2, y3)[0]


@compiled
def oriented(value, slope, goal):  # type: ignore[no-untyped-def]
    """Value and slope of the curve whose maximum is the extreme asked for."""
    if goal == LEAST or (goal == LARGEST_MAGNITUDE and value < 0.0):
        return -value, -slope
    return value, slope


@compiled
def evaluate(f, i, table, panel, u, goal):  # type: ignore[no-untyped-def]
    """Oriented value and slope (by u) of design i on a panel."""
    y, y1, y2, y3 = motion(table, panel, u)
    value, slope = curve(f, i, y, y1, y2, y3)
    value, slope = oriented(value, slope, goal)
    return value, slope * table.half_width[panel]


@compiled
def panel_maximum(f, i, table, panel, goal):  # type: ignore[no-untyped-def]
    """Largest value inside a panel and its u, by the Illinois false position on the slope.

    Where the slope does not change sign from + to −, the larger end is the answer.
    """
    low, high = -1.0, 1.0
    best, rising = evaluate(f, i, table, panel, low, goal)
    at = low
    value, falling = evaluate(f, i, table, panel, high, goal)
    if value > best:
        best, at = value, high
    if not (rising >= 0.0 and falling <= 0.0) or not (np.isfinite(rising) and np.isfinite(falling)):
        return best, at
    side = 0
    for step in range(MOST_STEPS):
        u = 0.5 * (low + high)
        if step > 0 and rising > falling:
            u = low + (high - low) * (rising / (rising - falling))
        value, slope = evaluate(f, i, table, panel, u, goal)
        if value > best:
            best, at = value, u
        if slope == 0.0:
            break
        if slope > 0.0:
            moved, low, rising = u - low, u, slope
            if side == 1:
                falling *= 0.5
            side = 1
        else:
            moved, high, falling = high - u, u, slope
            if side == -1:
                rising *= 0.5
            side = -1
        if moved < CLOSE or high - low < CLOSE:
            break
    return best, at


@compiled
def design_maximum(f, i, column, table, values, kinds, goal):  # type: ignore[no-untyped-def]
    """Largest oriented value of design i over the pieces of the given kinds, and its cam angle."""
    best, where = -np.inf, 0.0
    for q in range(table.kind.size):
        if table.kind[q] & kinds:
            for t in range(table.first_panel[q] + q, table.first_panel[q + 1] + q + 1):
                value, _ = oriented(values[t, column], 0.0, goal)
                if value > best:
                    best = value
                    panel = min(max(t - q, table.first_panel[q]), table.first_panel[q + 1] - 1)
                    side = -1.0 if t - q == panel else 1.0
                    where = table.centre[panel] + side * table.half_width[panel]
    for q in range(table.kind.size):
        if table.kind[q] & kinds:
            first, last = table.first_panel[q] + q, table.first_panel[q + 1] + q
            for t in range(first, last + 1):
                value, _ = oriented(values[t, column], 0.0, goal)
                left, _ = oriented(values[max(t - 1, first), column], 0.0, goal)
                right, _ = oriented(values[min(t + 1, last), column], 0.0, goal)
                # a resolved maximum exceeds its nodes by an eighth of the drop to its neighbours or less
                slack = 2.0 * value - left - right
                if value >= left and value >= right and value + slack >= best:
                    for panel in range(max(t - q - 1, first - q), min(t - q + 1, last - q)):
                        top, u = panel_maximum(f, i, table, panel, goal)
                        if top > best:
                            best, where = top, table.centre[panel] + u * table.half_width[panel]
    return best, where


@compiled
def extremes(f, designs, table, questions, value, where):  # type: ignore[no-untyped-def]
    """Answer questions about a curve for designs 0 … designs − 1.

    questions (K, 2): the kinds of stroke to look at and the goal; value, where (K, designs): the extremes and
    their cam angles in rad. The largest magnitude is returned without its sign.
    """
    values = np.empty((table.nodes.shape[0], TILE))
    for first in range(0, designs, TILE):
        count = min(TILE, designs - first)
        node_values(f, first, count, table, values)
        for k in range(questions.shape[0]):
            kinds, goal = questions[k, 0], questions[k, 1]
            for i in range(count):
                best, at = design_maximum(f, first + i, i, table, values, kinds, goal)
                value[k, first + i] = -best if goal == LEAST else best
                where[k, first + i] = at


@compiled
def turning(f, designs, table, out):  # type: ignore[no-untyped-def]
    """Largest turn of the direction (1, f) between neighbouring nodes, as the tangent of the angle.

    With f = tan β this is how far the normal of the pitch curve turns within a panel: where it turns far, the
    curve has features narrower than a panel, and a finer table is called for.
    """
    values = np.empty((table.nodes.shape[0], TILE))
    for first in range(0, designs, TILE):
        count = min(TILE, designs - first)
        node_values(f, first, count, table, values)
        for i in range(count):
            out[first + i] = 0.0
        for q in range(table.kind.size):
            for t in range(table.first_panel[q] + q, table.first_panel[q + 1] + q):
                for i in range(count):
                    a, b = values[t, i], values[t + 1, i]
                    along = 1.0 + a * b
                    turn = abs(b - a) / along if along > 0.0 else np.inf
                    out[first + i] = max(out[first + i], turn)
