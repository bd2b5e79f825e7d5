"""Extremes of a curve over the continuous turn, enclosed from both sides, for many designs at once.

For a tile of designs the curve is evaluated at the table's nodes, and jets bound its derivatives and the
rounding error: over groups of panels first, then within each panel that this leaves open. Within a panel of width
w a curve exceeds its end values by no more than |f''|·w²/8; a panel that stays below the best node by that is done
with, and two or three are left. There, slopes at both ends and a bound of the third derivative say how far f'' may
be from its mean. Where the curve is concave, its maximum is at an end or at a root of the slope, and a bracketed
secant climbs to it until slope²/(2·|f''|), which bounds what is still to be gained, is below the tolerance. What is
not concave is halved.

Designs are innermost: all of this, but the last resort (``split``), runs in vector registers. Every answer is the
largest value found, and a bound of what the true extreme may differ from it.
"""

import numpy as np

from camopt.numerics import LARGEST_MAGNITUDE, LEAST
from camopt.numerics.climbing import (
    CLIMBS,
    DEPTH,
    OPEN,
    SCRATCH,
    allowed,
    begin_climb,
    climb_all,
    looked_at,
    orient,
    oriented,
    split,
)
from camopt.numerics.compile import called, compiled_for_many, inlined
from camopt.numerics.curves import curve
from camopt.numerics.jet import UNIT, known
from camopt.numerics.piecewise import motion, node_motion, row_jets

TILE = 256  # designs whose tables (about 70 × 256 × 8 bytes each) stay in the second-level cache
TIED = 8.0 * UNIT  # relative: values this near differ by rounding alone
ROW = TILE + 8  # a row of a tile: not a power of two, whose columns would all share one cache set


@inlined
def node_values(f, first, count, table, values):
    """values[t, i] = curve of design first + i at node t."""
    for t in range(table.nodes.shape[0]):
        y, y1, y2, y3 = node_motion(table, t)
        row = values[t]
        for i in range(np.uint64(count)):  # unsigned: an index that may be negative would keep the loop scalar
            row[i] = curve(f, np.uint64(first) + i, y, y1, y2, y3)[0]


@inlined
def row_bounds(f, first, count, table, row, half_width, excess, third, error):
    """What jets say of a row of the table, a panel or a group of panels, and design first + i.

    excess[row, i]: by how much the curve may exceed both its end values in a panel; third[row, i]: bound of
    |f'''|; error[row, i]: of rounding.
    """
    y, y1, y2, y3 = row_jets(table, row)
    eighth = 0.5 * half_width * half_width  # of the squared width
    for i in range(np.uint64(count)):
        jet = curve(f, np.uint64(first) + i, y, y1, y2, y3)[0]
        excess[row, i] = known(eighth * jet.second + jet.error)
        third[row, i] = known(jet.third)
        error[row, i] = known(jet.error)


@inlined
def best_nodes(values, count, table, kinds, goal, best, node):
    """Largest oriented node value of each design over pieces of given kinds, and the first node that has it."""
    for i in range(count):
        best[i] = -np.inf
        node[i] = -1
    for q in range(table.kind.size):
        if table.kind[q] & kinds:
            for t in range(table.first_panel[q] + q, table.first_panel[q + 1] + q + 1):
                row = values[t]
                for i in range(count):
                    value = orient(row[i], goal)
                    node[i] = t if value > max(best[i] * (1.0 + TIED), best[i] * (1.0 - TIED)) else node[i]
                    best[i] = max(value, best[i])


@called
def node_angle(table, node):
    """Cam angle of a node."""
    q = 0
    while table.first_panel[q + 1] + q < node:
        q += 1
    panel = min(node - q, table.first_panel[q + 1] - 1)
    side = -1.0 if node - q == panel else 1.0
    return table.centre[panel] + side * table.half_width[panel]


@inlined
def may_exceed(before, after, excess, count, goal, best):
    """Whether a panel may hold more than the best value of any of the designs."""
    found = False
    for i in range(count):
        found |= max(orient(before[i], goal), orient(after[i], goal)) + excess[i] > best[i]
    return found


@inlined
def candidates(before, after, excess, error, count, sign, tolerance, best, top, index):
    """Which designs may exceed their best value within a panel by more than is allowed."""
    many = 0
    for i in range(count):
        bound = max(sign * before[i], sign * after[i]) + excess[i]
        more = bound > best[i] + allowed(best[i], tolerance, error[i])
        index[many] = i
        many += more
        top[i] = top[i] if more else max(top[i], bound)
    return many


@inlined
def slopes_at(f, first, index, many, y, y1, y2, y3, sign, slopes):
    """Oriented slopes of some designs at one cam angle."""
    for j in range(np.uint64(many)):
        slopes[j] = sign * curve(f, np.uint64(first + index[j]), y, y1, y2, y3)[1]


