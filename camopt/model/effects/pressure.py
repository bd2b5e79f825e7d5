"""Pressure angle: its largest magnitude over rises, returns and dwells, and the pitch point.

On a cylindrical cam it is the angle at the mean radius R_m. A groove of depth d is steepest at its bottom, at the
radius R_m − d/2; a rib of height d is steepest at its foot, at the same radius.
"""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST_MAGNITUDE, Curve
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup
from camopt.model.effects.peak import AngleOfTangentScale, Peak, Variant
from camopt.model.effects.peak_columns import peak_column
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES, DWELL, RETURN, RISE

ANGLE_ERROR = 4e-16  # relative error of an angle that is computed from its tangent
PITCH_POINT_ANGLE = "pressure_angle_max_at_deg"
BOTTOM_ANGLE = "pressure_angle_max_bottom_deg"
ANGLE_SCALE = AngleOfTangentScale()
STROKE_KINDS = {
    "pressure_angle_max_rise_deg": RISE,
    "pressure_angle_max_return_deg": RETURN,
    "pressure_angle_max_dwell_deg": DWELL,
}
"""The kind of strokes of each quantity."""


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    bottom = (BOTTOM_ANGLE,) if setup.mechanism.body.developed else ()
    return ("pressure_angle_max_deg", *STROKE_KINDS, PITCH_POINT_ANGLE, *bottom)


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    body = setup.mechanism.body
    return (
        {BOTTOM_ANGLE: (f"part.{body.flank_height}",)}
        if body.developed and setup.solid.groove_depth_or_rib_height is None
        else {}
    )


def peaks(setup: Setup) -> dict[str, Peak]:
    names = STROKE_KINDS | {"pressure_angle_max_deg": ALL_STROKES}
    curves: dict[str, Variant] = {name: (setup.mechanism.pressure, kinds) for name, kinds in names.items()}
    if BOTTOM_ANGLE in applicable_quantities(setup) and BOTTOM_ANGLE not in missing_keys_by_quantity(setup):
        curves[BOTTOM_ANGLE] = (partial(_groove_bottom_pressure_curve, setup), ALL_STROKES)
    return {name: Peak((curve,), LARGEST_MAGNITUDE, ANGLE_SCALE) for name, curve in curves.items()}


def _groove_bottom_pressure_curve(setup: Setup, designs: Designs, programme: Programme) -> Curve:
    """Curve tan β at the bottom of the groove, or the foot of the rib."""
    inwards = (setup.solid.groove_depth_or_rib_height or 0.0) / 2.0
    return setup.mechanism.pressure(replace(designs, size=designs.size - inwards), programme)


def evaluate_pitch_curve_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    bits = {name: bit for name, bit in STROKE_KINDS.items() if case.programme.has_kinds(bit)}
    # each kind, or all together
    groups = bits if wanted_quantities & STROKE_KINDS.keys() else {"": sum(bits.values())}
    questions = [(bit, LARGEST_MAGNITUDE) for bit in groups.values()]
    tangents = case.extremes(
        case.setup.mechanism.pressure, questions, exact_angles=PITCH_POINT_ANGLE in wanted_quantities
    )
    angles = ANGLE_SCALE.quantity_from_extreme(tangents.value, case.designs)
    largest = angles.max(axis=0)
    outer = ANGLE_SCALE.quantity_from_extreme(tangents.value + tangents.width, case.designs) + ANGLE_ERROR * largest
    columns: dict[str, Any] = dict.fromkeys(STROKE_KINDS, 0.0)
    columns |= {
        n: EnclosedValue(angle, top - angle, largest) for n, angle, top in zip(groups, angles, outer, strict=True)
    }
    columns["pressure_angle_max_deg"] = EnclosedValue(largest, outer.max(axis=0) - largest, largest)
    if PITCH_POINT_ANGLE in wanted_quantities:
        columns[PITCH_POINT_ANGLE] = np.degrees(tangents.where[angles.argmax(axis=0), np.arange(len(case.designs))])
    if BOTTOM_ANGLE in wanted_quantities:
        columns[BOTTOM_ANGLE] = peak_column(case, peaks(case.setup)[BOTTOM_ANGLE])
    return columns


EFFECT = Effect(
    "pressure",
    applicable_quantities,
    missing_keys_by_quantity=missing_keys_by_quantity,
    evaluate_pitch_curve_columns=evaluate_pitch_curve_columns,
    peaks=peaks,
    is_per_contact=True,
)
