"""The width of a groove on a drawing: by the fit of its roller, or by the clearance that the scene gives."""

from typing import NamedTuple

from camopt.scene.iso286 import deviations
from camopt.sheet.cam import TrueCam
from camopt.sheet.marks import said


class Clearance(NamedTuple):
    """How much wider than its roller a groove is, mm."""

    given: float | None
    """That of the scene, which flanks in files have."""
    ends: tuple[float, float] | None
    """From what to what it may be: by the fit, or else by the tolerance of both walls."""


def clearance_of(cam: TrueCam) -> Clearance:
    """The clearance of the roller in a groove."""
    drive, fit, tolerance = cam.scene.drive, cam.part.groove_fit, cam.part.profile_tolerance
    given = drive.clearance if drive else None
    if fit and cam.roller:
        try:
            found = deviations(fit, 2 * cam.roller)
        except ValueError:  # a class that the standard has not for this size
            return Clearance(given, None)
        return Clearance(given, (found.lower, found.upper))
    if given is not None and tolerance is not None:
        return Clearance(given, (given - 2 * tolerance, given + 2 * tolerance))
    return Clearance(given, None)


def width_said(cam: TrueCam) -> str:
    """The width of a groove: its roller's diameter with a fit, or the width that flanks in files have."""
    if cam.part.groove_fit:
        return f"{said(2 * cam.roller)} {cam.part.groove_fit}"
    return said(2 * cam.problem.half_width)
