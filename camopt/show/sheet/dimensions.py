"""Dimensions by ISO 129-1: lines with arrows and the value above, readable from below or from the right."""

import numpy as np

from camopt.show.sheet.marks import (
    LARGE,
    Line,
    Marks,
    Words,
    arc_points,
    closed_line,
    line_mark,
    readable_direction,
    rectangle_line,
    text_width,
)

ARROW_LENGTH, ARROW_HALF_ANGLE = 3.0, np.radians(15.0) / 2  # mm and half angle at the tip
ARROW_TAIL = 6.0  # mm: line of an arrow outside of its dimension
EXTENSION_GAP, EXTENSION_OVERRUN = 1.0, 2.0  # mm: gap before, and overrun of, extension lines
FIRST_LEVEL, LEVEL_STEP = 8.0, 8.0  # mm from the part to the first dimension, and between dimensions
TEXT_ABOVE_LINE = 1.25  # mm from a dimension line to its value
CELL, STEM = 2 * LARGE, 2.0  # mm: height of a tolerance frame; length from a datum triangle to its letter
DATUM_REACH = ARROW_LENGTH + STEM + CELL  # mm from an arrow to the far side of the letter
BASIC_FRAME = 0.3  # mm from a basic value to its frame
VALUE_GAP = 2.0  # mm between a value and its arrows


def arrowhead(
    tip: complex, direction: complex, length: float = ARROW_LENGTH, half: float = ARROW_HALF_ANGLE
) -> Line:
    """A filled arrowhead in a direction (unit vector), with a half angle at its tip [rad]."""
    sides = tip - length * direction / np.cos(half) * np.exp(1j * half * np.array([1.0, -1.0]))
    return Line(np.array([tip, *sides, tip]), filled=True)


def distance_dimension(
    first: complex, last: complex, along: complex, level: float, value: str, datum: str = ""
) -> Marks:
    """Dimension of the distance of two points along a unit vector, on a line at a level to the left of the first.

    Arrows stand outside where the line is short, and the value past the second of them where it is wider. The
    middle between the points may be a datum: its letter stands before the first arrow, or in place of one outside.
    """
    across = 1j * along
    ends = [first + level * across, last + ((first - last) * across.conjugate()).real * across + level * across]
    ends = ends if ((ends[1] - ends[0]) * along.conjugate()).real >= 0 else ends[::-1]
    length, wide = abs(ends[1] - ends[0]), text_width(value, LARGE)
    marks: Marks = []
    for point in (first, last):
        rise = ((ends[0] - point) * across.conjugate()).real
        if abs(rise) > EXTENSION_GAP:
            side = np.copysign(1.0, rise)
            marks.append(
                line_mark(point + side * EXTENSION_GAP * across, point + (rise + side * EXTENSION_OVERRUN) * across)
            )
    turn = readable_direction(float(np.angle(along)))
    reading = np.exp(1j * turn)
    within = wide + VALUE_GAP <= length
    if length >= 2 * ARROW_LENGTH + VALUE_GAP:
        marks += [line_mark(*ends), arrowhead(ends[0], -along), arrowhead(ends[1], along)]
        at = (ends[0] + ends[1]) / 2 if within else None
    else:
        marks += [line_mark(*ends), arrowhead(ends[1], -along)]
        marks += [] if datum else [line_mark(ends[0] - ARROW_TAIL * along, ends[0]), arrowhead(ends[0], along)]
        marks.append(line_mark(ends[1], ends[1] + (ARROW_TAIL if within else ARROW_TAIL + wide) * along))
        at = (ends[0] + ends[1]) / 2 if within else ends[1] + (ARROW_TAIL + wide / 2) * along
    if at is None:
        marks.append(line_mark(ends[1], ends[1] + (VALUE_GAP + wide) * along))
        at = ends[1] + (VALUE_GAP + wide / 2) * along
    marks += datum_symbol(ends[0], -along, STEM, datum)
    return [*marks, Words(at + 1j * reading * TEXT_ABOVE_LINE, value, LARGE, 0.5, turn, backed=True)]


def datum_symbol(point: complex, direction: complex, stem: float, letter: str) -> Marks:
    """A datum: a filled triangle on an extension line, a stem, and the letter in a frame; none without a letter."""
    if not letter:
        return []
    across, far = 1j * direction, point + (3.0 + stem) * direction
    centre = far + CELL / 2 / max(abs(direction.real), abs(direction.imag)) * direction
    corner = centre - complex(CELL, CELL) / 2
    triangle = np.array([point + 1.75 * across, point - 1.75 * across, point + 3.0 * direction])
    return [
        Line(np.append(triangle, triangle[:1]), filled=True),
        line_mark(point, far),
        rectangle_line(corner, corner + complex(CELL, CELL)),
        Words(corner + complex(CELL / 2, (CELL - LARGE) / 2), letter, LARGE, 0.5),
    ]


def radius_dimension_from_outside(
    point: complex, direction: complex, length: float, value: str, is_basic: bool
) -> Marks:
    """Dimension of a radius from outside: a line with an arrow to a point of the arc, and the value."""
    tail = point + length * direction
    turn = readable_direction(float(np.angle(direction)))
    middle = point + (length + ARROW_LENGTH) / 2 * direction
    return [line_mark(tail, point), arrowhead(point, -direction), *_value_above_line(middle, value, turn, is_basic)]


def radius_dimension_from_centre(
    start: complex, point: complex, clear_length: float, value: str, is_basic: bool
) -> Marks:
    """Dimension of a radius from the centre: an arrow to the arc, with the value beyond occupied parts."""
    direction = (point - start) / abs(point - start)
    turn = readable_direction(float(np.angle(direction)))
    middle = start + (clear_length + abs(point - start) - ARROW_LENGTH) / 2 * direction
    return [line_mark(start, point), arrowhead(point, direction), *_value_above_line(middle, value, turn, is_basic)]


def _value_above_line(middle: complex, value: str, direction_angle: float, is_basic: bool) -> Marks:
    """A value above a line in a direction [rad]; a basic one interrupts the line and is in a frame (ASME Y14.5)."""
    rise = -LARGE / 2 if is_basic else TEXT_ABOVE_LINE
    words = Words(
        middle + 1j * rise * np.exp(1j * direction_angle), value, LARGE, 0.5, direction_angle, backed=True
    )
    if not is_basic:
        return [words]
    frame = BASIC_FRAME * np.exp(1j * direction_angle) * np.array([-1.0 - 1j, 1.0 - 1j, 1.0 + 1j, -1.0 + 1j])
    return [words, closed_line(*(words.corners + frame))]


def angle_dimension(radius: float, start: float, end: float) -> Marks:
    """Dimension line of an angle about 0 between two directions [rad], with arrows, or dots if there is no room."""
    marks: Marks = [Line(arc_points(radius, start, end))]
    sense = np.sign(end - start)
    lean = sense * ARROW_LENGTH / (2 * radius)  # the chord of an arrow is on the arc
    if abs(end - start) * radius >= 2 * ARROW_LENGTH + VALUE_GAP:
        for direction, side in ((start, -1.0), (end, 1.0)):
            tangent = 1j * sense * side * np.exp(1j * (direction - side * lean))
            marks.append(arrowhead(radius * np.exp(1j * direction), tangent))
        return marks
    dots = (radius * np.exp(1j * direction) for direction in (start, end))
    return [*marks, *(Line(arc_points(0.5, centre=dot), filled=True) for dot in dots)]
