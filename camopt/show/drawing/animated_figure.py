"""The figure of an animation: the cam turning under its follower, to scale, beside diagrams with cursors.

A disc cam turns in its sense of rotation. For a cylindrical cam, the developed surface moves past the follower.
"""

from math import ceil
from typing import Any

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.scene.problem.linkage import follower_pivot, outward_turn_sense_of_follower
from camopt.show.drawing import diagrams
from camopt.show.drawing.cam import (
    CROSS_POINTS,
    draw_cam_body,
    draw_shaft_and_centre_mark,
    draw_stroke_starts,
    frame_with_scale_bar,
    largest_body_radius,
)
from camopt.show.drawing.figures import TEXT_SEPARATOR, mechanism_and_sizes_line
from camopt.show.drawing.follower import FollowerAxes, draw_follower
from camopt.show.drawing.groove import draw_groove_follower, draw_groove_or_rib, drawn_cylinder_ends, surface_colour
from camopt.show.drawing.labels import place_labels
from camopt.show.drawing.linkage import draw_fixed_parts, draw_member, sketch_extent_over_turn, train_sketch
from camopt.show.drawing.moving_bodies import (
    FRAME_ANGLES,
    AnimatedFigure,
    MovingBody,
    Reading,
    disable_axes_clipping,
    reading_texts,
)
from camopt.show.drawing.panels import motion_panels
from camopt.show.drawing.picture import Picture, draw_circle, draw_line, fill_area
from camopt.show.drawing.second_contact import draw_second_contact, draw_second_disc_outline
from camopt.show.drawing.style import FAINT, INK, MUTED, SMALL_SIZE, TEXT_SIZE, TITLE_SIZE

SHOWN_PANELS = (0, 2, 4)  # displacement, acceleration, pressure angle, of the six diagrams of a design
DISC_SIZE, GROOVE_SIZE = (9.0, 5.4), (9.0, 6.0)  # inches
CAM_AREA, PANEL_AREAS = (0.02, 0.05, 0.47, 0.82), [(0.57, 0.69 - 0.285 * k, 0.4, 0.165) for k in range(3)]
GROOVE_AREA, AREAS_BELOW = (0.03, 0.42, 0.94, 0.42), [(0.06 + 0.32 * k, 0.1, 0.26, 0.2) for k in range(3)]
"""Boxes in shares of the figure: left, bottom, width, height."""
Area = tuple[float, float, float, float]
DRAWN_TURNS = (-np.pi, 3 * np.pi)  # rad: cam angles whose window is on the drawn surface of a cylinder
LINE_LETTERS = 140  # letters that fit on a line below the title


def draw_animated_figure(figure: Any, picture: Picture) -> AnimatedFigure:
    """Draw a design at cam angle 0 on an empty figure; return the figure with its moving parts."""
    name = picture.scene.name
    figure.text(0.03, 0.955, name if len(name) <= 70 else f"{name[:69]}…", fontsize=TITLE_SIZE, fontweight="bold")
    words = mechanism_and_sizes_line(picture)
    parts = words.split(TEXT_SEPARATOR)
    middle = ceil(len(parts) / 2) if len(words) > LINE_LETTERS else len(parts)
    lines = "\n".join(TEXT_SEPARATOR.join(line) for line in (parts[:middle], parts[middle:]) if line)
    figure.text(0.03, 0.935, lines, fontsize=SMALL_SIZE, color=MUTED, va="top")
    bodies = draw_mechanism_bodies(figure, picture, GROOVE_AREA if picture.is_developed else CAM_AREA)
    cursors, readings = _draw_diagram_cursors(figure, picture, AREAS_BELOW if picture.is_developed else PANEL_AREAS)
    for body in cursors:
        body.axes.set_axis_off()
    return AnimatedFigure(figure, [*bodies, *cursors], readings)


