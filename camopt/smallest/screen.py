"""Many designs at a few cam angles, in plain arithmetic: most of those that break a limit show it there."""

import numpy as np
from numpy.typing import NDArray

from camopt.mechanisms import Designs
from camopt.numerics.curves import curve
from camopt.problem.claims import Claim
from camopt.problem.problem import Problem
from camopt.smallest.enclosure import claims_on_size

ANGLES = np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False)
MANY = 8  # designs: fewer are evaluated as fast
CLEARLY = 1e-9  # relative, beyond all rounding


def may_hold(problem: Problem, designs: Designs) -> Designs:
    """The designs without those that break a claim at one of some cam angles, by more than rounding.

    All designs can be assembled. What holds at these angles may break a limit at others.
    """
    for claim in claims_on_size(problem):
        if len(designs) > MANY:
            designs = designs.take(~_broken(problem, claim, designs))
    return designs


def _broken(problem: Problem, claim: Claim, designs: Designs) -> NDArray[np.bool_]:
    """Which designs break a claim at one of the cam angles (designs,)."""
    angles = problem.programme.beside(ANGLES, claim.strokes).ravel()[:, None]
    with np.errstate(all="ignore"):  # what is not known there is nan, and breaks nothing
        made = claim.curve(designs, problem.programme)
        value, _ = curve(made, ..., *problem.programme.state(angles))
        value = claim.factor(designs) * value
        allowed = claim.allowed()
        clearly = CLEARLY * (np.abs(value) + abs(allowed) + claim.unit(designs))
        beyond = [side * value - allowed > clearly for side in claim.sides]
    shown = np.broadcast_to(np.any(beyond, axis=0), (angles.size, len(designs)))
    return np.asarray(np.any(shown, axis=0))
