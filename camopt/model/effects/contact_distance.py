"""Frame: the distance of two contacts of one follower, which is the same at every cam angle.

    two rollers that translate:  √((e₂ − e₁)² + (s₀₁ + s₀₂ + h)²)
    two arms:                    η = ψ₀₁ + ψ₀₂ + h
    two flat faces:              the breadth of the disc, R_b1 + R_b2 + h
    two rollers about a rib, on arms:  δ = 2·arcsin(d/2l)

with s₀ or ψ₀ of each contact at its lowest position, and the lift h (``mechanisms.pairs``).
"""

from functools import partial
from math import pi
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST, Number
from camopt.core.numerics.curves import Linear
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup
from camopt.model.effects.peak import IDENTITY_SCALE, MultipleScale, Peak
from camopt.model.mechanisms.design import Designs
from camopt.model.mechanisms.ribs import roller_spacing_as_displacement
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES

DISTANCE, ANGLE, BREADTH = "roller_distance_mm", "subtending_angle_deg", "breadth_mm"


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    if setup.mechanism.has_rib:
        return (ANGLE,) if setup.angular else ()
    if not setup.mechanism.further_contacts:
        return ()
    return (BREADTH if setup.mechanism.flat_faced else ANGLE if setup.angular else DISTANCE,)


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    (name,) = applicable_quantities(case.setup)
    return {
        name: _contact_distance_scale(case.setup).factor
        * _contact_distance(case.setup, case.designs, case.programme)
    }


def peaks(setup: Setup) -> dict[str, Peak]:
    """The distance as the largest value of a constant curve, for searches and proofs."""
    curves = ((partial(_constant_contact_distance_curve, setup), ALL_STROKES),)
    return {name: Peak(curves, LARGEST, _contact_distance_scale(setup)) for name in applicable_quantities(setup)}


def _contact_distance_scale(setup: Setup) -> MultipleScale:
    return MultipleScale(180.0 / pi) if setup.angular else IDENTITY_SCALE


def _constant_contact_distance_curve(setup: Setup, designs: Designs, programme: Programme) -> Linear:
    none = np.zeros(len(designs))
    return Linear(none, none, none, _contact_distance(setup, designs, programme) + none)


def _contact_distance(setup: Setup, designs: Designs, programme: Programme) -> Number:
    """Distance of the contacts [mm or rad]."""
    mechanism, lift = setup.mechanism, programme.lift
    if mechanism.has_rib:
        return roller_spacing_as_displacement(mechanism, designs)
    (contact,) = mechanism.further_contacts
    second = contact.local_designs(designs)
    if mechanism.start is None:
        return designs.size + second.size + lift
    along = mechanism.start(designs) + mechanism.start(second) + lift
    return along if setup.angular else np.sqrt(np.square(second.offset - designs.offset) + np.square(along))


EFFECT = Effect("frame", applicable_quantities, evaluate_columns, is_of_sizes=True, peaks=peaks)
