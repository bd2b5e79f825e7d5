"""The section of a disc cam through its axis, in the place of the view from the left: plate, hub, groove and bore.

It goes through the middle of the keyway, which is above, or along the vertical centre line.
"""

from collections.abc import Iterator, Sequence
from math import sqrt
from typing import Any

import numpy as np

from camopt.contour.hole import keyway_turn
from camopt.mechanisms.design import ComplexArray
from camopt.scene.part import Part
from camopt.sheet import symbols
from camopt.sheet.dimensions import FIRST_LEVEL, LEVEL_STEP, STEM, datum_at, distance
from camopt.sheet.hole import bore_said, hole_outline, keyway_depth_said
from camopt.sheet.marks import CHAIN, THICK, THIN, Line, Marks, line, said

HATCH = 2.5  # mm between lines at 45°
Gap = tuple[float, float]


def section(outline: ComplexArray, part: Part, scale: float, walls: Sequence[ComplexArray] = ()) -> Marks:
    """The section of a plate with an outline (mm on the paper, in the cam's own frame); its axis is at y = 0.

    ``walls`` are those of a groove in its face, the inner one first.
    """
    from shapely import box, union_all

    turn = keyway_turn(part)
    upright = outline * np.exp(1j * (np.pi / 2 - turn))
    hole = hole_outline(part, np.pi / 2) * scale if part.bore else np.zeros(0, dtype=complex)
    plate, whole = (part.thickness or 0.0) * scale, max(part.hub_length or 0.0, part.thickness or 0.0) * scale
    hub = (part.hub_diameter or 0.0) / 2 * scale
    cut, gap = _crossing(upright), _crossing(hole)
    beyond = upright.imag[upright.real >= 0.0]
    ends = float(beyond.min(initial=-hub)), float(beyond.max(initial=hub))
    grooves = _between(*(_crossing(wall * np.exp(1j * (np.pi / 2 - turn))) for wall in walls)) if walls else []
    bottom = plate - (part.groove_depth or 0.0) * scale
    solid = _solid(cut, gap, hub, plate, whole)
    solid = solid.difference(union_all([box(bottom, low, plate + 1.0, high) for low, high in grooves]))
    marks: Marks = [*outlines(solid), *hatching(solid)]
    marks.append(line(0j, plate + 0j, pen=CHAIN)._replace(points=np.array([-4.0, whole + 4.0], dtype=complex)))
    edges = [ends[0], *(y for each in cut for y in each), ends[1]]
    for low, high in zip(edges[::2], edges[1::2], strict=True):  # what is behind the section
        marks += [line(x + 1j * low, x + 1j * high, pen=THICK) for x in (0.0, plate)] if high - low > 1e-6 else []
    marks += [line(1j * y, plate + 1j * y, pen=THICK) for y in ends]
    marks += [line(plate + 1j * low, plate + 1j * high, pen=THICK) for low, high in grooves]
    for low, high in gap:
        marks += [line(x + 1j * low, x + 1j * high, pen=THICK) for x in (0.0, whole)]
    marks += mouth(part, scale, whole)
    return [*marks, *_dimensions(part, scale, ends)]


def _crossing(outline: ComplexArray) -> list[Gap]:
    """The interval of the vertical through the axis that is inside an outline, mm."""
    from shapely import LineString, Polygon, make_valid

    if not outline.size:
        return []
    far = 2.0 * float(np.abs(outline).max())
    body = make_valid(Polygon(np.column_stack([outline.real, outline.imag])))
    inside = body.intersection(LineString([(0.0, -far), (0.0, far)]))
    bounds = (part.bounds for part in getattr(inside, "geoms", [inside]) if not part.is_empty)
    return sorted((low, high) for _, low, _, high in bounds if high - low > 1e-9)


def _between(inner: list[Gap], outer: list[Gap]) -> list[Gap]:
    """The intervals that are inside the outer wall of a groove and not inside its inner one."""
    ends = sorted(y for gap in (*inner, *outer) for y in gap)
    return list(zip(ends[::2], ends[1::2], strict=True))


def _solid(cut: list[Gap], gap: list[Gap], hub: float, plate: float, whole: float) -> Any:
    """The cut material, as a shape of shapely."""
    from shapely import box, union_all

    bodies = [box(0.0, low, plate, high) for low, high in cut]
    bodies += [box(0.0, -hub, whole, hub)] if hub else []
    return union_all(bodies).difference(union_all([box(-1.0, low, whole + 1.0, high) for low, high in gap]))


def outlines(solid: Any) -> Iterator[Line]:
    """Outlines of the cut material."""
    for part in getattr(solid, "geoms", [solid]):
        if not part.is_empty:
            x, y = np.asarray(part.exterior.coords.xy)
            yield Line(x + 1j * y, THICK)


def hatching(solid: Any) -> Iterator[Line]:
    """Thin lines at 45°."""
    from shapely import LineString

    if solid.is_empty:
        return
    x0, y0, x1, y1 = solid.bounds
    step = HATCH * sqrt(2.0)
    for foot in np.arange(np.ceil((y0 - x1) / step), (y1 - x0) / step) * step:
        inside = solid.intersection(LineString([(x0, x0 + foot), (x1, x1 + foot)]))
        for part in getattr(inside, "geoms", [inside]):
            if part.geom_type == "LineString" and not part.is_empty:
                x, y = np.asarray(part.coords.xy)
                yield Line(x + 1j * y, THIN)


def mouth(part: Part, scale: float, whole: float) -> Iterator[Line]:
    """The edge where the keyway's wall meets the bore, behind the section."""
    if part.bore and part.keyway_width:
        y = sqrt(part.bore**2 - part.keyway_width**2) / 2 * scale
        yield line(1j * y, whole + 1j * y, pen=THICK)


def _dimensions(part: Part, scale: float, ends: Gap) -> Marks:
    plate, whole = (part.thickness or 0.0) * scale, max(part.hub_length or 0.0, part.thickness or 0.0) * scale
    bottom = 1j * ends[0]
    marks = distance(bottom + plate, bottom, -1.0, FIRST_LEVEL, said(part.thickness or 0.0))
    if part.hub_length and part.hub_diameter:
        foot = whole - 0.5j * part.hub_diameter * scale
        marks += distance(foot, bottom, -1.0, foot.imag - ends[0] + FIRST_LEVEL + LEVEL_STEP, said(part.hub_length))
    if part.bore:
        radius = part.bore / 2 * scale
        marks += distance(whole - 1j * radius, whole + 1j * radius, 1j, -FIRST_LEVEL, bore_said(part))
        if part.keyway_depth:
            top = radius + part.keyway_depth * scale
            marks += distance(-1j * radius, 1j * top, 1j, FIRST_LEVEL, keyway_depth_said(part))
        if datum := symbols.datums_of(part, bool(part.thickness)).bore:
            foot, hub = complex(whole + FIRST_LEVEL, -radius), (part.hub_diameter or 0.0) / 2 * scale
            marks += datum_at(foot, -1j, max(STEM, hub - radius), datum)
    if part.groove_depth:
        rim = plate + 1j * ends[1]
        marks += distance(rim - part.groove_depth * scale, rim, 1.0, FIRST_LEVEL, said(part.groove_depth))
    if across := part.hub_diameter or part.outer_diameter:
        half = 0.5j * across * scale
        marks += distance(whole - half, whole + half, 1j, -FIRST_LEVEL - LEVEL_STEP, f"Ø{said(across)}")
    return marks
