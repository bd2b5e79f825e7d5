"""A stroke: the motion of the follower in one segment of the turn, with its kind and the conditions on it."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf, isfinite, pi
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, IntArray
from camopt.model.motion.law import Law, law_derivatives

RISE, RETURN, DWELL = 1, 2, 4  # bits, so that a mask can hold several kinds
ALL_STROKES = RISE | RETURN | DWELL
OUTWARD, INWARD, RESTING = 8, 16, 32  # the direction of a piece of a stroke: the sign of y'
WAYS = OUTWARD | INWARD | RESTING
WAY_OF = {RISE: OUTWARD, RETURN: INWARD, DWELL: RESTING}
REVERSED_KINDS = {RISE: RETURN, RETURN: RISE, OUTWARD: INWARD, INWARD: OUTWARD}

DERIVATIVE_NAMES = ("position", "velocity", "acceleration", "jerk")
"""The names of y and its derivatives by the cam angle, by order."""
SOLVER_TOLERANCE = (1e-6, 1e-6, 1e-5, 1e-3)
"""Error of a solver: by which share of its largest value a motion or derivative may miss a condition, by order."""
END_TOLERANCE = 1e-9  # of a stroke: an angle this near to its end counts as the end
RANGE_SAMPLES = 2001  # angles of a range at which a condition is checked


def motion_directions(kinds: IntArray) -> FloatArray:
    """Direction of the follower in pieces of some kinds: out (1), in (−1), or at rest (0)."""
    return np.asarray(((kinds & OUTWARD) != 0) * 1.0 - ((kinds & INWARD) != 0))


def reversed_kinds(kinds: Any) -> Any:
    """Kinds and directions of the reversed motion: rises become returns, outward becomes inward."""
    reversible = RISE | RETURN | OUTWARD | INWARD
    return sum((((kinds & kind) != 0) * other for kind, other in REVERSED_KINDS.items()), kinds & ~reversible)


class Condition(NamedTuple):
    """Bounds on the motion or one of its derivatives, at a cam angle or over a range of angles."""

    key: str
    """The key of the scene that sets it."""
    order: int
    start: float  # cam angles, rad
    end: float
    low: float  # mm (rad, or deg) per radᵏ; infinite without a bound
    high: float

    def with_widened_range(self, share: float) -> "Condition":
        """The condition with its range of values widened by a share; a single value stays."""
        by = share * (self.high - self.low)
        return self._replace(low=self.low - by, high=self.high + by) if isfinite(by) else self


class ExactNumbers(NamedTuple):
    """The numbers of a segment as the scene gives them; proofs take them as exact."""

    angle: float  # deg
    change: float  # of the displacement, mm, or deg if angular
    angular: bool

    @property
    def unit_in_mm_or_rad(self) -> float:
        """The unit of the displacement, in mm (rad)."""
        return pi / 180 if self.angular else 1.0


class PassingCondition(NamedTuple):
    """A condition on a move at a cam angle, or over a range of angles; deg in segments, rad in strokes."""

    start: float
    end: float
    required_values: tuple["RequiredValue", ...]
    """For y, y', y'' …, as those of ``Stroke.wanted``."""


RequiredValue = float | tuple[float, float] | None
"""A number, a range of numbers, or None for any number."""


def required_range(required: RequiredValue) -> tuple[float, float]:
    """Least and largest number that a required value allows."""
    if required is None:
        return -inf, inf
    return required if isinstance(required, tuple) else (required, required)


