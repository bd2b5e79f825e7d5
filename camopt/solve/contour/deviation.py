"""A proved bound of the distance between a path and the cam curve that it follows.

Over a short stretch of the turn the curve is p(t) = p₀ + p₁·t + p₂·t² + [p₃]·t³ about the middle. The interval [p₃]
contains the remainder of every point. Take a frame at the start of an arc of curvature κ, with u along the tangent
and v along the normal. The circle of the arc is the zero set of

    F = v − κ/2·(u² + v²)

and the distance of a point from the circle is 2|F|/(1 + √(1 − 2κF)). A bound of F over the stretch, from its
series, therefore bounds the distance of the curve from the circle.

While the rate M = u'·(1 − κv) + v'·κu is above 0, the curve advances along the arc. If it also starts and ends
beside the ends of the arc, every point of the curve lies beside a point of the arc, and every point of the arc
beside a point of the curve. A part on which M may be negative adds its length to the bound.

A cubic is compared with the curve at the same share of the stretch.

Source: Moore, Kearfott and Cloud, Introduction to Interval Analysis, ch. 6 and 9 (Taylor forms).
"""

from collections.abc import Callable

import numpy as np

from camopt.core.numerics import FloatArray
from camopt.core.numerics.interval import as_interval
from camopt.core.numerics.taylor import Taylor
from camopt.solve.contour.curve import CamCurve, Expansion
from camopt.solve.contour.path import ArcPath, CubicPath

FIRST_PART_COUNT, MOST_PART_COUNT = 2, 1024  # parts of an element
HALVING_GAIN = 0.95  # an element is halved again while halving reduces its bound at least by this factor
ROUNDING_SHARE = 1e-12  # of the largest coordinate: many times the largest rounding error


def deviation_upper_bound(curve: CamCurve, path: ArcPath | CubicPath, target_bound: float = 0.0) -> float:
    """Upper bound of the distance between a curve and its path [mm], from each point of one to the other.

    Elements are divided until the bound is at most ``target_bound`` (mm), or until dividing no longer helps.
    """
    bounds, parts = _element_deviation_bounds(curve, path, np.arange(len(path)), FIRST_PART_COUNT), FIRST_PART_COUNT
    wide = np.flatnonzero(~(bounds <= target_bound))
    while parts < MOST_PART_COUNT and wide.size:
        parts *= 2
        before, after = bounds[wide], _element_deviation_bounds(curve, path, wide, parts)
        bounds[wide] = np.fmin(before, after)
        wide = wide[~(after <= target_bound) & ~(after > HALVING_GAIN * before)]
    return float(bounds.max())


def _element_deviation_bounds(
    curve: CamCurve, path: ArcPath | CubicPath, index: np.ndarray, parts_per_element: int
) -> FloatArray:
    """A bound for each element of ``index`` [mm], which is divided into so many parts."""
    starts, ends = path.angles[index].T
    edges = starts[:, None] + (ends - starts)[:, None] * np.linspace(0.0, 1.0, parts_per_element + 1)
    spans = [curve.spans[path.spans[element]] for element in np.repeat(index, parts_per_element)]
    expansion = curve.taylor_expansion(spans, edges[:, :-1].ravel(), edges[:, 1:].ravel())
    bound = _arc_deviation_bounds if isinstance(path, ArcPath) else _cubic_deviation_bounds
    distances = bound(path, index, expansion, parts_per_element)  # type: ignore[arg-type]
    size = np.abs(path.vertices if isinstance(path, ArcPath) else path.controls).max()
    return np.asarray(distances + ROUNDING_SHARE * size)


def _arc_deviation_bounds(path: ArcPath, index: np.ndarray, curve: Expansion, parts_per_element: int) -> FloatArray:
    arc = np.repeat(index, parts_per_element)
    tangent, curvature, first = path.tangents[0][arc], path.curvatures[arc], path.vertices[arc]

    def arc_coordinates(x: Taylor, y: Taylor) -> tuple[Taylor, Taylor]:
        x, y = x - first.real, y - first.imag
        return x * tangent.real + y * tangent.imag, y * tangent.real - x * tangent.imag

    def circle_residual(x: Taylor, y: Taylor) -> Taylor:
        u, v = arc_coordinates(x, y)
        above: Taylor = v - (u * u + v * v) * (curvature / 2)
        return above

    def advance_rate_along_arc(x: Taylor, y: Taylor) -> Taylor:
        u, v = arc_coordinates(x, y)
        u, v, du, dv = Taylor(u.terms[:-1]), Taylor(v.terms[:-1]), u.slope, v.slope
        rate: Taylor = du * (1.0 - v * curvature) + dv * u * curvature
        return rate

    above = _formula_magnitude_upper_bounds(curve, circle_residual)
    distance = 2.0 * above / (1.0 + np.sqrt(np.maximum(1.0 - 2.0 * np.abs(curvature) * above, 0.0)))
    distance = np.where(2.0 * np.abs(curvature) * above < 1.0, distance, np.inf)
    back = np.where(
        _formula_lower_bounds(curve, advance_rate_along_arc) > 0.0, 0.0, _stretch_length_upper_bounds(curve)
    )
    radial = distance.reshape(-1, parts_per_element).max(axis=1)
    return np.asarray(
        radial
        + back.reshape(-1, parts_per_element).sum(axis=1)
        + _arc_end_mismatches_along_arc(path, index, curve, parts_per_element)
    )


