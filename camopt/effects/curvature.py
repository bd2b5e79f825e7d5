"""Curvature of pitch curve and profile, undercut, and the largest cutter.

With a trace point, κ_profile = κ/(1 − κ·R_r): the profile's least convex radius is 1/κ_max − R_r, the cam is
undercut where κ·R_r ≥ 1 (a test of sign, no difference of radii), and a cutter reaches the most concave flank
if it is no larger than R_r + 1/|κ_min|. A groove is touched on both flanks, so |κ| takes the place of κ. A flat
face touches the profile itself: ρ is linear in y and y''. A corner of the motion is a corner of the curve.
"""

from typing import Any

import numpy as np

from camopt.effects.case import Case, Effect, Subject
from camopt.motion.table import TURN
from camopt.numerics.extremes import LARGEST, LEAST


def offers(subject: Subject) -> tuple[str, ...]:
    if subject.mechanism.curvature is None:
        return ("profile_radius_min_mm", "undercut")
    names = ("pitch_curvature_max_per_mm", "pitch_curvature_min_per_mm", "profile_radius_min_mm", "undercut")
    return (*names, "cutter_radius_max_mm")


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    return _flat(case) if case.subject.mechanism.curvature is None else _trace_point(case)


def _flat(case: Case) -> dict[str, Any]:
    assert case.subject.mechanism.profile_radius is not None
    (radius,), _ = case.extremes(case.subject.mechanism.profile_radius, [(TURN, LEAST)])
    if any(corner.size < 0.0 for corner in case.programme.corners):
        radius = np.full_like(radius, -np.inf)
    return {"profile_radius_min_mm": radius, "undercut": radius <= 0.0}


def _trace_point(case: Case) -> dict[str, Any]:
    mechanism, roller = case.subject.mechanism, case.designs.roller_radius
    assert mechanism.curvature is not None
    (most, least), _ = case.extremes(mechanism.curvature, [(TURN, LARGEST), (TURN, LEAST)])
    convex_sign = 1.0 if mechanism.grooved else -1.0  # of a jump of y' that makes a convex corner
    for corner in case.programme.corners:
        if corner.size * convex_sign > 0.0:
            most = np.full_like(most, np.inf)
        else:
            least = np.full_like(least, -np.inf)
    sharpest = np.maximum(most, -least) if mechanism.grooved else most
    concave = np.maximum(sharpest, 0.0) if mechanism.grooved else np.maximum(-least, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        product = np.where(roller > 0.0, sharpest * roller, 0.0)
        return {
            "pitch_curvature_max_per_mm": most,
            "pitch_curvature_min_per_mm": least,
            "profile_radius_min_mm": np.where(sharpest > 0.0, 1.0 / sharpest - roller, np.inf),
            "cutter_radius_max_mm": roller + 1.0 / concave,
            "undercut": product >= 1.0,
        }


EFFECT = Effect("curvature", offers, run)
