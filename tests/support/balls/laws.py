"""The motion laws as exact expressions: on each piece a polynomial and sine waves, in balls.

Written apart from ``camopt.model.motion``, from the accelerations that define the laws (from knots and coefficients
for a spline, from the conditions at its ends for a polynomial): a proof does not rest on the tables that it checks.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from math import factorial, perm
from typing import Any

from flint import arb, arb_poly, fmpq, fmpq_mat

from camopt.core.mistakes import BadInput, Mistake
from camopt.model.motion import LAWS
from camopt.model.motion.derived_laws import MirroredLaw, SkewedLaw
from camopt.model.motion.installed_laws import EXACT_CLASSES, InstalledLaw
from camopt.model.motion.law import Law
from camopt.model.motion.polynomial import PolynomialLaw
from camopt.model.motion.profile_law import ProfileLaw
from camopt.model.motion.scca import SCCALaw
from camopt.model.motion.spline import SplineLaw
from support.balls.ball import precisely
from support.balls.driven import DrivenPiece
from support.balls.profile import ProfilePiece, piece_on_profile

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
        return self.derivatives(order + 1, x)[order]

    def derivatives(self, count: int, x: arb) -> list[arb]:
        """The unit stroke and its derivatives over a ball of x."""
        d = x - self.start
        found = [powers(d) for powers in self._rates[:count]]
        found += [arb(0)] * (count - len(found))
        for size, speed, phase in self.waves:
            sine, cosine = (speed * d + phase).sin_cos_pi()
            fast = arb.pi() * speed
            for order in range(count):
                found[order] += size * (sine, cosine, -sine, -cosine)[order % 4]
                size *= fast
        return found

    @cached_property
    def _rates(self) -> list[arb_poly]:
        """The polynomial and its derivatives."""
        found = [arb_poly(list(self.powers))]
        for _ in self.powers[1:]:
            found.append(found[-1].derivative())
        return found


def _moved_piece(piece: Piece, start: arb, end: arb) -> Piece:
    """A part of a piece, its polynomial and waves by the distance from its own start."""
    step, powers = start - piece.start, [arb(c) for c in piece.powers]
    for k in range(len(powers)):  # Horner's scheme, again and again, is the expansion about the new start
        for j in range(len(powers) - 2, k - 1, -1):
            powers[j] += powers[j + 1] * step
    return Piece(start, end, tuple(powers), tuple((a, w, phase + w * step) for a, w, phase in piece.waves))


def _stretched_piece(piece: Piece, by: fmpq, low: fmpq, place: Callable[[arb], arb]) -> Piece:
    """by·s(x/by) + low, from the place of its start to that of its end."""
    powers = [c / arb(by) ** (k - 1) for k, c in enumerate(piece.powers)] or [arb(0)]
    powers[0] += low
    waves = tuple((a * by, w / by, phase) for a, w, phase in piece.waves)
    return Piece(place(piece.start), place(piece.end), tuple(powers), waves)


def _polynomial(*powers: int) -> tuple[Piece, ...]:
    return (Piece(arb(0), arb(1), tuple(arb(c) for c in powers)),)


def _from_accelerations(*pieces: tuple[fmpq, arb, fmpq, fmpq]) -> tuple[Piece, ...]:
    """Pieces from (length, A, w, φ): a = A·sin(π·(w·d + φ)), or a = A where w is 0; integrated twice from rest."""
    found, start, s, v = [], fmpq(0), arb(0), arb(0)
    for length, size, speed, phase in pieces:
        ends = arb(start), arb(start + length)
        if speed == 0:
            piece = Piece(*ends, (s, v, size / 2))
        else:
            swing, fast = size / (arb.pi() * speed), arb.pi() * speed
            powers = (s + swing / fast * arb(phase).sin_pi(), v + swing * arb(phase).cos_pi())
            piece = Piece(*ends, powers, ((-swing / fast, arb(speed), arb(phase)),))
        found.append(piece)
        start = start + length
        s, v = piece.derivative(0, piece.end), piece.derivative(1, piece.end)
    return tuple(found)


def _scca(law: SCCALaw) -> tuple[Piece, ...]:
    """The waves of the acceleration in order; its size in closed form."""
    shares = _rational(law.shares)
    b, c, d, e = (share / sum(shares, fmpq(0)) for share in shares)
    pi, p, half, none = arb.pi(), b + c + d, fmpq(1, 2), fmpq(0)
    through = ((pi**2 - 8) * (b * b - d * d) - 2 * pi * (pi - 2) * b * p + (pi * p) ** 2) / (4 * pi**2)
    size = 1 / (through + ((b + d) / pi + c / 2) * e)
    ramp, fall = (1 / share if share else none for share in (b, d))
    waves = (
        (b / 2, size, ramp, none),
        (c / 2, size, none, none),
        (d / 2, size, fall, half),
        (e, arb(0), none, none),
        (d / 2, size, fall, fmpq(1)),
        (c / 2, -size, none, none),
        (b / 2, size, ramp, 3 * half),
    )
    return _from_accelerations(*(wave for wave in waves if wave[0]))


def _double_harmonic() -> tuple[Piece, ...]:
    half = arb(1) / 2
    waves = ((-half, arb(1), half), (arb(1) / 8, arb(2), half))
    return (Piece(arb(0), arb(1), (arb(3) / 8,), waves),)


def _parabolic() -> tuple[Piece, ...]:
    half = arb(1) / 2
    return Piece(arb(0), half, (arb(0), arb(0), arb(2))), Piece(half, arb(1), (half, arb(2), arb(-2)))


def _wave(size: arb, speed: fmpq, phase: fmpq, *powers: int | fmpq) -> tuple[Piece, ...]:
    """One wave and a polynomial over the whole stroke."""
    return (Piece(arb(0), arb(1), tuple(map(arb, powers)), ((size, arb(speed), arb(phase)),)),)


EXACT_BY_NAME: dict[str, Callable[[], tuple[Piece, ...]]] = {
    "parabolic": _parabolic,
    "harmonic": lambda: _wave(arb(-1) / 2, fmpq(1), fmpq(1, 2), fmpq(1, 2)),
    "cycloidal": lambda: _wave(-1 / (2 * arb.pi()), fmpq(2), fmpq(0), 0, 1),
    "poly345": lambda: _polynomial(0, 0, 0, 10, -15, 6),
    "poly4567": lambda: _polynomial(0, 0, 0, 0, 35, -84, 70, -20),
    "double-harmonic": _double_harmonic,
    "poly56789": lambda: _polynomial(0, 0, 0, 0, 0, 126, -420, 540, -315, 70),
    "half-cycloidal-1": lambda: _wave(-1 / arb.pi(), fmpq(1), fmpq(0), 0, 1),
    "half-cycloidal-2": lambda: _wave(1 / arb.pi(), fmpq(1), fmpq(0), 0, 1),
    "half-harmonic-1": lambda: _wave(arb(-1), fmpq(1, 2), fmpq(1, 2), 1),
    "half-harmonic-2": lambda: _wave(arb(1), fmpq(1, 2), fmpq(0), 0),
}


def _spline(law: SplineLaw) -> tuple[Piece, ...]:
    """The polynomial of each span between knots: its knots and coefficients are exact."""
    knots, coefficients = (list(map(arb, numbers)) for numbers in (law.knots, law.coefficients))
    found = []
    for k in range(law.degree, len(coefficients)):
        if knots[k] < knots[k + 1]:
            powers = _de_boor(law.degree, knots, coefficients, k).coeffs()
            found.append(Piece(knots[k], knots[k + 1], tuple(powers)))
    return tuple(found)


def _de_boor(degree: int, knots: list[arb], coefficients: list[arb], k: int) -> arb_poly:
    """De Boor's algorithm on the span after knot k, run on polynomials of d = x − start."""
    found = [arb_poly([c]) for c in coefficients[k - degree : k + 1]]
    for level in range(1, degree + 1):
        for j in range(degree, level - 1, -1):
            left, right = knots[k - degree + j], knots[k + 1 + j - level]
            over = 1 / (right - left)
            share = arb_poly([(knots[k] - left) * over, over])
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


