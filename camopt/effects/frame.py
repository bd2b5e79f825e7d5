"""Frame: how far apart two contacts of one follower are, which is the same at every cam angle.

    two rollers that translate:  √((e₂ − e₁)² + (s₀₁ + s₀₂ + h)²)
    two arms:                    η = ψ₀₁ + ψ₀₂ + h
    two flat faces:              the breadth of the disc, R_b1 + R_b2 + h

with s₀ and ψ₀ of each contact at its lowest, and the lift h (``mechanisms.pairs``).
"""

from typing import Any

import numpy as np

from camopt.effects.case import Case, Effect, Setup

DISTANCE, ANGLE, BREADTH = "roller_distance_mm", "subtending_angle_deg", "breadth_mm"


def offers(setup: Setup) -> tuple[str, ...]:
    if not setup.mechanism.further:
        return ()
    return (BREADTH if setup.mechanism.flat_faced else ANGLE if setup.angular else DISTANCE,)


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    mechanism, lift, first = case.setup.mechanism, case.programme.lift, case.designs
    (contact,) = mechanism.further
    second, (name,) = contact.seen(first), offers(case.setup)
    if mechanism.start is None:
        return {name: first.size + second.size + lift}
    along = mechanism.start(first) + mechanism.start(second) + lift
    if case.setup.angular:
        return {name: np.rad2deg(1.0) * along}
    return {name: np.sqrt(np.square(second.offset - first.offset) + np.square(along))}


EFFECT = Effect("frame", offers, run, is_of_sizes=True)
