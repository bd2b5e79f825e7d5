"""Limits on the curvature of a cam that is given by its profile, decided in rational numbers.

On an arc the curvature is constant, and a limit is often just that of the sharpest arc. It is not divided by, so
that this is seen.
"""

from collections.abc import Iterator
from fractions import Fraction
from itertools import product
from math import isinf

from camopt.model.effects.peak import BodyRadiusPlus, NumberKind
from camopt.model.mechanisms import Designs
from camopt.scene.problem.constraints import Constraint
from camopt.scene.problem.problem import Problem
from camopt.solve.verdicts.verdict_words import BROKEN, HELD, worst_verdict


def _refuse_irrational(*given: object) -> Fraction:
    """π, and tangents: no limit on a curvature has one."""
    raise NotImplementedError


RATIONAL = NumberKind(Fraction, _refuse_irrational, _refuse_irrational)


def is_on_arcs(problem: Problem, constraint: Constraint) -> bool:
    """Whether a constraint is on the curvature of a cam that is given by its profile."""
    mechanism = problem.setup.mechanism
    curves = mechanism.curvature, mechanism.profile_radius
    return bool(problem.profile) and constraint.curve in curves


def arcs_verdict(problem: Problem, constraint: Constraint, design: Designs) -> str:
    """Whether all arcs hold such a constraint."""
    return worst_verdict(BROKEN if over > 0 else HELD for over in _arc_excesses(problem, constraint, design))


def _arc_excesses(problem: Problem, constraint: Constraint, design: Designs) -> Iterator[Fraction]:
    """By how much, or by how many times that, each side of a constraint is exceeded on each arc."""
    allowed, body = constraint.upper_bound(RATIONAL), Fraction(float(design.roller_radius[0]))
    if isinstance(constraint.factor, BodyRadiusPlus):
        factor = body + Fraction(constraint.factor.radius)
    else:
        factor = Fraction(float(constraint.factor(design)))
    for side, radius in product(map(int, constraint.sides), problem.profile):
        if isinf(radius):  # a line
            yield -allowed
        elif problem.setup.mechanism.flat_faced:
            yield factor * side * Fraction(radius) - allowed
        else:
            of_pitch = body + Fraction(radius)
            yield (factor * side - allowed * of_pitch) * (1 if of_pitch > 0 else -1)
