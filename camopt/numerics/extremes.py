"""Extremes of a curve over the continuous turn, for many designs at once.

Three steps for a tile of designs. All are evaluated at the table's nodes (designs innermost, so that the loop
runs in vector registers). A scan finds each design's best node, and counts the nodes that are local maxima and
could still lead to the largest value. Each of those is then followed to the true maximum inside its panel, by
a bracketed root of the slope.
"""

import numpy as np

from camopt.numerics.compile import compiled
from camopt.numerics.curves import curve
from camopt.numerics.piecewise import motion

LARGEST, LEAST, LARGEST_MAGNITUDE = 0, 1, 2
TILE = 256  # designs whose node values (about 70 × 256 × 8 bytes) stay in the second-level cache
ROW = TILE + 8  # a row of a tile: not a power of two, whose columns would all share one cache set
MOST_STEPS = 60


@compiled
def node_values(f, first, count, table, values):
    """values[t, i] = curve of design first + i at node t."""
    for t in range(table.nodes.shape[0]):
        y, y1, y2, y3 = table.nodes[t, 0], table.nodes[t, 1], table.nodes[t, 2], table.nodes[t, 3]
        row = values[t]
        for i in range(count):
            row[i] = curve(f, first + i, y, y1, y2, y3)[0]


@compiled
def orient(value, goal):
    """The number whose maximum is the extreme asked for."""
    if goal == LARGEST_MAGNITUDE:
        return abs(value)
    return -value if goal == LEAST else value


@compiled
def best_nodes(values, count, table, kinds, goal, best, node):
    """Largest oriented node value of each design over the pieces of the given kinds, and its node."""
    for i in range(count):
        best[i] = -np.inf
        node[i] = -1
    for q in range(table.kind.size):
        if table.kind[q] & kinds:
            for t in range(table.first_panel[q] + q, table.first_panel[q + 1] + q + 1):
                row = values[t]
                for i in range(count):
                    value = orient(row[i], goal)
                    node[i] = t if value > best[i] else node[i]
                    best[i] = max(value, best[i])


@compiled
def is_candidate(left, value, right, best):
    """Whether a node is a local maximum that could lead beyond the best node.

    A smooth maximum exceeds its nearest node by at most an eighth of the fall to both neighbours, to leading
    order; the whole fall is allowed.
    """
    return (value >= left) & (value >= right) & (value + (2.0 * value - left - right) >= best)


@compiled
def count_candidates(values, count, table, kinds, goal, best, candidates):
    """How many candidate nodes each design has."""
    for i in range(count):
        candidates[i] = 0
    for q in range(table.kind.size):
        if table.kind[q] & kinds:
            first, last = table.first_panel[q] + q, table.first_panel[q + 1] + q
            for t in range(first, last + 1):
                before, here, after = values[max(t - 1, first)], values[t], values[min(t + 1, last)]
                for i in range(count):
                    left, right = orient(before[i], goal), orient(after[i], goal)
                    candidates[i] += is_candidate(left, orient(here[i], goal), right, best[i])


@compiled
def piece_of(table, node):
    """The piece that a node belongs to."""
    q = 0
    while table.first_panel[q + 1] + q < node:
        q += 1
    return q


@compiled
def oriented_slope(f, i, y, y1, y2, y3, goal):
    """Oriented value and slope of design i."""
    value, slope = curve(f, i, y, y1, y2, y3)
    flip = goal == LEAST or (goal == LARGEST_MAGNITUDE and value < 0.0)
    return (-value, -slope) if flip else (value, slope)


@compiled
def node_slope(f, i, table, node, goal):
    """Slope of the oriented curve of design i at a node."""
    m = table.nodes[node]
    return oriented_slope(f, i, m[0], m[1], m[2], m[3], goal)[1]


