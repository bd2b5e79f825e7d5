"""The displacement diagram, with the construction of its ordinates by ruler and compasses for each stroke.

Sources: Khurmi & Gupta, Theory of Machines, ch. 20 (straight lines, semicircle, double parabola); the lecture notes
on cams and followers (generating circle of the cycloid).
"""

from collections.abc import Callable
from math import degrees, pi
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.model.motion import LAWS
from camopt.show.drawing.construction.shapes import Letter, PenLine, Step, arc_about, circle_about, line_through
from camopt.show.drawing.construction.stations import Division, StationPlan
from camopt.show.drawing.picture import four_digit_text, value_with_unit

UP, DOWN, LEFT = pi / 2, -pi / 2, pi
SAME_POINT = 1e-6  # mm on the paper


class DiagramScale(NamedTuple):
    """Scales from cam angle [rad] and displacement [mm or rad] to the paper [mm from A]."""

    per_angle: float
    per_displacement: float

    def point_on_paper(self, angle: float, displacement: float) -> complex:
        return complex(self.per_angle * angle, self.per_displacement * displacement)


class LawConstruction(NamedTuple):
    """The construction of one stroke: sentence, lines, letters, and constructed points [mm on the paper]."""

    sentence: str
    shapes: list[PenLine]
    letters: list[Letter]
    points: ComplexArray


SMALL_LETTERS = " abcdefghijklmnopqrstuvwxyz"
"""a for 1, b for 2, …"""


def _stroke_ends_and_stations(
    scale: DiagramScale, division: Division
) -> tuple[complex, complex, FloatArray, list[str]]:
    """Both ends of a stroke on the paper, the abscissae of its stations, and their numbers."""
    places = [scale.point_on_paper(each.angle, each.displacement) for each in division.stations]
    return places[0], places[-1], np.real(places), [each.number for each in division.stations]


def construct_uniform_velocity(scale: DiagramScale, division: Division) -> LawConstruction:
    """Uniform velocity: one straight line from end to end."""
    start, end, x, _ = _stroke_ends_and_stations(scale, division)
    points = start + (end - start) * (x - x[0]) / (x[-1] - x[0])
    return LawConstruction("Uniform velocity: join both ends of the stroke by a straight line.", [], [], points)


def construct_simple_harmonic(scale: DiagramScale, division: Division) -> LawConstruction:
    """Simple harmonic motion: horizontals from equal parts of a semicircle on the stroke."""
    start, end, x, number = _stroke_ends_and_stations(scale, division)
    count = len(number) - 1
    low, high = sorted((start.imag, end.imag))
    middle, radius = 1j * (low + high) / 2, (high - low) / 2
    turns = np.pi * np.arange(count + 1) / count
    on_circle = middle + radius * (-np.sin(turns) - 1j * np.cos(turns))
    if start.imag > end.imag:
        on_circle = on_circle[::-1]
    points = x + 1j * on_circle.imag
    inner, rising = range(1, count), start.imag < end.imag
    shapes = [
        arc_about("semicircle", middle, middle + 1j * radius, pi, "construction"),
        *(line_through(f"projection-{number[k]}", (on_circle[k], points[k]), "projection") for k in inner),
    ]
    letters = [
        Letter(
            SMALL_LETTERS[k if rising else count - k],
            complex(on_circle[k]),
            float(np.angle(on_circle[k] - middle)),
            "note",
        )
        for k in inner
    ]
    sentence = (
        f"Simple harmonic motion: divide a semicircle on AY into {count} equal arcs by a, b, c … The horizontal "
        "through a meets the first vertical of the rise and the last but one of the return, that through b the "
        "next, and so on."
    )
    return LawConstruction(sentence, shapes, letters, points)


