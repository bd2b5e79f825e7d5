"""Cams with a rib between two rollers of one follower.

The rollers have the same radius. Their centres have the distance d (``roller_spacing``), on a line along the motion
(oscillating: on arms of the length l, with the angle δ between them). Each roller has its own pitch curve and
touches one flank of the rib. The pitch curve is that of an ordinary roller with the motion

    cylinder:  y ± d/2,        (oscillating) ψ ± δ/2
    disc:      y and y − d,    (oscillating) ψ and ψ − δ,        sin(δ/2) = d/(2l)

So both rollers touch at every cam angle, and the rib is thinner where the motion is steeper. On a rib of constant
thickness the rollers would have clearance wherever the slope changes.

The first roller pushes the follower outward: on a cylinder it is the upper roller, on a disc the outer one, whose
flank is that of an open cam. The second roller is on the other side of the rib, from where the rib pulls the
follower back. On a disc it is the roller of a second ordinary cam, nearer to the axis:

    s₀₂ = s₀ − d,    ψ₀₂ = ψ₀ − δ

Its flank lies beyond its trace point. κ > 0 where the pitch curve of a contact is convex, seen from its roller.

Let α₁ and α₂ be the angles between the line through both rollers and the normals of their pitch curves. With the
pressure angles β₁ and β₂ and the sense of rotation σ (1 for a disc), the thickness of the rib is

    t = d·cos(½(α₁ + α₂))/cos(½(α₂ − α₁)) − 2·R_r,    α₁ = β₁ − σ·½δ,  α₂ = β₂ + σ·½δ    (translating: δ = 0)

This is the distance of two arcs about one centre with these normals, or of two parallel lines. On a cylinder with a
translating follower both rollers have the same β, and the rib is nowhere thinner than the least t: with
|tan β| ≤ tan β_max everywhere, two points of the pitch curves are at least d·cos β_max apart. Other ribs are
slightly thicker.

Sources: Rothbart, Cam Design Handbook, ch. 3 (ribbed barrel cams); Norton, Cam Design and Manufacturing Handbook,
ch. 1 (form-closed cams with a rib).
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from math import sin
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import Curve, FloatArray, Number
from camopt.core.numerics.curves import curve_formula, curve_or_number_value, curve_value
from camopt.core.numerics.stable_functions import difference_of_squares_root, triangle_angle
from camopt.core.numerics.state import State
from camopt.model.mechanisms import cylindrical, cylindrical_oscillating, oscillating, translating
from camopt.model.mechanisms.contact_errors import (
    ContactErrors,
    ContactPoint,
    ContactShift,
    angle_increase_from_sine,
)
from camopt.model.mechanisms.design import Designs, Mechanism, SizeFault
from camopt.model.mechanisms.elements import (
    FACE_WALLS,
    GROOVE_WALLS,
    RIBBED,
    RIBBED_CYLINDER,
    RIBBED_DISC,
    ROLLER,
    Body,
    Flank,
)
from camopt.model.mechanisms.pairs import CONTACT_CURVES, with_second_contact
from camopt.model.motion.programme import Programme


class ShiftedCurve(NamedTuple):
    """A factor times a curve of a shifted motion: it takes y + by in place of y."""

    curve: Curve
    by: FloatArray
    factor: FloatArray


@curve_formula(ShiftedCurve)
def shifted_motion_curve_value(curve, design, state):
    return curve_or_number_value(curve.factor, design, state) * curve_value(
        curve.curve, design, State(state.y + curve.by[design], state.y1, state.y2, state.y3, None, state.y4)
    )


def roller_spacing_as_displacement(mechanism: Mechanism, designs: Designs) -> Number:
    """Distance of the two rollers as a displacement of the follower: d [mm], or the angle δ of its arms [rad]."""
    spacing = designs.roller_spacing
    return 2.0 * np.arcsin(0.5 * spacing / designs.arm_length) if mechanism.motion.angular else spacing


def _displacement_error_of_roller_spacing(mechanism: Mechanism, designs: Designs, errors: ContactErrors) -> Number:
    """Error of ``roller_spacing_as_displacement`` that errors of the follower's sizes cause [mm or rad]."""
    wider = errors.size_error("roller_spacing")
    if not mechanism.motion.angular:
        return wider
    longer, arm = errors.size_error("arm_length"), designs.arm_length
    sine = designs.roller_spacing / (2.0 * arm)
    more = (wider * 0.5 - longer * sine) / (longer + arm)
    return angle_increase_from_sine(sine, np.sqrt((1.0 - sine) * (1.0 + sine)), more) * 2.0


