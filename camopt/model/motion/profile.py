"""The profile of a cam as arcs and lines, each tangent to the next; points are complex x + iy in mm.

The plane of the cam is seen so that the follower meets the elements anticlockwise: mirrored if the cam turns ccw.
An arc has the centre C and a signed radius r, negative on a hollow flank; its point with the outward normal n is
C + r·n. Two elements meet at a point where both have the same normal:

    arc and arc               C₂ − C₁ = (r₁ − r₂)·n
    arc, line and arc         C₂ − C₁ = ((r₁ − r₂) + i·t)·n,  the line t > 0 long
    arcs r₁, r and r₂         C₂ − C₁ = (a − b·e^{iφ})·n,  a = r₁ − r, b = r₂ − r, the middle one turning by φ

Source: Rothbart, Cam Design Handbook, ch. 3 (circular-arc and tangent cams); the relations are closed loops.
"""

from collections.abc import Sequence
from math import atan2, pi, sqrt
from typing import NamedTuple

TOUCHING_SHARE = 1e-9  # of the radii: elements whose gap is no larger touch


class ProfileFault(ValueError):
    """The fault of one element, by its number from 1, or of the whole profile (0)."""

    def __init__(self, number: int, why: str) -> None:
        super().__init__(why)
        self.number = number
        self.why = why


class ElementSpec(NamedTuple):
    """An arc or line as the scene gives it."""

    radius: float | None
    """None for a line."""
    centre: complex | None = None
    """None if the element is placed so that it touches both neighbours."""


class ProfileJoint(NamedTuple):
    """A point of the profile with its outward normal."""

    point: complex
    normal: complex


class ProfilePiece(NamedTuple):
    """An element in its place, from joint to joint."""

    radius: float | None
    centre: complex
    """Centre of an arc; of a line the foot of the perpendicular from the axis."""
    start: ProfileJoint
    end: ProfileJoint

    @property
    def normal_sweep_angle(self) -> float:
        """Angle by which the normal turns, anticlockwise; negative on a hollow arc [rad]."""
        if self.radius is None:
            return 0.0
        if self.start is self.end:
            return 2 * pi
        return _turn_between(self.start.normal, self.end.normal, self.radius > 0.0)

    @property
    def line_distance_from_axis(self) -> float:
        """Distance of a line from the axis, along its normal [mm]."""
        return _distance_along_normal(self.start.point, self.start.normal)

    @property
    def is_concentric(self) -> bool:
        """Whether it is an arc about the axis, where the follower dwells."""
        return self.radius is not None and abs(self.centre) <= TOUCHING_SHARE * abs(self.radius)

    def extreme_distances_from_axis(self) -> list[float]:
        """Least and greatest distance from the axis inside the element [mm]; negative if the axis is outside."""
        if self.radius is None:
            start, end = ((joint.point - self.centre) / (1j * joint.normal) for joint in (self.start, self.end))
            room = TOUCHING_SHARE * abs(self.centre)
            return [self.line_distance_from_axis] if start.real <= room and end.real >= -room else []
        if self.is_concentric:
            return [self.radius]
        away = self.centre / abs(self.centre)
        return [
            _distance_along_normal(self.centre, n) + self.radius for n in (away, -away) if self._contains_normal(n)
        ]

    def _contains_normal(self, normal: complex) -> bool:
        """Whether the arc has a point with this normal, up to rounding."""
        turned = abs(_turn_between(self.start.normal, normal, self.normal_sweep_angle > 0.0))
        return turned <= abs(self.normal_sweep_angle) + TOUCHING_SHARE or turned >= 2 * pi - TOUCHING_SHARE


def complex_angle(z: complex) -> float:
    """Angle of a complex number [rad]; unlike ``cmath.phase`` it accepts one that rounds to 0."""
    return atan2(z.imag, z.real)


def _distance_along_normal(point: complex, normal: complex) -> float:
    """Distance of a point along a normal [mm]."""
    return (point * normal.conjugate()).real


def _turn_between(start: complex, end: complex, anticlockwise: bool) -> float:
    """Angle from one direction to another [rad]: in [0, 2π) if ``anticlockwise``, else in (−2π, 0]."""
    angle = complex_angle(end / start)
    return angle % (2 * pi) if anticlockwise else -(-angle % (2 * pi))


def place_profile_elements(elements: Sequence[ElementSpec]) -> list[ProfilePiece]:
    """The elements in their places.

    Raises
    ------
    ProfileFault
        If an element has no tangent place, two arcs do not touch, or the elements do not go round once.
    """
    if len(elements) == 1:
        return [_eccentric_circle(elements[0])]
    arcs = [_radius_and_centre(elements, k) for k in range(len(elements))]
    joints = [_joint_to_next_element(elements, arcs, k) for k in range(len(elements))]
    parts = []
    for k, arc in enumerate(arcs):
        start, end = joints[k - 1][1], joints[k][0]
        foot = _distance_along_normal(start.point, start.normal) * start.normal
        radius, centre = arc or (None, foot)
        parts.append(ProfilePiece(radius, centre, start, end))
    if round(sum(part.normal_sweep_angle for part in parts) / (2 * pi)) != 1:
        raise ProfileFault(0, "the elements do not go round the cam exactly once")
    return parts