def construct_uniform_acceleration(scale: DiagramScale, division: Division) -> LawConstruction:
    """Uniform acceleration and retardation: rays from both ends to equal parts of the middle vertical."""
    start, end, x, number = _stroke_ends_and_stations(scale, division)
    count = len(number) - 1
    half, middle = count // 2, (x[0] + x[-1]) / 2
    marks = middle + 1j * (start.imag + (end.imag - start.imag) * np.arange(count + 1) / count)
    feet = np.where(np.arange(count + 1) <= half, start, end)
    share = (x - feet.real) / (marks.real - feet.real)
    points = x + 1j * (feet.imag + share * (marks.imag - feet.imag))
    shapes = [
        line_through(f"middle-{number[half]}", (marks[0], marks[-1]), "construction"),
        *(
            line_through(f"ray-{number[k]}", (foot, marks[k]), "projection")
            for k in range(1, count)
            for foot in ((start, end) if k == half else (complex(feet[k]),))
        ),
    ]
    letters = [Letter(SMALL_LETTERS[k], complex(marks[k]), 0.0, "note") for k in range(1, count)]
    sentence = (
        f"Uniform acceleration and retardation: divide the middle vertical of the stroke into {count} equal "
        "parts by a, b, c … Join the start of the stroke to the parts of the first half, and its end to those of "
        "the second half. The line to a cuts the first vertical, that to b the second, and so on, in points of a "
        "double parabola."
    )
    return LawConstruction(sentence, shapes, letters, points)


def construct_cycloidal(scale: DiagramScale, division: Division) -> LawConstruction:
    """Cycloidal motion: parallels to the diagonal from the projected points of the circle that generates it."""
    start, end, x, number = _stroke_ends_and_stations(scale, division)
    count = len(number) - 1
    rising = end.imag > start.imag
    centre = start if rising else end
    radius = abs(end.imag - start.imag) / (2.0 * pi)
    turns = 2.0 * pi * np.arange(count + 1) / count
    on_circle = centre + radius * np.exp((-1j if rising else 1j) * turns)
    projected = centre.real + 1j * on_circle.imag
    points = x + 1j * (projected.imag + (end - start).imag / (end - start).real * (x - centre.real))
    inner = range(1, count)
    shapes = [
        circle_about(f"generating-circle-{number[-1]}", centre, radius, "construction"),
        line_through(f"diagonal-{number[-1]}", (start, end), "construction"),
        line_through(f"diameter-{number[-1]}", (centre - 1j * radius, centre + 1j * radius), "construction"),
        *(line_through(f"across-{number[k]}", (on_circle[k], projected[k]), "projection") for k in inner),
        *(line_through(f"parallel-{number[k]}", (projected[k], points[k]), "projection") for k in inner),
    ]
    letters = [
        Letter(SMALL_LETTERS[k], complex(on_circle[k]), float(np.angle(on_circle[k] - centre)), "note")
        for k in inner
    ]
    sentence = (
        "Cycloidal motion: draw the diagonal of the stroke, and a circle of radius S/2π about its lower end. "
        f"Divide the circle into {count} equal parts by a, b, c …, from the horizontal, downwards on a rise and "
        "upwards on a return. Project these on the vertical diameter. The parallel to the diagonal from a cuts "
        "the first vertical, from b the second …"
    )
    return LawConstruction(sentence, shapes, letters, points)


def construct_by_computed_ordinates(scale: DiagramScale, division: Division) -> LawConstruction:
    """Any other law: ordinates from its equation, as in the table."""
    points = np.array([scale.point_on_paper(each.angle, each.displacement) for each in division.stations])
    law = division.stroke and division.stroke.law
    what = f"{law.TITLE} motion" if law and law.NAME in LAWS else "the follower"
    return LawConstruction(f"Set off the ordinates of the table for {what}.", [], [], points)


CONSTRUCTION_BY_LAW: dict[str, Callable[[DiagramScale, Division], LawConstruction]] = {
    "uniform": construct_uniform_velocity,
    "harmonic": construct_simple_harmonic,
    "parabolic": construct_uniform_acceleration,
    "cycloidal": construct_cycloidal,
}
"""Laws with a construction; other laws have only their ordinates."""


