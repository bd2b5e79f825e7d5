"""Functions that are compiled for each curve: its values, slopes and jets.

The search for extremes is compiled once, and calls these functions by address (``kernels.address_calls``). So code
here costs compile time for each curve, and code of the search does not.

Uncompiled, a formula takes several designs at once, as arrays, with the same bits, and computes no slope where none
is needed. Compiled, an unused slope costs nothing.

``source`` is the address of a curve and its motion table. Designs are numbered from ``first``. ``out`` takes values
in its first row and slopes in its second. ``sign`` orients both: 1 to find the largest, −1 to find the smallest.
"""

from typing import Any, NamedTuple

import numpy as np

from camopt.core.kernels.address_calls import called_by_address, function_address
from camopt.core.kernels.arguments import ADDRESS, COUNT, NONE, NUMBER, Record
from camopt.core.kernels.compile import PLAIN_RUN
from camopt.core.kernels.marks import inline_in_kernels
from camopt.core.numerics import FloatArray
from camopt.core.numerics.curves import value_and_slope, value_of
from camopt.core.numerics.jet import known_bound
from camopt.core.numerics.piecewise import (
    COUNTS,
    NUMBERS,
    columns_of_all_rows,
    columns_of_rows,
    motion_at_node,
    motion_on_panel,
    part_jets,
    row_jets,
)
from camopt.core.numerics.workspace import BOUNDS_RECORD, MATRIX_KIND

JET_WORK = 3  # work of an uncompiled jet, in values of a curve


class PartBounds(NamedTuple):
    """Bounds by jets over a part of a panel: of a curve, its rounding error, |f''|, |f'''| and its slope."""

    low: float
    high: float
    error: float
    second: float
    third: float
    least_slope: float
    most_slope: float
    slope_error: float


@inline_in_kernels
def fill_node_values(f, table, first, count, values):
    """Write the curve of design first + i at node t to values[t, i]."""
    for t in range(table.nodes.shape[0]):
        at, row = motion_at_node(table, t), values[t]
        for i in range(np.uint64(count)):  # unsigned: an index that may be negative would keep the loop scalar
            row[i] = value_and_slope(f, np.uint64(first) + i, at)[0]


@called_by_address(NONE, COUNT, COUNT, MATRIX_KIND)
def evaluate_nodes(source, first, count, values):
    """Write the curve of design first + i at node t to values[t, i]."""
    f, table = source[0]
    fill_node_values(f, table, first, count, values)


@evaluate_nodes.array_version
def _evaluate_nodes_in_python(source, first, count, values):
    f, table = source[0]
    PLAIN_RUN.count(len(table.nodes) * count)
    at = motion_at_node(columns_of_all_rows(table), ...)
    values[: len(table.nodes), :count] = value_of(f, slice(first, first + count), at)


@called_by_address(NONE, COUNT, NUMBER, COUNT, COUNT, BOUNDS_RECORD)
def bound_row(source, place, half_width, first, count, bounds):
    """Bound the curve of design first + i by jets over a row of the table: a panel or a group of panels."""
    f, table = source[0]
    at = row_jets(table, place)
    eighth = 0.5 * half_width * half_width  # an eighth of the squared width
    for i in range(np.uint64(count)):
        jet = value_and_slope(f, np.uint64(first) + i, at)[0]
        bounds.excess[place, i] = known_bound(eighth * jet.second + jet.error)
        bounds.third[place, i] = known_bound(jet.third)
        bounds.error[place, i] = known_bound(jet.error)


@bound_row.array_version
def _bound_rows_in_python(source, place, half_width, first, count, bounds):
    """Bound several rows of the table at once: ``place`` (rows,), ``half_width`` (rows, 1)."""
    f, table = source[0]
    PLAIN_RUN.count(JET_WORK * len(place) * count)
    at, eighth = row_jets(columns_of_rows(table, place), ...), 0.5 * half_width * half_width
    jet = value_of(f, slice(first, first + count), at)
    bounds.excess[place, :count] = known_bound(eighth * jet.second + jet.error)
    bounds.third[place, :count] = known_bound(jet.third)
    bounds.error[place, :count] = known_bound(jet.error)


@inline_in_kernels
def oriented_curve(f, i, at, sign):
    """Oriented value and slope of design ``i`` in a state."""
    value, slope = value_and_slope(f, i, at)
    return sign * value, sign * slope


