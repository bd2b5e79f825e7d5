"""Proved deviation of a motion from measured points, and from the straight lines between them.

The motion is that of the scene as it is written. Its angles, lifts and coefficients are exact numbers, and so are
those of the points. Between neighbouring points and knots, the distance from the line is a polynomial, which its
Bernstein coefficients enclose. Angles are rational numbers. All other numbers have PROOF_DIGITS digits. The proof
leaves PROOF_ROUNDING for their rounding, which is far more than it takes.
"""

from collections.abc import Iterator
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import cache
from itertools import accumulate, pairwise
from math import comb, inf, nextafter
from typing import NamedTuple

from camopt.model.motion.programme import Programme
from camopt.model.motion.spline import SplineLaw
from camopt.solve.measured.measured_points import TURN_DEG, MeasuredPoints

PROOF_DIGITS = 60
PROOF_ROUNDING = Decimal("1e-40")
"""Rounding error of a stretch, as a share of its terms; many times the true one."""


class Deviation(NamedTuple):
    """Deviations of a motion from points, in the unit of the lifts."""

    held: bool
    """Whether every point is proved to be within the band."""
    at_points: tuple[float, ...]
    """Motion less lift at each point."""
    largest: float
    """Proved upper bound of the deviation from any point."""
    between: float
    """Proved upper bound of the distance from the straight lines between neighbouring points, at any cam angle."""


class _PolynomialSpan(NamedTuple):
    """y = Σ cₖ·dᵏ from one cam angle to another (deg of the scene), with d from its start."""

    start: Fraction
    end: Fraction
    powers: list[Decimal]

    def coefficients_on_part(self, start: Fraction, end: Fraction) -> list[Decimal]:
        """Coefficients of the powers of t on a part of the span, with t from 0 to 1."""
        offset, length, powers = _to_decimal(start - self.start), _to_decimal(end - start), list(self.powers)
        for low in range(len(powers)):
            for k in range(len(powers) - 2, low - 1, -1):
                powers[k] += offset * powers[k + 1]
        return _scale_coefficients(powers, length)

    @property
    def rounding_error(self) -> Decimal:
        """Largest rounding error of y; 0 at rest, because levels have fewer digits."""
        length, moves = _to_decimal(self.end - self.start), len(self.powers) > 1
        return moves * PROOF_ROUNDING * sum(map(abs, _scale_coefficients(self.powers, length)), Decimal(0))


def _scale_coefficients(coefficients: list[Decimal], length: Decimal) -> list[Decimal]:
    """Coefficients for a variable that is ``length`` times smaller."""
    return [
        c * scale
        for c, scale in zip(
            coefficients, accumulate(coefficients[1:], lambda by, _: by * length, initial=Decimal(1)), strict=True
        )
    ]


def certify_band(
    programme: Programme, points: MeasuredPoints, start_angle_deg: float, zero_lift: float, band: float
) -> Deviation:
    """Proved deviation of a motion from points.

    It starts at their angle ``start_angle_deg`` [deg] and lift ``zero_lift``.
    """
    with localcontext(prec=PROOF_DIGITS):
        return _deviation_of_spans(list(_programme_spans(programme)), points, start_angle_deg, zero_lift, band)


def _deviation_of_spans(
    turn_spans: list[_PolynomialSpan], points: MeasuredPoints, start_angle_deg: float, zero_lift: float, band: float
) -> Deviation:
    """The deviation of the spans of one turn from points."""
    turn_end = turn_spans[-1].end  # lines between points may cross the end of the turn
    spans = turn_spans + [
        span._replace(start=turn_end + span.start, end=turn_end + span.end) for span in turn_spans
    ]
    first, turn = Fraction(start_angle_deg), Fraction(TURN_DEG)
    sorted_points = sorted(
        ((Fraction(angle_deg) - first) % turn, Decimal(lift_given) - Decimal(zero_lift), k)
        for k, (angle_deg, lift_given) in enumerate(zip(points.angles, points.lifts, strict=True))
    )
    deviations, largest_deviation, between, number = [Decimal(0)] * len(sorted_points), Decimal(0), Decimal(0), 0
    for (angle, lift, place), (next_angle, next_lift, _) in pairwise(
        [*sorted_points, (sorted_points[0][0] + turn, *sorted_points[0][1:])]
    ):
        while spans[number].end < angle:
            number += 1
        deviations[place] = spans[number].coefficients_on_part(angle, angle)[0] - lift
        largest_deviation = max(largest_deviation, abs(deviations[place]) + spans[number].rounding_error)
        if next_angle > angle:
            between = max(between, *_line_deviation_bounds(spans, number, (angle, lift), (next_angle, next_lift)))
    held, largest = largest_deviation <= Decimal(band), nextafter(float(largest_deviation), inf)
    between_bound = nextafter(float(between + max(span.rounding_error for span in turn_spans)), inf)
    return Deviation(held, tuple(map(float, deviations)), min(largest, band) if held else largest, between_bound)


