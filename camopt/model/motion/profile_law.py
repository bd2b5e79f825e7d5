"""The motion of a follower on a profile of arcs and lines: one exact law for each element.

The velocity is continuous where elements meet, because they are tangent; the acceleration jumps with the curvature.
The turn starts where the follower comes on the first element; on an eccentric, where the follower is lowest.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, cos, degrees, floor, inf, pi, radians

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Series, Taylor
from camopt.model.motion.law import LawBySeries
from camopt.model.motion.load import ExternalLoad
from camopt.model.motion.profile import (
    ProfileFault,
    ProfileJoint,
    ProfilePiece,
    complex_angle,
    least_distance_from_axis,
)
from camopt.model.motion.profile_contact import JointPosition, ProfileContact
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES, DWELL, ExactNumbers, Stroke

STATE_ORDERS = 4  # y and its first three derivatives
LEAST_LIFT = 1e-6  # of the largest position: the smallest lift that keeps enough digits after rounding
LEAST_DROP = 1e-12  # of the largest position: a level this near to the lowest is the lowest but for rounding


@dataclass(frozen=True)
class ProfileLaw(LawBySeries):
    """The motion of a follower on one element, from its start [mm or rad], over x from 0 to 1."""

    contact: ProfileContact
    radius: float | None
    """Radius of the trace point's arc, with a flat face that of the profile's; None for a line."""
    distance: float
    """Distance from the axis of the arc's centre, or of the trace point's line."""
    first: float
    """δ at the start [rad]."""
    turn: float
    """The cam angle over the element [deg]."""

    @property
    def NAME(self) -> str:  # noqa: N802
        return "line" if self.radius is None else "arc"

    @property
    def TITLE(self) -> str:  # noqa: N802
        return f"{self.NAME} of the profile"

    SOURCE = "Rothbart, Cam Design Handbook, ch. 3"
    BREAKS = (0.0, 1.0)

    def follower_position(self, angle: Series) -> Series:
        """Position of the follower, by δ."""
        if self.radius is None:
            return self.contact.position_on_line(self.distance, angle)
        return self.contact.position_on_arc(self.radius, self.distance, angle)

    def _derivatives_to_order(self, x: ArrayLike, order: int) -> list[FloatArray]:
        x, turn = np.asarray(x, dtype=float), radians(self.turn)
        rates = (turn, *(0.0,) * (STATE_ORDERS - 2))
        start = self.follower_position(Taylor([self.first])).terms[0]
        motion = self.follower_position(Taylor([self.first + turn * x, *rates])) - start
        return [np.asarray(motion.derivative(k)) for k in range(order + 1)]

    @property
    def has_finite_motion(self) -> bool:
        """Whether the follower has a position and a finite speed everywhere on the element.

        The radicands are least at the ends, or where δ is a multiple of a right angle.
        """
        ends = sorted([self.first, self.first + radians(self.turn)])
        square = np.arange(ceil(ends[0] / (pi / 2)), floor(ends[1] / (pi / 2)) + 1) * (pi / 2)
        with np.errstate(invalid="ignore", divide="ignore"):
            motion = self.follower_position(Taylor([np.array([*ends, *square]), 1.0]))
        return bool(np.isfinite(motion.terms).all())


def programme_on_profile(
    parts: Sequence[ProfilePiece], contact: ProfileContact, load: ExternalLoad | None = None
) -> Programme:
    """The motion of a follower on a profile, over one turn.

    Raises
    ------
    ProfileFault
        If the axis is outside the profile, or the follower bridges a hollow flank, jumps, or cannot be driven.
    """
    least = least_distance_from_axis(parts)
    positions = [_start_position_on_piece(part, contact, k) for k, part in enumerate(parts, start=1)]
    lowest = contact.position_at_joint(ProfileJoint(complex(least), 1.0 + 0.0j)).position
    farthest = max(abs(at.position) for at in positions)
    levels = [at.position - lowest for at in positions]
    levels = [0.0 if abs(level) <= LEAST_DROP * farthest else level for level in levels]
    strokes: list[Stroke] = []
    for k, (part, at) in enumerate(zip(parts, positions, strict=True), start=1):
        turn = degrees((positions[k % len(parts)].turned - at.turned) % (2 * pi)) or 360.0
        start = strokes[-1].end if strokes else 0.0
        strokes.append(_piece_stroke(part, contact, at.turned, turn, start, levels[k - 1], levels[k % len(parts)]))
        law = strokes[-1].law
        if isinstance(law, ProfileLaw) and not law.has_finite_motion:
            raise ProfileFault(k, TOO_STEEP)
    if round(strokes[-1].end / (2 * pi)) != 1:
        raise ProfileFault(0, "the contact does not go round the cam exactly once")
    radii = tuple(inf if part.radius is None else part.radius + contact.radius for part in parts)
    programme = Programme(tuple(strokes), load, levels[0], radii)
    if programme.lift <= LEAST_LIFT * farthest:
        raise ProfileFault(
            0, "the arcs are one circle about the cam's axis to within a millionth: the follower does not move"
        )
    return programme


STEEPEST_JOINT = 89.0  # deg: with a larger pressure angle, rounding turns joints into corners
TOO_STEEP = (
    f"too steep: the pressure angle would exceed {STEEPEST_JOINT:g} deg, or the follower does not reach so far"
)


def _start_position_on_piece(part: ProfilePiece, contact: ProfileContact, element_number: int) -> JointPosition:
    """The position of a follower at the start of an element; raises ``ProfileFault`` if it has none."""
    if part.radius is None or part.radius < 0.0:
        element = "a line" if part.radius is None else "a hollow flank"
        if contact.is_flat:
            raise ProfileFault(
                element_number,
                f"a flat face jumps over {element}: only arcs with a radius above 0 move it smoothly",
            )
        if part.radius is not None and part.radius + contact.radius >= 0.0:
            why = f"the follower bridges this hollow flank: its radius ({contact.radius:g}) is too large for it"
            raise ProfileFault(element_number, why)
    position = contact.position_at_joint(part.start)
    if not position.lead > cos(radians(STEEPEST_JOINT)) * (not contact.is_flat):
        raise ProfileFault(element_number, TOO_STEEP)
    return position


def _piece_stroke(
    part: ProfilePiece,
    contact: ProfileContact,
    start_contact_angle: float,
    angle_deg: float,
    start_angle: float,
    low: float,
    high: float,
) -> Stroke:
    """The stroke of the follower on an element; a dwell on an arc about the axis."""
    if part.is_concentric:
        return Stroke(
            DWELL, None, start_angle, radians(angle_deg), low, low, ExactNumbers(angle_deg, 0.0, angular=False)
        )
    if part.radius is None:
        radius, distance, towards = None, part.line_distance_from_axis + contact.radius, part.start.normal
    else:
        radius, distance, towards = part.radius + contact.radius, abs(part.centre), part.centre
    law = ProfileLaw(contact, radius, distance, start_contact_angle - complex_angle(towards), angle_deg)
    return Stroke(
        ALL_STROKES,
        law,
        start_angle,
        radians(angle_deg),
        low,
        high,
        ExactNumbers(angle_deg, high - low, angular=False),
    )
