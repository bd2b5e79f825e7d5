"""The moving parts of an animation: bodies and cursors, drawn once and then turned or shifted, and changing texts.

A body is drawn on axes of its own, as it is at cam angle 0. Its motion is given at the frames of one turn of the
cam, which ends with the first frame again.
"""

from typing import Any, NamedTuple

import numpy as np

from camopt.mechanisms.design import ComplexArray
from camopt.numerics import FloatArray

FRAMES, TURN_TIME = 100, 4.0  # of one turn; GIF counts the time of a frame in 0.01 s
FRAME_ANGLES: FloatArray = np.linspace(0.0, 2 * np.pi, FRAMES + 1)
"""Cam angles of the frames, rad."""


class SvgMotion(NamedTuple):
    """A kind of transform of SVG, and its values frame by frame."""

    kind: str
    values: list[str]


class Turning(NamedTuple):
    """A body that turns about a fixed point of its axes by angles in rad."""

    axes: Any
    centre: complex
    angles: FloatArray
    windowed: bool = False
    """Whether it is seen within its axes alone."""

    def moved(self, points: ComplexArray) -> ComplexArray:
        """Where points of the body are, (points, frames)."""
        moved: ComplexArray = self.centre + (points[:, None] - self.centre) * np.exp(1j * self.angles)
        return moved

    def place(self, affine: Any, frame: int) -> None:
        """Set an affine transform in the units of the axes to a frame."""
        affine.clear().rotate_around(self.centre.real, self.centre.imag, self.angles[frame])

    def svg_motions(self, units: Any) -> list[SvgMotion]:
        """The SVG transforms that move it, the first one first; ``units`` maps points of the axes to SVG."""
        x, y = units(np.array([self.centre]))[0]
        values = [f"{_short(-angle)} {_short(x)} {_short(y)}" for angle in np.degrees(self.angles)]
        return [SvgMotion("rotate", values)]


class Shifting(NamedTuple):
    """A body that shifts, without turning, in the units of its axes."""

    axes: Any
    shifts: Any
    """(frames,), complex"""
    windowed: bool = False
    """Whether it is seen within its axes alone."""

    def moved(self, points: ComplexArray) -> ComplexArray:
        """Where points of the body are, (points, frames)."""
        moved: ComplexArray = points[:, None] + self.shifts
        return moved

    def place(self, affine: Any, frame: int) -> None:
        """Set an affine transform in the units of the axes to a frame."""
        affine.clear().translate(self.shifts[frame].real, self.shifts[frame].imag)

    def svg_motions(self, units: Any) -> list[SvgMotion]:
        """The SVG transforms that move it, the first one first; ``units`` maps points of the axes to SVG."""
        (origin,), places = units(np.zeros(1, dtype=complex)), units(self.shifts)
        return [SvgMotion("translate", [f"{_short(x)} {_short(y)}" for x, y in places - origin])]


class Carried(NamedTuple):
    """A body that shifts and turns, about a point of its own that goes along a path."""

    axes: Any
    path: Any
    """Of that point, (frames,), complex."""
    angles: FloatArray
    windowed: bool = False
    """Whether it is seen within its axes alone."""

    @property
    def turning(self) -> Turning:
        """Its turn about that point, where it starts."""
        return Turning(self.axes, complex(self.path[0]), self.angles)

    @property
    def shifting(self) -> Shifting:
        """Its shift after that."""
        return Shifting(self.axes, self.path - self.path[0])

    def moved(self, points: ComplexArray) -> ComplexArray:
        """Where points of the body are, (points, frames)."""
        moved: ComplexArray = self.turning.moved(points) + self.shifting.shifts
        return moved

    def place(self, affine: Any, frame: int) -> None:
        """Set an affine transform in the units of the axes to a frame."""
        shift = self.shifting.shifts[frame]
        self.turning.place(affine, frame)
        affine.translate(shift.real, shift.imag)

    def svg_motions(self, units: Any) -> list[SvgMotion]:
        """The SVG transforms that move it, the first one first; ``units`` maps points of the axes to SVG."""
        return [*self.turning.svg_motions(units), *self.shifting.svg_motions(units)]


MovingBody = Turning | Shifting | Carried


def artists_of(body: MovingBody) -> list[Any]:
    """The artists that draw a body."""
    return [*body.axes.lines, *body.axes.patches, *body.axes.collections]


class Reading(NamedTuple):
    """A text that shows another value in each frame."""

    text: Any
    values: list[str]


class Stage(NamedTuple):
    """A figure with all that moves on it, the lowest first."""

    figure: Any
    bodies: list[MovingBody]
    readings: list[Reading]


def _short(number: float) -> str:
    """A number in six digits: a thousandth of a point or of a degree."""
    return f"{number:.6g}"