def _to_decimal(value: Fraction) -> Decimal:
    return Decimal(value.numerator) / Decimal(value.denominator)


def _programme_spans(programme: Programme) -> Iterator[_PolynomialSpan]:
    """The polynomials of a motion along its turn."""
    angle, level = Fraction(0), Decimal(0)
    for stroke in programme.strokes:
        assert stroke.given is not None
        length, change = Fraction(stroke.given.angle), Decimal(stroke.given.change)
        if stroke.law is None:
            yield _PolynomialSpan(angle, angle + length, [level])
        else:
            assert isinstance(stroke.law, SplineLaw)
            for low, high, powers in _spline_law_polynomials(stroke.law):
                scaled = [change * c for c in _scale_coefficients(powers, 1 / _to_decimal(length))]
                yield _PolynomialSpan(angle + low * length, angle + high * length, [level + scaled[0], *scaled[1:]])
        level, angle = level + change, angle + length


def _spline_law_polynomials(law: SplineLaw) -> Iterator[tuple[Fraction, Fraction, list[Decimal]]]:
    """The polynomial of each span between knots, in powers of the distance from its start (de Boor's algorithm)."""
    knots, degree, zero = [Decimal(knot) for knot in law.knots], law.degree, Decimal(0)
    for k in range(degree, len(law.coefficients)):
        if not knots[k] < knots[k + 1]:
            continue
        found = [[Decimal(c)] for c in law.coefficients[k - degree : k + 1]]
        for level in range(1, degree + 1):
            for j in range(degree, level - 1, -1):
                left, right = knots[k - degree + j], knots[k + 1 + j - level]
                step = [b - a for a, b in zip(found[j - 1], found[j], strict=True)]
                near, far = (knots[k] - left) / (right - left), 1 / (right - left)
                moved = [near * a + far * b for a, b in zip([*step, zero], [zero, *step], strict=True)]
                found[j] = [a + b for a, b in zip([*found[j - 1], zero], moved, strict=True)]
        yield Fraction(law.knots[k]), Fraction(law.knots[k + 1]), found[degree]


def _line_deviation_bounds(
    spans: list[_PolynomialSpan],
    first_span: int,
    first_point: tuple[Fraction, Decimal],
    last_point: tuple[Fraction, Decimal],
) -> Iterator[Decimal]:
    """Bounds of the distance from the line between two points, by Bernstein coefficients."""
    slope = (last_point[1] - first_point[1]) / _to_decimal(last_point[0] - first_point[0])
    while spans[first_span].start < last_point[0]:
        start, end = max(spans[first_span].start, first_point[0]), min(spans[first_span].end, last_point[0])
        if end > start:
            powers = spans[first_span].coefficients_on_part(start, end)
            powers += [Decimal(0)] * (2 - len(powers))
            powers[0] -= first_point[1] + slope * _to_decimal(start - first_point[0])
            powers[1] -= slope * _to_decimal(end - start)
            for row in _bernstein_from_powers(len(powers) - 1):
                yield abs(sum((share * power for share, power in zip(row, powers, strict=False)), Decimal(0)))
        first_span += 1


@cache
def _bernstein_from_powers(degree: int) -> list[list[Decimal]]:
    """Matrix from the power coefficients of a polynomial to its Bernstein coefficients."""
    return [[_to_decimal(Fraction(comb(k, j), comb(degree, j))) for j in range(k + 1)] for k in range(degree + 1)]
