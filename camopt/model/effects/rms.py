"""Means of the motion: root mean square of acceleration and jerk, which heat a drive, and the area below the lift.

    √(1/(2π)·∮a² dθ),  a = ω²·y'', or the derivative by the cam angle without a speed; the jerk likewise
    ∮y dθ from the lowest position: the opening of a valve, summed over the turn

The motion is a polynomial on each panel, so these integrals are exact. A root mean square is infinite if a lower
derivative jumps. All depend on the motion and the speed only.
"""

from typing import Any

from camopt.core.quantities import RMS_ORDERS, motion_rms_name
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup
from camopt.model.effects.mean import Mean
from camopt.model.effects.mean_columns import mean_column
from camopt.model.effects.motion import motion_unit_scale
from camopt.model.effects.peak import DegreeScale, MotionDerivative
from camopt.model.motion.stroke import ALL_STROKES


def means(setup: Setup) -> dict[str, Mean]:
    turns, timed = setup.tool_turns, setup.omega is not None
    roots = {
        motion_rms_name(name, angular=turns, timed=timed): Mean(
            ((MotionDerivative(order), ALL_STROKES),),
            2,
            motion_unit_scale(setup, order),
            MotionDerivative(order).is_infinite_somewhere,
        )
        for name, order in RMS_ORDERS.items()
    }
    lift_area = Mean(((MotionDerivative(0), ALL_STROKES),), 1, DegreeScale(int(turns), 360.0))
    return {**roots, f"lift_area_{'deg' if turns else 'mm'}_deg": lift_area}


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    return {name: mean_column(case, mean) for name, mean in means(case.setup).items() if name in wanted_quantities}


EFFECT = Effect(
    "rms", lambda setup: tuple(means(setup)), evaluate_columns, is_of_motion=lambda setup: True, means=means
)
