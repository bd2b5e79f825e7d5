"""The contact of a real cam with errors and a real follower, exactly.

The profile is cut for nominal sizes. It stands out along its normal by ``out``, its axis is not that of the bore,
and the sizes of the follower have errors. Which point of the profile the follower touches at a cam angle θ follows
only by iteration. The other way round there is a formula. Take the point that the nominal follower, with the
displacement y, touches at the cam angle φ. The real follower touches the same point

    at θ = φ + turned,    with the displacement y(φ) + moved

Both ``turned`` and ``moved`` are as small as the errors; no formula subtracts large numbers. As φ runs through the
turn, θ does too: so the largest error over φ is the largest error over θ.

Source: the closed loop of cam and follower (Norton, Cam Design and Manufacturing Handbook, ch. 7).
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import Number

Shift = tuple[Number, Number]
"""Shift of a point (x, y) [mm]; in a derivative by an error, mm per unit of the error."""


class ContactPoint(NamedTuple):
    """The trace point (flat faces: contact point) in the ground frame [mm], and the cam's outward normal.

    The normal (across, up) may have any length. The numbers are of the kind of the cam angle and motion that they
    are computed from: arrays, or ``Taylor`` series of arrays or of Intervals.
    """

    x: Number
    y: Number
    across: Number
    up: Number


class ContactErrors(NamedTuple):
    """The errors of a cam and its follower; numbers, arrays, or ranges with slopes."""

    sizes: Mapping[str, Number]
    """Errors of the follower's sizes, by field of ``Designs`` [mm]; other sizes have none."""
    out: Number = 0.0
    """Profile error along the outward normal, and error of a round follower's radius, as their sum [mm]."""
    bore: Shift = (0.0, 0.0)
    """Shift from the axis of the bore to that of the profile, in the ground frame at the cam angle φ [mm]."""
    tilt: Number = 0.0
    """Tilt of a translating flat face, ccw [rad]."""

    def size_error(self, field: str) -> Number:
        return self.sizes.get(field, 0.0)

    def flat_face_profile_error(self, point: ContactPoint) -> Number:
        """Error of the profile along the normal of a flat face, at the contact [mm]."""
        return self.out + self.bore[0] * point.across + self.bore[1] * point.up

    def trace_point_shift_by_cam_errors(self, point: ContactPoint) -> Shift:
        """Shift of the trace point that the errors of the cam cause [mm]."""
        length = np.sqrt(np.square(point.across) + np.square(point.up))
        return self.bore[0] + point.across / length * self.out, self.bore[1] + point.up / length * self.out


class ContactShift(NamedTuple):
    """How a real follower touches a point of the cam, relative to the nominal follower."""

    moved: Number
    """Its further displacement [mm or rad]."""
    turned: Number
    """The further cam angle [rad]."""


def cam_angle_until_points_meet(
    sense: float, point: ContactPoint, cam_shift: Shift, follower_shift: Shift
) -> Number:
    """Further cam angle at which the shifted point of a disc cam meets the shifted trace point [rad]."""
    x, y = point.x + cam_shift[0], point.y + cam_shift[1]
    across = x * (follower_shift[1] - cam_shift[1]) - y * (follower_shift[0] - cam_shift[0])
    return np.arcsin(across / (np.square(x) + np.square(y))) * sense


def angle_increase_from_sine(sine: Number, cosine: Number, sine_increase: Number) -> Number:
    """Growth of an angle between −90 and 90 deg whose sine grows by ``sine_increase`` [rad]."""
    fall = sine_increase * (sine * 2.0 + sine_increase)
    nearer = np.sqrt(np.square(cosine) - fall)
    return np.arcsin(sine_increase * cosine + sine * fall / (nearer + cosine))
