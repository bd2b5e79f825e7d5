"""The hole for the shaft as points of a sheet, in mm in the cam's own frame."""

from math import asin

import numpy as np

from camopt.contour.hole import keyway_corners
from camopt.mechanisms.design import ComplexArray
from camopt.scene.fits import depth_tolerance
from camopt.scene.part import Part
from camopt.sheet.marks import arc_points, said


def bore_said(part: Part) -> str:
    """The bore's diameter, with its fit."""
    return f"Ø{said(part.bore or 0.0)}{after_size(part.bore_fit)}"


def keyway_width_said(part: Part) -> str:
    """The keyway's width, with its fit."""
    return f"{said(part.keyway_width or 0.0)}{after_size(part.keyway_fit)}"


def keyway_depth_said(part: Part) -> str:
    """From the bore's surface to the keyway's bottom, with the tolerance of DIN 6885 where the width has a fit."""
    depth = said((part.bore or 0.0) + (part.keyway_depth or 0.0))
    return f"{depth} +{said(depth_tolerance(part.keyway_width or 0.0))}" if part.keyway_fit else depth


def after_size(fit: str | None) -> str:
    """A fit behind its dimension; nothing if there is none."""
    return f" {fit}" if fit else ""


def hole_outline(part: Part, turn: float) -> ComplexArray:
    """The closed outline of a bore, and of its keyway if it has one, whose middle is in a direction (rad)."""
    radius = (part.bore or 0.0) / 2
    if not part.keyway_width:
        return arc_points(radius)
    half = asin(part.keyway_width / 2 / radius)
    corners = keyway_corners(part, turn)
    return np.concatenate([corners, arc_points(radius, turn + half, turn + 2 * np.pi - half), corners[:1]])