def _skewed_pieces(law: SkewedLaw) -> tuple[Piece, ...]:
    """The pieces of a law, those of its first half and of its second stretched."""
    (crossing,), half, found = _rational((law.crossing,)), arb(1) / 2, []
    before, after = 2 * crossing, 2 * (1 - crossing)
    for piece in pieces_of(law.law):
        if piece.start < half:
            part = _moved_piece(piece, piece.start, piece.end.min(half))
            found.append(_stretched_piece(part, before, fmpq(0), lambda x: x * before))
        if piece.end > half:
            part = _moved_piece(piece, piece.start.max(half), piece.end)
            found.append(_stretched_piece(part, after, 1 - after, lambda x: 1 - (1 - x) * after))
    return tuple(found)


def _mirrored_pieces(law: MirroredLaw) -> tuple[Piece, ...]:
    """The pieces of a law from their ends, the last one first."""
    found = []
    for piece in reversed(pieces_of(law.law)):
        turned = _moved_piece(piece, piece.end, piece.end)
        powers = [-c * (-1) ** k for k, c in enumerate(turned.powers)] or [arb(0)]
        powers[0] += 1
        waves = tuple((-a, -w, phase) for a, w, phase in turned.waves)
        found.append(Piece(1 - piece.end, 1 - piece.start, tuple(powers), waves))
    return tuple(found)


