"""Texts of sizes on a drawing: bore and keyway with fits, width of a groove with clearance."""

from math import asin
from typing import NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray
from camopt.scene.fits import keyway_depth_tolerance
from camopt.scene.iso286 import limit_deviations
from camopt.scene.part import Part
from camopt.show.sheet.marks import arc_points, length_text
from camopt.show.sheet.true_cam import TrueCam
from camopt.solve.contour.hole import keyway_corners


def bore_text(part: Part) -> str:
    """Text of the bore diameter with its fit."""
    return f"Ø{length_text(part.bore or 0.0)}{fit_suffix(part.bore_fit)}"


def keyway_width_text(part: Part) -> str:
    """Text of the keyway width with its fit."""
    return f"{length_text(part.keyway_width or 0.0)}{fit_suffix(part.keyway_fit)}"


def keyway_depth_text(part: Part) -> str:
    """Text of the depth from bore to keyway bottom, with the tolerance of DIN 6885 if the keyway has a fit."""
    depth = length_text((part.bore or 0.0) + (part.keyway_depth or 0.0))
    return f"{depth} +{length_text(keyway_depth_tolerance(part.keyway_width or 0.0))}" if part.keyway_fit else depth


def fit_suffix(fit: str | None) -> str:
    """A fit as the end of a dimension; empty without a fit."""
    return f" {fit}" if fit else ""


def hole_outline(part: Part, turn: float) -> ComplexArray:
    """Closed outline of a bore with its keyway, whose middle is in the direction ``turn`` [rad]."""
    radius = (part.bore or 0.0) / 2
    if not part.keyway_width:
        return arc_points(radius)
    half = asin(part.keyway_width / 2 / radius)
    corners = keyway_corners(part, turn)
    return np.concatenate([corners, arc_points(radius, turn + half, turn + 2 * np.pi - half), corners[:1]])


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
        try:
            deviations = limit_deviations(fit, 2 * cam.roller_radius)
        except ValueError:  # the standard has no such class for this size
            return Clearance(given, None)
        return Clearance(given, (deviations.lower, deviations.upper))
    if given is not None and tolerance is not None:
        return Clearance(given, (given - 2 * tolerance, given + 2 * tolerance))
    return Clearance(given, None)


def groove_width_text(cam: TrueCam) -> str:
    """Text of the width of a groove: the roller diameter with a fit, or the width in files."""
    if cam.part.groove_fit:
        return f"{length_text(2 * cam.roller_radius)} {cam.part.groove_fit}"
    return length_text(2 * cam.problem.wall_distance_from_pitch_curve)
