"""Cams with a rib, which two rollers of one follower have between them.

The rollers have the same radius, and their centres stand at the distance d, ``roller_spacing``: on a line along the
motion (oscillating: on arms of the length l, with the angle δ between them). Each cuts a flank of its own, on one
side of a pitch curve of its own, as walls of a groove are on both sides of one curve: that of an ordinary roller
with the motion

    cylinder:  y ± d/2,        (oscillating) ψ ± δ/2
    disc:      y and y − d,    (oscillating) ψ and ψ − δ,        sin(δ/2) = d/(2l)

So both touch at every cam angle, and the rib is thinner where the motion is steeper. Flanks that are parallels of
one curve, a rib of one thickness, would leave the rollers room wherever the slope changes.

The first roller is beyond the rib: of a cylinder the upper one, of a disc the outer one, whose flank is that of an
open cam. The second one is before the rib, on the side of its flank from which a force pulls the follower back. It
is that of an ordinary cam too, on a disc of one that stands closer to the axis,

    s₀₂ = s₀ − d,    ψ₀₂ = ψ₀ − δ

and touches its flank beyond its trace point. κ > 0 is where the pitch curve of a contact is convex, seen from its
roller.

With the angles α₁ and α₂ between the line through both rollers and the normals of their pitch curves, the rib is

    t = d·cos(½(α₁ + α₂))/cos(½(α₂ − α₁)) − 2·R_r,    α₁ = β₁ − σ·½δ,  α₂ = β₂ + σ·½δ    (translating: δ = 0)

thick, with the pressure angle β at each and the sense of rotation σ (1 of a disc): so far apart are arcs about one
centre that have these normals, and parallel lines. Over a cylinder, where a follower that translates has one β at
both, no rib is thinner than the least t: with |tan β| ≤ tan β_max everywhere, two points of the pitch curves are at
least d·cos β_max apart. Others are by a little thicker.

Sources: Rothbart, Cam Design Handbook, ch. 3 (ribbed barrel cams); Norton, Cam Design and Manufacturing Handbook,
ch. 1 (form-closed cams with a rib).
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import sin
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.curves import curve_formula, field_value, value_of
from camopt.core.numerics.stable_functions import difference_of_squares_root, triangle_angle
from camopt.core.numerics.state import State
from camopt.model.mechanisms import cylindrical, cylindrical_oscillating, oscillating, translating
from camopt.model.mechanisms.contact_errors import ContactErrors, ContactPoint, ContactShift, angle_growth
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
from camopt.model.mechanisms.pairs import with_second_contact
from camopt.model.motion.programme import Programme


class ShiftedCurve(NamedTuple):
    """A factor times a curve of a motion that is ahead: of y + by, in place of y."""

    curve: Any
    by: FloatArray
    factor: FloatArray


@curve_formula(ShiftedCurve)
def shifted_curve(f, i, at):
    return field_value(f.factor, i, at) * value_of(
        f.curve, i, State(at.y + f.by[i], at.y1, at.y2, at.y3, None, at.y4)
    )


def roller_advance(mechanism: Mechanism, designs: Designs) -> Any:
    """By how much the first roller is ahead of the second one, mm; of a follower that swings δ, rad."""
    apart = designs.roller_spacing
    return 2.0 * np.arcsin(0.5 * apart / designs.arm_length) if mechanism.motion.angular else apart


def _advance_error(mechanism: Mechanism, designs: Designs, off: ContactErrors) -> Any:
    """By how much further that is, where sizes of the follower are off."""
    wider = off.size_error("roller_spacing")
    if not mechanism.motion.angular:
        return wider
    longer, arm = off.size_error("arm_length"), designs.arm_length
    sine = designs.roller_spacing / (2.0 * arm)
    more = (wider * 0.5 - longer * sine) / (longer + arm)
    return angle_growth(sine, np.sqrt((1.0 - sine) * (1.0 + sine)), more) * 2.0


def _roller_mechanism(mechanism: Mechanism, share: float, still: float = 0.0) -> Mechanism:
    """The mechanism of a roller that is ahead of its follower by a share of the distance of both.

    ``still`` is that of it by which the sizes of designs have it ahead already.
    """

    def roller_shift(design: Designs) -> Any:
        return (share - still) * roller_advance(mechanism, design)

    def contact(design: Designs, lift: float, angle: Any, y: Any, y1: Any) -> ContactPoint:
        return mechanism.contact(design, lift, angle, y + roller_shift(design), y1)

    def rest(design: Designs, lift: float, y: Any, y1: Any, off: ContactErrors) -> ContactShift:
        found = mechanism.shifted_contact(design, lift, y + roller_shift(design), y1, off)
        return found._replace(moved=found.moved - _advance_error(mechanism, design, off) * share)

    return mechanism._replace(contact=contact, shifted_contact=rest)


def same_designs(designs: Designs) -> Designs:
    """Designs as the second contact with a cylinder sees them."""
    return designs


def _inner_roller_start(mechanism: Mechanism, designs: Designs) -> Any:
    """The height or angle of the second roller over a disc at displacement 0."""
    assert mechanism.start is not None
    return mechanism.start(designs) - roller_advance(mechanism, designs)


def inner_cam_on_line(designs: Designs) -> Designs:
    """The cam to which the inner roller of a follower that translates is the roller of an open one."""
    height = _inner_roller_start(translating.MECHANISM, designs)
    return _with_prime_radius(designs, np.sqrt(np.square(height) + np.square(designs.offset)))


def inner_cam_on_arm(designs: Designs) -> Designs:
    """Likewise of a follower that swings."""
    c, l = designs.centre_distance, designs.arm_length  # noqa: E741
    half = np.sin(0.5 * _inner_roller_start(oscillating.MECHANISM, designs))
    return _with_prime_radius(designs, np.sqrt(np.square(c - l) + 4.0 * (c * l) * np.square(half)))


def _with_prime_radius(designs: Designs, prime: Any) -> Designs:
    """Designs with a prime radius, by the size of their cam."""
    return replace(designs, size=prime - designs.roller_radius)


def _shifted_maker(make: Any, by: Callable[[Designs], Any], factor: float) -> Any:
    """What makes a curve of a motion that is ahead, times a factor."""

    def make_shifted(designs: Designs, programme: Programme) -> ShiftedCurve:
        zero = designs.size * 0.0
        return ShiftedCurve(make(designs, programme), by(designs) + zero, zero + factor)

    return make_shifted


def _zero_shift(designs: Designs) -> float:
    return 0.0


def _rib_side_mechanism(mechanism: Mechanism, body: Body, wall: Flank) -> Mechanism:
    """The mechanism of one of the rollers at a rib, which has the flank where a groove would have a wall.

    Its curvature is seen from that roller, whose force is that of the follower if it pushes it outward.
    """
    curvature = (
        mechanism.curvature if wall.bulge > 0.0 else _shifted_maker(mechanism.curvature, _zero_shift, wall.bulge)
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


def _rib_misfit(mechanism: Mechanism, sizes: Mapping[str, float]) -> SizeFault | None:
    """Why the rollers of a design have no room for a rib, or no arms."""
    if found := mechanism.misfit(sizes):
        return found
    apart, key = sizes["roller_spacing"], "follower.roller_spacing"
    if apart <= (wide := 2.0 * sizes["roller_radius"]):
        return key, apart, f"must be above the diameter of the rollers ({wide:g}): they have a rib between them"
    if mechanism.motion.angular and apart >= (most := 2.0 * sizes["arm_length"]):
        return key, apart, f"must be below twice the arm ({most:g})"
    return None


def _rib_margins(mechanism: Mechanism, designs: Designs) -> tuple[Any, ...]:
    """Numbers above 0 where the rollers have a rib between them, and arms."""
    arms = (2.0 * designs.arm_length - designs.roller_spacing,) if mechanism.motion.angular else ()
    return designs.roller_spacing - 2.0 * designs.roller_radius, *arms


ROLLERS_STAND_APART = "the rollers have to stand apart by more than their diameter"


def _on_cylinder(mechanism: Mechanism) -> Mechanism:
    """The mechanism of a grooved cylinder as that of a rib between two rollers."""

    def mechanism_at(wall: Flank) -> Mechanism:
        """That of the roller on the other side of the wall that there would be."""

        def wall_shift(designs: Designs) -> Any:
            return -0.5 * wall.side * roller_advance(mechanism, designs)

        def shift_curve(make: Any) -> Any:
            return (
                _shifted_maker(make, wall_shift, 1.0) if mechanism.motion.angular else make
            )  # the same wherever it translates

        placed = _roller_mechanism(mechanism, -0.5 * wall.side)._replace(
            pressure=shift_curve(mechanism.pressure),
            curvature=shift_curve(mechanism.curvature),
            path=shift_curve(mechanism.path),
            speeding=shift_curve(mechanism.speeding),
        )
        return _rib_side_mechanism(placed, RIBBED_CYLINDER, wall)

    def margins(designs: Designs, programme: Programme) -> tuple[Any, ...]:
        return *mechanism.assembly_margins(designs, programme), *_rib_margins(mechanism, designs)

    below, above = GROOVE_WALLS
    return with_second_contact(
        mechanism_at(below)._replace(
            assembly_margins=margins,
            assembly=f"{mechanism.assembly}, and {ROLLERS_STAND_APART}",
            misfit=lambda sizes: _rib_misfit(mechanism, sizes),
        ),
        mechanism_at(above),
        same_designs,
    )


def _on_disc(mechanism: Mechanism, closer: Callable[[Designs], Designs]) -> Mechanism:
    """The mechanism of an open disc cam as that of a rib on its face between two rollers."""

    def margins(designs: Designs, programme: Programme) -> tuple[Any, ...]:
        reach = closer(designs).size
        return (
            *mechanism.assembly_margins(designs, programme),
            *_rib_margins(mechanism, designs),
            _inner_roller_start(mechanism, designs),
            reach,
        )

    def misfit(sizes: Mapping[str, float]) -> SizeFault | None:
        if found := _rib_misfit(mechanism, sizes):
            return found
        apart, most = sizes["roller_spacing"], _most_spacing(mechanism.motion.angular, sizes)
        if apart < most:
            return None
        why = f"must be below {most:g}: the inner roller would reach the axis of the cam"
        return "follower.roller_spacing", apart, why

    inner, outer = FACE_WALLS
    return with_second_contact(
        _rib_side_mechanism(_roller_mechanism(mechanism, 0.0), RIBBED_DISC, inner)._replace(
            assembly_margins=margins,
            assembly=f"{mechanism.assembly}, {ROLLERS_STAND_APART}, and the inner one has to stay off the axis",
            misfit=misfit,
        ),
        _rib_side_mechanism(_roller_mechanism(mechanism, -1.0, still=-1.0), RIBBED_DISC, outer),
        closer,
    )


def _most_spacing(angular: bool, sizes: Mapping[str, float]) -> Any:
    """The distance of the rollers at which the inner one reaches the axis of the cam, mm."""
    prime, radius = sizes["size"] + sizes["roller_radius"], sizes["roller_radius"]
    if not angular:
        offset = sizes["offset"]
        return difference_of_squares_root(prime, offset) - difference_of_squares_root(radius, offset)
    c, l = sizes["centre_distance"], sizes["arm_length"]  # noqa: E741
    start, least = (triangle_angle(c, l, r) for r in (prime, radius))
    return 2.0 * l * sin(0.5 * (start - least))


RIB_MECHANISMS = (
    _on_cylinder(cylindrical.MECHANISM),
    _on_cylinder(cylindrical_oscillating.MECHANISM),
    _on_disc(translating.MECHANISM, inner_cam_on_line),
    _on_disc(oscillating.MECHANISM, inner_cam_on_arm),
)
