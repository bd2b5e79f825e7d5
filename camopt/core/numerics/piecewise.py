"""Piecewise polynomials, the only form of motion that kernels read.

A turn is cut into *pieces* on which the motion is smooth, and a piece into equal *panels*. On each panel y is a
polynomial of degree 12 in u ∈ [−1, 1]. Derivatives jump only between pieces, so both one-sided values are in the
table. A piece of m panels has m + 1 nodes (panel ends), at which the motion is tabulated.
"""

from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from math import comb
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from camopt.core.kernels.arguments import COUNT, NUMBER, ArgumentKind, Record
from camopt.core.kernels.marks import inline_in_kernels
from camopt.core.numerics import BISECTIONS, UNIT_ROUNDOFF, FloatArray, IndexArray, IntArray
from camopt.core.numerics.load_tables import (
    LoadTable,
    TrainLoadTable,
    load_as_columns,
    load_at_node,
    load_on_panel,
    load_over_part,
    load_over_row,
    select_load_rows,
)
from camopt.core.numerics.panels import (
    displacement_jets_over_part,
    displacement_jets_over_row,
    fourth_derivative,
    fourth_derivative_jet_over_part,
    fourth_derivative_jet_over_row,
    value_and_three_derivatives,
)
from camopt.core.numerics.stable_functions import matrix_product
from camopt.core.numerics.state import State

GROUP_PANELS = 4  # panels of a group
BERNSTEIN_ERROR = 1e-10  # relative room for rounding in the ranges below
LEAST_VALUE = 1e-12  # share of a polynomial's largest value below which a value is rounding
ANGLE_ROUNDINGS = 1.5  # error of the cam angle, in roundings of the stroke's angle
# errors of y, y', y'', y''', y'''' in the table, in roundings of the largest in the stroke
TABLE_ERRORS = (4.0, 8.0, 32.0, 512.0, 16384.0)


class MotionTable(NamedTuple):
    """A programme for kernels, with P panels, Q pieces and N = P + Q nodes; cam angles in rad."""

    coefficients: FloatArray  # (P, TABLE_DEGREE + 1) of y in powers of u
    centre: FloatArray  # (P,) cam angle at u = 0
    half_width: FloatArray  # (P,) cam angle from u = 0 to u = 1
    first_panel: IntArray  # (Q + 1,) first panel of each piece; its first node is first_panel + its number
    kind: IntArray  # (Q,) a bit for the kind of the piece
    nodes: FloatArray  # (N, 5) y, y', y'', y''', y'''' at panel ends, one-sided at the ends of a piece
    group: IntArray  # (P,) row of the group of neighbours that the panel belongs to
    # rows of the following arrays: P panels, then G groups of a few neighbours in the same piece
    low: FloatArray  # (P + G, 5) smallest y, y', y'', y''', y''''
    high: FloatArray  # (P + G, 5) largest y, y', y'', y''', y''''
    most: FloatArray  # (P + G, 7) largest magnitudes of y and its first six derivatives
    error: FloatArray  # (P + G, 5) bounds of the error of y, y', y'', y''', y''''
    load: LoadTable | TrainLoadTable | None  # load that curves read with the motion


class Panels(NamedTuple):
    """Panels of a MotionTable for the search for extremes."""

    first_panel: IntArray
    kind: IntArray
    centre: FloatArray
    half_width: FloatArray
    group: IntArray
    rows: int  # panels and groups


COUNTS, NUMBERS = ArgumentKind(COUNT.name, 1), ArgumentKind(NUMBER.name, 1)
PANEL_RECORD = Record(Panels, (COUNTS, COUNTS, NUMBERS, NUMBERS, COUNTS, COUNT))


def panels_of(table: MotionTable) -> Panels:
    """Panels of a motion table."""
    return Panels(table.first_panel, table.kind, table.centre, table.half_width, table.group, len(table.low))


def table_as_columns(table: MotionTable) -> MotionTable:
    """The table for formulas on all rows or nodes at once (index ``...``): numbers become columns (rows, 1)."""
    columns = {name: getattr(table, name).T[:, :, None] for name in ("nodes", "low", "high", "most", "error")}
    return table._replace(**columns, load=None if table.load is None else load_as_columns(table.load))


