"""The position of a follower on an arc or a line of a given profile.

As in ``profile``, the cam is fixed and the follower goes round it anticlockwise. At the cam angle θ the direction
of an arc's centre C = m·e^{iγ}, or of a line's normal e^{iγ}, is behind the follower by δ = θ − γ. A trace point
moves on an arc of radius p = r + R_r about C, or on a line at the distance D = d + R_r from the axis:

    translating, lead e     s = m·cos δ ± √(p² − u²),  u = e + m·sin δ        s = (D + e·sin δ)/cos δ
    oscillating, arm l      ψ = σ·arg B ± acos((b² + l² − p²)/(2·b·l))        ψ = acos((c·cos δ − D)/l) − σ·δ
    translating face        R = r + m·cos δ
    oscillating face, f     ψ = σ·arg B + asin((r − f)/b)

B = b·e^{i arg B} = c − m·e^{−iδ} is the vector from the centre to the pivot; σ = 1 for a ccw cam and −1 for cw. The
sign ± is that of p, which is negative on a hollow flank. While the follower is on one arc it moves as the
equivalent slider-crank, four-bar linkage or Scotch yoke. The formulas take numbers of any kind.

Source: Norton, Design of Machinery, ch. 4 (position analysis of linkages); Rothbart, Cam Design Handbook, ch. 3.
"""

from dataclasses import dataclass
from math import asin, cos, nan, pi, sin
from typing import ClassVar, NamedTuple, Protocol

from camopt.core.numerics.stable_functions import difference_of_squares_root, triangle_angle
from camopt.core.numerics.taylor import Series, cosine_and_sine_series, series_quotient, series_root, vector_angle
from camopt.model.motion.profile import ProfileJoint, complex_angle


class JointPosition(NamedTuple):
    """The position of a follower at a joint of the profile."""

    turned: float
    """The cam angle [rad]."""
    position: float
    """Height above the axis [mm], or angle at the pivot [rad]."""
    lead: float
    """A number that is positive, as cos β, if the cam can drive the follower; nan if there is no position."""


class ProfileContact(Protocol):
    """A follower on a profile; an arc has a radius and the distance of its centre, a line a distance."""

    @property
    def radius(self) -> float: ...
    @property
    def is_flat(self) -> bool: ...
    def position_at_joint(self, joint: ProfileJoint) -> JointPosition: ...
    def position_on_arc(self, radius: float, distance: float, angle: Series) -> Series: ...
    def position_on_line(self, distance: float, angle: Series) -> Series: ...


@dataclass(frozen=True)
class TranslatingPoint:
    """A translating knife edge, roller or spherical face: its radius and the lead of its axis [mm]."""

    radius: float
    eccentricity: float
    is_flat: ClassVar[bool] = False

    def position_at_joint(self, joint: ProfileJoint) -> JointPosition:
        point, e = joint.point + self.radius * joint.normal, self.eccentricity
        height = float(difference_of_squares_root(abs(point), e))
        if not height > 0.0:
            return JointPosition(nan, nan, nan)
        turned = complex_angle(point / complex(height, e))
        return JointPosition(turned, height, cos(complex_angle(joint.normal) - turned))

    def position_on_arc(self, radius: float, distance: float, angle: Series) -> Series:
        along, across = (each * distance for each in cosine_and_sine_series(angle))
        u, side = across + self.eccentricity, _convexity_sign(radius)
        return along + series_root(-((u - radius) * (u + radius))) * side

    def position_on_line(self, distance: float, angle: Series) -> Series:
        along, across = cosine_and_sine_series(angle)
        return series_quotient(across * self.eccentricity + distance, along)


