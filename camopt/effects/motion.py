"""Motion: peak velocity, acceleration and jerk of the follower. The same for all designs of a programme.

velocity = ω·y', acceleration = ω²·y'', jerk = ω³·y''' at constant ω; without a speed, the derivatives by cam
angle themselves. Where a lower derivative jumps a peak is an impulse, and is reported as infinite.
"""

from math import degrees
from typing import Any

from camopt.effects.case import Case, Effect, Setup, of_setting
from camopt.effects.peak import ByTime, Derivative, InDegrees, Peak, Scale, Times
from camopt.motion.programme import peak
from camopt.motion.table import RETURN, RISE
from camopt.numerics import LARGEST_MAGNITUDE
from camopt.quantities import DERIVATIVES, motion_quantity

MOVE_KINDS = {"rise": RISE, "return": RETURN, "": RISE | RETURN}


def _names(setup: Setup) -> dict[str, tuple[int, int]]:
    """Name of each quantity with its order of derivative and kinds of stroke."""
    timed = setup.omega is not None
    return {
        motion_quantity(derivative, stroke, angular=setup.angular, timed=timed): (order, kinds)
        for order, derivative in enumerate(DERIVATIVES, start=1)
        for stroke, kinds in MOVE_KINDS.items()
    }


def offers(setup: Setup) -> tuple[str, ...]:
    return tuple(_names(setup))


def scale(setup: Setup, order: int) -> Any:
    """From mm (rad) by cam angle to the table's unit: m by time, rad by time, mm or deg by cam angle."""
    if setup.omega is not None:
        return setup.omega**order * (1.0 if setup.angular else 1e-3)
    return degrees(1.0) if setup.angular else 1.0


def derivative_scale(setup: Setup, order: int) -> Scale:
    """As ``scale``, for any kind of number."""
    if setup.rpm is None:
        return InDegrees(int(setup.angular))
    unit = 1.0 if setup.angular else 1e3
    by_time, by_unit = ByTime(unit, order, setup.rpm), Times(1.0 / unit)
    return of_setting(setup, by_time, by_unit, lambda each: each.omega**order)


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    return {
        name: peak(case.programme, order, kinds) * scale(case.each, order)
        for name, (order, kinds) in _names(case.setup).items()
        if name in wanted
    }


def peaks(setup: Setup) -> dict[str, Peak]:
    return {name: _peak(setup, *which) for name, which in _names(setup).items()}


def _peak(setup: Setup, order: int, kinds: int) -> Peak:
    by_angle = Derivative(order)
    return Peak(((by_angle, kinds),), LARGEST_MAGNITUDE, derivative_scale(setup, order), by_angle.jumps)


EFFECT = Effect("motion", offers, run, of_motion=lambda setup: True, peaks=peaks)
