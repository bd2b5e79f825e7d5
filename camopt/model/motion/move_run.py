"""A run of consecutive moves: the motion of least jerk that meets their conditions.

The motion is the one with the least ∫ (y‴)² dθ among all that meet the conditions. If only positions are given, it
is a spline of degree 5 with four continuous derivatives. If the jerk is given at an angle, the run has a continuous
jerk (degree 7) and the least ∫ (y⁗)² dθ.

A run is cut at each cam angle of a condition. A state is y with its derivatives at a cut; between two cuts the
motion is the polynomial that joins both states. A range of angles with a condition is cut into parts, and the
condition is set on the Bernstein coefficients of each part. If no motion is found, the number of parts is doubled.

The proof that no motion meets the conditions uses weighted means of derivatives over these parts (divided
differences). Any motion has these means within the bounds of its derivatives; if no states can, no motion exists.

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
from camopt.model.motion.run_states import AllowedMoveStates, LimitRows
from camopt.model.motion.stroke import Condition, Stroke

NEAR_ANGLE = 1e-6  # of the run: angles nearer than this are the same
TO_ACCELERATION, TO_JERK = 3, 4  # count of a state's numbers: up to the acceleration, up to the jerk
RANGE_PARTS = (12, 24, 48)  # of a range of angles; with more parts a motion may come nearer to its bounds


class InfeasibleMoves(Unmet):
    """No motion meets all conditions of a run of moves (``proved``), or none was found.

    ``keys`` are those of an irreducible set: without any one of them there is a motion.
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
"""From the count of a state's numbers and the order of a derivative: weighted sums of its Bernstein coefficients,
as rows of weights."""


