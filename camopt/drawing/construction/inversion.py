"""The profile by kinematic inversion: the cam stands still, and the follower goes round against its rotation.

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
from typing import Any

import numpy as np

from camopt.drawing.cam import corner_arc, remaining
from camopt.drawing.construction.displacement import displacement_text
from camopt.drawing.construction.shapes import ARC_POINTS, Letter, Shape, Step, arc, circle, line
from camopt.drawing.construction.stations import Station, StationPlan
from camopt.drawing.picture import Picture, four_digits, in_figures, told
from camopt.mechanisms.design import ComplexArray
from camopt.mistakes import BadInput, Mistake
from camopt.problem.linkage import pivot_of, turning_of
from camopt.problem.problem import resolve_design
from camopt.scene.scene import Scene

ANGLE_ARC = 0.42  # of the base radius: where the sizes of angles stand
BEYOND = 0.12  # of the cam: how far tangents, radii and arcs are produced beyond the farthest station
FACE_ROOM = 0.12  # of the base radius: how far a face reaches past what it touches


class FinePicture(Picture):
    """A picture whose lines keep within 1e-6 of a sheet from its curves."""

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

    @classmethod
    def from_scene(cls, scene: Scene, parts: int) -> "Inversion":
        """That of a scene, with so many equal parts a stroke."""
        picture = FinePicture(scene, resolve_design(scene))
        return cls(picture, StationPlan(picture, parts))

    def __post_init__(self) -> None:
        why = None
        if len(self.picture.contacts) > 1:
            why = "a follower with one contact: this one has two"
        elif not self.picture.exists:
            why = "a mechanism that can be put together at every cam angle"
        if why:
            raise BadInput([Mistake("camopt", "construction", self.picture.scene.name, why)])

    @property
    def problem(self) -> Any:
        return self.picture.problem

    @property
    def mechanism(self) -> Any:
        return self.problem.setup.mechanism

    @property
    def angular(self) -> bool:
        return bool(self.problem.setup.angular)

    @property
    def is_developed(self) -> bool:
        return bool(self.mechanism.body.developed)

    @property
    def base(self) -> float:
        """Base radius, or mean radius of a cylinder, mm."""
        return float(self.problem.design.size[0])

    @property
    def radius(self) -> float:
        """Radius of the roller or spherical face, mm; 0 of a knife edge and a flat face."""
        return float(self.problem.design.roller_radius[0])

    @property
    def offset(self) -> float:
        """Offset of the line of stroke, mm: 0 where it makes no difference to the profile."""
        none = self.angular or self.is_developed or self.mechanism.flat_faced
        return 0.0 if none else float(self.problem.design.offset[0])

    @cached_property
    def _lowest(self) -> Any:
        """The contact at displacement 0 and cam angle 0, at rest."""
        return self.mechanism.contact(self.problem.design, self.problem.programme.lift, *np.zeros((3, 1)))

    @property
    def lowest(self) -> complex:
        """The follower's point at its lowest, at cam angle 0, mm: the trace point, or the foot on a flat face."""
        return complex(self._lowest.x[0], self._lowest.y[0])

    @property
    def face(self) -> complex:
        """The direction of a flat face at its lowest, at cam angle 0."""
        normal = complex(self._lowest.across[0], self._lowest.up[0])
        return -1j * normal / abs(normal)

    @cached_property
    def pivot(self) -> complex:
        """The pivot of an arm at cam angle 0, mm."""
        return pivot_of(self.problem)

    def seen_from_cam(self, points: Any, angle: Any) -> Any:
        """Points of the ground frame as the cam has them at a cam angle (rad), mm."""
        if self.is_developed:
            return points + self.base * angle
        return points * np.exp(-1j * self.problem.design.sense * angle)

    def displace(self, point: complex, displacement: Any) -> Any:
        """A point of the follower, given at its lowest, after a displacement (mm or rad)."""
        if not self.angular:
            return point + 1j * displacement
        return self.pivot + (point - self.pivot) * np.exp(1j * turning_of(self.problem) * displacement)

    def point_at(self, angle: Any, displacement: Any) -> Any:
        """The follower's point at a displacement, seen from the cam, mm."""
        return self.seen_from_cam(self.displace(self.lowest, displacement), angle)

    @cached_property
    def size(self) -> float:
        """The reach of the drawing from the axis, or along a cylinder, mm."""
        return float(max(np.abs(piece.pitch).max() for piece in self.picture.curves))

    # --- steps ---

    def steps(self) -> list[Step]:
        """The steps of the profile; their points are mm of the cam, in its own frame."""
        begin = [self._surface()] if self.is_developed else [*self._circles(), self._angles()]
        found = [*begin, self._division(), self._guides(), self._ordinates(), self._pitch_curve()]
        return [step for step in [*found, self._bodies(), self._profile()] if step is not None]

    @cached_property
    def _free(self) -> complex:
        """The direction of the middle of the longest dwell, or of the widest gap between stations, from O."""
        angles = np.array([each.angle for each in self.plan.stations])
        gaps = np.diff(np.append(angles, angles[0] + 2.0 * pi))
        widest = int(np.argmax(gaps))
        middle = self.seen_from_cam(self.lowest, angles[widest] + 0.5 * gaps[widest])
        return complex(middle / abs(middle))

    def _named_circle(self, name: str, radius: float) -> tuple[Shape, Letter]:
        """A circle about O, and its name where the drawing has most room."""
        text = f"{name.replace('-', ' ')}, R {in_figures(radius)}"
        return circle(name, 0.0, radius, "reference"), Letter(text, radius * self._free, phase(self._free), "note")

    def _circles(self) -> list[Step]:
        base, shaft = self.base, self.problem.setup.shaft_radius
        base_circle, name = self._named_circle("base-circle", base)
        shapes = [base_circle]
        letters = [Letter("O", 0.0, -pi / 4), name]
        sentence = f"Draw the base circle: centre O, radius {told(base)}, the least radius of the cam."
        if shaft is not None:
            shapes.append(circle("shaft", 0.0, shaft, "thin"))
            sentence += f" The camshaft has a diameter of {told(2.0 * shaft)}."
        steps = [Step(sentence, shapes, letters)]
        start, place = self.lowest, "on its axis through O"
        named: list[tuple[Shape, Letter]] = []
        more: list[Shape] = []
        letters = []
        sentence = ""
        if self.radius > 0.0:
            prime = base + self.radius
            sentence = f"Draw the prime circle: radius {told(base)} + {told(self.radius)} = {told(prime)}. "
            named.append(self._named_circle("prime-circle", prime))
        if self.angular:
            distance, arm = abs(self.pivot), abs(self.pivot - start)
            length = "its foot on the base circle" if self.mechanism.flat_faced else "the trace point"
            sentence += (
                f"Locate the pivot A₁ at OA₁ = {told(distance)}; A is {length}, A₁A = {told(arm)}. "
                "Draw the pivot circle through A₁."
            )
            named.append(self._named_circle("pivot-circle", distance))
            more.append(line("arm", (self.pivot, start), "guide"))
            letters.append(Letter("A₁", self.pivot, phase(self.pivot)))
        else:
            if self.offset:
                named.append(self._named_circle("offset-circle", abs(self.offset)))
                place = "where the follower's axis meets it"
                sentence += (
                    f"Draw the offset circle: radius {told(abs(self.offset))}. The follower's axis touches it. "
                )
            sentence += f"The {'face' if self.mechanism.flat_faced else 'trace point'} begins at A, {place}."
        more += [each for each, _ in named]
        return [*steps, Step(sentence, more, [*letters, *(name for _, name in named)])]

    def _angles(self) -> Step:
        """The angles of strokes and dwells about O, against the rotation of the cam."""
        mark, name = (self.pivot, "A₁") if self.angular else (self.lowest, "A")
        known, sense = {each.letter for each in self.plan.stations}, self.problem.design.sense
        shapes, letters = [self._way_round()], []
        for (letter, angle), (_, after) in pairwise(self.plan.edges):
            end = complex(self.seen_from_cam(mark, angle))
            about, turn = end / abs(end) * ANGLE_ARC * self.base, -sense * (after - angle)
            shapes += [line(f"angle-{letter}", (0.0, end), "angle")]
            shapes += [arc(f"angle-arc-{letter}", 0.0, about, turn * 0.98, "angle")]
            letters += [] if letter in known else [Letter(letter, end, phase(end))]
            middle, text = complex(about * np.exp(0.5j * turn)), f"{four_digits(degrees(after - angle))}°"
            letters.append(Letter(text, middle, phase(middle), "note"))
        sentence = (
            f"The cam stands still and the follower goes round {'clockwise' if sense > 0 else 'anticlockwise'}, "
            f"against the rotation of the cam. From O{name} mark the angles about O: {self.plan.segment_words}."
        )
        return Step(sentence.replace("X = ", "A = "), shapes, letters)

    def _way_round(self) -> Shape:
        """An arrow outside the cam: the way in which the follower goes round."""
        radius, turn = self.size * (1.0 + 1.6 * BEYOND), -self.problem.design.sense * np.radians(24.0)
        start = radius * self._free
        shaft = arc("way-round", 0.0, start, turn, "arrow").points
        tip, back = shaft[-1], 0.04 * radius * np.exp(1j * np.angle(shaft[-3] - shaft[-1]))
        head = [tip, tip + back * np.exp(0.4j), tip, tip + back * np.exp(-0.4j)]
        return Shape("way-round", np.concatenate([shaft, head]), "arrow")

    def _surface(self) -> Step:
        """The developed surface of a cylinder."""
        around, known = 2.0 * pi * self.base, {each.letter for each in self.plan.stations}
        heights = np.concatenate([piece.pitch.imag for piece in self.picture.curves])
        low, high = heights.min() - self.radius, heights.max() + self.radius
        start, room = self.lowest, 0.1 * (high - low)
        corner, width, height = complex(start.real, low - room), around, 1j * (high - low + 2.0 * room)
        edge = (corner, corner + width, corner + width + height, corner + height, corner)
        shapes = [line("development", edge, "axis"), line("base-line", (start, start + around), "reference")]
        letters = [
            Letter(name, start + self.base * angle, -pi / 2) for name, angle in self.plan.edges if name not in known
        ]
        sentence = (
            f"Develop the cylinder: 2π × {told(self.base)} = {told(around)} for 360°. "
            f"Mark {self.plan.segment_words}. The stroke is "
            f"{displacement_text(self.problem.programme.lift, self.angular)}."
        )
        return Step(sentence, shapes, letters)

    def _division(self) -> Step:
        """The numbers of the stations, on the circle where ordinates begin, and on the pivot circle."""
        shapes, letters = [], []
        for each in self.plan.stations:
            start = complex(self.point_at(each.angle, 0.0))
            shapes.append(Shape(f"start-{each.number}", np.array([start]), "point"))
            inwards = -pi / 2 if self.is_developed else phase(-start)
            if each.number != "0":
                letters.append(Letter(each.number, start, inwards, "number"))
            if self.angular:
                pivot = complex(self.seen_from_cam(self.pivot, each.angle))
                shapes.append(Shape(f"pivot-{each.number}", np.array([pivot]), "point"))
                if each.number != "0":
                    letters.append(Letter(each.number, pivot, phase(pivot), "number"))
        parts = self.plan.parts
        where = "on the pivot circle" if self.angular and not self.is_developed else "as in the diagram"
        return Step(f"Divide the angle of each stroke into {parts} equal parts, {where}.", shapes, letters)

    def _guides(self) -> Step:
        """The lines or arcs along which the follower's point moves at each station."""
        shapes = [self._guide(each.number, each.angle) for each in self.plan.stations]
        if self.angular:
            arm = told(abs(self.pivot - self.lowest))
            sentence = f"With centres 1, 2, 3 … on the pivots and radius {arm} draw arcs through 1, 2, 3 …"
        elif self.is_developed:
            sentence = "Draw lines along the cylinder through 1, 2, 3 …"
        elif self.offset:
            sentence = "From 1, 2, 3 … draw tangents to the offset circle, and produce them outwards."
        else:
            sentence = "Join O to 1, 2, 3 … and produce these radii outwards."
        return Step(sentence, shapes, [])

    def _guide(self, number: str, angle: float) -> Shape:
        reach, low = float(self.problem.programme.at(np.array([angle]), 0)[0, 0]), self.lowest
        if self.angular:
            beyond = BEYOND * self.size / abs(self.pivot - low)
            share = np.linspace(0.0, reach + beyond, ARC_POINTS)
            return Shape(f"guide-{number}", np.asarray(self.point_at(angle, share)), "guide")
        foot = low if self.is_developed else complex(self.offset)
        end = low + 1j * (reach + BEYOND * self.size)
        return Shape(f"guide-{number}", np.asarray(self.seen_from_cam(np.array([foot, end]), angle)), "guide")

    def _ordinates(self) -> Step:
        """The displacements, set off from where the follower's point begins."""
        shapes, letters = [], []
        for each in self.plan.stations:
            points = np.asarray(
                self.point_at(each.angle, np.linspace(0.0, each.displacement, 61 if self.angular else 2))
            )
            end = complex(points[-1])
            shapes += [Shape(f"set-off-{each.number}", points, "ordinate")]
            shapes += [Shape(f"station-{each.number}", points[-1:], "station")]
            letters.append(Letter(each.letter, end, pi / 2 if self.is_developed else phase(end)))
        names = ", ".join(f"{each.number}{each.letter}" for each in self.plan.stations[1:4])
        arcs = " along the arcs: each is the arm times the angle of the diagram (many books take the chord)"
        return Step(f"Set off {names} … from the displacement diagram{arcs * self.angular}.", shapes, letters)

    def _pitch_curve(self) -> Step | None:
        """The curve through the stations; a flat face has none, and that of a knife edge is the profile."""
        if self.mechanism.flat_faced:
            return None
        pitch = self._close_curve(np.concatenate([piece.pitch for piece in self.picture.curves]))
        knife = self.radius == 0.0
        what = "the profile of the cam" if knife else "the pitch curve"
        shape = Shape("profile" if knife else "pitch-curve", pitch, "curve" if knife else "pitch")
        return Step(f"{self.plan.curve_words}: {what}.", [shape], [])

    def _close_curve(self, points: ComplexArray) -> ComplexArray:
        return points if self.is_developed else np.append(points, points[0])

    def _wall(self, flank: int) -> ComplexArray:
        """A flank over the turn, with the arcs of the roller at corners of the pitch curve."""
        curves, radius = self.picture.curves, -self.mechanism.flanks[flank].side * self.radius
        before = [curves[-1], *curves[:-1]]
        parts = [
            part
            for earlier, piece in zip(before, curves, strict=True)
            for part in (corner_arc(earlier, piece, radius), piece.profile[flank])
        ]
        return np.concatenate(parts[1:] if self.is_developed else parts)

    def _bodies(self) -> Step | None:
        """Rollers, spherical faces or flat faces at the stations."""
        if self.mechanism.flat_faced:
            return self._faces()
        if self.radius == 0.0:
            return None
        shapes = [
            circle(
                f"roller-{each.number}", complex(self.point_at(each.angle, each.displacement)), self.radius, "body"
            )
            for each in self.plan.stations
        ]
        what = "the roller" if self.picture.scene.follower.contact == "roller" else "the spherical face"
        return Step(f"Draw {what}, radius {told(self.radius)}, about each of these points.", shapes, [])

    def _faces(self) -> Step:
        shapes = []
        half = FACE_ROOM * self.base + max(abs(self._reach(each)) for each in self.plan.stations)
        for each in self.plan.stations:
            point = complex(self.point_at(each.angle, each.displacement))
            along = self._along_face(each)
            shapes.append(line(f"face-{each.number}", (point - along * half, point + along * half), "body"))
        how = "inclined as the arm holds it" if self.angular else "square to its radius"
        return Step(f"Draw the face of the follower at each of these points, {how}.", shapes, [])

    def _along_face(self, station: Station) -> complex:
        """The direction of a flat face at a station, seen from the cam."""
        turned = self.face * np.exp(1j * turning_of(self.problem) * station.displacement * self.angular)
        return complex(self.seen_from_cam(turned, station.angle))

    def _reach(self, station: Station) -> float:
        """How far along its face from the constructed point a flat face touches the cam, mm."""
        angle = np.array([station.angle])
        touched = self.mechanism.travel(self.problem.design, self.problem.programme, angle).trace
        gap = self.seen_from_cam(touched, angle) - self.point_at(angle, station.displacement)
        return float((gap[0] * self._along_face(station).conjugate()).real)

    def _profile(self) -> Step | None:
        """The curve that touches all rollers or faces; where it is undercut, what is left of the cam as well."""
        if self.radius == 0.0 and not self.mechanism.flat_faced:
            return None
        flanks = range(len(self.mechanism.flanks))
        shapes = []
        for k in flanks:
            wall = self._close_curve(self._wall(k))
            name = "profile" if len(flanks) == 1 else f"profile-{self.mechanism.flanks[k].name}"
            shapes.append(Shape(name, wall, "curve"))
        touched = "faces" if self.mechanism.flat_faced else "circles"
        sentence = f"Draw the curve that touches these {touched} from inside: the profile of the cam."
        if len(flanks) > 1:
            sentence = f"Draw the curves that touch these {touched} on both sides: the walls of the groove."
        if self.picture.undercut:
            sentence += " It crosses itself: the follower cuts away what lies outside the shaded area."
            if self.mechanism.body.bounded:
                shapes.append(Shape("what-is-left", remaining(self.picture), "left"))
        return Step(sentence, shapes, [])
