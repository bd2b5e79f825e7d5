"""The moving parts of an animation: bodies and cursors, drawn once and then turned or shifted, and changing texts.

A body is drawn on axes of its own, as it is at cam angle 0. Its motion is given at the frames of one turn of the
cam, which ends with the first frame again.
"""

from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray

FRAMES, TURN_TIME = 100, 4.0  # of one turn; GIF counts the time of a frame in 0.01 s
FRAME_ANGLES: FloatArray = np.linspace(0.0, 2 * np.pi, FRAMES + 1)
"""Cam angles of the frames, rad."""
NO_ROTATION: FloatArray = np.zeros(FRAMES + 1)
"""The angles of a body that does not turn."""


class MovingBody(NamedTuple):
    """A body that shifts and turns, about a point of its own that goes along a path."""

    axes: Any
    path: Any
    """Of that point, (frames,), complex."""
    angles: FloatArray = NO_ROTATION
    """By which the body is turned, rad, (frames,)."""
    windowed: bool = False
    """Whether it is seen within its axes alone."""

    def positions(self, points: ComplexArray) -> ComplexArray:
        """Where points of the body are, (points, frames)."""
        return np.asarray(self.path + (points[:, None] - self.path[0]) * np.exp(1j * self.angles))

    def place(self, affine: Any, frame: int) -> None:
        """Set an affine transform in the units of the axes to a frame."""
        centre, shift = self.path[0], self.path[frame] - self.path[0]
        affine.clear().rotate_around(centre.real, centre.imag, self.angles[frame]).translate(shift.real, shift.imag)

    def svg_transforms(self, units: Any) -> dict[str, list[str]]:
        """The SVG transforms that move it, the first one first; ``units`` maps points of the axes to SVG.

        Numbers have six digits: a thousandth of a point or of a degree.
        """
        x, y = units(self.path[:1])[0]
        turns = [f"{-angle:.6g} {x:.6g} {y:.6g}" for angle in np.degrees(self.angles)]
        (origin,), places = units(np.zeros(1, dtype=complex)), units(self.path - self.path[0])
        return {"rotate": turns, "translate": [f"{x:.6g} {y:.6g}" for x, y in places - origin]}


def body_artists(body: MovingBody) -> list[Any]:
    """The artists that draw a body."""
    return [*body.axes.lines, *body.axes.patches, *body.axes.collections]


class Reading(NamedTuple):
    """A text that shows another value in each frame."""

    text: Any
    values: list[str]


class AnimatedFigure(NamedTuple):
    """A figure with all that moves on it, the lowest first."""

    figure: Any
    bodies: list[MovingBody]
    readings: list[Reading]
