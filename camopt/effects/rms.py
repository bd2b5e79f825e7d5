"""Root mean square of the follower's acceleration and jerk over the turn: what heats a drive and excites a machine.

    √(1/(2π)·∮a² dθ),  a = ω²·y'', or the derivative by the cam angle without a speed; the jerk likewise

The motion is a polynomial on each panel, and the integral of its square exact. It is infinite where a lower
derivative jumps. It depends on the motion and the speed alone.
"""

from typing import Any

from camopt.effects.case import Case, Effect, Setup
from camopt.effects.mean import Mean
from camopt.effects.mean_columns import mean_column
from camopt.effects.motion import scale_of
from camopt.effects.peak import Derivative
from camopt.motion.table import TURN
from camopt.quantities import MEANS, motion_mean


def _mean(setup: Setup, order: int) -> Mean:
    by_angle = Derivative(order)
    return Mean(((by_angle, TURN),), 2, scale_of(setup, order), by_angle.jumps)


def means(setup: Setup) -> dict[str, Mean]:
    timed = setup.omega is not None
    return {
        motion_mean(each, angular=setup.angular, timed=timed): _mean(setup, order) for each, order in MEANS.items()
    }


def offers(setup: Setup) -> tuple[str, ...]:
    return tuple(means(setup))


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    return {name: mean_column(case, mean) for name, mean in means(case.setup).items() if name in wanted}


EFFECT = Effect("rms", offers, run, of_motion=lambda setup: True, means=means)
