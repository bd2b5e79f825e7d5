"""Radii of rollers with which a line contact bears its load at every cam angle, for all designs of a pitch curve.

Contact stress has the load N/R (``effects.loads``). It is at most 1/share where R_r·(1 − κ·R_r) ≥ n, with
n = share·N, on a flank that κ > 0 bends towards the roller and that is not undercut. At every cam angle this holds
if

    n/R_r + κ·R_r ≤ 1    or    n + κ·u ≤ √u,    u = R_r²

Neither n nor κ depends on the roller. The largest of the straight lines n + κ·u is convex, and √u is concave: the
allowed rollers of a pitch curve form one range. A straight line is below √u for the rollers

    2·n/(1 + √d)  ≤  R_r  ≤  (1 + √d)/(2·κ),    d = 1 − 4·κ·n

The line of the largest n and κ gives rollers that surely bear the load, before any search. The lines at single cam
angles exclude rollers. Only next to the ends of the remaining range the largest n/R_r + κ·R_r is searched: where it
is above 1, its angle gives another line, and so the end by Newton's method.

A flat face bears its load where ρ ≥ n. Its body adds to ρ, so the least body is the largest n − ρ, with ρ for a
body of 0.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import reduce
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST, LEAST, FloatArray, Number
from camopt.core.numerics.curves import curve_type_from_formula, curve_value
from camopt.core.numerics.piecewise import state_at_node, table_as_columns
from camopt.core.numerics.state import State
from camopt.model.effects.effect import EvaluationBlock
from camopt.model.effects.force import least_and_largest_contact_force
from camopt.model.effects.loads import flank_path_curvature_curve, normal_force_curve
from camopt.model.effects.peak import CLEAR_SHARE, Peak, RadiusRange, is_infinite_by_velocity_jumps
from camopt.model.effects.peak_columns import peak_column, peak_extremes
from camopt.model.effects.pressure import peaks
from camopt.model.mechanisms.design import Designs
from camopt.model.mechanisms.elements import Flank
from camopt.model.motion.stroke import ALL_STROKES

PROBED_CURVES, TRIALS = 16, 2  # pitch curves probed at all nodes; rollers tried at each end of a range
TRIAL_STEP, MOST_USED = 1e-5, 1.0 - 1e-6  # relative distance of these rollers from the end; share that is below 1


@curve_type_from_formula(reads_load=True)
def roller_load_utilisation(
    state: State, normal: Number, curvature: Number, normal_force_factor: Number, curvature_factor: Number
) -> Number:
    """Curve n/R_r + κ·R_r, at most 1 where a roller bears its load.

    ``normal_force_factor`` is that of n over R_r, with the sign of the force on the flank. ``curvature_factor`` is
    R_r times the sign of κ.
    """
    return normal_force_factor * normal + curvature_factor * curvature


@curve_type_from_formula(reads_load=True)
def flat_face_radius_shortfall(
    state: State, normal: Number, profile_radius: Number, inverse_allowed_load: Number
) -> Number:
    """Curve n − ρ, the least further radius with which a flat face bears its load [mm]."""
    return inverse_allowed_load * normal - profile_radius


def sure_and_possible_radii_for_load(
    case: EvaluationBlock, inverse_allowed_load: Callable[[Designs], Any], body_radii: RadiusRange
) -> tuple[RadiusRange, RadiusRange]:
    """The radii of ``body_radii`` with which pitch curves surely bear a load, and those with which they may.

    The designs have a point as their follower, which moves along their pitch curves; guides have no friction.
    """
    shares = inverse_allowed_load(case.designs) + np.zeros(len(case.designs))
    if case.setup.mechanism.flat_faced:
        return _flat_face_radii_for_load(case, shares, max(map(abs, body_radii)))
    if is_infinite_by_velocity_jumps(case.programme) or not shares.size:
        return RadiusRange(np.inf, -np.inf), RadiusRange(np.inf, -np.inf)
    ranges = [
        _roller_radii_for_flank_load(case, each, each.pressing * shares, body_radii)
        for each in case.setup.mechanism.flanks
    ]
    sure, possible = (reduce(RadiusRange.intersection, each) for each in zip(*ranges, strict=True))
    return sure, possible


def _flat_face_radii_for_load(
    case: EvaluationBlock, inverse_allowed_loads: FloatArray, rounding_scale: float
) -> tuple[RadiusRange, RadiusRange]:
    """The sure and the possible bodies of a flat face, from the largest n − ρ with a margin for rounding."""
    assert case.setup.mechanism.profile_radius is not None
    radius = case.setup.mechanism.profile_radius(case.designs, case.programme)
    curve = flat_face_radius_shortfall(
        normal_force_curve(case.setup, case.designs, case.programme), radius, inverse_allowed_loads
    )
    largest = peak_extremes(
        case, Peak(((lambda *_: curve, ALL_STROKES),), LARGEST, jumps=is_infinite_by_velocity_jumps)
    )
    finite = np.where(np.isfinite(largest.value), np.abs(largest.value), 0.0)
    margin = largest.width + CLEAR_SHARE * (finite + rounding_scale)
    return RadiusRange(least=largest.value + margin), RadiusRange(least=largest.value - margin)


def _roller_radii_for_flank_load(
    case: EvaluationBlock, flank: Flank, inverse_allowed_loads: FloatArray, body_radii: RadiusRange
) -> tuple[RadiusRange, RadiusRange]:
    """The rollers of ``body_radii`` with which pitch curves surely bear the load of a flank, and may bear it.

    ``inverse_allowed_loads`` have the sign of the force on the flank. Rollers next to both ends of the second range
    are tried; the cam angle at which one fails cuts the range.
    """
    table, sure = (
        case.programme.table,
        _roller_radii_bearing_scaled_load(
            *_scaled_load_and_curvature_upper_bounds(case, flank, inverse_allowed_loads), 1.0 + TRIAL_STEP
        ),
    )
    possible = RadiusRange(*(np.full(inverse_allowed_loads.size, radius) for radius in map(float, body_radii)))
    some = np.linspace(0, inverse_allowed_loads.size - 1, PROBED_CURVES).astype(int)
    n, bend = _scaled_load_and_curvature_at_state(
        case, flank, inverse_allowed_loads, some, state_at_node(table_as_columns(table), ...)
    )
    for node in np.unique([np.argmax(n / radius + bend * radius, axis=0) for radius in body_radii]).tolist():
        line = _scaled_load_and_curvature_at_state(
            case, flank, inverse_allowed_loads, slice(None), state_at_node(table, node)
        )
        possible = possible.intersection(_roller_radii_bearing_scaled_load(*line, 1.0 - CLEAR_SHARE))
    for end, step in ((0, TRIAL_STEP), (1, -TRIAL_STEP)) * TRIALS:
        radii = np.clip(possible[end] * (1.0 + step), *body_radii)
        index = np.flatnonzero(possible.contains(radii) & ~sure.contains(radii))
        if index.size:
            radii, part = radii[index], replace(case, designs=case.designs.take(index))
            curve = roller_load_utilisation(
                *_normal_force_and_curvature_curves(part, flank),
                inverse_allowed_loads[index] / radii,
                flank.bulge * radii,
            )
            used = part.extremes(lambda *_, curve=curve: curve, [(ALL_STROKES, LARGEST)], floor=MOST_USED)
            held = used.value[0] + used.width[0] <= 1.0 - CLEAR_SHARE
            np.minimum.at(sure.least, index[held], radii[held])
            np.maximum.at(sure.most, index[held], radii[held])
            line = _scaled_load_and_curvature_at_state(
                case, flank, inverse_allowed_loads, index, case.programme.state(np.mod(used.where[0], 2.0 * np.pi))
            )
            below = _roller_radii_bearing_scaled_load(*line, 1.0 - CLEAR_SHARE)
            np.maximum.at(possible.least, index, below.least)
            np.minimum.at(possible.most, index, below.most)
    return sure, possible


def _normal_force_and_curvature_curves(case: EvaluationBlock, flank: Flank) -> tuple[Any, Any]:
    """The curves of N and κ."""
    parts = case.setup, case.designs, case.programme
    return normal_force_curve(*parts), flank_path_curvature_curve(*parts, flank)


def _scaled_load_and_curvature_at_state(
    case: EvaluationBlock, flank: Flank, inverse_allowed_loads: FloatArray, index: Any, state: State
) -> tuple[Any, Any]:
    """n and κ of the pitch curves at an index, at one state of the motion or one for each."""
    curves = _normal_force_and_curvature_curves(replace(case, designs=case.designs.take(index)), flank)
    normal, bend = (curve_value(curve, ..., state) for curve in curves)
    return inverse_allowed_loads[index] * normal, flank.bulge * bend


def _scaled_load_and_curvature_upper_bounds(
    case: EvaluationBlock, flank: Flank, inverse_allowed_loads: FloatArray
) -> tuple[Any, Any]:
    """Upper bounds of n and κ over the turn, from the largest force, pressure angle and curvature."""
    path, name = _normal_force_and_curvature_curves(case, flank)[1], "pressure_angle_max_deg"
    sharpest = case.extremes(lambda *_: path, [(ALL_STROKES, LARGEST if flank.bulge > 0.0 else LEAST)])
    bend = flank.bulge * sharpest.value[0] + sharpest.width[0]
    force = np.maximum(*(np.abs(end.value) + np.abs(end.outward) for end in least_and_largest_contact_force(case)))
    preload = case.setup_per_design.dynamics.pair_preload
    along = force if preload is None else force + preload
    angle = (
        case.outer_end_of_column_enclosure(name)
        if name in case.columns
        else sum(peak_column(case, peaks(case.setup)[name])[:2])
    )
    lever = case.designs.arm_length if case.setup.angular else 1.0
    normal = along / lever / np.cos(np.radians(np.minimum(angle, 90.0)))
    return np.abs(inverse_allowed_loads) * normal, np.where(np.isfinite(bend), bend, np.inf)


def _roller_radii_bearing_scaled_load(scaled_load: Any, signed_curvature: Any, margin_factor: float) -> RadiusRange:
    """The rollers for which √u is at least a straight line n + κ·u times a factor; none if it is infinite."""
    scaled_load, signed_curvature = margin_factor * scaled_load, margin_factor * signed_curvature
    with np.errstate(all="ignore"):
        root = np.sqrt(1.0 - 4.0 * signed_curvature * scaled_load)
        least, most = 2.0 * scaled_load / (1.0 + root), (1.0 + root) / (2.0 * signed_curvature)
    always = np.isnan(scaled_load) | np.isnan(signed_curvature) | (np.isnan(root) & (signed_curvature < 0.0))
    never = ~always & (np.isnan(root) | (scaled_load == np.inf))
    return RadiusRange(
        np.where(never, np.inf, np.where(always, -np.inf, least)),
        np.where(never, -np.inf, np.where(~always & (signed_curvature > 0.0), most, np.inf)),
    )
