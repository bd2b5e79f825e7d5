"""Cylindrical cam, oscillating follower, developed at the mean radius R_m.

The arm of length l is square to the cam's axis at mid-swing. It carries the roller on an arc, which is laid on the
developed (tangent) plane. With ψ = y − h/2 and the upper sign for a ccw cam the pitch curve is

    (R_m·θ ∓ l·(cos ψ − cos ψ_end), l·sin ψ)

With σ = +1 for ccw and −1 for cw,

    tan β = (l·ψ' + σ·R_m·sin ψ)/(R_m·cos ψ),    N² = R_m² + 2σR_m·l·sin ψ·ψ' + l²ψ'²
    κ = (β' − σψ')/N = (R_m·l·(cos ψ·ψ'' − sin ψ·ψ'²) − σl²ψ'³)/N³

Approximation: the true arc leaves the cylinder. At its ends it is x = l(1 − cos ½h) from the plane's line of
contact and x²/(2R_m) above the cylinder. Wrapping the arc round the cylinder, instead of laying it flat, would
shift a point by about x³/(6R_m²). For l = 100, h = 20° and R_m = 60 mm these are 1.5 mm, 0.02 mm and 0.0002 mm.
"""

from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray, Number
from camopt.core.numerics.curves import (
    cosine_and_sine_derivatives_of_sum,
    curve_type_from_formula,
    derivative_formula,
    quotient_derivatives,
)
from camopt.core.numerics.state import State
from camopt.core.numerics.trigonometry import cosine_and_sine_of_sum
from camopt.model.mechanisms.contact_errors import (
    ContactErrors,
    ContactPoint,
    ContactShift,
    angle_increase_from_sine,
)
from camopt.model.mechanisms.design import Designs, Mechanism, with_zero_roller_radius
from camopt.model.mechanisms.elements import CYLINDER, GROOVED, OSCILLATING, ROUND_TIPS
from camopt.model.mechanisms.trace import cylinder_arm_velocity_components, tangential_acceleration, trace_curvature
from camopt.model.motion.programme import Programme


@curve_type_from_formula
def swinging_pressure_tangent(
    state: State, mean_radius: Number, arm_length: Number, cosine: Number, sine: Number, sense: Number
) -> Number:
    """tan β; ``cosine`` and ``sine`` belong to the arm's angle at displacement 0."""
    cosine, sine = cosine_and_sine_of_sum(cosine, sine, state.y)
    return (arm_length / mean_radius * state.y1 + sense * sine) / cosine


@derivative_formula(swinging_pressure_tangent)
def swinging_pressure_derivatives(curve, design, state):
    cosine, (s, s1, s2, s3) = cosine_and_sine_derivatives_of_sum(curve.cosine[design], curve.sine[design], state)
    ratio, sense = curve.arm_length[design] / curve.mean_radius[design], curve.sense[design]
    w = (
        ratio * state.y1 + sense * s,
        ratio * state.y2 + sense * s1,
        ratio * state.y3 + sense * s2,
        ratio * state.y4 + sense * s3,
    )
    return quotient_derivatives(w, cosine)


@curve_type_from_formula
def swinging_path_speed(
    state: State, mean_radius: Number, arm_length: Number, cosine: Number, sine: Number, sense: Number
) -> Number:
    """Length of the pitch curve per cam angle, N [mm/rad]."""
    cosine, sine = cosine_and_sine_of_sum(cosine, sine, state.y)
    swing = sense * arm_length * state.y1
    return np.sqrt(np.square(mean_radius + swing * sine) + np.square(swing * cosine))


@curve_type_from_formula
def swinging_curvature(
    state: State, mean_radius: Number, arm_length: Number, cosine: Number, sine: Number, sense: Number
) -> Number:
    """κ of the developed pitch curve [1/mm]."""
    w, w1, s, s1 = cylinder_arm_velocity_components(state, mean_radius, arm_length, cosine, sine, sense)
    return trace_curvature(w, w1, s, s1, -sense * state.y1)


@curve_type_from_formula
def swinging_tangential_acceleration(
    state: State, mean_radius: Number, arm_length: Number, cosine: Number, sine: Number, sense: Number
) -> Number:
    """Derivative of ``swinging_path_speed`` by the cam angle, N' [mm/rad²]."""
    w, w1, s, s1 = cylinder_arm_velocity_components(state, mean_radius, arm_length, cosine, sine, sense)
    return tangential_acceleration(w, w1, s, s1)


def _swinging_curve_fields(designs: Designs, programme: Programme) -> tuple[FloatArray, ...]:
    ones, start = np.ones(len(designs)), -programme.lift / 2
    return designs.size, designs.arm_length, ones * np.cos(start), ones * np.sin(start), ones * designs.sense


def _swinging_contact(design: Designs, lift: float, angle: Any, y: Any, y1: Any) -> ContactPoint:
    half, l, sense = lift / 2, design.arm_length, design.sense  # noqa: E741
    cosine, sine = np.cos(y - half), np.sin(y - half)
    x = angle * design.size - (cosine - np.cos(half)) * (sense * l)
    return ContactPoint(x, sine * l, -y1 * cosine * l, y1 * sine * (sense * l) + design.size)


def _swinging_shifted_contact(design: Designs, lift: float, y: Any, y1: Any, errors: ContactErrors) -> ContactShift:
    """The arm turns until its end is at the height of the shifted point; then the cam turns until both meet."""
    psi, l, longer, sense = y - lift / 2, design.arm_length, errors.size_error("arm_length"), design.sense  # noqa: E741
    across, up = errors.trace_point_shift_by_cam_errors(_swinging_contact(design, lift, y * 0.0, y, y1))
    cosine, sine = np.cos(psi), np.sin(psi)
    moved = angle_increase_from_sine(sine, cosine, (up - sine * longer) / (longer + l))
    fall = np.sin(psi + moved * 0.5) * np.sin(moved * 0.5) * 2.0
    return ContactShift(moved, (((cosine - fall) * longer - fall * l) * sense + across) / design.size)


MECHANISM = Mechanism(
    body=CYLINDER,
    drive=GROOVED,
    motion=OSCILLATING,
    tips=ROUND_TIPS,
    sizes=("roller_radius", "arm_length"),
    name="cylindrical cam, oscillating follower",
    pressure=lambda designs, programme: swinging_pressure_tangent(*_swinging_curve_fields(designs, programme)),
    curvature=lambda designs, programme: swinging_curvature(*_swinging_curve_fields(designs, programme)),
    path=lambda designs, programme: swinging_path_speed(*_swinging_curve_fields(designs, programme)),
    speeding=lambda designs, programme: swinging_tangential_acceleration(
        *_swinging_curve_fields(designs, programme)
    ),
    assembly_margins=lambda designs, programme: (designs.size, np.pi - programme.lift),
    assembly="the mean radius has to be above 0, and the swing below 180 deg",
    contact=_swinging_contact,
    shifted_contact=_swinging_shifted_contact,
    pitch=with_zero_roller_radius,
    misfit=lambda sizes: (
        None
        if sizes["lift"] < 180.0
        else ("motion.lift", None, f"the arm swings {sizes['lift']:g} deg; a swing stays below 180")
    ),
)
