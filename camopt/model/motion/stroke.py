"""A stroke: the motion of the follower in one segment of the turn. What kinds there are, and conditions on it."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf, isfinite, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, IntArray
from camopt.model.motion.law import Law, law_derivatives

RISE, RETURN, DWELL = 1, 2, 4  # bits, so that a question can ask for several kinds at once
ALL_STROKES = RISE | RETURN | DWELL
OUTWARD, INWARD, RESTING = 8, 16, 32  # which way a piece moves: the sign of y', whatever its stroke
WAYS = OUTWARD | INWARD | RESTING
WAY_OF = {RISE: OUTWARD, RETURN: INWARD, DWELL: RESTING}
REVERSED_KINDS = {RISE: RETURN, RETURN: RISE, OUTWARD: INWARD, INWARD: OUTWARD}

DERIVATIVE_NAMES = ("position", "velocity", "acceleration", "jerk")
"""Of y and its derivatives by the cam angle, by order."""
SOLVER_TOLERANCE = (1e-6, 1e-6, 1e-5, 1e-3)
"""By what share of its largest value a motion, and each derivative, may miss what is asked: a solver does."""
END_TOLERANCE = 1e-9  # of a stroke: an angle as close as that to its end is there
RANGE_SAMPLES = 2001  # angles of a range at which a condition is looked at


def motion_ways(kinds: IntArray) -> FloatArray:
    """Which way the follower moves in pieces of some kinds: out (1), in (−1), or not (0)."""
    return np.asarray(((kinds & OUTWARD) != 0) * 1.0 - ((kinds & INWARD) != 0))


def reversed_kinds(kinds: Any) -> Any:
    """The kinds, and ways, of a motion that goes in where one with these goes out."""
    both = RISE | RETURN | OUTWARD | INWARD
    others = (((kinds & kind) != 0) * other for kind, other in REVERSED_KINDS.items())
    return sum(others, kinds & ~both)


def stroke_ways(kinds: int) -> int:
    """The ways in which the follower moves in strokes of some kinds."""
    return sum(way for kind, way in WAY_OF.items() if kind & kinds)


class Condition(NamedTuple):
    """Bounds on the motion or one of its derivatives, at a cam angle or all along a range of them."""

    key: str
    """Of the scene that asks for it."""
    order: int
    start: float  # cam angles, rad
    end: float
    low: float  # mm (rad, or deg) by radᵏ; infinite where nothing is asked
    high: float

    def widen_range(self, share: float) -> "Condition":
        """The condition with a range that is wider by a share; one value stays as it is."""
        by = share * (self.high - self.low)
        return self._replace(low=self.low - by, high=self.high + by) if isfinite(by) else self


class ExactNumbers(NamedTuple):
    """A segment's numbers as they were given, which a proof takes as exact."""

    angle: float  # deg
    change: float  # of the displacement, mm, or deg if angular
    angular: bool

    @property
    def unit(self) -> float:
        """Of the displacement, in mm (rad)."""
        return pi / 180 if self.angular else 1.0


class PassingCondition(NamedTuple):
    """A condition on a move from one cam angle of the turn to another, or at one; deg as given, else rad."""

    start: float
    end: float
    required_values: tuple["RequiredValue", ...]
    """Of y, y', y'' … as those of ``Stroke.wanted``."""


RequiredValue = float | tuple[float, float] | None
"""A number, from where to where it may be, or nothing that is asked."""


def required_range(asked: RequiredValue) -> tuple[float, float]:
    """The range of a number that is asked for."""
    if asked is None:
        return -inf, inf
    return asked if isinstance(asked, tuple) else (asked, asked)


