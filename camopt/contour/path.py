"""Paths of arcs and lines, and of cubics, as machines and other programs take them."""

from dataclasses import dataclass

import numpy as np

from camopt.mechanisms.design import ComplexArray
from camopt.numerics import FloatArray

STRAIGHT = 1e-12  # of the chord: a smaller sagitta is that of a line


@dataclass(frozen=True)
class ArcPath:
    """n arcs or lines from vertex to vertex.

    ``vertices`` are n + 1 points x + iy, mm. ``bulges`` are n numbers, the tangents of a quarter of what each arc turns:
    above 0 anticlockwise, 0 for a line (as in DXF). ``angles`` are n pairs of cam angles, rad, between which the cam's
    curve follows the arc; a pair of equal angles is an arc that rounds a gap.
    """

    vertices: ComplexArray
    bulges: FloatArray
    angles: FloatArray
    spans: tuple[int, ...]
    """On which span of the curve each arc is."""

    @property
    def chords(self) -> ComplexArray:
        return np.diff(self.vertices)

    @property
    def sweeps(self) -> FloatArray:
        """What each arc turns, rad, anticlockwise positive."""
        return 4.0 * np.arctan(self.bulges)

    @property
    def curvatures(self) -> FloatArray:
        """1/mm, anticlockwise positive."""
        return 2.0 * np.sin(self.sweeps / 2) / np.abs(self.chords)

    @property
    def centres(self) -> ComplexArray:
        """Of the arcs, mm; of lines without bounds."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.vertices[:-1] + self.chords * (0.5 + 0.5j / np.tan(self.sweeps / 2))

    @property
    def tangents(self) -> tuple[ComplexArray, ComplexArray]:
        """Unit tangents where each arc starts and ends."""
        chords, turn = self.chords / np.abs(self.chords), np.exp(0.5j * self.sweeps)
        return chords / turn, chords * turn

    def __len__(self) -> int:
        return self.bulges.size


@dataclass(frozen=True)
class CubicPath:
    """n Bézier cubics: control points (n, 4), x + iy in mm; ``angles`` and ``spans`` as of ``ArcPath``."""

    controls: ComplexArray
    angles: FloatArray
    spans: tuple[int, ...]

    def __len__(self) -> int:
        return len(self.controls)
