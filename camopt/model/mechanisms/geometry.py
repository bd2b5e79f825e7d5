"""The cam as curves in its own frame: pitch curve and profile, as complex points x + iy in mm."""

from typing import NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.model.mechanisms.design import Designs, Mechanism
from camopt.model.motion.programme import Programme


class CamCurves(NamedTuple):
    """Curves of one design at cam angles (m,). A disc cam in its own frame; a cylindrical cam developed.

    ``profile`` has a row for each flank of the mechanism. For a flat face pitch curve and profile
    are the same: the contact points.
    """

    pitch: ComplexArray
    normal: ComplexArray
    profile: ComplexArray


def cam_curves(
    mechanism: Mechanism,
    design: Designs,
    programme: Programme,
    angles: FloatArray,
) -> CamCurves:
    """Pitch curve, outward normal and profile of one design.

    p = e^{∓iθ}·(trace point), profile p − R_r·n; angles in rad, lengths in mm.
    """
    travel = mechanism.travel(design, programme, angles)
    turn = np.ones_like(angles) if mechanism.body.developed else np.exp(-1j * design.sense * angles)
    pitch, normal = turn * travel.trace, turn * travel.normal
    radius = design.roller_radius[0]
    inwards = np.array([[-flank.side] for flank in mechanism.flanks])
    profile = pitch - inwards * radius * normal
    return CamCurves(pitch, normal, profile)


def mirror_curves(curves: CamCurves) -> CamCurves:
    """The curves of a second disc in the cam's own frame, from those in the mirror (``mechanisms.pairs``)."""
    return CamCurves(*(each.conj() for each in curves))


def normal_distances(mechanism: Mechanism, radius: float, cutter_radius: float | None = None) -> dict[str, float]:
    """Distance (mm) of each curve of one design along the normal of its pitch curve, or of its flat face, by name.

    ``radius`` is that of the follower's round body with half its clearance.

    ``pitch`` (not for a flat face, which has no trace point), ``profile``, and ``cutter``, the path of the centre
    of a cutter, if its radius is given. A groove has ``profile_left`` and ``profile_right``, and two cutter paths
    likewise: left and right are seen along the motion of the roller in it.
    """
    found = {} if mechanism.flat_faced else {"pitch": 0.0}
    out = {"profile": -radius} | ({} if cutter_radius is None else {"cutter": cutter_radius - radius})
    for name, distance in out.items():
        for flank in reversed(mechanism.flanks):
            found[f"{name}_{flank.name}" if flank.name else name] = -flank.side * distance
    return found


def profile_points(mechanism: Mechanism, design: Designs, programme: Programme, angles: FloatArray) -> ComplexArray:
    """The profile of a disc cam at cam angles in rad."""
    points: ComplexArray = cam_curves(mechanism, design, programme, angles).profile[0]
    return points
