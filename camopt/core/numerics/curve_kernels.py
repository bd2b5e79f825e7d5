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
from camopt.core.numerics.curves import curve_value, value_and_slope
from camopt.core.numerics.jet import infinite_if_nan
from camopt.core.numerics.piecewise import (
    COUNTS,
    NUMBERS,
    state_at_node,
    state_jets_over_part,
    state_jets_over_row,
    state_on_panel,
    table_as_columns,
    table_rows_as_columns,
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
def fill_node_values(f, table, first_design, count, values):
    """Write the curve of design first + i at node t to values[t, i]."""
    for t in range(table.nodes.shape[0]):
        at, row = state_at_node(table, t), values[t]
        for i in range(np.uint64(count)):  # unsigned: an index that may be negative would keep the loop scalar
            row[i] = value_and_slope(f, np.uint64(first_design) + i, at)[0]


@called_by_address(NONE, COUNT, COUNT, MATRIX_KIND)
def evaluate_nodes(curve_address, first_design, count, values):
    """Write the curve of design first + i at node t to values[t, i]."""
    f, table = curve_address[0]
    fill_node_values(f, table, first_design, count, values)


@evaluate_nodes.array_version
def _evaluate_nodes_in_python(curve_address, first_design, count, values):
    f, table = curve_address[0]
    PLAIN_RUN.add_formula_work_within_limit(len(table.nodes) * count)
    at = state_at_node(table_as_columns(table), ...)
    values[: len(table.nodes), :count] = curve_value(f, slice(first_design, first_design + count), at)


@called_by_address(NONE, COUNT, NUMBER, COUNT, COUNT, BOUNDS_RECORD)
def bound_curves_over_row(curve_address, row, half_width, first_design, count, bounds):
    """Bound the curve of design first + i by jets over a row of the table: a panel or a group of panels."""
    f, table = curve_address[0]
    at = state_jets_over_row(table, row)
    eighth = 0.5 * half_width * half_width  # an eighth of the squared width
    for i in range(np.uint64(count)):
        jet = value_and_slope(f, np.uint64(first_design) + i, at)[0]
        bounds.excess[row, i] = infinite_if_nan(eighth * jet.second + jet.error)
        bounds.third[row, i] = infinite_if_nan(jet.third)
        bounds.error[row, i] = infinite_if_nan(jet.error)


@bound_curves_over_row.array_version
def _bound_curves_over_rows_in_python(curve_address, rows, half_width, first_design, count, bounds):
    """Bound several rows of the table at once: ``rows`` (rows,), ``half_width`` (rows, 1)."""
    f, table = curve_address[0]
    PLAIN_RUN.add_formula_work_within_limit(JET_WORK * len(rows) * count)
    at, eighth = state_jets_over_row(table_rows_as_columns(table, rows), ...), 0.5 * half_width * half_width
    jet = curve_value(f, slice(first_design, first_design + count), at)
    bounds.excess[rows, :count] = infinite_if_nan(eighth * jet.second + jet.error)
    bounds.third[rows, :count] = infinite_if_nan(jet.third)
    bounds.error[rows, :count] = infinite_if_nan(jet.error)


@inline_in_kernels
def oriented_value_and_slope(curve, design, state, sign):
    """Oriented value and slope of a design in a state."""
    value, slope = value_and_slope(curve, design, state)
    return sign * value, sign * slope


@called_by_address(NONE, COUNT, NUMBER, COUNT, COUNTS, COUNT, MATRIX_KIND)
def evaluate_at_node(curve_address, node, sign, first_design, designs, count, values_and_slopes):
    """Evaluate some designs at one node."""
    f, table = curve_address[0]
    at, values, slopes = state_at_node(table, node), values_and_slopes[0], values_and_slopes[1]
    for j in range(np.uint64(count)):
        values[j], slopes[j] = oriented_value_and_slope(f, np.uint64(first_design + designs[j]), at, sign)


@evaluate_at_node.array_version
def _evaluate_at_node_in_python(curve_address, node, sign, first_design, designs, count, values_and_slopes):
    f, table = curve_address[0]
    PLAIN_RUN.add_formula_work_within_limit(count)
    values_and_slopes[0, :count], values_and_slopes[1, :count] = oriented_value_and_slope(
        f, first_design + designs[:count], state_at_node(table, node), sign
    )


@called_by_address(NONE, COUNT, NUMBERS, NUMBER, COUNT, COUNTS, COUNT, MATRIX_KIND)
def evaluate_on_panel(curve_address, panel, u, sign, first_design, designs, count, values_and_slopes):
    """Evaluate some designs on one panel, each at its own u in [−1, 1]."""
    (f, table), values, slopes = curve_address[0], values_and_slopes[0], values_and_slopes[1]
    for j in range(np.uint64(count)):
        at = state_on_panel(table, panel, u[j])
        values[j], slopes[j] = oriented_value_and_slope(f, np.uint64(first_design + designs[j]), at, sign)


@evaluate_on_panel.array_version
def _evaluate_on_panel_in_python(curve_address, panel, u, sign, first_design, designs, count, values_and_slopes):
    PLAIN_RUN.add_formula_work_within_limit(count)
    values_and_slopes[0, :count], values_and_slopes[1, :count] = evaluate_points(
        curve_address, panel, u[:count], sign, first_design + designs[:count]
    )


@called_by_address(Record(tuple, (NUMBER, NUMBER)), COUNT, NUMBER, NUMBER, COUNT)
def evaluate_point(curve_address, panel, u, sign, design):
    """Oriented value and slope of one design at u in [−1, 1] of a panel."""
    f, table = curve_address[0]
    return oriented_value_and_slope(f, np.uint64(design), state_on_panel(table, panel, u), sign)


@inline_in_kernels
def curve_bounds_from_jets(f, design, jet_state):
    """Bounds of a curve from a state of jets."""
    value, slope = value_and_slope(f, design, jet_state)
    return PartBounds(
        value.low,
        value.high,
        infinite_if_nan(value.error),
        value.second,
        infinite_if_nan(value.third),
        slope.low,
        slope.high,
        slope.error,
    )


@called_by_address(Record(PartBounds, (NUMBER,) * len(PartBounds._fields)), COUNT, NUMBER, NUMBER, COUNT)
def bound_curve_over_part(curve_address, panel, middle, half_length, design):
    """Bounds of one design over the part |u − middle| ≤ half_length of a panel; 1 is the whole panel."""
    f, table = curve_address[0]
    at = (
        state_jets_over_row(table, panel)
        if half_length == 1.0
        else state_jets_over_part(table, panel, middle, half_length)
    )
    return curve_bounds_from_jets(f, np.uint64(design), at)


def bound_curves_over_parts(
    curve_address: Any, panel: int, middles: FloatArray, half_lengths: FloatArray, designs: Any
) -> PartBounds:
    """Bounds of many designs, uncompiled, each over its own part of a panel; no part is the whole panel."""
    f, table = curve_address[0]
    bounds: PartBounds = curve_bounds_from_jets(
        f, designs, state_jets_over_part(table, panel, middles, half_lengths)
    )
    return bounds


def evaluate_points(
    curve_address: Any, panel: int, u: FloatArray, sign: float, designs: Any
) -> tuple[FloatArray, FloatArray]:
    """Oriented values and slopes of many designs, uncompiled, each at its own u of a panel."""
    f, table = curve_address[0]
    values, slopes = oriented_value_and_slope(f, designs, state_on_panel(table, panel, u), sign)
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
                bound_curves_over_row,
                evaluate_at_node,
                evaluate_on_panel,
                evaluate_point,
                bound_curve_over_part,
            )
        ),
    ),
)


@inline_in_kernels
def evaluator_with_function_addresses(curve_and_table, address):
    """The evaluator of ``curve_and_table``, a curve and motion table that are kept at ``address``."""
    return Evaluator(
        address,
        function_address(evaluate_nodes, curve_and_table),
        function_address(bound_curves_over_row, curve_and_table),
        function_address(evaluate_at_node, curve_and_table),
        function_address(evaluate_on_panel, curve_and_table),
        function_address(evaluate_point, curve_and_table),
        function_address(bound_curve_over_part, curve_and_table),
    )
