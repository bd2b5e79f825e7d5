"""Lift change: the largest change of the lift from one degree of the cam to the next.

It is the largest |y'| over the turn, per degree of the cam. A grinder with a table of lifts at every degree has to
follow it.
"""

from math import radians
from typing import Any

from camopt.core.numerics import LARGEST_MAGNITUDE
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup
from camopt.model.effects.peak import DegreeScale, MotionDerivative, Peak
from camopt.model.motion.programme import derivative_peak
from camopt.model.motion.stroke import ALL_STROKES, RETURN, RISE


def lift_change_name(setup: Setup) -> str:
    """Name of the quantity, in mm or deg per deg."""
    return f"lift_change_max_{'deg' if setup.tool_turns else 'mm'}_per_deg"


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    per_degree = 1.0 if case.setup.tool_turns else radians(1.0)
    return {lift_change_name(case.setup): derivative_peak(case.programme.tool, 1, ALL_STROKES) * per_degree}


def peaks(setup: Setup) -> dict[str, Peak]:
    scale = DegreeScale(0 if setup.tool_turns else -1)
    return {lift_change_name(setup): Peak(((MotionDerivative(1), RISE | RETURN),), LARGEST_MAGNITUDE, scale)}


EFFECT = Effect(
    "lift_change",
    lambda setup: (lift_change_name(setup),),
    evaluate_columns,
    is_of_motion=lambda setup: True,
    peaks=peaks,
)
