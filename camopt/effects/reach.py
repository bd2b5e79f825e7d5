"""Face reach: how far the contact travels along a flat face.

Translating: from the follower's axis, positive to the side the contact moves to on the rise. Oscillating:
distance from the pivot.
"""

from typing import Any

import numpy as np

from camopt.effects.case import Case, Effect, Subject
from camopt.motion.table import TURN
from camopt.numerics.extremes import LARGEST, LEAST


def offers(subject: Subject) -> tuple[str, ...]:
    return () if subject.mechanism.reach is None else ("face_reach_max_mm", "face_reach_min_mm")


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    assert case.subject.mechanism.reach is not None
    (furthest, nearest), _ = case.extremes(case.subject.mechanism.reach, [(TURN, LARGEST), (TURN, LEAST)])
    return {"face_reach_max_mm": np.asarray(furthest), "face_reach_min_mm": np.asarray(nearest)}


EFFECT = Effect("reach", offers, run)
