"""The profile by kinematic inversion: the cam is fixed, and the follower turns about it against its rotation.

A place of the follower is taken at cam angle 0 and turned by −θ (of a cylinder: shifted by R·θ along the developed
surface). From its place at the lowest displacement the follower's point moves along a tangent to the offset circle
(a radius, if there is no offset), or along an arc of its arm.

Source: Khurmi & Gupta, Theory of Machines, ch. 20; the lecture notes on cams and followers.
"""

from cmath import phase
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import degrees, pi

import numpy as np

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.numerics import ComplexArray, Number
from camopt.model.mechanisms.contact_errors import ContactPoint
from camopt.model.mechanisms.design import Mechanism
from camopt.scene.problem.linkage import follower_pivot, outward_turn_sense_of_follower
from camopt.scene.problem.problem import Problem
from camopt.show.drawing.cam import outline_left_by_undercutting, roller_arc_at_corner
from camopt.show.drawing.construction.shapes import (
    SHAPE_ARC_POINTS,
    Letter,
    PenLine,
    Step,
    arc_about,
    circle_about,
    line_through,
)
from camopt.show.drawing.construction.stations import StationPlan
from camopt.show.drawing.picture import Picture, four_digit_length_text, four_digit_text, value_with_unit

ANGLE_ARC = 0.72  # of the base radius: radius of arcs with angles
OVERRUN_SHARE = 0.12  # of the cam: length of tangents, radii and arcs beyond the farthest station
FACE_MARGIN = 0.12  # of the base radius: length of a face beyond its contacts


class FinePicture(Picture):
    """A picture whose lines deviate from its curves by at most 1e-6 of a sheet."""

    per_degree = 10.0


