"""Rib: its least thickness between the two rollers of a follower.

Let α₁ and α₂ be the angles between the line through both rollers and the normals of their pitch curves, d the
distance of the centres, and j the clearance. The thickness is

    t = d·cos(½(α₁ + α₂))/cos(½(α₂ − α₁)) − 2·R_r − j = d·(cos α₁ + cos α₂)/(1 + cos(α₂ − α₁)) − 2·R_r − j

    α₁ = β₁ − σ·½δ,    α₂ = β₂ + σ·½δ,    sin(½δ) = d/(2l)      (translating: δ = 0)

with the pressure angles β, the sense of rotation σ (1 for a disc), and arms of the length l (``mechanisms.ribs``).
This is the distance of both flanks if they are arcs about one centre, as in dwells, or parallel lines. A rib for a
translating follower on a cylinder is proved to be nowhere thinner than the least t; no other rib was found that is.
At t ≤ 0 the rollers leave no rib, and the cam cannot exist.
"""

from operator import attrgetter
from typing import Any

import numpy as np

from camopt.core.numerics import LEAST, Curve
from camopt.core.numerics.curves import curve_type_from_formula
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup
from camopt.model.effects.peak import Peak
from camopt.model.effects.peak_columns import peak_column
from camopt.model.mechanisms import Designs
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES

RIB_THICKNESS = "rib_thickness_min_mm"


@curve_type_from_formula
def rib_thickness(
    state,
    first_pressure_tangent,
    second_pressure_tangent,
    spacing,
    half_spacing_cosine,
    half_spacing_sine,
    diameter_and_clearance,
):
    """Thickness of the rib, t [mm], from tan β at both rollers, d, cos and sin of σ·½δ, and 2·R_r + j."""
    root, further = (
        np.sqrt(1.0 + np.square(first_pressure_tangent)),
        np.sqrt(1.0 + np.square(second_pressure_tangent)),
    )
    cos_1, sin_1 = (
        (half_spacing_cosine + half_spacing_sine * first_pressure_tangent) / root,
        (half_spacing_cosine * first_pressure_tangent - half_spacing_sine) / root,
    )
    cos_2, sin_2 = (
        (half_spacing_cosine - half_spacing_sine * second_pressure_tangent) / further,
        (half_spacing_cosine * second_pressure_tangent + half_spacing_sine) / further,
    )
    return spacing * (cos_1 + cos_2) / (1.0 + cos_1 * cos_2 + sin_1 * sin_2) - diameter_and_clearance


def peaks(setup: Setup) -> dict[str, Peak]:
    mechanism = setup.mechanism

    def rib_thickness_curve(designs: Designs, programme: Programme) -> Curve:
        d, zero = designs.roller_spacing, designs.size * 0.0
        sine = 0.5 * d / designs.arm_length if setup.angular else zero
        cosine, way = np.sqrt((1.0 - sine) * (1.0 + sine)), designs.sense if mechanism.body.developed else 1.0
        (second,) = mechanism.further_contacts
        first = mechanism.pressure(designs, programme)
        other = second.mechanism.pressure(second.local_designs(designs), programme)
        return rib_thickness(
            first, other, d, cosine + zero, way * sine, 2.0 * setup.pitch_to_flank_distance(designs) + zero
        )

    curves, spacing = ((rib_thickness_curve, ALL_STROKES),), attrgetter("roller_spacing")
    return {RIB_THICKNESS: Peak(curves, LEAST, unit=spacing, open_at_zero=True)} if mechanism.has_rib else {}


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    return {RIB_THICKNESS: peak_column(case, peaks(case.setup)[RIB_THICKNESS])}


EFFECT = Effect(
    "rib",
    lambda setup: (RIB_THICKNESS,) if setup.mechanism.has_rib else (),
    evaluate_columns,
    peaks=peaks,
    work=400.0,
)