def table_rows_as_columns(table: MotionTable, rows: IndexArray) -> MotionTable:
    """The table for formulas on some panels or groups at once."""
    chosen = {name: getattr(table, name)[rows] for name in ("low", "high", "most", "error")}
    load = None if table.load is None else select_load_rows(table.load, rows)
    return table_as_columns(table._replace(**chosen, load=load))


@inline_in_kernels
def state_on_panel(table, panel, u):
    """State of the follower at u of a panel."""
    y, y1, y2, y3 = value_and_three_derivatives(table, panel, u)
    load = load_on_panel(table.load, panel, u * table.half_width[panel])
    return State(y, y1, y2, y3, load, fourth_derivative(table, panel, u))


@inline_in_kernels
def state_at_node(table, node):
    """State of the follower at a node."""
    y = table.nodes[node]
    return State(y[0], y[1], y[2], y[3], load_at_node(table.load, node, 0.0), y[4])


@inline_in_kernels
def state_jets_over_row(table, row):
    """State over a panel or group, in jets."""
    y, y1, y2, y3 = displacement_jets_over_row(table, row)
    return State(y, y1, y2, y3, load_over_row(table.load, row, 0.0), fourth_derivative_jet_over_row(table, row))


@inline_in_kernels
def state_jets_over_part(table, panel, u, half_length):
    """State over the part [u − r, u + r] of a panel, in jets, by the mean value theorem."""
    y, y1, y2, y3 = displacement_jets_over_part(table, panel, u, half_length)
    h = table.half_width[panel]
    load = load_over_part(table.load, panel, (u * h, half_length * h))
    return State(y, y1, y2, y3, load, fourth_derivative_jet_over_part(table, panel, u, half_length))


def node_displacements_and_derivatives(table: Any, first_panel: IntArray) -> FloatArray:
    """y and four derivatives at all nodes (N, 5); between two panels of a piece, those of the second."""
    panels = np.arange(len(table.coefficients))
    pieces = np.repeat(np.arange(len(first_panel) - 1), np.diff(first_panel))
    nodes = np.empty((len(panels) + len(first_panel) - 1, 5))
    for side in (1, 0):
        u = 2.0 * side - 1.0
        rows = (*value_and_three_derivatives(table, panels, u), fourth_derivative(table, panels, u))
        nodes[panels + pieces + side] = np.stack(rows, axis=1)
    return nodes


@cache
def powers_to_bernstein_matrix(degree: int) -> FloatArray:
    """Matrix from powers of u ∈ [−1, 1] to Bernstein coefficients, which enclose the polynomial's range."""

    def blossom(ones: int, power: int) -> int:
        """Elementary symmetric polynomial of ``ones`` ones and minus ones otherwise, exact in integers."""
        chosen = range(power + 1)
        return sum(comb(ones, k) * comb(degree - ones, power - k) * (-1) ** (power - k) for k in chosen)

    powers = range(degree + 1)
    return np.array([[blossom(ones, power) / comb(degree, power) for power in powers] for ones in powers])


def sign_changes(series: FloatArray) -> Iterator[tuple[int, float]]:
    """Places (panel, u) within panels where polynomials (powers, panels) change sign."""
    bounds = matrix_product(powers_to_bernstein_matrix(len(series) - 1), series)
    rounding = LEAST_VALUE * np.abs(bounds).max()
    for panel in np.flatnonzero((bounds.min(axis=0) < -rounding) & (bounds.max(axis=0) > rounding)):
        yield from ((int(panel), u) for u in places_of_sign_change(series[:, panel]))


def places_of_sign_change(series: FloatArray) -> list[float]:
    """Places in (−1, 1) where a polynomial in powers of u changes its sign, in order.

    A polynomial has at most as many roots as its Bernstein coefficients have sign changes, and exactly one root if
    they have one (Descartes' rule). The interval is halved (de Casteljau) until they have one; then the root is
    bisected.
    """
    places, powers = [], series.tolist()
    waiting = [(matrix_product(powers_to_bernstein_matrix(len(series) - 1), series), -1.0, 1.0)]
    while waiting:
        bounds, low, high = waiting.pop()
        signs = np.sign(bounds[np.abs(bounds) > 0.0])
        changes = int(np.count_nonzero(signs[1:] != signs[:-1]))
        middle = 0.5 * (low + high)
        if changes == 1 or (changes % 2 and not low < middle < high):
            places.append(_bisect_root(powers, low, high, float(signs[0])))
        elif changes and low < middle < high:
            left, right = halve_bernstein(bounds)
            waiting.append((right, middle, high))
            if right[0] == 0.0:  # a root where the halves meet is in neither
                neighbours = [*left[left != 0.0][-1:], *right[right != 0.0][:1]]
                waiting.append((np.array(neighbours), middle, middle))
            waiting.append((left, low, middle))
    return places


