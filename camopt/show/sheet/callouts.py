"""Callouts outside the ring of the front view, each at a free place."""

from collections.abc import Callable
from math import cos, pi, sin

import numpy as np

from camopt.show.sheet import symbols
from camopt.show.sheet.dimensions import ARROW_TAIL, CELL, TEXT_ABOVE_LINE, arrowhead, distance_dimension
from camopt.show.sheet.front_view import (
    EVERY_DEGREE,
    FrontView,
    angle_between,
    is_keyway_section_vertical,
    outline_radius,
)
from camopt.show.sheet.marks import (
    LARGE,
    MEDIUM,
    THICK,
    Marks,
    Words,
    decimal_text,
    first_free_marks,
    line_mark,
    marks_box,
    readable_direction,
    shift_marks,
    text_width,
)
from camopt.show.sheet.ring import NAME_DISTANCE
from camopt.show.sheet.sizes import bore_text, groove_width_text, profile_symbols, size_text_with_fit
from camopt.show.sheet.standards import sheet_standard
from camopt.show.sheet.two_contacts import contact_distance
from camopt.solve.contour.hole import keyway_corners, keyway_direction_angle

LETTER_DISTANCE, ARROW_SHAFT = 9.0, 5.0  # mm from the end of a cutting plane to its letter, and length of its arrow
MARK_LENGTH = 4.0  # mm: length of the timing mark
TIMING_TEXT = "timing mark"
UPWARD, SAME_DIRECTION = 0.5 * pi, 1e-6  # rad
LEADER_ANGLE = 0.12  # rad: smallest angle between leaders and other radial lines
NAME_CLEARANCE = NAME_DISTANCE + LARGE  # mm from the ring to the outside of its names
TRIAL_OFFSETS = 6.0 * np.arange(8)  # mm: offsets to try, farther and farther out

Callout = Callable[[FrontView, float], Marks]
"""A function for the marks of a callout in a direction of the view [rad]; empty if it is not needed."""


def front_view_with_callouts(view: FrontView) -> Marks:
    """The front view with callouts: timing mark, cutting plane, sense of rotation, profile surface, bore."""
    marks = view.marks()
    obstacles: Marks = [
        mark for mark in marks if isinstance(mark, Words) or np.abs(mark.points).max() > view.ring_radius
    ]
    callouts = _keyway_width_dimension(view, marks)
    callouts += _timing_mark_and_ring_start(view, [*obstacles, *callouts])
    callouts += _yoke_breadth_dimension(view, [*obstacles, *callouts])
    callouts += _cutting_plane_marks(view, [*marks, *callouts])
    lines = np.array([np.angle(view.lowest_point), np.angle(view.highest_point), *view.ray_directions])
    beside = EVERY_DEGREE[angle_between(EVERY_DEGREE[:, None], lines).min(axis=1) > LEADER_ANGLE]
    for callout, wanted in CALLOUTS.items():
        free = EVERY_DEGREE if callout is _rotation_callout else beside  # leaders are beside radial lines
        near = free[np.argsort(angle_between(free, wanted), kind="stable")]
        callouts += first_free_marks((callout(view, float(turn)) for turn in near), [*obstacles, *callouts])
    return [*marks, *callouts]


def _keyway_width_dimension(view: FrontView, taken: Marks) -> Marks:
    """The width of the keyway, dimensioned outside the cam at the first free place."""
    part, turn = view.part, keyway_direction_angle(view.part)
    if not part.keyway_width:
        return []
    _, first, last, _ = keyway_corners(part, turn) * view.scale
    bottom = ((part.bore or 0.0) / 2 + (part.keyway_depth or 0.0)) * view.scale
    level = view.largest_radius_near_direction(turn, abs(first - last) / bottom) + 5.0 - bottom
    across, width = -1j * np.exp(1j * turn), size_text_with_fit(part.keyway_width, part.keyway_fit)
    datum = symbols.datums_of(part, bool(part.thickness)).keyway
    return first_free_marks(
        (
            distance_dimension(*ends, side * across, side * (level + further), width, datum)
            for further in TRIAL_OFFSETS * sheet_standard().text_share
            for ends, side in (((last, first), 1.0), ((first, last), -1.0))
        ),
        taken,
    )


