"""The hole for the shaft: a bore with its keyway, in mm in the cam's own frame."""

from math import asin, radians, sqrt

import numpy as np

from camopt.mechanisms.design import ComplexArray
from camopt.scene.part import Part
from camopt.sheet.marks import arc_points


def keyway_corners(part: Part, turn: float) -> ComplexArray:
    """Of a keyway whose middle is in a direction (rad): from its bottom's right corner, seen from the axis, on."""
    half, bottom = (part.keyway_width or 0.0) / 2, (part.bore or 0.0) / 2 + (part.keyway_depth or 0.0)
    mouth = sqrt((part.bore or 0.0) ** 2 / 4 - half**2)
    corners = np.array([complex(mouth, -half), complex(bottom, -half), complex(bottom, half), complex(mouth, half)])
    return np.asarray(corners * np.exp(1j * turn))


def hole_outline(part: Part, turn: float) -> ComplexArray:
    """The closed outline of a bore, and of its keyway if it has one, whose middle is in a direction (rad)."""
    radius = (part.bore or 0.0) / 2
    if not part.keyway_width:
        return arc_points(radius)
    half = asin(part.keyway_width / 2 / radius)
    corners = keyway_corners(part, turn)
    return np.concatenate([corners, arc_points(radius, turn + half, turn + 2 * np.pi - half), corners[:1]])


def keyway_turn(part: Part) -> float:
    """The direction of the middle of the keyway, rad; straight up where there is none."""
    return radians(90.0 if part.keyway_angle is None else part.keyway_angle)
