"""Extremes of a curve over the continuous turn, enclosed from both sides, for many designs at once.

For a tile of designs the curve is evaluated at the table's nodes, and jets bound its derivatives and the
rounding error: over groups of panels first, then within each panel that this leaves open. Within a panel of width
w a curve exceeds its end values by no more than |f''|·w²/8; a panel that stays below the best node by that is done
with, and two or three are left. There, slopes at both ends and a bound of the third derivative say how far f'' may
be from its mean. Where the curve is concave, its maximum is at an end or at a root of the slope, and a bracketed
secant climbs to it until slope²/(2·|f''|), which bounds what is still to be gained, is below the tolerance. What is
not concave is halved.

Designs are innermost, so that loops can run in vector registers; only the last resort (``halving``) takes designs
one by one. Every answer is the largest value found, and a bound of what the true extreme may differ from it.

numba compiles what takes the curve ``f`` anew for each curve. So such functions are few and short; what works on
their results is apart from them, and typed once.
"""

from typing import NamedTuple

import numpy as np

from camopt.numerics import LARGEST_MAGNITUDE, LEAST, UNIT
from camopt.numerics.climbing import Ask, allowed, orient
from camopt.numerics.compile import called, compiled_for_many, inlined
from camopt.numerics.curves import curve
from camopt.numerics.jet import known
from camopt.numerics.piecewise import node_motion, row_jets
from camopt.numerics.searching import search_panel
from camopt.numerics.workspace import TILE, workspace

TIED = 8.0 * UNIT  # relative: values this near differ by rounding alone


class Precision(NamedTuple):
    """The errors allowed: of extremes, relative; of their cam angles, rad, or inf."""

    value: float
    location: float


@called
def node_values(f, first, count, table, values):
    """values[t, i] = curve of design first + i at node t."""
    for t in range(table.nodes.shape[0]):
        y, y1, y2, y3 = node_motion(table, t)
        row = values[t]
        for i in range(np.uint64(count)):  # unsigned: an index that may be negative would keep the loop scalar
            row[i] = curve(f, np.uint64(first) + i, y, y1, y2, y3)[0]


@called
def row_bounds(f, first, count, table, row, half_width, bounds):
    """What jets say of a row of the table, a panel or a group of panels, and design first + i."""
    y, y1, y2, y3 = row_jets(table, row)
    eighth = 0.5 * half_width * half_width  # of the squared width
    for i in range(np.uint64(count)):
        jet = curve(f, np.uint64(first) + i, y, y1, y2, y3)[0]
        bounds.excess[row, i] = known(eighth * jet.second + jet.error)
        bounds.third[row, i] = known(jet.third)
        bounds.error[row, i] = known(jet.error)


@called
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


@called
def may_exceed(before, after, excess, count, goal, best):
    """Whether a panel may hold more than the best value of any of the designs."""
    found = False
    for i in range(count):
        found |= max(orient(before[i], goal), orient(after[i], goal)) + excess[i] > best[i]
    return found


@called
def candidates(panel, node, count, ask, work):
    """Which designs may exceed their best value within a panel by more than is allowed: their number."""
    before, after, excess = work.values[node], work.values[node + 1], work.bounds.excess[panel]
    best, top, error, chosen = work.found.best, work.found.top, work.bounds.error[panel], work.chosen
    many = 0
    for i in range(count):
        bound = max(ask.sign * before[i], ask.sign * after[i]) + excess[i]
        more = bound > best[i] + allowed(best[i], ask.tolerance, error[i])
        chosen[many] = i
        many += more
        top[i] = top[i] if more else max(top[i], bound)
    return many


@inlined
def is_open(f, first, count, table, panel, node, goal, work):
    """Whether jets leave it open that a panel holds more than the best value of some design."""
    before, after = work.values[node], work.values[node + 1]
    for row in (table.group[panel], panel):  # the bounds of its group settle most panels
        if not work.looked[row]:
            row_bounds(f, first, count, table, row, table.half_width[panel], work.bounds)
            work.looked[row] = True
        if not may_exceed(before, after, work.bounds.excess[row], count, goal, work.found.best):
            return False
    return True


@called
def begin(table, kinds, goal, count, work):
    """What the nodes say of the extremes of a tile."""
    found = work.found
    best_nodes(work.values, count, table, kinds, goal, found.best, found.node)
    for i in range(count):
        found.top[i], found.rounding[i], found.at[i] = found.best[i], 0.0, node_angle(table, found.node[i])


@called
def search(f, first, count, table, question, precision, work):
    """The extremes of a tile: a question is the kinds of stroke to look at, and the goal."""
    kinds, goal = question
    begin(table, kinds, goal, count, work)
    for q in range(table.kind.size):
        if table.kind[q] & kinds:
            for p in range(table.first_panel[q], table.first_panel[q + 1]):
                if not is_open(f, first, count, table, p, p + q, goal, work):
                    continue
                for way in range(2):
                    if goal != LARGEST_MAGNITUDE and (goal == LEAST) != (way == 1):
                        continue
                    ask = Ask(1.0 - 2.0 * way, precision.value, precision.location)
                    many = candidates(p, p + q, count, ask, work)
                    if many:
                        search_panel(f, first, many, table, p, p + q, ask, work)


@called
def give(found, count, goal, value, where, width):
    """Write the extremes of a tile to where they are asked for."""
    for i in range(count):
        value[i] = -found.best[i] if goal == LEAST else found.best[i]
        where[i] = found.at[i]
        width[i] = max(found.top[i] - found.best[i], 0.0) + 2.0 * found.rounding[i]


@compiled_for_many
def extremes(f, designs, table, questions, precision, value, where, width):
    """Answer questions about a curve for designs 0 … designs − 1.

    questions (K, 2): the kinds of stroke to look at and the goal; value, where (K, designs): the extremes and
    their cam angles in rad; width: by how much the true extreme may differ. The largest magnitude comes without its
    sign.
    """
    work = workspace(table.nodes.shape[0], table.low.shape[0])
    for first in range(0, designs, TILE):
        count = min(TILE, designs - first)
        node_values(f, first, count, table, work.values)
        work.looked[:] = False
        for k in range(questions.shape[0]):
            question, tile = (questions[k, 0], questions[k, 1]), slice(first, first + count)
            search(f, first, count, table, question, precision, work)
            give(work.found, count, question[1], value[k, tile], where[k, tile], width[k, tile])
