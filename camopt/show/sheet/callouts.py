"""Callouts outside the ring of the front view, each at a free place."""

from collections.abc import Callable, Iterable
from math import cos, pi, sin

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.show.sheet import symbols
from camopt.show.sheet.dimensions import CELL, OVER_LINE, TAIL, arrow, distance
from camopt.show.sheet.front_view import EVERY_DEGREE, FrontView, angle_between, is_upright
from camopt.show.sheet.marks import (
    LARGE,
    MEDIUM,
    THICK,
    Marks,
    Taken,
    Words,
    box_of,
    decimal,
    line,
    moved,
    upright,
    width_of,
)
from camopt.show.sheet.ring import TO_NAMES
from camopt.show.sheet.sizes import bore_said, keyway_width_said, width_said
from camopt.show.sheet.two_contacts import apart
from camopt.solve.contour.hole import keyway_corners, keyway_turn

TO_LETTER = 9.0  # mm: from the end of a cutting plane to its letter
MARK_LENGTH = 4.0  # mm: length of the timing mark
TIMING = "timing mark"
UP, SAME_DIRECTION = 0.5 * pi, 1e-6  # rad
LEADER = 0.12  # rad: leaders from other lines along radii
OUTSIDE = TO_NAMES + LARGE  # mm: from the ring past the names along it
FURTHER = 6.0 * np.arange(8)  # mm: places that are tried, further and further out

Callout = Callable[[FrontView, float], Marks]
"""What is said in a direction (rad) of the view; nothing if there is nothing to say."""


def with_callouts(view: FrontView) -> Marks:
    """The front view with its timing mark, cutting plane, sense of rotation, surface of the profile, and bore."""
    marks = view.marks()
    there: Marks = [mark for mark in marks if isinstance(mark, Words) or np.abs(mark.points).max() > view.ring]
    said = _keyway(view, marks)
    said += _zero(view, [*there, *said])
    said += _breadth(view, [*there, *said])
    said += _cutting_plane(view, [*marks, *said])
    for callout, wanted in CALLOUTS.items():
        free = _directions(view, callout)
        near = free[np.argsort(angle_between(free, wanted), kind="stable")]
        said += first_free((callout(view, float(turn)) for turn in near), [*there, *said])
    return [*marks, *said]


def _directions(view: FrontView, callout: Callout) -> FloatArray:
    """The directions a callout may take; with a leader, only those well away from other radial lines."""
    if callout is _rotation:
        return EVERY_DEGREE
    lines = np.array([np.angle(view.lowest), np.angle(view.highest), *view.rays])
    return np.asarray(EVERY_DEGREE[angle_between(EVERY_DEGREE[:, None], lines).min(axis=1) > LEADER])


def first_free(tried: Iterable[Marks], taken: Marks) -> Marks:
    """The first of several marks that overlaps nothing; the last, if all overlap."""
    made: Marks = []
    there = Taken(taken)
    for made in tried:
        if not made or not there.meets(made):
            break
    return made


def _keyway(view: FrontView, taken: Marks) -> Marks:
    """The width of the keyway, dimensioned outside the cam at the first free place."""
    part, turn = view.part, keyway_turn(view.part)
    if not part.keyway_width:
        return []
    _, first, last, _ = keyway_corners(part, turn) * view.scale
    bottom = ((part.bore or 0.0) / 2 + (part.keyway_depth or 0.0)) * view.scale
    level = view.radius_at(turn, abs(first - last) / bottom) + 5.0 - bottom
    across, width = -1j * np.exp(1j * turn), keyway_width_said(part)
    datum = symbols.datums_of(part, bool(part.thickness)).keyway
    return first_free(
        (
            distance(*ends, side * across, side * (level + further), width, datum)
            for further in FURTHER
            for ends, side in (((last, first), 1.0), ((first, last), -1.0))
        ),
        taken,
    )


def _breadth(view: FrontView, taken: Marks) -> Marks:
    """How far apart both contacts of a yoke are, dimensioned beside the ring at the first free place."""
    if not view.yoke:
        return []
    found, (top, low) = apart(view.cam), view.yoke
    assert found is not None
    levels = (view.ring + OUTSIDE + further for further in FURTHER)
    return first_free(
        (
            distance(low, top, 1j, low.real - side * level, found.nominal)
            for level in levels
            for side in (1.0, -1.0)
        ),
        taken,
    )


def _zero(view: FrontView, taken: Marks) -> Marks:
    """The timing mark, and the start of the ring."""
    ray = np.exp(1j * view.cam.start)
    text = f"{view.cam.say(TIMING)} 0°" if _begins_at_mark(view) else "0°"
    place = 0.5 - 0.5 * float(np.clip(4.0 * ray.real, -1.0, 1.0))
    down = 0.5j * MEDIUM * (1.0 - ray.imag)
    outside: list[Marks] = [
        [line((view.ring + 2.0) * ray, (radius - 1.0) * ray), Words(radius * ray - down, text, MEDIUM, place)]
        for radius in view.ring + OUTSIDE + 3.0 + FURTHER
    ]
    named = first_free([*outside, [_along(ray, view.ring - 3.0, text)]], taken)
    top = 1j * view.mark
    return [line(top - 1j * MARK_LENGTH, top, pen=THICK), *named]


def _along(ray: complex, radius: float, text: str) -> Words:
    """A text beside a ray, inwards from a radius."""
    turn = upright(float(np.angle(ray)))
    reading = np.exp(1j * turn)
    place = 1.0 if (reading * ray.conjugate()).real > 0.0 else 0.0
    return Words(radius * ray + 1j * OVER_LINE * reading, text, MEDIUM, place, turn, backed=True)