def _advanced_roller_mechanism(
    mechanism: Mechanism, spacing_share: float, included_share: float = 0.0
) -> Mechanism:
    """The mechanism of a roller that is ahead of its follower by a share of ``roller_spacing_as_displacement``.

    ``included_share`` is the share that the sizes of designs include already.
    """

    def roller_shift(design: Designs) -> Number:
        return (spacing_share - included_share) * roller_spacing_as_displacement(mechanism, design)

    def contact(design: Designs, lift: float, angle: Any, y: Any, y1: Any) -> ContactPoint:
        return mechanism.contact(design, lift, angle, y + roller_shift(design), y1)

    def shifted_contact(design: Designs, lift: float, y: Any, y1: Any, errors: ContactErrors) -> ContactShift:
        shift = mechanism.shifted_contact(design, lift, y + roller_shift(design), y1, errors)
        return shift._replace(
            moved=shift.moved - _displacement_error_of_roller_spacing(mechanism, design, errors) * spacing_share
        )

    return mechanism._replace(contact=contact, shifted_contact=shifted_contact)


def _inner_roller_start_position(mechanism: Mechanism, designs: Designs) -> Number:
    """Height [mm] or angle [rad] of a disc's inner roller at displacement 0."""
    assert mechanism.start is not None
    return mechanism.start(designs) - roller_spacing_as_displacement(mechanism, designs)


def translating_inner_cam_designs(designs: Designs) -> Designs:
    """The open disc cam whose roller is the inner roller of a translating follower."""
    height = _inner_roller_start_position(translating.MECHANISM, designs)
    prime_radius = np.sqrt(np.square(height) + np.square(designs.offset))
    return replace(designs, size=prime_radius - designs.roller_radius)


def oscillating_inner_cam_designs(designs: Designs) -> Designs:
    """The open disc cam whose roller is the inner roller of an oscillating follower."""
    c, l = designs.centre_distance, designs.arm_length  # noqa: E741
    half = np.sin(0.5 * _inner_roller_start_position(oscillating.MECHANISM, designs))
    prime_radius = np.sqrt(np.square(c - l) + 4.0 * (c * l) * np.square(half))
    return replace(designs, size=prime_radius - designs.roller_radius)


def _shifted_curve(
    make_curve: Any, motion_shift: Callable[[Designs], Any], factor: float, designs: Designs, programme: Programme
) -> ShiftedCurve:
    """A curve of the motion itself, times a factor, from the maker of one for the shifted motion."""
    zero = designs.size * 0.0
    return ShiftedCurve(make_curve(designs, programme), motion_shift(designs) + zero, zero + factor)


def _mechanism_of_one_roller_at_rib(mechanism: Mechanism, body: Body, wall: Flank) -> Mechanism:
    """The mechanism of one roller at a rib; ``wall`` is the wall of a groove in place of the flank.

    The sign of the curvature is that seen from the roller.
    """
    curvature = (
        mechanism.curvature
        if wall.bulge > 0.0
        else partial(_shifted_curve, mechanism.curvature, lambda designs: 0.0, wall.bulge)
    )
    flanks = (Flank("", wall.side, 1.0),)
    return mechanism._replace(
        body=body,
        drive=RIBBED._replace(flanks=flanks),
        tips=(ROLLER,),
        sizes=(*mechanism.sizes, "roller_spacing"),
        name=f"{body.words}, {mechanism.motion.name} follower with two rollers",
        curvature=curvature,
        way=wall.pressing,
    )


def _rib_size_fault(mechanism: Mechanism, sizes: Mapping[str, float]) -> SizeFault | None:
    """Why a design has no space for a rib between its rollers, or no arms; None if it has both."""
    if fault := mechanism.misfit(sizes):
        return fault
    spacing, key = sizes["roller_spacing"], "follower.roller_spacing"
    if spacing <= (diameter := 2.0 * sizes["roller_radius"]):
        return key, spacing, f"must be above the diameter of the rollers ({diameter:g}), with a rib between them"
    if mechanism.motion.angular and spacing >= (most := 2.0 * sizes["arm_length"]):
        return key, spacing, f"must be below twice the arm length ({most:g})"
    return None


def _rib_assembly_margins(mechanism: Mechanism, designs: Designs) -> tuple[Any, ...]:
    """Numbers that are positive if there is space for a rib between the rollers, and for arms."""
    arms = (2.0 * designs.arm_length - designs.roller_spacing,) if mechanism.motion.angular else ()
    return designs.roller_spacing - 2.0 * designs.roller_radius, *arms


