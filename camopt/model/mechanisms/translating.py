"""Disc cam, translating follower with a trace point: knife edge, roller or spherical face.

The displacement of the follower is y; y' and y'' are its derivatives by the cam angle in rad. The trace point is
(offset, s) with s = s₀ + y and s₀ = √(R_p² − e²). The lead e is the offset if the cam turns ccw, and minus the
offset if it turns cw. With w = y' − e:

    tan β = w / s,    N² = s² + w²,    κ_pitch = (1 − β') / N = (N² + w·y' − s·y'') / N³   (> 0 convex)

Source: Norton, Cam Design and Manufacturing Handbook, ch. 7; regrouped.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from camopt.core.numerics import Number
from camopt.core.numerics.curves import curve_type_from_formula, derivative_formula, quotient_derivatives
from camopt.core.numerics.state import State
from camopt.model.mechanisms.contact_errors import (
    ContactErrors,
    ContactPoint,
    ContactShift,
    cam_angle_until_points_meet,
)
from camopt.model.mechanisms.design import Designs, Mechanism, SizeFault
from camopt.model.mechanisms.elements import DISC, ROUND_TIPS, SPRUNG, TRANSLATING
from camopt.model.mechanisms.trace import tangential_acceleration, trace_curvature
from camopt.model.motion.profile_contact import TranslatingPoint


@curve_type_from_formula
def translating_pressure_tangent(state: State, signed_offset: Number, start_height: Number) -> Number:
    """tan β; ``signed_offset`` is e, ``start_height`` is s₀ [mm]."""
    return (state.y1 - signed_offset) / (state.y + start_height)


@derivative_formula(translating_pressure_tangent)
def translating_pressure_derivatives(curve, design, state):
    return quotient_derivatives(
        (state.y1 - curve.signed_offset[design], state.y2, state.y3, state.y4),
        (curve.start_height[design] + state.y, state.y1, state.y2, state.y3),
    )


@curve_type_from_formula
def translating_trace_speed(state: State, signed_offset: Number, start_height: Number) -> Number:
    """Speed of the trace point over the cam, N [mm/rad]."""
    return np.sqrt(np.square(state.y + start_height) + np.square(state.y1 - signed_offset))


@curve_type_from_formula
def translating_tangential_acceleration(state: State, signed_offset: Number, start_height: Number) -> Number:
    """Derivative of that speed by the cam angle, N' [mm/rad²]."""
    return tangential_acceleration(state.y1 - signed_offset, state.y2, state.y + start_height, state.y1)


@curve_type_from_formula
def translating_curvature(state: State, signed_offset: Number, start_height: Number) -> Number:
    """κ of the pitch curve [1/mm]."""
    return trace_curvature(state.y1 - signed_offset, state.y2, state.y + start_height, state.y1, 1.0)


@curve_type_from_formula
def translating_outline_distance(
    state: State, signed_offset: Number, start_height: Number, roller_radius: Number
) -> Number:
    """Distance of the trace point from the cam's axis, minus R_r [mm]."""
    return np.sqrt(np.square(state.y + start_height) + np.square(signed_offset)) - roller_radius


def _translating_contact(design: Designs, lift: float, angle: Any, y: Any, y1: Any) -> ContactPoint:
    s = y + design.height
    return ContactPoint(s * 0.0 + design.offset, s, (design.signed_offset - y1) * design.sense, s)


def _translating_shifted_contact(
    design: Designs, lift: float, y: Any, y1: Any, errors: ContactErrors
) -> ContactShift:
    """The cam turns until its point is on the follower's line, x = e + δe; its distance from the axis stays."""
    point, wide = _translating_contact(design, lift, 0.0, y, y1), errors.size_error("offset")
    across, up = errors.trace_point_shift_by_cam_errors(point)
    more = (across - wide) * (point.x * 2.0 + across + wide) + up * (point.y * 2.0 + up)
    moved = more / (np.sqrt(np.square(point.y) + more) + point.y)
    return ContactShift(moved, cam_angle_until_points_meet(design.sense, point, (across, up), (wide, moved)))


def _translating_size_fault(sizes: Mapping[str, float]) -> SizeFault | None:
    prime, offset = sizes["size"] + sizes["roller_radius"], sizes["offset"]
    if abs(offset) < prime:
        return None
    return "follower.offset", offset, f"must be smaller than the prime radius ({prime:g})"


MECHANISM = Mechanism(
    body=DISC,
    drive=SPRUNG,
    motion=TRANSLATING,
    tips=ROUND_TIPS,
    sizes=("roller_radius", "offset"),
    name="disc cam, translating follower with a trace point",
    pressure=lambda designs, programme: translating_pressure_tangent(designs.signed_offset, designs.height),
    sliding=lambda designs, programme: translating_trace_speed(designs.signed_offset, designs.height),
    speeding=lambda designs, programme: translating_tangential_acceleration(designs.signed_offset, designs.height),
    curvature=lambda designs, programme: translating_curvature(designs.signed_offset, designs.height),
    outline=lambda designs, programme, beyond: translating_outline_distance(
        designs.signed_offset, designs.height, -beyond
    ),
    start=lambda designs: designs.height,
    trace_point=lambda designs, height: (designs.offset, height),
    assembly_margins=lambda designs, programme: (
        designs.prime_radius - designs.offset,
        designs.prime_radius + designs.offset,
    ),
    assembly="the offset has to be smaller than the prime radius",
    contact=_translating_contact,
    shifted_contact=_translating_shifted_contact,
    pitch=lambda designs: designs.knife_edge_designs,
    misfit=_translating_size_fault,
    on_profile=lambda sizes, sense: TranslatingPoint(sizes["roller_radius"], sense * sizes["offset"]),
)
