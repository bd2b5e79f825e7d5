"""Extremes of a curve over the continuous turn, enclosed from both sides, for many designs at once.

The search for a maximum:

1. Evaluate the curve for a tile of designs at the nodes of the panels; the best node is the first answer. 2. Bound
the derivatives and the rounding error by jets, first over groups of panels, then over the open panels. In a
   panel of width w, the curve exceeds its end values by at most |f''|·w²/8. Panels that cannot exceed the best node
   are dropped; two or three remain.
3. There, the slopes at both ends and a bound of the third derivative bound f''. Where the curve is concave, its
maximum
   is at an end or at a root of the slope. A bracketed secant (``climbing``) finds the root, until slope²/(2·|f''|),
   a bound of the remaining gain, is below the allowed error.
4. Parts that are not concave are halved (``halving``).

The innermost loops run over designs, so that they can be vectorised; only the halving takes designs one by one. An
answer is the largest value found, and a bound of its distance from the true extreme.

The search is compiled once. The functions that evaluate a curve are compiled for each curve and called by address.
"""

from functools import partial
from typing import Any, NamedTuple

import numpy as np

from camopt.core.kernels.address_calls import AddressedKernel, address_of_values, call_by_address
from camopt.core.kernels.arguments import COUNT, NUMBER, ArgumentKind, Record, as_pinned_tuple
from camopt.core.kernels.compile import compiled, compiled_once_it_pays
from camopt.core.kernels.marks import called_by_kernels, inline_in_kernels
from camopt.core.numerics import LEAST, UNIT_ROUNDOFF, FloatArray
from camopt.core.numerics.climbing import PeakQuery, allowed_gain, orient_to_maximum, range_of_search_signs
from camopt.core.numerics.curve_kernels import EVALUATOR_RECORD, evaluator_with_function_addresses
from camopt.core.numerics.curves import LOADED_CURVES
from camopt.core.numerics.identity_cache import cached_by_identity
from camopt.core.numerics.jet import larger
from camopt.core.numerics.panel_prefetch import CachingEvaluator
from camopt.core.numerics.panel_search import (
    restart_inexact_designs,
    search_panel_for_chosen_designs,
    search_panel_for_inexact_designs,
)
from camopt.core.numerics.piecewise import PANEL_RECORD, MotionTable, Panels, panels_of
from camopt.core.numerics.workspace import (
    PLAIN_TILE,
    WORKSPACE_RECORD,
    empty_workspace_for_uncompiled_search,
    keep_freed_memory,
    thread_workspace,
)

SHARP_SHARE = 0.25  # share of the allowed error that rounding may take in a part that is searched again
SEARCH_SIZE = 5.0  # compile time of the search divided by that of a curve, with the import of numba
SEARCH_WORK = 30.0  # values of a curve that a search evaluates for each number of its answer
TIE_TOLERANCE = 8.0 * UNIT_ROUNDOFF  # relative difference that rounding alone explains


class Precision(NamedTuple):
    """Allowed errors: relative of extremes, and of their cam angles [rad], or inf.

    Extremes below ``floor`` are returned as ``floor``; smallest values above −floor as −floor.
    """

    value: float
    location: float
    floor: float = -np.inf


PRECISION_RECORD = Record(Precision, (NUMBER, NUMBER, NUMBER))


class Extremes(NamedTuple):
    """Extremes (questions, designs): values, their cam angles [rad], and half-widths of their enclosures.

    The largest magnitude has no sign. A true extreme differs from its value by at most ``width``.
    """

    value: FloatArray
    where: FloatArray
    width: FloatArray


@called_by_kernels
def write_best_nodes(values, count, panels, stroke_kinds, extreme_kind, best, node):
    """Largest oriented node value of each design over pieces of some kinds, and the first node that has it."""
    for i in range(count):
        best[i] = -np.inf
        node[i] = -1
    for q in range(panels.kind.size):
        if panels.kind[q] & stroke_kinds:
            for t in range(panels.first_panel[q] + q, panels.first_panel[q + 1] + q + 1):
                row = values[t]
                for i in range(count):
                    value = orient_to_maximum(row[i], extreme_kind)
                    node[i] = (
                        t
                        if value > max(best[i] * (1.0 + TIE_TOLERANCE), best[i] * (1.0 - TIE_TOLERANCE))
                        else node[i]
                    )
                    best[i] = max(value, best[i])


