"""Cylindrical cam with a rib, which two rollers of one follower have between them.

The rollers have the same radius, and their centres stand at the distance d, ``roller_spacing``: beyond the rib and
before it, on a line along the cam's axis (oscillating: on arms of the length l, at the angles ±½δ from the middle
between them). Each cuts a flank of its own, and has a pitch curve of its own: that
of an ordinary roller with the motion

    translating: y ± d/2,      oscillating: ψ ± δ/2,  sin(δ/2) = d/(2l)

So both touch at every cam angle, and the rib is thinner where the motion is steeper. Flanks that are parallels of
one curve, a rib of one thickness, would leave the rollers room wherever the slope changes.

The roller beyond the rib is the first. Seen in a mirror across the axis, the other one is beyond the rib too, and
its motion is reversed: y₂ = h − y (ψ₂ = −ψ). So each curve of the second contact is one of the first, run on the
reversed motion (``mechanisms.pairs``). κ > 0 is where the pitch curve of a contact is convex, seen from its roller.

From the tangent of a flank where its roller touches it to the other roller, the rib has, square to that tangent,

    t = d·cos(β − σ·½δ) − 2·R_r        (translating: δ = 0)

with the pressure angle β at that roller and the sense of rotation σ. The rib of a follower that translates is
nowhere thinner than the least t: with |tan β| ≤ tan β_max everywhere, two points of the pitch curves are at least
d·cos β_max apart.

Source: Rothbart, Cam Design Handbook, ch. 3 (ribbed barrel cams).
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from camopt.mechanisms import cylindrical, cylindrical_oscillating
from camopt.mechanisms.body import RIBBED_CYLINDER
from camopt.mechanisms.design import Designs, Mechanism, Misfit
from camopt.mechanisms.drive import RIBBED
from camopt.mechanisms.follower import ROLLER
from camopt.mechanisms.pairs import with_opposed
from camopt.mechanisms.rest import ContactPoint, Off, Rest, Shift, angle_by_sine
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray
from camopt.numerics.curves import curve, formula
from camopt.numerics.state import State


class Ahead(NamedTuple):
    """A factor times a curve of a motion that is ahead: of y + by, in place of y."""

    curve: Any
    by: FloatArray
    factor: FloatArray


@formula(Ahead)
def ahead_curve(f, i, at):
    value, slope = curve(f.curve, i, State(at.y + f.by[i], at.y1, at.y2, at.y3, None))
    return f.factor[i] * value, f.factor[i] * slope


def half_spacing(mechanism: Mechanism, designs: Designs) -> Any:
    """By how much the first roller is ahead of the middle between both, mm; rad of a follower that swings."""
    half = designs.roller_spacing / 2.0
    return np.arcsin(half / designs.arm_length) if mechanism.motion.angular else half


def _half_wider(mechanism: Mechanism, designs: Designs, off: Off) -> Any:
    """By how much further that is, where sizes of the follower are off."""
    wider = off.of("roller_spacing") * 0.5
    if not mechanism.motion.angular:
        return wider
    longer, arm = off.of("arm_length"), designs.arm_length
    sine = designs.roller_spacing / (2.0 * arm)
    return angle_by_sine(sine, np.sqrt((1.0 - sine) * (1.0 + sine)), (wider - longer * sine) / (longer + arm))


def _half_slopes(mechanism: Mechanism, designs: Designs) -> dict[str, Any]:
    """By how much more that is for a size that is larger, by field of ``Designs``, mm/mm (rad/mm)."""
    if not mechanism.motion.angular:
        return {"roller_spacing": 0.5}
    half, arm = half_spacing(mechanism, designs), designs.arm_length
    return {"roller_spacing": 0.5 / (arm * np.cos(half)), "arm_length": -np.tan(half) / arm}


def seen_in_mirror(designs: Designs) -> Designs:
    """Designs as the second contact sees them: a mirror across the axis leaves the sense of rotation as it is."""
    return designs


def _with_rib(mechanism: Mechanism) -> Mechanism:
    """The mechanism of a grooved cylinder as that of a rib between two rollers."""

    def ahead(make: Any, factor: float = 1.0) -> Any:
        if not mechanism.motion.angular and factor == 1.0:
            return make  # which is the same wherever a follower that translates is

        def made(designs: Designs, programme: Programme) -> Ahead:
            zero = designs.size * 0.0
            return Ahead(make(designs, programme), half_spacing(mechanism, designs) + zero, zero + factor)

        return made

    def margins(designs: Designs, programme: Programme) -> tuple[Any, ...]:
        apart = designs.roller_spacing - 2.0 * designs.roller_radius
        arms = (2.0 * designs.arm_length - designs.roller_spacing,) if mechanism.motion.angular else ()
        return *mechanism.assembly_margins(designs, programme), apart, *arms

    def misfit(sizes: Mapping[str, float]) -> Misfit | None:
        if found := mechanism.misfit(sizes):
            return found
        apart, key = sizes["roller_spacing"], "follower.roller_spacing"
        if apart <= (wide := 2.0 * sizes["roller_radius"]):
            return key, apart, f"must be above the diameter of the rollers ({wide:g}): they have a rib between them"
        if mechanism.motion.angular and apart >= (most := 2.0 * sizes["arm_length"]):
            return key, apart, f"must be below twice the arm ({most:g})"
        return None

    def contact(design: Designs, lift: float, angle: Any, y: Any, y1: Any) -> ContactPoint:
        return mechanism.contact(design, lift, angle, y + half_spacing(mechanism, design), y1)

    def shifts(design: Designs, lift: float, y: Any, y1: Any) -> dict[str, Shift]:
        found = mechanism.shifts(design, lift, y + half_spacing(mechanism, design), y1)
        x, up = found["displacement"]
        for field, slope in _half_slopes(mechanism, design).items():
            across, along = found.get(field, (0.0, 0.0))
            found[field] = across + x * slope, along + up * slope
        return found

    def rest(design: Designs, lift: float, y: Any, y1: Any, off: Off) -> Rest:
        found = mechanism.rest(design, lift, y + half_spacing(mechanism, design), y1, off)
        return found._replace(moved=found.moved - _half_wider(mechanism, design, off))

    first = replace(
        mechanism,
        body=RIBBED_CYLINDER,
        drive=RIBBED,
        tips=(ROLLER,),
        sizes=(*mechanism.sizes, "roller_spacing"),
        name=f"ribbed cylindrical cam, {mechanism.motion.name} follower with two rollers",
        pressure=ahead(mechanism.pressure),
        curvature=ahead(mechanism.curvature, -1.0),
        path=ahead(mechanism.path),
        speeding=ahead(mechanism.speeding),
        assembly_margins=margins,
        assembly=f"{mechanism.assembly}, and the rollers have to stand apart by more than their diameter",
        contact=contact,
        shifts=shifts,
        rest=rest,
        misfit=misfit,
    )
    return with_opposed(first, seen_in_mirror)


MECHANISMS = (_with_rib(cylindrical.MECHANISM), _with_rib(cylindrical_oscillating.MECHANISM))
