"""A disc cam with its follower drawn to scale, at cam angle 0."""

from typing import Any

import numpy as np
import scipy
from shapely import LinearRing, Point, Polygon, make_valid

from camopt.core.numerics import ComplexArray
from camopt.core.quantities.unit_systems import from_shown_unit, to_shown_unit, unit_in_shown_system
from camopt.model.mechanisms.geometry import CamCurves, cam_curves
from camopt.model.motion.stroke import DWELL
from camopt.show.drawing.follower import FollowerAxes, draw_follower
from camopt.show.drawing.labels import Label, label_place_candidates
from camopt.show.drawing.linkage import draw_linkage
from camopt.show.drawing.picture import (
    STROKE_NAMES,
    Picture,
    draw_circle,
    draw_line,
    fill_area,
    fit_axes,
    four_digit_length_text,
    round_down_to_1_2_5,
)
from camopt.show.drawing.second_contact import draw_second_contact, draw_second_disc_outline, second_disc_outline
from camopt.show.drawing.style import (
    COLOURS,
    FAINT,
    FILL,
    INK,
    MUTED,
    PITCH_COLOUR,
    PROFILE_WIDTH,
    REFERENCE_COLOUR,
    SMALL_SIZE,
    TEXT_SIZE,
    TITLE_SIZE,
)

START_LABEL_DISTANCES = (7.0, 16.0, 28.0)  # points from the start of a stroke to its cam angle
ROTATION_LABEL_DISTANCES = (5.0, 8.0, 12.0, 16.0, 22.0, 30.0)  # points from the arrow to ω
CROSS_POINTS = np.array([1, 1j, -1, -1j])
BODY_MARGIN = 0.08  # share of the radius of a groove: drawn beside it if the diameter of the disc is unknown
INVISIBLE_OFFSET = 1e-4  # share of the cam: a smaller offset is not drawn


def draw_disc(axes: Any, picture: Picture) -> list[Label]:
    """Draw a disc cam at cam angle 0 with its follower; return the labels to place."""
    whole, picture = picture, picture.contacts[0]
    pitch = np.concatenate([c.pitch for c in picture.curves])
    size = float(np.abs(pitch).max())
    draw_cam_body(axes, whole)
    draw_second_disc_outline(axes, whole)
    labels = [*draw_stroke_starts(axes, picture), draw_rotation_arrow(axes, picture)]
    spans = draw_follower(FollowerAxes(axes, axes, axes), picture, size)
    extent = [
        *draw_second_contact(axes, whole),
        second_disc_outline(whole),
        pitch,
        largest_body_radius(picture) * CROSS_POINTS,
        *_draw_reference_circles(axes, whole, pitch, size),
        *spans,
        *draw_linkage(axes, picture, spans, size),
    ]
    frame_with_scale_bar(axes, np.concatenate(extent))
    return labels


def roller_arc_at_corner(before: CamCurves, after: CamCurves, radius: float) -> ComplexArray:
    """The arc of the roller at a corner of the pitch curve, where the normal jumps."""
    turn = np.angle(after.normal[0] / before.normal[-1])
    steps = np.linspace(0.0, turn, max(2, int(abs(np.degrees(turn)))))
    return np.asarray(after.pitch[0] - radius * before.normal[-1] * np.exp(1j * steps))


def draw_cam_body(axes: Any, picture: Picture) -> None:
    """Draw the body with its profile, groove or rib, coloured by stroke, without parts cut away by undercutting."""
    _fill_body(axes, picture)
    labelled = set[Any]()
    for contact in picture.first_disc_contacts:
        radius = float(contact.problem.design.roller_radius[0])
        thin = {"lw": 0.9, "alpha": 0.9} if contact.undercut else {"lw": 2.2}
        for place, (kind, curves) in enumerate(zip(contact.stroke_kind_of_each_piece, contact.curves, strict=True)):
            for flank, wall in zip(contact.problem.setup.mechanism.flanks, curves.profile, strict=True):
                label = f"profile, {STROKE_NAMES[kind]}" if kind not in labelled else None
                draw_line(axes, wall, color=COLOURS[kind], label=label, zorder=4, solid_capstyle="round", **thin)
                corner = roller_arc_at_corner(contact.curves[place - 1], curves, -flank.side * radius)
                draw_line(axes, corner, color=COLOURS[DWELL], zorder=3.9, **thin)
                labelled.add(kind)
        if radius > 0.0:
            pitch = np.concatenate([c.pitch for c in contact.curves])
            style = {"color": PITCH_COLOUR, "lw": 1.0, "ls": (0, (9, 2.5, 1.5, 2.5)), "zorder": 3}
            label = None if "pitch curve" in labelled else "pitch curve"
            draw_line(axes, np.append(pitch, pitch[0]), label=label, **style)
            labelled.add(label)


