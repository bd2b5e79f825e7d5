"""Deviation of a motion from measured points, in balls: at each point, and from straight lines between them.

The motion is that of the scene as it is written: its angles, lifts and coefficients are exact numbers, and so are
the angles and lifts of the points. On each stretch between points and knots the distance from the line is a
polynomial, which its Bernstein coefficients enclose.
"""

from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from math import comb, inf, nextafter
from typing import NamedTuple

from flint import arb, arb_mat, fmpq

from camopt.measured.reading import FULL_TURN, MeasuredPoints
from camopt.motion.programme import Programme
from camopt.verdicts.ball import precisely
from camopt.verdicts.exact_laws import pieces_of


class Deviation(NamedTuple):
    """Deviations of a motion from points, in the unit of the lifts."""

    held: bool
    """Whether it is proved that no point is further away than the band."""
    at_points: tuple[float, ...]
    """Motion less lift at each point."""
    largest: float
    """No point is further away than that."""
    between: float
    """At no cam angle is the motion further than that from the straight lines between neighbouring points."""


class _Span(NamedTuple):
    """y = Σ cₖ·dᵏ from one cam angle to another (deg of the scene), with d from its start."""

    start: fmpq
    end: fmpq
    powers: list[arb]

    def shifted(self, start: fmpq, end: fmpq) -> list[arb]:
        """The powers of t on a part of it, t from 0 to 1."""
        away, length, found = arb(start - self.start), arb(end - start), list(self.powers)
        for low in range(len(found)):
            for k in range(len(found) - 2, low - 1, -1):
                found[k] = found[k] + away * found[k + 1]
        return [c * length**k for k, c in enumerate(found)]


@precisely()
def prove_band(programme: Programme, points: MeasuredPoints, start: float, zero: float, band: float) -> Deviation:
    """The deviation of a motion from points; their angle ``start`` (deg) and lift ``zero`` are its 0 and 0."""
    once = list(_spans(programme))  # and again: lines between points may go beyond the end of the turn
    spans = once + [each._replace(start=once[-1].end + each.start, end=once[-1].end + each.end) for each in once]
    first, turn = _exact(start), fmpq(int(FULL_TURN))
    found = [
        (_turned(_exact(a) - first, turn), _exact(y) - _exact(zero), k)
        for k, (a, y) in enumerate(zip(points.angles, points.lifts, strict=True))
    ]
    found.sort()
    at, between, number = [arb(0)] * len(found), arb(0), 0
    last = (found[0][0] + turn, found[0][1], found[0][2])
    for (angle, lift, place), (after, following, _) in pairwise([*found, last]):
        while spans[number].end < angle:
            number += 1
        at[place] = spans[number].shifted(angle, angle)[0] - arb(lift)
        if after > angle:
            between = max(
                between, *_off_line(spans, number, (angle, arb(lift)), (after, arb(following))), key=_most
            )
    off = [abs(each) for each in at]
    held = all(bool(each <= arb(band)) for each in off)
    largest = max(map(_most, off))
    return Deviation(
        held, tuple(float(v.mid()) for v in at), min(largest, band) if held else largest, _most(between)
    )


def _exact(value: float) -> fmpq:
    return fmpq(*float(value).as_integer_ratio())


def _turned(angle: fmpq, turn: fmpq) -> fmpq:
    """An angle from 0 to a turn."""
    return angle - turn * (angle / turn).floor()


def _most(ball: arb) -> float:
    """A number that no value of a ball is above."""
    return nextafter(float(ball.abs_upper()), inf)


def _spans(programme: Programme) -> Iterator[_Span]:
    """The polynomials of a motion along its turn."""
    angle, level = fmpq(0), arb(0)
    for stroke in programme.strokes:
        assert stroke.given is not None
        length, change = _exact(stroke.given.angle), arb(stroke.given.change)
        if stroke.law is None:
            yield _Span(angle, angle + length, [level])
        else:
            for piece in pieces_of(stroke.law):
                low, high = (fmpq(*float(x.mid()).as_integer_ratio()) for x in (piece.start, piece.end))
                powers = [change * c / arb(length) ** k for k, c in enumerate(piece.powers)] or [arb(0)]
                yield _Span(angle + low * length, angle + high * length, [level + powers[0], *powers[1:]])
        level, angle = level + change, angle + length


def _off_line(spans: list[_Span], number: int, low: tuple[fmpq, arb], high: tuple[fmpq, arb]) -> Iterator[arb]:
    """Balls of the distance from the line between two points: Bernstein coefficients on each part of it."""
    slope = (high[1] - low[1]) / arb(high[0] - low[0])
    while spans[number].start < high[0]:
        start, end = max(spans[number].start, low[0]), min(spans[number].end, high[0])
        if end > start:
            powers = spans[number].shifted(start, end)
            powers += [arb(0)] * (2 - len(powers))
            powers[0] -= low[1] + slope * arb(start - low[0])
            powers[1] -= slope * arb(end - start)
            yield from map(abs, (_bernstein(len(powers) - 1) * arb_mat([[power] for power in powers])).entries())
        number += 1


@cache
@precisely()
def _bernstein(degree: int) -> arb_mat:
    """From the powers of a polynomial to its Bernstein coefficients."""
    every = range(degree + 1)
    return arb_mat([[arb(fmpq(comb(k, j), comb(degree, j))) for j in every] for k in every])