@dataclass(frozen=True)
class MoveRun:
    """Consecutive moves with their neighbours.

    Displacements count from the start of the run, in the scene's unit (mm or deg); angles in rad.
    """

    moves: Sequence[Stroke]
    before: Stroke
    after: Stroke
    start: float
    """The displacement at the start of the turn."""
    parts: int = RANGE_PARTS[0]
    """The number of parts of a range of angles; the run is cut between them too."""

    @cached_property
    def conditions(self) -> list[Condition]:
        """The conditions on the moves, with cam angles from the start of the run."""
        conditions, angle = [], 0.0
        up = (self.start - self.moves[0].low) / self.moves[0].size
        for move in self.moves:
            for each in move.conditions():
                by, rise = angle - move.start, up * (each.order == 0)
                start, end, low, high = each.start + by, each.end + by, each.low + rise, each.high + rise
                conditions.append(Condition(each.key, each.order, start, end, low, high))
            angle += move.angle
        return conditions

    @cached_property
    def cut_angles(self) -> FloatArray:
        """Cam angles of the joints, of all conditions, and between the parts of their ranges."""
        cuts = np.cumsum([0.0, *(move.angle for move in self.moves)])
        length = cuts[-1]
        for each in self.conditions:
            cuts = _add_cuts(cuts, np.array([each.start, each.end]), NEAR_ANGLE * length)
        for each in self.conditions:
            parts = np.linspace(each.start, each.end, self.parts + 1)[1:-1]
            cuts = _add_cuts(cuts, parts, max(NEAR_ANGLE * length, (each.end - each.start) / self.parts / 2))
        return np.sort(cuts)

    @property
    def angles_between_cuts(self) -> FloatArray:
        return np.diff(self.cut_angles)

    @property
    def move_spans(self) -> list[tuple[int, int]]:
        """The indices of the cuts where each move starts and ends."""
        ends = [self._nearest_cut_index(end) for end in np.cumsum([0.0, *(move.angle for move in self.moves)])]
        return list(pairwise(ends))

    def _nearest_cut_index(self, angle: float) -> int:
        return int(np.abs(self.cut_angles - angle).argmin())

    @property
    def numbers_per_state(self) -> int:
        """Count of a state's numbers; with a condition on the jerk at an angle the jerk is one of them."""
        jerks = any(each.order == TO_JERK - 1 and each.start == each.end for each in self.conditions)
        return TO_JERK if jerks else TO_ACCELERATION

    @property
    def is_closed(self) -> bool:
        """Whether the turn consists of these moves only, so that the run ends where it starts."""
        return self.before.law_follows_from_neighbours

    def smoothest_states(self, keys: Sequence[str] | None = None) -> FloatArray | None:
        """The states at the cuts with the least integral that meet the conditions (of some keys, or all)."""
        # weights of single coefficients: if all of these are within bounds, the motion is
        states = self._allowed_states(keys, lambda count, order: np.eye(2 * count - order))
        return states.smoothest_allowed_states()

    def is_proved_impossible(self, keys: Sequence[str] | None = None) -> bool:
        """Whether it is proved that no motion meets the conditions (of some keys, or all)."""
        return self._allowed_states(keys, derivative_mean_weights).are_proved_impossible()

    def _allowed_states(self, keys: Sequence[str] | None, weights: BernsteinWeights) -> AllowedMoveStates:
        """The states that the conditions of some keys (None for all) allow.

        Conditions over a range bound weighted sums of Bernstein coefficients, with the ``weights``.
        """
        low, high = self._state_ranges()
        limits: list[LimitRows] = []
        for each in (each for each in self.conditions if keys is None or each.key in keys):
            if each.start == each.end and each.order < self.numbers_per_state:
                place = self._nearest_cut_index(each.start), each.order
                low[place], high[place] = max(low[place], each.low), min(high[place], each.high)
            elif each.end > each.start:
                limits += self._range_condition_limits(each, low.shape, weights)
        if self.is_closed:
            low[0, 1:], high[0, 1:] = low[-1, 1:], high[-1, 1:]
        return AllowedMoveStates(low, high, limits, self.angles_between_cuts, self.is_closed)

    def _state_ranges(self) -> tuple[FloatArray, FloatArray]:
        """Ranges of the states' numbers: fixed at both ends of the run and where a position is a number."""
        low, high = np.full((2, self.cut_angles.size, self.numbers_per_state), [[[-np.inf]], [[np.inf]]])
        changes = [move.given.change if move.given else 0.0 for move in self.moves]
        positions = np.cumsum([0.0, *changes])
        for (_, end), move, position in zip(self.move_spans, self.moves, positions[1:], strict=True):
            if not (move.wanted and move.wanted[0]):
                low[end, 0] = high[end, 0] = position
        low[0, 0] = high[0, 0] = 0.0
        if not self.is_closed:
            unit = self.moves[0].size
            low[0, 1:] = high[0, 1:] = _stroke_end_state(self.before, 1.0)[1 : self.numbers_per_state] / unit
            last = self.cut_angles.size - 1
            required = [each.order for each in self.conditions if self._nearest_cut_index(each.start) == last]
            orders = [order for order in range(1, self.numbers_per_state) if order not in required]
            low[-1, orders] = high[-1, orders] = _stroke_end_state(self.after, 0.0)[orders] / unit
        return low, high

    def _range_condition_limits(
        self, condition: Condition, shape: tuple[int, ...], weights: BernsteinWeights
    ) -> list[LimitRows]:
        """The limits that a condition over a range of angles sets on the states at its cuts."""
        first, last = self._nearest_cut_index(condition.start), self._nearest_cut_index(condition.end)
        limits = []
        for place, angle in zip(range(first, last), self.angles_between_cuts[first:last], strict=True):
            sums = weights(self.numbers_per_state, condition.order)
            values = np.zeros((len(sums), *shape))
            per = angle**condition.order  # numbers of all orders then have one scale
            here = (
                sums
                @ bernstein_derivative_matrix(self.numbers_per_state, condition.order)
                @ states_to_bernstein_matrix(self.numbers_per_state, angle)
            )
            values[:, place : place + 2] = here.reshape(len(here), 2, self.numbers_per_state)
            sides = ((1.0, condition.low), (-1.0, condition.high))
            equal = condition.low == condition.high
            for side, end in sides[: 1 if equal else 2]:
                if isfinite(end):
                    rows = side * values.reshape(len(values), -1)
                    limits.append(LimitRows(rows, np.full(len(values), side * end * per), equal))
        return limits


