"""The motion on the arcs and lines of a profile in balls: the formulas of ``motion.contact``, run on balls.

What a law is made from, the centres of arcs found and rounded among it, is taken as exact.
"""

from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any

from flint import arb

from camopt.motion.profile_law import ProfileLaw
from camopt.numerics.taylor import Taylor
from camopt.verdicts.ball import Ball, as_arb, precisely


@dataclass(frozen=True)
class ProfilePiece:
    """The motion on one element, over x from ``start`` to ``end``."""

    law: ProfileLaw
    """With balls in place of its numbers."""
    turn: Ball
    start: arb
    end: arb

    def derivative(self, order: int, x: arb) -> arb:
        """A derivative by x over a ball of x; of the displacement, from where it starts."""
        return self.derivatives(order + 1, x)[order]

    def derivatives(self, count: int, x: arb) -> list[arb]:
        """The displacement from where it starts, and its derivatives by x, over a ball of x: of one series."""
        angle = self.law.first + self.turn * Ball(x)
        terms = [angle, self.turn, *[Ball(0.0)] * count]
        series = self.law.position(Taylor(terms[:count]))
        value, *rest = (as_arb(series.derivative(k)) for k in range(count))
        return [value - self.begins, *rest]

    @cached_property
    def begins(self) -> arb:
        """The position where the element starts."""
        return as_arb(self.law.position(Taylor([self.law.first])).derivative(0))


@cache
@precisely()
def piece_on_profile(law: ProfileLaw) -> ProfilePiece:
    """The one piece of a law."""
    contact: Any = law.contact
    numbers: dict[str, Any] = {name: Ball(value) for name, value in vars(contact).items()}
    radius = None if law.radius is None else Ball(law.radius)
    exact: dict[str, Any] = {"radius": radius, "distance": Ball(law.distance), "first": Ball(law.first)}
    of_balls = replace(law, contact=replace(contact, **numbers), **exact)
    return ProfilePiece(of_balls, Ball(law.turn * arb.pi() / 180), arb(0), arb(1))
