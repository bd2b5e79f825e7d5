"""The reference: extremes to 50 digits in ball arithmetic, found by a secant and proved to be the largest."""

from typing import Any, cast

from flint import arb

from camopt.mechanisms import Designs
from camopt.motion.programme import Programme
from camopt.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, FloatArray
from camopt.problem.problem import Problem
from camopt.studies.accuracy.subjects import Subject
from camopt.verdicts.ball import as_arb, precisely
from camopt.verdicts.certify import HELD, Statement, decide, in_balls, motion_at, motion_of, of_curve
from camopt.verdicts.exact_laws import pieces_of

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
    motion = motion_of(problem.programme)
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
    found, values = [], of_curve(made)
    for stroke, plain in zip(motion.strokes, programme.strokes, strict=True):
        if not (stroke.kind & kinds and plain.start - 1e-6 <= angle <= plain.end + 1e-6):
            continue
        for piece in pieces_of(stroke.law) if stroke.law else (None,):

            def at(x: arb, stroke: Any = stroke, piece: Any = piece) -> tuple[arb, arb]:
                value, slope = values(motion_at(stroke, piece, x))
                return as_arb(value) * sign, as_arb(slope).mid()

            if piece is None:
                found.append(at(arb(0))[0])
                continue
            found += [at(piece.start)[0], at(piece.end)[0]]
            x = arb((angle - plain.start) / plain.angle)
            if not piece.start - 1e-6 < x < piece.end + 1e-6:
                continue
            other = x + arb(1e-7)
            for _ in range(STEPS):
                here, there = at(x)[1], at(other)[1]
                if here == there:
                    break
                x, other = (x - here * (x - other) / (here - there)).mid(), x
            if piece.start < x < piece.end:
                found.append(at(x)[0])
    return found