@write_best_nodes.array_version
def _write_best_nodes_in_python(values, count, panels, stroke_kinds, extreme_kind, best, node):
    piece = np.repeat(np.arange(panels.kind.size), np.diff(panels.first_panel) + 1)
    nodes = np.flatnonzero(panels.kind[piece] & stroke_kinds)
    oriented = orient_to_maximum(values[nodes, :count], extreme_kind)
    if np.isnan(oriented).any():  # a NaN stays the best until the next node
        write_best_nodes.py_func(values, count, panels, stroke_kinds, extreme_kind, best, node)
        return
    most = np.full((len(oriented) + 1, count), -np.inf)
    for t in range(len(oriented)):  # a fifth of the time of np.maximum.accumulate
        np.maximum(most[t], oriented[t], out=most[t + 1])
    more = oriented > larger(most[:-1] * (1.0 + TIE_TOLERANCE), most[:-1] * (1.0 - TIE_TOLERANCE))
    last = nodes[::-1][more[::-1].argmax(axis=0)]
    best[:count], node[:count] = most[-1], np.where(more.any(axis=0), last, -1)


@called_by_kernels
def node_angle(panels, node):
    """Cam angle of a node [rad]."""
    q = 0
    while panels.first_panel[q + 1] + q < node:
        q += 1
    panel = min(node - q, panels.first_panel[q + 1] - 1)
    side = -1.0 if node - q == panel else 1.0
    return panels.centre[panel] + side * panels.half_width[panel]


@node_angle.array_version
def _node_angle_in_python(panels, node):
    q = np.searchsorted(panels.first_panel[1:] + np.arange(panels.kind.size), node)
    panel = np.minimum(node - q, panels.first_panel[q + 1] - 1)
    return panels.centre[panel] + np.where(node - q == panel, -1.0, 1.0) * panels.half_width[panel]


@called_by_kernels
def may_any_design_exceed_best(start_values, end_values, largest_rise, design_count, extreme_kind, best):
    """Whether a panel may exceed the best value of any design."""
    exceeds = False
    for i in range(design_count):
        exceeds |= (
            max(orient_to_maximum(start_values[i], extreme_kind), orient_to_maximum(end_values[i], extreme_kind))
            + largest_rise[i]
            > best[i]
        )
    return exceeds


@may_any_design_exceed_best.array_version
def _may_designs_exceed_best_in_python(start_values, end_values, largest_rise, design_count, extreme_kind, best):
    ends = larger(
        orient_to_maximum(start_values[:design_count], extreme_kind),
        orient_to_maximum(end_values[:design_count], extreme_kind),
    )
    return bool(np.any(ends + largest_rise[:design_count] > best[:design_count]))


@called_by_kernels
def choose_candidate_designs(panel, node, count, query, workspace):
    """Choose the designs that may exceed their best value in a panel by more than allowed; return their number."""
    before, after, excess = workspace.values[node], workspace.values[node + 1], workspace.bounds.excess[panel]
    best, top, error, chosen = (
        workspace.found.best,
        workspace.found.top,
        workspace.bounds.error[panel],
        workspace.chosen,
    )
    many = 0
    for i in range(count):
        bound = max(query.sign * before[i], query.sign * after[i]) + excess[i]
        more = bound > best[i] + allowed_gain(best[i], query.relative_error, error[i])
        chosen[many] = i
        many += more
        top[i] = top[i] if more else max(top[i], bound)
    return many


@choose_candidate_designs.array_version
def _choose_candidate_designs_in_python(panel, node, count, query, workspace):
    before, after, excess = (
        workspace.values[node, :count],
        workspace.values[node + 1, :count],
        workspace.bounds.excess[panel],
    )
    best, top, error = (
        workspace.found.best[:count],
        workspace.found.top[:count],
        workspace.bounds.error[panel, :count],
    )
    bound = larger(query.sign * before, query.sign * after) + excess[:count]
    more = bound > best + allowed_gain(best, query.relative_error, error)
    top[:] = np.where(more, top, larger(top, bound))
    chosen = np.flatnonzero(more)
    workspace.chosen[: chosen.size] = chosen
    return chosen.size


@inline_in_kernels
def may_panel_exceed_best(curve, first_design, count, panels, panel, node, extreme_kind, workspace):
    """Whether a panel may exceed the best value of any design, by its jets."""
    before, after = workspace.values[node], workspace.values[node + 1]
    for row in (panels.group[panel], panel):  # the bounds of the group are enough for most panels
        if not workspace.looked[row]:
            call_by_address(
                curve.row, (curve.source, row, panels.half_width[panel], first_design, count, workspace.bounds)
            )
            workspace.looked[row] = True
        if not may_any_design_exceed_best(
            before, after, workspace.bounds.excess[row], count, extreme_kind, workspace.found.best
        ):
            return False
    return True


@may_panel_exceed_best.array_version
def _may_panel_exceed_best_in_python(curve, first_design, count, panels, panel, node, extreme_kind, workspace):
    before, after, best = workspace.values[node], workspace.values[node + 1], workspace.found.best
    return all(
        may_any_design_exceed_best(before, after, workspace.bounds.excess[row], count, extreme_kind, best)
        for row in (panels.group[panel], panel)
    )