def _rational(values: tuple[float, ...]) -> list[fmpq]:
    return [fmpq(*value.as_integer_ratio()) for value in values]


class NoExactForm(BadInput):
    """A law is known by its functions alone, of which no number is proved."""

    def __init__(self, name: str) -> None:
        kinds = "one of camopt's own, or an object of PolynomialLaw, SCCALaw or SplineLaw"
        super().__init__([Mistake("camopt", "law", name, f"a law with an exact form: {kinds}")])

    def __reduce__(self) -> Any:
        return NoExactForm, (self.mistakes[0].value,)


def _installed_pieces(law: InstalledLaw) -> tuple[Piece, ...]:
    """The pieces of the law of a package, if it is of a class of camopt's."""
    if type(law.law) not in EXACT_CLASSES:
        raise NoExactForm(law.NAME)
    return pieces_of(law.law)


EXACT_BY_TYPE: dict[type, Callable[[Any], tuple[Piece, ...]]] = {
    SplineLaw: _spline,
    PolynomialLaw: _by_conditions,
    SCCALaw: _scca,
    SkewedLaw: _skewed_pieces,
    MirroredLaw: _mirrored_pieces,
    InstalledLaw: _installed_pieces,
}
"""The exact form of laws that come in families; ``EXACT_BY_NAME`` has that of laws by name."""


@cache
@precisely()
def pieces_of(law: Law) -> tuple[Piece, ...]:
    """The pieces of a law.

    Raises
    ------
    NoExactForm
        If it is of another package, and not of a class of camopt's.
    """
    if form := EXACT_BY_TYPE.get(type(law)):
        return form(law)
    if law.NAME in EXACT_BY_NAME and LAWS.get(law.NAME) is law:
        return EXACT_BY_NAME[law.NAME]()
    raise NoExactForm(law.NAME)


Stretch = Piece | ProfilePiece | DrivenPiece
"""Where a motion is smooth."""


def stretches_of(law: Law) -> tuple[Stretch, ...]:
    """The smooth parts of a law: its pieces on the unit stroke, or an element of a profile."""
    return (piece_on_profile(law),) if isinstance(law, ProfileLaw) else pieces_of(law)
