"""Two contacts on one follower: pairs of discs, and yokes about one disc.

The second contact is on the other side of the camshaft. Seen in a mirror along the axis through the first contact's
ground, y → −y, it is that of an ordinary cam which turns the other way and moves its follower by

    y₂ = h − y,    y₂' = −y',    y₂'' = −y''                    (oscillating: ψ₂ = η − ψ₁, so that y₂ = h − y too)

with the sizes of a second disc of its own (its offset is the x of its roller, as that of the first is). So the
follower cannot leave either disc: of rollers that translate at the offsets e₁ and e₂ the distance along the motion
is

    d = √(R_p1² − e₁²) + √(R_p2² − e₂²) + h

and the angle between two arms is η = ψ₀₁ + ψ₀₂ + h, whatever the cam angle. A yoke has both contacts on one disc,
which needs y(θ) + y(θ + π) = h: then the second disc is the first, half a turn later. The distance of two flat
faces, the breadth of the disc, is 2·R_b + h; by Barbier's theorem it is 1/π of the length of the profile, and of
the radii of curvature ρ(θ) + ρ(θ + π) is the breadth too.

Each curve of the second contact is an ordinary one, run on the state that is reversed (``ReversedCurve``).

Sources: Rothbart, Cam Design Handbook, ch. 3 (conjugate and yoke cams); Yaglom and Boltyanskii, Convex Figures,
ch. 7 (curves of constant width).
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.curves import curve_formula, field_value, value_of
from camopt.core.numerics.state import State
from camopt.model.mechanisms import oscillating, translating, translating_flat
from camopt.model.mechanisms.design import Designs, FurtherContact, Mechanism, unshared_pitch
from camopt.model.mechanisms.elements import BREADTH_YOKE, CONJUGATE, DIAMETER_YOKE, ROLLER
from camopt.model.motion.programme import Programme

CONTACT_CURVES = ("pressure", "sliding", "speeding", "curvature", "profile_radius", "reach", "outline", "path")
"""The curves of a mechanism that are of its contact with a cam."""
HALF_TURN_SAMPLES = 1801  # over half a turn
SAME_HALVES = 1e-9  # of the lift
HALVES_HAVE_TO = "y(θ) + y(θ + 180°) has to be the lift at every cam angle"


class ReversedCurve(NamedTuple):
    """A curve of a motion that is reversed: of lift − y, in place of y."""

    curve: Any
    lift: FloatArray


@curve_formula(ReversedCurve)
def reversed_curve(f, i, at):
    return value_of(f.curve, i, State(field_value(f.lift, i, at) - at.y, -at.y1, -at.y2, -at.y3, None, -at.y4))


def _reversing_maker(make: Callable[..., Any]) -> Callable[..., ReversedCurve]:
    """What makes a curve of the reversed motion, over the motion itself."""

    def make_reversed(designs: Designs, programme: Programme, *more: Any) -> ReversedCurve:
        return ReversedCurve(make(designs, programme, *more), designs.size * 0.0 + programme.lift)

    return make_reversed


def second_discs(designs: Designs) -> Designs:
    """The second discs of pairs, seen in the mirror."""

    def second_size(name: str) -> Any:
        return designs.second.get(f"second_{name}", getattr(designs, name))

    return replace(
        designs,
        size=second_size("size"),
        roller_radius=second_size("roller_radius"),
        offset=second_size("offset"),
        arm_length=second_size("arm_length"),
        sense=-designs.sense,
        second={},
    )


def _opposed_mechanism(mechanism: Mechanism) -> Mechanism:
    """The mechanism of a second contact: its curves are those of its own motion, over that of the follower."""
    curves: dict[str, Any] = {
        name: made and _reversing_maker(made) for name in CONTACT_CURVES if (made := getattr(mechanism, name))
    }
    return mechanism._replace(**curves, way=-1.0, reverses=True)


class HalfTurnMisfit(NamedTuple):
    """How far the motions of two halves of a turn are from y(θ) + y(θ + π) = h."""

    off: float
    """The largest |y(θ) + y(θ + π) − h|, mm."""
    at: float
    """The cam angle of it, rad."""


@lru_cache(maxsize=256)
def half_turn_misfit(programme: Programme) -> HalfTurnMisfit:
    """Whether a yoke can move so: where both its contacts, half a turn apart, would not fit the least."""
    angles = np.linspace(0.0, np.pi, HALF_TURN_SAMPLES)
    off = np.abs(
        programme.motion_at(angles)[0]
        + programme.motion_at(np.mod(angles + np.pi, 2.0 * np.pi))[0]
        - programme.lift
    )
    place = int(np.argmax(off))
    return HalfTurnMisfit(float(off[place]), float(angles[place]))


def with_second_contact(
    mechanism: Mechanism, second: Mechanism, seen: Callable[[Designs], Designs], **changes: Any
) -> Mechanism:
    """A mechanism with a second contact, as that sees designs."""

    def margins(designs: Designs, programme: Programme) -> tuple[Any, ...]:
        of_second = second.assembly_margins(seen(designs), programme)
        return *mechanism.assembly_margins(designs, programme), *of_second

    contact = FurtherContact(second._replace(pitch=unshared_pitch), seen)
    return mechanism._replace(
        assembly_margins=margins, further_contacts=(contact,), pitch=unshared_pitch, **changes
    )


def _yoke_mechanism(mechanism: Mechanism, **changes: Any) -> Mechanism:
    """A mechanism with both contacts on one disc, which the motion has to allow."""
    paired = with_second_contact(mechanism, _opposed_mechanism(mechanism), second_discs, **changes)

    def margins(designs: Designs, programme: Programme) -> tuple[Any, ...]:
        room = SAME_HALVES * programme.lift - half_turn_misfit(programme).off
        return *paired.assembly_margins(designs, programme), designs.size * 0.0 + room

    return paired._replace(assembly_margins=margins, assembly=f"{paired.assembly}, and {HALVES_HAVE_TO}")


def _pair_mechanism(mechanism: Mechanism, *sizes: str) -> Mechanism:
    """Two discs, each with a roller of one follower; the second has sizes of its own."""
    drive = CONJUGATE._replace(keys=(*CONJUGATE.keys, *sizes))
    name = f"conjugate pair, {mechanism.motion.name} follower with two rollers"
    opposed = _opposed_mechanism(mechanism)
    return with_second_contact(mechanism, opposed, second_discs, drive=drive, tips=(ROLLER,), name=name)


PAIR_MECHANISMS = (
    _pair_mechanism(translating.MECHANISM, "offset"),
    _pair_mechanism(oscillating.MECHANISM, "arm_length"),
    _yoke_mechanism(
        translating_flat.MECHANISM,
        drive=BREADTH_YOKE,
        name="disc of constant breadth in a yoke with two flat faces",
    ),
    _yoke_mechanism(
        translating.MECHANISM,
        drive=DIAMETER_YOKE,
        tips=(ROLLER,),
        name="disc of constant diameter in a yoke with two rollers",
    ),
)
