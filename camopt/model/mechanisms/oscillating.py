"""Disc cam, oscillating follower with a trace point at the end of its arm.

The pivot is at the distance c to the right of the cam centre; the arm has the length l and lies above that line.
The angle at the pivot between the line and the arm is ψ = ψ₀ + y, with cos ψ₀ = (c² + l² − R_p²)/(2cl). Let
q = 1 + p, where p = ψ' for a ccw cam and −ψ' for a cw one:

    tan β = (l·q − c·cos ψ)/(c·sin ψ),    N² = l²q² + c² − 2clq·cos ψ
    κ_pitch = (q ∓ β') / N = (l²q³ + c² − cl·(q(1+q)·cos ψ + ψ''·sin ψ)) / N³   (− for a ccw cam)

Source: Norton, Cam Design and Manufacturing Handbook, ch. 7.
"""

from collections.abc import Mapping
from math import degrees
from typing import Any

import numpy as np

from camopt.core.numerics import FloatArray, Number
from camopt.core.numerics.curves import (
    cosine_and_sine_derivatives_of_sum,
    curve_type_from_formula,
    derivative_formula,
    quotient_derivatives,
)
from camopt.core.numerics.stable_functions import triangle_angle
from camopt.core.numerics.state import State
from camopt.core.numerics.taylor import cosine_and_sine_series
from camopt.core.numerics.trigonometry import cosine_and_sine_of_sum
from camopt.model.mechanisms.contact_errors import (
    ContactErrors,
    ContactPoint,
    ContactShift,
    angle_increase_from_sine,
    cam_angle_until_points_meet,
)
from camopt.model.mechanisms.design import Designs, Mechanism, SizeFault
from camopt.model.mechanisms.elements import DISC, OSCILLATING, ROUND_TIPS, SPRUNG
from camopt.model.mechanisms.trace import disc_arm_velocity_components, tangential_acceleration, trace_curvature
from camopt.model.motion.profile_contact import OscillatingPoint
from camopt.model.motion.programme import Programme


@curve_type_from_formula
def oscillating_pressure_tangent(
    state: State, centre_distance: Number, arm_length: Number, cosine: Number, sine: Number, sense: Number
) -> Number:
    """tan β; ``cosine`` and ``sine`` are cos ψ₀ and sin ψ₀."""
    cosine, sine = cosine_and_sine_of_sum(cosine, sine, state.y)
    return (arm_length * (1.0 + sense * state.y1) - centre_distance * cosine) / (centre_distance * sine)


@derivative_formula(oscillating_pressure_tangent)
def oscillating_pressure_derivatives(curve, design, state):
    (c, c1, c2, c3), (s, s1, s2, s3) = cosine_and_sine_derivatives_of_sum(
        curve.cosine[design], curve.sine[design], state
    )
    ratio = curve.arm_length[design] / curve.centre_distance[design]
    swung = ratio * curve.sense[design]
    w = (ratio + swung * state.y1 - c, swung * state.y2 - c1, swung * state.y3 - c2, swung * state.y4 - c3)
    return quotient_derivatives(w, (s, s1, s2, s3))


@curve_type_from_formula
def oscillating_trace_speed(
    state: State, centre_distance: Number, arm_length: Number, cosine: Number, sine: Number, sense: Number
) -> Number:
    """N [mm/rad]."""
    cosine, sine = cosine_and_sine_of_sum(cosine, sine, state.y)
    w = arm_length * (1.0 + sense * state.y1) - centre_distance * cosine
    return np.sqrt(np.square(w) + np.square(centre_distance * sine))


@curve_type_from_formula
def oscillating_curvature(
    state: State, centre_distance: Number, arm_length: Number, cosine: Number, sine: Number, sense: Number
) -> Number:
    """κ of the pitch curve [1/mm]."""
    w, w1, s, s1 = disc_arm_velocity_components(state, centre_distance, arm_length, cosine, sine, sense)
    return trace_curvature(w, w1, s, s1, 1.0 + sense * state.y1)


@curve_type_from_formula
def oscillating_tangential_acceleration(
    state: State, centre_distance: Number, arm_length: Number, cosine: Number, sine: Number, sense: Number
) -> Number:
    """N' [mm/rad²]."""
    w, w1, s, s1 = disc_arm_velocity_components(state, centre_distance, arm_length, cosine, sine, sense)
    return tangential_acceleration(w, w1, s, s1)


@curve_type_from_formula
def oscillating_outline_distance(
    state: State, centre_distance: Number, arm_length: Number, cosine: Number, sine: Number, roller_radius: Number
) -> Number:
    """Distance of the trace point from the cam's axis, minus R_r [mm]."""
    cosine, sine = cosine_and_sine_of_sum(cosine, sine, state.y)
    across = np.square(arm_length - centre_distance * cosine)
    return np.sqrt(across + np.square(centre_distance * sine)) - roller_radius


