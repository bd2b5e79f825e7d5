"""Cylindrical cam, oscillating follower, developed at the mean radius R_m.

The arm of length l is square to the cam's axis at mid-swing and carries the roller on an arc, here laid on the
developed (tangent) plane. With ψ = y − h/2 and the upper sign for a ccw cam the curve is

    (R_m·θ ∓ l·(cos ψ − cos ψ_end), l·sin ψ)

so that, with σ = +1 for ccw and −1 for cw,

    tan β = (l·ψ' + σ·R_m·sin ψ)/(R_m·cos ψ),    N² = R_m² + 2σR_m·l·sin ψ·ψ' + l²ψ'²
    κ = (β' − σψ')/N = (R_m·l·(cos ψ·ψ'' − sin ψ·ψ'²) − σl²ψ'³)/N³

Known deviation: the true arc leaves the cylinder. At its ends it stands x = l(1 − cos ½h) off the plane's line
of contact, and lies x²/(2R_m) above the cylinder; wrapping it instead of laying it flat shifts a point by about
x³/(6R_m²) round the cylinder (for l = 100, h = 20°, R_m = 60 mm: x = 1.5 mm, 0.02 mm and 0.0002 mm).
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from camopt.mechanisms.body import CYLINDER
from camopt.mechanisms.design import Designs, Mechanism, Misfit, without_roller
from camopt.mechanisms.drive import GROOVED
from camopt.mechanisms.follower import OSCILLATING, ROUND
from camopt.mechanisms.rest import ContactPoint, Off, Rest, angle_by_sine
from camopt.mechanisms.trace import course_over_cylinder, speed_change, trace_curvature
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray
from camopt.numerics.curves import formula, further_formula, quotient, turned_series
from camopt.numerics.trigonometry import turned


class ArmOverCylinder(NamedTuple):
    """Of each design: R_m and l, mm, the direction of the arm at the start, and the sense of rotation."""

    mean_radius: FloatArray
    arm_length: FloatArray
    cosine: FloatArray
    sine: FloatArray
    sense: FloatArray


class CylindricalOscillatingPressureAngle(ArmOverCylinder):
    """tan β."""


class CylindricalOscillatingPath(ArmOverCylinder):
    """The length of the pitch curve by the cam angle, N, mm/rad pressure angle."""


class CylindricalOscillatingPitchCurvature(ArmOverCylinder):
    """κ of the developed pitch curve, 1/mm."""


@formula(CylindricalOscillatingPressureAngle)
def pressure_angle(f, i, at):
    r, l = f.mean_radius[i], f.arm_length[i]  # noqa: E741
    cosine, sine = turned(f.cosine[i], f.sine[i], at.y)
    tangent = (l / r * at.y1 + f.sense[i] * sine) / cosine
    return tangent, (l / r * at.y2 + f.sense[i] * cosine * at.y1 + tangent * sine * at.y1) / cosine


@further_formula(CylindricalOscillatingPressureAngle)
def pressure_angle_further(f, i, at):
    cosine, (s, s1, s2, s3) = turned_series(f.cosine[i], f.sine[i], at)
    ratio, sense = f.arm_length[i] / f.mean_radius[i], f.sense[i]
    w = (
        ratio * at.y1 + sense * s,
        ratio * at.y2 + sense * s1,
        ratio * at.y3 + sense * s2,
        ratio * at.y4 + sense * s3,
    )
    return quotient(w, cosine)


@formula(CylindricalOscillatingPath)
def path(f, i, at):
    r, l = f.mean_radius[i], f.arm_length[i]  # noqa: E741
    cosine, sine = turned(f.cosine[i], f.sine[i], at.y)
    swing, swing1 = f.sense[i] * l * at.y1, f.sense[i] * l * at.y2
    along, along1 = r + swing * sine, swing1 * sine + swing * cosine * at.y1
    up, up1 = swing * cosine, swing1 * cosine - swing * sine * at.y1
    value = np.sqrt(np.square(along) + np.square(up))
    return value, (along * along1 + up * up1) / value


class CylindricalOscillatingSpeedChange(ArmOverCylinder):
    """The derivative of that length by the cam angle, mm/rad² pressure angle."""


@formula(CylindricalOscillatingPitchCurvature)
def pitch_curvature(f, i, at):
    w, w1, w2, s, s1, s2 = course_over_cylinder(f, i, at)
    return trace_curvature(w, w1, w2, s, s1, s2, -f.sense[i] * at.y1, -f.sense[i] * at.y2)


@formula(CylindricalOscillatingSpeedChange)
def speed_changes(f, i, at):
    w, w1, w2, s, s1, s2 = course_over_cylinder(f, i, at)
    return speed_change(w, w1, w2, s, s1, s2)


def _fields(designs: Designs, programme: Programme) -> tuple[FloatArray, ...]:
    ones, start = np.ones(len(designs)), -programme.lift / 2
    return designs.size, designs.arm_length, ones * np.cos(start), ones * np.sin(start), ones * designs.sense


def _assembly_margins(designs: Designs, programme: Programme) -> tuple[Any, ...]:
    return designs.size, np.pi - programme.lift


def _contact(design: Designs, lift: float, angle: Any, y: Any, y1: Any) -> ContactPoint:
    half, l, sense = lift / 2, design.arm_length, design.sense  # noqa: E741
    cosine, sine = np.cos(y - half), np.sin(y - half)
    x = angle * design.size - (cosine - np.cos(half)) * (sense * l)
    return ContactPoint(x, sine * l, -y1 * cosine * l, y1 * sine * (sense * l) + design.size)


def _rest(design: Designs, lift: float, y: Any, y1: Any, off: Off) -> Rest:
    """The arm turns until its end is as high as the point, and the surface moves until both meet."""
    psi, l, longer, sense = y - lift / 2, design.arm_length, off.of("arm_length"), design.sense  # noqa: E741
    across, up = off.shift(_contact(design, lift, y * 0.0, y, y1))
    cosine, sine = np.cos(psi), np.sin(psi)
    moved = angle_by_sine(sine, cosine, (up - sine * longer) / (longer + l))
    fall = np.sin(psi + moved * 0.5) * np.sin(moved * 0.5) * 2.0
    return Rest(moved, (((cosine - fall) * longer - fall * l) * sense + across) / design.size)


def _misfit(sizes: Mapping[str, float]) -> Misfit | None:
    lift = sizes["lift"]
    if lift < 180.0:
        return None
    return "motion.lift", None, f"the arm swings {lift:g} deg; a swing stays below 180"


MECHANISM = Mechanism(
    body=CYLINDER,
    drive=GROOVED,
    motion=OSCILLATING,
    tips=ROUND,
    sizes=("roller_radius", "arm_length"),
    name="cylindrical cam, oscillating follower",
    pressure=lambda designs, programme: CylindricalOscillatingPressureAngle(*_fields(designs, programme)),
    curvature=lambda designs, programme: CylindricalOscillatingPitchCurvature(*_fields(designs, programme)),
    path=lambda designs, programme: CylindricalOscillatingPath(*_fields(designs, programme)),
    speeding=lambda designs, programme: CylindricalOscillatingSpeedChange(*_fields(designs, programme)),
    assembly_margins=_assembly_margins,
    assembly="the mean radius has to be above 0, and the swing below 180 deg",
    contact=_contact,
    rest=_rest,
    pitch=without_roller,
    misfit=_misfit,
)
