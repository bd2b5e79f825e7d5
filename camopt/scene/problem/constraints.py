"""Constraints: the requirement of a limit on a curve at every cam angle, for any kind of number.

Doubles (verdicts), intervals (proofs and boxes of designs), samples (convex steps) and drawings evaluate the same
constraints, each in its own numbers. A solver asks a constraint which curve it is about, never a limit for its
name.
"""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST
from camopt.model.effects.mean import Mean
from camopt.model.effects.peak import DOUBLES, BodyRadiusPlus, NumberKind, Peak, Scale, unit_weight
from camopt.model.effects.train_peak import TrainPeak
from camopt.model.mechanisms import Designs
from camopt.model.motion.stroke import ALL_STROKES


class QuantityBound(NamedTuple):
    """The extreme at which its quantity has a given value."""

    scale: Scale
    quantity: float

    def value(self, numbers: NumberKind) -> Any:
        return self.scale.extreme_at(self.quantity, numbers)


class ConstantBound(NamedTuple):
    """A bound that is the same double for all designs and kinds of number."""

    number: float

    def value(self, numbers: NumberKind) -> Any:
        return numbers.of(self.number)


ConstraintBound = QuantityBound | ConstantBound


CONSTRAINT_SIDES = {LARGEST: (1.0,), LEAST: (-1.0,), LARGEST_MAGNITUDE: (1.0, -1.0)}


class Constraint(NamedTuple):
    """side · factor(design) · curve ≤ allowed at every cam angle of some strokes, for each side of the goal.

    That is: the largest value (LARGEST) or the largest magnitude (LARGEST_MAGNITUDE) of factor · curve is at most
    the bound, or its least value (LEAST) at least the bound. Units are the curve's. No factor is below 0, since
    searches look where the curve itself is largest or least.

    Example: a roller of radius R_r undercuts no profile with κ·R_r < 1 at every cam angle, where κ is the curvature
    of the pitch curve: the curve is κ, the goal LARGEST, the factor R_r, the bound 1.
    """

    curve: Callable[[Designs, Any], Any]
    """A curve of the mechanism or of a load, for a design and a motion; or of a train, for what that does."""
    kinds: int
    """Kinds of stroke, or ways in which the follower moves (``motion.table``)."""
    goal: int
    bound: ConstraintBound
    factor: Callable[[Designs], Any] = unit_weight
    unit: Callable[[Designs], Any] = unit_weight
    """The scale of a relative excess where the bound is 0."""

    @property
    def sides(self) -> tuple[float, ...]:
        return CONSTRAINT_SIDES[self.goal]

    def upper_bound(self, numbers: NumberKind = DOUBLES) -> Any:
        """The upper bound of each side."""
        value = self.bound.value(numbers)
        return -value if self.goal == LEAST else value

    @property
    def comparison_key(self) -> tuple[Any, ...]:
        """Equal for constraints on one curve with one kind of factor: the strictest implies the others."""
        of_body = isinstance(self.factor, BodyRadiusPlus)
        weighted = (BodyRadiusPlus, self.upper_bound()) if of_body else (self.factor, None)
        return self.curve, self.kinds, self.goal, *weighted

    @property
    def strictness(self) -> float:
        """Larger for the stricter of two comparable constraints."""
        return self.factor.radius if isinstance(self.factor, BodyRadiusPlus) else -float(self.upper_bound())


def constraints_on_peak(peak: Peak, bound: float) -> tuple[Constraint, ...]:
    """The constraints of a bound on the curves that decide its quantity."""
    at, weight = QuantityBound(peak.scale, bound), peak.scale.weight(bound)
    return tuple(
        Constraint(make, kinds, peak.goal, at, weight, peak.unit or unit_weight) for make, kinds in peak.curves
    )


def merge_stroke_kinds(constraints: Iterable[Constraint]) -> list[Constraint]:
    """Constraints with equal bounds on one curve, over several kinds of stroke, as one over all of these."""
    found: dict[Any, Constraint] = {}
    for constraint in constraints:
        same = (*constraint._replace(kinds=0, bound=ConstantBound(0.0)), constraint.upper_bound())
        found[same] = (
            constraint._replace(kinds=constraint.kinds | found[same].kinds) if same in found else constraint
        )
    return list(found.values())


def constraints_on_train_peak(peak: TrainPeak, bound: float) -> tuple[Constraint, ...]:
    """The constraints of a bound on the curves of a train that decide its quantity."""
    return tuple(
        Constraint(curve, ALL_STROKES, peak.goal, QuantityBound(peak.scale, bound)) for curve in peak.curves
    )


class TurnMeanConstraint(NamedTuple):
    """The requirement of a limit on the mean of a curve to a power over the turn: at most, or at least, a bound."""

    mean: Mean
    quantity: float
    """The bound on the quantity."""
    side: float
    """−1 where the mean must be at least so much, else 1."""

    @property
    def kinds(self) -> int:
        """The kinds of stroke that it is about: all."""
        return ALL_STROKES

    @property
    def sides(self) -> tuple[float, ...]:
        return (self.side,)

    def upper_bound(self, numbers: NumberKind = DOUBLES) -> Any:
        """The mean of the curve to the power that is just allowed, times the factor."""
        return self.mean.power_mean_at(self.quantity, numbers)

    def factor(self, designs: Designs) -> Any:
        """The factor of that mean, which may depend on the design; not below 0."""
        factor = self.mean.scale.weight(self.quantity)(designs)
        return factor * factor if self.mean.power == 2 else factor


AnyConstraint = Constraint | TurnMeanConstraint


def constraint_on_mean(mean: Mean, bound: float, side: float) -> TurnMeanConstraint:
    """The constraint of a bound, from one side, on the mean that decides its quantity."""
    return TurnMeanConstraint(mean, bound, -side if mean.scale.falls else side)
