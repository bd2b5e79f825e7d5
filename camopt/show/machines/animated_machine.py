"""The figure of an animated machine: all cams turning side by side, and a cursor in the timing diagram.

The outlines of tools move in a panel of their own.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from math import ceil
from typing import Any, NamedTuple

import numpy as np
from shapely import LineString, Point, Polygon

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.core.quantities.unit_systems import INCH_MM, to_shown_unit, unit_in_shown_system
from camopt.scene.machine import Machine
from camopt.show.drawing.animated_figure import draw_mechanism_bodies
from camopt.show.drawing.cam import frame_with_scale_bar
from camopt.show.drawing.moving_bodies import (
    FRAME_ANGLES,
    AnimatedFigure,
    MovingBody,
    Reading,
    disable_axes_clipping,
    reading_texts,
)
from camopt.show.drawing.picture import Picture, draw_line, fill_area, four_digit_text
from camopt.show.drawing.style import BODY, INK, MUTED, SMALL_SIZE, new_figure, series_line_style
from camopt.show.machines.timing_diagram import (
    CLEARANCE_HEIGHT,
    READING_WIDTH,
    TEXT,
    TimingDiagram,
    draw_words,
)
from camopt.show.machines.timing_spans import TimingData, phase_and_ratio_text
from camopt.show.sheet.marks import MarkBox, add_paper_axes, fitted_lines_and_height
from camopt.solve.machine.evaluation import MachineEvaluation
from camopt.solve.machine.stations import ResolvedStation

WIDTH, EDGE = 304.8, 5.0  # mm: width of the figure, and its edge
HEAD, CAPTION = 14.0, 12.0  # mm: heights of the title, and of the caption of a cam
ROW, SCALES, TORQUE = 14.0, 20.0, 36.0  # mm: heights in the timing diagram
PIXELS = 2.54  # mm: the height is a multiple, since videos have even numbers of pixels
MOST_COLUMNS, LARGEST_CAM = 6, 90.0  # cams beside each other, and mm


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


@contextmanager
def animated_machine_figure(what: Machine | MachineEvaluation) -> Iterator[AnimatedFigure]:
    """The figure of a machine, drawn at angle 0 of its shaft, with its moving parts."""
    data = TimingData.from_machine(what)
    machine = data.machine
    tools = machine_tools(machine, data.stations)
    count = len(data.stations) + bool(tools)
    columns = ceil(count / ceil(count / MOST_COLUMNS))
    side = (WIDTH - 2 * EDGE) / columns
    cell = min(side, LARGEST_CAM) + CAPTION
    below = timing_height(data)
    height = ceil((HEAD + ceil(count / columns) * cell + below + EDGE) / PIXELS) * PIXELS
    with new_figure(None, (WIDTH / INCH_MM, height / INCH_MM)) as figure:
        axes = add_paper_axes(figure, WIDTH, height)
        draw_words(axes, EDGE, height - EDGE, machine.name, 3.5, va="top", fontweight="bold")
        if machine.shaft_rpm is not None:
            words = f"{four_digit_text(machine.shaft_rpm)} rev/min"
            draw_words(axes, WIDTH - EDGE, height - EDGE, words, TEXT, va="top", ha="right", color=MUTED)
        bodies = list[MovingBody]()
        for place in range(count):
            row, column = divmod(place, columns)
            corner = complex(EDGE + column * side, height - HEAD - (row + 1) * cell)
            box = MarkBox(corner, corner + complex(0.94 * side, cell - CAPTION))
            if place < len(data.stations):
                station = data.stations[place]
                _draw_caption(axes, box, station.name, phase_and_ratio_text(station))
                bodies += _draw_station(figure, box, height, station)
            else:
                _draw_caption(axes, box, "Tools", "")
                bodies += _draw_tools(figure, box, height, tools)
        box = MarkBox(complex(EDGE, EDGE), complex(WIDTH - EDGE, EDGE + below))
        diagram = TimingDiagram(data, box, READING_WIDTH)
        diagram.draw(axes)
        cursors, readings = _draw_cursors(figure, axes, diagram)
        yield AnimatedFigure(figure, [*bodies, *cursors], readings)


def timing_height(data: TimingData) -> float:
    """The height of the timing diagram below cams, or on a page [mm]."""
    clearances = len(data.clearances) * CLEARANCE_HEIGHT
    return ROW * len(data.stations) + SCALES + clearances + (TORQUE if data.total_torque else 0.0)


def cam_angles(station: ResolvedStation, shaft_angles: FloatArray) -> FloatArray:
    """The angles of a station's cam at angles of the shaft, which begin at 0 [rad]; the first is from −π to π."""
    ratio = station.station.ratio
    first = (np.pi - ratio * np.radians(station.station.phase)) % (2 * np.pi) - np.pi
    return np.asarray(first + ratio * shaft_angles)


def _draw_caption(axes: Any, box: MarkBox, name: str, subtitle: str) -> None:
    lines, size = fitted_lines_and_height(name, 0.88 * box.size.real, 3, (2.2, 1.9, 1.6))
    level = box.high.imag + CAPTION - 1.0
    for text in lines:
        level -= 1.4 * size
        draw_words(axes, box.low.real, level, text, size, fontweight="bold")
    if len(lines) < 3:
        draw_words(axes, box.low.real, level - 1.7 * TEXT, subtitle, 1.7, color=MUTED)


