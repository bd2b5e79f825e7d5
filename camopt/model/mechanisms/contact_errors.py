"""Where a follower rests on a cam that is off: the exact contact, from the point of the cam that it touches.

The profile is cut for nominal sizes, and stands out along its normal by ``out``; its axis is off that of the bore,
and the follower has sizes of its own. Which point of the profile is touched at a cam angle θ, is known by iteration
alone. Seen from the point it is a formula: the point that a nominal follower, with the displacement y, would touch
at the cam angle φ is touched by the real one

    at θ = φ + turned,    with the displacement y(φ) + moved

where both are as small as the errors, and are found without subtracting what is large. As φ goes round the turn,
θ does: the largest error over one is the largest over the other.

Source: the closed loop of cam and follower (Norton, Cam Design and Manufacturing Handbook, ch. 7).
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

Shift = tuple[Any, Any]
"""How far a point moves (x, y), mm; of what its cause is in a derivative."""


class ContactPoint(NamedTuple):
    """The trace point (flat faces: contact point) in the ground frame, and the cam's outward normal.

    x and y in mm; of the normal the direction (across, up), of any length. Each an array, a ``Taylor`` series of
    arrays or of Intervals, as the cam angle and the motion that it was made from.
    """

    x: Any
    y: Any
    across: Any
    up: Any


class ContactErrors(NamedTuple):
    """What is off of a cam and its follower; numbers, arrays, or ranges with slopes."""

    sizes: Mapping[str, Any]
    """How much larger sizes of the follower are, by field of ``Designs``, mm; 0 of those that are not named."""
    out: Any = 0.0
    """By how much the profile stands out along its normal and a round follower is larger, mm."""
    bore: Shift = (0.0, 0.0)
    """From the axis of the bore to that of the profile, in the ground frame at the cam angle φ, mm."""
    tilt: Any = 0.0
    """Of a translating flat face, ccw, rad."""

    def size_error(self, field: str) -> Any:
        return self.sizes.get(field, 0.0)

    def profile_error(self, at: ContactPoint) -> Any:
        """By how much the profile of a flat face stands out where it touches."""
        return self.out + self.bore[0] * at.across + self.bore[1] * at.up

    def point_shift(self, at: ContactPoint) -> Shift:
        """How far the point of the cam is off that a trace point touches."""
        length = np.sqrt(np.square(at.across) + np.square(at.up))
        return self.bore[0] + at.across / length * self.out, self.bore[1] + at.up / length * self.out


class ContactShift(NamedTuple):
    """Where a real follower touches the point that a nominal one touches."""

    moved: Any
    """How much further its displacement is, mm or rad."""
    turned: Any
    """How much further the cam is turned, rad."""


def cam_turn_to_point(sense: float, at: ContactPoint, cam: Shift, follower: Shift) -> Any:
    """How far a disc cam turns on until its point, off by one shift, is at the trace point, off by another."""
    x, y = at.x + cam[0], at.y + cam[1]
    across = x * (follower[1] - cam[1]) - y * (follower[0] - cam[0])
    return np.arcsin(across / (np.square(x) + np.square(y))) * sense


def angle_growth(sine: Any, cosine: Any, more: Any) -> Any:
    """By how much an angle between −90 and 90 deg grows if its sine does by ``more``, rad."""
    fall = more * (sine * 2.0 + more)
    nearer = np.sqrt(np.square(cosine) - fall)
    return np.arcsin(more * cosine + sine * fall / (nearer + cosine))
