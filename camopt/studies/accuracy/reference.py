"""The reference: extremes to 25 digits in ball arithmetic, found by a secant and proved to be the largest."""

from typing import Any, cast

from flint import arb

from camopt.effects.peak import Peak
from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.problem.claims import CLAIM_SIDES
from camopt.problem.problem import Problem
from camopt.verdicts.ball import as_arb, precisely
from camopt.verdicts.certify import exact_turn
from camopt.verdicts.deciding import Statement, decide
from camopt.verdicts.exact_curve import of_curve
from camopt.verdicts.exact_laws import Stretch
from camopt.verdicts.exact_motion import ExactStroke, motion_at
from camopt.verdicts.words import HELD

SECANT_STEPS = 40  # of the secant
EQUAL_DIGITS = arb(2) ** -83  # 1e-25, exact at any precision


@precisely()
def reference(peak: Peak, problem: Problem, exact: Designs, near: float) -> arb:
    """The extreme of one design in balls, by a secant from the cam angle of a kernel's, and proved.

    Raises
    ------
    ArithmeticError
        If the proof that nothing is beyond fails.
    """
    ((make, kinds),), motion = peak.curves, exact_turn(problem.programme)
    values = of_curve(make(exact, cast(Programme, motion)))
    sides = [Statement(values, kinds, arb(side), arb(0)) for side in CLAIM_SIDES[peak.goal]]
    candidates = [each for side in sides for each in _candidates(side, motion, problem.programme, near)]
    best = candidates[0]
    for value in candidates[1:]:
        best = value if value > best else best
    for side in sides:
        if decide(side._replace(bound=best + abs(best) * EQUAL_DIGITS), motion) != HELD:
            raise ArithmeticError(f"no proof of the extreme of {exact}")
    return best * CLAIM_SIDES[peak.goal][0]


def _candidates(side: Statement, motion: Any, programme: Programme, near: float) -> list[arb]:
    """Values at the ends of the pieces of a law around a cam angle, and where the slope is zero inside."""
    found = []
    for stroke, plain in zip(motion.strokes, programme.strokes, strict=True):
        about = side.on(stroke)
        if about is None or not plain.start - 1e-6 <= near <= plain.end + 1e-6:
            continue
        for piece in stroke.pieces or (None,):
            for x in _places(about, stroke, piece, (near - plain.start) / plain.angle):
                moved = motion_at(stroke, piece, x)
                if about.applies(moved[1].arb)[0]:
                    found.append(as_arb(about.values(moved)[0]) * side.factor)
    return found


def _places(about: Statement, stroke: ExactStroke, piece: Stretch | None, near: float) -> list[arb]:
    """The ends of a piece of a law, and where the slope of a curve is zero inside it near some x, by secants."""
    if piece is None:
        return [arb(0)]

    def slope(x: arb) -> arb:
        return as_arb(about.values(motion_at(stroke, piece, x))[1]).mid()

    x = arb(near)
    if not piece.start - 1e-6 < x < piece.end + 1e-6:
        return [piece.start, piece.end]
    other = x + arb(1e-7)
    for _ in range(SECANT_STEPS):
        here, there = slope(x), slope(other)
        if here == there:
            break
        x, other = (x - here * (x - other) / (here - there)).mid(), x
    return [piece.start, piece.end, *([x] if piece.start < x < piece.end else [])]
