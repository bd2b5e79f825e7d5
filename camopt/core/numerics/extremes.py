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
from camopt.core.numerics.climbing import PeakQuery, allowed_gain, orient_to_maximum, sign_index_range
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
    keep_freed_memory,
    thread_workspace,
    uncompiled_workspace,
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
def write_best_nodes(values, count, panels, kinds, extreme_kind, best, node):
    """Largest oriented node value of each design over pieces of some kinds, and the first node that has it."""
    for i in range(count):
        best[i] = -np.inf
        node[i] = -1
    for q in range(panels.kind.size):
        if panels.kind[q] & kinds:
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
def _write_best_nodes_in_python(values, count, panels, kinds, extreme_kind, best, node):
    piece = np.repeat(np.arange(panels.kind.size), np.diff(panels.first_panel) + 1)
    nodes = np.flatnonzero(panels.kind[piece] & kinds)
    oriented = orient_to_maximum(values[nodes, :count], extreme_kind)
    if np.isnan(oriented).any():  # a NaN stays the best until the next node
        write_best_nodes.py_func(values, count, panels, kinds, extreme_kind, best, node)
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
def choose_candidate_designs(panel, node, count, query, work):
    """Choose the designs that may exceed their best value in a panel by more than allowed; return their number."""
    before, after, excess = work.values[node], work.values[node + 1], work.bounds.excess[panel]
    best, top, error, chosen = work.found.best, work.found.top, work.bounds.error[panel], work.chosen
    many = 0
    for i in range(count):
        bound = max(query.sign * before[i], query.sign * after[i]) + excess[i]
        more = bound > best[i] + allowed_gain(best[i], query.relative_error, error[i])
        chosen[many] = i
        many += more
        top[i] = top[i] if more else max(top[i], bound)
    return many


@choose_candidate_designs.array_version
def _choose_candidate_designs_in_python(panel, node, count, query, work):
    before, after, excess = work.values[node, :count], work.values[node + 1, :count], work.bounds.excess[panel]
    best, top, error = work.found.best[:count], work.found.top[:count], work.bounds.error[panel, :count]
    bound = larger(query.sign * before, query.sign * after) + excess[:count]
    more = bound > best + allowed_gain(best, query.relative_error, error)
    top[:] = np.where(more, top, larger(top, bound))
    chosen = np.flatnonzero(more)
    work.chosen[: chosen.size] = chosen
    return chosen.size


@inline_in_kernels
def may_panel_exceed_best(curve, first, count, panels, panel, node, extreme_kind, work):
    """Whether a panel may exceed the best value of any design, by its jets."""
    before, after = work.values[node], work.values[node + 1]
    for row in (panels.group[panel], panel):  # the bounds of the group are enough for most panels
        if not work.looked[row]:
            call_by_address(curve.row, (curve.source, row, panels.half_width[panel], first, count, work.bounds))
            work.looked[row] = True
        if not may_any_design_exceed_best(
            before, after, work.bounds.excess[row], count, extreme_kind, work.found.best
        ):
            return False
    return True


@may_panel_exceed_best.array_version
def _may_panel_exceed_best_in_python(curve, first, count, panels, panel, node, extreme_kind, work):
    before, after, best = work.values[node], work.values[node + 1], work.found.best
    return all(
        may_any_design_exceed_best(before, after, work.bounds.excess[row], count, extreme_kind, best)
        for row in (panels.group[panel], panel)
    )


@called_by_kernels
def start_extremes_at_best_nodes(panels, kinds, extreme_kind, floor, count, work):
    """Start the extremes of a tile with the best nodes."""
    found = work.found
    write_best_nodes(work.values, count, panels, kinds, extreme_kind, found.best, found.node)
    for i in range(count):
        found.best[i] = max(found.best[i], floor)
        found.top[i], found.rounding[i], found.at[i] = found.best[i], 0.0, node_angle(panels, found.node[i])


@start_extremes_at_best_nodes.array_version
def _start_extremes_in_python(panels, kinds, extreme_kind, floor, count, work):
    found = work.found
    write_best_nodes(work.values, count, panels, kinds, extreme_kind, found.best, found.node)
    found.best[:count] = larger(found.best[:count], floor)
    found.top[:count], found.rounding[:count] = found.best[:count], 0.0
    found.at[:count] = node_angle(panels, found.node[:count])


@inline_in_kernels
def search_panel_for_candidate_designs(curve, first, count, panels, panel_and_node, goal_and_precision, work):
    """Search a panel for the designs whose best value it may exceed, by its jets.

    ``panel_and_node`` is the panel and its first node, ``goal_and_precision`` the goal and the precision.
    """
    (panel, node), (goal, precision) = panel_and_node, goal_and_precision
    one, other = sign_index_range(goal)
    for way in range(one, other):
        ask = PeakQuery(1.0 - 2.0 * way, precision.value, precision.location, np.inf)
        many = choose_candidate_designs(panel, node, count, ask, work)
        if many:
            search_panel_for_chosen_designs(curve, first, many, panels, panel, node, ask, work)


@inline_in_kernels
def find_extremes_of_design_tile(curve, first, count, panels, question, precision, work):
    """Find the extremes of a tile; a question is the kinds of stroke to search, and the goal."""
    kinds, goal = question
    start_extremes_at_best_nodes(panels, kinds, goal, precision.floor, count, work)
    for q in range(panels.kind.size):
        if panels.kind[q] & kinds:
            for p in range(panels.first_panel[q], panels.first_panel[q + 1]):
                if may_panel_exceed_best(curve, first, count, panels, p, p + q, goal, work):
                    search_panel_for_candidate_designs(
                        curve, first, count, panels, (p, p + q), (goal, precision), work
                    )


