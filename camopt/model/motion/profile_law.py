"""The motion of a follower on a profile of arcs and lines: a law for each element, exact, and their turn.

Velocity is continuous where elements meet, for they are tangent; acceleration jumps with the curvature. The turn
starts where the follower comes on the first element, or, on an eccentric, where it is lowest.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, cos, degrees, floor, inf, pi, radians

import numpy as np
from numpy.typing import ArrayLike

from camopt.core.numerics import FloatArray
from camopt.core.numerics.taylor import Series, Taylor
from camopt.model.motion.law import BySeries
from camopt.model.motion.load import ExternalLoad
from camopt.model.motion.profile import ProfileFault, ProfileJoint, ProfilePiece, least_radius, phase
from camopt.model.motion.profile_contact import JointPosition, ProfileContact
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES, DWELL, ExactNumbers, Stroke

STATE_ORDERS = 4  # y and its first three derivatives
LEAST_LIFT = 1e-6  # of the largest position: a lift of which rounding leaves enough digits
LEAST_DROP = 1e-12  # of the largest position: no more from the lowest is rounding


@dataclass(frozen=True)
class ProfileLaw(BySeries):
    """The motion of a follower from the start of an element, mm (rad), over x from 0 to 1.

    ``radius`` is that of the trace point's arc (of a flat face's, the profile's), None for a line; ``distance`` and
    ``first`` are the distance of its centre from the axis (of the trace point's line itself), and δ at the start.
    """

    contact: ProfileContact
    radius: float | None
    distance: float
    first: float
    turn: float  # deg

    @property
    def NAME(self) -> str:  # noqa: N802
        return "line" if self.radius is None else "arc"

    @property
    def TITLE(self) -> str:  # noqa: N802
        return f"{self.NAME} of the profile"

    SOURCE = "Rothbart, Cam Design Handbook, ch. 3"
    BREAKS = (0.0, 1.0)

    def position(self, angle: Series) -> Series:
        """Where the follower stands, by δ."""
        if self.radius is None:
            return self.contact.on_line(self.distance, angle)
        return self.contact.on_arc(self.radius, self.distance, angle)

    def _derivatives_to_order(self, x: ArrayLike, order: int) -> list[FloatArray]:
        x, turn = np.asarray(x, dtype=float), radians(self.turn)
        rates = (turn, *(0.0,) * (STATE_ORDERS - 2))
        start = self.position(Taylor([self.first])).terms[0]
        found = self.position(Taylor([self.first + turn * x, *rates])) - start
        return [np.asarray(found.derivative(k)) for k in range(order + 1)]

    @property
    def is_steady(self) -> bool:
        """Whether the follower has a position and a finite speed everywhere on the element.

        What is under the roots is least at the ends, or where δ is a whole number of right angles.
        """
        ends = sorted([self.first, self.first + radians(self.turn)])
        square = np.arange(ceil(ends[0] / (pi / 2)), floor(ends[1] / (pi / 2)) + 1) * (pi / 2)
        with np.errstate(invalid="ignore", divide="ignore"):
            found = self.position(Taylor([np.array([*ends, *square]), 1.0]))
        return bool(np.isfinite(found.terms).all())


def programme_on_profile(
    parts: Sequence[ProfilePiece], contact: ProfileContact, load: ExternalLoad | None = None
) -> Programme:
    """The turn of a follower on a profile.

    Raises
    ------
    Unfit
        If the axis is outside, the follower bridges a hollow flank, would jump, or could not be driven by it.
    """
    least = least_radius(parts)
    stands = [_position_on_piece(part, contact, k) for k, part in enumerate(parts, start=1)]
    lowest = contact.position_at_joint(ProfileJoint(complex(least), 1.0 + 0.0j)).position
    farthest = max(abs(stand.position) for stand in stands)
    levels = [stand.position - lowest for stand in stands]
    levels = [0.0 if abs(level) <= LEAST_DROP * farthest else level for level in levels]
    strokes: list[Stroke] = []
    for k, (part, stand) in enumerate(zip(parts, stands, strict=True), start=1):
        turn = degrees((stands[k % len(parts)].turned - stand.turned) % (2 * pi)) or 360.0
        start = strokes[-1].end if strokes else 0.0
        strokes.append(
            _piece_stroke(part, contact, stand.turned, turn, start, levels[k - 1], levels[k % len(parts)])
        )
        law = strokes[-1].law
        if isinstance(law, ProfileLaw) and not law.is_steady:
            raise ProfileFault(k, TOO_STEEP)
    if round(strokes[-1].end / (2 * pi)) != 1:
        raise ProfileFault(0, "the follower does not go round the cam once")
    radii = tuple(inf if part.radius is None else part.radius + contact.radius for part in parts)
    programme = Programme(tuple(strokes), load, levels[0], radii)
    if programme.lift <= LEAST_LIFT * farthest:
        raise ProfileFault(0, "the arcs are one circle about the cam's axis but for a millionth: nothing moves")
    return programme


STEEPEST_JOINT = 89.0  # deg: beyond, rounding makes corners of joints
TOO_STEEP = (
    f"too steep: the pressure angle would exceed {STEEPEST_JOINT:g} deg, or the follower does not come so far"
)


def _position_on_piece(part: ProfilePiece, contact: ProfileContact, number: int) -> JointPosition:
    """The position of a follower at the start of an element, if it has one."""
    if part.radius is None or part.radius < 0.0:
        what = "a line" if part.radius is None else "a hollow flank"
        if contact.is_flat:
            raise ProfileFault(
                number, f"a flat face jumps over {what}: only arcs with a radius above 0 move it smoothly"
            )
        if part.radius is not None and part.radius + contact.radius >= 0.0:
            why = f"the follower bridges this hollow flank: its radius ({contact.radius:g}) is too large for it"
            raise ProfileFault(number, why)
    stand = contact.position_at_joint(part.start)
    if not stand.lead > cos(radians(STEEPEST_JOINT)) * (not contact.is_flat):
        raise ProfileFault(number, TOO_STEEP)
    return stand


def _piece_stroke(
    part: ProfilePiece, contact: ProfileContact, turned: float, turn: float, start: float, low: float, high: float
) -> Stroke:
    """The stroke of the follower on an element; on an arc about the axis it rests."""
    if part.is_concentric:
        return Stroke(DWELL, None, start, radians(turn), low, low, ExactNumbers(turn, 0.0, angular=False))
    if part.radius is None:
        radius, distance, towards = None, part.height + contact.radius, part.start.normal
    else:
        radius, distance, towards = part.radius + contact.radius, abs(part.centre), part.centre
    law = ProfileLaw(contact, radius, distance, turned - phase(towards), turn)
    return Stroke(ALL_STROKES, law, start, radians(turn), low, high, ExactNumbers(turn, high - low, angular=False))
