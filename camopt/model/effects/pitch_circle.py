"""The pitch circle of a disc cam, about its axis and through the pitch point.

The pitch point is the point of largest pressure angle on the pitch curve; with a flat face it is a contact point.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 7.
"""

from typing import Any

import numpy as np

from camopt.model.effects.effect import Effect, EvaluationBlock

PITCH_CIRCLE_RADIUS, PITCH_POINT_COLUMN = "pitch_circle_radius_mm", "pressure_angle_max_at_deg"


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    angles = np.radians(case.columns[PITCH_POINT_COLUMN] + np.zeros(len(case.designs)))
    return {
        PITCH_CIRCLE_RADIUS: np.abs(
            case.setup.mechanism.trace_and_normal(case.designs, case.programme, angles).trace
        )
    }


EFFECT = Effect(
    "pitch_circle",
    lambda setup: () if setup.mechanism.body.developed else (PITCH_CIRCLE_RADIUS,),
    evaluate_columns,
    input_quantities=lambda setup: (PITCH_POINT_COLUMN,),
    is_per_contact=True,
    exact=True,
)