def _yoke_breadth_dimension(view: FrontView, taken: Marks) -> Marks:
    """The distance of both contacts of a yoke, dimensioned beside the ring at the first free place."""
    if not view.yoke_contacts:
        return []
    distance, (top, low) = contact_distance(view.cam), view.yoke_contacts
    assert distance is not None
    levels = (view.ring_radius + NAME_CLEARANCE + further for further in TRIAL_OFFSETS)
    return first_free_marks(
        (
            distance_dimension(low, top, 1j, low.real - side * level, distance.toleranced_text)
            for level in levels
            for side in (1.0, -1.0)
        ),
        taken,
    )


def _timing_mark_and_ring_start(view: FrontView, taken: Marks) -> Marks:
    """The timing mark, and the start of the ring, named outside of the ring or else along its ray."""
    ray = np.exp(1j * view.cam.start_direction)
    text = f"{view.cam.translate(TIMING_TEXT)} 0°" if _ring_starts_at_timing_mark(view) else "0°"
    place = 0.5 - 0.5 * float(np.clip(4.0 * ray.real, -1.0, 1.0))
    down = 0.5j * MEDIUM * (1.0 - ray.imag)
    names: list[Marks] = [
        [
            line_mark((view.ring_radius + 2.0) * ray, (radius - 1.0) * ray),
            Words(radius * ray - down, text, MEDIUM, place),
        ]
        for radius in view.ring_radius + NAME_CLEARANCE + 3.0 + TRIAL_OFFSETS
    ]
    turn = readable_direction(float(np.angle(ray)))
    reading = np.exp(1j * turn)
    foot = (view.ring_radius - 3.0) * ray + 1j * TEXT_ABOVE_LINE * reading
    end = 1.0 if (reading * ray.conjugate()).real > 0.0 else 0.0
    names.append([Words(foot, text, MEDIUM, end, turn, backed=True)])
    top = 1j * view.timing_mark_radius
    return [line_mark(top - 1j * MARK_LENGTH, top, pen=THICK), *first_free_marks(names, taken)]


def _ring_starts_at_timing_mark(view: FrontView) -> bool:
    return bool(angle_between(view.cam.start_direction, UPWARD) < SAME_DIRECTION)


def _timing_leader(view: FrontView, direction_angle: float) -> Marks:
    """A leader to the timing mark, unless the ring begins there."""
    if _ring_starts_at_timing_mark(view):
        return []
    tip, knee = (
        1j * (view.timing_mark_radius - MARK_LENGTH / 2),
        (view.ring_radius + NAME_CLEARANCE + 2.0) * np.exp(1j * direction_angle),
    )
    side = 1.0 if cos(direction_angle) >= 0.0 else -1.0
    words = Words(knee + side * 3.0 - 0.5j * MEDIUM, view.cam.translate(TIMING_TEXT), MEDIUM, 0.5 - 0.5 * side)
    return [line_mark(knee + side * 2.0, knee, tip), arrowhead(tip, (tip - knee) / abs(tip - knee)), words]


def _cutting_plane_marks(view: FrontView, taken: Marks) -> Marks:
    """The cutting plane of the section through the keyway, with arrows in the direction of view.

    In first angle the arrows point to the plane, in third angle away from it (ASME Y14.3).
    """
    turn, side, found = keyway_direction_angle(view.part), sheet_standard().section_side, []
    if not view.part.thickness or is_keyway_section_vertical(view.part):
        return []
    seen = side * np.exp(1j * (turn - pi / 2))
    for direction in (turn, turn + pi):
        ends: list[Marks] = []
        for radius in (
            view.largest_radius_near_direction(direction) + 1.5,
            view.ring_radius + 2.0,
            *(view.ring_radius + NAME_CLEARANCE + 2.0 + TRIAL_OFFSETS),
        ):
            foot = radius * np.exp(1j * direction)
            end = foot + 6.0 * foot / abs(foot)
            tip = end if side > 0.0 else end + ARROW_SHAFT * seen
            letter = Words(end - side * LETTER_DISTANCE * seen - 0.5j * LARGE, "A", LARGE, 0.5)
            shaft = line_mark(tip - ARROW_SHAFT * seen, tip)
            ends.append([line_mark(foot, end, pen=THICK), shaft, arrowhead(tip, seen), letter])
        found += first_free_marks(ends, taken)
    return found


