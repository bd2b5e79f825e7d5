"""A profile that a scene names as a drawing (DXF): its outline as the arcs and lines of ``[[profile]]``.

A drawing has the ends of its arcs in some digits, so that neighbours are tangent but for rounding. Each arc is one
here that is tangent to its neighbours: its centre c and signed radius r are moved as little as it takes (least
squares, by Newton's method) for

    |c₂ − c₁| = |r₁ − r₂|

where two arcs meet; a line follows from the arcs beside it.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import BoolArray, ComplexArray, FloatArray, IndexArray
from camopt.model.motion.profile import ElementSpec, ProfileFault, ProfilePiece, place_elements
from camopt.scene.dxf import DrawnOutline, read_dxf_profile
from camopt.scene.law_forms import Fault
from camopt.scene.mapping import value_at_key
from camopt.scene.own_laws import LARGEST_NUMBER
from camopt.scene.tables import MOST_SEGMENTS

SAME_ARC = 1e-5  # of the radius: neighbours so near to each other are one arc
SAME_LINE = 1e-7  # rad: of lines that are one
TANGENT_GAP = 1e-10  # of the radii: what Newton's method leaves
NEWTON_ROUNDS = 20
SHARP_CORNER = 0.02  # rad
DRAWN_WITHIN = 1e-3  # mm: how far a vertex of the drawing may be from the arcs made of it


def read_drawing(data: dict[str, Any], folder: Path | None) -> Iterator[Fault]:
    """Put the arcs and lines of a profile that names a file in place of the name, in ``data`` itself.

    ``folder`` is where the file is looked for; None if none may be named.
    """
    name = data.get("profile")
    if not isinstance(name, str):
        return
    try:
        if folder is None:
            raise ValueError("the scene of a table names no files")
        rows = outline_elements(read_dxf_profile(folder / name), value_at_key(data, "cam.rotation") == "cw")
    except (OSError, ValueError) as trouble:
        reason = getattr(trouble, "strerror", None) or trouble
        yield "profile", name, f"must be a DXF file with the profile, or its [[profile]]: {reason}"
    else:
        data["profile"] = rows


def outline_elements(outline: DrawnOutline, clockwise: bool) -> list[dict[str, Any]]:
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
    outline = outline if (outline.area > 0.0) == clockwise else outline.reversed_outline
    arcs = _outline_arcs(outline, 1.0 if clockwise else -1.0)
    starts = _starts_of_arcs(arcs)
    if starts.sum() > MOST_SEGMENTS:
        raise ValueError(f"its profile has {starts.sum():,} arcs and lines; at most {MOST_SEGMENTS:,} are allowed")
    radii, centres = _make_tangent(arcs.radii[starts], arcs.centres[starts])
    given = ((float(r), complex(c)) for r, c in zip(radii, centres, strict=True))
    made = [ElementSpec(None) if np.isinf(r) else ElementSpec(r, c) for r, c in given]
    _check_near(made, outline.vertices, np.cumsum(starts) - 1, clockwise)
    return [
        {"element": "line"}
        if each.centre is None
        else {"element": "arc", "radius": each.radius, "x": each.centre.real, "y": each.centre.imag}
        for each in made
    ]


class _Arcs(NamedTuple):
    """Radii, positive where convex and infinite of lines, and centres, of lines their tangents."""

    radii: FloatArray
    centres: ComplexArray


def _outline_arcs(outline: DrawnOutline, turn: float) -> _Arcs:
    """The arcs of an outline that goes round anticlockwise (``turn`` 1) or clockwise (−1)."""
    chords, bulges = outline.chords, outline.bulges
    with np.errstate(divide="ignore", invalid="ignore"):
        radii = turn * np.abs(chords) * (1.0 + bulges**2) / (4.0 * bulges)
        centres = outline.vertices + chords * (0.5 + 0.25j * (1.0 / bulges - bulges))
    lines = ~(np.abs(radii) < LARGEST_NUMBER)
    return _Arcs(np.where(lines, np.inf, radii), np.where(lines, chords / np.abs(chords), centres))


def _starts_of_arcs(arcs: _Arcs) -> BoolArray:
    """Whether each is another arc or line than the one before it."""
    size = np.where(np.isinf(arcs.radii), SAME_LINE, SAME_ARC * np.abs(arcs.radii))
    before = np.roll(arcs.radii, 1)
    with np.errstate(invalid="ignore"):
        other = np.where(before == arcs.radii, 0.0, before - arcs.radii)  # lines have no difference
    starts = np.abs(np.roll(arcs.centres, 1) - arcs.centres) + np.abs(other) > size
    if not starts.any():
        starts[0] = True  # a whole circle
    return starts


def _make_tangent(radii: FloatArray, centres: ComplexArray) -> tuple[FloatArray, ComplexArray]:
    """Radii and centres moved until neighbours that are both arcs touch."""
    after = np.roll(np.arange(radii.size), -1)
    both = np.flatnonzero(np.isfinite(radii) & np.isfinite(radii[after]) & (radii.size > 1))
    here, there = both, after[both]
    for _ in range(NEWTON_ROUNDS):
        way, step = centres[there] - centres[here], radii[here] - radii[there]
        off = np.abs(way) - np.abs(step)
        if np.all(np.abs(off) <= TANGENT_GAP * (np.abs(radii[here]) + np.abs(radii[there]))):
            break
        slopes, rows = np.zeros((both.size, 3, radii.size)), np.arange(both.size)
        ahead, side = way / np.abs(way), np.sign(step)
        for place, sign in ((here, -1.0), (there, 1.0)):
            slopes[rows, 0, place] += sign * side
            slopes[rows, 1, place] += sign * ahead.real
            slopes[rows, 2, place] += sign * ahead.imag
        flat = slopes.reshape(both.size, -1)
        moved = (flat.T @ np.linalg.lstsq(flat @ flat.T, -off, rcond=None)[0]).reshape(3, -1)
        radii, centres = radii + moved[0], centres + moved[1] + 1j * moved[2]
    return radii, centres


def _check_near(elements: list[ElementSpec], vertices: ComplexArray, owners: IndexArray, clockwise: bool) -> None:
    """ValueError if elements do not fit together, or not through the vertices where their owners begin."""

    def plane(z: Any) -> Any:  # that of the motion, in which they go round anticlockwise
        return z if clockwise else np.conjugate(z)

    try:
        parts = place_elements(
            [each if each.centre is None else ElementSpec(each.radius, plane(each.centre)) for each in elements]
        )
    except ProfileFault as unfit:
        raise ValueError(f"{f'element {unfit.number}: ' if unfit.number else ''}{unfit.why}") from None
    beside = np.column_stack([owners, np.roll(owners, 1)])
    off = [
        max(_distance_from_element(parts[k], z) for k in pair)
        for pair, z in zip(beside, plane(vertices), strict=True)
    ]
    worst = int(np.argmax(off))
    if off[worst] > DRAWN_WITHIN:
        raise ValueError(f"tangent arcs and lines are {off[worst]:.2g} mm off at {_point_text(vertices[worst])}")


def _point_text(point: complex) -> str:
    return f"({point.real:.6g}, {point.imag:.6g})"


def _distance_from_element(part: ProfilePiece, point: complex) -> float:
    """How far a point is from the circle or line that a part is on, mm."""
    if part.radius is None:
        return abs((part.start.normal.conjugate() * point).real - part.height)
    return abs(abs(point - part.centre) - abs(part.radius))
