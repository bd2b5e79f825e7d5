"""The cam as curves in its own frame: pitch curve, profile and cutter path, as complex points x + iy in mm."""

from typing import NamedTuple

import numpy as np

from camopt.mechanisms.design import ComplexArray, Designs, Mechanism
from camopt.motion.programme import Programme
from camopt.numerics import FloatArray


class CamCurves(NamedTuple):
    """Curves of one design at cam angles (m,). A disc cam in its own frame; a cylindrical cam developed.

    ``profile`` has two rows for a groove (its flanks), one otherwise. For a flat face pitch curve and profile
    are the same: the contact points.
    """

    pitch: ComplexArray
    normal: ComplexArray
    profile: ComplexArray
    cutter: ComplexArray | None


def cam_curves(
    mechanism: Mechanism,
    design: Designs,
    programme: Programme,
    angles: FloatArray,
    cutter_radius: float | None = None,
) -> CamCurves:
    """Pitch curve, outward normal, profile and path of the cutter's centre of one design.

    p = e^{∓iθ}·(trace point), profile p − R_r·n, cutter path p + (R_c − R_r)·n; angles in rad, lengths in mm.
    """
    travel = mechanism.travel(design, programme, angles)
    turn = np.ones_like(angles) if mechanism.grooved else np.exp(-1j * design.sense * angles)
    pitch, normal = turn * travel.trace, turn * travel.normal
    radius = design.roller_radius[0]
    sides = np.array([[1.0], [-1.0]]) if mechanism.grooved else np.array([[1.0]])
    profile = pitch - sides * radius * normal
    cutter = None if cutter_radius is None else pitch + (cutter_radius - radius) * normal
    return CamCurves(pitch, normal, profile, cutter)


def profile_points(mechanism: Mechanism, design: Designs, programme: Programme, angles: FloatArray) -> ComplexArray:
    """The profile of a disc cam at cam angles in rad."""
    points: ComplexArray = cam_curves(mechanism, design, programme, angles).profile[0]
    return points
