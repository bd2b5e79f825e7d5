"""Where moves meet what is beside them: the velocity, acceleration and jerk there, and the polynomials between.

A move ends with the derivatives that it was given, or else with those that the dwell or law after it starts with.
It starts as what is before it ends. Derivatives between two moves that neither gives are those of the least
∫ (y‴)² dθ over the run of moves: a spline of degree 5 with four continuous derivatives, where only positions are
given. If a move of a run is given a jerk, the run has a continuous jerk (degree 7) and the least ∫ (y⁗)² dθ.

Source: de Boor, A Practical Guide to Splines, ch. V and XIII (natural splines; minimum of a quadratic form).
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise
from math import perm

import numpy as np
from numpy.polynomial import polynomial

from camopt.motion.polynomial import PolynomialLaw
from camopt.motion.stroke import Stroke
from camopt.numerics import FloatArray

State = FloatArray
"""Of the follower at a joint: y, y', y'' and, where it is matched, y''', by the cam angle in rad; mm or deg."""

MOVE = "move"
SMOOTH, SMOOTHER = 3, 4  # numbers of a state: up to the acceleration, up to the jerk


def joined(strokes: Sequence[Stroke]) -> tuple[Stroke, ...]:
    """The strokes of a turn, each move among them with the polynomial that joins it to what is beside it."""
    found = list(strokes)
    for run in _runs(strokes):
        moves = [strokes[i] for i in run]
        states = _states(moves, strokes[run[0] - 1], strokes[(run[-1] + 1) % len(strokes)])
        for i, move, (before, after) in zip(run, moves, pairwise(states), strict=True):
            found[i] = replace(move, law=_between(before, after, move.angle))
    return tuple(found)


def _runs(strokes: Sequence[Stroke]) -> Iterator[list[int]]:
    """The moves that follow each other, round the turn, by their places."""
    count = len(strokes)
    starts = [i for i, stroke in enumerate(strokes) if stroke.is_open and not strokes[i - 1].is_open]
    if not starts and count and strokes[0].is_open:
        starts = [0]
    for start in starts:
        run = [start]
        while len(run) < count and strokes[(run[-1] + 1) % count].is_open:
            run.append((run[-1] + 1) % count)
        yield run


def _between(before: State, after: State, angle: float) -> PolynomialLaw:
    """The polynomial from one state to the next, over x from 0 to 1; the displacement is counted from its start."""
    powers = angle ** np.arange(len(before))
    start, end = before * powers, after * powers
    start[0], end[0] = 0.0, after[0] - before[0]
    return PolynomialLaw(MOVE, tuple(start.tolist()), tuple(end.tolist()))


# ---------------------------------------------------------------------------------------------------- states


def _states(moves: Sequence[Stroke], before: Stroke, after: Stroke) -> list[State]:
    """The states at the joints of a run of moves, the first and the last included, from what is beside it."""
    count = SMOOTHER if any(value is not None for move in moves for value in (move.wanted or ())[2:]) else SMOOTH
    states = np.full((len(moves) + 1, count), np.nan)
    states[:, 0] = np.cumsum([0.0, *(move.given.change if move.given else 0.0 for move in moves)])
    unit = moves[0].given.unit if moves[0].given else 1.0
    alone = before.is_open  # the turn has moves only, and ends where it starts
    if not alone:
        states[0, 1:] = _end_of(before, 1.0)[1:count] / unit
        states[-1, 1:] = _end_of(after, 0.0)[1:count] / unit
    for move, state in zip(moves, states[1:], strict=True):
        wanted = np.array([np.nan if value is None else value for value in (move.wanted or ())[: count - 1]])
        given = np.flatnonzero(~np.isnan(wanted))
        state[1 + given] = wanted[given]
    if alone:
        states[0, 1:] = states[-1, 1:]
    _fill(states, np.array([move.angle for move in moves]), alone)
    return list(states)


def _end_of(stroke: Stroke, x: float) -> FloatArray:
    """y, y', y'', y''' where a stroke starts (x = 0) or ends (x = 1)."""
    return stroke.motion(np.array([stroke.start + x * stroke.angle]))[:, 0]


def _fill(states: FloatArray, angles: FloatArray, alone: bool) -> None:
    """Put those of the least integral in place of unknown derivatives; ``alone``, the last joint is the first."""
    joints, count = states.shape
    scale = angles.mean() ** np.arange(count)
    place = np.arange(joints * count).reshape(joints, count)
    if alone:
        place[-1, 1:] = place[0, 1:]
    form = np.zeros((joints * count, joints * count))
    for i, share in enumerate(angles / angles.mean()):
        here = place[i : i + 2].ravel()
        powers = np.tile(share ** np.arange(count), 2)
        form[np.ix_(here, here)] += share ** (1 - 2 * count) * powers[:, None] * _squares(count) * powers
    known = (states * scale).ravel()
    free = np.unique(place.ravel()[np.isnan(known)])
    if not free.size:
        return
    size = 1.0 / np.sqrt(np.diag(form)[free])
    pull = form[free] @ np.nan_to_num(known)
    known[free] = -size * np.linalg.solve(size[:, None] * form[np.ix_(free, free)] * size, size * pull)
    states[:] = known[place] / scale


@cache
def _squares(count: int) -> FloatArray:
    """The quadratic form of ∫₀¹ (p⁽ᵏ⁾)² dx, k = ``count``, in p, p', … at 0 and at 1, for p of degree 2k − 1."""
    orders, degrees = range(count), range(2 * count)
    ends = [[perm(n, k) * x ** max(n - k, 0) for n in degrees] for x in (0, 1) for k in orders]
    powers = np.linalg.inv(np.array(ends, dtype=float))  # in a column one of these derivatives is 1, the others 0
    nodes, weights = np.polynomial.legendre.leggauss(count)
    values = polynomial.polyval((nodes + 1) / 2, polynomial.polyder(powers, count))
    return np.asarray(values * weights / 2 @ values.T)
