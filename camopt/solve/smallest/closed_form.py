"""The smallest cam by closed forms: a lower bound of the size from the linear limits, with its design.

For a follower with a trace point the limits on the pressure angle are lines in (e, s₀):

    e + T·s₀ ≥ max (y' − T·y),    −e + T·s₀ ≥ max (−y' − T·y)

The smallest prime radius √(s₀² + e²) belongs to the point of a convex polygon that is nearest to the origin. A flat
face's profile radius and a cylindrical cam's pressure angle are linear in the size.
"""

from itertools import combinations, product

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.model.effects.peak import BodyRadiusPlus
from camopt.model.mechanisms import Designs, cylindrical, translating, translating_flat
from camopt.model.mechanisms.design import SizeBounds
from camopt.model.motion.programme import Programme, weighted_derivative_range
from camopt.model.motion.stroke import ALL_STROKES, DWELL
from camopt.scene.problem.problem import Problem, constraints_on_curve
from camopt.solve.smallest.result import RELATIVE_GAP
from camopt.solve.verdicts.feasible_filter import feasible_designs

LEAD_ZOOMS, LEADS_A_ZOOM = 14, 33
"""Rounds of the search for a convex minimum, and samples in each: enough to reach rounding."""
NUMBER_SHARES = 5  # samples of the range of each free number at which the smallest size is tried
NUDGES = (0.0, 1e-15, 4e-15, 1.6e-14, 6.4e-14, 2.6e-13, 1e-12, 4e-12)  # relative to the prime radius


def least_allowed_size(problem: Problem, bounds: SizeBounds) -> float:
    """Lower bound of the size from its range and from limits on it [mm]; above 0."""
    return max(bounds["size"][0], negligible_size(problem, bounds), *(limit.least_size for limit in problem.limits))


def size_lower_bound(problem: Problem, bounds: SizeBounds) -> float:
    """Lower bound of the size without a search [mm]: from its range, limits on it, and the base circle.

    A disc cam that dwells at its lowest is an arc of the base circle there, which must meet limits on curvature.
    """
    least = least_allowed_size(problem, bounds)
    rests = any(stroke.kind == DWELL and stroke.low == 0.0 for stroke in problem.programme.strokes)
    is_arc = rests and problem.setup.mechanism.body.closed
    return max(least, required_profile_radius(problem)) if is_arc else least


def required_profile_radius(problem: Problem) -> float:
    """Least radius of curvature that limits require of convex parts of the profile [mm]."""
    mechanism = problem.setup.mechanism
    face_radii = [
        -limit.upper_bound_of_each_side() for limit in constraints_on_curve(problem, mechanism.profile_radius)
    ]
    body_radii = [
        factor.radius
        for constraint in constraints_on_curve(problem, mechanism.curvature)
        if isinstance(factor := constraint.factor, BodyRadiusPlus)
    ]
    return float(max([0.0, *face_radii, *body_radii]))


def negligible_size(problem: Problem, bounds: SizeBounds) -> float:
    """Size below which a feasible cam has no effective limit [mm]: tiny beside lift and follower."""
    return RELATIVE_GAP * max(
        0.0 if problem.setup.angular else problem.programme.lift,
        *(abs(end) for name, ends in bounds.items() if name != "size" for end in ends),
        0.0,
    )


def pressure_tangents_by_stroke(problem: Problem) -> list[tuple[float, int]]:
    """The limits on the pressure angle: tan β and the kinds of stroke that each applies to."""
    return [
        (constraint.upper_bound_of_each_side(), constraint.kinds)
        for constraint in constraints_on_curve(problem, problem.setup.mechanism.pressure)
        if problem.programme.has_kinds(constraint.kinds)
    ]


def closed_form_design(problem: Problem, bounds: SizeBounds) -> Designs | None:
    """The smallest design under the linear limits; None if there is no closed form for it.

    Its size may be above the range of the size.
    """
    mechanism = problem.setup.mechanism
    slopes = pressure_tangents_by_stroke(problem)
    low = bounds["size"][0]
    middle = {name: a for name, (a, b) in bounds.items() if a == b}
    if mechanism.moves_as(translating.MECHANISM):
        roller = bounds["roller_radius"][1]
        lead, prime = _signed_offset_and_least_prime_radius(problem, bounds["offset"], slopes, low + roller)
        size = max(prime - roller, low)
        middle |= {"offset": lead * problem.design.sense, "roller_radius": roller}
    elif mechanism.moves_as(translating_flat.MECHANISM):
        radius = required_profile_radius(problem)
        size = max(low, radius - weighted_derivative_range(problem.programme, (1, 0, 1), ALL_STROKES)[0])
        middle.setdefault("offset", problem.design.offset[0])
    elif mechanism.moves_as(cylindrical.MECHANISM) and slopes:
        size = max(
            low,
            *(
                max(map(abs, weighted_derivative_range(problem.programme, (0, 1), kinds))) / tangent
                for tangent, kinds in slopes
            ),
        )
        middle.setdefault("roller_radius", bounds["roller_radius"][1])
    else:
        return None
    if size <= 0.0:
        return None
    fields = {name: np.array([middle.get(name, bounds[name][0])]) for name in bounds}
    return problem.design.with_values({**fields, "size": np.array([size])})


