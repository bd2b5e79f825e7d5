"""Two contacts on one follower: pairs of discs, and yokes about one disc.

The second contact is on the other side of the camshaft. In the mirror y → −y of the ground frame it is the contact
of an ordinary cam that turns the other way. That cam moves its follower by

    y₂ = h − y,    y₂' = −y',    y₂'' = −y''                    (oscillating: ψ₂ = η − ψ₁, so that y₂ = h − y too)

The second disc has its own sizes; its offset is the x of its roller, as the offset of the first disc is. The
follower cannot leave either disc, because the distance between its contacts does not change. Two translating
rollers with the offsets e₁ and e₂ have the distance

    d = √(R_p1² − e₁²) + √(R_p2² − e₂²) + h

along the motion, and two arms have the angle η = ψ₀₁ + ψ₀₂ + h between them, at every cam angle.

A yoke has both contacts on one disc, so y(θ) + y(θ + π) = h has to hold: the second disc is the first, half a turn
later. The distance of two flat faces, the breadth of the disc, is 2·R_b + h. It equals ρ(θ) + ρ(θ + π), and by
Barbier's theorem 1/π of the length of the profile.

Each curve of the second contact is an ordinary curve that takes the reversed state (``ReversedCurve``).

Sources: Rothbart, Cam Design Handbook, ch. 3 (conjugate and yoke cams); Yaglom and Boltyanskii, Convex Figures,
ch. 7 (curves of constant width).
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import Curve, FloatArray
from camopt.core.numerics.curves import curve_formula, curve_or_number_value, curve_value
from camopt.core.numerics.state import State
from camopt.model.mechanisms import oscillating, translating, translating_flat
from camopt.model.mechanisms.design import (
    CurveMaker,
    Designs,
    FurtherContact,
    Mechanism,
    OutlineMaker,
    unreduced_designs,
)
from camopt.model.mechanisms.elements import BREADTH_YOKE, CONJUGATE, DIAMETER_YOKE, ROLLER
from camopt.model.motion.programme import Programme

CONTACT_CURVES = tuple(
    name
    for name, kind in Mechanism.__annotations__.items()
    if kind in (CurveMaker, CurveMaker | None, OutlineMaker | None)
)
"""The curves of a mechanism that describe its contact with the cam."""
HALF_TURN_SAMPLES = 1801  # over half a turn
SAME_HALVES = 1e-9  # of the lift
HALVES_HAVE_TO = "y(θ) + y(θ + 180°) has to be the lift at every cam angle"


class ReversedCurve(NamedTuple):
    """A curve of the reversed motion: it takes lift − y in place of y."""

    curve: Curve
    lift: FloatArray


@curve_formula(ReversedCurve)
def reversed_motion_curve_value(curve, design, state):
    return curve_value(
        curve.curve,
        design,
        State(
            curve_or_number_value(curve.lift, design, state) - state.y,
            -state.y1,
            -state.y2,
            -state.y3,
            None,
            -state.y4,
        ),
    )


def _reversed_motion_curve(
    make_curve: Callable[..., Any], designs: Designs, programme: Programme, *extra_arguments: Any
) -> ReversedCurve:
    """A curve of the motion itself, from the maker of one for the reversed motion."""
    return ReversedCurve(make_curve(designs, programme, *extra_arguments), designs.size * 0.0 + programme.lift)


def second_disc_designs(designs: Designs) -> Designs:
    """The second discs of pairs, mirrored."""
    sizes: dict[str, Any] = {
        name: designs.second.get(f"second_{name}", getattr(designs, name))
        for name in ("size", "roller_radius", "offset", "arm_length")
    }
    return replace(designs, **sizes, sense=-designs.sense, second={})


def _reversed_motion_mechanism(mechanism: Mechanism) -> Mechanism:
    """The mechanism of a second contact: its curves take the follower's motion and reverse it."""
    curves: dict[str, Any] = {
        name: partial(_reversed_motion_curve, make) for name in CONTACT_CURVES if (make := getattr(mechanism, name))
    }
    return mechanism._replace(**curves, way=-1.0, reverses=True)


class HalfTurnMisfit(NamedTuple):
    """How far a motion is from y(θ) + y(θ + π) = h."""

    off: float
    """The largest |y(θ) + y(θ + π) − h| [mm]."""
    at: float
    """The cam angle of the largest misfit [rad]."""


@lru_cache(maxsize=256)
def largest_half_turn_misfit(programme: Programme) -> HalfTurnMisfit:
    """Largest misfit of the two contacts of a yoke with this motion, and its place."""
    angles = np.linspace(0.0, np.pi, HALF_TURN_SAMPLES)
    misfits = np.abs(
        programme.motion_at(angles)[0]
        + programme.motion_at(np.mod(angles + np.pi, 2.0 * np.pi))[0]
        - programme.lift
    )
    place = int(np.argmax(misfits))
    return HalfTurnMisfit(float(misfits[place]), float(angles[place]))


def with_second_contact(
    mechanism: Mechanism, second_mechanism: Mechanism, local_designs: Callable[[Designs], Designs], **changes: Any
) -> Mechanism:
    """A mechanism with a second contact; ``local_designs`` gives the sizes at that contact."""

    def assembly_margins(designs: Designs, programme: Programme) -> tuple[Any, ...]:
        second_margins = second_mechanism.assembly_margins(local_designs(designs), programme)
        return *mechanism.assembly_margins(designs, programme), *second_margins

    contact = FurtherContact(second_mechanism._replace(pitch=unreduced_designs), local_designs)
    return mechanism._replace(
        assembly_margins=assembly_margins, further_contacts=(contact,), pitch=unreduced_designs, **changes
    )


def _yoke_mechanism(mechanism: Mechanism, **changes: Any) -> Mechanism:
    """A mechanism with both contacts on one disc; the motion has to allow it."""
    paired = with_second_contact(mechanism, _reversed_motion_mechanism(mechanism), second_disc_designs, **changes)

    def assembly_margins(designs: Designs, programme: Programme) -> tuple[Any, ...]:
        if isinstance(programme, Programme):
            margin = SAME_HALVES * programme.lift - largest_half_turn_misfit(programme).off
        else:  # a part of the motion behind uncertain trains does not tell that the halves are the same
            margin = -1.0
        return *paired.assembly_margins(designs, programme), designs.size * 0.0 + margin

    return paired._replace(assembly_margins=assembly_margins, assembly=f"{paired.assembly}, and {HALVES_HAVE_TO}")


def _pair_mechanism(mechanism: Mechanism, *sizes: str) -> Mechanism:
    """Two discs, each with a roller of one follower; ``sizes`` may differ at the second disc."""
    drive = CONJUGATE._replace(keys=(*CONJUGATE.keys, *sizes))
    name = f"conjugate pair, {mechanism.motion.name} follower with two rollers"
    opposed = _reversed_motion_mechanism(mechanism)
    return with_second_contact(mechanism, opposed, second_disc_designs, drive=drive, tips=(ROLLER,), name=name)


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
