"""Cylindrical cam, translating follower, developed at the mean radius R_m: the curve (R_m·θ, y).

tan β = y'/R_m,    κ = (y''/R_m²) / (1 + (y'/R_m)²)^{3/2};    both flanks of the groove touch the roller
"""

from typing import Any, NamedTuple

import numpy as np

from camopt.mechanisms.body import CYLINDER
from camopt.mechanisms.design import Designs, Mechanism, without_roller
from camopt.mechanisms.drive import GROOVED
from camopt.mechanisms.follower import ROUND, TRANSLATING
from camopt.mechanisms.rest import ContactPoint, Off, Rest
from camopt.mechanisms.trace import speed_change, trace_curvature
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray
from camopt.numerics.curves import formula, further_formula


class OverCylinder(NamedTuple):
    """Of each design: R_m, mm."""

    mean_radius: FloatArray


class CylindricalPressureAngle(OverCylinder):
    """tan β."""


class CylindricalPath(OverCylinder):
    """The length of the pitch curve by the cam angle, √(R_m² + y'²), mm/rad."""


class CylindricalPitchCurvature(OverCylinder):
    """κ of the developed pitch curve, 1/mm."""


@formula(CylindricalPressureAngle)
def pressure_angle(f, i, at):
    return at.y1 / f.mean_radius[i], at.y2 / f.mean_radius[i]


@further_formula(CylindricalPressureAngle)
def pressure_angle_further(f, i, at):
    return at.y1 / f.mean_radius[i], at.y2 / f.mean_radius[i], at.y3 / f.mean_radius[i], at.y4 / f.mean_radius[i]


@formula(CylindricalPath)
def path(f, i, at):
    value = np.sqrt(np.square(f.mean_radius[i]) + np.square(at.y1))
    return value, at.y1 * at.y2 / value


class CylindricalSpeedChange(OverCylinder):
    """The derivative of that length by the cam angle, mm/rad²."""


@formula(CylindricalSpeedChange)
def speed_changes(f, i, at):
    return speed_change(at.y1, at.y2, at.y3, f.mean_radius[i], 0.0, 0.0)


@formula(CylindricalPitchCurvature)
def pitch_curvature(f, i, at):
    return trace_curvature(-at.y1, -at.y2, -at.y3, f.mean_radius[i], 0.0, 0.0, 0.0, 0.0)


def _assembly_margins(designs: Designs, programme: Programme) -> tuple[Any, ...]:
    return (designs.size,)


def _contact(design: Designs, lift: float, angle: Any, y: Any, y1: Any) -> ContactPoint:
    return ContactPoint(angle * design.size, y, -y1, y * 0.0 + design.size)


def _rest(design: Designs, lift: float, y: Any, y1: Any, off: Off) -> Rest:
    """On the developed surface the follower has one line on which it moves."""
    across, up = off.shift(_contact(design, lift, y * 0.0, y, y1))
    return Rest(up, across / design.size)


MECHANISM = Mechanism(
    body=CYLINDER,
    drive=GROOVED,
    motion=TRANSLATING,
    tips=ROUND,
    sizes=("roller_radius",),
    name="cylindrical cam, translating follower",
    pressure=lambda designs, programme: CylindricalPressureAngle(designs.size),
    curvature=lambda designs, programme: CylindricalPitchCurvature(designs.size),
    path=lambda designs, programme: CylindricalPath(designs.size),
    speeding=lambda designs, programme: CylindricalSpeedChange(designs.size),
    assembly_margins=_assembly_margins,
    assembly="the mean radius has to be above 0",
    contact=_contact,
    rest=_rest,
    pitch=without_roller,
)
