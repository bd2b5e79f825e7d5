"""Curvature of pitch curve and profile, undercut, and the largest cutter.

With a trace point, the profile has the curvature κ/(1 − κ·R_r). Its least convex radius is 1/κ_max − R_r. The cam
is undercut where κ·R_r ≥ 1; this is a test of sign, without a difference of radii. A cutter reaches the most
concave flank if its radius is at most R_r + 1/|κ_min|.

In a groove the roller touches both flanks, so |κ| takes the place of κ; a cutter of the roller's size reaches all
flanks. With a clearance j the flanks are R_r + j/2 from the pitch curve, and R_r + j/2 takes the place of R_r. A
flat face touches the profile itself, and ρ is linear in y and y''. A corner of the motion is a corner of the curve.
If the scene gives the profile, its radii are known.
"""

from operator import attrgetter
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, FloatArray
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup
from camopt.model.effects.peak import (
    ConvexRadiusScale,
    CutterRadiusScale,
    Peak,
    is_infinite_by_velocity_jumps,
)
from camopt.model.effects.peak_columns import largest_and_least_columns, peak_column
from camopt.model.mechanisms.design import unreduced_designs
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES

CONVEX_RADIUS, CUTTER_RADIUS = "profile_radius_min_mm", "cutter_radius_max_mm"
PITCH_PAIR = ("pitch_curvature_max_per_mm", "pitch_curvature_min_per_mm")


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    if setup.mechanism.curvature is None:
        return (CONVEX_RADIUS, "undercut")
    return (
        *PITCH_PAIR,
        CONVEX_RADIUS,
        "undercut",
        *(() if setup.mechanism.is_cut_by_roller_sized_cutter else (CUTTER_RADIUS,)),
    )


def peaks(setup: Setup) -> dict[str, Peak]:
    mechanism = setup.mechanism
    flank = mechanism.flanks[0]
    below = mechanism.reverses == (flank.side > 0.0)  # the profile is below the trace point along the motion
    pointed, notched = (
        (speed_falls_at_any_corner, speed_rises_at_any_corner)
        if below
        else (speed_rises_at_any_corner, speed_falls_at_any_corner)
    )
    if mechanism.curvature is None:
        assert mechanism.profile_radius is not None
        curves = ((mechanism.profile_radius, ALL_STROKES),)
        radius = Peak(curves, LEAST, jumps=pointed, unit=attrgetter("size"), open_at_zero=True)
        return {
            CONVEX_RADIUS: radius._replace(
                per_body=0.0 if mechanism.standard_profile_reduction is unreduced_designs else 1.0
            )
        }
    curves = ((mechanism.curvature, ALL_STROKES),)
    most, least = (pointed, notched) if flank.bulge > 0.0 else (notched, pointed)
    # with two flanks either one may be the sharper
    goal, sharp = (
        (LARGEST_MAGNITUDE, is_infinite_by_velocity_jumps)
        if mechanism.has_flanks_on_both_sides
        else (LARGEST, pointed)
    )
    wider = None if setup.given.drive.clearance is None else setup.pitch_to_flank_distance
    radii = {
        "pitch_curvature_max_per_mm": Peak(curves, LARGEST, jumps=most),
        "pitch_curvature_min_per_mm": Peak(curves, LEAST, jumps=least),
        CONVEX_RADIUS: Peak(curves, goal, ConvexRadiusScale(wider), sharp, extremes=PITCH_PAIR, open_at_zero=True),
        CUTTER_RADIUS: Peak(curves, LEAST, CutterRadiusScale(), notched, extremes=PITCH_PAIR),
    }
    return {
        name: radii[name] for name in radii if name != CUTTER_RADIUS or not mechanism.is_cut_by_roller_sized_cutter
    }


def speed_falls_at_any_corner(programme: Programme) -> bool:
    """Whether the follower's speed falls at a corner, where a disc cam's profile is pointed."""
    return any(corner.size < 0.0 for corner in programme.corners)


def speed_rises_at_any_corner(programme: Programme) -> bool:
    """Whether the follower's speed rises at a corner, where a disc cam's profile is hollow."""
    return any(corner.size > 0.0 for corner in programme.corners)


def evaluate_pitch_curve_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    """Extremes of the pitch curve's curvature, from which ``evaluate_columns`` computes the other quantities."""
    if case.setup.mechanism.curvature is None:
        return {}
    if case.programme.radii:  # a cam of arcs and lines, each of constant curvature
        curvature = 1.0 / np.array(case.programme.radii)
        most, least = (np.full(len(case.designs), extreme) for extreme in (curvature.max(), curvature.min()))
        exact, scale = np.zeros_like(most), np.maximum(np.abs(most), np.abs(least))
        columns = EnclosedValue(most, exact, scale), EnclosedValue(least, exact, scale)
    else:
        columns = largest_and_least_columns(case, *map(peaks(case.setup).__getitem__, PITCH_PAIR))
    return dict(zip(PITCH_PAIR, columns, strict=True))


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    if case.setup.mechanism.curvature is None:
        return _flat_face_curvature_columns(case)
    roller, both = case.setup.pitch_to_flank_distance(case.designs), case.setup.mechanism.has_flanks_on_both_sides
    (most, least), (highest, lowest) = (
        map(case.columns.__getitem__, PITCH_PAIR),
        map(case.outer_end_of_column_enclosure, PITCH_PAIR),
    )
    if both:
        most, highest = np.maximum(most, -least), np.maximum(highest, -lowest)
    radius, inwards = _radius_and_change_to_other_curvature(most, highest)
    columns: dict[str, Any] = {CONVEX_RADIUS: EnclosedValue(radius - roller, inwards, radius)}
    if "undercut" in wanted_quantities:
        columns["undercut"] = np.where(roller > 0.0, np.maximum(most, 0.0), 0.0) * roller >= 1.0
    if CUTTER_RADIUS in wanted_quantities and not case.setup.mechanism.is_cut_by_roller_sized_cutter:
        radius, inwards = _radius_and_change_to_other_curvature(-least, -lowest)
        columns[CUTTER_RADIUS] = EnclosedValue(roller + radius, inwards, roller + radius)
    return columns


def _flat_face_curvature_columns(case: EvaluationBlock) -> dict[str, Any]:
    if case.programme.radii:
        radius = np.full(len(case.designs), min(case.programme.radii))
        return {CONVEX_RADIUS: EnclosedValue(radius, np.zeros_like(radius), radius), "undercut": radius <= 0.0}
    least = peak_column(case, peaks(case.setup)[CONVEX_RADIUS])
    return {CONVEX_RADIUS: least, "undercut": least.value <= 0.0}


@np.errstate(divide="ignore", invalid="ignore")
def _radius_and_change_to_other_curvature(
    curvature: FloatArray, larger_curvature: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Radius of a curvature, infinite if that is 0 or less; and the change to the radius of a larger curvature."""
    radius = 1.0 / np.maximum(curvature, 0.0)
    inwards = np.minimum(1.0 / np.maximum(larger_curvature, 0.0) - radius, 0.0)
    return radius, np.where(np.isfinite(radius), inwards, 0.0)


EFFECT = Effect(
    "curvature",
    applicable_quantities,
    evaluate_columns,
    input_quantities=lambda setup: () if setup.mechanism.curvature is None else PITCH_PAIR,
    evaluate_pitch_curve_columns=evaluate_pitch_curve_columns,
    peaks=peaks,
    is_per_contact=True,
)
