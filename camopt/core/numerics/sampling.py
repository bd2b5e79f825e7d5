"""Extremes by sampling, the common method, made as fast as possible for a comparison with enclosures."""

from typing import Any

import numpy as np

from camopt.core.kernels.compile import compiled
from camopt.core.kernels.marks import inline_in_kernels
from camopt.core.numerics import LEAST
from camopt.core.numerics.climbing import orient_to_maximum
from camopt.core.numerics.curve_kernels import fill_node_values
from camopt.core.numerics.extremes import write_best_nodes
from camopt.core.numerics.piecewise import MotionTable
from camopt.core.numerics.workspace import ROW_LENGTH, TILE


@inline_in_kernels
def has_neighbours_in_piece(table, node):
    """Whether both neighbours of a sample are in the same piece."""
    inside = False
    for q in range(table.kind.size):
        inside |= (table.first_panel[q] + q < node) & (node < table.first_panel[q + 1] + q)
    return inside


def write_sampled_extremes(
    f: Any, design_count: int, table: MotionTable, questions: Any, polish: bool, largest_samples: Any
) -> None:
    """Write the largest sample by question (as in ``extremes``) and design to ``largest_samples`` (K, designs).

    The nodes of the table are the samples. With ``polish``, it is the vertex of the parabola through the best
    sample and its neighbours in the same stroke.
    """
    values, best, node = np.empty((len(table.nodes), ROW_LENGTH)), np.empty(TILE), np.empty(TILE, np.int64)
    _write_sampled_extremes(f, design_count, table, questions, polish, largest_samples, (values, best, node))


@compiled
def _write_sampled_extremes(f, design_count, table, questions, polish, largest_samples, buffers):
    values, best, node = buffers
    for first in range(0, design_count, TILE):
        count = min(TILE, design_count - first)
        fill_node_values(f, table, first, count, values)
        for k in range(questions.shape[0]):
            kinds, goal = questions[k, 0], questions[k, 1]
            write_best_nodes(values, count, table, kinds, goal, best, node)
            for i in range(count):
                top, t = best[i], node[i]
                if polish and has_neighbours_in_piece(table, t):
                    left, right = (
                        orient_to_maximum(values[t - 1, i], goal),
                        orient_to_maximum(values[t + 1, i], goal),
                    )
                    bend = left - 2.0 * top + right
                    if left <= top and right <= top and bend < 0.0:
                        top -= (left - right) ** 2 / (8.0 * bend)
                largest_samples[k, first + i] = -top if goal == LEAST else top