def _signed_offset_and_least_prime_radius(
    problem: Problem,
    offset_range: tuple[float, float],
    pressure_tangents: list[tuple[float, int]],
    least_prime_radius: float,
) -> tuple[float, float]:
    """The lead e and prime radius of the smallest cam that meets the pressure angle, within the offsets.

    s₀(e) is the largest of a few lines, so R_p² = e² + s₀² is convex in e. Its least value lies at e = 0, at the
    projection of the origin on a line, at a crossing of two lines, or at an end of the interval.
    """
    ends = sorted(problem.design.sense * e for e in offset_range)
    if problem.robust_errors:
        return _robust_offset_and_least_prime_radius(
            problem, (ends[0], ends[1]), pressure_tangents, least_prime_radius
        )
    lines = _pressure_angle_lines(problem.programme, pressure_tangents)
    candidates = [0.0, *(-a * b / (1 + b * b) for a, b in lines)]
    candidates += [(a2 - a1) / (b1 - b2) for (a1, b1), (a2, b2) in combinations(lines, 2) if b1 != b2]
    leads = np.clip(np.array([*ends, *candidates]), ends[0], ends[1])
    heights = np.max([np.zeros_like(leads), *(a + b * leads for a, b in lines)], axis=0)
    primes = np.maximum(np.hypot(leads, heights), least_prime_radius)
    best = np.lexsort((np.abs(leads), primes))[0]
    return float(leads[best]), float(primes[best])


def _pressure_angle_lines(
    programme: Programme, pressure_tangents: list[tuple[float, int]]
) -> list[tuple[float, float]]:
    """The lines s₀ ≥ a + b·e, as a and b."""
    return [
        line
        for tangent, kinds in pressure_tangents
        for line in (
            (weighted_derivative_range(programme, (-tangent, 1), kinds)[1] / tangent, -1 / tangent),
            (-weighted_derivative_range(programme, (tangent, 1), kinds)[0] / tangent, 1 / tangent),
        )
    ]


def _robust_offset_and_least_prime_radius(
    problem: Problem,
    offset_range: tuple[float, float],
    pressure_tangents: list[tuple[float, int]],
    least_prime_radius: float,
) -> tuple[float, float]:
    """The lead e and prime radius of the smallest cam that meets the pressure angle with all its errors too.

    With errors δe and δR a cam needs R_p ≥ √((e + δe)² + s₀(e + δe)²) − δR. This is convex in e, and so is the
    maximum over all errors.
    """
    sense = problem.design.sense
    variants = [
        (
            np.array(_pressure_angle_lines(variant.programme, pressure_tangents)).reshape(-1, 2, 1),
            sense * errors.get("offset", 0.0),
            errors.get("roller_radius", 0.0) + errors.get("size", 0.0),
        )
        for variant, errors in ((problem, {}), *problem.error_variants)
    ]

    def prime_radii(signed_offsets: FloatArray) -> FloatArray:
        radii = [np.full_like(signed_offsets, least_prime_radius)]
        for lines, lead_error, radius_error in variants:
            heights = np.max(lines[:, 0] + lines[:, 1] * (signed_offsets + lead_error), axis=0, initial=0.0)
            radii.append(np.hypot(signed_offsets + lead_error, heights) - radius_error)
        return np.asarray(np.max(radii, axis=0))

    low, high = offset_range
    for _ in range(LEAD_ZOOMS):
        leads = np.linspace(low, high, LEADS_A_ZOOM)
        best = int(np.argmin(prime_radii(leads)))
        low, high = float(leads[max(best - 1, 0)]), float(leads[min(best + 1, LEADS_A_ZOOM - 1)])
    return float(leads[best]), float(prime_radii(leads)[best])


def nudge_to_feasible(problem: Problem, design: Designs, bounds: SizeBounds) -> Designs | None:
    """The design, enlarged by a few units in the last place until it is feasible despite rounding; else None.

    Free numbers take samples of their ranges, those nearest to the middle first.
    """
    numbers = _free_number_samples(problem, bounds)
    samples = max((column.size for column in numbers.values()), default=1)
    steps = np.repeat(np.array(NUDGES) * design.prime_radius, samples)
    larger = design.take(np.zeros(steps.size, dtype=int))
    columns = {key: np.tile(column, len(NUDGES)) for key, column in numbers.items()}
    larger = larger.with_values({"size": larger.size + steps, **columns})
    held = np.flatnonzero(feasible_designs(problem, larger) & (larger.size <= bounds["size"][1]))
    return larger.take(held[:1]) if held.size else None


def _free_number_samples(problem: Problem, bounds: SizeBounds) -> dict[str, FloatArray]:
    """Samples of the ranges of free numbers, by key; those in the middle first."""
    free = sorted(problem.setup.free & bounds.keys())
    if not free:
        return {}
    shares = np.array(list(product(np.linspace(0.0, 1.0, NUMBER_SHARES), repeat=len(free)))).T
    shares = shares[:, np.argsort(np.abs(shares - 0.5).max(axis=0), kind="stable")]
    ends = (bounds[key] for key in free)
    return {key: low + share * (high - low) for key, share, (low, high) in zip(free, shares, ends, strict=True)}