@called_by_kernels
def start_extremes_at_best_nodes(panels, stroke_kinds, extreme_kind, floor, count, workspace):
    """Start the extremes of a tile with the best nodes."""
    found = workspace.found
    write_best_nodes(workspace.values, count, panels, stroke_kinds, extreme_kind, found.best, found.node)
    for i in range(count):
        found.best[i] = max(found.best[i], floor)
        found.top[i], found.rounding[i], found.at[i] = found.best[i], 0.0, node_angle(panels, found.node[i])


@start_extremes_at_best_nodes.array_version
def _start_extremes_in_python(panels, stroke_kinds, extreme_kind, floor, count, workspace):
    found = workspace.found
    write_best_nodes(workspace.values, count, panels, stroke_kinds, extreme_kind, found.best, found.node)
    found.best[:count] = larger(found.best[:count], floor)
    found.top[:count], found.rounding[:count] = found.best[:count], 0.0
    found.at[:count] = node_angle(panels, found.node[:count])


@inline_in_kernels
def search_panel_for_candidate_designs(
    curve, first_design, count, panels, panel_and_node, goal_and_precision, workspace
):
    """Search a panel for the designs whose best value it may exceed, by its jets.

    ``panel_and_node`` is the panel and its first node, ``goal_and_precision`` the goal and the precision.
    """
    (panel, node), (goal, precision) = panel_and_node, goal_and_precision
    one, other = range_of_search_signs(goal)
    for way in range(one, other):
        ask = PeakQuery(1.0 - 2.0 * way, precision.value, precision.location, np.inf)
        many = choose_candidate_designs(panel, node, count, ask, workspace)
        if many:
            search_panel_for_chosen_designs(curve, first_design, many, panels, panel, node, ask, workspace)


@inline_in_kernels
def find_extremes_of_design_tile(curve, first_design, count, panels, question, precision, workspace):
    """Find the extremes of a tile; a question is the kinds of stroke to search, and the goal."""
    kinds, goal = question
    start_extremes_at_best_nodes(panels, kinds, goal, precision.floor, count, workspace)
    for q in range(panels.kind.size):
        if panels.kind[q] & kinds:
            for p in range(panels.first_panel[q], panels.first_panel[q + 1]):
                if may_panel_exceed_best(curve, first_design, count, panels, p, p + q, goal, workspace):
                    search_panel_for_candidate_designs(
                        curve, first_design, count, panels, (p, p + q), (goal, precision), workspace
                    )


@find_extremes_of_design_tile.array_version
def _search_tile_in_python(curve, first_design, count, panels, question, precision, workspace):
    kinds, goal = question
    start_extremes_at_best_nodes(panels, kinds, goal, precision.floor, count, workspace)
    evaluate_unknown_row_bounds(curve, first_design, count, panels, np.unique(panels.group), workspace)
    panel, piece = panels_that_may_exceed_best(panels, kinds, goal, count, workspace)
    evaluate_unknown_row_bounds(curve, first_design, count, panels, panel, workspace)
    for p, q in zip(panel.tolist(), piece.tolist(), strict=True):
        if may_panel_exceed_best(curve, first_design, count, panels, p, p + q, goal, workspace):
            search_panel_for_candidate_designs(
                curve, first_design, count, panels, (p, p + q), (goal, precision), workspace
            )


def evaluate_unknown_row_bounds(curve, first_design, count, panels, rows, workspace):
    """Evaluate the unknown bounds of some panels or groups together."""
    rows = rows[~workspace.looked[rows]]
    if rows.size:
        widths = np.empty(panels.rows)
        widths[: panels.half_width.size] = widths[panels.group] = panels.half_width
        call_by_address(curve.row, (curve.source, rows, widths[rows, None], first_design, count, workspace.bounds))
        workspace.looked[rows] = True


@inline_in_kernels
def search_again_for_inexact_designs(curve, first_design, count, panels, question, precision, workspace):
    """Search again for the designs of a tile whose extremes are not exact enough."""
    kinds, goal = question
    one, other = range_of_search_signs(goal)
    many = restart_inexact_designs(count, precision, workspace)
    for q in range(panels.kind.size if many else 0):
        if panels.kind[q] & kinds:
            for p in range(panels.first_panel[q], panels.first_panel[q + 1]):
                if may_panel_exceed_best(curve, first_design, count, panels, p, p + q, goal, workspace):
                    for way in range(one, other):
                        sharp = PeakQuery(
                            1.0 - 2.0 * way, precision.value, precision.location, SHARP_SHARE * precision.value
                        )
                        search_panel_for_inexact_designs(
                            curve, first_design, many, panels, p, p + q, sharp, workspace
                        )