def construct_laws(plan: StationPlan, scale: DiagramScale) -> list[LawConstruction]:
    """The construction of each stroke. With a train the follower has no law: its motion follows from the tool."""
    found = []
    for division in plan.divisions:
        law = division.stroke and division.stroke.law
        known = CONSTRUCTION_BY_LAW.get(law.NAME) if law and plan.programme.tool_programme is None else None
        found.append((known or construct_by_computed_ordinates)(scale, division))
    return found


def displacement_steps(plan: StationPlan, scale: DiagramScale) -> list[Step]:
    """Steps of the displacement diagram: axes, constructions of laws, curve; points in mm on the paper, from A.

    Strokes with the same sentence share a step, and common points share a letter.
    """
    constructed, steps = construct_laws(plan, scale), dict[str, Step]()
    for each in constructed:
        step = steps.setdefault(each.sentence, Step(each.sentence, [], []))
        step.shapes.extend(each.shapes)
        known = [(letter.text, letter.point) for letter in step.letters]
        step.letters.extend(
            new
            for new in each.letters
            if not any(text == new.text and abs(point - new.point) < SAME_POINT for text, point in known)
        )
    angles = np.concatenate(plan.picture.angles_of_pieces)
    heights = np.concatenate([motion[0] for motion in plan.picture.motion])
    shapes = [PenLine("displacement", scale.per_angle * angles + 1j * scale.per_displacement * heights, "curve")]
    points = {
        station.letter: point
        for division, found in zip(plan.divisions, constructed, strict=True)
        for station, point in zip(division.stations, found.points.tolist(), strict=True)
    }
    for station in plan.stations:
        ends = scale.point_on_paper(station.angle, 0.0), points[station.letter]
        shapes.append(line_through(f"ordinate-{station.number}", ends, "ordinate"))
    letters = [Letter(letter, point, UP) for letter, point in points.items()]
    curve = Step(f"{plan.join_stations_sentence}: the displacement diagram.", shapes, letters)
    return [*_axis_steps(plan, scale), *steps.values(), curve]


def displacement_text(displacement: float, angular: bool) -> str:
    """A displacement of the follower with its unit: a length, or an angle in degrees."""
    return f"{four_digit_text(degrees(displacement))}°" if angular else value_with_unit(displacement)


def _axis_steps(plan: StationPlan, scale: DiagramScale) -> list[Step]:
    """The step of the axes: cam angle, stroke, and verticals of the stations."""
    ends = [scale.point_on_paper(angle, 0.0) for _, angle in plan.lettered_segment_ends]
    letters = [Letter(name, place, DOWN) for (name, _), place in zip(plan.lettered_segment_ends, ends, strict=True)]
    letters += [
        Letter(f"{four_digit_text(degrees(end - start))}°", (place + after) / 2 - 5.5j, DOWN, "note")
        for place, after, (_, start, end) in zip(ends, ends[1:], plan.segments, strict=False)
    ]
    lift = plan.programme.lift
    top, right, text = (
        scale.point_on_paper(0.0, lift),
        ends[-1],
        displacement_text(lift, plan.picture.problem.setup.angular),
    )
    frame = [
        line_through("axis-AY", (0.0, top), "axis"),
        line_through("rectangle", (top, top + right, right), "thin"),
    ]
    stroke = [Letter("Y", top, LEFT), Letter(f"S = {text}", right + top / 2, 0.0, "note")]
    feet = [(each.number, scale.point_on_paper(each.angle, 0.0)) for each in plan.stations]
    verticals = [line_through(f"vertical-{number}", (foot, foot + top), "thin") for number, foot in feet]
    numbers = [Letter(number, foot, DOWN, "number") for number, foot in feet if number != "0"]
    divided = f"Divide each stroke into {plan.parts} equal parts, and draw a vertical at each point."
    return [
        Step(
            f"Draw AX = 360° to scale. Mark {plan.segment_angle_words()}.",
            [line_through("axis-AX", (0.0, right), "axis")],
            letters,
        ),
        Step(f"Draw AY = {text}, the stroke, and complete the rectangle.", frame, stroke),
        Step(divided, verticals, numbers),
    ]
