"""The profile in a drawing (DXF) that a scene names, as the arcs and lines of ``[[profile]]``.

A drawing rounds the ends of its arcs, so neighbours are not exactly tangent. Here each centre c and signed radius r
moves by the least amount (least squares, by Newton's method) that makes neighbouring arcs tangent:

    |c₂ − c₁| = |r₁ − r₂|

A line follows from the arcs beside it.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from camopt.core.numerics import BoolArray, ComplexArray, FloatArray, IndexArray
from camopt.model.motion.profile import ElementSpec, ProfileFault, ProfilePiece, place_profile_elements
from camopt.scene.dxf import DrawnOutline, read_dxf_profile
from camopt.scene.law_forms import Fault
from camopt.scene.mapping import value_at_key
from camopt.scene.own_laws import LARGEST_NUMBER
from camopt.scene.tables import MOST_SEGMENTS

SAME_ARC = 1e-5  # share of the radius: neighbours that differ less are one arc
SAME_LINE = 1e-7  # rad: neighbouring lines that differ less are one line
TANGENT_GAP = 1e-10  # share of the radii: gap at which Newton's method stops
NEWTON_ROUNDS = 20
SHARP_CORNER = 0.02  # rad
DRAWN_WITHIN = 1e-3  # mm: largest distance of a vertex of the drawing from the tangent arcs


def replace_drawing_by_elements(data: dict[str, Any], folder: Path | None) -> Iterator[Fault]:
    """Replace the name of a DXF file by its arcs and lines, in ``data`` itself.

    The path is relative to ``folder``; None if the scene may not name files.
    """
    name = data.get("profile")
    if not isinstance(name, str):
        return
    try:
        if folder is None:
            raise ValueError("a scene inside a table cannot name files")
        rows = profile_elements_of_outline(
            read_dxf_profile(folder / name), value_at_key(data, "cam.rotation") == "cw"
        )
    except (OSError, ValueError) as trouble:
        reason = getattr(trouble, "strerror", None) or trouble
        yield "profile", name, f"must be a DXF file with the profile, or its [[profile]]: {reason}"
    else:
        data["profile"] = rows


def profile_elements_of_outline(outline: DrawnOutline, clockwise: bool) -> list[dict[str, Any]]:
    """The elements of an outline in the order in which the follower meets them, on a cam that turns cw or ccw.

    Raises
    ------
    ValueError
        If no tangent arcs and lines come within ``DRAWN_WITHIN`` of its vertices.
    """
    sharpest = int(np.argmax(outline.corner_angles))
    if outline.corner_angles[sharpest] > SHARP_CORNER:
        jump = np.degrees(outline.corner_angles[sharpest])
        raise ValueError(f"it has a corner of {jump:.3g}° at {_point_text(outline.vertices[sharpest])}")
    outline = outline if (outline.signed_area > 0.0) == clockwise else outline.reversed_outline
    radii, centres = _arc_radii_and_centres(outline, 1.0 if clockwise else -1.0)
    starts = _differs_from_previous_arc(radii, centres)
    if starts.sum() > MOST_SEGMENTS:
        raise ValueError(f"its profile has {starts.sum():,} arcs and lines; at most {MOST_SEGMENTS:,} are allowed")
    radii, centres = _tangent_radii_and_centres(radii[starts], centres[starts])
    elements = [
        ElementSpec(None) if np.isinf(r) else ElementSpec(float(r), complex(c))
        for r, c in zip(radii, centres, strict=True)
    ]
    _check_elements_meet_vertices(elements, outline.vertices, np.cumsum(starts) - 1, clockwise)
    return [
        {"element": "line"}
        if each.centre is None
        else {"element": "arc", "radius": each.radius, "x": each.centre.real, "y": each.centre.imag}
        for each in elements
    ]


def _arc_radii_and_centres(outline: DrawnOutline, outline_sense: float) -> tuple[FloatArray, ComplexArray]:
    """Radii [mm] and centres of the arcs of an outline, anticlockwise (``outline_sense`` 1) or clockwise (−1).

    A radius is positive where the outline is convex. Lines have an infinite radius, and the unit tangent as centre.
    """
    chords, bulges = outline.chords, outline.bulges
    with np.errstate(divide="ignore", invalid="ignore"):
        radii = outline_sense * np.abs(chords) * (1.0 + bulges**2) / (4.0 * bulges)
        centres = outline.vertices + chords * (0.5 + 0.25j * (1.0 / bulges - bulges))
    lines = ~(np.abs(radii) < LARGEST_NUMBER)
    return np.where(lines, np.inf, radii), np.where(lines, chords / np.abs(chords), centres)


def _differs_from_previous_arc(radii: FloatArray, centres: ComplexArray) -> BoolArray:
    """Whether each arc or line differs from the one before it."""
    size = np.where(np.isinf(radii), SAME_LINE, SAME_ARC * np.abs(radii))
    before = np.roll(radii, 1)
    with np.errstate(invalid="ignore"):
        other = np.where(before == radii, 0.0, before - radii)  # lines have no difference
    starts = np.abs(np.roll(centres, 1) - centres) + np.abs(other) > size
    if not starts.any():
        starts[0] = True  # a whole circle
    return starts


def _tangent_radii_and_centres(radii: FloatArray, centres: ComplexArray) -> tuple[FloatArray, ComplexArray]:
    """Radii and centres, moved until neighbouring arcs are tangent."""
    after = np.roll(np.arange(radii.size), -1)
    both = np.flatnonzero(np.isfinite(radii) & np.isfinite(radii[after]) & (radii.size > 1))
    here, there = both, after[both]
    for _ in range(NEWTON_ROUNDS):
        distance, step = centres[there] - centres[here], radii[here] - radii[there]
        gaps = np.abs(distance) - np.abs(step)
        if np.all(np.abs(gaps) <= TANGENT_GAP * (np.abs(radii[here]) + np.abs(radii[there]))):
            break
        slopes, rows = np.zeros((both.size, 3, radii.size)), np.arange(both.size)
        direction, side = distance / np.abs(distance), np.sign(step)
        for place, sign in ((here, -1.0), (there, 1.0)):
            slopes[rows, 0, place] += sign * side
            slopes[rows, 1, place] += sign * direction.real
            slopes[rows, 2, place] += sign * direction.imag
        flat = slopes.reshape(both.size, -1)
        change = (flat.T @ np.linalg.lstsq(flat @ flat.T, -gaps, rcond=None)[0]).reshape(3, -1)
        radii, centres = radii + change[0], centres + change[1] + 1j * change[2]
    return radii, centres


def _check_elements_meet_vertices(
    elements: list[ElementSpec], vertices: ComplexArray, element_at_each_vertex: IndexArray, clockwise: bool
) -> None:
    """Raise ValueError if the elements make no profile, or miss a vertex between the two they belong to."""

    def mirror_unless_clockwise(z: Any) -> Any:  # the plane of the motion, where elements run anticlockwise
        return z if clockwise else np.conjugate(z)

    try:
        parts = place_profile_elements(
            [
                each if each.centre is None else ElementSpec(each.radius, mirror_unless_clockwise(each.centre))
                for each in elements
            ]
        )
    except ProfileFault as fault:
        raise ValueError(f"{f'element {fault.number}: ' if fault.number else ''}{fault.why}") from None
    neighbours = np.column_stack([element_at_each_vertex, np.roll(element_at_each_vertex, 1)])
    distances = [
        max(_distance_from_unbounded_element(parts[k], z) for k in pair)
        for pair, z in zip(neighbours, mirror_unless_clockwise(vertices), strict=True)
    ]
    worst = int(np.argmax(distances))
    if distances[worst] > DRAWN_WITHIN:
        where = _point_text(vertices[worst])
        raise ValueError(f"tangent arcs and lines miss the drawing by {distances[worst]:.2g} mm at {where}")


def _point_text(point: complex) -> str:
    return f"({point.real:.6g}, {point.imag:.6g})"


def _distance_from_unbounded_element(element: ProfilePiece, point: complex) -> float:
    """Distance of a point from the circle or line of an element [mm]."""
    if element.radius is None:
        return abs((element.start.normal.conjugate() * point).real - element.line_distance_from_axis)
    return abs(abs(point - element.centre) - abs(element.radius))
