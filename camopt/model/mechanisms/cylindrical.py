"""Cylindrical cam, translating follower, developed at the mean radius R_m.

The pitch curve is (R_m·θ, y), and both walls of the groove touch the roller:

    tan β = y'/R_m,    κ = (y''/R_m²) / (1 + (y'/R_m)²)^{3/2}
"""

from typing import Any

import numpy as np

from camopt.core.numerics.curves import curve_type, derivative_formula
from camopt.model.mechanisms.contact_errors import ContactErrors, ContactPoint, ContactShift
from camopt.model.mechanisms.design import Designs, Mechanism, without_roller
from camopt.model.mechanisms.elements import CYLINDER, GROOVED, ROUND_TIPS, TRANSLATING
from camopt.model.mechanisms.trace import speed_change, trace_curvature
from camopt.model.motion.programme import Programme


@curve_type
def cylindrical_pressure(at, mean_radius):
    """tan β; ``mean_radius`` is R_m [mm]."""
    return at.y1 / mean_radius


@derivative_formula(cylindrical_pressure)
def cylindrical_pressure_derivatives(f, i, at):
    return at.y1 / f.mean_radius[i], at.y2 / f.mean_radius[i], at.y3 / f.mean_radius[i], at.y4 / f.mean_radius[i]


@curve_type
def cylindrical_path(at, mean_radius):
    """Length of the pitch curve per cam angle, √(R_m² + y'²) [mm/rad]."""
    return np.sqrt(np.square(mean_radius) + np.square(at.y1))


@curve_type
def cylindrical_speed_change(at, mean_radius):
    """Derivative of ``cylindrical_path`` by the cam angle [mm/rad²]."""
    return speed_change(at.y1, at.y2, mean_radius, 0.0)


@curve_type
def cylindrical_curvature(at, mean_radius):
    """κ of the developed pitch curve [1/mm]."""
    return trace_curvature(-at.y1, -at.y2, mean_radius, 0.0, 0.0)


def _cylindrical_margins(designs: Designs, programme: Programme) -> tuple[Any, ...]:
    return (designs.size,)


def _cylindrical_contact(design: Designs, lift: float, angle: Any, y: Any, y1: Any) -> ContactPoint:
    return ContactPoint(angle * design.size, y, -y1, y * 0.0 + design.size)


def _cylindrical_shift(design: Designs, lift: float, y: Any, y1: Any, errors: ContactErrors) -> ContactShift:
    """On the developed surface the follower moves along one line, so both shifts are those of the point."""
    across, up = errors.point_shift(_cylindrical_contact(design, lift, y * 0.0, y, y1))
    return ContactShift(up, across / design.size)


MECHANISM = Mechanism(
    body=CYLINDER,
    drive=GROOVED,
    motion=TRANSLATING,
    tips=ROUND_TIPS,
    sizes=("roller_radius",),
    name="cylindrical cam, translating follower",
    pressure=lambda designs, programme: cylindrical_pressure(designs.size),
    curvature=lambda designs, programme: cylindrical_curvature(designs.size),
    path=lambda designs, programme: cylindrical_path(designs.size),
    speeding=lambda designs, programme: cylindrical_speed_change(designs.size),
    assembly_margins=_cylindrical_margins,
    assembly="the mean radius has to be above 0",
    contact=_cylindrical_contact,
    shifted_contact=_cylindrical_shift,
    pitch=without_roller,
)