def _fill_body(axes: Any, picture: Picture) -> None:
    """Fill the inside of the profile, or a disc without the groove that a roller sweeps in it, or with its rib.

    The edge of a disc is drawn if its diameter is known.
    """
    mechanism, first = picture.problem.setup.mechanism, picture.contacts[0]
    if mechanism.body.bounded:
        edge = {"edgecolor": INK, "label": "cam after undercutting"} if first.undercut else {"edgecolor": "none"}
        profile = np.concatenate([c.profile[0] for c in first.curves])
        solid = outline_left_by_undercutting(first) if first.undercut else profile
        fill_area(axes, solid, facecolor=FILL, lw=1.4, zorder=1, **edge)
        return
    disc = largest_body_radius(first) * np.exp(1j * np.linspace(0.0, 2 * np.pi, 721))
    colour = INK if first.problem.setup.solid.outer_diameter is not None else "none"
    fill_area(axes, disc, facecolor="white" if mechanism.has_rib else FILL, edgecolor=colour, lw=1.0, zorder=1)
    if mechanism.has_rib:
        outer, inner = (np.concatenate([c.profile[0] for c in each.curves]) for each in picture.contacts)
        rib = np.concatenate([outer, outer[:1], inner[:1], inner[::-1]])
        fill_area(axes, rib, facecolor=FILL, lw=0.0, zorder=1.5)
        return
    pitch = np.concatenate([c.pitch for c in first.curves])
    swept = LinearRing(np.column_stack([pitch.real, pitch.imag]))
    swept = swept.buffer(float(first.problem.design.roller_radius[0]), quad_segs=64)
    style = {"edgecolor": INK if first.undercut else "none", "lw": 1.0, "zorder": 1.5}
    for colour, ring in [("white", swept.exterior), *((FILL, hole) for hole in swept.interiors)]:
        axes.fill(*np.asarray(ring.coords).T, facecolor=colour, **style)


def largest_body_radius(picture: Picture) -> float:
    """Largest radius of the body of a disc cam [mm]; if it is unknown, of the part that is drawn."""
    mechanism, solid = picture.problem.setup.mechanism, picture.problem.setup.solid
    reach = float(max(np.abs(c.profile).max() for c in picture.curves))
    return reach if mechanism.body.bounded else (solid.outer_diameter or 0.0) / 2 or reach * (1.0 + BODY_MARGIN)


def outline_left_by_undercutting(picture: Picture) -> ComplexArray:
    """The outline of an undercut cam: the region that no position of the follower covers."""
    pitch = np.concatenate([c.pitch for c in picture.curves])
    if picture.problem.setup.mechanism.flat_faced:
        normal = np.concatenate([c.normal for c in picture.curves])
        support = (pitch * normal.conj()).real
        corners = scipy.spatial.HalfspaceIntersection(
            np.column_stack([normal.real, normal.imag, -support]), np.zeros(2)
        ).intersections
        outline = corners[:, 0] + 1j * corners[:, 1]
        return np.asarray(outline[np.argsort(np.angle(outline))])
    cut = make_valid(Polygon(np.column_stack([pitch.real, pitch.imag])))
    cut = cut.buffer(-float(picture.problem.design.roller_radius[0]), quad_segs=64)
    parts = [part for part in getattr(cut, "geoms", [cut]) if not part.is_empty]
    if not parts:
        return np.zeros(1, dtype=complex)
    x, y = np.asarray(min(parts, key=lambda part: part.distance(Point(0, 0))).exterior.coords.xy)
    return np.asarray(x + 1j * y)


