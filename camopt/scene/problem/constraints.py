"""Constraints: what a limit requires of a curve at every cam angle, for any kind of number.

Verdicts (doubles), proofs and boxes (intervals), convex steps (samples) and pictures evaluate the same constraints,
each with its own kind of number. Solvers look at the curve of a constraint, never at the name of a limit.
"""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, Number
from camopt.model.effects.mean import Mean
from camopt.model.effects.peak import DOUBLES, BodyRadiusPlus, NumberKind, Peak, Scale, unit_weight
from camopt.model.mechanisms import Designs
from camopt.model.motion.stroke import ALL_STROKES


class QuantityBound(NamedTuple):
    """The bound on an extreme at which the quantity has a given value."""

    scale: Scale
    quantity: float

    def curve_extreme_at_bound(self, number_kind: NumberKind) -> Number:
        return self.scale.weighted_extreme_for_quantity(self.quantity, number_kind)


class ConstantBound(NamedTuple):
    """A bound that is the same double for all designs and kinds of number."""

    number: float

    def curve_extreme_at_bound(self, number_kind: NumberKind) -> Number:
        return number_kind.of(self.number)


LEAST_CONTACT_FORCE = 1e-9
"""Force [N] below which a contact counts as lost in proofs."""
CONSTRAINT_SIDES = {LARGEST: (1.0,), LEAST: (-1.0,), LARGEST_MAGNITUDE: (1.0, -1.0)}


class Constraint(NamedTuple):
    """side · factor(design) · curve ≤ bound at every cam angle of some strokes, for each side of the goal.

    By goal: the largest value (LARGEST) or largest magnitude (LARGEST_MAGNITUDE) of factor · curve is at most the
    bound, or its least value (LEAST) is at least the bound. Units are those of the curve. Factors are at least 0,
    since searches look for the largest or least value of the curve itself.

    Example: a roller of radius R_r makes no undercut if κ·R_r < 1 at every cam angle, with the curvature κ of the
    pitch curve. The curve is κ, the goal LARGEST, the factor R_r, the bound 1.
    """

    curve: Callable[[Designs, Any], Any]
    """A curve of the mechanism or of a load, from a design and a motion; or a curve of a train."""
    kinds: int
    """Kinds of stroke, or directions of motion (``motion.table``)."""
    goal: int
    bound: QuantityBound | ConstantBound
    factor: Callable[[Designs], Any] = unit_weight
    unit: Callable[[Designs], Any] = unit_weight
    """The value that a relative excess is relative to if the bound is 0."""

    @property
    def side_signs(self) -> tuple[float, ...]:
        return CONSTRAINT_SIDES[self.goal]

    @property
    def kinds_and_goals(self) -> list[tuple[int, int]]:
        """The kinds of stroke, and the goal of the search for the curve's extreme, of each side."""
        return [(self.kinds, LARGEST if side > 0.0 else LEAST) for side in self.side_signs]

    def upper_bound_of_each_side(self, number_kind: NumberKind = DOUBLES) -> Number:
        """The upper bound of each side."""
        value = self.bound.curve_extreme_at_bound(number_kind)
        return -value if self.goal == LEAST else value

    @property
    def comparison_key(self) -> tuple[Any, ...]:
        """Key that is equal for constraints on the same curve with the same kind of factor.

        Of these, the strictest implies the others.
        """
        of_body = isinstance(self.factor, BodyRadiusPlus)
        weighted = (BodyRadiusPlus, self.upper_bound_of_each_side()) if of_body else (self.factor, None)
        return self.curve, self.kinds, self.goal, *weighted

    @property
    def strictness(self) -> float:
        """A number that is larger for the stricter of two constraints with the same key."""
        return (
            self.factor.radius
            if isinstance(self.factor, BodyRadiusPlus)
            else -float(self.upper_bound_of_each_side())
        )


def constraints_on_peak(peak: Peak, bound: float) -> tuple[Constraint, ...]:
    """The constraints on the curves behind a quantity, from a bound on the quantity."""
    at, weight = QuantityBound(peak.scale, bound), peak.scale.curve_weight_by_design(bound)
    return tuple(
        Constraint(make, kinds, peak.goal, at, weight, peak.unit or unit_weight) for make, kinds in peak.curves
    )


def merge_constraints_over_stroke_kinds(constraints: Iterable[Constraint]) -> list[Constraint]:
    """Merge constraints that differ only in their kinds of stroke."""
    merged: dict[Any, Constraint] = {}
    for constraint in constraints:
        key = (*constraint._replace(kinds=0, bound=ConstantBound(0.0)), constraint.upper_bound_of_each_side())
        merged[key] = (
            constraint._replace(kinds=constraint.kinds | merged[key].kinds) if key in merged else constraint
        )
    return list(merged.values())


class TurnMeanConstraint(NamedTuple):
    """What a limit requires of the mean over the turn of a power of a curve: at most, or at least, a bound."""

    mean: Mean
    quantity: float
    """The bound on the quantity."""
    side: float
    """−1 if the mean must be at least the bound, else 1."""

    @property
    def kinds(self) -> int:
        """All kinds of stroke."""
        return ALL_STROKES

    @property
    def side_signs(self) -> tuple[float, ...]:
        return (self.side,)

    def upper_bound_of_each_side(self, number_kind: NumberKind = DOUBLES) -> Number:
        """The largest allowed mean of the curve to the power, times the factor."""
        return self.mean.power_mean_for_quantity(self.quantity, number_kind)

    def factor(self, designs: Designs) -> Number:
        """The factor of the mean, at least 0, which may depend on the design."""
        factor = self.mean.scale.curve_weight_by_design(self.quantity)(designs)
        return factor * factor if self.mean.power == 2 else factor


AnyConstraint = Constraint | TurnMeanConstraint