def _rotation_callout(view: FrontView, direction_angle: float) -> Marks:
    rpm = view.cam.scene.cam.rpm
    radius = view.ring_radius + NAME_CLEARANCE + 4.0
    words = view.cam.translate("rotation" if rpm is None else "{} rev/min").format(decimal_text(rpm or 0.0))
    at = (radius + 2.0) * np.exp(1j * direction_angle) - (1j * LARGE if sin(direction_angle) < 0.0 else 0.0)
    place = 1.0 if cos(direction_angle) < 0.0 else 0.0
    return [*symbols.rotation_symbol(radius, direction_angle, view.cam.sense), Words(at, words, LARGE, place)]


def _surface_leader(view: FrontView, direction_angle: float) -> Marks:
    """A leader to the profile, with its tolerance and roughness."""
    part = view.part
    frame = profile_symbols(part, bool(part.thickness))
    if not frame:
        return []
    box, side = marks_box(frame), 1.0 if cos(direction_angle) >= 0.0 else -1.0
    knee = (view.ring_radius + NAME_CLEARANCE + 2.0) * np.exp(1j * direction_angle)
    shelf = knee + side * 3.0
    tip = outline_radius(view.walls[0], direction_angle) * np.exp(1j * direction_angle)
    corner = shelf - (box.size.real if side < 0.0 else 0.0) - 0.5j * CELL
    return [
        *shift_marks(frame, corner),
        line_mark(shelf, knee, tip),
        arrowhead(tip, (tip - knee) / abs(tip - knee)),
    ]


def _groove_width_dimension(view: FrontView, direction_angle: float) -> Marks:
    """The width of a groove, across it from wall to wall."""
    cam = view.cam
    if not cam.problem.setup.mechanism.has_flanks_on_both_sides:
        return []
    curves = cam.curves_at(EVERY_DEGREE)
    near = int(np.argmin(angle_between(np.angle(curves.pitch), direction_angle)))
    middle, normal = complex(curves.pitch[near]) * view.scale, complex(curves.normal[near])
    half = cam.problem.wall_distance_from_pitch_curve * view.scale
    inner, outer = middle - half * normal, middle + half * normal
    along, across = (outer * normal.conjugate()).real, (outer * normal.conjugate()).imag
    reach = np.sqrt((view.ring_radius + NAME_CLEARANCE + 2.0) ** 2 - across**2) - along
    knee, side = outer + reach * normal, 1.0 if normal.real >= 0.0 else -1.0
    text = groove_width_text(cam)
    wide = text_width(text, LARGE)
    words = Words(knee + side * (1.0 + wide / 2) + 1j * TEXT_ABOVE_LINE, text, LARGE, 0.5)
    return [
        line_mark(knee + side * (wide + 2.0), knee, outer, inner - ARROW_TAIL * normal),
        arrowhead(inner, normal),
        arrowhead(outer, -normal),
        words,
    ]


def _bore_diameter_dimension(view: FrontView, direction_angle: float) -> Marks:
    """The diameter of the bore, if no section shows it."""
    part = view.part
    if not part.bore or part.thickness:
        return []
    ray, side = np.exp(1j * direction_angle), 1.0 if cos(direction_angle) >= 0.0 else -1.0
    tip, knee = part.bore / 2 * view.scale * ray, (view.ring_radius + NAME_CLEARANCE + 2.0) * ray
    text = bore_text(part)
    wide = text_width(text, LARGE)
    words = Words(knee + side * (1.0 + wide / 2) + 1j * TEXT_ABOVE_LINE, text, LARGE, 0.5)
    return [line_mark(knee + side * (wide + 2.0), knee, tip), arrowhead(tip, -ray), words]


CALLOUTS: dict[Callout, float] = {
    _timing_leader: 0.6 * pi,
    _rotation_callout: 0.75 * pi,
    _surface_leader: -0.25 * pi,
    _bore_diameter_dimension: -0.75 * pi,
    _groove_width_dimension: -0.6 * pi,
}
"""Callouts with their preferred directions [rad]."""
