"""The motion on the arcs and lines of a profile in balls: the formulas of ``motion.profile_contact``, run on balls.

What a law is made from, the centres of arcs found and rounded among it, is taken as exact.
"""

from dataclasses import dataclass, replace
from functools import cache, cached_property
from math import factorial
from typing import Any

from flint import arb, arb_series

from camopt.core.numerics.taylor import (
    Direction,
    Taylor,
    cosine_and_sine_series,
    series_derivative,
    series_quotient,
    series_root,
    vector_angle,
)
from camopt.model.motion.profile_law import ProfileLaw
from support.balls.ball import Ball, precisely


@dataclass(frozen=True)
class ProfilePiece:
    """The motion on one element, over x from ``start`` to ``end``."""

    law: ProfileLaw
    """With balls in place of its numbers."""
    turn: arb
    start: arb
    end: arb

    def derivative(self, order: int, x: arb) -> arb:
        """A derivative by x over a ball of x; of the displacement, from where it starts."""
        return self.derivatives(order + 1, x)[order]

    def derivatives(self, count: int, x: arb) -> list[arb]:
        """The displacement from where it starts, and its derivatives by x, over a ball of x: of one series."""
        series = self.law.follower_position(arb_series([self.law.first + self.turn * x, self.turn], count))
        value, *rest = (series[k] * factorial(k) for k in range(count))
        return [value - self.begins, *rest]

    @cached_property
    def begins(self) -> arb:
        """The position where the element starts."""
        found: arb = self.law.follower_position(arb_series([self.law.first], 1))[0]
        return found


@cache
@precisely()
def piece_on_profile(law: ProfileLaw) -> ProfilePiece:
    """The one piece of a law."""
    contact: Any = law.contact
    numbers: dict[str, Any] = {name: arb(value) for name, value in vars(contact).items()}
    radius = None if law.radius is None else arb(law.radius)
    exact: dict[str, Any] = {"radius": radius, "distance": arb(law.distance), "first": arb(law.first)}
    of_balls = replace(law, contact=replace(contact, **numbers), **exact)
    return ProfilePiece(of_balls, law.turn * arb.pi() / 180, arb(0), arb(1))


@series_root.register
def _(series: arb_series) -> arb_series:
    """Term by term: flint's own is by Newton's method, with far wider terms over a wide ball."""
    found = Taylor([Ball(series[k]) for k in range(series.prec)]).root()
    return arb_series([term.arb for term in found.terms], series.prec)


@series_quotient.register
def _(a: arb_series, b: arb_series) -> arb_series:
    return a * b.inv()  # not known where b may be zero; divided by b, it would be an error


@series_derivative.register
def _(series: arb_series) -> arb_series:
    return series.derivative()


@cosine_and_sine_series.register
def _(angle: arb_series) -> Direction:
    sine, cosine = angle.sin_cos()
    return Direction(cosine, sine)


@vector_angle.register
def _(x: arb_series, y: arb_series) -> arb_series:
    rate = (x * y.derivative() - y * x.derivative()) * (x * x + y * y).inv()
    return rate.integral() + arb.atan2(y[0], x[0])