def draw_mechanism_bodies(
    figure: Any, picture: Picture, area: Area, angles: FloatArray = FRAME_ANGLES
) -> list[MovingBody]:
    """Draw a mechanism at cam angle 0 in an area of a figure; return its parts with their motion.

    The motion is given at cam angles [rad]: the first is 0, and they go through a whole turn.
    """
    bodies = (_draw_groove_bodies if picture.is_developed else _draw_disc_bodies)(figure, picture, area, angles)
    for body in bodies:
        body.axes.set_axis_off()
    return disable_axes_clipping(bodies)


def _draw_disc_bodies(figure: Any, picture: Picture, area: Area, angles: FloatArray) -> list[MovingBody]:
    problem, size = picture.problem, picture.largest_pitch_radius
    ground, cam, follower, contact = (figure.add_axes(area) for _ in range(4))
    draw_cam_body(cam, picture)
    draw_second_disc_outline(cam, picture)
    draw_circle(cam, float(problem.design.size[0]), color=MUTED, lw=0.8, zorder=2.5)
    draw_shaft_and_centre_mark(cam, picture, size)
    draw_stroke_starts(cam, picture)  # without its labels, which would turn upside down
    spans = [
        *draw_follower(FollowerAxes(follower, ground, contact), picture.contacts[0], size),
        *draw_second_contact(follower, picture),
    ]
    (body, *links), reached = _follower_and_train_bodies(follower, ground, picture, spans, angles)
    disc = max(size, largest_body_radius(picture)) * CROSS_POINTS
    frame_with_scale_bar(ground, np.concatenate([disc, reached]))
    for axes in (cam, follower, contact, *(link.axes for link in links)):
        axes.set(xlim=ground.get_xlim(), ylim=ground.get_ylim(), aspect="equal")
    turning = MovingBody(cam, 0j * angles, problem.design.sense * angles)
    travel = problem.setup.mechanism.trace_and_normal(problem.design, problem.programme, angles % (2 * np.pi))
    touched = travel.trace - problem.design.roller_radius[0] * travel.normal
    return [turning, body, MovingBody(contact, touched - touched[0], 0.0 * angles), *links]


def _draw_groove_bodies(figure: Any, picture: Picture, area: Area, angles: FloatArray) -> list[MovingBody]:
    """The groove in a window of one turn, with the follower in its middle."""
    size, (low, high) = float(picture.problem.design.size[0]), drawn_cylinder_ends(picture)
    half, around = np.pi * size, 2 * np.pi * size
    surface, ground, follower = (figure.add_axes(area) for _ in range(3))
    spans = draw_groove_follower(FollowerAxes(follower, ground, ground), picture)
    (body, *links), reached = _follower_and_train_bodies(follower, ground, picture, spans, angles)
    window = np.array([-half + 1j * low, half + 1j * high])
    corner, unit = frame_with_scale_bar(ground, np.concatenate([window, reached]))
    for axes in (follower, *(link.axes for link in links)):
        axes.set(xlim=ground.get_xlim(), ylim=ground.get_ylim())
    draw_line(ground, _rectangle_corners(-half, half, low, high), color=INK, lw=1.0)
    (left, width), (bottom, height) = (
        ((values[0] - start) / unit / inches, np.ptp(values) / unit / inches)
        for values, start, inches in zip(
            (window.real, window.imag), (corner.real, corner.imag), figure.get_size_inches(), strict=True
        )
    )
    surface.set_position((area[0] + left, area[1] + bottom, width, height))
    surface.set(xlim=(-half, half), ylim=(low, high))
    fill_area(
        surface,
        _rectangle_corners(-around, 2 * around, low, high),
        facecolor=surface_colour(picture),
        lw=0,
        zorder=1,
    )
    draw_groove_or_rib(surface, picture, around)
    for stroke in picture.problem.programme.strokes:
        for turn in (-around, 0.0, around):
            ends = size * stroke.start + turn + 1j * np.array([low, high])
            draw_line(surface, ends, color=FAINT, lw=0.7, zorder=1.5)
    if angles.max() > DRAWN_TURNS[1] or angles.min() < DRAWN_TURNS[0]:
        angles = (angles - DRAWN_TURNS[0]) % (2 * np.pi) + DRAWN_TURNS[0]
    moving = MovingBody(surface, -size * angles + 0j, 0.0 * angles, windowed=True)
    return [moving, MovingBody(ground, 0j * angles, 0.0 * angles), body, *links]


