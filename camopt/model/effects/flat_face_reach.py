"""Face reach: the travel of the contact along a flat face.

On a translating face it is measured from the follower's axis, y' − e·sense (sense +1 for ccw, −1 for cw); positive
to the right of the axis if the cam turns ccw, to the left if cw. On an oscillating face it is the distance from the
pivot.
"""

from typing import Any

from camopt.core.numerics import LARGEST, LEAST
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup
from camopt.model.effects.peak import Peak
from camopt.model.effects.peak_columns import largest_and_least_columns
from camopt.model.motion.stroke import ALL_STROKES


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    return () if setup.mechanism.reach is None else ("face_reach_max_mm", "face_reach_min_mm")


def peaks(setup: Setup) -> dict[str, Peak]:
    if setup.mechanism.reach is None:
        return {}
    curves, goals = ((setup.mechanism.reach, ALL_STROKES),), (LARGEST, LEAST)
    return {name: Peak(curves, goal) for name, goal in zip(applicable_quantities(setup), goals, strict=True)}


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    ends = peaks(case.setup)
    return dict(zip(ends, largest_and_least_columns(case, *ends.values()), strict=True))


EFFECT = Effect("reach", applicable_quantities, evaluate_columns, peaks=peaks, is_per_contact=True)