def _oscillating_curve_fields(designs: Designs) -> tuple[FloatArray, ...]:
    start = designs.start_arm_angle
    sense = np.full(len(designs), designs.sense)
    return designs.centre_distance, designs.arm_length, np.cos(start), np.sin(start), sense


def _oscillating_assembly_margins(designs: Designs, programme: Programme) -> tuple[Any, ...]:
    c, l, r = designs.centre_distance, designs.arm_length, designs.prime_radius  # noqa: E741
    return r - (c - l), r - (l - c), c + l - r, np.pi - programme.lift - designs.start_arm_angle


def trace_point_at_arm_angle(designs: Designs, angle: Any) -> tuple[Any, Any]:
    """(x, y) of the trace point in the ground frame, at an angle of the arm [mm]."""
    l = designs.arm_length  # noqa: E741
    return designs.centre_distance - l * np.cos(angle), l * np.sin(angle)


def _contact_point_at_trace_point(design: Designs, x: Any, height: Any, y1: Any) -> ContactPoint:
    """The contact; its normal is p − σ·y'·(c − p), with the trace point p and the pivot c."""
    turn = y1 * design.sense
    return ContactPoint(x, height, x - turn * (design.centre_distance - x), height + turn * height)


def _oscillating_shifted_contact(
    design: Designs, lift: float, y: Any, y1: Any, errors: ContactErrors
) -> ContactShift:
    """From the law of cosines for the triangle with errors in its sides: cos ψ falls by ``fall``."""
    angle = y + design.start_arm_angle
    cosine, sine = cosine_and_sine_series(angle)
    c, l, dc, dl = (  # noqa: E741
        design.centre_distance,
        design.arm_length,
        errors.size_error("centre_distance"),
        errors.size_error("arm_length"),
    )
    point = _contact_point_at_trace_point(design, c - l * cosine, l * sine, y1)
    across, up = errors.trace_point_shift_by_cam_errors(point)
    square = across * (point.x * 2.0 + across) + up * (point.y * 2.0 + up)
    square = square - dc * (2.0 * c + dc) - dl * (2.0 * l + dl)
    fall = (square + (c * dl + l * dc + dc * dl) * 2.0 * cosine) / ((c + dc) * (l + dl) * 2.0)
    moved = -angle_increase_from_sine(cosine, sine, -fall)
    rise = np.cos(angle + moved * 0.5) * np.sin(moved * 0.5) * 2.0
    tip = dc - (cosine - fall) * dl + fall * l, (sine + rise) * dl + rise * l
    return ContactShift(moved, cam_angle_until_points_meet(design.sense, point, (across, up), tip))


def _oscillating_size_fault(sizes: Mapping[str, float]) -> SizeFault | None:
    arm, centre, prime = sizes["arm_length"], sizes["centre_distance"], sizes["size"] + sizes["roller_radius"]
    lift = sizes["lift"]
    if not abs(centre - arm) < prime < centre + arm:
        between = f"{abs(centre - arm):g} and {centre + arm:g}"
        return "follower.arm_length", arm, f"no triangle: the prime radius ({prime:g}) must lie between {between}"
    start = degrees(triangle_angle(centre, arm, sizes["size"], sizes["roller_radius"]))
    if start + lift < 180.0:
        return None
    return "motion.lift", None, f"the arm starts at {start:g} deg and rises by {lift:g}: it must stay below 180 deg"


MECHANISM = Mechanism(
    body=DISC,
    drive=SPRUNG,
    motion=OSCILLATING,
    tips=ROUND_TIPS,
    sizes=("centre_distance", "arm_length", "roller_radius"),
    name="disc cam, oscillating follower with a trace point",
    pressure=lambda designs, programme: oscillating_pressure_tangent(*_oscillating_curve_fields(designs)),
    sliding=lambda designs, programme: oscillating_trace_speed(*_oscillating_curve_fields(designs)),
    speeding=lambda designs, programme: oscillating_tangential_acceleration(*_oscillating_curve_fields(designs)),
    curvature=lambda designs, programme: oscillating_curvature(*_oscillating_curve_fields(designs)),
    outline=lambda designs, programme, beyond: oscillating_outline_distance(
        *_oscillating_curve_fields(designs)[:4], -beyond
    ),
    start=lambda designs: designs.start_arm_angle,
    trace_point=trace_point_at_arm_angle,
    assembly_margins=_oscillating_assembly_margins,
    assembly="prime radius, arm and centre distance have to form a triangle at every displacement",
    contact=lambda design, lift, angle, y, y1: _contact_point_at_trace_point(
        design, *trace_point_at_arm_angle(design, y + design.start_arm_angle), y1
    ),
    shifted_contact=_oscillating_shifted_contact,
    pitch=lambda designs: designs.knife_edge_designs,
    misfit=_oscillating_size_fault,
    on_profile=lambda sizes, sense: OscillatingPoint(
        sizes["roller_radius"], sizes["centre_distance"], sizes["arm_length"], sense
    ),
)
