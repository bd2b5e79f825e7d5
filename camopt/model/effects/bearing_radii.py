"""Radii of rollers with which a line contact bears its load at every cam angle, for all designs of a pitch curve.

Contact stress has the load N/R (``effects.loads``). It is at most 1/share where R_r·(1 − κ·R_r) ≥ n, with
n = share·N, on a flank that κ > 0 bends towards the roller and that is not undercut. At every cam angle this holds
if

    M(u) ≤ √u,    M(u) = max(n + κ·u) over the turn,    u = R_r²

Neither n nor κ depends on the roller. M is the largest of straight lines and so convex, and √u is concave: the
allowed rollers of a pitch curve form one range. A few values of M enclose its ends: between two values M is below
their chord, and beyond them above it. A straight line n + κ·u is below √u for the rollers

    2·n/(1 + √d)  ≤  R_r  ≤  (1 + √d)/(2·κ),    d = 1 − 4·κ·n

A flat face bears its load where ρ ≥ n. Its body adds to ρ, so the least body is the largest n − ρ, with ρ for a
body of 0.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import sqrt
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST, FloatArray
from camopt.core.numerics.curves import curve_type_from_formula
from camopt.model.effects.effect import EvaluationBlock
from camopt.model.effects.loads import flank_path_curvature, normal_force_curve
from camopt.model.effects.peak import CLEAR_SHARE, Peak, RadiusRange, jumps_at_corners
from camopt.model.effects.peak_columns import peak_extremes
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.stroke import ALL_STROKES


@curve_type_from_formula(reads_load=True)
def required_roller_radius(state, normal, curvature, share, bulge):
    """Curve n + κ·u, at most R_r where a roller bears its load [mm].

    ``share`` has the sign of the force on the flank, ``bulge`` is u times the sign of κ there.
    """
    return share * normal + bulge * curvature


@curve_type_from_formula(reads_load=True)
def required_face_radius(state, normal, radius, share):
    """Curve n − ρ, the least further radius with which a flat face bears its load [mm]."""
    return share * normal - radius


def sure_and_possible_radii_for_load(
    case: EvaluationBlock, inverse_allowed_load: Callable[[Designs], Any], body_radii: RadiusRange
) -> tuple[RadiusRange, RadiusRange]:
    """The radii of ``body_radii`` with which pitch curves surely bear a load, and those with which they may.

    The designs have a point as their follower, which moves along their pitch curves; guides have no friction.
    """
    normal = normal_force_curve(case.setup, case.designs, case.programme)
    shares = inverse_allowed_load(case.designs) + _design_zeros(case)
    if case.setup.mechanism.flat_faced:
        far, near = _enclose_largest(
            case, [_required_face_radius_curve(case, normal, shares)], max(map(abs, body_radii))
        )
        return RadiusRange(least=far), RadiusRange(least=near)
    flanks = case.setup.mechanism.flanks
    paths = [flank_path_curvature(case.setup, case.designs, case.programme, flank) for flank in flanks]
    radii, sides = _probe_radii(body_radii), []
    for radius in radii:
        spread = radius**2 + _design_zeros(case)
        curves = [
            required_roller_radius(normal, path, flank.pressing * shares, flank.bulge * spread)
            for flank, path in zip(flanks, paths, strict=True)
        ]
        sides.append(_enclose_largest(case, curves, radius))
    most, least = zip(*sides, strict=True)
    return _surely_bearing_radii(radii, most), _possibly_bearing_radii(radii, most, least)


def _probe_radii(body_radii: RadiusRange) -> list[float]:
    """The rollers at which M is computed: the least, the largest, and their geometric mean."""
    low, high = map(float, body_radii)
    return [low, sqrt(low * high), high] if low < high else [low]


def _surely_bearing_radii(radii: Sequence[float], upper_bounds: Sequence[FloatArray]) -> RadiusRange:
    """The rollers with which M ≤ √u for certain, from upper bounds of M: M is below the chords between them."""
    ranges = _single_bearing_radii(radii, upper_bounds)
    for low, high, first, last in zip(radii, radii[1:], upper_bounds, upper_bounds[1:], strict=False):
        below_root = _radii_where_line_below_root(
            low, first, _chord_slope_by_squared_radius(low, first, high, last)
        )
        ranges.append(below_root.intersection(RadiusRange(low, high)))
    return _radius_hull(ranges)


def _possibly_bearing_radii(
    radii: Sequence[float], upper_bounds: Sequence[FloatArray], lower_bounds: Sequence[FloatArray]
) -> RadiusRange:
    """The rollers with which M ≤ √u is possible, from upper and lower bounds of M.

    Between two rollers M is above the chords of its neighbours, extended: these give the lower bounds.
    """
    ranges = _single_bearing_radii(radii, lower_bounds)
    for i, (low, high) in enumerate(pairwise(radii)):
        between = RadiusRange(low, high)
        if i > 0:
            slope = _chord_slope_by_squared_radius(radii[i - 1], upper_bounds[i - 1], low, lower_bounds[i])
            between = between.intersection(_radii_where_line_below_root(low, lower_bounds[i], slope))
        if i + 2 < len(radii):
            slope = _chord_slope_by_squared_radius(high, lower_bounds[i + 1], radii[i + 2], upper_bounds[i + 2])
            between = between.intersection(_radii_where_line_below_root(high, lower_bounds[i + 1], slope))
        ranges.append(between)
    return _radius_hull(ranges)


def _single_bearing_radii(radii: Sequence[float], required_values: Sequence[FloatArray]) -> list[RadiusRange]:
    """For each roller a range: itself alone if it bears its load (M ≤ √u), else empty."""
    return [
        RadiusRange(radius, np.where(value <= radius, radius, -np.inf))
        for radius, value in zip(radii, required_values, strict=True)
    ]


def _chord_slope_by_squared_radius(low: float, first: FloatArray, high: float, last: FloatArray) -> FloatArray:
    """Slope by u of the straight line through two values of M."""
    with np.errstate(invalid="ignore"):  # loads may be infinite
        return np.asarray((last - first) / (high**2 - low**2))


def _radii_where_line_below_root(radius: float, value: FloatArray, slope: FloatArray) -> RadiusRange:
    """The rollers for which a straight line is at most √u; none if it is infinite.

    The line has a value at one roller, and a slope by u.
    """
    with np.errstate(all="ignore"):
        start = value - slope * radius**2
        root = np.sqrt(1.0 - 4.0 * slope * start)
        least, most = 2.0 * start / (1.0 + root), (1.0 + root) / (2.0 * slope)
    always, never = np.isnan(root) & (slope < 0.0), np.isnan(root) & ~(slope < 0.0)
    return RadiusRange(
        np.where(never, np.inf, np.where(always, -np.inf, least)),
        np.where(never, -np.inf, np.where(slope > 0.0, most, np.inf)),
    )


def _radius_hull(ranges: Sequence[RadiusRange]) -> RadiusRange:
    """The least range that contains several ranges; empty where all are."""
    least, most = (np.array(np.broadcast_arrays(*ends)) for ends in zip(*ranges, strict=True))
    filled = least <= most
    return RadiusRange(np.where(filled, least, np.inf).min(axis=0), np.where(filled, most, -np.inf).max(axis=0))


def _enclose_largest(case: EvaluationBlock, curves: Sequence[Any], scale: float) -> tuple[FloatArray, FloatArray]:
    """Upper and lower bound of the largest value of some curves, with a margin for rounding."""
    variants = tuple((lambda *_, curve=curve: curve, ALL_STROKES) for curve in curves)
    largest = peak_extremes(case, Peak(variants, LARGEST, jumps=jumps_at_corners))
    finite = np.where(np.isfinite(largest.value), np.abs(largest.value), 0.0)
    margin = largest.width + CLEAR_SHARE * (finite + scale)
    return largest.value + margin, largest.value - margin


def _required_face_radius_curve(case: EvaluationBlock, normal: Any, shares: FloatArray) -> Any:
    assert case.setup.mechanism.profile_radius is not None
    return required_face_radius(normal, case.setup.mechanism.profile_radius(case.designs, case.programme), shares)


def _design_zeros(case: EvaluationBlock) -> FloatArray:
    return np.zeros(len(case.designs))