def _follower_and_train_bodies(
    follower_axes: Any, ground_axes: Any, picture: Picture, drawn_extent: list[ComplexArray], angles: FloatArray
) -> tuple[list[MovingBody], ComplexArray]:
    """The follower, then the members of its train (drawn on their own axes), and the points that they reach.

    The follower moves along its guide or about its pivot. The members are above the fixed parts.
    """
    problem = picture.problem
    rise = problem.programme.motion_at(angles % (2 * np.pi))[0] - picture.start_displacement
    bodies = [MovingBody(follower_axes, 1j * rise, 0.0 * angles)]
    if problem.setup.angular:
        turns = outward_turn_sense_of_follower(problem) * rise
        bodies = [MovingBody(follower_axes, 0.0 * angles + follower_pivot(problem), turns)]
    reached = [bodies[0].positions(span).ravel() for span in drawn_extent]
    size = float(problem.design.size[0]) if picture.is_developed else picture.largest_pitch_radius
    if (train := train_sketch(picture, drawn_extent, size, angles)) is not None:
        draw_fixed_parts(ground_axes, train, size)
        for member in train.members:
            axes = ground_axes.figure.add_axes(ground_axes.get_position())
            draw_member(axes, member, size)
            bodies.append(MovingBody(axes, member.at, member.turned))
        reached.append(sketch_extent_over_turn(train))
    return bodies, np.concatenate(reached)


def _rectangle_corners(left: float, right: float, low: float, high: float) -> list[complex]:
    return [complex(x, y) for x, y in ((left, low), (right, low), (right, high), (left, high), (left, low))]


def _draw_diagram_cursors(figure: Any, picture: Picture, boxes: Any) -> tuple[list[MovingBody], list[Reading]]:
    """Cursors of the diagrams (a line and a dot each), their readings, and the reading of the cam angle."""
    panels = [panel.in_shown_units() for panel in motion_panels(picture)]
    shown, axes_of_panels = [panels[k] for k in SHOWN_PANELS], [figure.add_axes(box) for box in boxes]
    labels = diagrams.draw_diagrams(axes_of_panels, picture, shown, (), range(len(shown)))
    bodies: list[MovingBody] = []
    degrees = np.degrees(FRAME_ANGLES)
    style = {"ha": "right", "fontsize": TEXT_SIZE, "color": INK}
    words = [f"cam angle {angle:.1f}°" for angle in degrees]
    readings = [Reading(figure.text(boxes[-1][0] + boxes[-1][2], 0.02, words[0], **style), words)]
    for axes, panel in zip(axes_of_panels, shown, strict=True):
        axes.set(xticks=range(0, 361, 90))
        axes.set_title("", loc="right")
        assert panel.value_at is not None
        factor, _ = diagrams.short_number_factor_and_unit(panel.values, panel.unit)
        values = panel.value_at(FRAME_ANGLES % (2 * np.pi)) * factor
        line_axes, dot_axes = (figure.add_axes(axes.get_position()) for _ in range(2))
        for each in (line_axes, dot_axes):
            each.set(xlim=axes.get_xlim(), ylim=axes.get_ylim())
        draw_line(line_axes, 1j * np.array(axes.get_ylim()), color=INK, lw=0.8, clip_on=False)
        draw_line(dot_axes, [1j * values[0]], marker="o", ms=5, color=INK, mec="white", clip_on=False)
        words = reading_texts(values)
        text = axes.text(1.0, 1.03, words[0], fontweight="bold", va="bottom", transform=axes.transAxes, **style)
        readings.append(Reading(text, words))
        bodies += [MovingBody(line_axes, degrees + 0j), MovingBody(dot_axes, degrees + 1j * (values - values[0]))]
    place_labels(figure, labels)
    return bodies, readings
