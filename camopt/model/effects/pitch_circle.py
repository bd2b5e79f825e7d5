"""The pitch circle of a disc cam: about its axis, through the pitch point.

The pitch point is where the pressure angle is largest; it is on the pitch curve, or where a flat face touches.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 7.
"""

from typing import Any

import numpy as np

from camopt.model.effects.case import Case, Effect, Setup

RADIUS, PITCH_POINT = "pitch_circle_radius_mm", "pressure_angle_max_at_deg"


def offers(setup: Setup) -> tuple[str, ...]:
    return () if setup.mechanism.body.developed else (RADIUS,)


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    angles = np.radians(case.found[PITCH_POINT] + np.zeros(len(case.designs)))
    return {RADIUS: np.abs(case.setup.mechanism.travel(case.designs, case.programme, angles).trace)}


EFFECT = Effect("pitch_circle", offers, run, reads=lambda setup: (PITCH_POINT,), of_contact=True, exact=True)