def _arc_end_mismatches_along_arc(
    path: ArcPath, index: np.ndarray, curve: Expansion, parts_per_element: int
) -> FloatArray:
    """Distance along each arc between its ends and those of the curve [mm]; the larger of the two ends."""
    distances = np.zeros(index.size)
    for part, sign, tangents, vertices in (
        (0, -1.0, path.tangents[0], path.vertices[:-1]),
        (-1, 1.0, path.tangents[1], path.vertices[1:]),
    ):
        t = sign * curve.half_widths
        x, y = (
            (a0 + t * (a1 + t * (a2 + t * a3))).reshape(-1, parts_per_element)[:, part]
            for a0, a1, a2, a3 in (series.terms for series in curve.at_middles)
        )
        local = (x + 1j * y - vertices[index]) * tangents[index].conjugate()
        distances = np.maximum(distances, np.abs(local.real / (1.0 - path.curvatures[index] * local.imag)))
    return distances


def _cubic_deviation_bounds(
    path: CubicPath, index: np.ndarray, curve: Expansion, parts_per_element: int
) -> FloatArray:
    """Bounds of the difference between the curve and the cubic c₀ + c₁·s + c₂·s² + c₃·s³ at equal cam angles."""
    p0, p1, p2, p3 = path.controls[np.repeat(index, parts_per_element)].T
    starts, ends = path.angles[index].T
    middles = np.tile((np.arange(parts_per_element) + 0.5) / parts_per_element, index.size)
    share = Taylor([middles, np.repeat(1.0 / (ends - starts), parts_per_element), 0.0, 0.0])
    cubic = share * (p3 - 3.0 * p2 + 3.0 * p1 - p0) + 3.0 * (p0 - 2.0 * p1 + p2)
    cubic = (cubic * share + 3.0 * (p1 - p0)) * share + p0
    across, up = (Taylor([part(term) for term in cubic.terms]) for part in (np.real, np.imag))
    bounds = np.hypot(
        _formula_magnitude_upper_bounds(curve, lambda x, y: x - across),
        _formula_magnitude_upper_bounds(curve, lambda x, y: y - up),
    )
    return np.asarray(bounds.reshape(-1, parts_per_element).max(axis=1))


def _formula_magnitude_upper_bounds(curve: Expansion, formula: Callable[[Taylor, Taylor], Taylor]) -> FloatArray:
    """Upper bound of |formula| over each stretch: the largest |polynomial| plus the remainder."""
    a0, a1, a2 = formula(*curve.at_middles).terms[:3]
    r = curve.half_widths
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.clip(np.nan_to_num(-a1 / (2.0 * a2)), -r, r)
    highest = np.max([np.abs(a0 + t * (a1 + t * a2)) for t in (-r, turn, r)], axis=0)
    return np.asarray(highest + as_interval(formula(*curve.over_stretches).terms[3]).largest_magnitude * r**3)


def _formula_lower_bounds(curve: Expansion, formula: Callable[[Taylor, Taylor], Taylor]) -> FloatArray:
    """Lower bound of a formula over each stretch, from its value and slope at the middle and the remainder."""
    a0, a1 = formula(*curve.at_middles).terms[:2]
    rest = as_interval(formula(*curve.over_stretches).terms[2]).largest_magnitude
    return np.asarray(a0 - np.abs(a1) * curve.half_widths - rest * curve.half_widths**2)


def _stretch_length_upper_bounds(curve: Expansion) -> FloatArray:
    """Upper bound of the length of the curve on each stretch [mm]."""
    x, y = (as_interval(series.terms[1]).largest_magnitude for series in curve.over_stretches)
    return np.asarray(2.0 * curve.half_widths * np.hypot(x, y))
