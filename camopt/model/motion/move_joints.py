"""The joints of moves with their neighbours: derivatives at the joints, and the motion between.

A move ends with the derivatives that the scene gives, or else with those at the start of the next dwell or law. It
starts as the stroke before ends. Derivatives between two moves that are free, or have a range, follow from the
least jerk of the whole run of consecutive moves (``move_run``).
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.stable_functions import matrix_product
from camopt.model.motion.law import Law
from camopt.model.motion.move_run import MoveRun, solve_move_run, states_to_bernstein_matrix
from camopt.model.motion.polynomial import PolynomialLaw
from camopt.model.motion.segments import MOVE
from camopt.model.motion.spline import SplineLaw
from camopt.model.motion.stroke import Stroke


@lru_cache(maxsize=256)  # checking a scene and resolving it both need it
def strokes_with_move_laws(strokes: tuple[Stroke, ...]) -> tuple[Stroke, ...]:
    """The strokes of a turn, each move with the law that joins it to its neighbours.

    Raises
    ------
    InfeasibleMoves
        If no motion meets all conditions on a run of moves, or none was found.
    """
    joined = list(strokes)
    for places in _consecutive_move_indices(strokes):
        moves = [strokes[i] for i in places]
        run = MoveRun(moves, strokes[places[0] - 1], strokes[(places[-1] + 1) % len(strokes)], strokes[0].low)
        run, states = solve_move_run(run)
        for i, move, (first, last) in zip(places, moves, run.move_spans, strict=True):
            law = _move_law_from_states(states[first : last + 1], run.angles_between_cuts[first:last])
            joined[i] = replace(move, law=law)
            if any(other.wanted and other.wanted[0] for other in moves):
                start, end = float(states[first, 0]), float(states[last, 0])  # above the start of the run
                low, change = moves[0].low + start * move.size, end - start
                given = move.given and move.given._replace(change=change)
                joined[i] = replace(joined[i], low=low, high=low + change * move.size, given=given)
    return tuple(joined)


def _consecutive_move_indices(strokes: Sequence[Stroke]) -> Iterator[list[int]]:
    """The runs of consecutive moves round the turn, as indices of strokes."""
    count = len(strokes)
    starts = [
        i
        for i, stroke in enumerate(strokes)
        if stroke.law_follows_from_neighbours and not strokes[i - 1].law_follows_from_neighbours
    ]
    if not starts and count and strokes[0].law_follows_from_neighbours:
        starts = [0]
    for start in starts:
        run = [start]
        while len(run) < count and strokes[(run[-1] + 1) % count].law_follows_from_neighbours:
            run.append((run[-1] + 1) % count)
        yield run


def _move_law_from_states(states: FloatArray, angles: FloatArray) -> Law:
    """The law of a move over x from 0 to 1, from the states at its cuts; y counts from its start."""
    from_start = states - states[0] * (np.arange(states.shape[1]) == 0)
    if angles.size == 1:
        start, end = from_start * (angles[0] ** np.arange(states.shape[1]))
        return PolynomialLaw(MOVE, tuple(start.tolist()), tuple(end.tolist()))
    degree = 2 * states.shape[1] - 1
    coefficients = [0.0]
    for angle, ends in zip(angles, pairwise(from_start), strict=True):
        coefficients += matrix_product(states_to_bernstein_matrix(states.shape[1], angle), np.concatenate(ends))[
            1:
        ].tolist()
    cuts = np.cumsum(angles)[:-1] / angles.sum()
    knots = np.concatenate([np.zeros(degree + 1), np.repeat(cuts, degree), np.ones(degree + 1)])
    return SplineLaw(MOVE, degree, tuple(knots.tolist()), tuple(coefficients))