ROLLERS_STAND_APART = "the rollers have to stand apart by more than their diameter"


def _cylinder_rib_mechanism(mechanism: Mechanism) -> Mechanism:
    """The mechanism of a rib on a cylinder, from that of a groove."""

    def roller_mechanism_beyond_wall(wall: Flank) -> Mechanism:
        """The mechanism of the roller that is beyond a wall of the groove."""

        def wall_shift(designs: Designs) -> Number:
            return -0.5 * wall.side * roller_spacing_as_displacement(mechanism, designs)

        shifted_curves: dict[str, Any] = {
            name: partial(_shifted_curve, make, wall_shift, 1.0)
            for name in CONTACT_CURVES
            if mechanism.motion.angular and (make := getattr(mechanism, name))  # others do not depend on y
        }
        placed = _advanced_roller_mechanism(mechanism, -0.5 * wall.side)._replace(**shifted_curves)
        return _mechanism_of_one_roller_at_rib(placed, RIBBED_CYLINDER, wall)

    def assembly_margins(designs: Designs, programme: Programme) -> tuple[Any, ...]:
        return *mechanism.assembly_margins(designs, programme), *_rib_assembly_margins(mechanism, designs)

    below, above = GROOVE_WALLS
    return with_second_contact(
        roller_mechanism_beyond_wall(below)._replace(
            assembly_margins=assembly_margins,
            assembly=f"{mechanism.assembly}, and {ROLLERS_STAND_APART}",
            misfit=lambda sizes: _rib_size_fault(mechanism, sizes),
        ),
        roller_mechanism_beyond_wall(above),
        lambda designs: designs,  # both contacts of a cylinder have the same sizes
    )


def _disc_rib_mechanism(mechanism: Mechanism, inner_cam_designs: Callable[[Designs], Designs]) -> Mechanism:
    """The mechanism of a rib on the face of a disc, from that of an open disc cam."""

    def assembly_margins(designs: Designs, programme: Programme) -> tuple[Any, ...]:
        return (
            *mechanism.assembly_margins(designs, programme),
            *_rib_assembly_margins(mechanism, designs),
            _inner_roller_start_position(mechanism, designs),
            inner_cam_designs(designs).size,
        )

    def size_fault(sizes: Mapping[str, float]) -> SizeFault | None:
        if fault := _rib_size_fault(mechanism, sizes):
            return fault
        spacing, most = sizes["roller_spacing"], _roller_spacing_reaching_axis(mechanism.motion.angular, sizes)
        if spacing < most:
            return None
        why = f"must be below {most:g}: the inner roller would reach the axis of the cam"
        return "follower.roller_spacing", spacing, why

    inner, outer = FACE_WALLS
    return with_second_contact(
        _mechanism_of_one_roller_at_rib(_advanced_roller_mechanism(mechanism, 0.0), RIBBED_DISC, inner)._replace(
            assembly_margins=assembly_margins,
            assembly=f"{mechanism.assembly}, {ROLLERS_STAND_APART}, and the inner one has to stay off the axis",
            misfit=size_fault,
        ),
        _mechanism_of_one_roller_at_rib(
            _advanced_roller_mechanism(mechanism, -1.0, included_share=-1.0), RIBBED_DISC, outer
        ),
        inner_cam_designs,
    )


def _roller_spacing_reaching_axis(angular: bool, sizes: Mapping[str, float]) -> Number:
    """Distance of the rollers at which the inner one reaches the axis of the cam [mm]."""
    prime, radius = sizes["size"] + sizes["roller_radius"], sizes["roller_radius"]
    if not angular:
        offset = sizes["offset"]
        return difference_of_squares_root(prime, offset) - difference_of_squares_root(radius, offset)
    c, l = sizes["centre_distance"], sizes["arm_length"]  # noqa: E741
    start, least = (triangle_angle(c, l, r) for r in (prime, radius))
    return 2.0 * l * sin(0.5 * (start - least))


RIB_MECHANISMS = (
    _cylinder_rib_mechanism(cylindrical.MECHANISM),
    _cylinder_rib_mechanism(cylindrical_oscillating.MECHANISM),
    _disc_rib_mechanism(translating.MECHANISM, translating_inner_cam_designs),
    _disc_rib_mechanism(oscillating.MECHANISM, oscillating_inner_cam_designs),
)