@dataclass(frozen=True)
class OscillatingPoint:
    """A knife edge, roller or spherical face at the end of an arm [mm], and the sense of the cam."""

    radius: float
    centre_distance: float
    arm_length: float
    sense: float
    is_flat: ClassVar[bool] = False

    def position_at_joint(self, joint: ProfileJoint) -> JointPosition:
        point, c, l = joint.point + self.radius * joint.normal, self.centre_distance, self.arm_length  # noqa: E741
        psi = float(triangle_angle(c, l, abs(point)))
        if not 0.0 < psi < pi:
            return JointPosition(nan, nan, nan)
        arm = l * complex(cos(psi), self.sense * sin(psi))
        turned = complex_angle(point / (c - arm))
        upwards = -1j * self.sense * arm / l
        return JointPosition(turned, psi, cos(complex_angle(joint.normal) - turned - complex_angle(upwards)))

    def position_on_arc(self, radius: float, distance: float, angle: Series) -> Series:
        (to_pivot, square), l = (  # noqa: E741
            _angle_and_square_of_pivot_vector(self.centre_distance, distance, angle),
            self.arm_length,
        )
        near = square + (l - radius) * (l + radius)
        far = series_root(square * (4.0 * l * l) - near * near)
        return to_pivot * self.sense + vector_angle(near, far) * _convexity_sign(radius)

    def position_on_line(self, distance: float, angle: Series) -> Series:
        l = self.arm_length  # noqa: E741
        along = cosine_and_sine_series(angle).cosine * self.centre_distance - distance
        return vector_angle(along, series_root(-((along - l) * (along + l)))) - angle * self.sense


@dataclass(frozen=True)
class TranslatingFace:
    """A translating flat face, square to the motion."""

    radius: ClassVar[float] = 0.0
    is_flat: ClassVar[bool] = True

    def position_at_joint(self, joint: ProfileJoint) -> JointPosition:
        return JointPosition(complex_angle(joint.normal), (joint.point * joint.normal.conjugate()).real, 1.0)

    def position_on_arc(self, radius: float, distance: float, angle: Series) -> Series:
        return cosine_and_sine_series(angle).cosine * distance + radius

    def position_on_line(self, distance: float, angle: Series) -> Series:
        raise NotImplementedError("a flat face rests on a line at one cam angle only")


@dataclass(frozen=True)
class OscillatingFace:
    """A flat face that swings about a pivot [mm], and the sense of the cam."""

    centre_distance: float
    face_offset: float
    sense: float
    radius: ClassVar[float] = 0.0
    is_flat: ClassVar[bool] = True

    def position_at_joint(self, joint: ProfileJoint) -> JointPosition:
        sine = ((joint.point * joint.normal.conjugate()).real - self.face_offset) / self.centre_distance
        if not abs(sine) < 1.0:
            return JointPosition(nan, nan, nan)
        psi = asin(sine)
        turned = complex_angle(joint.normal) + self.sense * (pi / 2 - psi)
        face = complex(cos(psi), self.sense * sin(psi))
        from_pivot = self.centre_distance - joint.point * complex(cos(turned), -sin(turned))
        return JointPosition(turned, psi, (from_pivot * face.conjugate()).real)

    def position_on_arc(self, radius: float, distance: float, angle: Series) -> Series:
        to_pivot, square = _angle_and_square_of_pivot_vector(self.centre_distance, distance, angle)
        far = radius - self.face_offset
        return to_pivot * self.sense + vector_angle(series_root(square - far * far), square * 0.0 + far)

    def position_on_line(self, distance: float, angle: Series) -> Series:
        raise NotImplementedError("a flat face rests on a line at one cam angle only")


def _angle_and_square_of_pivot_vector(
    centre_distance: float, distance: float, angle: Series
) -> tuple[Series, Series]:
    """Angle and squared length of the vector from the centre of an arc to the pivot."""
    along, across = (each * distance for each in cosine_and_sine_series(angle))
    x = -along + centre_distance
    return vector_angle(x, across), x * x + across * across


def _convexity_sign(radius: float) -> float:
    """1 for a convex arc, −1 for a hollow one."""
    return 1.0 if radius > 0.0 else -1.0