def _draw_reference_circles(axes: Any, picture: Picture, pitch: ComplexArray, size: float) -> list[ComplexArray]:
    """Draw base, prime, pitch, offset and shaft circles, the centre and the follower's axis; return their extent.

    The pitch circle is that of the contact with the largest pressure angle.
    """
    steepest, picture = picture.steepest_contact, picture.contacts[0]
    problem = picture.problem
    mechanism = problem.setup.mechanism
    spans, lowest = [], float(pitch.imag.min()) if mechanism.body.bounded else -largest_body_radius(picture)
    base, radius = float(problem.design.size[0]), float(problem.design.roller_radius[0])
    thin = {"lw": 0.8, "zorder": 2.5}
    draw_circle(axes, base, color=MUTED, label=f"base circle, R {four_digit_length_text(base)}", **thin)
    if radius > 0.0:
        label = f"prime circle, R {four_digit_length_text(base + radius)}"
        draw_circle(axes, base + radius, color=MUTED, ls=(0, (5, 3)), label=label, **thin)
    if not mechanism.flat_faced:
        through = steepest.quantity_values["pitch_circle_radius_mm"]
        label = f"pitch circle, R {four_digit_length_text(through)}"
        draw_circle(axes, through, color=REFERENCE_COLOUR, ls=(0, (1.5, 2.5)), label=label, **thin)
        spans.append(through * CROSS_POINTS)
        lowest = min(lowest, -through)
        at = np.radians([steepest.quantity_values["pressure_angle_max_at_deg"]])
        own = steepest.problem
        point = cam_curves(own.setup.mechanism, own.design, own.programme, at).pitch
        if steepest is not picture and not mechanism.touches_rib:  # the contact is with a second disc
            point = point.conj()
        ring = {"ls": "none", "marker": "o", "ms": 5, "mfc": "white", "mec": REFERENCE_COLOUR, "zorder": 6}
        draw_line(axes, point, label="pitch point", **ring)
    draw_shaft_and_centre_mark(axes, picture, size)
    if not problem.setup.angular:
        spans.append(_draw_offset_circle_and_dimension(axes, float(problem.design.offset[0]), lowest, size))
    return spans


def draw_shaft_and_centre_mark(axes: Any, picture: Picture, size: float) -> None:
    """Draw the shaft, and a mark at its centre."""
    shaft, mark = picture.problem.setup.shaft_radius, 0.06 * size
    if shaft is not None:
        draw_circle(axes, shaft, color=INK, lw=1.0, zorder=2.6)
        fill_area(axes, shaft * np.exp(1j * np.linspace(0, 2 * np.pi, 181)), facecolor="white", zorder=2.2)
    draw_line(axes, [-mark, mark], color=INK, lw=0.8, zorder=5)
    draw_line(axes, [-mark * 1j, mark * 1j], color=INK, lw=0.8, zorder=5)
    draw_circle(axes, 0.012 * size, color=INK, lw=0.8, zorder=5)


def _draw_offset_circle_and_dimension(axes: Any, offset: float, lowest_level: float, size: float) -> ComplexArray:
    """Draw the offset circle, the follower's axis, and the offset as a dimension below the cam."""
    dashes = {"color": MUTED, "lw": 0.7, "ls": (0, (12, 3, 2, 3)), "zorder": 2}
    offset = offset if abs(offset) > INVISIBLE_OFFSET * size else 0.0
    level = lowest_level - (0.1 * size if offset else 0.02 * size)
    ends = 1j * np.array([level - 0.03 * size, 0.4 * size])
    draw_line(axes, ends, **dashes)
    if offset == 0.0:
        return ends
    draw_circle(
        axes,
        abs(offset),
        color=REFERENCE_COLOUR,
        lw=0.8,
        zorder=2.5,
        label=f"offset circle, R {four_digit_length_text(abs(offset))}",
    )
    draw_line(axes, offset + 1j * np.array([level - 0.03 * size, 0.9 * size]), **dashes)
    arrow = {"arrowstyle": "<|-|>", "color": MUTED, "lw": 0.7, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 7}
    axes.annotate("", (0.0, level), (offset, level), arrowprops=arrow)
    side = 1.0 if offset > 0 else -1.0
    place = {"ha": "left" if offset > 0 else "right", "va": "center", "fontsize": TEXT_SIZE, "color": INK}
    axes.text(offset + side * 0.03 * size, level, f"offset {four_digit_length_text(offset)}", **place)
    return ends


