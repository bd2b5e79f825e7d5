"""The reference: extremes to 25 digits in ball arithmetic."""

from flint import arb

from camopt.effects.peak import Peak
from camopt.mechanisms import Designs
from camopt.numerics import LEAST
from camopt.problem.claims import claims_of
from camopt.problem.problem import Problem
from camopt.verdicts.ball import precisely
from camopt.verdicts.certify import exact_turn, largest_of

EQUAL_DIGITS = arb(2) ** -83  # 1e-25, exact at any precision
ENCLOSED_TO = 2.0**-110


@precisely()
def reference(peak: Peak, problem: Problem, exact: Designs) -> arb:
    """The extreme of one design in balls, in the middle of an enclosure."""
    found = largest_of(claims_of(peak, 1.0), exact, exact_turn(problem.programme)).within(ENCLOSED_TO)
    if not found.rad() < abs(found) * EQUAL_DIGITS:
        raise ArithmeticError(f"no close enclosure of the extreme of {exact}")
    return -found.mid() if peak.goal == LEAST else found.mid()