def _eccentric_circle(element: ElementSpec) -> ProfilePiece:
    """A profile of one circle, from its point nearest to the axis."""
    radius, centre = element.radius, element.centre
    if radius is None or centre is None or radius < 0.0:
        raise ProfileFault(1, "a profile of one element is an arc with its centre (x, y) and a radius above 0")
    if abs(centre) <= TOUCHING_SHARE * radius:
        raise ProfileFault(1, "a circle about the cam's axis does not move the follower")
    normal = -centre / abs(centre)
    joint = ProfileJoint(centre + radius * normal, normal)
    return ProfilePiece(radius, centre, joint, joint)


def _radius_and_centre(elements: Sequence[ElementSpec], element_index: int) -> tuple[float, complex] | None:
    """The radius of an arc with its centre, given or computed; None for a line."""
    element = elements[element_index]
    if element.radius is None:
        return None
    if element.centre is not None:
        return element.radius, element.centre
    (r1, c1), (r2, c2) = _neighbour_arcs(elements, element_index)
    a, b, apart = r1 - element.radius, r2 - element.radius, abs(c2 - c1)
    if not (apart > 0.0 and a * b != 0.0 and -1.0 < (cosine := (a * a + b * b - apart**2) / (2 * a * b)) < 1.0):
        raise ProfileFault(element_index + 1, "no arc of this radius touches both neighbours")
    forward = 1.0 if element.radius > 0.0 else -1.0
    turn = complex(cosine, forward * sqrt((1.0 - cosine) * (1.0 + cosine)))
    normal = (c2 - c1) / (a - b * turn)
    return element.radius, c1 + a * normal / abs(normal)


def _neighbour_arcs(elements: Sequence[ElementSpec], element_index: int) -> list[tuple[float, complex]]:
    """Radius and centre of the arcs before and after an element that has to touch both."""
    arcs = []
    for other in (elements[element_index - 1], elements[(element_index + 1) % len(elements)]):
        if other.radius is None or other.centre is None:
            raise ProfileFault(
                element_index + 1, "its neighbours, which it touches, must be arcs with centres (x, y)"
            )
        arcs.append((other.radius, other.centre))
    return arcs


def _joint_to_next_element(
    elements: Sequence[ElementSpec], arcs: Sequence[tuple[float, complex] | None], element_index: int
) -> tuple[ProfileJoint, ProfileJoint]:
    """The end of an element and the start of the next; both are the same point up to rounding."""
    after = (element_index + 1) % len(elements)
    arc, next_arc = arcs[element_index], arcs[after]
    if arc is None:
        return _line_ends(elements, element_index)[1:] * 2
    if next_arc is None:
        return _line_ends(elements, after)[:1] * 2
    (r1, c1), (r2, c2) = arc, next_arc
    apart, gap = abs(c2 - c1), abs(abs(c2 - c1) - abs(r1 - r2))
    if apart <= TOUCHING_SHARE * (abs(r1) + abs(r2)):
        raise ProfileFault(after + 1, "has the centre of the arc before it: they are one circle, or never touch")
    if gap > TOUCHING_SHARE * (abs(r1) + abs(r2)):
        why = f"does not touch the arc before it, by {gap:.3g} mm; one of them may leave its centre out (x, y)"
        raise ProfileFault(after + 1, why)
    normal = (c2 - c1) / apart * (1.0 if r1 > r2 else -1.0)
    return ProfileJoint(c1 + r1 * normal, normal), ProfileJoint(c2 + r2 * normal, normal)


def _line_ends(elements: Sequence[ElementSpec], element_index: int) -> tuple[ProfileJoint, ProfileJoint]:
    """The ends of a line."""
    (r1, c1), (r2, c2) = _neighbour_arcs(elements, element_index)
    square = abs(c2 - c1) ** 2 - (r1 - r2) ** 2
    if not square > 0.0:
        raise ProfileFault(element_index + 1, "no line touches both neighbours: one is inside the other")
    normal = (c2 - c1) / complex(r1 - r2, sqrt(square))
    normal /= abs(normal)
    return ProfileJoint(c1 + r1 * normal, normal), ProfileJoint(c2 + r2 * normal, normal)


def least_distance_from_axis(parts: Sequence[ProfilePiece]) -> float:
    """Least distance of a profile from the axis [mm].

    Raises
    ------
    ProfileFault
        If the axis is not inside the profile.
    """
    least = min((height for part in parts for height in part.extreme_distances_from_axis()), key=abs)
    if least <= 0.0:
        raise ProfileFault(0, "the axis of the cam (0, 0) is outside the profile")
    base = [part.radius for part in parts if part.is_concentric and part.radius is not None]
    return next((radius for radius in base if abs(radius - least) <= TOUCHING_SHARE * least), least)
