"""Outlines of tools and fixed bodies: where they are at a lift, and how far apart two of them are.

An outline is a point, a line or a closed polygon, rounded outward by a radius. Points are complex numbers x + iy
[mm]. A tree of chords covers the outline: each chord joins two of its points, and the outline between them lies
within the ``cover`` of the chord. So a search need not look at pairs of edges that are far apart.
"""

from dataclasses import dataclass
from functools import cached_property
from math import radians
from typing import NamedTuple, Self

import numpy as np

from camopt.core.numerics import BoolArray, ComplexArray, FloatArray, IndexArray
from camopt.scene.machine import Body, Station

TINY = 1e-300  # mm: keeps the quotients of points finite
MOST_PAIRS_AT_ONCE = 200_000  # pairs of edges and lifts, for the memory that they take


class ChordTree(NamedTuple):
    """Chords of an outline by their numbers; number 0 covers all of it."""

    start: ComplexArray
    end: ComplexArray
    cover: (
        FloatArray  # largest distance from the chord to a point of the outline that it covers [mm]; 0 for an edge
    )
    speed: FloatArray  # largest way of a point that the chord covers, for a lift of one unit [mm]
    children: IndexArray  # the two chords of the halves (chords, 2); those of an edge are the edge itself


@dataclass(frozen=True, eq=False)
class MovingOutline:
    """The outline of a tool that slides or turns, or of a body that stays."""

    points: ComplexArray  # points of the outline at the lift 0 [mm]
    radius: float  # radius that rounds the outline [mm]
    direction: complex = 0.0  # way of a sliding tool for a lift of 1 mm
    pivot: complex = 0.0  # point about which a turning tool turns [mm]
    turn: float = 0.0  # angle by which a turning tool turns counterclockwise for a lift of 1 deg [rad]

    @classmethod
    def from_table(cls, table: Station | Body) -> Self:
        """The outline of a station or of a fixed body."""
        assert table.outline is not None
        points, radius = np.array([complex(*point) for point in table.outline]), table.outline_radius
        if isinstance(table, Body):
            return cls(points, radius)
        if table.pivot is None:
            angle = radians(table.direction or 0.0)
            return cls(points, radius, direction=complex(np.cos(angle), np.sin(angle)))
        sense = 1.0 if table.sense == "ccw" else -1.0
        return cls(points, radius, pivot=complex(*table.pivot), turn=sense * radians(1.0))

    def moved_points(self, points: ComplexArray, lifts: FloatArray) -> ComplexArray:
        """Where points of the outline are at lifts."""
        turned = self.pivot + (points - self.pivot) * np.exp(1j * self.turn * lifts) if self.turn else points
        return np.asarray(turned + self.direction * lifts)

    def velocities_by_lift(self, moved_points: ComplexArray) -> ComplexArray:
        """Velocities of moved points by the lift."""
        return self.direction + 1j * self.turn * (moved_points - self.pivot)

    @cached_property
    def edges(self) -> tuple[ComplexArray, ComplexArray]:
        """Starts and ends of the edges; a point is one edge of length 0."""
        closed = np.append(self.points, self.points[0]) if len(self.points) > 2 else self.points
        return (closed[:-1], closed[1:]) if len(closed) > 1 else (closed, closed)

    @cached_property
    def chord_tree(self) -> ChordTree:
        """The chords that cover the outline, each cut in the middle of its points."""
        starts, ends = self.edges
        points = np.append(starts, ends[-1])
        ranges, children = [(0, len(points) - 1)], list[tuple[int, int]]()
        cover, speed = list[float](), list[float]()
        for number, (first, last) in enumerate(ranges):
            part, is_edge = points[first : last + 1], last - first == 1
            offsets = offsets_from_segments(part, points[first], points[last])
            cover.append(0.0 if is_edge else float(np.abs(offsets).max()))
            speed.append(float(np.abs(self.velocities_by_lift(part)).max()))
            children.append((number, number) if is_edge else (len(ranges), len(ranges) + 1))
            if not is_edge:
                middle = (first + last) // 2
                ranges += [(first, middle), (middle, last)]
        first_points, last_points = np.array(ranges).T
        return ChordTree(
            points[first_points], points[last_points], np.array(cover), np.array(speed), np.array(children)
        )

    def contains(self, points: ComplexArray, lifts: FloatArray) -> BoolArray:
        """Whether each point is inside of the polygon at its lift, by the polygon's winding about it."""
        if len(self.points) < 3:
            return np.zeros(points.shape, dtype=bool)
        around = self.moved_points(self.points[:, None], lifts) - points
        return np.asarray(np.abs(np.angle(np.roll(around, -1, axis=0) * around.conj()).sum(axis=0)) > np.pi)


def offsets_from_segments(points: ComplexArray, start: ComplexArray, end: ComplexArray) -> ComplexArray:
    """Vectors from the nearest points of segments to points."""
    along = end - start
    share = ((points - start) * along.conj()).real / np.maximum((along * along.conj()).real, TINY)
    return np.asarray(points - start - np.clip(share, 0.0, 1.0) * along)


def offsets_between_segments(
    first_start: ComplexArray, first_end: ComplexArray, second_start: ComplexArray, second_end: ComplexArray
) -> ComplexArray:
    """Vectors from the nearest points of segments cd to those of segments ab; 0 where the segments cross."""
    offset = offsets_from_segments(first_start, second_start, second_end)
    for other in (
        offsets_from_segments(first_end, second_start, second_end),
        -offsets_from_segments(second_start, first_start, first_end),
        -offsets_from_segments(second_end, first_start, first_end),
    ):
        offset = np.where(np.abs(other) < np.abs(offset), other, offset)
    first, second = (first_end - first_start).conj(), (second_end - second_start).conj()
    crosses = (first * (second_start - first_start)).imag * (first * (second_end - first_start)).imag < 0.0
    crosses &= (second * (first_start - second_start)).imag * (second * (first_end - second_start)).imag < 0.0
    return np.where(crosses, 0.0, offset)


def outline_distances(
    first: MovingOutline, second: MovingOutline, first_lifts: FloatArray, second_lifts: FloatArray
) -> FloatArray:
    """Distances of two outlines at lifts (N,) [mm]; 0 where they overlap or one is inside of the other."""
    (a, b), (c, d) = first.edges, second.edges
    result = np.empty(len(first_lifts))
    step = max(MOST_PAIRS_AT_ONCE // (len(a) * len(c)), 1)
    for begin in range(0, len(result), step):
        one, two = first_lifts[begin : begin + step], second_lifts[begin : begin + step]
        starts, ends = (first.moved_points(each[:, None, None], one) for each in (a, b))
        other_starts, other_ends = (second.moved_points(each[:, None], two) for each in (c, d))
        gaps = [
            np.abs(offsets_between_segments(*edge, other_starts, other_ends)).min(axis=0)
            for edge in zip(starts, ends, strict=True)
        ]
        gap = np.min(gaps, axis=0)
        inside = second.contains(starts[0, 0], two) | first.contains(other_starts[0], one)
        result[begin : begin + step] = np.where(inside, 0.0, np.maximum(gap - first.radius - second.radius, 0.0))
    return result
