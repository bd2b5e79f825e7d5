"""The hole for the shaft as points of a sheet, in mm in the cam's own frame."""

from math import asin

import numpy as np

from camopt.contour.hole import keyway_corners
from camopt.mechanisms.design import ComplexArray
from camopt.scene.part import Part
from camopt.sheet.marks import arc_points


def hole_outline(part: Part, turn: float) -> ComplexArray:
    """The closed outline of a bore, and of its keyway if it has one, whose middle is in a direction (rad)."""
    radius = (part.bore or 0.0) / 2
    if not part.keyway_width:
        return arc_points(radius)
    half = asin(part.keyway_width / 2 / radius)
    corners = keyway_corners(part, turn)
    return np.concatenate([corners, arc_points(radius, turn + half, turn + 2 * np.pi - half), corners[:1]])
