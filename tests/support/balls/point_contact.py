"""The pressure of a point contact (``numerics.point_contact``) in balls."""

from typing import Any

from flint import acb, arb

from camopt.core.numerics.point_contact import contact_half_axis_ratio, pressure_factor_and_derivative
from support.balls.ball import Ball, ball_between

SHORT_CHORD = arb(2) ** -64  # relative: a chord this short stands for the slope
CONVERGED = arb(2) ** -180
NEWTON_STEPS = 8


def _carlson(ellipticity: arb) -> tuple[arb, arb]:
    """B and D of μ."""
    square = ellipticity * ellipticity
    return square * acb.elliptic_rd(0, 1, square).real / 3, acb.elliptic_rd(0, square, 1).real / 3


def _factor(t: arb) -> arb:
    """h of an exact t > 0: ln μ by secants from its value in doubles, and then between two signs."""

    def logarithmic_gap(x: arb) -> arb:
        b, d = _carlson(x.exp())
        return (b / d).log() - 2 * x - t.log()

    one, other = _start(t), _start(t) + arb(2) ** -50
    before = logarithmic_gap(one)
    for _ in range(NEWTON_STEPS):
        here = logarithmic_gap(other)
        change = here - before
        if change.contains(0):
            break
        one, before, other = other, here, (other - here * (other - one) / change).mid()
    if not (logarithmic_gap(other - CONVERGED) > 0 and logarithmic_gap(other + CONVERGED) < 0):
        return arb(0, float("inf"))
    mu = ball_between(other - CONVERGED, other + CONVERGED).exp()
    b, _ = _carlson(mu)
    return 3 * mu / (8 * arb.pi() * b * b)


def _start(t: arb) -> arb:
    return arb(float(contact_half_axis_ratio(float(t.mid())))).log().mid()


@pressure_factor_and_derivative.register
def _of_ball(t: Ball, table: Any) -> tuple[Any, Any]:
    """h falls and is convex: its ends bound it, and chords outside them its slope."""
    low, high = t.arb.lower(), t.arb.upper()
    if not low > 0:
        return Ball(arb(0, float("inf"))), Ball(arb(0, float("inf")))
    most, least = _factor(low), _factor(high)
    steep = (most - _factor((low * (1 - SHORT_CHORD)).mid())) / (low - (low * (1 - SHORT_CHORD)).mid())
    gentle = (_factor((high * (1 + SHORT_CHORD)).mid()) - least) / ((high * (1 + SHORT_CHORD)).mid() - high)
    return Ball(most.union(least)), Ball(steep.union(gentle))
