"""A run of moves: the states of least jerk at the cam angles of its conditions.

Of all motions that meet what is asked, the one of the least ∫ (y‴)² dθ is sought, a spline of degree 5 with four
continuous derivatives where only positions are given. If a jerk is asked for at an angle of a run, the run has a
continuous jerk (degree 7) and the least ∫ (y⁗)² dθ.

A run is cut at each cam angle where something is asked. Between cuts the motion is the polynomial that joins two
states, and what is asked all along a range of angles holds for its Bernstein coefficients on parts of that range.

Source: de Boor, A Practical Guide to Splines, ch. V and XIII (natural splines); Farin, Curves and Surfaces for
CAGD, ch. 5 (Bernstein form).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import pairwise
from math import comb, isfinite, perm

import numpy as np
from numpy.polynomial import polynomial

from camopt.mistakes import Unmet, listed_words
from camopt.motion.conditions import Condition
from camopt.motion.stroke import Stroke
from camopt.numerics import FloatArray
from camopt.numerics.distinct import distinct
from camopt.numerics.irreducible import irreducible
from camopt.numerics.quadratic import least_within, solutions_of

SINGLE_NUMBER = 1e-12  # of the run's largest number: ranges no wider are single numbers
NEAR_ANGLE = 1e-6  # of the run: angles nearer than that are one
TO_ACCELERATION, TO_JERK = 3, 4  # numbers of a state: up to the acceleration, up to the jerk
RANGE_PARTS = 12  # of a range of angles: there the Bernstein coefficients are hardly wider than the motion


class Contradiction(Unmet):
    """No motion meets all conditions of a run of moves; ``keys`` are those of a smallest set that none meets."""

    def __init__(self, keys: Sequence[str]) -> None:
        super().__init__(
            f"no motion meets these together: {listed_words(keys)}; without any one of them there is one"
        )
        self.keys = tuple(keys)


@dataclass(frozen=True)
class Run:
    """Consecutive moves, their neighbours, and the displacement where the turn starts.

    Displacements are counted from the start of the run, in mm or deg as given, angles in rad.
    """

    moves: Sequence[Stroke]
    before: Stroke
    after: Stroke
    start: float

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
            found = _with(found, np.array([each.start, each.end]), NEAR_ANGLE * most)
        for each in self.conditions:
            parts = np.linspace(each.start, each.end, RANGE_PARTS + 1)[1:-1]
            found = _with(found, parts, max(NEAR_ANGLE * most, (each.end - each.start) / RANGE_PARTS / 2))
        return np.sort(found)

    @property
    def angles(self) -> FloatArray:
        return np.diff(self.cuts)

    @property
    def spans(self) -> list[tuple[int, int]]:
        """The places of the cuts where each move starts and ends."""
        ends = [self._place(end) for end in np.cumsum([0.0, *(move.angle for move in self.moves)])]
        return list(pairwise(ends))

    def _place(self, angle: float) -> int:
        return int(np.abs(self.cuts - angle).argmin())

    @property
    def count(self) -> int:
        """Numbers of a state: a run with a condition on its jerk at an angle has a continuous jerk."""
        jerks = any(each.order == TO_JERK - 1 and each.start == each.end for each in self.conditions)
        return TO_JERK if jerks else TO_ACCELERATION

    @property
    def closed(self) -> bool:
        """Whether the turn has these moves only, and ends where it starts."""
        return self.before.is_open

    def states(self) -> FloatArray:
        """The states at the cuts that meet all conditions with the least integral."""
        found = self._states(self.conditions)
        if found is not None:
            return found
        keys = list(dict.fromkeys(each.key for each in self.conditions))

        def feasible(kept: Sequence[str]) -> bool:
            return self._states([each for each in self.conditions if each.key in kept]) is not None

        raise Contradiction(irreducible(keys, feasible))

    def _states(self, conditions: Sequence[Condition]) -> FloatArray | None:
        """The states that meet some conditions; None if none do."""
        low, high = self._ends()
        along: list[_Rows] = []
        for each in conditions:
            if each.start == each.end and each.order < self.count:
                place = self._place(each.start), each.order
                low[place], high[place] = max(low[place], each.low), min(high[place], each.high)
            elif each.end > each.start:
                along += self._along(each, low.shape)
        if self.closed:
            low[0, 1:], high[0, 1:] = low[-1, 1:], high[-1, 1:]
        if np.any(low > high):
            return None
        return _least(low, high, along, self.angles, self.closed)

    def _ends(self) -> tuple[FloatArray, FloatArray]:
        """The ranges of the states: given at both ends of the run, and where positions are numbers."""
        low, high = np.full((2, self.cuts.size, self.count), [[[-np.inf]], [[np.inf]]])
        changes = [move.given.change if move.given else 0.0 for move in self.moves]
        positions = np.cumsum([0.0, *changes])
        for (_, end), move, position in zip(self.spans, self.moves, positions[1:], strict=True):
            if not (move.wanted and move.wanted[0]):
                low[end, 0] = high[end, 0] = position
        low[0, 0] = high[0, 0] = 0.0
        if not self.closed:
            unit = self.moves[0].size
            low[0, 1:] = high[0, 1:] = _end_of(self.before, 1.0)[1 : self.count] / unit
            last = self.cuts.size - 1
            asked = [each.order for each in self.conditions if self._place(each.start) == last]
            orders = [order for order in range(1, self.count) if order not in asked]
            low[-1, orders] = high[-1, orders] = _end_of(self.after, 0.0)[orders] / unit
        return low, high

    def _along(self, condition: Condition, shape: tuple[int, ...]) -> "list[_Rows]":
        """The limits that a condition over a range of angles sets on the states at its cuts."""
        first, last = self._place(condition.start), self._place(condition.end)
        found = []
        for place, angle in zip(range(first, last), self.angles[first:last], strict=True):
            values = np.zeros((2 * self.count - condition.order, *shape))
            per = angle**condition.order  # so that numbers of all orders are alike
            here = _derivative(self.count, condition.order) @ bernstein_of(self.count, angle)
            values[:, place : place + 2] = here.reshape(len(here), 2, self.count)
            sides = ((1.0, condition.low), (-1.0, condition.high))
            equal = condition.low == condition.high
            for side, end in sides[: 1 if equal else 2]:
                if isfinite(end):
                    rows = side * values.reshape(len(values), -1)
                    found.append(_Rows(rows, np.full(len(values), side * end * per), equal))
        return found


def _with(cuts: FloatArray, others: FloatArray, apart: float) -> FloatArray:
    """Cuts, and those of others that are not near any of them."""
    for each in others:
        if np.abs(cuts - each).min() > apart:
            cuts = np.append(cuts, each)
    return cuts


@dataclass(frozen=True)
class _Rows:
    """Linear limits on the states, one after another: ``rows`` @ states ≥ ``least``, or equal to it."""

    rows: FloatArray
    least: FloatArray
    equal: bool


def _end_of(stroke: Stroke, x: float) -> FloatArray:
    """y, y', y'', y''' where a stroke starts (x = 0) or ends (x = 1)."""
    return stroke.motion(np.array([stroke.start + x * stroke.angle]))[:, 0]


def _least(
    low: FloatArray, high: FloatArray, along: Sequence[_Rows], angles: FloatArray, closed: bool
) -> FloatArray | None:
    """The states of the least integral within their ranges, if any are; ``closed``, the last joint is the first."""
    joints, count = low.shape
    scale = np.tile(angles.mean() ** np.arange(count), joints)
    place = np.arange(joints * count).reshape(joints, count)
    if closed:
        place[-1, 1:] = place[0, 1:]
    factor = np.zeros((angles.size * count, place.size))
    for i, share in enumerate(angles / angles.mean()):
        powers = np.tile(share ** np.arange(count), 2)
        np.add.at(factor[i * count : (i + 1) * count].T, place[i : i + 2].ravel(), (_factor(count) * powers).T)
        factor[i * count : (i + 1) * count] *= share ** (0.5 - count)
    low, high = low.ravel() * scale, high.ravel() * scale
    largest = np.abs(np.nan_to_num([low, high], posinf=0.0, neginf=0.0)).max()
    fixed = high - low <= SINGLE_NUMBER * largest
    states = np.where(fixed, low, 0.0)
    free = distinct(place.ravel()[~fixed])
    onto = np.eye(place.size)[place.ravel()]  # to all numbers of the states from those that are chosen

    def limits(equal: bool) -> tuple[FloatArray, FloatArray]:
        some = [each for each in along if each.equal == equal]
        rows = np.concatenate([np.empty((0, place.size)), *(each.rows for each in some)]) / scale @ onto
        return rows, np.concatenate([np.empty(0), *(each.least for each in some)]) - rows @ states

    (same, values), (rows, least) = limits(True), limits(False)
    size = 1.0 / np.linalg.norm(factor[:, free], axis=0)
    rows = rows[:, free] * size
    for side, end in ((1.0, low[free]), (-1.0, -high[free])):
        some = np.isfinite(end)
        rows, least = np.concatenate([rows, side * np.diag(size)[some]]), np.concatenate([least, end[some]])
    solutions = solutions_of(same[:, free] * size, values, largest)
    if solutions is None:
        return None
    (start, others), own = solutions, factor[:, free] * size
    offset = factor @ states + own @ start
    found = least_within(own @ others, offset, rows @ others, least - rows @ start, largest)
    if found is None:
        return None
    states[free] = np.clip(size * (start + others @ found), low[free], high[free])
    return np.asarray((states[place.ravel()] / scale).reshape(joints, count))


@cache
def _factor(count: int) -> FloatArray:
    """From p, p', … at 0 and at 1, what has ∫₀¹ (p⁽ᵏ⁾)² dx as its square, k = ``count``, for p of degree 2k − 1."""
    orders, degrees = range(count), range(2 * count)
    ends = [[perm(n, k) * x ** max(n - k, 0) for n in degrees] for x in (0, 1) for k in orders]
    powers = np.linalg.inv(np.array(ends, dtype=float))  # in a column one of these derivatives is 1, the others 0
    nodes, weights = np.polynomial.legendre.leggauss(count)
    values = polynomial.polyval((nodes + 1) / 2, polynomial.polyder(powers, count))
    return np.asarray((values * np.sqrt(weights / 2)).T)


def bernstein_of(count: int, angle: float) -> FloatArray:
    """The matrix from the states at both ends of an angle to the Bernstein coefficients of the motion between."""
    degree = 2 * count - 1
    half = np.array(
        [[comb(i, k) / perm(degree, k) * angle**k if k <= i else 0.0 for k in range(count)] for i in range(count)]
    )
    signs = (-1.0) ** np.arange(count)
    none = np.zeros((count, count))
    return np.block([[half, none], [none, (half * signs)[::-1]]])


def _derivative(count: int, order: int) -> FloatArray:
    """The matrix from Bernstein coefficients over [0, 1] to those of a derivative."""
    degree = 2 * count - 1
    return np.asarray(perm(degree, order) * np.diff(np.eye(degree + 1), order, axis=0))
