"""The motion laws as exact expressions: on each piece a polynomial and sine waves, in balls.

Written apart from ``camopt.motion``, from the accelerations that define the laws (from knots and coefficients for
a spline, from the conditions at its ends for a polynomial), so that a proof does not rest on the tables it is to
check.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import factorial, perm

from flint import arb, fmpq, fmpq_mat, fmpq_poly

from camopt.motion.law import Law
from camopt.motion.polynomial import PolynomialLaw
from camopt.motion.spline import SplineLaw
from camopt.verdicts.ball import precisely

SineWave = tuple[arb, arb, arb]
"""A·sin(π·(w·d + φ)): sin π·x is exact where x is a whole number, so that strokes end exactly where they should."""


@dataclass(frozen=True)
class Piece:
    """s(x) = Σ cₖ·dᵏ + Σ A·sin(π·(w·d + φ)) with d = x − start, up to ``end``."""

    start: arb
    end: arb
    powers: tuple[arb, ...]
    waves: tuple[SineWave, ...] = ()

    def derivative(self, order: int, x: arb) -> arb:
        """A derivative of the unit stroke over a ball of x."""
        d, total = x - self.start, arb(0)
        for k in range(len(self.powers) - 1, order - 1, -1):
            factor = 1
            for j in range(order):
                factor *= k - j
            total = total * d + self.powers[k] * factor
        for size, speed, phase in self.waves:
            total += size * (arb.pi() * speed) ** order * (speed * d + phase + arb(order) / 2).sin_pi()
        return total


def _polynomial(*powers: int) -> tuple[Piece, ...]:
    return (Piece(arb(0), arb(1), tuple(arb(c) for c in powers)),)


def _from_accelerations(*pieces: tuple[arb, arb, arb, arb]) -> tuple[Piece, ...]:
    """Pieces from (length, A, w, φ): a = A·sin(π·(w·d + φ)), or a = A where w is 0; integrated twice from rest."""
    found, start, s, v = [], arb(0), arb(0), arb(0)
    for length, size, speed, phase in pieces:
        if speed == 0:
            piece = Piece(start, start + length, (s, v, size / 2))
        else:
            swing, fast = size / (arb.pi() * speed), arb.pi() * speed
            powers = (s + swing / fast * phase.sin_pi(), v + swing * phase.cos_pi())
            piece = Piece(start, start + length, powers, ((-swing / fast, speed, phase),))
        found.append(piece)
        start = start + length
        s, v = piece.derivative(0, start), piece.derivative(1, start)
    return tuple(found)


def _modified_sine() -> tuple[Piece, ...]:
    pi, eighth, half = arb.pi(), arb(1) / 8, arb(1) / 2
    size, fast, slow = 4 * pi**2 / (4 + pi), arb(4), arb(4) / 3
    return _from_accelerations(
        (eighth, size, fast, arb(0)), (6 * eighth, size, slow, half), (eighth, size, fast, 3 * half)
    )


def _modified_trapezoid() -> tuple[Piece, ...]:
    pi, eighth, half, none = arb.pi(), arb(1) / 8, arb(1) / 2, arb(0)
    size, fast = 8 * pi / (2 + pi), arb(4)
    return _from_accelerations(
        (eighth, size, fast, none),
        (2 * eighth, size, none, none),
        (2 * eighth, size, fast, half),
        (2 * eighth, -size, none, none),
        (eighth, size, fast, 3 * half),
    )


def _double_harmonic() -> tuple[Piece, ...]:
    half = arb(1) / 2
    waves = ((-half, arb(1), half), (arb(1) / 8, arb(2), half))
    return (Piece(arb(0), arb(1), (arb(3) / 8,), waves),)


def _parabolic() -> tuple[Piece, ...]:
    half = arb(1) / 2
    return Piece(arb(0), half, (arb(0), arb(0), arb(2))), Piece(half, arb(1), (half, arb(2), arb(-2)))


def _harmonic() -> tuple[Piece, ...]:
    half = arb(1) / 2
    return (Piece(arb(0), arb(1), (half,), ((-half, arb(1), half),)),)


def _cycloidal() -> tuple[Piece, ...]:
    return (Piece(arb(0), arb(1), (arb(0), arb(1)), ((-1 / (2 * arb.pi()), arb(2), arb(0)),)),)


EXACT: dict[str, Callable[[], tuple[Piece, ...]]] = {
    "uniform": lambda: _polynomial(0, 1),
    "parabolic": _parabolic,
    "harmonic": _harmonic,
    "cycloidal": _cycloidal,
    "poly345": lambda: _polynomial(0, 0, 0, 10, -15, 6),
    "poly4567": lambda: _polynomial(0, 0, 0, 0, 35, -84, 70, -20),
    "modified-trapezoid": _modified_trapezoid,
    "modified-sine": _modified_sine,
    "cubic": lambda: _polynomial(0, 0, 3, -2),
    "double-harmonic": _double_harmonic,
    "poly56789": lambda: _polynomial(0, 0, 0, 0, 0, 126, -420, 540, -315, 70),
}


def _spline(law: SplineLaw) -> tuple[Piece, ...]:
    """The polynomial of each span between knots, in rational numbers: its knots and coefficients are exact."""
    knots, coefficients = map(_rational, (law.knots, law.coefficients))
    found = []
    for k in range(law.degree, len(coefficients)):
        if knots[k] < knots[k + 1]:
            powers = _de_boor(law.degree, knots, coefficients, k).coeffs()
            found.append(Piece(arb(knots[k]), arb(knots[k + 1]), tuple(map(arb, powers))))
    return tuple(found)


def _de_boor(degree: int, knots: list[fmpq], coefficients: list[fmpq], k: int) -> fmpq_poly:
    """De Boor's algorithm on the span after knot k, run on polynomials of d = x − start."""
    found = [fmpq_poly([c]) for c in coefficients[k - degree : k + 1]]
    for level in range(1, degree + 1):
        for j in range(degree, level - 1, -1):
            left, right = knots[k - degree + j], knots[k + 1 + j - level]
            share = fmpq_poly([knots[k] - left, 1]) / (right - left)
            found[j] = found[j - 1] + share * (found[j] - found[j - 1])
    return found[degree]


def _by_conditions(law: PolynomialLaw) -> tuple[Piece, ...]:
    """The polynomial with given derivatives at both ends: those at 0 are its first powers."""
    start, end = map(_rational, (law.start, law.end))
    first = [value / factorial(k) for k, value in enumerate(start)]
    rest = range(len(first), law.degree + 1)
    missing = [
        value - sum((perm(power, order) * c for power, c in enumerate(first)), fmpq(0))
        for order, value in enumerate(end)
    ]
    matrix = fmpq_mat([[fmpq(perm(power, order)) for power in rest] for order in range(len(end))])
    solved = matrix.solve(fmpq_mat([[value] for value in missing])) if missing else fmpq_mat(0, 1)
    return (Piece(arb(0), arb(1), tuple(map(arb, [*first, *solved.entries()]))),)


def _rational(values: tuple[float, ...]) -> list[fmpq]:
    return [fmpq(*value.as_integer_ratio()) for value in values]


@cache
@precisely()
def pieces_of(law: Law) -> tuple[Piece, ...]:
    """The pieces of a law."""
    if isinstance(law, SplineLaw):
        return _spline(law)
    return _by_conditions(law) if isinstance(law, PolynomialLaw) else EXACT[law.NAME]()