def _draw_station(figure: Any, box: MarkBox, height: float, station: ResolvedStation) -> list[MovingBody]:
    """Draw the cam of a station at cam angle 0; return its parts with their motion by the angle of the shaft."""
    angles = np.concatenate([[0.0], cam_angles(station, FRAME_ANGLES)])
    bodies = draw_mechanism_bodies(
        figure, Picture(station.scene, station.problem), _mm_box_in_figure_shares(box, height), angles
    )
    for text in [text for body in bodies for text in body.axes.texts if text.get_rotation()]:
        text.remove()  # upright words have no room
    return [
        body._replace(path=body.path[1:], angles=body.angles[1:], drawn_at=complex(body.path[0])) for body in bodies
    ]


def _mm_box_in_figure_shares(box: MarkBox, figure_height: float) -> tuple[float, float, float, float]:
    """A box [mm] in shares of the figure."""
    size = box.size
    return box.low.real / WIDTH, box.low.imag / figure_height, size.real / WIDTH, size.imag / figure_height


def _draw_tools(figure: Any, box: MarkBox, height: float, tools: list[Tool]) -> list[MovingBody]:
    """Draw the outlines of tools and fixed bodies; return the tools with their motion."""
    area = _mm_box_in_figure_shares(box, height)
    ground = figure.add_axes(area)
    bodies, reach = [], list[Any]()
    for tool in tools:
        axes = figure.add_axes(area)
        fill_area(axes, tool.outline, facecolor=BODY, edgecolor=tool.colour, lw=1.3)
        path, rotation = tool.path(FRAME_ANGLES), tool.rotation(FRAME_ANGLES)
        bodies.append(MovingBody(axes, path, rotation, drawn_at=tool.origin))
        reach.append(bodies[-1].positions(tool.outline).ravel())
    frame_with_scale_bar(ground, np.concatenate(reach))
    for number, (body, tool) in enumerate(zip(bodies, tools, strict=True)):
        body.axes.set(xlim=ground.get_xlim(), ylim=ground.get_ylim(), aspect="equal")
        body.axes.set_axis_off()
        style = {"transform": ground.transAxes, "color": tool.colour, "fontsize": SMALL_SIZE, "ha": "right"}
        ground.text(1.0, 1.0 - 0.07 * number, tool.name, va="top", **style)
    return disable_axes_clipping(bodies)


def _draw_cursors(figure: Any, axes: Any, diagram: TimingDiagram) -> tuple[list[MovingBody], list[Reading]]:
    """The cursor of the timing diagram, a dot on each curve, and readings of angle and lifts."""
    width, height = axes.get_xlim()[1], axes.get_ylim()[1]
    along = diagram.x(np.degrees(FRAME_ANGLES))
    line = add_paper_axes(figure, width, height)
    draw_line(line, 1j * np.array([diagram.bottom, diagram.top]) + along[0], color=INK, lw=1.0)
    bodies = [MovingBody(line, along + 0j)]
    right, style = diagram.box.high.real, dict[str, Any](ha="right", fontweight="bold")
    angles = [f"{angle:.1f}°" for angle in np.degrees(FRAME_ANGLES)]
    readings = [Reading(draw_words(axes, right, diagram.top + 2.9, angles[0], TEXT, **style), angles)]
    for number, (station, row) in enumerate(
        zip(diagram.data.stations, diagram.station_clearance_and_torque_rows[0], strict=True)
    ):
        lift = station.lift.value(FRAME_ANGLES)
        places = along + 1j * diagram.lift_levels(number, lift)
        dot = add_paper_axes(figure, width, height)
        draw_line(dot, places[:1], marker="o", ms=4.5, color=INK, mec="white")
        bodies.append(MovingBody(dot, places))
        unit = unit_in_shown_system(station.unit)
        words = [f"{text} {unit}" for text in reading_texts(to_shown_unit(lift, station.unit))]
        readings.append(Reading(draw_words(axes, right, (row.low + row.high - TEXT) / 2, words[0], **style), words))
    return disable_axes_clipping(bodies), readings


def machine_tools(machine: Machine, stations: tuple[ResolvedStation, ...]) -> list[Tool]:
    """The tools that have outlines, and the fixed bodies; empty if no tool has an outline."""
    tools = [
        Tool(
            each.name,
            rounded_outline(points, each.station.outline_radius),
            each,
            series_line_style(number)["color"],
        )
        for number, each in enumerate(stations)
        if (points := each.station.outline) is not None
    ]
    bodies = [Tool(body.name, rounded_outline(body.outline, body.outline_radius)) for body in machine.body]
    return [*tools, *bodies] if tools else []


def rounded_outline(points: tuple[tuple[float, float], ...], radius: float) -> ComplexArray:
    """The closed outline of a point, a line or a polygon, rounded outward by a radius."""
    if radius > 0.0:
        shape = Point(*points) if len(points) == 1 else LineString(points) if len(points) == 2 else Polygon(points)
        points = tuple(shape.buffer(radius).exterior.coords)
    return np.array([complex(*point) for point in (*points, points[0])])