def solve_move_run(run: MoveRun) -> tuple[MoveRun, FloatArray]:
    """A run with its ranges in as many parts as it needs, and its states.

    Raises
    ------
    InfeasibleMoves
        If no motion meets all conditions, or none was found.
    """
    keys = list(dict.fromkeys(each.key for each in run.conditions))
    finest = replace(run, parts=RANGE_PARTS[-1])
    for parts in RANGE_PARTS:
        finer = replace(run, parts=parts)
        if (states := finer.smoothest_states()) is not None:
            return finer, states
        if parts == RANGE_PARTS[0] and finest.is_proved_impossible():
            proof_keys = irreducible_set(keys, lambda some: not finest.is_proved_impossible(some))
            raise InfeasibleMoves(proof_keys, proved=True)
    raise InfeasibleMoves(
        irreducible_set(keys, lambda some: finer.smoothest_states(some) is not None), proved=False
    )


def _add_cuts(cuts: FloatArray, new_cuts: FloatArray, least_distance: float) -> FloatArray:
    """The cuts with those of others that are further than ``least_distance`` from all cuts."""
    for angle in new_cuts:
        if np.abs(cuts - angle).min() > least_distance:
            cuts = np.append(cuts, angle)
    return cuts


def _stroke_end_state(stroke: Stroke, x: float) -> FloatArray:
    """y, y', y'', y''' at the start (x = 0) or the end (x = 1) of a stroke."""
    return stroke.motion(np.array([stroke.start + x * stroke.angle]))[:, 0]


def states_to_bernstein_matrix(numbers_per_state: int, angle: float) -> FloatArray:
    """Matrix from the states at both ends of an angle to the Bernstein coefficients of the motion between."""
    degree = 2 * numbers_per_state - 1
    half = np.array(
        [
            [comb(i, k) / perm(degree, k) * angle**k if k <= i else 0.0 for k in range(numbers_per_state)]
            for i in range(numbers_per_state)
        ]
    )
    signs = (-1.0) ** np.arange(numbers_per_state)
    none = np.zeros((numbers_per_state, numbers_per_state))
    return np.block([[half, none], [none, (half * signs)[::-1]]])


def bernstein_derivative_matrix(numbers_per_state: int, order: int) -> FloatArray:
    """Matrix from Bernstein coefficients over [0, 1] to those of a derivative."""
    degree = 2 * numbers_per_state - 1
    return np.asarray(perm(degree, order) * np.diff(np.eye(degree + 1), order, axis=0))


@cache
def derivative_mean_weights(numbers_per_state: int, order: int) -> FloatArray:
    """Weights of Bernstein coefficients that give weighted means of a derivative between two states.

    The means are k! times divided differences of the motion: means of its k-th derivative with the weight
    (1 − x)ⁱ⁻¹xʲ⁻¹, i + j = k + 1, x from 0 to 1 over the range. For any motion they are within the bounds of that
    derivative. With i = 0 or j = 0 they are its values at the ends.
    """
    degree, rows = 2 * numbers_per_state - order - 1, []
    for i in range(max(0, order + 1 - numbers_per_state), min(order + 1, numbers_per_state) + 1):
        j = order + 1 - i
        row = [float(n == (0 if j == 0 else degree)) for n in range(degree + 1)]
        if i and j:
            row = [
                comb(degree, n) * _beta_function(n + j, degree - n + i) / _beta_function(i, j)
                for n in range(degree + 1)
            ]
        rows.append(row)
    return np.array(rows)


def _beta_function(p: int, q: int) -> float:
    """Euler's beta function B(p, q) of whole numbers."""
    return factorial(p - 1) * factorial(q - 1) / factorial(p + q - 1)