@inlined
def search_panel(
    f, first, index, many, table, panel, node, values, third, error, sign, tolerance, location, best, at, top,
    rounding, climbing, slopes, scratch, stack,
):  # fmt: skip
    """Search one panel for all designs in ``index``."""
    half_width = table.half_width[panel]
    rising, falling = slopes[0], slopes[1]
    y, y1, y2, y3 = node_motion(table, node)
    slopes_at(f, first, index, many, y, y1, y2, y3, sign, rising)
    y, y1, y2, y3 = node_motion(table, node + 1)
    slopes_at(f, first, index, many, y, y1, y2, y3, sign, falling)
    y, y1, y2, y3 = motion(table, panel, 0.0)
    climbs = np.int64(0)  # a literal would be compiled for as well
    for j in range(many):
        i = index[j]
        left, right = sign * values[node, i], sign * values[node + 1, i]
        rounding[i] = max(rounding[i], error[panel, i] if error[panel, i] < np.inf else 0.0)
        enough = best[i] + allowed(best[i], tolerance, error[panel, i])
        part, middle, slope, parts = (-1.0, 1.0, left, rising[j], right, falling[j]), 0.0, 0.0, 1
        for k in range(3):  # the panel, and if that settles nothing its halves
            if k >= parts:
                break
            if k == 1:
                part = (-1.0, 0.0, left, rising[j], middle, slope)
            elif k == 2:
                part = (0.0, 1.0, middle, slope, right, falling[j])
            low, high, a, a1, b, b1 = part
            verdict, bound, concavity = looked_at(low, high, a, a1, b, b1, third[panel, i], half_width, enough)
            if verdict == CLIMBS:
                begin_climb(scratch, climbs, part, half_width, concavity)
                climbing[climbs] = i
                climbs += 1
                continue
            if verdict == OPEN and k == 0:
                parts = 3
                middle, slope = oriented(f, np.uint64(first + i), y, y1, y2, y3, sign)
                if middle > best[i]:
                    best[i], at[i] = middle, table.centre[panel]
                continue
            if verdict == OPEN:
                found, u, bound, blur = split(
                    f, np.uint64(first + i), table, panel, part, error[panel, i], sign, tolerance, location,
                    best[i], stack,
                )  # fmt: skip
                if found > best[i]:
                    best[i], at[i] = found, table.centre[panel] + half_width * u
                rounding[i] = max(rounding[i], blur)
            top[i] = max(top[i], bound)
    climb_all(f, first, climbing, climbs, table, panel, error, sign, tolerance, location, best, at, top, scratch)


@compiled_for_many
def extremes(f, designs, table, questions, tolerance, location, value, where, width):
    """Answer questions about a curve for designs 0 … designs − 1.

    questions (K, 2): the kinds of stroke to look at and the goal; value, where (K, designs): the extremes and
    their cam angles in rad; width: by how much the true extreme may differ. ``tolerance`` is relative;
    ``location`` is the error allowed in the cam angles, rad, or inf. The largest magnitude comes without its sign.
    """
    rows = table.low.shape[0]
    values, excess = np.empty((table.nodes.shape[0], ROW)), np.empty((rows, ROW))
    third, error, looked = np.empty((rows, ROW)), np.empty((rows, ROW)), np.empty(rows, np.bool_)
    best, node, at = np.empty(TILE), np.empty(TILE, np.int64), np.empty(TILE)
    top, rounding, stack = np.empty(TILE), np.empty(TILE), np.empty((DEPTH + 2, 6))
    index, climbing = np.empty(TILE + 1, np.int64), np.empty(2 * TILE, np.int64)
    slopes, scratch = np.empty((2, ROW)), np.empty((SCRATCH, 2 * ROW))
    for first in range(0, designs, TILE):
        count = min(TILE, designs - first)
        node_values(f, first, count, table, values)
        looked[:] = False
        for k in range(questions.shape[0]):
            kinds, goal = questions[k, 0], questions[k, 1]
            best_nodes(values, count, table, kinds, goal, best, node)
            for i in range(count):
                top[i], rounding[i], at[i] = best[i], 0.0, node_angle(table, node[i])
            for q in range(table.kind.size):
                if table.kind[q] & kinds:
                    for p in range(table.first_panel[q], table.first_panel[q + 1]):
                        before, after, room = values[p + q], values[p + q + 1], excess[p]
                        open_ = True
                        for row in (table.group[p], p):  # the bounds of its group settle most panels
                            if open_ and not looked[row]:
                                row_bounds(f, first, count, table, row, table.half_width[p], excess, third, error)
                                looked[row] = True
                            open_ = open_ and may_exceed(before, after, excess[row], count, goal, best)
                        if not open_:
                            continue
                        for way in range(2):
                            if goal != LARGEST_MAGNITUDE and (goal == LEAST) != (way == 1):
                                continue
                            sign = 1.0 - 2.0 * way
                            many = candidates(
                                before, after, room, error[p], count, sign, tolerance, best, top, index
                            )
                            if many:
                                search_panel(
                                    f, first, index, many, table, p, p + q, values, third, error, sign, tolerance,
                                    location, best, at, top, rounding, climbing, slopes, scratch, stack,
                                )  # fmt: skip
            for i in range(count):
                value[k, first + i] = -best[i] if goal == LEAST else best[i]
                where[k, first + i] = at[i]
                width[k, first + i] = max(top[i] - best[i], 0.0) + 2.0 * rounding[i]
