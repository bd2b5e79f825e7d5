"""Limits on the curvature of a cam that is given by its profile, decided in rational numbers.

On an arc the curvature is constant, and a limit is often exactly that of the sharpest arc. Without division the
comparison is exact, so that such a limit is held.
"""

from collections.abc import Iterator
from fractions import Fraction
from itertools import product
from math import isinf

from camopt.model.effects.peak import BodyRadiusPlus, NumberKind
from camopt.model.mechanisms import Designs
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.problem import Problem


def _refuse_irrational(*_arguments: object) -> Fraction:
    """Refuse π and tangents, which no limit on a curvature contains."""
    raise NotImplementedError


RATIONAL = NumberKind(Fraction, _refuse_irrational, _refuse_irrational)


def scaled_curvature_excesses_on_arcs(
    problem: Problem, constraint: Constraint, design: Designs
) -> Iterator[Fraction]:
    """Excess over each side of a constraint on the curvature on each arc, up to a positive factor."""
    allowed, body = constraint.upper_bound_of_each_side(RATIONAL), Fraction(float(design.roller_radius[0]))
    if isinstance(constraint.factor, BodyRadiusPlus):
        factor = body + Fraction(constraint.factor.radius)
    else:
        factor = Fraction(float(constraint.factor(design)))
    for side, radius in product(map(int, constraint.side_signs), problem.profile):
        if isinf(radius):  # a line
            yield -allowed
        elif problem.setup.mechanism.flat_faced:
            yield factor * side * Fraction(radius) - allowed
        else:
            pitch_radius = body + Fraction(radius)
            yield (factor * side - allowed * pitch_radius) * (1 if pitch_radius > 0 else -1)