@dataclass(frozen=True)
class Stroke:
    """One segment of a turn: cam angle in rad, displacements at its ends in mm (rad when oscillating).

    A stroke of kind TURN is a move: it rises, dwells and returns as it goes, and its law is no unit stroke, but the
    displacement itself as it was given (mm or deg) over x from 0 to 1, counted from its start.
    """

    kind: int
    law: Law | None
    start: float
    angle: float
    low: float  # displacement at its start
    high: float  # and at its end
    given: ExactNumbers | None = None
    """What its angle and displacements are made from; None where they are exact themselves."""
    wanted: tuple[RequiredValue, ...] | None = None
    """Of a move: what is asked of y, y', y'' … at its end as given, mm (deg) by rad. Its y is counted from the
    start of the turn, and None where ``high`` has it."""
    through: tuple[PassingCondition, ...] = ()
    """What is asked of it on its way, at cam angles in rad."""
    key: str = ""
    """Of its segment in the scene."""
    named: bool = False
    """Whether the law of a move was given; if not, it follows from what is beside it (``joints``)."""
    way: float = 1.0
    """−1 in a turn that is reversed."""

    @property
    def end(self) -> float:
        return self.start + self.angle

    @property
    def is_move(self) -> bool:
        return self.kind == ALL_STROKES

    @property
    def is_open(self) -> bool:
        """Whether its law follows from its neighbours."""
        return self.wanted is not None and not self.named

    @property
    def is_free(self) -> bool:
        """Whether it may have another law than its own: it is neither a dwell nor at constant velocity."""
        return self.wanted is not None if self.is_move else self.kind != DWELL

    @property
    def size(self) -> float:
        """The factor of its law."""
        if self.is_move and self.given:
            return self.way * self.given.unit
        return self.high - self.low

    def reversed_stroke(self, lift: float) -> "Stroke":
        """The same stroke with the displacement lift − y."""
        kind, given = int(reversed_kinds(self.kind)), self.given
        turned = given and given._replace(change=-given.change)
        low, high = lift - self.low, lift - self.high
        return replace(self, kind=kind, low=low, high=high, given=turned, way=-self.way)

    def required_conditions(self, start: float) -> Iterator[Condition]:
        """The conditions on a move, or on a stretch at constant velocity, in mm (rad) by rad.

        ``start`` is the displacement at the start of the turn.
        """
        if self.is_move and not (self.wanted and self.wanted[0]):
            yield Condition(f"{self.key}.to", 0, self.end, self.end, self.high, self.high)
        for each in self.conditions():
            up = start * (each.order == 0)
            yield each._replace(low=up + each.low * self.size, high=up + each.high * self.size)

    def conditions(self) -> Iterator[Condition]:
        """The given conditions on a move at its end and on its way; y is relative to the start of the turn.

        Not the position at its end, where that is a number: ``high`` has it.
        """
        for order, name in enumerate(("to", *DERIVATIVE_NAMES[1:])):
            yield from _conditions_of_order(f"{self.key}.{name}", order, self.end, self.end, self.wanted or ())
        for number, each in enumerate(self.through, start=1):
            for order, name in enumerate(DERIVATIVE_NAMES):
                yield from _conditions_of_order(
                    f"{self.key}.through.{number}.{name}", order, each.start, each.end, each.required_values
                )

    def part_under(self, condition: Condition) -> tuple[float, float] | None:
        """The range of x, from 0 to 1, on which a condition holds; None if it does not hold in this stroke.

        One at the angle where the stroke starts is about the stroke before.
        """
        low, high = ((angle - self.start) / self.angle for angle in (condition.start, condition.end))
        low, high = (round(x) if abs(x - round(x)) <= END_TOLERANCE else x for x in (low, high))
        if condition.start == condition.end:
            return (low, high) if 0.0 < low <= 1.0 else None
        return (max(low, 0.0), min(high, 1.0)) if low < 1.0 and high > 0.0 else None

    def values_at(self, condition: Condition) -> FloatArray:
        """The values that a condition is about, at its angle or at many of its range; empty outside the stroke."""
        part = self.part_under(condition)
        if part is None:
            return np.empty(0)
        low, high = part  # where a range ends the jerk may jump
        x = np.linspace(low + END_TOLERANCE, high - END_TOLERANCE, RANGE_SAMPLES) if low < high else np.array([low])
        return np.asarray(self.motion(self.start + self.angle * x)[condition.order])

    def motion(self, angles: FloatArray, order: int = 3) -> FloatArray:
        """(y, y', y'', y''') up to an order at cam angles of the stroke, one row each."""
        if self.law is None:
            return np.stack([np.full_like(angles, self.low), *np.zeros((order, *angles.shape))])
        x = np.clip((angles - self.start) / self.angle, 0.0, 1.0)
        found = enumerate(law_derivatives(self.law, x, order))
        rows = np.stack([self.size * each / self.angle**k for k, each in found])
        rows[0] += self.low
        return rows


def _conditions_of_order(
    key: str, order: int, start: float, end: float, asked: tuple[RequiredValue, ...]
) -> Iterator[Condition]:
    """A condition, if there is one of that order."""
    low, high = required_range(asked[order] if order < len(asked) else None)
    if isfinite(low) or isfinite(high):
        yield Condition(key, order, start, end, low, high)
