"""Curves in balls: the formulas of mechanisms and loads, run on the motion of one design in balls.

Over a part of the turn each curve that a formula is made of is where both its ball and its mean-value form have it:

    f(X) ⊂ f(m) + f′(X)·(X − m)

Next to a cusp 1 − κ·R grows with the square of the distance from it, a ball of κ only with the width of the part.

Source: Moore, Kearfott and Cloud, Introduction to Interval Analysis, ch. 6.
"""

from typing import Any

import numpy as np
from flint import arb

from camopt.core.numerics.curves import (
    CURVE_FORMULAS,
    curve_derivatives,
    derivative_formula,
    value_and_slope,
    value_and_slope_formula,
)
from camopt.core.numerics.state import Load, State, TrainForces
from camopt.model.effects.peak import MotionDerivative, NumberKind
from camopt.model.mechanisms import Designs
from support.balls.ball import Ball, as_arb

BALL_NUMBERS = NumberKind(arb, arb.pi, arb.tan)
LOADS: dict[int, Any] = {0: lambda: None, 2: Load, 4: TrainForces}
"""What a load is to curves, by how many balls it has."""


def in_balls(design: Designs) -> Designs:
    """One design with its sizes as balls, taken as exact."""
    return design.with_values({name: Ball(value) for name, value in design.sizes.items()})


class ExactCurve:
    """Value and slope of a curve, from the motion, its derivatives, and a load that changes."""

    def __init__(self, made: Any) -> None:
        self.made, self.by = _numbers_in_balls(made), list[arb]()
        self.close = _close_curve(self.made, self.by)

    def __call__(self, motion: list[Ball]) -> tuple[arb, arb]:
        """Over any range of cam angles."""
        return _values(self.made, motion)

    def in_middle(self, motion: list[Ball]) -> arb:
        """The value in the middle of a part of the turn, which ``around`` is about."""
        self.by.clear()
        here, _ = _values(self.close, motion)
        return here

    def around(self, motion: list[Ball], by: arb) -> tuple[arb, arb]:
        """Over that part, closely: cam angles from the middle are ``by``, in rad."""
        self.by[:] = [by]
        return _values(self.close, motion)


def _values(made: Any, motion: list[Ball]) -> tuple[arb, arb]:
    if isinstance(made, MotionDerivative):
        return motion[made.order].arb, motion[made.order + 1].arb
    y, y1, y2, y3, y4, *load = motion
    value, slope = value_and_slope(made, ..., State(y, y1, y2, y3, LOADS[len(load)](*load), y4))
    return as_arb(value), as_arb(slope)


class Close:
    """A curve that remembers its value in the middle of a part of the turn.

    ``by`` are the cam angles of the part from there, or nothing in the middle itself; all of a formula share it.
    """

    def __init__(self, curve: Any, by: list[arb]) -> None:
        self.curve, self.by, self.here = curve, by, arb(0)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.curve, name)


@value_and_slope_formula(Close)
def curve_ball(f: Any, i: Any, at: State) -> tuple[Ball, Ball]:
    value, slope = map(as_arb, value_and_slope(f.curve, i, at))
    if not f.by:
        f.here = value
    elif slope.is_finite():
        value = value.intersection(f.here + slope * f.by[0])
    return Ball(value), Ball(slope)


@derivative_formula(Close)
def derivative_ball(f: Any, i: Any, at: State) -> tuple[Any, Any, Any, Any]:
    return curve_derivatives(f.curve, i, at)


def _close_curve(made: Any, by: list[arb]) -> Any:
    """A curve that is close, as are all that it is made of."""
    if not hasattr(made, "_fields"):
        return made
    inner = type(made)(*(_close_curve(each, by) for each in made))
    return Close(inner, by) if type(made) in CURVE_FORMULAS else inner


def _numbers_in_balls(made: Any) -> Any:
    """A curve whose numbers are balls: numpy's beside balls take longer than the arithmetic. Tables stay."""
    if hasattr(made, "_fields"):
        return type(made)(*map(_numbers_in_balls, made))
    if isinstance(made, (np.ndarray, np.floating)) and made.size == 1 and made.dtype.kind == "f":
        return Ball(made)
    return made
