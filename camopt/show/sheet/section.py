"""The section of a disc cam through its axis: plates, hub, groove and bore.

In first angle it is drawn as the view from the left, in third angle as the view from the right.

It goes through the middle of the keyway, which is on top, or along the vertical centre line.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from shapely import LineString, Polygon, box, make_valid, union_all

from camopt.core.numerics import ComplexArray
from camopt.core.numerics.stable_functions import difference_of_squares_root
from camopt.scene.part import Part
from camopt.show.sheet import symbols
from camopt.show.sheet.dimensions import (
    CELL,
    FIRST_LEVEL,
    LEVEL_STEP,
    STEM,
    TEXT_ABOVE_LINE,
    datum_symbol,
    distance_dimension,
)
from camopt.show.sheet.marks import (
    CHAIN,
    LARGE,
    THICK,
    THIN,
    Line,
    Marks,
    Words,
    line_mark,
    mirror_marks,
    shift_marks,
)
from camopt.show.sheet.sizes import bore_and_keyway_outline, bore_text, keyway_depth_text
from camopt.show.sheet.standards import sheet_standard, size_text
from camopt.solve.contour.hole import keyway_direction_angle

HATCH_DISTANCE = 2.5  # mm between hatch lines
PLATE_OVERRUN = 2.0  # mm from a plate to its number
Gap = tuple[float, float]


class Plate(NamedTuple):
    """The plate of a disc in the section: its range along the axis, and its ranges across [mm]."""

    low: float
    high: float
    cut: list[Gap]
    """Ranges of cut material."""
    ends: Gap
    """Edges seen behind the section."""

    def edges(self) -> Iterator[Line]:
        """Visible lines of the plate, without those of the cut material."""
        ends = [self.ends[0], *(y for each in self.cut for y in each), self.ends[1]]
        for low, high in zip(ends[::2], ends[1::2], strict=True):
            if high - low > 1e-6:
                yield from (line_mark(x + 1j * low, x + 1j * high, pen=THICK) for x in (self.low, self.high))
        yield from (line_mark(self.low + 1j * y, self.high + 1j * y, pen=THICK) for y in self.ends)


def section_marks(
    profiles: Sequence[ComplexArray], part: Part, scale: float, walls: Sequence[ComplexArray] = ()
) -> Marks:
    """The section of the plates of discs with given profiles (mm on the paper, in the frame of the cam).

    Its axis is at y = 0. ``walls`` are the walls of a groove or rib on the face of a single plate, the inner one
    first.
    """
    turn = np.exp(1j * (np.pi / 2 - keyway_direction_angle(part)))
    hole = bore_and_keyway_outline(part, np.pi / 2) * scale if part.bore else np.zeros(0, dtype=complex)
    whole, hub = max(part.hub_length or 0.0, part.width) * scale, (part.hub_diameter or 0.0) / 2 * scale
    plates = [
        _plate_of_profile(profile * turn, hub, low * scale, high * scale)
        for profile, (low, high) in zip(profiles, part.plate_extents, strict=True)
    ]
    gap, face = _vertical_intervals_inside(hole), plates[0].high
    around = [plates[0].cut] if part.rib_height else []  # beside a rib the plate is cut away
    grooves = (
        _intervals_between_outlines(*(_vertical_intervals_inside(wall * turn) for wall in walls), *around)
        if walls
        else []
    )
    bottom = face - (part.groove_depth or part.rib_height or 0.0) * scale
    bodies = [
        *(box(plate.low, low, plate.high, high) for plate in plates for low, high in plate.cut),
        *([box(0.0, -hub, whole, hub)] if hub else []),
    ]
    solid = union_all(bodies).difference(union_all([box(-1.0, low, whole + 1.0, high) for low, high in gap]))
    solid = solid.difference(union_all([box(bottom, low, face + 1.0, high) for low, high in grooves]))
    left_of = [plate._replace(high=bottom) for plate in plates] if around and walls else plates
    seen = grooves[1:-1] if around else grooves  # behind the section
    marks: Marks = [
        *outline_lines(solid),
        *hatch_lines(solid),
        line_mark(complex(-4.0), complex(whole + 4.0), pen=CHAIN),
        *(edge for plate in left_of for edge in plate.edges()),
        *(line_mark(face + 1j * low, face + 1j * high, pen=THICK) for low, high in seen),
    ]
    for left, right in [(0.0, whole)] if hub else [(plate.low, plate.high) for plate in left_of]:
        marks += [line_mark(x + 1j * low, x + 1j * high, pen=THICK) for low, high in gap for x in (left, right)]
        marks += shift_marks(keyway_edge_behind_section(part, scale, right - left), left)
    for k, plate in enumerate(plates if len(plates) > 1 else (), start=1):
        above = complex((plate.low + plate.high) / 2, plate.ends[1] + PLATE_OVERRUN)
        marks.append(Words(above, f"{k}", LARGE, 0.5))
    marks += _section_dimensions(part, scale, plates)
    return marks if sheet_standard().section_side > 0.0 else mirror_marks(marks, TEXT_ABOVE_LINE)


def _plate_of_profile(profile: ComplexArray, hub_radius: float, low: float, high: float) -> Plate:
    beyond = profile.imag[sheet_standard().section_side * profile.real >= 0.0]
    ends = float(beyond.min(initial=-hub_radius)), float(beyond.max(initial=hub_radius))
    return Plate(low, high, _vertical_intervals_inside(profile), ends)


def _vertical_intervals_inside(outline: ComplexArray) -> list[Gap]:
    """Intervals of the vertical through the axis that are inside an outline [mm]."""
    if not outline.size:
        return []
    far = 2.0 * float(np.abs(outline).max())
    body = make_valid(Polygon(np.column_stack([outline.real, outline.imag])))
    inside = body.intersection(LineString([(0.0, -far), (0.0, far)]))
    bounds = (part.bounds for part in getattr(inside, "geoms", [inside]) if not part.is_empty)
    return sorted((low, high) for _, low, _, high in bounds if high - low > 1e-9)


def _intervals_between_outlines(*outlines: list[Gap]) -> list[Gap]:
    """Intervals between the outlines: inside the outer wall of a groove, outside of its inner wall.

    With a third outline around a rib: intervals inside this outline but outside of the rib.
    """
    ends = sorted(y for gaps in outlines for gap in gaps for y in gap)
    return list(zip(ends[::2], ends[1::2], strict=True))


def outline_lines(solid: Any) -> Iterator[Line]:
    """Outlines of cut material."""
    for part in getattr(solid, "geoms", [solid]):
        if not part.is_empty:
            x, y = np.asarray(part.exterior.coords.xy)
            yield Line(x + 1j * y, THICK)


def hatch_lines(solid: Any) -> Iterator[Line]:
    """Hatch lines at 45°."""
    if solid.is_empty:
        return
    x0, y0, x1, y1 = solid.bounds
    step = HATCH_DISTANCE * sqrt(2.0)
    for foot in np.arange(np.ceil((y0 - x1) / step), (y1 - x0) / step) * step:
        inside = solid.intersection(LineString([(x0, x0 + foot), (x1, x1 + foot)]))
        for part in getattr(inside, "geoms", [inside]):
            if part.geom_type == "LineString" and not part.is_empty:
                x, y = np.asarray(part.coords.xy)
                yield Line(x + 1j * y, THIN)


def keyway_edge_behind_section(part: Part, scale: float, total_length: float) -> Iterator[Line]:
    """The edge of the keyway wall and the bore, behind the section."""
    if part.bore and part.keyway_width:
        y = difference_of_squares_root(part.bore, part.keyway_width) / 2 * scale
        yield line_mark(1j * y, total_length + 1j * y, pen=THICK)


def _section_dimensions(part: Part, scale: float, plates: Sequence[Plate]) -> Marks:
    whole, foot = max(part.hub_length or 0.0, part.width) * scale, min(plate.ends[0] for plate in plates)
    hub, datums = (part.hub_diameter or 0.0) / 2 * scale, symbols.datums_of(part, bool(part.thickness))
    rows = [
        [(complex(high, ends[0]), complex(low, ends[0])) for low, high, _, ends in plates],
        *([(complex(b.low, b.ends[0]), complex(a.high, a.ends[0]))] for b, a in pairwise(plates)),
        *([[(complex(whole, -hub), 1j * plates[-1].ends[0])]] if part.has_protruding_hub and hub else []),
    ]
    marks: Marks = []
    for k, row in enumerate(rows):
        for first, last in row:
            level = first.imag - foot + FIRST_LEVEL + k * LEVEL_STEP
            along = 1.0 if first.real == plates[0].high > plates[-1].high else -1.0  # values on the free side
            marks += distance_dimension(first, last, along, -along * level, size_text((first - last).real / scale))
    if part.bore:
        radius = part.bore / 2 * scale
        marks += distance_dimension(whole - 1j * radius, whole + 1j * radius, 1j, -FIRST_LEVEL, bore_text(part))
        if part.keyway_depth:
            top = radius + part.keyway_depth * scale
            marks += distance_dimension(-1j * radius, 1j * top, 1j, FIRST_LEVEL, keyway_depth_text(part))
        place = complex(whole + FIRST_LEVEL, -radius)
        marks += datum_symbol(place, -1j, max(STEM, hub - radius), datums.bore)
    if height := part.groove_depth or part.rib_height:
        rim = plates[0].high + 1j * plates[0].ends[1]
        marks += distance_dimension(rim - height * scale, rim, 1.0, FIRST_LEVEL, size_text(height))
        marks += datum_symbol(rim - 1j * CELL, 1.0, STEM, datums.face)
    if across := part.hub_diameter or part.outer_diameter:
        half = 0.5j * across * scale
        marks += distance_dimension(
            whole - half, whole + half, 1j, -FIRST_LEVEL - LEVEL_STEP, f"Ø{size_text(across)}"
        )
    return marks
