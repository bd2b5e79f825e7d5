"""Paths for machines and other programs: of arcs and lines, or of cubics."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray, IndexArray

STRAIGHT_ARC = 1e-12  # rad: an arc that turns by less is a line
SAME_VELOCITY = 1e-9  # velocities with a smaller relative difference are equal


@dataclass(frozen=True)
class ArcPath:
    """n arcs or lines from vertex to vertex.

    ``vertices`` are n + 1 points x + iy (mm). ``bulges`` are the n tangents of a quarter of each arc's sweep: above
    0 anticlockwise, 0 for a line (as in DXF). ``angles`` are n pairs of cam angles (rad): the part of the turn that
    each arc replaces.
    """

    vertices: ComplexArray
    bulges: FloatArray
    angles: FloatArray
    spans: tuple[int, ...]
    """Index of the curve's span that each arc follows."""

    @property
    def element_kind(self) -> str:
        """The kind of the path's elements, in words."""
        arcs, lines = np.any(self.bulges != 0.0), np.any(self.bulges == 0.0)
        return "arcs and lines" if arcs and lines else "arcs" if arcs else "lines"

    @property
    def is_closed(self) -> bool:
        return bool(self.vertices[0] == self.vertices[-1])

    @property
    def chords(self) -> ComplexArray:
        return np.diff(self.vertices)

    @property
    def sweeps(self) -> FloatArray:
        """Angle that each arc turns through [rad], anticlockwise positive."""
        return 4.0 * np.arctan(self.bulges)

    @property
    def curvatures(self) -> FloatArray:
        """Curvature of each arc [1/mm], anticlockwise positive."""
        return 2.0 * np.sin(self.sweeps / 2) / np.abs(self.chords)

    @property
    def centres(self) -> ComplexArray:
        """Centres of the arcs [mm]; infinite for lines."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.vertices[:-1] + self.chords * (0.5 + 0.5j / np.tan(self.sweeps / 2))

    @property
    def tangents(self) -> tuple[ComplexArray, ComplexArray]:
        """Unit tangents at the start and at the end of each arc."""
        chords, turn = self.chords / np.abs(self.chords), np.exp(0.5j * self.sweeps)
        return chords / turn, chords * turn

    def scale_length(self, factor: float) -> "ArcPath":
        """The path in another unit of length."""
        return replace(self, vertices=factor * self.vertices)

    @property
    def mirrored_path(self) -> "ArcPath":
        """The path seen from the other side of its plane: mirrored in the y axis."""
        return replace(self, vertices=-self.vertices.conjugate(), bulges=-self.bulges)

    @property
    def is_anticlockwise(self) -> bool:
        """Whether the path goes round the origin anticlockwise, by the signed area of its vertices."""
        return bool((self.vertices[:-1].conjugate() * self.vertices[1:]).imag.sum() > 0.0)

    @property
    def reversed_path(self) -> "ArcPath":
        """The path from its end to its start."""
        return ArcPath(self.vertices[::-1], -self.bulges[::-1], self.angles[::-1], self.spans[::-1])

    def divide_arcs(self, counts: IndexArray) -> "ArcPath":
        """The path with each arc divided into ``counts`` equal ones, each with an equal part of its cam angles.

        An arc with the chord c and the sweep φ has the points c·(e^{iφt} − 1)/(e^{iφ} − 1), t from 0 to 1.
        """
        arc, t = np.repeat(np.arange(counts.size), counts), np.concatenate([np.arange(n) / n for n in counts])
        turn = np.where(np.abs(self.sweeps) > STRAIGHT_ARC, self.sweeps, STRAIGHT_ARC)[arc]
        inside = self.vertices[arc] + self.chords[arc] * np.expm1(1j * turn * t) / np.expm1(1j * turn)
        low, high = self.angles[arc].T
        begin, end = (low + (high - low) * share for share in (t, t + 1.0 / counts[arc]))
        return ArcPath(
            np.append(inside, self.vertices[-1]),
            np.tan(np.arctan(self.bulges) / counts)[arc],
            np.column_stack([begin, end]),
            tuple(self.spans[k] for k in arc),
        )

    def start_at_vertex(self, k: int) -> "ArcPath":
        """The closed path, started at its vertex k."""
        corners = np.roll(self.vertices[:-1], -k)
        spans = (*self.spans[k:], *self.spans[:k])
        return ArcPath(np.append(corners, corners[0]), np.roll(self.bulges, -k), np.roll(self.angles, -k, 0), spans)

    def __len__(self) -> int:
        return self.bulges.size


@dataclass(frozen=True)
class CubicPath:
    """n Bézier cubics: control points x + iy (mm) of shape (n, 4); ``angles`` and ``spans`` as in ``ArcPath``."""

    controls: ComplexArray
    angles: FloatArray
    spans: tuple[int, ...]
    element_kind: ClassVar[str] = "cubics"

    def scale_length(self, factor: float) -> "CubicPath":
        """The path in another unit of length."""
        return replace(self, controls=factor * self.controls)

    def __len__(self) -> int:
        return len(self.controls)

    @property
    def bspline_controls_and_knots_deg(self) -> tuple[ComplexArray, FloatArray]:
        """Control points [mm] and knots [deg of cam angle] of the equal cubic B-spline.

        Knots are double where the velocity is continuous, and triple at corners.
        """
        lengths = self.angles[:, 1] - self.angles[:, 0]
        leaving = (self.controls[:-1, 3] - self.controls[:-1, 2]) / lengths[:-1]
        starting = (self.controls[1:, 1] - self.controls[1:, 0]) / lengths[1:]
        corner = np.abs(starting - leaving) > SAME_VELOCITY * np.abs(leaving)
        keep = np.ones(self.controls.shape, dtype=bool)
        keep[:-1, 3] = corner
        keep[1:, 0] = False
        times = np.where(corner, 3, 2)
        knots = np.concatenate([self.angles[[0], 0], self.angles[:, 1]])
        return self.controls[keep], np.degrees(np.repeat(knots, np.concatenate([[4], times, [4]])))
