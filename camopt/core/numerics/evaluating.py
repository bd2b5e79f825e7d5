"""The functions compiled for each curve: its values, slopes and jets.

The search for extremes is compiled once, and calls these functions by their address (``kernels.by_address``). So
whatever is written here costs compile time for each curve, and whatever is written there does not.

Uncompiled, several designs go through a formula together, as arrays, with the same bits; and it gives its value
alone where no slope is asked. Compiled, a slope that nobody reads costs nothing.

``made`` is the address of a curve and its motion table. Several designs are numbered from ``first``; ``out`` takes
values in its first row and slopes in its second. ``sign`` orients both: 1 looks for the largest, −1 for the least.
"""

from typing import Any, NamedTuple

import numpy as np

from camopt.core.kernels.arguments import ADDRESS, COUNT, NONE, NUMBER, Record
from camopt.core.kernels.by_address import code_of, evaluates
from camopt.core.kernels.compile import PLAIN_RUN, inlined
from camopt.core.numerics import FloatArray
from camopt.core.numerics.curves import curve, value_of
from camopt.core.numerics.jet import known_bound
from camopt.core.numerics.piecewise import (
    COUNTS,
    NUMBERS,
    motion,
    node_motion,
    of_all_rows,
    of_some_rows,
    part_jets,
    row_jets,
)
from camopt.core.numerics.workspace import BOUNDS, ROWS

JET = 3  # values: the work of evaluating a jet, uncompiled


class PartBounds(NamedTuple):
    """Bounds by jets of a curve and its slope over a part of a panel.

    Range of the curve, bounds of its rounding error, |f''| and |f'''|; range and rounding error of its slope.
    """

    low: float
    high: float
    error: float
    second: float
    third: float
    least_slope: float
    most_slope: float
    slope_error: float


@inlined
def node_values(f, table, first, count, values):
    """values[t, i] = curve of design first + i at node t."""
    for t in range(table.nodes.shape[0]):
        at, row = node_motion(table, t), values[t]
        for i in range(np.uint64(count)):  # unsigned: an index that may be negative would keep the loop scalar
            row[i] = curve(f, np.uint64(first) + i, at)[0]


@evaluates(NONE, COUNT, COUNT, ROWS)
def nodes(made, first, count, values):
    """values[t, i] = curve of design first + i at node t."""
    f, table = made[0]
    node_values(f, table, first, count, values)


@nodes.uncompiled
def _nodes_in_python(made, first, count, values):
    f, table = made[0]
    PLAIN_RUN.count(len(table.nodes) * count)
    at = node_motion(of_all_rows(table), ...)
    values[: len(table.nodes), :count] = value_of(f, slice(first, first + count), at)


@evaluates(NONE, COUNT, NUMBER, COUNT, COUNT, BOUNDS)
def row(made, place, half_width, first, count, bounds):
    """Bounds by jets over a row of the table, a panel or a group of panels, of design first + i."""
    f, table = made[0]
    at = row_jets(table, place)
    eighth = 0.5 * half_width * half_width  # of the squared width
    for i in range(np.uint64(count)):
        jet = curve(f, np.uint64(first) + i, at)[0]
        bounds.excess[place, i] = known_bound(eighth * jet.second + jet.error)
        bounds.third[place, i] = known_bound(jet.third)
        bounds.error[place, i] = known_bound(jet.error)


@row.uncompiled
def _rows_in_python(made, place, half_width, first, count, bounds):
    """Some rows of the table at once: ``place`` (rows,), ``half_width`` (rows, 1)."""
    f, table = made[0]
    PLAIN_RUN.count(JET * len(place) * count)
    at, eighth = row_jets(of_some_rows(table, place), ...), 0.5 * half_width * half_width
    jet = value_of(f, slice(first, first + count), at)
    bounds.excess[place, :count] = known_bound(eighth * jet.second + jet.error)
    bounds.third[place, :count] = known_bound(jet.third)
    bounds.error[place, :count] = known_bound(jet.error)