@dataclass(frozen=True)
class Stroke:
    """One segment of a turn: cam angles in rad, displacements at its ends in mm (rad of an oscillating follower).

    A stroke of the kind ``ALL_STROKES`` is a move, which may rise, dwell and return. Its law is not a unit stroke,
    but the displacement from its start in the scene's unit (mm or deg), over x from 0 to 1.
    """

    kind: int
    law: Law | None
    start: float
    angle: float
    low: float  # displacement at its start
    high: float  # and at its end
    given: ExactNumbers | None = None
    """The scene's numbers for its angle and displacements; None if these are exact themselves."""
    wanted: tuple[RequiredValue, ...] | None = None
    """The required values of y, y', y'' … at the end of a move, in mm (deg) per radᵏ.

    y counts from the start of the turn, and is None if ``high`` has it.
    """
    through: tuple[PassingCondition, ...] = ()
    """The conditions on a move before its end, at cam angles in rad."""
    key: str = ""
    """The key of its segment in the scene."""
    named: bool = False
    """Whether the scene gives the law of a move; if not, the law follows from its neighbours (``move_joints``)."""
    way: float = 1.0
    """−1 in a reversed turn, else 1."""

    @property
    def end(self) -> float:
        return self.start + self.angle

    @property
    def is_move(self) -> bool:
        return self.kind == ALL_STROKES

    @property
    def law_follows_from_neighbours(self) -> bool:
        """Whether it is a move whose law follows from its neighbours."""
        return self.wanted is not None and not self.named

    @property
    def is_law_replaceable(self) -> bool:
        """Whether another law may replace its law: not in a dwell, nor at constant velocity."""
        return self.wanted is not None if self.is_move else self.kind != DWELL

    @property
    def size(self) -> float:
        """The factor of its law [mm or rad]."""
        if self.is_move and self.given:
            return self.way * self.given.unit_in_mm_or_rad
        return self.high - self.low

    def reversed_stroke(self, lift: float) -> "Stroke":
        """The same stroke with the displacement lift − y."""
        kind, given = int(reversed_kinds(self.kind)), self.given and self.given._replace(change=-self.given.change)
        return replace(self, kind=kind, low=lift - self.low, high=lift - self.high, given=given, way=-self.way)

    def conditions_in_mm_or_rad(self, start: float) -> Iterator[Condition]:
        """The conditions on a move or on a segment of constant velocity, in mm (rad) per radᵏ.

        ``start`` is the displacement at the start of the turn.
        """
        if self.is_move and not (self.wanted and self.wanted[0]):
            yield Condition(f"{self.key}.to", 0, self.end, self.end, self.high, self.high)
        for condition in self.conditions():
            up = start * (condition.order == 0)
            yield condition._replace(low=up + condition.low * self.size, high=up + condition.high * self.size)

    def conditions(self) -> Iterator[Condition]:
        """The scene's conditions on a move, at its end and before; y counts from the start of the turn.

        A position at its end that is a number is not among them: ``high`` has it.
        """
        for order, name in enumerate(("to", *DERIVATIVE_NAMES[1:])):
            yield from _conditions_of_order(f"{self.key}.{name}", order, self.end, self.end, self.wanted or ())
        for number, passing in enumerate(self.through, start=1):
            for order, name in enumerate(DERIVATIVE_NAMES):
                key = f"{self.key}.through.{number}.{name}"
                yield from _conditions_of_order(key, order, passing.start, passing.end, passing.required_values)

    def part_under_condition(self, condition: Condition) -> tuple[float, float] | None:
        """Range of x (0 to 1) of this stroke to which a condition applies, or None.

        A condition at the angle where the stroke starts applies to the stroke before.
        """
        low, high = ((angle - self.start) / self.angle for angle in (condition.start, condition.end))
        low, high = (round(x) if abs(x - round(x)) <= END_TOLERANCE else x for x in (low, high))
        if condition.start == condition.end:
            return (low, high) if 0.0 < low <= 1.0 else None
        return (max(low, 0.0), min(high, 1.0)) if low < 1.0 and high > 0.0 else None

    def values_under_condition(self, condition: Condition) -> FloatArray:
        """The values that a condition bounds, at its angle or at samples of its range; empty outside the stroke."""
        part = self.part_under_condition(condition)
        if part is None:
            return np.empty(0)
        low, high = part  # the jerk may jump at the ends of a range
        x = np.linspace(low + END_TOLERANCE, high - END_TOLERANCE, RANGE_SAMPLES) if low < high else np.array([low])
        return np.asarray(self.motion(self.start + self.angle * x)[condition.order])

    def motion(self, angles: FloatArray, order: int = 3) -> FloatArray:
        """Rows of y, y', y'' … up to an order, at cam angles of the stroke."""
        if self.law is None:
            return np.stack([np.full_like(angles, self.low), *np.zeros((order, *angles.shape))])
        x = np.clip((angles - self.start) / self.angle, 0.0, 1.0)
        derivatives = enumerate(law_derivatives(self.law, x, order))
        rows = np.stack([self.size * values / self.angle**k for k, values in derivatives])
        rows[0] += self.low
        return rows


def _conditions_of_order(
    key: str, order: int, start: float, end: float, required: tuple[RequiredValue, ...]
) -> Iterator[Condition]:
    """The condition of one order, if the required values have one."""
    low, high = required_range(required[order] if order < len(required) else None)
    if isfinite(low) or isfinite(high):
        yield Condition(key, order, start, end, low, high)
