"""Cylindrical cam, translating follower, developed at the mean radius R_m.

The pitch curve is (R_m·θ, y), and both walls of the groove touch the roller:

    tan β = y'/R_m,    κ = (y''/R_m²) / (1 + (y'/R_m)²)^{3/2}
"""

from typing import Any

import numpy as np

from camopt.core.numerics import Number
from camopt.core.numerics.curves import curve_type_from_formula, derivative_formula
from camopt.core.numerics.state import State
from camopt.model.mechanisms.contact_errors import ContactErrors, ContactPoint, ContactShift
from camopt.model.mechanisms.design import Designs, Mechanism, with_zero_roller_radius
from camopt.model.mechanisms.elements import CYLINDER, GROOVED, ROUND_TIPS, TRANSLATING
from camopt.model.mechanisms.trace import tangential_acceleration, trace_curvature


@curve_type_from_formula
def cylindrical_pressure_tangent(state: State, mean_radius: Number) -> Number:
    """tan β; ``mean_radius`` is R_m [mm]."""
    return state.y1 / mean_radius


@derivative_formula(cylindrical_pressure_tangent)
def cylindrical_pressure_derivatives(curve, design, state):
    return (
        state.y1 / curve.mean_radius[design],
        state.y2 / curve.mean_radius[design],
        state.y3 / curve.mean_radius[design],
        state.y4 / curve.mean_radius[design],
    )


@curve_type_from_formula
def cylindrical_path_speed(state: State, mean_radius: Number) -> Number:
    """Length of the pitch curve per cam angle, √(R_m² + y'²) [mm/rad]."""
    return np.sqrt(np.square(mean_radius) + np.square(state.y1))


@curve_type_from_formula
def cylindrical_tangential_acceleration(state: State, mean_radius: Number) -> Number:
    """Derivative of ``cylindrical_path_speed`` by the cam angle [mm/rad²]."""
    return tangential_acceleration(state.y1, state.y2, mean_radius, 0.0)


@curve_type_from_formula
def cylindrical_curvature(state: State, mean_radius: Number) -> Number:
    """κ of the developed pitch curve [1/mm]."""
    return trace_curvature(-state.y1, -state.y2, mean_radius, 0.0, 0.0)


def _cylindrical_contact(design: Designs, lift: float, angle: Any, y: Any, y1: Any) -> ContactPoint:
    return ContactPoint(angle * design.size, y, -y1, y * 0.0 + design.size)


def _cylindrical_shifted_contact(
    design: Designs, lift: float, y: Any, y1: Any, errors: ContactErrors
) -> ContactShift:
    """On the developed surface the follower moves along one line, so both shifts are those of the point."""
    across, up = errors.trace_point_shift_by_cam_errors(_cylindrical_contact(design, lift, y * 0.0, y, y1))
    return ContactShift(up, across / design.size)


MECHANISM = Mechanism(
    body=CYLINDER,
    drive=GROOVED,
    motion=TRANSLATING,
    tips=ROUND_TIPS,
    sizes=("roller_radius",),
    name="cylindrical cam, translating follower",
    pressure=lambda designs, programme: cylindrical_pressure_tangent(designs.size),
    curvature=lambda designs, programme: cylindrical_curvature(designs.size),
    path=lambda designs, programme: cylindrical_path_speed(designs.size),
    speeding=lambda designs, programme: cylindrical_tangential_acceleration(designs.size),
    assembly_margins=lambda designs, programme: (designs.size,),
    assembly="the mean radius has to be above 0",
    contact=_cylindrical_contact,
    shifted_contact=_cylindrical_shifted_contact,
    pitch=with_zero_roller_radius,
)