@compiled
def follow(f, i, table, node, goal, tolerance):
    """Largest value in the panel that the curve climbs into from a node, and its cam angle.

    Illinois false position on the slope. Stops when slope × bracket, which bounds what is still to be gained
    under a concave maximum, is below the tolerance; -inf where the panel holds no stationary point.
    """
    q = piece_of(table, node)
    slope = node_slope(f, i, table, node, goal)
    other = node + 1 if slope > 0.0 else node - 1
    if slope == 0.0 or other < table.first_panel[q] + q or other > table.first_panel[q + 1] + q:
        return -np.inf, 0.0
    panel = min(node, other) - q
    rising = node_slope(f, i, table, min(node, other), goal)
    falling = node_slope(f, i, table, max(node, other), goal)
    low, high, side, best, at = -1.0, 1.0, 0, -np.inf, 0.0
    if not (rising >= 0.0 and falling <= 0.0 and np.isfinite(rising) and np.isfinite(falling)):
        return best, at
    half_width = table.half_width[panel]
    for _ in range(MOST_STEPS):
        u = low + (high - low) * (rising / (rising - falling))
        if not low < u < high:
            u = 0.5 * (low + high)
        y, y1, y2, y3 = motion(table, panel, u)
        value, slope = oriented_slope(f, i, y, y1, y2, y3, goal)
        best, at = max(value, best), table.centre[panel] + u * half_width
        if abs(slope) * half_width * (high - low) <= tolerance * abs(value) or not low < u < high:
            break
        if slope > 0.0:
            low, rising = u, slope
            falling = 0.5 * falling if side == 1 else falling
            side = 1
        else:
            high, falling = u, slope
            rising = 0.5 * rising if side == -1 else rising
            side = -1
    return best, at


@compiled
def node_angle(table, node):
    """Cam angle of a node."""
    q = piece_of(table, node)
    panel = min(node - q, table.first_panel[q + 1] - 1)
    side = -1.0 if node - q == panel else 1.0
    return table.centre[panel] + side * table.half_width[panel]


@compiled
def follow_all(f, i, column, table, values, kinds, goal, tolerance, best, at):
    """The best of all candidate nodes of a design, followed to their maxima."""
    bound = best
    for q in range(table.kind.size):
        if table.kind[q] & kinds:
            first, last = table.first_panel[q] + q, table.first_panel[q + 1] + q
            for t in range(first, last + 1):
                left = orient(values[max(t - 1, first), column], goal)
                right = orient(values[min(t + 1, last), column], goal)
                if is_candidate(left, orient(values[t, column], goal), right, bound):
                    value, angle = follow(f, i, table, t, goal, tolerance)
                    if value > best:
                        best, at = value, angle
    return best, at


@compiled
def extremes(f, designs, table, questions, tolerance, value, where):
    """Answer questions about a curve for designs 0 … designs − 1.

    questions (K, 2): the kinds of stroke to look at and the goal; value, where (K, designs): the extremes and
    their cam angles in rad. The largest magnitude is returned without its sign.
    """
    values = np.empty((table.nodes.shape[0], ROW))
    best, node, candidates = np.empty(TILE), np.empty(TILE, np.int64), np.empty(TILE, np.int64)
    for first in range(0, designs, TILE):
        count = min(TILE, designs - first)
        node_values(f, first, count, table, values)
        for k in range(questions.shape[0]):
            kinds, goal = questions[k, 0], questions[k, 1]
            best_nodes(values, count, table, kinds, goal, best, node)
            count_candidates(values, count, table, kinds, goal, best, candidates)
            for i in range(count):
                top, at = best[i], node_angle(table, node[i])
                if candidates[i] > 1:
                    top, at = follow_all(f, first + i, i, table, values, kinds, goal, tolerance, top, at)
                else:
                    followed, angle = follow(f, first + i, table, node[i], goal, tolerance)
                    if followed > top:
                        top, at = followed, angle
                value[k, first + i] = -top if goal == LEAST else top
                where[k, first + i] = at


@compiled
def turns_far(f, designs, table, limit, out):
    """Whether the direction (1, f) turns by more than a limit (tangent of the angle) between two nodes.

    With f = tan β that is the normal of the pitch curve: where it turns far within a panel, the curve has
    features narrower than a panel, and a finer table is called for.
    """
    values = np.empty((table.nodes.shape[0], ROW))
    for first in range(0, designs, TILE):
        count = min(TILE, designs - first)
        node_values(f, first, count, table, values)
        excess = np.full(TILE, -np.inf)
        for q in range(table.kind.size):
            for t in range(table.first_panel[q] + q, table.first_panel[q + 1] + q):
                before, after = values[t], values[t + 1]
                for i in range(count):
                    turn = abs(after[i] - before[i]) - limit * (1.0 + before[i] * after[i])
                    excess[i] = max(excess[i], turn)
        for i in range(count):
            out[first + i] = excess[i] > 0.0