@called_by_address(NONE, COUNT, NUMBER, COUNT, COUNTS, COUNT, MATRIX_KIND)
def evaluate_at_node(source, place, sign, first, designs, count, out):
    """Evaluate some designs at one node."""
    f, table = source[0]
    at, values, slopes = motion_at_node(table, place), out[0], out[1]
    for j in range(np.uint64(count)):
        values[j], slopes[j] = oriented_curve(f, np.uint64(first + designs[j]), at, sign)


@evaluate_at_node.array_version
def _evaluate_at_node_in_python(source, place, sign, first, designs, count, out):
    f, table = source[0]
    PLAIN_RUN.count(count)
    out[0, :count], out[1, :count] = oriented_curve(f, first + designs[:count], motion_at_node(table, place), sign)


@called_by_address(NONE, COUNT, NUMBERS, NUMBER, COUNT, COUNTS, COUNT, MATRIX_KIND)
def evaluate_on_panel(source, place, angles, sign, first, designs, count, out):
    """Evaluate some designs on one panel, each at its own u in [−1, 1]."""
    (f, table), values, slopes = source[0], out[0], out[1]
    for j in range(np.uint64(count)):
        at = motion_on_panel(table, place, angles[j])
        values[j], slopes[j] = oriented_curve(f, np.uint64(first + designs[j]), at, sign)


@evaluate_on_panel.array_version
def _evaluate_on_panel_in_python(source, place, angles, sign, first, designs, count, out):
    PLAIN_RUN.count(count)
    out[0, :count], out[1, :count] = evaluate_points(source, place, angles[:count], sign, first + designs[:count])


@called_by_address(Record(tuple, (NUMBER, NUMBER)), COUNT, NUMBER, NUMBER, COUNT)
def evaluate_point(source, place, u, sign, design):
    """Oriented value and slope of one design at u in [−1, 1] of a panel."""
    f, table = source[0]
    return oriented_curve(f, np.uint64(design), motion_on_panel(table, place, u), sign)


@inline_in_kernels
def jet_bounds(f, design, at):
    """Bounds of a curve from a state of jets."""
    value, slope = value_and_slope(f, design, at)
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


@called_by_address(Record(PartBounds, (NUMBER,) * len(PartBounds._fields)), COUNT, NUMBER, NUMBER, COUNT)
def bound_part(source, place, middle, reach, design):
    """Bounds of one design over the part |u − middle| ≤ reach of a panel; the whole panel if ``reach`` is 1."""
    f, table = source[0]
    at = row_jets(table, place) if reach == 1.0 else part_jets(table, place, middle, reach)
    return jet_bounds(f, np.uint64(design), at)


def bound_parts(source: Any, place: int, middles: FloatArray, reaches: FloatArray, designs: Any) -> PartBounds:
    """Bounds of many designs, uncompiled, each over its own part of a panel; no part is the whole panel."""
    f, table = source[0]
    bounds: PartBounds = jet_bounds(f, designs, part_jets(table, place, middles, reaches))
    return bounds


def evaluate_points(
    source: Any, place: int, u: FloatArray, sign: float, designs: Any
) -> tuple[FloatArray, FloatArray]:
    """Oriented values and slopes of many designs, uncompiled, each at its own u of a panel."""
    f, table = source[0]
    values, slopes = oriented_curve(f, designs, motion_on_panel(table, place, u), sign)
    return values, slopes


class Evaluator(NamedTuple):
    """Addresses of a curve with its motion table, and of the functions that evaluate it."""

    source: Any
    nodes: Any
    row: Any
    node: Any
    panel: Any
    point: Any
    part: Any


EVALUATOR_RECORD = Record(
    Evaluator,
    (
        ADDRESS,
        *(
            function.code
            for function in (
                evaluate_nodes,
                bound_row,
                evaluate_at_node,
                evaluate_on_panel,
                evaluate_point,
                bound_part,
            )
        ),
    ),
)


@inline_in_kernels
def evaluator(source, address):
    """The evaluator of ``source``, a curve and motion table that are kept at ``address``."""
    return Evaluator(
        address,
        function_address(evaluate_nodes, source),
        function_address(bound_row, source),
        function_address(evaluate_at_node, source),
        function_address(evaluate_on_panel, source),
        function_address(evaluate_point, source),
        function_address(bound_part, source),
    )