@find_extremes_of_design_tile.array_version
def _find_extremes_of_tile_in_python(curve, first, count, panels, question, precision, work):
    kinds, goal = question
    start_extremes_at_best_nodes(panels, kinds, goal, precision.floor, count, work)
    evaluate_unknown_row_bounds(curve, first, count, panels, np.unique(panels.group), work)
    panel, piece = panels_that_may_exceed_best(panels, kinds, goal, count, work)
    evaluate_unknown_row_bounds(curve, first, count, panels, panel, work)
    for p, q in zip(panel.tolist(), piece.tolist(), strict=True):
        if may_panel_exceed_best(curve, first, count, panels, p, p + q, goal, work):
            search_panel_for_candidate_designs(curve, first, count, panels, (p, p + q), (goal, precision), work)


def evaluate_unknown_row_bounds(curve, first, count, panels, rows, work):
    """Evaluate the unknown bounds of some panels or groups together."""
    rows = rows[~work.looked[rows]]
    if rows.size:
        widths = np.empty(panels.rows)
        widths[: panels.half_width.size] = widths[panels.group] = panels.half_width
        call_by_address(curve.row, (curve.source, rows, widths[rows, None], first, count, work.bounds))
        work.looked[rows] = True


@inline_in_kernels
def search_again_for_inexact_designs(curve, first, count, panels, question, precision, work):
    """Search again for the designs of a tile whose extremes are not exact enough."""
    kinds, goal = question
    one, other = sign_index_range(goal)
    many = restart_inexact_designs(count, precision, work)
    for q in range(panels.kind.size if many else 0):
        if panels.kind[q] & kinds:
            for p in range(panels.first_panel[q], panels.first_panel[q + 1]):
                if may_panel_exceed_best(curve, first, count, panels, p, p + q, goal, work):
                    for way in range(one, other):
                        sharp = PeakQuery(
                            1.0 - 2.0 * way, precision.value, precision.location, SHARP_SHARE * precision.value
                        )
                        search_panel_for_inexact_designs(curve, first, many, panels, p, p + q, sharp, work)


def panels_that_may_exceed_best(panels, kinds, extreme_kind, count, work):
    """Panels that may exceed the best node by the jets of their groups, and the numbers of their pieces."""
    piece = np.repeat(np.arange(panels.kind.size), np.diff(panels.first_panel))
    panel = np.flatnonzero(panels.kind[piece] & kinds)
    before, after = (
        orient_to_maximum(work.values[panel + piece[panel] + side, :count], extreme_kind) for side in (0, 1)
    )
    most = larger(before, after) + work.bounds.excess[panels.group[panel], :count]
    remaining = panel[np.any(most > work.found.best[:count], axis=1)]
    return remaining, piece[remaining]


@called_by_kernels
def write_extremes(found, count, extreme_kind, value, where, width):
    """Write the extremes of a tile into the answers."""
    for i in range(count):
        value[i] = -found.best[i] if extreme_kind == LEAST else found.best[i]
        where[i] = found.at[i]
        width[i] = max(found.top[i] - found.best[i], 0.0) + 2.0 * found.rounding[i]


@write_extremes.array_version
def _write_extremes_in_python(found, count, extreme_kind, value, where, width):
    best = found.best[:count]
    value[:count], where[:count] = -best if extreme_kind == LEAST else best, found.at[:count]
    width[:count] = larger(found.top[:count] - best, 0.0) + 2.0 * found.rounding[:count]


@partial(compiled, size=SEARCH_SIZE)
def answer_all_questions_on_curve(curve, panels, questions, precision, answers, work):
    """Write the extremes of a curve, an ``Evaluator``, to ``answers`` (3, K, designs)."""
    designs, tile = answers.shape[2], work.middle.size
    for first in range(0, designs, tile):
        count = min(tile, designs - first)
        call_by_address(curve.nodes, (curve.source, first, count, work.values))
        work.looked[:] = False
        for k in range(questions.shape[0]):
            question = (questions[k, 0], questions[k, 1])
            find_extremes_of_design_tile(curve, first, count, panels, question, precision, work)
            search_again_for_inexact_designs(curve, first, count, panels, question, precision, work)
            value, where, width = answers[0, k, first:], answers[1, k, first:], answers[2, k, first:]
            write_extremes(work.found, count, question[1], value, where, width)


@answer_all_questions_on_curve.array_version
def _answer_all_questions_in_python(curve, panels, questions, precision, answers, work):
    answer_all_questions_on_curve.py_func(
        CachingEvaluator(*curve), panels, questions, precision, answers, uncompiled_workspace(panels)
    )


@compiled_once_it_pays(work=SEARCH_WORK)
def search_curve(f, table, panels, questions, precision, answers, work, answer_all_questions_on_curve):
    """Search a curve over a motion table; ``answer_all_questions_on_curve`` is called by its address."""
    source = (f, table)
    call_by_address(
        answer_all_questions_on_curve,
        (
            evaluator_with_function_addresses(source, address_of_values(source)),
            panels,
            questions,
            precision,
            answers,
            work,
        ),
    )


ANSWERS_KIND = ArgumentKind(NUMBER.name, 3)
QUESTIONS_KIND = ArgumentKind(COUNT.name, 2)
SEARCH_ADDRESS = AddressedKernel(
    answer_all_questions_on_curve,
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
