"""Moving parts of an animation: bodies and cursors, drawn once and then moved, and changing texts.

A body is drawn on its own axes, that of a mechanism at cam angle 0. Its motion is given at the frames of one turn;
the last frame equals the first.
"""

from math import floor, log10
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray

FRAMES, TURN_TIME = 100, 4.0  # frames and seconds of one turn; a GIF has frame times in 0.01 s
FRAME_ANGLES: FloatArray = np.linspace(0.0, 2 * np.pi, FRAMES + 1)
"""Cam angles of the frames, rad."""
NO_ROTATION: FloatArray = np.zeros(FRAMES + 1)
"""Angles of a body that does not turn [rad]."""


class MovingBody(NamedTuple):
    """A body that turns about a point that moves along a path."""

    axes: Any
    path: Any
    """Positions of this point, (frames,), complex."""
    angles: FloatArray = NO_ROTATION
    """Angles of the body [rad], (frames,)."""
    windowed: bool = False
    """Whether the body is visible only within its axes."""
    drawn_at: complex | None = None
    """The position of the point as drawn, at angle 0; by default that of the first frame."""

    @property
    def origin(self) -> complex:
        """The position of the point as drawn."""
        return complex(self.path[0]) if self.drawn_at is None else self.drawn_at

    def positions(self, points: ComplexArray) -> ComplexArray:
        """Positions of points of the body, (points, frames)."""
        return np.asarray(self.path + (points[:, None] - self.origin) * np.exp(1j * self.angles))


def body_artists(body: MovingBody) -> list[Any]:
    """The matplotlib artists of a body."""
    return [*body.axes.lines, *body.axes.patches, *body.axes.collections]


def disable_axes_clipping(bodies: list[MovingBody]) -> list[MovingBody]:
    """The bodies, whose lines are then drawn outside of their axes too."""
    from matplotlib.transforms import Affine2D

    for body in bodies:
        for artist in body_artists(body):
            artist.set_clip_on(False)
            artist.set_transform(Affine2D() + body.axes.transData)
    return bodies


def reading_texts(values: FloatArray) -> list[str]:
    """Numbers with as many decimals as give the largest four digits, and a real minus sign."""
    largest = float(np.abs(values).max())
    decimals = max(0, 3 - floor(log10(largest))) if largest else 0
    return [f"{round(float(value), decimals) + 0.0:.{decimals}f}".replace("-", "−") for value in values]


class Reading(NamedTuple):
    """A text with a value for each frame."""

    text: Any
    values: list[str]


class AnimatedFigure(NamedTuple):
    """A figure with its moving bodies, the lowest first, and its changing texts."""

    figure: Any
    bodies: list[MovingBody]
    readings: list[Reading]
