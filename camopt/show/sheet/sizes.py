"""Texts of sizes on a drawing: bore and keyway with fits, width of a groove with clearance."""

from math import asin
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray
from camopt.scene.fits import keyway_depth_tolerance
from camopt.scene.iso286 import Deviations, limit_deviations
from camopt.scene.part import Part
from camopt.show.sheet.dimensions import CELL
from camopt.show.sheet.marks import Marks, arc_points, line_mark, marks_box
from camopt.show.sheet.standards import length_text, sheet_standard, size_text
from camopt.show.sheet.symbols import datums_of, roughness_symbol, tolerance_frame
from camopt.show.sheet.true_cam import TrueCam
from camopt.solve.contour.hole import keyway_corners


def bore_text(part: Part) -> str:
    """Text of the bore diameter with its fit."""
    return f"Ø{size_text_with_fit(part.bore or 0.0, part.bore_fit)}"


def keyway_depth_text(part: Part) -> str:
    """Text of the depth from bore to keyway bottom, with the tolerance of DIN 6885 if the keyway has a fit."""
    depth, more = (part.bore or 0.0) + (part.keyway_depth or 0.0), keyway_depth_tolerance(part.keyway_width or 0.0)
    if not part.keyway_fit:
        return size_text(depth)
    return sheet_standard().toleranced_text(depth, f"+{length_text(more)}", Deviations(0.0, more))


def size_text_with_fit(size: float, fit: str | None) -> str:
    """Text of a size with its fit, if it has one."""
    return sheet_standard().toleranced_text(size, fit, fit_deviations(fit, size)) if fit else size_text(size)


def fit_deviations(fit: str, size: float) -> Deviations | None:
    """Limit deviations of a fit; None if the standard has no such class for the size."""
    try:
        return limit_deviations(fit, size)
    except ValueError:
        return None


def bore_and_keyway_outline(part: Part, keyway_direction: float) -> ComplexArray:
    """Closed outline of a bore with its keyway, whose middle is in the direction ``keyway_direction`` [rad]."""
    radius = (part.bore or 0.0) / 2
    if not part.keyway_width:
        return arc_points(radius)
    half = asin(part.keyway_width / 2 / radius)
    corners = keyway_corners(part, keyway_direction)
    return np.concatenate(
        [corners, arc_points(radius, keyway_direction + half, keyway_direction + 2 * np.pi - half), corners[:1]]
    )


def profile_symbols(part: Part, has_section: bool) -> Marks:
    """Requirements on the profile: tolerance frame at the level of a leader, roughness above it."""
    marks: Marks = []
    if part.profile_tolerance is not None:
        marks = tolerance_frame(0j, length_text(2 * part.profile_tolerance, 4), datums_of(part, has_section))
    elif part.roughness is not None:
        marks = [line_mark(0.5j * CELL, 10.0 + 0.5j * CELL)]
    if part.roughness is not None:
        foot = complex(5.0, marks_box(marks).high.imag)
        marks += roughness_symbol(foot, sheet_standard().roughness_text(part.roughness))
    return marks


class Clearance(NamedTuple):
    """Width of a groove less that of its roller [mm]."""

    given: float | None
    """Clearance of the scene, which flanks in files have."""
    ends: tuple[float, float] | None
    """Smallest and largest clearance: by the fit, else by the tolerance of both walls."""


def groove_clearance(cam: TrueCam) -> Clearance:
    """The clearance of the roller in a groove."""
    drive, fit, tolerance = cam.scene.drive, cam.part.groove_fit, cam.part.profile_tolerance
    given = drive.clearance if drive else None
    if fit and cam.roller_radius:
        return Clearance(given, fit_deviations(fit, 2 * cam.roller_radius))
    if given is not None and tolerance is not None:
        return Clearance(given, (given - 2 * tolerance, given + 2 * tolerance))
    return Clearance(given, None)


def groove_width_text(cam: TrueCam) -> str:
    """Text of the width of a groove: the roller diameter with a fit, or the width in files."""
    if cam.part.groove_fit:
        return size_text_with_fit(2 * cam.roller_radius, cam.part.groove_fit)
    return length_text(2 * cam.problem.wall_distance_from_pitch_curve)
