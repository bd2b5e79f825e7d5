"""The front view of a disc cam along its axis, at cam angle 0, with the follower above.

A ring around the cam shows the angles of rises, dwells and returns. Its 0 is the direction of the trace point
(roller centre, or contact of a flat face) at cam angle 0. The timing mark is straight up.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import cos, pi
from typing import Any

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.scene.part import Part
from camopt.show.sheet.dimensions import radius_dimension_from_centre, radius_dimension_from_outside
from camopt.show.sheet.marks import (
    CHAIN,
    DOUBLE_CHAIN,
    HIDDEN,
    LARGE,
    THICK,
    Line,
    Marks,
    arc_points,
    circle_mark,
    line_mark,
    text_width,
)
from camopt.show.sheet.ring import RingSector, ring_marks
from camopt.show.sheet.sizes import bore_and_keyway_outline
from camopt.show.sheet.standards import length_text, sheet_standard
from camopt.show.sheet.true_cam import TrueCam
from camopt.show.sheet.two_contacts import contact_distance
from camopt.solve.contour.hole import keyway_direction_angle

RING_DISTANCE = 10.0  # mm from the cam, or its pitch curve, to the ring
BEND_LENGTH = 6.0  # mm from the ring to the bend of lines
CENTRE_LINE_OVERRUN = 4.0  # mm of centre lines beyond the cam
LEAST_RAY_ANGLE = 0.3  # rad: sufficient angle between radial lines
SAME_RADIUS = 1e-9  # relative: closer radii are equal
EVERY_DEGREE = np.radians(np.arange(0, 360))


@dataclass(frozen=True)
class FrontView:
    """A disc cam seen along its axis; lengths in mm on the paper, at a scale."""

    cam: TrueCam
    scale: float

    @property
    def part(self) -> Part:
        return self.cam.part

    @cached_property
    def walls(self) -> list[ComplexArray]:
        """The profile, or the walls of a groove or a rib, the inner one first."""
        if self.cam.is_ribbed:
            return [
                self.cam.curves[f"{disc.curve_name_prefix}profile"].points * self.scale
                for disc in self.cam.discs[::-1]
            ]
        return [
            self.cam.curve(f"profile_{flank.name}".removesuffix("_")) * self.scale
            for flank in self.cam.problem.setup.mechanism.flanks
        ]

    @cached_property
    def outline(self) -> ComplexArray:
        """The edge of the cam; the outer wall of a groove if the diameter of the disc is unknown."""
        if not self.part.outer_diameter:
            return self.walls[-1]
        return np.asarray(self.part.outer_diameter / 2 * self.scale * np.exp(1j * np.linspace(0.0, 2 * pi, 721)))

    @cached_property
    def other_profiles(self) -> list[ComplexArray]:
        """The profiles of the other discs on the shaft."""
        return [profile * self.scale for profile in self.cam.other_profiles]

    @property
    def profiles(self) -> list[ComplexArray]:
        """The outlines of all discs, in their order."""
        return [*self.other_profiles[: self.cam.place], self.outline, *self.other_profiles[self.cam.place :]]

    @cached_property
    def pitch(self) -> ComplexArray:
        """The closed path of the roller's centre; empty without a roller."""
        return self.cam.curve("pitch") * self.scale

    @property
    def base_radius(self) -> float:
        return self.cam.base_or_mean_radius * self.scale

    @cached_property
    def segments(self) -> list[RingSector]:
        """Names of the follower's strokes with their directions on the ring [rad]."""
        return [
            (
                name,
                self.cam.start_direction - self.cam.sense * begin,
                self.cam.start_direction - self.cam.sense * end,
            )
            for name, begin, end in self.cam.segments
        ]

    @property
    def ray_directions(self) -> list[float]:
        """Directions of segment starts on the ring [rad]."""
        return [begin for _, begin, _ in self.segments]

    @cached_property
    def contact_directions(self) -> list[float]:
        """Directions of the contact points on the profile at segment starts [rad]."""
        return [
            ray + aside
            for ray, aside in zip(self.ray_directions, self.cam.contact_direction_offsets_from_rays, strict=True)
        ]

    @cached_property
    def highest_point(self) -> complex:
        """The point of the profile farthest from the axis; of several points, the one farthest from other lines."""
        sizes = np.abs(self.walls[-1])
        return self._point_farthest_from_lines(self.walls[-1][sizes >= sizes.max() * (1 - SAME_RADIUS)])

    @cached_property
    def lowest_point(self) -> complex:
        """The point of the profile nearest to the axis."""
        sizes = np.abs(self.walls[0])
        return self._point_farthest_from_lines(self.walls[0][sizes <= sizes.min() * (1 + SAME_RADIUS)])

    def _point_farthest_from_lines(self, points: ComplexArray) -> complex:
        room = angle_between(np.angle(points)[:, None], self._line_directions).min(axis=1)
        return complex(points[np.argmax(np.minimum(room, LEAST_RAY_ANGLE))])

    @property
    def _line_directions(self) -> FloatArray:
        """Directions of centre lines, keyway and rays of the ring [rad]."""
        return np.array(
            [
                0,
                pi / 2,
                pi,
                -pi / 2,
                keyway_direction_angle(self.part),
                *self.ray_directions,
                *self.contact_directions,
            ]
        )

    @cached_property
    def radius_texts(self) -> tuple[str, str]:
        """Texts of the smallest and largest radius of the profile."""
        if self.cam.is_ribbed:  # beyond the inner roller
            inner = self.cam.discs[-1].problem
            low = float(inner.design.prime_radius[0]) + inner.wall_distance_from_pitch_curve
        else:
            gap = self.cam.disc.problem.wall_distance_from_pitch_curve - self.cam.roller_radius
            low = self.cam.base_or_mean_radius - gap
        high = self.cam.quantity("outer_radius_mm") or abs(self.highest_point) / self.scale
        return f"R{length_text(low)}", f"R{length_text(high)}"

    @cached_property
    def hub_or_bore_radius(self) -> float:
        """Largest radius around the axis: hub, or bore with keyway."""
        return max((self.part.hub_diameter or 0.0) / 2, self.part.bore_reach) * self.scale

    @cached_property
    def ring_radius(self) -> float:
        """Radius of the ring of angles."""
        furthest = max(self.hub_or_bore_radius, *(np.abs(curve).max(initial=0.0) for curve in self._outer_curves))
        room = abs(self.lowest_point) + text_width(self.radius_texts[0], LARGE) + 9.0
        beyond = (
            0.0
            if self._is_largest_radius_text_inside
            else abs(self.highest_point) + text_width(self.radius_texts[1], LARGE) + 9.0
        )
        return float(max(furthest + RING_DISTANCE, room, beyond))

    @cached_property
    def yoke_contacts(self) -> tuple[complex, ...]:
        """Contacts of a yoke (centres of rollers); empty without a yoke."""
        if not self.cam.problem.setup.mechanism.drive.one_disc:
            return ()
        distance = contact_distance(self.cam)
        assert distance is not None
        top = complex(self.cam.curves_at(np.zeros(1)).pitch[0])
        return top * self.scale, (top - 1j * distance.value) * self.scale

    @cached_property
    def roller_outlines(self) -> list[ComplexArray]:
        """Outlines of the rollers of a yoke."""
        radius = self.cam.roller_radius * self.scale
        return [arc_points(radius, centre=centre) for centre in self.yoke_contacts if radius]

    @property
    def _outer_curves(self) -> list[ComplexArray]:
        """Curves that may reach farthest from the axis."""
        return [self.outline, self.pitch, *self.other_profiles, *self.roller_outlines]

    @property
    def _is_largest_radius_text_inside(self) -> bool:
        """Whether the value of the largest radius is written inside the profile."""
        return (
            len(self.walls) == 1
            and abs(self.highest_point) - self.hub_or_bore_radius >= text_width(self.radius_texts[1], LARGE) + 8.0
        )

    def largest_radius_near_direction(self, direction_angle: float, half_angle: float = 0.0) -> float:
        """Largest radius of hub, profile and pitch curve within an angle of a direction [rad]."""
        largest = self.hub_or_bore_radius
        for curve in self._outer_curves:
            near = angle_between(np.angle(curve), direction_angle) <= max(half_angle, 0.02)
            largest = max(largest, float(np.abs(curve[near]).max(initial=0.0)))
        return largest

    @property
    def timing_mark_radius(self) -> float:
        """Radius of the end of the timing mark, straight up; with a hub it is on the first disc only."""
        curve = self.profiles[0] if self.part.hub_diameter else self.outline
        if not self.cam.problem.setup.mechanism.body.bounded and not self.part.outer_diameter:
            curve = self.walls[0]
        return outline_radius(curve, pi / 2)

    def marks(self) -> Marks:
        """Marks of the view, around the axis of the cam."""
        part, turn = self.part, keyway_direction_angle(self.part)
        paths = [self.pitch, *([self.cam.curves["second_pitch"].points * self.scale] if self.cam.is_ribbed else [])]
        marks: Marks = [
            *(Line(wall, THICK) for wall in self.walls),
            circle_mark(self.base_radius, CHAIN),
            *([Line(self.outline, THICK)] if part.outer_diameter else []),
            *(Line(profile, HIDDEN) for profile in self.other_profiles),
            *(Line(roller, DOUBLE_CHAIN) for roller in self.roller_outlines),
            *(Line(path, DOUBLE_CHAIN) for path in paths if path.size),
        ]
        for along in (1.0, 1j):
            low, high = (
                max(0.0, float(((side * along).conjugate() * self.outline).real.max())) for side in (-1.0, 1.0)
            )
            low, high = low + CENTRE_LINE_OVERRUN, high + CENTRE_LINE_OVERRUN
            marks.append(line_mark(-low * along, high * along, pen=CHAIN))
        return [
            *marks,
            *([circle_mark(part.hub_diameter / 2 * self.scale, THICK)] if part.hub_diameter else []),
            *([Line(bore_and_keyway_outline(part, turn) * self.scale, THICK)] if part.bore else []),
            *self._ray_lines(),
            *ring_marks(self.segments, self.ring_radius),
            *self._radius_marks(),
        ]

    def _ray_lines(self) -> Iterator[Line]:
        """Lines from the contact points at segment starts to the ring; bent if the contact is not on the ray."""
        for turn, joint, aside in zip(
            self.ray_directions, self.contact_directions, self.cam.contact_direction_offsets_from_rays, strict=True
        ):
            ray, touched = np.exp(1j * turn), np.exp(1j * joint)
            bent = [(self.ring_radius - BEND_LENGTH) * touched, self.ring_radius * ray] if aside else []
            yield line_mark(
                (self.largest_radius_near_direction(joint) + 1.5) * touched, *bent, (self.ring_radius + 2.0) * ray
            )

    def _radius_marks(self) -> Marks:
        """Dimensions of the smallest radius, at a dwell on the base circle or at one point, and of the largest."""
        (low_text, high_text), low, high = self.radius_texts, self.lowest_point, self.highest_point
        basic = sheet_standard().has_tolerance_block and self.part.profile_tolerance is not None
        inside, ring = self.hub_or_bore_radius, self.ring_radius
        sizes, away = np.abs(self.walls[0]), low / abs(low)
        turns = np.angle(self.walls[0][sizes <= sizes.min() * (1 + SAME_RADIUS)] / away)
        if np.ptp(turns) < LEAST_RAY_ANGLE and self.base_radius - inside >= text_width(low_text, LARGE) + 8.0:
            lines = np.append(self._line_directions, np.angle(high))
            free = np.argmax(angle_between(EVERY_DEGREE[:, None], lines).min(axis=1))
            end = self.base_radius * np.exp(1j * EVERY_DEGREE[free])
            marks = radius_dimension_from_centre(0.0, end, inside, low_text, basic)
        else:
            marks = radius_dimension_from_outside(low, away, ring - abs(low) - 3.0, low_text, basic)
        if abs(abs(high) - abs(low)) <= SAME_RADIUS * abs(high):
            return marks
        if self._is_largest_radius_text_inside:
            return marks + radius_dimension_from_centre(0.0, high, inside, high_text, basic)
        away = high / abs(high)
        return marks + radius_dimension_from_outside(high, away, ring - abs(high) - 3.0, high_text, basic)


def outline_radius(outline: ComplexArray, direction_angle: float) -> float:
    """Radius of a closed curve around the axis in a direction [rad]."""
    return float(np.abs(outline[np.argmin(angle_between(np.angle(outline), direction_angle))]))


def angle_between(direction_angle: Any, other_direction_angle: Any) -> FloatArray:
    """Angle between directions [rad]."""
    return np.asarray(np.abs(np.angle(np.exp(1j * (direction_angle - other_direction_angle)))))


def is_keyway_section_vertical(part: Part) -> bool:
    """Whether the section through the keyway is along the vertical centre line."""
    return abs(cos(keyway_direction_angle(part))) < SAME_RADIUS
