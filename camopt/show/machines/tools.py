"""Tools with outlines, and fixed bodies, in the plane of the machine [mm]."""

from typing import NamedTuple

import numpy as np
from shapely import LineString, Point, Polygon

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.scene.machine import Machine
from camopt.show.drawing.style import INK, series_line_style
from camopt.solve.machine.stations import ResolvedStation


class Tool(NamedTuple):
    """An outline that moves with a station, or stands still."""

    name: str
    outline: ComplexArray
    """Points of the outline, where the tool is lowest."""
    station: ResolvedStation | None = None
    """The station that moves it; None for a fixed body."""
    colour: str = INK
    """That of the torque of its station."""

    @property
    def origin(self) -> complex:
        """The point about which the tool turns; 0 for a tool that slides."""
        pivot = self.station.station.pivot if self.station else None
        return 0j if pivot is None else complex(*pivot)

    def path(self, shaft_angles: FloatArray) -> ComplexArray:
        """Positions of the origin at angles of the shaft [rad]."""
        if self.station is None or self.station.tool_turns:
            return np.full(len(shaft_angles), self.origin)
        direction = np.exp(1j * np.radians(self.station.station.direction or 0.0))
        return np.asarray(self.station.lift.value(shaft_angles) * direction)

    def rotation(self, shaft_angles: FloatArray) -> FloatArray:
        """Rotation of the tool at angles of the shaft [rad]."""
        if self.station is None or not self.station.tool_turns:
            return np.zeros(len(shaft_angles))
        sense = -1.0 if self.station.station.sense == "cw" else 1.0
        return np.asarray(sense * np.radians(self.station.lift.value(shaft_angles)))


def machine_tools(machine: Machine, stations: tuple[ResolvedStation, ...]) -> list[Tool]:
    """The tools that have outlines, and the fixed bodies; empty if no tool has an outline."""
    tools = []
    for number, each in enumerate(stations):
        if (points := each.station.outline) is not None:
            outline = rounded_outline(points, each.station.outline_radius)
            tools.append(Tool(each.name, outline, each, series_line_style(number)["color"]))
    bodies = [Tool(body.name, rounded_outline(body.outline, body.outline_radius)) for body in machine.body]
    return [*tools, *bodies] if tools else []


def rounded_outline(points: tuple[tuple[float, float], ...], radius: float) -> ComplexArray:
    """The closed outline of a point, a line or a polygon, rounded outward by a radius."""
    if radius > 0.0:
        shape = Point(*points) if len(points) == 1 else LineString(points) if len(points) == 2 else Polygon(points)
        points = tuple(shape.buffer(radius).exterior.coords)
    return np.array([complex(*point) for point in (*points, points[0])])
