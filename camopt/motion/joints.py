"""Where moves meet what is beside them: the velocity, acceleration and jerk there, and the polynomials between.

A move ends with the derivatives that it was given, or else with those that the dwell or law after it starts with.
It starts as what is before it ends. What is not given between two moves, or given as a range, is as for the least
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
from camopt.motion.segments import MOVE
from camopt.motion.stroke import Stroke, range_of
from camopt.numerics import FloatArray

State = FloatArray
"""Of the follower at a joint: y, y', y'' and, where it is matched, y''', by the cam angle in rad; mm or deg."""

NARROW = 1e-12  # of the run's largest number: ranges no wider are single numbers
SMOOTH, SMOOTHER = 3, 4  # numbers of a state: up to the acceleration, up to the jerk


def joined(strokes: Sequence[Stroke]) -> tuple[Stroke, ...]:
    """The strokes of a turn, each move among them with the polynomial that joins it to what is beside it."""
    found = list(strokes)
    for run in _runs(strokes):
        moves = [strokes[i] for i in run]
        states = _states(moves, strokes[run[0] - 1], strokes[(run[-1] + 1) % len(strokes)], strokes[0].low)
        for i, move, (before, after) in zip(run, moves, pairwise(states), strict=True):
            found[i] = replace(move, law=_between(before, after, move.angle))
        if any(move.wanted and move.wanted[0] for move in moves):
            for i, before in zip(run, states, strict=False):
                found[i] = _placed(found[i], moves[0].low, float(before[0]))
    return tuple(found)


def _placed(move: Stroke, start: float, height: float) -> Stroke:
    """A move that starts at a height above the start of its run, and ends where its polynomial does."""
    assert isinstance(move.law, PolynomialLaw)
    assert move.given
    low, change = start + height * move.size, move.law.end[0]
    return replace(move, low=low, high=low + change * move.size, given=move.given._replace(change=change))


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


def _states(moves: Sequence[Stroke], before: Stroke, after: Stroke, start: float) -> list[State]:
    """The states at the joints of a run of moves, the first and the last included, from what is beside it.

    Displacements are counted from the start of the run; ``start`` is that at the start of the turn.
    """
    jerks = [value for move in moves for value in (move.wanted or ())[3:]]
    count = SMOOTHER if any(value is not None for value in jerks) else SMOOTH
    low, high = np.full((2, len(moves) + 1, count), [[[-np.inf]], [[np.inf]]])
    unit = moves[0].size
    low[:, 0] = high[:, 0] = np.cumsum([0.0, *(move.given.change if move.given else 0.0 for move in moves)])
    alone = before.is_open  # the turn has moves only, and ends where it starts
    if not alone:
        low[0, 1:] = high[0, 1:] = _end_of(before, 1.0)[1:count] / unit
        low[-1, 1:] = high[-1, 1:] = _end_of(after, 0.0)[1:count] / unit
    from_turn = (start - moves[0].low) / unit
    for joint, move in enumerate(moves, start=1):
        for order, asked in enumerate((move.wanted or ())[:count]):
            if asked is not None:
                low[joint, order], high[joint, order] = np.array(range_of(asked)) + (order == 0) * from_turn
    if alone:
        low[0, 1:], high[0, 1:] = low[-1, 1:], high[-1, 1:]
    return list(_least(low, high, np.array([move.angle for move in moves]), alone))


def _end_of(stroke: Stroke, x: float) -> FloatArray:
    """y, y', y'', y''' where a stroke starts (x = 0) or ends (x = 1)."""
    return stroke.motion(np.array([stroke.start + x * stroke.angle]))[:, 0]


def _least(low: FloatArray, high: FloatArray, angles: FloatArray, alone: bool) -> FloatArray:
    """The states of the least integral within their ranges; ``alone``, the last joint is the first."""
    joints, count = low.shape
    scale = angles.mean() ** np.arange(count)
    place = np.arange(joints * count).reshape(joints, count)
    if alone:
        place[-1, 1:] = place[0, 1:]
    form = np.zeros((joints * count, joints * count))
    for i, share in enumerate(angles / angles.mean()):
        here = place[i : i + 2].ravel()
        powers = np.tile(share ** np.arange(count), 2)
        form[np.ix_(here, here)] += share ** (1 - 2 * count) * powers[:, None] * _squares(count) * powers
    low, high = (low * scale).ravel(), (high * scale).ravel()
    fixed = high - low <= NARROW * np.abs(np.nan_to_num([low, high], posinf=0.0, neginf=0.0)).max()
    states = np.where(fixed, low, 0.0)
    free = np.unique(place.ravel()[~fixed])
    if free.size:
        size = 1.0 / np.sqrt(np.diag(form)[free])
        square, pull = size[:, None] * form[np.ix_(free, free)] * size, size * (form[free] @ states)
        states[free] = size * _bottom(square, pull, low[free] / size, high[free] / size)
    return np.asarray(states[place] / scale)


def _bottom(square: FloatArray, pull: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Where xᵀ·S·x/2 + p·x is least for low ≤ x ≤ high."""
    bottom = np.linalg.solve(square, -pull)
    if np.all((low <= bottom) & (bottom <= high)):
        return np.asarray(bottom)
    from scipy.optimize import lsq_linear  # bounded least squares: |Lᵀ·x + L⁻¹·p| with S = L·Lᵀ

    root = np.linalg.cholesky(square)
    found = lsq_linear(root.T, np.linalg.solve(root, -pull), (low, high), method="bvls", tol=1e-14)
    return np.asarray(np.clip(found.x, low, high))


@cache
def _squares(count: int) -> FloatArray:
    """The quadratic form of ∫₀¹ (p⁽ᵏ⁾)² dx, k = ``count``, in p, p', … at 0 and at 1, for p of degree 2k − 1."""
    orders, degrees = range(count), range(2 * count)
    ends = [[perm(n, k) * x ** max(n - k, 0) for n in degrees] for x in (0, 1) for k in orders]
    powers = np.linalg.inv(np.array(ends, dtype=float))  # in a column one of these derivatives is 1, the others 0
    nodes, weights = np.polynomial.legendre.leggauss(count)
    values = polynomial.polyval((nodes + 1) / 2, polynomial.polyder(powers, count))
    return np.asarray(values * weights / 2 @ values.T)