def _begins_at_mark(view: FrontView) -> bool:
    return bool(angle_between(view.cam.start, UP) < SAME_DIRECTION)


def _timing(view: FrontView, turn: float) -> Marks:
    """A leader to the timing mark, if the ring does not begin there."""
    if _begins_at_mark(view):
        return []
    tip, knee = 1j * (view.mark - MARK_LENGTH / 2), (view.ring + OUTSIDE + 2.0) * np.exp(1j * turn)
    side = 1.0 if cos(turn) >= 0.0 else -1.0
    words = Words(knee + side * 3.0 - 0.5j * MEDIUM, view.cam.say(TIMING), MEDIUM, 0.5 - 0.5 * side)
    return [line(knee + side * 2.0, knee, tip), arrow(tip, (tip - knee) / abs(tip - knee)), words]


def _cutting_plane(view: FrontView, taken: Marks) -> Marks:
    """The cutting plane of the section through the keyway, with arrows in the direction of view."""
    turn, found = keyway_turn(view.part), []
    if not view.part.thickness or is_upright(view.part):
        return []
    seen = np.exp(1j * (turn - pi / 2))
    for direction in (turn, turn + pi):
        radii = (view.radius_at(direction) + 1.5, view.ring + 2.0, *(view.ring + OUTSIDE + 2.0 + FURTHER))
        found += first_free((_plane_end(radius * np.exp(1j * direction), seen) for radius in radii), taken)
    return found


def _plane_end(foot: complex, seen: complex) -> Marks:
    """One end of a cutting plane, seen in a direction (of length 1)."""
    end = foot + 6.0 * foot / abs(foot)
    letter = Words(end - TO_LETTER * seen - 0.5j * LARGE, "A", LARGE, 0.5)
    return [line(foot, end, pen=THICK), line(end - 5.0 * seen, end), arrow(end, seen), letter]


def _rotation(view: FrontView, turn: float) -> Marks:
    rpm = view.cam.scene.cam.rpm
    radius = view.ring + OUTSIDE + 4.0
    words = view.cam.say("rotation" if rpm is None else "{} rev/min").format(decimal(rpm or 0.0))
    at = (radius + 2.0) * np.exp(1j * turn) - (1j * LARGE if sin(turn) < 0.0 else 0.0)
    place = 1.0 if cos(turn) < 0.0 else 0.0
    return [*symbols.rotation(radius, turn, view.cam.sense), Words(at, words, LARGE, place)]


def _surface(view: FrontView, turn: float) -> Marks:
    """A leader to the profile, with its tolerance and roughness."""
    part = view.part
    frame = symbols.surface(part, symbols.datums_of(part, bool(part.thickness)))
    if not frame:
        return []
    box, side = box_of(frame), 1.0 if cos(turn) >= 0.0 else -1.0
    knee = (view.ring + OUTSIDE + 2.0) * np.exp(1j * turn)
    shelf = knee + side * 3.0
    tip = view.nearest(turn) * np.exp(1j * turn)
    corner = shelf - (box.size.real if side < 0.0 else 0.0) - 0.5j * CELL
    return [*moved(frame, corner), line(shelf, knee, tip), arrow(tip, (tip - knee) / abs(tip - knee))]


def _groove_width(view: FrontView, turn: float) -> Marks:
    """The width of a groove, across it from wall to wall."""
    cam = view.cam
    if not cam.problem.setup.mechanism.two_sided:
        return []
    curves = cam.curves_at(EVERY_DEGREE)
    near = int(np.argmin(angle_between(np.angle(curves.pitch), turn)))
    middle, normal = complex(curves.pitch[near]) * view.scale, complex(curves.normal[near])
    half = cam.problem.half_width * view.scale
    inner, outer = middle - half * normal, middle + half * normal
    along, across = (outer * normal.conjugate()).real, (outer * normal.conjugate()).imag
    reach = np.sqrt((view.ring + OUTSIDE + 2.0) ** 2 - across**2) - along
    knee, side = outer + reach * normal, 1.0 if normal.real >= 0.0 else -1.0
    text = width_said(cam)
    wide = width_of(text, LARGE)
    words = Words(knee + side * (1.0 + wide / 2) + 1j * OVER_LINE, text, LARGE, 0.5)
    lines = [line(knee + side * (wide + 2.0), knee, outer, inner - TAIL * normal)]
    return [*lines, arrow(inner, normal), arrow(outer, -normal), words]


def _bore(view: FrontView, turn: float) -> Marks:
    """The diameter of the bore, if no section shows it."""
    part = view.part
    if not part.bore or part.thickness:
        return []
    ray, side = np.exp(1j * turn), 1.0 if cos(turn) >= 0.0 else -1.0
    tip, knee = part.bore / 2 * view.scale * ray, (view.ring + OUTSIDE + 2.0) * ray
    text = bore_said(part)
    wide = width_of(text, LARGE)
    words = Words(knee + side * (1.0 + wide / 2) + 1j * OVER_LINE, text, LARGE, 0.5)
    return [line(knee + side * (wide + 2.0), knee, tip), arrow(tip, -ray), words]


CALLOUTS: dict[Callout, float] = {
    _timing: 0.6 * pi,
    _rotation: 0.75 * pi,
    _surface: -0.25 * pi,
    _bore: -0.75 * pi,
    _groove_width: -0.6 * pi,
}
"""In which direction (rad) each is wanted."""
