"""Disc cam, oscillating flat-faced follower.

The face is a line at the distance f from the pivot. The angle ψ at the pivot is between the line to the cam centre
and the face; R_b = f + c·sin ψ₀. Let q = 1 + p, where p = ψ' for a ccw cam and −ψ' for a cw one. With q > 0:

    contact at t = c·cos ψ / q along the face,    tan β = f / t
    ρ = f + c·(sin ψ·(2q − 1)/q² + cos ψ·ψ''/q³),    sliding at q·f + c·sin ψ per rad
"""

from collections.abc import Mapping
from math import asin, degrees
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
from camopt.model.mechanisms.design import Designs, Mechanism, SizeFault, with_face_through_pivot
from camopt.model.mechanisms.elements import DISC, FLAT, OSCILLATING, SPRUNG
from camopt.model.motion.profile_contact import OscillatingFace
from camopt.model.motion.programme import Programme


@curve_type_from_formula
def swinging_face_sliding_speed(
    state: State, face_offset: Number, centre_distance: Number, cosine: Number, sine: Number, sense: Number
) -> Number:
    """Sliding speed [mm/rad]; ``cosine`` and ``sine`` are cos ψ₀ and sin ψ₀."""
    _, sine = cosine_and_sine_of_sum(cosine, sine, state.y)
    return (1.0 + sense * state.y1) * face_offset + centre_distance * sine


@curve_type_from_formula
def swinging_face_pressure_tangent(
    state: State, face_offset: Number, centre_distance: Number, cosine: Number, sine: Number, sense: Number
) -> Number:
    """tan β."""
    cosine, _ = cosine_and_sine_of_sum(cosine, sine, state.y)
    return face_offset / (centre_distance * cosine) * (1.0 + sense * state.y1)


@curve_type_from_formula
def swinging_face_profile_radius(
    state: State, face_offset: Number, centre_distance: Number, cosine: Number, sine: Number, sense: Number
) -> Number:
    """Radius of curvature of the profile, ρ [mm]."""
    cosine, sine = cosine_and_sine_of_sum(cosine, sine, state.y)
    q = 1.0 + sense * state.y1
    return face_offset + centre_distance * (sine * ((2.0 * q - 1.0) / (q * q)) + cosine * (state.y2 / (q * q * q)))


@curve_type_from_formula
def swinging_face_reach(
    state: State, face_offset: Number, centre_distance: Number, cosine: Number, sine: Number, sense: Number
) -> Number:
    """Distance of the contact from the pivot along the face, t [mm]."""
    cosine, _ = cosine_and_sine_of_sum(cosine, sine, state.y)
    return centre_distance * cosine / (1.0 + sense * state.y1)


@derivative_formula(swinging_face_reach)
def swinging_face_reach_derivatives(curve, design, state):
    c, sense = curve.centre_distance[design], curve.sense[design]
    (cosine, cosine1, cosine2, cosine3), _ = cosine_and_sine_derivatives_of_sum(
        curve.cosine[design], curve.sine[design], state
    )
    turning = (1.0 + sense * state.y1, sense * state.y2, sense * state.y3, sense * state.y4)
    return quotient_derivatives((c * cosine, c * cosine1, c * cosine2, c * cosine3), turning)


@curve_type_from_formula
def swinging_face_outline_distance(
    state: State, face_offset: Number, centre_distance: Number, cosine: Number, sine: Number
) -> Number:
    """Distance of the face from the cam's axis [mm]."""
    _, sine = cosine_and_sine_of_sum(cosine, sine, state.y)
    return face_offset + centre_distance * sine


def sine_of_start_face_angle(designs: Designs) -> FloatArray:
    """sin ψ₀."""
    return (designs.size - designs.face_offset) / designs.centre_distance