@inlined
def oriented(f, i, at, sign):
    """Oriented value and slope of design i in a state."""
    value, slope = curve(f, i, at)
    return sign * value, sign * slope


@evaluates(NONE, COUNT, NUMBER, COUNT, COUNTS, COUNT, ROWS)
def node(made, place, sign, first, designs, count, out):
    """Some designs at one node."""
    f, table = made[0]
    at, values, slopes = node_motion(table, place), out[0], out[1]
    for j in range(np.uint64(count)):
        values[j], slopes[j] = oriented(f, np.uint64(first + designs[j]), at, sign)


@node.uncompiled
def _node_in_python(made, place, sign, first, designs, count, out):
    f, table = made[0]
    PLAIN_RUN.count(count)
    out[0, :count], out[1, :count] = oriented(f, first + designs[:count], node_motion(table, place), sign)


@evaluates(NONE, COUNT, NUMBERS, NUMBER, COUNT, COUNTS, COUNT, ROWS)
def panel(made, place, angles, sign, first, designs, count, out):
    """Some designs on one panel, each at its own u in [−1, 1]."""
    (f, table), values, slopes = made[0], out[0], out[1]
    for j in range(np.uint64(count)):
        at = motion(table, place, angles[j])
        values[j], slopes[j] = oriented(f, np.uint64(first + designs[j]), at, sign)


@panel.uncompiled
def _panel_in_python(made, place, angles, sign, first, designs, count, out):
    PLAIN_RUN.count(count)
    out[0, :count], out[1, :count] = many_points(made, place, angles[:count], sign, first + designs[:count])


@evaluates(Record(tuple, (NUMBER, NUMBER)), COUNT, NUMBER, NUMBER, COUNT)
def point(made, place, u, sign, design):
    """Value and slope of one design."""
    f, table = made[0]
    return oriented(f, np.uint64(design), motion(table, place, u), sign)


@inlined
def jet_bounds(f, design, at):
    """The bounds of a design from a state in jets."""
    value, slope = curve(f, design, at)
    return PartBounds(
        value.low,
        value.high,
        known_bound(value.error),
        value.second,
        known_bound(value.third),
        slope.low,
        slope.high,
        slope.error,
    )


@evaluates(Record(PartBounds, (NUMBER,) * len(PartBounds._fields)), COUNT, NUMBER, NUMBER, COUNT)
def part(made, place, middle, reach, design):
    """Bounds of one design over the part |u − middle| ≤ reach of a panel; over all of it if ``reach`` is 1."""
    f, table = made[0]
    at = row_jets(table, place) if reach == 1.0 else part_jets(table, place, middle, reach)
    return jet_bounds(f, np.uint64(design), at)


def many_parts(made: Any, place: int, middles: FloatArray, reaches: FloatArray, designs: Any) -> PartBounds:
    """As ``part``, uncompiled, of many designs, each with a part of its own that is less than the panel."""
    f, table = made[0]
    found: PartBounds = jet_bounds(f, designs, part_jets(table, place, middles, reaches))
    return found


def many_points(made: Any, place: int, u: FloatArray, sign: float, designs: Any) -> tuple[FloatArray, FloatArray]:
    """As ``point``, uncompiled, of many designs."""
    f, table = made[0]
    values, slopes = oriented(f, designs, motion(table, place, u), sign)
    return values, slopes


class Evaluator(NamedTuple):
    """The address of a curve and its motion table, and those of the functions above."""

    made: Any
    nodes: Any
    row: Any
    node: Any
    panel: Any
    point: Any
    part: Any


CURVE = Record(Evaluator, (ADDRESS, *(function.code for function in (nodes, row, node, panel, point, part))))


@inlined
def evaluator(made, address):
    """The addresses for (curve, motion table), which is kept at ``address``."""
    return Evaluator(
        address,
        code_of(nodes, made),
        code_of(row, made),
        code_of(node, made),
        code_of(panel, made),
        code_of(point, made),
        code_of(part, made),
    )
