"""Symbols of a workshop drawing: projection, roughness, profile tolerance, datums, sense of rotation.

Sources: ISO 5456-2 (projection), ISO 21920-1 (surface texture), ISO 1101 and ISO 5459 (tolerance frame, datum);
ASME Y14.3 (third-angle projection) and Y14.36M (roughness).
"""

from typing import NamedTuple

import numpy as np

from camopt.scene.part import Part
from camopt.show.sheet.dimensions import CELL, arrowhead
from camopt.show.sheet.marks import (
    CHAIN,
    LARGE,
    THICK,
    Line,
    Marks,
    Words,
    arc_points,
    circle_mark,
    closed_line,
    line_mark,
    rectangle_line,
    text_width,
)

ROTATION_ARROW = 5.0, np.radians(13.0)  # length in mm and half angle at the tip of the arrow of rotation
FRAME_PADDING = 1.5  # mm beside the text in a frame


def projection_symbol(centre: complex, is_third_angle: bool = False) -> Marks:
    """The symbol of first-angle projection: a truncated cone and, right of it, the view of its left end.

    In third angle the view is on the left.
    """
    small, large, half, over = 1.25, 2.5, 2.5, 1.0
    left, right = (centre + 5.0, centre - 5.0) if is_third_angle else (centre - 5.0, centre + 5.0)
    cone = [left + complex(side * half, end) for side, end in ((-1, small), (1, large), (1, -large), (-1, -small))]
    centre_lines = (left, half + over), (right, large + over), (right, 1j * (large + over))
    return [
        closed_line(*cone, pen=THICK),
        circle_mark(large, THICK, right),
        circle_mark(small, THICK, right),
        *(line_mark(middle - reach, middle + reach, pen=CHAIN) for middle, reach in centre_lines),
    ]


def roughness_symbol(foot: complex, text: str) -> Marks:
    """The symbol of a machined surface, standing on its foot; a number alone is over its bar (ASME Y14.36M)."""
    low, high = 1.4 * LARGE, 3.0 * LARGE
    slope = 1 / np.tan(np.radians(60.0))
    left, right = foot + low * complex(-slope, 1.0), foot + high * complex(slope, 1.0)
    if "Ra" not in text:
        words = Words(foot + complex(low * slope - 0.6, low + 1.4), text, LARGE, 1.0)
        return [line_mark(left, foot, right), line_mark(left, foot + low * complex(slope, 1.0)), words]
    bar = right + text_width(text, LARGE) + 2 * FRAME_PADDING
    return [
        line_mark(left, foot, right, bar),
        line_mark(left, foot + low * complex(slope, 1.0)),
        Words(right + complex(FRAME_PADDING, -LARGE - 1.2), text, LARGE),
    ]


class Datums(NamedTuple):
    """Letters of the datums of the profile tolerance; empty if a datum is missing."""

    bore: str
    keyway: str
    """Datum of the middle of the keyway width, which fixes the angle of the cam."""
    face: str
    """Datum that locates a groove along the axis: lower face of a cylinder, or grooved face of a disc."""


def datums_of(part: Part, has_section: bool) -> Datums:
    """The datums of a part with a profile tolerance and a section that shows the bore."""
    bore = bool(part.bore) and has_section and part.profile_tolerance is not None
    present = bore, bore and bool(part.keyway_width), bore and bool(part.groove_depth or part.rib_height)
    letters = iter("ABC")
    return Datums(*(next(letters) if datum else "" for datum in present))


def tolerance_frame(corner: complex, zone_width_text: str, datums: Datums) -> Marks:
    """The tolerance frame of a line profile with its zone width, from its lower left corner.

    Each datum has a cell; the bore is the first.
    """
    letters = [letter for letter in datums if letter]
    cells = [CELL, text_width(zone_width_text, LARGE) + 2 * FRAME_PADDING, *(CELL for _ in letters)]
    edges = corner + np.cumsum([0.0, *cells])
    base, radius = corner + complex(CELL / 2, CELL * 0.32), LARGE * 0.75
    foot = 1j * (CELL - LARGE) / 2
    return [
        rectangle_line(corner, edges[-1] + 1j * CELL),
        *(line_mark(x, x + 1j * CELL) for x in edges[1:-1]),
        Line(arc_points(radius, 0.0, np.pi, base), THICK),
        *(
            Words((a + b) / 2 + foot, text, LARGE, 0.5)
            for a, b, text in zip(edges[1:-1], edges[2:], [zone_width_text, *letters], strict=True)
        ),
    ]


def rotation_symbol(radius: float, middle_direction: float, sense: float) -> Marks:
    """An arc around the centre with an arrow in the sense of rotation (+1 ccw), centred at a direction [rad]."""
    half, lean = min(np.radians(14.0), 14.0 / radius), sense * ROTATION_ARROW[0] / (2 * radius)
    ends = middle_direction - sense * half, middle_direction + sense * half
    head = arrowhead(radius * np.exp(1j * ends[1]), 1j * sense * np.exp(1j * (ends[1] - lean)), *ROTATION_ARROW)
    return [Line(arc_points(radius, ends[0], ends[1] - 2 * lean), THICK), head]
