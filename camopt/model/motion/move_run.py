"""A run of moves: the states of least jerk at the cam angles of its conditions.

Of all motions that meet what is asked, the one of the least ∫ (y‴)² dθ is sought, a spline of degree 5 with four
continuous derivatives where only positions are given. If a jerk is asked for at an angle of a run, the run has a
continuous jerk (degree 7) and the least ∫ (y⁗)² dθ.

A run is cut at each cam angle where something is asked. Between cuts the motion is the polynomial that joins two
states, and what is asked all along a range of angles holds for its Bernstein coefficients on parts of that range:
on twice as many where they do not suffice. That no motion at all meets the conditions is proved by means of its
derivatives over such parts (divided differences), which no states at the cuts bring within their bounds.

Source: de Boor, A Practical Guide to Splines, ch. V and XIII (natural splines); Farin, Curves and Surfaces for
CAGD, ch. 5 (Bernstein form).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import pairwise
from math import comb, factorial, isfinite, perm

import numpy as np

from camopt.core.mistakes import Unmet, join_words
from camopt.core.numerics import FloatArray
from camopt.core.numerics.irreducible import irreducible_set
from camopt.model.motion.run_states import LimitRows, States
from camopt.model.motion.stroke import Condition, Stroke

NEAR_ANGLE = 1e-6  # of the run: angles nearer than that are one
TO_ACCELERATION, TO_JERK = 3, 4  # numbers of a state: up to the acceleration, up to the jerk
RANGE_PARTS = (12, 24, 48)  # of a range of angles, the more the nearer a motion may come to its bounds


class InfeasibleMoves(Unmet):
    """No motion meets all conditions of a run of moves, or none was found where there is no proof of that.

    ``keys`` are those of a smallest set, in which each one counts.
    """

    def __init__(self, keys: Sequence[str], proved: bool) -> None:
        self.keys, self.proved = tuple(keys), proved
        super().__init__(f"{self.headline}: {join_words(keys)}")

    @property
    def headline(self) -> str:
        if self.proved:
            return "no motion meets all of these"
        return f"no motion was found that meets all of these, with each range in {RANGE_PARTS[-1]} parts"


BernsteinWeights = Callable[[int, int], FloatArray]
"""Of the numbers of a state and the order of a derivative: weights of its Bernstein coefficients, a sum a row."""


@dataclass(frozen=True)
class MoveRun:
    """Consecutive moves, their neighbours, and the displacement where the turn starts.

    Displacements are counted from the start of the run, in mm or deg as given, angles in rad.
    """

    moves: Sequence[Stroke]
    before: Stroke
    after: Stroke
    start: float
    parts: int = RANGE_PARTS[0]
    """Of a range of angles: the run is cut between them too."""

    @cached_property
    def conditions(self) -> list[Condition]:
        """The conditions on the moves, with cam angles from the start of the run."""
        found, turned = [], 0.0
        up = (self.start - self.moves[0].low) / self.moves[0].size
        for move in self.moves:
            for each in move.conditions():
                by, moved = turned - move.start, up * (each.order == 0)
                start, end, low, high = each.start + by, each.end + by, each.low + moved, each.high + moved
                found.append(Condition(each.key, each.order, start, end, low, high))
            turned += move.angle
        return found

    @cached_property
    def cuts(self) -> FloatArray:
        """The cam angles of its joints and of all conditions on the way."""
        found = np.cumsum([0.0, *(move.angle for move in self.moves)])
        most = found[-1]
        for each in self.conditions:
            found = _add_cuts(found, np.array([each.start, each.end]), NEAR_ANGLE * most)
        for each in self.conditions:
            parts = np.linspace(each.start, each.end, self.parts + 1)[1:-1]
            found = _add_cuts(found, parts, max(NEAR_ANGLE * most, (each.end - each.start) / self.parts / 2))
        return np.sort(found)

    @property
    def angles(self) -> FloatArray:
        return np.diff(self.cuts)

    @property
    def spans(self) -> list[tuple[int, int]]:
        """The places of the cuts where each move starts and ends."""
        ends = [self._cut_place(end) for end in np.cumsum([0.0, *(move.angle for move in self.moves)])]
        return list(pairwise(ends))

    def _cut_place(self, angle: float) -> int:
        return int(np.abs(self.cuts - angle).argmin())

    @property
    def count(self) -> int:
        """Numbers of a state: a run with a condition on its jerk at an angle has a continuous jerk."""
        jerks = any(each.order == TO_JERK - 1 and each.start == each.end for each in self.conditions)
        return TO_JERK if jerks else TO_ACCELERATION

    @property
    def is_closed(self) -> bool:
        """Whether the turn has these moves only, and ends where it starts."""
        return self.before.is_open

    def states(self, keys: Sequence[str] | None = None) -> FloatArray | None:
        """The states at the cuts that meet all conditions, or those of some keys, with the least integral."""
        return self._allowed_states(keys, _identity_weights).least_states()

    def is_impossible(self, keys: Sequence[str] | None = None) -> bool:
        """Whether it is proved that no motion meets the conditions, or those of some keys."""
        return self._allowed_states(keys, means_between).are_impossible()

    def _allowed_states(self, keys: Sequence[str] | None, weights: BernsteinWeights) -> States:
        """The states that conditions of some keys (None for all) allow, by weights of Bernstein coefficients."""
        low, high = self._state_ranges()
        along: list[LimitRows] = []
        for each in (each for each in self.conditions if keys is None or each.key in keys):
            if each.start == each.end and each.order < self.count:
                place = self._cut_place(each.start), each.order
                low[place], high[place] = max(low[place], each.low), min(high[place], each.high)
            elif each.end > each.start:
                along += self._range_limits(each, low.shape, weights)
        if self.is_closed:
            low[0, 1:], high[0, 1:] = low[-1, 1:], high[-1, 1:]
        return States(low, high, along, self.angles, self.is_closed)

    def _state_ranges(self) -> tuple[FloatArray, FloatArray]:
        """The ranges of the states: given at both ends of the run, and where positions are numbers."""
        low, high = np.full((2, self.cuts.size, self.count), [[[-np.inf]], [[np.inf]]])
        changes = [move.given.change if move.given else 0.0 for move in self.moves]
        positions = np.cumsum([0.0, *changes])
        for (_, end), move, position in zip(self.spans, self.moves, positions[1:], strict=True):
            if not (move.wanted and move.wanted[0]):
                low[end, 0] = high[end, 0] = position
        low[0, 0] = high[0, 0] = 0.0
        if not self.is_closed:
            unit = self.moves[0].size
            low[0, 1:] = high[0, 1:] = _end_state(self.before, 1.0)[1 : self.count] / unit
            last = self.cuts.size - 1
            asked = [each.order for each in self.conditions if self._cut_place(each.start) == last]
            orders = [order for order in range(1, self.count) if order not in asked]
            low[-1, orders] = high[-1, orders] = _end_state(self.after, 0.0)[orders] / unit
        return low, high

    def _range_limits(
        self, condition: Condition, shape: tuple[int, ...], weights: BernsteinWeights
    ) -> list[LimitRows]:
        """The limits that a condition over a range of angles sets on the states at its cuts."""
        first, last = self._cut_place(condition.start), self._cut_place(condition.end)
        found = []
        for place, angle in zip(range(first, last), self.angles[first:last], strict=True):
            sums = weights(self.count, condition.order)
            values = np.zeros((len(sums), *shape))
            per = angle**condition.order  # so that numbers of all orders are alike
            here = sums @ bernstein_derivative(self.count, condition.order) @ states_to_bernstein(self.count, angle)
            values[:, place : place + 2] = here.reshape(len(here), 2, self.count)
            sides = ((1.0, condition.low), (-1.0, condition.high))
            equal = condition.low == condition.high
            for side, end in sides[: 1 if equal else 2]:
                if isfinite(end):
                    rows = side * values.reshape(len(values), -1)
                    found.append(LimitRows(rows, np.full(len(values), side * end * per), equal))
        return found


def solve_run(run: MoveRun) -> tuple[MoveRun, FloatArray]:
    """A run with ranges in as many parts as it needs, and its states.

    Raises
    ------
    Contradiction
        If no motion meets all conditions, or none was found.
    """
    for parts in RANGE_PARTS:
        finer = replace(run, parts=parts)
        if (found := finer.states()) is not None:
            return finer, found
        if parts == RANGE_PARTS[0]:
            _raise_if_impossible(replace(run, parts=RANGE_PARTS[-1]))
    raise InfeasibleMoves(
        irreducible_set(_condition_keys(run), lambda keys: finer.states(keys) is not None), proved=False
    )


def _raise_if_impossible(run: MoveRun) -> None:
    if run.is_impossible():
        raise InfeasibleMoves(
            irreducible_set(_condition_keys(run), lambda keys: not run.is_impossible(keys)), proved=True
        )


def _condition_keys(run: MoveRun) -> list[str]:
    return list(dict.fromkeys(each.key for each in run.conditions))


def _add_cuts(cuts: FloatArray, others: FloatArray, apart: float) -> FloatArray:
    """Cuts, and those of others that are not near any of them."""
    for each in others:
        if np.abs(cuts - each).min() > apart:
            cuts = np.append(cuts, each)
    return cuts


def _end_state(stroke: Stroke, x: float) -> FloatArray:
    """y, y', y'', y''' where a stroke starts (x = 0) or ends (x = 1)."""
    return stroke.motion(np.array([stroke.start + x * stroke.angle]))[:, 0]


def states_to_bernstein(count: int, angle: float) -> FloatArray:
    """The matrix from the states at both ends of an angle to the Bernstein coefficients of the motion between."""
    degree = 2 * count - 1
    half = np.array(
        [[comb(i, k) / perm(degree, k) * angle**k if k <= i else 0.0 for k in range(count)] for i in range(count)]
    )
    signs = (-1.0) ** np.arange(count)
    none = np.zeros((count, count))
    return np.block([[half, none], [none, (half * signs)[::-1]]])


def bernstein_derivative(count: int, order: int) -> FloatArray:
    """The matrix from Bernstein coefficients over [0, 1] to those of a derivative."""
    degree = 2 * count - 1
    return np.asarray(perm(degree, order) * np.diff(np.eye(degree + 1), order, axis=0))


def _identity_weights(count: int, order: int) -> FloatArray:
    """Every Bernstein coefficient: where all are within bounds, the motion is."""
    return np.eye(2 * count - order)


@cache
def means_between(count: int, order: int) -> FloatArray:
    """The means of a derivative over a range that the states at its ends give, of its Bernstein coefficients.

    They are k! times divided differences of the motion, so means of its k-th derivative with the weight
    (1 − x)ⁱ⁻¹xʲ⁻¹, i + j = k + 1, x from 0 to 1 over the range: of any motion they are within the bounds of that
    derivative. With i or j = 0 they are its values at the ends.
    """
    degree, rows = 2 * count - order - 1, []
    for i in range(max(0, order + 1 - count), min(order + 1, count) + 1):
        j = order + 1 - i
        row = [float(n == (0 if j == 0 else degree)) for n in range(degree + 1)]
        if i and j:
            row = [comb(degree, n) * _beta(n + j, degree - n + i) / _beta(i, j) for n in range(degree + 1)]
        rows.append(row)
    return np.array(rows)


def _beta(p: int, q: int) -> float:
    """The integral of xᵖ⁻¹ times that power of 1 − x over 0 to 1, Euler's of the first kind."""
    return factorial(p - 1) * factorial(q - 1) / factorial(p + q - 1)