def _bisect_root(powers: list[float], low: float, high: float, sign: float) -> float:
    """Root of a polynomial that has the sign ``sign`` at ``low`` and another at ``high``."""
    for _ in range(BISECTIONS):
        middle, value = 0.5 * (low + high), 0.0
        for power in reversed(powers):
            value = value * middle + power
        low, high = (middle, high) if value * sign > 0.0 else (low, middle)
    return 0.5 * (low + high)


def halve_bernstein(bounds: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bernstein coefficients of both halves of polynomials (degree + 1, …), by de Casteljau."""
    low, high = bounds.copy(), bounds.copy()
    for k in range(1, len(bounds)):
        high[: len(bounds) - k] = 0.5 * (high[: len(bounds) - k] + high[1 : len(bounds) - k + 1])
        low[k] = high[0]
    return low, high


def group_number_of_each_panel(first_panel: IntArray) -> IntArray:
    """Group of each panel, numbered from the number of panels on. No group crosses the end of a piece."""
    groups: list[int] = []
    for first, last in pairwise(first_panel):
        start = groups[-1] + 1 if groups else int(first_panel[-1])
        groups += [start + k // GROUP_PANELS for k in range(last - first)]
    return np.array(groups, dtype=np.int64)


def derivative_ranges_and_errors(
    coefficients: FloatArray, half_width: FloatArray, stroke: IntArray, group: IntArray
) -> tuple[FloatArray, ...]:
    """The arrays ``low``, ``high``, ``most`` and ``error`` of a MotionTable.

    ``stroke`` is the stroke of each panel. A law's rounding error is relative to its largest value in the stroke.
    On panels that are a small share of the stroke, it is the slope times the rounding of the cam angle, if that is
    larger.
    """
    low, high = np.empty((7, len(half_width))), np.empty((7, len(half_width)))
    series: NDArray[np.floating[Any]] = coefficients.T
    for order in range(7):
        series = polynomial.polyder(series, min(order, 1))
        values = matrix_product(powers_to_bernstein_matrix(len(series) - 1), series) / half_width**order
        room = BERNSTEIN_ERROR * np.abs(values).max(axis=0)
        low[order], high[order] = values.min(axis=0) - room, values.max(axis=0) + room
    most = np.maximum(-low, high)
    error = np.empty((5, len(half_width)))
    slope_error = np.zeros(len(half_width))
    angle_error = ANGLE_ROUNDINGS * UNIT_ROUNDOFF * np.bincount(stroke, 2.0 * half_width)[stroke]
    for order in (4, 3, 2, 1, 0):
        peak = np.zeros(stroke.max() + 1)
        np.maximum.at(peak, stroke, most[order])
        rounded = np.maximum(TABLE_ERRORS[order] * UNIT_ROUNDOFF * peak[stroke], angle_error * most[order + 1])
        error[order] = rounded + half_width * slope_error
        slope_error = error[order] if order < 4 else slope_error  # y'''' only serves for slopes
    starts = np.flatnonzero(np.diff(group, prepend=-1))  # a group's first panel
    return (
        np.vstack([low[:5].T, np.minimum.reduceat(low[:5].T, starts)]),
        *(np.vstack([x.T, np.maximum.reduceat(x.T, starts)]) for x in (high[:5], most, error)),
    )


def external_load_polynomials_by_panel(table: MotionTable) -> FloatArray:
    """External load on the panels in powers of u (powers, P); 0 if it is constant over the turn."""
    load = table.load
    if load is None:
        return np.zeros((2, len(table.centre)))
    if isinstance(load, TrainLoadTable):
        return np.asarray(load.still.coefficients.T)
    return np.array([load.centre, load.slope[: len(table.centre)] * table.half_width])


def train_inertia_polynomials_by_panel(table: MotionTable) -> FloatArray:
    """Inertia force of a train divided by ω², on the panels in powers of u (powers, P); 0 without masses."""
    if isinstance(table.load, TrainLoadTable):
        return np.asarray(table.load.carried.coefficients.T)
    return np.zeros((1, len(table.centre)))
