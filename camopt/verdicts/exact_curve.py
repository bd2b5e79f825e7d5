"""Curves in balls: the formulas of mechanisms and loads, run on the motion of one design in balls."""

from collections.abc import Callable
from typing import Any

import numpy as np
from flint import arb

from camopt.effects.peak import Derivative, NumberKind
from camopt.mechanisms import Designs
from camopt.numerics.curves import curve
from camopt.numerics.state import Load, State, TrainForces
from camopt.verdicts.ball import Ball

BALL_NUMBERS = NumberKind(arb, arb.pi, arb.tan)
LOADS: dict[int, Any] = {0: lambda: None, 2: Load, 4: TrainForces}
"""What a load is to curves, by how many balls it has."""
ExactCurve = Callable[[list[Ball]], tuple[Any, Any]]
"""From the motion, its derivatives and a load to value and slope."""


def in_balls(design: Designs) -> Designs:
    """One design with its sizes as balls, taken as exact."""
    return design.with_values({name: Ball(value) for name, value in design.sizes.items()})


def of_curve(made: Any) -> ExactCurve:
    """Value and slope of a curve, from the motion and its derivatives, and a load that changes."""
    made = _numbers_in_balls(made)

    def values(motion: list[Ball]) -> tuple[Any, Any]:
        if isinstance(made, Derivative):
            return motion[made.order], motion[made.order + 1]
        y, y1, y2, y3, y4, *load = motion
        return curve(made, ..., State(y, y1, y2, y3, LOADS[len(load)](*load), y4))

    return values


def _numbers_in_balls(made: Any) -> Any:
    """A curve whose numbers are balls: numpy's beside balls take longer than the arithmetic. Tables stay."""
    if hasattr(made, "_fields"):
        return type(made)(*map(_numbers_in_balls, made))
    if isinstance(made, (np.ndarray, np.floating)) and made.size == 1 and made.dtype.kind == "f":
        return Ball(made)
    return made