@dataclass(frozen=True)
class Inversion:
    """The follower at any cam angle, seen from the cam.

    Raises
    ------
    BadInput
        If the follower has two contacts, or the mechanism cannot be put together.
    """

    picture: Picture
    plan: StationPlan

    def __post_init__(self) -> None:
        if len(self.picture.contacts) > 1 or not self.picture.can_assemble:
            two = "a follower with one contact: this one has two"
            why = (
                two if len(self.picture.contacts) > 1 else "a mechanism that can be put together at every cam angle"
            )
            raise BadInput([Mistake("camopt", "construction", self.picture.scene.name, why)])

    @property
    def problem(self) -> Problem:
        return self.picture.problem

    @property
    def mechanism(self) -> Mechanism:
        return self.problem.setup.mechanism

    @property
    def angular(self) -> bool:
        return bool(self.problem.setup.angular)

    @property
    def is_developed(self) -> bool:
        return self.picture.is_developed

    @property
    def base_or_mean_radius(self) -> float:
        """Base radius, or mean radius of a cylinder [mm]."""
        return float(self.problem.design.size[0])

    @property
    def roller_radius(self) -> float:
        """Radius of the roller or spherical face [mm]; 0 for a knife edge and a flat face."""
        return float(self.problem.design.roller_radius[0])

    @property
    def offset(self) -> float:
        """Offset of the line of stroke [mm]; 0 if it has no influence on the profile."""
        none = self.angular or self.is_developed or self.mechanism.flat_faced
        return 0.0 if none else float(self.problem.design.offset[0])

    @cached_property
    def _contact_at_lowest_position(self) -> ContactPoint:
        """The contact at displacement 0 and cam angle 0, at rest."""
        return self.mechanism.contact(self.problem.design, self.problem.programme.lift, *np.zeros((3, 1)))

    @property
    def lowest_follower_point(self) -> complex:
        """The follower's point at its lowest, at cam angle 0 [mm]: the trace point, or the foot on a flat face."""
        return complex(self._contact_at_lowest_position.x[0], self._contact_at_lowest_position.y[0])

    @cached_property
    def pivot(self) -> complex:
        """Pivot of an arm at cam angle 0 [mm]; 0 for a translating follower."""
        return follower_pivot(self.problem) if self.angular else 0j

    def points_in_cam_frame(self, points: Number, angle: Number) -> Number:
        """Points of the ground frame, in the frame of the cam at a cam angle [rad]; mm."""
        if self.is_developed:
            return points + self.base_or_mean_radius * angle
        return points * np.exp(-1j * self.problem.design.sense * angle)

    def follower_point_in_cam_frame(self, angle: Number, displacement: Number) -> Number:
        """The follower's point at a displacement [mm or rad], in the frame of the cam [mm]."""
        point = self.lowest_follower_point + 1j * displacement
        if self.angular:
            turn = np.exp(1j * outward_turn_sense_of_follower(self.problem) * displacement)
            point = self.pivot + (self.lowest_follower_point - self.pivot) * turn
        return self.points_in_cam_frame(point, angle)

    @cached_property
    def drawing_reach(self) -> float:
        """Reach of the drawing from the axis, or along a cylinder [mm]."""
        return float(max(np.abs(piece.pitch).max() for piece in self.picture.curves))

    # --- steps ---

    def steps(self) -> list[Step]:
        """Steps of the profile; points in mm of the cam, in its own frame."""
        begin = (
            [self._developed_surface_step()]
            if self.is_developed
            else [*self._circle_steps(), self._segment_angle_step()]
        )
        found = [
            *begin,
            self._station_number_step(),
            self._follower_path_step(),
            self._ordinate_step(),
            self._pitch_curve_step(),
        ]
        return [step for step in [*found, self._roller_or_face_step(), self._profile_step()] if step is not None]

    @cached_property
    def _widest_station_gap_direction(self) -> complex:
        """Direction from O of the middle of the longest dwell, or of the widest gap between stations."""
        angles = np.array([each.angle for each in self.plan.stations])
        gaps = np.diff(np.append(angles, angles[0] + 2.0 * pi))
        widest = int(np.argmax(gaps))
        middle = self.points_in_cam_frame(self.lowest_follower_point, angles[widest] + 0.5 * gaps[widest])
        return complex(middle / abs(middle))

    def _add_named_circle(self, shapes: list[PenLine], letters: list[Letter], name: str, radius: float) -> None:
        """Add a circle about O, with its name where the drawing has most room."""
        shapes.append(circle_about(name, 0.0, radius, "reference"))
        text = f"{name.replace('-', ' ')}, R {four_digit_length_text(radius)}"
        way = self._widest_station_gap_direction
        letters.append(Letter(text, radius * way, phase(way), "note"))

    def _circle_steps(self) -> list[Step]:
        """Steps of the base circle with the shaft, then of the prime circle and the start of the follower."""
        base, shaft, where = self.base_or_mean_radius, self.problem.setup.shaft_radius, "base circle"
        shapes, letters = list[PenLine](), [Letter("O", 0.0, -pi / 4)]
        self._add_named_circle(shapes, letters, "base-circle", base)
        sentence = f"Draw the base circle: centre O, radius {value_with_unit(base)}, the least radius of the cam."
        if shaft is not None:
            shapes.append(circle_about("shaft", 0.0, shaft, "thin"))
            letters.append(Letter(f"shaft, R {four_digit_length_text(shaft)}", -1j * shaft, -pi / 2, "note"))
            sentence += f" The camshaft has a radius of {value_with_unit(shaft)}."
        base_step = Step(sentence, shapes, letters)
        start, (mark, _) = self.lowest_follower_point, self.plan.lettered_segment_ends[0]
        shapes, letters, sentence = [], [Letter(mark, start, phase(start))], ""
        if self.roller_radius > 0.0:
            where, prime = "prime circle", base + self.roller_radius
            self._add_named_circle(shapes, letters, "prime-circle", prime)
            terms = f"{value_with_unit(base)} + {value_with_unit(self.roller_radius)}"
            sentence = f"Draw the prime circle: {terms} = {value_with_unit(prime)}. "
        if self.angular:
            distance, arm = abs(self.pivot), value_with_unit(abs(self.pivot - start))
            self._add_named_circle(shapes, letters, "pivot-circle", distance)
            letters.append(Letter("A₁", self.pivot, phase(self.pivot)))
            shapes.append(line_through("arm", (self.pivot, start), "guide"))
            sentence += (
                f"Mark the pivot A₁ to the right of O, OA₁ = {value_with_unit(distance)}, "
                "and draw the pivot circle through it. "
                f"{mark} is on the {where}, above OA₁, with A₁{mark} = {arm}."
            )
        else:
            axis = "a vertical through O"
            if self.offset:
                side, apart = "right" if self.offset > 0 else "left", value_with_unit(abs(self.offset))
                axis = f"a vertical {apart} to the {side} of O, which touches it"
                self._add_named_circle(shapes, letters, "offset-circle", abs(self.offset))
                sentence += f"Draw the offset circle: radius {apart}. "
            ends = complex(self.offset), start + 1j * OVERRUN_SHARE * self.drawing_reach
            shapes.append(line_through("follower-axis", ends, "reference"))
            sentence += (
                f"Draw the follower's axis, {axis}. "
                f"It cuts the {where} above O in {mark}, where the follower begins."
            )
        return [base_step, Step(sentence, shapes, letters)]

    def _segment_angle_step(self) -> Step:
        """The step of the angles of strokes and dwells about O, against the rotation of the cam."""
        (first, _), sense = self.plan.lettered_segment_ends[0], self.problem.design.sense
        mark, name = (self.pivot, "A₁") if self.angular else (self.lowest_follower_point, first)
        shapes, letters = (
            [self._rotation_arrow()],
            [Letter("follower", self._rotation_arrow().points[0], 0.0, "note")],
        )
        for (letter, angle), (_, after) in pairwise(self.plan.lettered_segment_ends):
            end = complex(self.points_in_cam_frame(mark, angle))
            about, turn = end / abs(end) * ANGLE_ARC * self.base_or_mean_radius, -sense * (after - angle)
            shapes += [
                line_through(f"angle-{letter}", (0.0, end), "angle"),
                arc_about(f"angle-arc-{letter}", 0.0, about, turn * 0.98, "angle"),
            ]
            letters += [] if letter == first else [Letter(letter, end, phase(end))]
            middle, text = complex(about * np.exp(0.5j * turn)), f"{four_digit_text(degrees(after - angle))}°"
            letters.append(Letter(text, middle, phase(middle), "note"))
        sentence = (
            "Imagine that the cam is fixed, and that the follower turns about O "
            f"{'clockwise' if sense > 0 else 'anticlockwise'}, against the rotation of the cam. From O{name} "
            "mark the angles "
            f"{self.plan.segment_angle_words('O', name, name)}."
        )
        return Step(sentence, shapes, letters)

    def _rotation_arrow(self) -> PenLine:
        """An arrow outside of the cam in the direction in which the follower turns about it."""
        radius, turn = (
            (self.drawing_reach + self.roller_radius) * (1.0 + 0.6 * OVERRUN_SHARE),
            -self.problem.design.sense * np.radians(24.0),
        )
        shaft = arc_about("way-round", 0.0, radius * self._widest_station_gap_direction, turn, "arrow").points
        tip, back = shaft[-1], 0.04 * radius * np.exp(1j * np.angle(shaft[-3] - shaft[-1]))
        head = [tip, tip + back * np.exp(0.4j), tip, tip + back * np.exp(-0.4j)]
        return PenLine("way-round", np.concatenate([shaft, head]), "arrow")

    def _developed_surface_step(self) -> Step:
        """The step of the developed surface of a cylinder."""
        around, known = 2.0 * pi * self.base_or_mean_radius, {each.letter for each in self.plan.stations}
        heights = np.concatenate([piece.pitch.imag for piece in self.picture.curves])
        low, high = heights.min() - self.roller_radius, heights.max() + self.roller_radius
        start, room = self.lowest_follower_point, 0.1 * (high - low)
        corner, width, height = complex(start.real, low - room), around, 1j * (high - low + 2.0 * room)
        edge = (corner, corner + width, corner + width + height, corner + height, corner)
        shapes = [
            line_through("development", edge, "axis"),
            line_through("base-line", (start, start + around), "reference"),
        ]
        letters = [
            Letter(name, start + self.base_or_mean_radius * angle, -pi / 2)
            for name, angle in self.plan.lettered_segment_ends
            if name not in known
        ]
        sentence = (
            f"Develop the cylinder: 2π × {value_with_unit(self.base_or_mean_radius)} = {value_with_unit(around)} "
            "for 360°, and draw the base line through A. "
            f"On it mark {self.plan.segment_angle_words()}."
        )
        if self.angular:
            pivots, side = self.pivot, "right" if self.pivot.real > start.real else "left"
            shapes.append(line_through("line-of-pivots", (pivots, pivots + around), "reference"))
            letters.append(Letter("A₁", pivots, 0.0))
            sentence += (
                f" Draw the line of pivots {value_with_unit(pivots.imag - start.imag)} above the base line, "
                "so that the arm lies along it in the middle of its swing. "
                f"The first pivot A₁ is {value_with_unit(abs(pivots.real - start.real))} to the {side} of A."
            )
        return Step(sentence, shapes, letters)

    @property
    def _start_circle_or_line_name(self) -> str:
        """Name of the circle or line on which the follower's point begins."""
        return "base line" if self.is_developed else "prime circle" if self.roller_radius > 0.0 else "base circle"

    def _station_number_step(self) -> Step:
        """The step of the numbers of stations, at the starts of ordinates and of the pivot."""
        shapes, letters = [], []
        for each in self.plan.stations:
            start, pivot = (
                complex(p)
                for p in self.points_in_cam_frame(np.array([self.lowest_follower_point, self.pivot]), each.angle)
            )
            places = [("start", start, -pi / 2 if self.is_developed else phase(-start))]
            places += [("pivot", pivot, pi / 2 if self.is_developed else phase(pivot))] if self.angular else []
            for name, place, direction in places:
                shapes.append(PenLine(f"{name}-{each.number}", np.array([place]), "point"))
                letters += [] if each.number == "0" else [Letter(each.number, place, direction, "number")]
        pivots = "pivots 1, 2, 3 … on the " + ("line of pivots" if self.is_developed else "pivot circle")
        where = pivots if self.angular else f"1, 2, 3 … on the {self._start_circle_or_line_name}"
        return Step(
            f"Divide each stroke into {self.plan.parts} equal parts, as in the diagram: {where}.", shapes, letters
        )

    def _follower_path_step(self) -> Step:
        """The step of the lines or arcs along which the follower's point moves at each station."""
        shapes, low = [], self.lowest_follower_point
        for station in self.plan.stations:
            reach = float(self.problem.programme.motion_at(np.array([station.angle]), 0)[0, 0])
            if self.angular:
                beyond = OVERRUN_SHARE * self.drawing_reach / abs(self.pivot - low)
                share = np.linspace(0.0, reach + beyond, SHAPE_ARC_POINTS)
                points = self.follower_point_in_cam_frame(station.angle, share)
            else:
                foot = low if self.is_developed else complex(self.offset)
                end = low + 1j * (reach + OVERRUN_SHARE * self.drawing_reach)
                points = self.points_in_cam_frame(np.array([foot, end]), station.angle)
            shapes.append(PenLine(f"guide-{station.number}", np.asarray(points), "guide"))
        if self.angular:
            sentence = (
                f"About the pivots 1, 2, 3 … draw arcs of radius {value_with_unit(abs(self.pivot - low))}, "
                f"to cut the {self._start_circle_or_line_name} in 1, 2, 3 …"
            )
        elif self.is_developed:
            sentence = "Draw lines along the cylinder through 1, 2, 3 …"
        elif self.offset:
            sentence = (
                "From 1, 2, 3 … draw the tangents to the offset circle, on the same side of O as the "
                "follower's axis at the start, and produce them outwards."
            )
        else:
            sentence = "Join O to 1, 2, 3 … and produce these radii outwards."
        return Step(sentence, shapes, [])

    def _ordinate_step(self) -> Step:
        """The step of the displacements, set off from the start of the follower's point."""
        shapes, letters = [], []
        for each in self.plan.stations:
            points = np.asarray(
                self.follower_point_in_cam_frame(
                    each.angle, np.linspace(0.0, each.displacement, 61 if self.angular else 2)
                )
            )
            end = complex(points[-1])
            shapes += [
                PenLine(f"set-off-{each.number}", points, "ordinate"),
                PenLine(f"station-{each.number}", points[-1:], "station"),
            ]
            known = not self.is_developed and each.letter in {name for name, _ in self.plan.lettered_segment_ends}
            letters += [] if known else [Letter(each.letter, end, pi / 2 if self.is_developed else phase(end))]
        names = ", ".join(f"{each.number}{each.letter}" for each in self.plan.stations[1:4])
        arm = abs(self.pivot - self.lowest_follower_point)
        arcs = (
            f" as arcs: each is {value_with_unit(arm)} × the angle × π/180, the whole stroke "
            f"{value_with_unit(arm * self.problem.programme.lift)} "
            "(many books take chords)"
        )
        return Step(
            f"Set off {names} … from the displacement diagram{arcs if self.angular else ''}.", shapes, letters
        )

    def _pitch_curve_step(self) -> Step | None:
        """The step of the curve through the stations; none for a flat face; for a knife edge it is the profile."""
        if self.mechanism.flat_faced:
            return None
        pitch = self._close_curve(np.concatenate([piece.pitch for piece in self.picture.curves]))
        knife = self.roller_radius == 0.0
        what = "the profile of the cam" if knife else "the pitch curve"
        shape = PenLine("profile" if knife else "pitch-curve", pitch, "curve" if knife else "pitch")
        dwells = "" if self.is_developed else " In dwells it is an arc about O."
        return Step(f"{self.plan.join_stations_sentence}: {what}.{dwells}", [shape], [])

    def _close_curve(self, points: ComplexArray) -> ComplexArray:
        return points if self.is_developed else np.append(points, points[0])

    def _roller_or_face_step(self) -> Step | None:
        """The step of rollers, spherical faces or flat faces at the stations."""
        if self.mechanism.flat_faced:
            return self._flat_face_step()
        if self.roller_radius == 0.0:
            return None
        shapes = [
            circle_about(
                f"roller-{each.number}",
                complex(self.follower_point_in_cam_frame(each.angle, each.displacement)),
                self.roller_radius,
                "body",
            )
            for each in self.plan.stations
        ]
        what = "the roller" if self.picture.scene.follower.contact == "roller" else "the spherical face"
        return Step(
            f"Draw {what}, radius {value_with_unit(self.roller_radius)}, about each of these points.", shapes, []
        )

    def _flat_face_step(self) -> Step:
        """The step of flat faces at the stations, so long that they reach all contacts."""
        half, faces = 0.0, []
        lowest = self._contact_at_lowest_position
        normal = complex(lowest.across[0], lowest.up[0])
        sense = outward_turn_sense_of_follower(self.problem)
        for each in self.plan.stations:
            turned = -1j * normal / abs(normal) * np.exp(1j * sense * each.displacement * self.angular)
            along = complex(self.points_in_cam_frame(turned, each.angle))
            angle = np.array([each.angle])
            touched = self.mechanism.trace_and_normal(self.problem.design, self.problem.programme, angle).trace
            foot = self.follower_point_in_cam_frame(angle, each.displacement)
            gap = self.points_in_cam_frame(touched, angle) - foot
            half = max(half, abs(float((gap[0] * along.conjugate()).real)))  # distance of the contact from the foot
            point = complex(self.follower_point_in_cam_frame(each.angle, each.displacement))
            faces.append((f"face-{each.number}", point, along))
        half = FACE_MARGIN * self.base_or_mean_radius + half
        shapes = [
            line_through(name, (point - along * half, point + along * half), "body") for name, point, along in faces
        ]
        how = "inclined as the arm holds it" if self.angular else "square to its radius"
        return Step(f"Draw the face of the follower at each of these points, {how}.", shapes, [])

    def _profile_step(self) -> Step | None:
        """The step of the curve that touches all rollers or faces; with undercut also of the remaining cam."""
        if self.roller_radius == 0.0 and not self.mechanism.flat_faced:
            return None
        flanks, curves, shapes = self.mechanism.flanks, self.picture.curves, []
        for k, flank in enumerate(flanks):
            wall = []  # with the arcs of the roller at corners of the pitch curve
            for before, piece in zip([curves[-1], *curves[:-1]], curves, strict=True):
                wall += [roller_arc_at_corner(before, piece, -flank.side * self.roller_radius), piece.profile[k]]
            points = self._close_curve(np.concatenate(wall[1:] if self.is_developed else wall))
            shapes.append(PenLine("profile" if len(flanks) == 1 else f"profile-{flank.name}", points, "curve"))
        touched = "faces" if self.mechanism.flat_faced else "circles"
        sentence = f"Draw the curve that touches these {touched} from inside: the profile of the cam."
        if len(flanks) > 1:
            sentence = f"Draw the curves that touch these {touched} on both sides: the walls of the groove."
        if self.picture.undercut:
            sentence += " It crosses itself: the follower cuts away what lies outside the shaded area."
            if self.mechanism.body.bounded:
                shapes.append(PenLine("what-is-left", outline_left_by_undercutting(self.picture), "left"))
        return Step(sentence, shapes, [])
