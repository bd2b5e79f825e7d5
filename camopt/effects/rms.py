"""Root mean square of the follower's acceleration and jerk over the turn: what heats a drive and excites a machine.

    √(1/(2π)·∮a² dθ),  a = ω²·y'', or the derivative by the cam angle without a speed; the jerk likewise

The motion is a polynomial on each panel, and the integral of its square exact. It is infinite where a lower
derivative jumps. It depends on the motion and the speed alone.
"""

from math import inf
from typing import Any

from camopt.effects.case import Case, Effect, Setup
from camopt.effects.motion import scale
from camopt.effects.peak import Derivative
from camopt.motion.programme import Programme, root_mean_square
from camopt.quantities import MEANS, motion_mean


def _names(setup: Setup) -> dict[str, int]:
    """Name of each quantity with its order of derivative."""
    timed = setup.omega is not None
    return {motion_mean(each, angular=setup.angular, timed=timed): order for each, order in MEANS.items()}


def offers(setup: Setup) -> tuple[str, ...]:
    return tuple(_names(setup))


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    names = {name: order for name, order in _names(case.setup).items() if name in wanted}
    return {name: _mean(case.programme, order) * scale(case.each, order) for name, order in names.items()}


def _mean(programme: Programme, order: int) -> float:
    return inf if Derivative(order).jumps(programme) else root_mean_square(programme, order)


EFFECT = Effect("rms", offers, run, of_motion=lambda setup: True)