def panels_that_may_exceed_best(panels, stroke_kinds, extreme_kind, count, workspace):
    """Panels that may exceed the best node by the jets of their groups, and the numbers of their pieces."""
    piece = np.repeat(np.arange(panels.kind.size), np.diff(panels.first_panel))
    panel = np.flatnonzero(panels.kind[piece] & stroke_kinds)
    before, after = (
        orient_to_maximum(workspace.values[panel + piece[panel] + side, :count], extreme_kind) for side in (0, 1)
    )
    most = larger(before, after) + workspace.bounds.excess[panels.group[panel], :count]
    remaining = panel[np.any(most > workspace.found.best[:count], axis=1)]
    return remaining, piece[remaining]


@called_by_kernels
def write_extremes_of_tile(tile_extremes, count, extreme_kind, value, angle, width):
    """Write the extremes of a tile into the answers."""
    for i in range(count):
        value[i] = -tile_extremes.best[i] if extreme_kind == LEAST else tile_extremes.best[i]
        angle[i] = tile_extremes.at[i]
        width[i] = max(tile_extremes.top[i] - tile_extremes.best[i], 0.0) + 2.0 * tile_extremes.rounding[i]


@write_extremes_of_tile.array_version
def _write_extremes_of_tile_in_python(tile_extremes, count, extreme_kind, value, angle, width):
    best = tile_extremes.best[:count]
    value[:count], angle[:count] = -best if extreme_kind == LEAST else best, tile_extremes.at[:count]
    width[:count] = larger(tile_extremes.top[:count] - best, 0.0) + 2.0 * tile_extremes.rounding[:count]


@partial(compiled, size=SEARCH_SIZE)
def write_all_extremes_of_curve(curve, panels, questions, precision, answers, workspace):
    """Write the extremes of a curve, an ``Evaluator``, to ``answers`` (3, K, designs)."""
    designs, tile = answers.shape[2], workspace.middle.size
    for first in range(0, designs, tile):
        count = min(tile, designs - first)
        call_by_address(curve.nodes, (curve.source, first, count, workspace.values))
        workspace.looked[:] = False
        for k in range(questions.shape[0]):
            question = (questions[k, 0], questions[k, 1])
            find_extremes_of_design_tile(curve, first, count, panels, question, precision, workspace)
            search_again_for_inexact_designs(curve, first, count, panels, question, precision, workspace)
            value, where, width = answers[0, k, first:], answers[1, k, first:], answers[2, k, first:]
            write_extremes_of_tile(workspace.found, count, question[1], value, where, width)


@write_all_extremes_of_curve.array_version
def _write_all_extremes_in_python(curve, panels, questions, precision, answers, workspace):
    write_all_extremes_of_curve.py_func(
        CachingEvaluator(*curve),
        panels,
        questions,
        precision,
        answers,
        empty_workspace_for_uncompiled_search(panels),
    )


@compiled_once_it_pays(work=SEARCH_WORK)
def search_curve(f, table, panels, questions, precision, answers, workspace, search_address):
    """Search a curve over a motion table; ``search_address`` is called by its address."""
    source = (f, table)
    call_by_address(
        search_address,
        (
            evaluator_with_function_addresses(source, address_of_values(source)),
            panels,
            questions,
            precision,
            answers,
            workspace,
        ),
    )


ANSWERS_KIND = ArgumentKind(NUMBER.name, 3)
QUESTIONS_KIND = ArgumentKind(COUNT.name, 2)
SEARCH_ADDRESS = AddressedKernel(
    write_all_extremes_of_curve,
    (EVALUATOR_RECORD, PANEL_RECORD, QUESTIONS_KIND, PRECISION_RECORD, ANSWERS_KIND, WORKSPACE_RECORD),
)


def extremes_of_curve(
    f: Any, design_count: int, table: MotionTable, questions: Any, precision: Precision
) -> Extremes:
    """Extremes of a curve for designs 0 … designs − 1.

    ``questions`` (K, 2) has the kinds of stroke to search and the goal.
    """
    if design_count > PLAIN_TILE:
        keep_freed_memory()
    answers, question_array = np.empty((3, len(questions), design_count)), np.array(questions, np.int64)
    turn = _pinned_table_and_panels(table, type(f) in LOADED_CURVES)
    with np.errstate(all="ignore"):  # uncompiled, jets without bounds would warn
        search_curve(f, *turn, question_array, precision, answers, thread_workspace(turn[1]), SEARCH_ADDRESS)
    return Extremes(*answers)


@cached_by_identity(maxsize=64)
def _pinned_table_and_panels(table: MotionTable, keeps_load: bool) -> tuple[MotionTable, Panels]:
    """A motion table and its panels for kernels. Without the load, turns with and without one share a kernel."""
    table = table if keeps_load else table._replace(load=None)
    return as_pinned_tuple(table), as_pinned_tuple(panels_of(table))
