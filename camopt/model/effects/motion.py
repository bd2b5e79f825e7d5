"""Motion: peak velocity, acceleration and jerk of the follower, the same for all designs of a programme.

With a train these are the peaks of the tool; those of the follower have other names.

velocity = ω·y', acceleration = ω²·y'', jerk = ω³·y''' at constant ω; without a speed, the derivatives by the cam
angle. If a lower derivative jumps, the peak is an impulse, and is reported as infinite.
"""

from functools import cache
from math import degrees
from typing import Any

from camopt.core.numerics import LARGEST_MAGNITUDE, Number
from camopt.core.quantities import (
    AT_FOLLOWER,
    DERIVATIVE_UNITS,
    displacement_unit,
    dwell_error_name,
    motion_error_name,
    motion_peak_name,
    motion_unit,
)
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup, scale_per_design_if_varied
from camopt.model.effects.peak import DegreeScale, MotionDerivative, MultipleScale, Peak, Scale, TimeDerivativeScale
from camopt.model.motion.programme import derivative_peak
from camopt.model.motion.stroke import RETURN, RISE

MOVE_KINDS = {"rise": RISE, "return": RETURN, "": RISE | RETURN}


def _motion_curves(setup: Setup) -> dict[str, tuple[MotionDerivative, int]]:
    """The derivative and the kinds of strokes of each quantity, by name."""
    return _derivative_and_stroke_kinds_by_quantity(
        setup.tool_turns, None if setup.train is None else setup.angular, setup.omega is not None
    )


@cache
def _derivative_and_stroke_kinds_by_quantity(
    tool_turns: bool, follower_turns: bool | None, timed: bool
) -> dict[str, tuple[MotionDerivative, int]]:
    """Derivative and kinds of strokes of each motion quantity, by name.

    ``follower_turns`` is None without a train.
    """
    quantities = dict[str, tuple[MotionDerivative, int]]()
    for order, name in enumerate(DERIVATIVE_UNITS, start=1):
        for stroke, kinds in MOVE_KINDS.items():
            quantities[motion_peak_name(name, stroke, angular=tool_turns, timed=timed)] = (
                MotionDerivative(order),
                kinds,
            )
        if follower_turns is not None:
            quantity = motion_peak_name(name, AT_FOLLOWER, angular=follower_turns, timed=timed)
            quantities[quantity] = MotionDerivative(order, at_follower=True), RISE | RETURN
    return quantities


def motion_table_unit(setup: Setup, order: int) -> str:
    """Unit in tables of the tool's displacement (order 0), velocity (1), and so on."""
    if not order:
        return displacement_unit(angular=setup.tool_turns)
    return motion_unit([*DERIVATIVE_UNITS][order - 1], angular=setup.tool_turns, timed=setup.omega is not None)


def motion_error_quantity_names(setup: Setup) -> tuple[str, str, str, str]:
    """Names of the largest errors of position, velocity and acceleration, and of the change in a dwell."""
    angular, timed = setup.tool_turns, setup.omega is not None
    first, second, third = (motion_error_name(order, angular=angular, timed=timed) for order in range(3))
    return first, second, third, dwell_error_name(angular=angular)


def motion_unit_factor(setup: Setup, order: int, *, at_follower: bool = False) -> Number:
    """Factor from mm or rad per radⁿ to the unit of tables.

    That is mm or deg for a displacement, m or rad per sⁿ with a speed, and mm or deg per radⁿ without one.
    """
    turns = setup.angular if at_follower else setup.tool_turns
    if order and setup.omega is not None:
        return setup.omega**order * (1.0 if turns else 1e-3)
    return degrees(1.0) if turns else 1.0


def motion_unit_scale(setup: Setup, order: int, *, at_follower: bool = False) -> Scale:
    """Scale from mm or rad per radⁿ to the unit of tables, for any kind of number."""
    turns = setup.angular if at_follower else setup.tool_turns
    if setup.rpm is None:
        return DegreeScale(int(turns))
    unit = 1.0 if turns else 1e3
    by_time, by_unit = TimeDerivativeScale(unit, order, setup.rpm), MultipleScale(1.0 / unit)
    return scale_per_design_if_varied(setup, by_time, by_unit, lambda each: each.omega**order)


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    return {
        name: derivative_peak(curve.motion_of_tool_or_follower(case.programme), curve.order, kinds)
        * motion_unit_factor(case.setup_per_design, curve.order, at_follower=curve.at_follower)
        for name, (curve, kinds) in _motion_curves(case.setup).items()
        if name in wanted_quantities
    }


def peaks(setup: Setup) -> dict[str, Peak]:
    return {
        name: Peak(
            ((curve, kinds),),
            LARGEST_MAGNITUDE,
            motion_unit_scale(setup, curve.order, at_follower=curve.at_follower),
            curve.is_infinite_somewhere,
        )
        for name, (curve, kinds) in _motion_curves(setup).items()
    }


EFFECT = Effect(
    "motion",
    lambda setup: tuple(_motion_curves(setup)),
    evaluate_columns,
    is_of_motion=lambda setup: True,
    peaks=peaks,
    exact=True,
)
