"""Claims: what a limit requires of a curve at every cam angle, for any kind of number.

Doubles (verdicts), intervals (boxes of designs), balls (proofs), samples (convex steps) and drawings evaluate the
same claims, each in its own numbers. A solver asks a claim which curve it is about, never a limit for its name.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST


class NumberKind(NamedTuple):
    """A kind of number: how to make one from a double, its π, and its tangent."""

    of: Callable[[float], Any]
    pi: Callable[[], Any]
    tan: Callable[[Any], Any]


DOUBLES = NumberKind(float, lambda: math.pi, math.tan)


class Tangent(NamedTuple):
    """A bound on the tangent of an angle: tan β."""

    degrees: float

    def value(self, numbers: NumberKind) -> Any:
        return numbers.tan(numbers.of(self.degrees) * numbers.pi() / 180)


class ByCamAngle(NamedTuple):
    """A bound on a derivative by time, as one on the derivative of the same order by the cam angle: b·unit/ωⁿ."""

    by_time: float
    unit: float
    """Of the bound, in mm (rad) per sⁿ."""
    order: int
    rpm: float

    def value(self, numbers: NumberKind) -> Any:
        speed = numbers.of(self.rpm) * numbers.pi() / 30
        return numbers.of(self.by_time) * numbers.of(self.unit) / speed**self.order


class PerDegree(NamedTuple):
    """A bound on a velocity per degree of the cam, as one by the cam angle in rad."""

    by_degree: float
    angular: bool
    """Whether what moves is an angle too, in deg."""

    def value(self, numbers: NumberKind) -> Any:
        bound = numbers.of(self.by_degree)
        return bound if self.angular else bound * 180 / numbers.pi()


class Plain(NamedTuple):
    """A bound that is the same double for all."""

    number: float

    def value(self, numbers: NumberKind) -> Any:
        return numbers.of(self.number)


Bound = Plain | Tangent | ByCamAngle | PerDegree


@dataclass(frozen=True)
class Derivative:
    """The derivative of the follower's displacement by the cam angle of some order, as a curve of all designs."""

    order: int

    def __call__(self, designs: Designs, programme: Programme) -> "Derivative":
        return self


@dataclass(frozen=True)
class BodyRadiusPlus:
    """R_r + ρ of a design: times the curvature of its pitch curve it is 1 where the profile's radius is ρ, mm."""

    radius: float

    def __call__(self, designs: Designs) -> Any:
        return designs.roller_radius + self.radius


@dataclass(frozen=True)
class BeyondBody:
    """R_c − R_r of a cutter larger than the roller, else 0, mm.

    Times the curvature of the pitch curve it is −1 where the cutter just reaches a hollow flank.
    """

    radius: float

    def __call__(self, designs: Designs) -> Any:
        return np.maximum(self.radius - designs.roller_radius, 0.0)


def unweighted(designs: Designs) -> float:
    """The factor of most claims."""
    return 1.0


def size_of(designs: Designs) -> Any:
    """The unit of lengths."""
    return designs.size


SIDES = {LARGEST: (1.0,), LEAST: (-1.0,), LARGEST_MAGNITUDE: (1.0, -1.0)}


class Claim(NamedTuple):
    """side · factor(design) · curve ≤ allowed at every cam angle of some strokes, for each side of the goal.

    That is: the largest value (LARGEST) or the largest magnitude (LARGEST_MAGNITUDE) of factor · curve is at most
    the bound, or its least value (LEAST) at least the bound. Units are the curve's. No factor is below 0, since
    searches look where the curve itself is largest or least.

    Example: a roller of radius R_r undercuts no profile with κ·R_r < 1 at every cam angle, where κ is the curvature
    of the pitch curve: the curve is κ, the goal LARGEST, the factor R_r, the bound 1.
    """

    curve: Callable[[Designs, Programme], Any]
    """A curve of the mechanism or of a load, for a design and a motion."""
    strokes: int
    """Kinds of stroke, or ways in which the follower moves (``motion.table``)."""
    goal: int
    bound: Bound
    factor: Callable[[Designs], Any] = unweighted
    unit: Callable[[Designs], Any] = unweighted
    """The scale of a relative excess where the bound is 0."""

    @property
    def sides(self) -> tuple[float, ...]:
        return SIDES[self.goal]

    def allowed(self, numbers: NumberKind = DOUBLES) -> Any:
        """The upper bound of each side."""
        value = self.bound.value(numbers)
        return -value if self.goal == LEAST else value

    @property
    def comparable(self) -> tuple[Any, ...]:
        """Equal for claims of which the stricter one implies the others: on one curve, with one kind of factor."""
        weighted = (BodyRadiusPlus, self.bound) if isinstance(self.factor, BodyRadiusPlus) else (self.factor, None)
        return self.curve, self.strokes, self.goal, *weighted

    @property
    def strictness(self) -> float:
        """Larger for the stricter of two comparable claims."""
        return self.factor.radius if isinstance(self.factor, BodyRadiusPlus) else -float(self.allowed())
