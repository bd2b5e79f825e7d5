"""The reference: extremes to 50 digits in ball arithmetic, found by a secant and proved to be the largest."""

from typing import Any, cast

from flint import arb

from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, FloatArray
from camopt.problem.problem import Problem
from camopt.studies.accuracy.subjects import Subject
from camopt.verdicts.ball import as_arb, precisely
from camopt.verdicts.certify import turn_of
from camopt.verdicts.deciding import HELD, Statement, decide
from camopt.verdicts.exact_curve import in_balls, of_curve
from camopt.verdicts.exact_laws import Stretch, stretches_of
from camopt.verdicts.exact_motion import ExactStroke, motion_at

STEPS = 40  # of the secant
ALIKE = arb(2) ** -83  # 1e-25, exact at any precision
SIGNS = {LARGEST: (1,), LEAST: (-1,), LARGEST_MAGNITUDE: (1, -1)}  # of a curve whose largest value answers a goal


@precisely()
def reference(subject: Subject, problem: Problem, design: Designs, where: FloatArray) -> arb:
    """The oriented extreme of one design to 50 digits: by a secant in balls from a kernel's cam angles, and proved.

    Raises
    ------
    ArithmeticError
        If the proof that nothing is larger fails.
    """
    motion = turn_of(problem.programme)
    made = subject.make(in_balls(design), cast(Programme, motion))
    best: arb | None = None
    for (kinds, goal), angle in zip(subject.questions, where, strict=True):
        for sign in SIGNS[int(goal)]:
            for value in _candidates(made, motion, problem.programme, int(kinds), float(angle), sign):
                best = value if best is None or value > best else best
    assert best is not None
    for kinds, goal in subject.questions:
        for sign in SIGNS[int(goal)]:
            claim = Statement(of_curve(made), int(kinds), arb(sign), best + abs(best) * ALIKE)
            if decide(claim, motion) != HELD:
                raise ArithmeticError(f"no proof of the {subject.name} of {design}")
    return best


def _candidates(made: Any, motion: Any, programme: Programme, kinds: int, angle: float, sign: int) -> list[arb]:
    """Oriented values at the ends of the pieces of a law around a cam angle, and where the slope is zero inside."""
    found, asked = [], Statement(of_curve(made), kinds, arb(sign), arb(0))
    for stroke, plain in zip(motion.strokes, programme.strokes, strict=True):
        about = asked.on(stroke)
        if about is None or not plain.start - 1e-6 <= angle <= plain.end + 1e-6:
            continue
        for piece in stretches_of(stroke.law) if stroke.law else (None,):
            for x in _places(about, stroke, piece, (angle - plain.start) / plain.angle):
                moved = motion_at(stroke, piece, x)
                if about.applies(moved[1].arb)[0]:
                    found.append(as_arb(about.values(moved)[0]) * sign)
    return found


def _places(asked: Statement, stroke: ExactStroke, piece: Stretch | None, near: float) -> list[arb]:
    """The ends of a piece of a law, and where the slope of a curve is zero inside it near some x, by secants."""
    if piece is None:
        return [arb(0)]

    def slope(x: arb) -> arb:
        return as_arb(asked.values(motion_at(stroke, piece, x))[1]).mid()

    x = arb(near)
    if not piece.start - 1e-6 < x < piece.end + 1e-6:
        return [piece.start, piece.end]
    other = x + arb(1e-7)
    for _ in range(STEPS):
        here, there = slope(x), slope(other)
        if here == there:
            break
        x, other = (x - here * (x - other) / (here - there)).mid(), x
    return [piece.start, piece.end, *([x] if piece.start < x < piece.end else [])]
