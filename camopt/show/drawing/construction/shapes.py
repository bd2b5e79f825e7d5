"""Parts of a construction: named lines, letters, and steps with a sentence each."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray

CIRCLE_POINTS = 721
SHAPE_ARC_POINTS = 61


class PenLine(NamedTuple):
    """A line of the drawing: name (the id in an SVG file), points [mm] and pen."""

    name: str
    points: ComplexArray
    pen: str = "thin"


class Letter(NamedTuple):
    """A letter, number or short text at a point [mm], and its direction from there [rad]."""

    text: str
    point: complex
    direction: float = 0.0
    pen: str = "letter"


class Step(NamedTuple):
    """A step of a construction: its sentence, and its additions to the drawing."""

    sentence: str
    shapes: list[PenLine]
    letters: list[Letter]


def line_through(name: str, points: Iterable[complex], pen: str = "thin") -> PenLine:
    """A line through points."""
    return PenLine(name, np.asarray(list(points), dtype=complex), pen)


def circle_about(name: str, centre: complex, radius: float, pen: str = "thin") -> PenLine:
    """A circle about a centre."""
    return arc_about(name, centre, centre + radius, 2.0 * np.pi, pen, CIRCLE_POINTS)


def arc_about(
    name: str, centre: complex, start: complex, turn_angle: float, pen: str = "thin", count: int = SHAPE_ARC_POINTS
) -> PenLine:
    """An arc about a centre, from a point through an angle [rad, anticlockwise]."""
    turns = np.exp(1j * np.linspace(0.0, turn_angle, count))
    return PenLine(name, np.asarray(centre + (start - centre) * turns), pen)