def _swinging_face_curve_fields(designs: Designs) -> tuple[FloatArray, ...]:
    sine = np.minimum(np.maximum(sine_of_start_face_angle(designs), -1.0), 1.0)
    cosine = np.sqrt((1.0 - sine) * (1.0 + sine))
    return designs.face_offset, designs.centre_distance, cosine, sine, np.full(len(designs), designs.sense)


def _swinging_face_assembly_margins(designs: Designs, programme: Programme) -> tuple[Any, ...]:
    sine = sine_of_start_face_angle(designs)
    first = np.arcsin(np.minimum(np.maximum(sine, -1.0), 1.0))
    return (
        1.0 + sine,
        1.0 - sine,
        np.pi / 2 - programme.lift - first,
        least_relative_turning_rate(designs.sense, programme),
    )


def least_relative_turning_rate(sense: float, programme: Programme) -> float:
    """Least value of q = 1 ± ψ' over the turn; above 0, the face turns slower than the cam."""
    return 1.0 + programme.least_speed(sense)


def _swinging_face_contact(design: Designs, lift: float, angle: Any, y: Any, y1: Any) -> ContactPoint:
    psi = y + np.arcsin(sine_of_start_face_angle(design))
    cosine, sine = np.cos(psi), np.sin(psi)
    c, f = design.centre_distance, design.face_offset
    t = cosine * c / (y1 * design.sense + 1.0)
    return ContactPoint(sine * f - t * cosine + c, cosine * f + t * sine, sine, cosine)


def _swinging_face_shifted_contact(
    design: Designs, lift: float, y: Any, y1: Any, errors: ContactErrors
) -> ContactShift:
    """The distance of the face from the axis, f + c·sin ψ, grows by δn; the cam turns back with the face."""
    point, wider = _swinging_face_contact(design, lift, 0.0, y, y1), errors.size_error("centre_distance")
    more = errors.flat_face_profile_error(point) - errors.size_error("face_offset") - point.across * wider
    moved = angle_increase_from_sine(point.across, point.up, more / (design.centre_distance + wider))
    return ContactShift(moved, -(moved * design.sense))


def _swinging_face_size_fault(sizes: Mapping[str, float]) -> SizeFault | None:
    base, face, centre, lift = (sizes[name] for name in ("size", "face_offset", "centre_distance", "lift"))
    if not abs(base - face) < centre:
        why = f"must be above the difference between base radius and face offset ({abs(base - face):g})"
        return "follower.centre_distance", centre, why
    start = degrees(asin((base - face) / centre))
    if start + lift < 90.0:
        return None
    return "motion.lift", None, f"the face starts at {start:g} deg and rises by {lift:g}: it must stay below 90 deg"


MECHANISM = Mechanism(
    body=DISC,
    drive=SPRUNG,
    motion=OSCILLATING,
    tips=(FLAT,),
    sizes=("centre_distance", "face_offset"),
    name="disc cam, oscillating flat-faced follower",
    pressure=lambda designs, programme: swinging_face_pressure_tangent(*_swinging_face_curve_fields(designs)),
    profile_radius=lambda designs, programme: swinging_face_profile_radius(*_swinging_face_curve_fields(designs)),
    sliding=lambda designs, programme: swinging_face_sliding_speed(*_swinging_face_curve_fields(designs)),
    reach=lambda designs, programme: swinging_face_reach(*_swinging_face_curve_fields(designs)),
    outline=lambda designs, programme, beyond: swinging_face_outline_distance(
        *_swinging_face_curve_fields(designs)[:4]
    ),
    assembly_margins=_swinging_face_assembly_margins,
    assembly="the face has to touch the base circle, and to swing slower than the cam turns",
    contact=_swinging_face_contact,
    shifted_contact=_swinging_face_shifted_contact,
    misfit=_swinging_face_size_fault,
    profile=with_face_through_pivot,
    parallel="face_offset",
    on_profile=lambda sizes, sense: OscillatingFace(sizes["centre_distance"], sizes["face_offset"], sense),
)
