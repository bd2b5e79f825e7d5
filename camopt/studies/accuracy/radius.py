"""The smallest radius: the least size at which a method finds a limit held, the other sizes given.

Every design asks with the limit that it reaches itself, so that its own size is the answer but for rounding. A
bracketing root-finder (Chandrupatla's) asks the method at one size after another.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from flint import arb
from scipy.optimize import elementwise

from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray
from camopt.problem.problem import Problem
from camopt.studies.accuracy.methods import Method, enclosed
from camopt.studies.accuracy.reference import ALIKE, reference
from camopt.studies.accuracy.subjects import Subject
from camopt.verdicts.ball import Ball, as_arb, precisely
from camopt.verdicts.exact_curve import in_balls

ROOM = 0.1  # relative, to both sides of a design's own size
find_root: Any = elementwise.find_root  # its stubs know no arguments beside the root
FIRST_STEP = arb(2) ** -27  # relative, of the secant in balls; a power of two is exact at any precision


def bracketed(
    problem: Problem, subject: Subject, method: Method, designs: Designs, limit: FloatArray
) -> FloatArray:
    """Which designs break their limit if smaller by ROOM, and hold it if larger."""
    found = np.ones(len(designs), dtype=bool)
    for side in (-1.0, 1.0):
        moved = replace(designs, size=designs.size * (1.0 + side * ROOM))
        found &= problem.setup.mechanism.exists(moved, problem.programme)
        value, _ = method.run(
            subject.make(moved, problem.programme), len(moved), problem.programme, subject.questions
        )
        found &= side * subject.excess(value, np.zeros_like(value), limit) < 0.0
    return found


def smallest_radii(
    subject: Subject, method: Method, programme: Programme, designs: Designs, limit: FloatArray, side: float = 1.0
) -> tuple[FloatArray, FloatArray]:
    """Brackets (low, high) of the size at which a method holds the limit: to the half-width beyond its answer.

    With ``side`` −1 to as much this side of it. Enclosures go to a quarter of the tolerance, and so does the
    bracket, since errors of both add up in the size; samples know no tolerance, and the bracket goes to 1e-9.
    """
    accuracy = 0.25 * method.setting if method.setting < 1.0 else 1e-9
    run = enclosed(accuracy) if method.setting < 1.0 else method.run

    def excess(size: FloatArray, index: FloatArray) -> FloatArray:
        i = index.astype(int)
        f = subject.make(replace(designs.take(i), size=size), programme)
        value, width = run(f, size.size, programme, subject.questions)
        return subject.excess(value, side * width, limit[i])

    ends = designs.size * (1.0 - ROOM), designs.size * (1.0 + ROOM)
    found = find_root(excess, ends, args=(np.arange(len(designs)),), tolerances={"xrtol": accuracy})
    return found.bracket[0], found.bracket[1]


@precisely()
def reference_radius(subject: Subject, problem: Problem, design: Designs, limit: float, where: FloatArray) -> arb:
    """The size of one design at its limit, to 25 digits, by a secant in balls.

    Raises
    ------
    ArithmeticError
        If the secant does not settle.
    """
    bound = arb(limit) if subject.name != "pressure angle" else (arb(limit) * arb.pi() / 180).tan()
    exact: Any = in_balls(design)

    def excess(size: arb) -> arb:
        sized = replace(exact, size=Ball(size))
        return (reference(subject, problem, sized, where) - arb(subject.sign) * bound).mid()

    one = as_arb(exact.size)
    other = one * (1 + FIRST_STEP)
    beyond, there = excess(one), excess(other)
    for _ in range(4):
        step = (there * (other - one) / (there - beyond)).mid()
        one, beyond, other = other, there, (other - step).mid()
        if abs(step) < ALIKE * other:
            return other
        there = excess(other)
    raise ArithmeticError(f"no smallest radius of {design} by balls")