def draw_stroke_starts(axes: Any, picture: Picture) -> list[Label]:
    """Draw a ray at the start of each stroke; return labels with cam angles, inside the profile if they fit."""
    problem = picture.problem
    starts = np.array([s.start for s in problem.programme.strokes])
    mechanism, design = problem.setup.mechanism, problem.design
    curves = cam_curves(mechanism, design, problem.programme, starts)
    feet = np.exp(-1j * design.sense * starts) * (0.0 if mechanism.flat_faced else design.offset[0])
    labels = []
    for angle, point, foot in zip(starts, curves.profile[0], feet, strict=True):
        draw_line(axes, [foot, point], color=FAINT, lw=0.7, zorder=2)
        box = {"boxstyle": "round,pad=0.15", "fc": FILL, "ec": "none"}
        style = {"fontsize": SMALL_SIZE, "color": MUTED, "bbox": box, "zorder": 4.5}
        places = label_place_candidates(START_LABEL_DISTANCES, float(np.angle(foot - point)))
        labels.append(
            Label(axes, f"{np.degrees(angle):.4g}°", (point.real, point.imag), places, style, PROFILE_WIDTH)
        )
    return labels


def draw_rotation_arrow(axes: Any, picture: Picture) -> Label:
    """Draw an arrow for the sense of rotation, where the cam has most room inside; return its label."""
    design = picture.problem.design
    marks = [np.pi / 2, *(np.pi / 2 - design.sense * s.start for s in picture.problem.programme.strokes)]
    places = np.radians(np.arange(0, 360, 15))
    room = np.min(np.abs(np.angle(np.exp(1j * (places[:, None] - np.array(marks))))), axis=1)
    middle, half = places[int(np.argmax(room))], np.radians(32.0)
    base, shaft = float(design.size[0]), picture.problem.setup.shaft_radius or 0.0
    radius = max(0.6 * base, (shaft + base) / 2)
    arc = radius * np.exp(1j * (middle + design.sense * np.linspace(-half, half, 41)))
    draw_line(axes, arc, color=INK, lw=1.3, zorder=5)
    ends = [(point.real, point.imag) for point in (arc[-1], arc[-3])]
    axes.annotate("", *ends, arrowprops={"arrowstyle": "-|>", "color": INK, "mutation_scale": 13}, zorder=5)
    beside = radius * np.exp(1j * middle)
    style = {"fontsize": TITLE_SIZE, "color": INK, "zorder": 5}
    return Label(
        axes,
        "ω",
        (beside.real, beside.imag),
        label_place_candidates(ROTATION_LABEL_DISTANCES, middle + np.pi, 24),
        style,
    )


def frame_with_scale_bar(axes: Any, points: ComplexArray) -> tuple[complex, float]:
    """Set equal scales around points, hide the axes, draw a scale bar; return corner and scale of ``fit_axes``."""
    corner, unit = fit_axes(axes, points, 0.03)
    axes.set_axis_off()
    length = round_down_to_1_2_5(
        to_shown_unit(unit * axes.get_position().width * axes.figure.get_size_inches()[0] / 6, "mm")
    )
    text, length = f"{length:g} {unit_in_shown_system('mm')}", from_shown_unit(length, "mm")
    draw_line(axes, [corner, corner + length], color=INK, lw=2.5, solid_capstyle="butt", clip_on=False)
    place = corner + 0.07j * unit
    axes.text(place.real, place.imag, text, fontsize=TEXT_SIZE, color=INK, ha="left", va="bottom")
    return corner, unit
