"""The cam as curves in its own frame: pitch curve and profile, as complex points x + iy in mm."""

from typing import NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.model.mechanisms.design import Designs, Mechanism
from camopt.model.motion.programme import Programme


class CamCurves(NamedTuple):
    """Curves of one design at cam angles (m,): a disc cam in its own frame, a cylindrical cam developed.

    ``profile`` has one row for each flank. With a flat face, pitch curve and profile are both the contact points.
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
    travel = mechanism.trace_and_normal(design, programme, angles)
    turn = np.ones_like(angles) if mechanism.body.developed else np.exp(-1j * design.sense * angles)
    pitch, normal = turn * travel.trace, turn * travel.normal
    inwards = np.array([[-flank.side] for flank in mechanism.flanks])
    return CamCurves(pitch, normal, pitch - inwards * design.roller_radius[0] * normal)


def curve_distances_along_normal(
    mechanism: Mechanism, body_radius: float, cutter_radius: float | None = None
) -> dict[str, float]:
    """Distance of each curve of one design along the normal of its pitch curve or flat face, by name [mm].

    The curves are ``pitch`` (not with a flat face, which has no trace point), ``profile``, and, if its radius is
    given, ``cutter``, the path of the cutter's centre. A groove has ``profile_left`` and ``profile_right``, seen
    along the motion of the roller in it, and its cutter paths likewise.

    ``body_radius`` is that of the follower's round body plus half its clearance.
    """
    distances = {} if mechanism.flat_faced else {"pitch": 0.0}
    outward = {"profile": -body_radius} | ({} if cutter_radius is None else {"cutter": cutter_radius - body_radius})
    for name, distance in outward.items():
        for flank in reversed(mechanism.flanks):
            distances[f"{name}_{flank.name}" if flank.name else name] = -flank.side * distance
    return distances


def profile_points(mechanism: Mechanism, design: Designs, programme: Programme, angles: FloatArray) -> ComplexArray:
    """Points of a disc cam's profile at cam angles in rad [mm]."""
    return np.asarray(cam_curves(mechanism, design, programme, angles).profile[0])
