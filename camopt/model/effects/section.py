"""The section of a disc cam (area, length of the profile, centroid, polar moment), and the length of a groove.

The contact point z in the ground frame moves along the cam by dz/dθ − iσz, with σ = 1 for a ccw cam. The radius to
it sweeps twice the area at the rate w = −σ·Im(z̄·(dz/dθ − iσz)). By Green's theorem

    A = ½∮w dθ,    ∫(x + iy) dA = ⅓∮e^{−iσθ}·z·w dθ,    ∫r² dA = ¼∮|z|²·w dθ

in the cam's own frame, whose x and y are those of the ground at cam angle 0. A corner of the pitch curve adds an
arc of the roller about it; with a flat face a corner of the motion adds a straight edge. If a profile is undercut
or crosses itself, the values are those of the curve as drawn, whose loops count with their sign.

A groove in the face of a disc is the band between its walls, z + w·n and z − w·n, with the trace point z and half
the groove's width w: R_r plus half the clearance. Its length is that of its pitch curve.

Integrals use Gauss's rule on each panel of the motion (``numerics.quadrature``).

Source: Bronshtein et al., Handbook of Mathematics, ch. 8 (line integrals).
"""

from collections.abc import Iterator
from functools import partial
from math import pi, sqrt
from typing import Any

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.core.numerics.quadrature import GaussRule, Integrals, integrate_with_rising_order
from camopt.core.numerics.stable_functions import matrix_product
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, NecessaryConditions, Setup
from camopt.model.effects.mean import Mean
from camopt.model.effects.peak import TurnIntegralScale
from camopt.model.mechanisms.design import Designs
from camopt.model.mechanisms.elements import INNER_SIDE
from camopt.model.motion.programme import JUMP_SIDE
from camopt.model.motion.stroke import ALL_STROKES

AREA, PROFILE_LENGTH, POLAR_MOMENT = "area_mm2", "profile_length_mm", "polar_moment_mm4"
CENTROID = ("centroid_x_mm", "centroid_y_mm")
GROOVE_LENGTH = "groove_length_mm"
SECTION_POINTS = 2**15  # points of all designs that are computed together
JUST_ABOVE = 1.0 + 1e-12  # factor on a size, for rounding


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    if setup.mechanism.body.bounded:
        return AREA, PROFILE_LENGTH, *CENTROID, POLAR_MOMENT
    return (GROOVE_LENGTH,) if setup.mechanism.has_flanks_on_both_sides else ()


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    if not case.setup.mechanism.body.bounded:
        groove = integrate_groove(case)
        return {GROOVE_LENGTH: EnclosedValue(groove.value[0], groove.error[0], groove.value[0])}
    section = integrate_section(case)
    length, area, *_, polar = section.value
    columns = {
        PROFILE_LENGTH: EnclosedValue(length, section.error[0], length),
        AREA: EnclosedValue(area, section.error[1], area),
        POLAR_MOMENT: EnclosedValue(polar, section.error[4], polar),
    }
    for name, moment, error in zip(CENTROID, section.value[2:4], section.error[2:4], strict=True):
        width = (error + np.abs(moment / area) * section.error[1]) / area
        columns[name] = EnclosedValue(moment / area, width, np.sqrt(np.abs(area) / pi))
    return columns


def integrate_section(case: EvaluationBlock) -> Integrals:
    """Integrals over the sections of disc cams, or over the region within a flank of a rib, in mm (5, designs).

    They are the length, the area, the first moments x and y, and the polar moment.
    """
    side = case.setup.mechanism.flanks[0].side
    return _integrate_in_blocks(case, partial(section_integrals, side=side), _section_error_scales)


def _section_error_scales(integrals: FloatArray) -> FloatArray:
    """Scale of errors; for first moments, the area times the radius of a disc of the same area."""
    length, area, *_, polar = np.abs(integrals)
    moment = area * np.sqrt(area / pi)
    return np.stack([length, area, moment, moment, polar])


def _integrate_in_blocks(case: EvaluationBlock, integrals: Any, error_scale: Any) -> Integrals:
    """Integrals of all designs, to the setup's error; blocks of designs keep the memory bounded."""

    def integrate_designs(rule: GaussRule, index: Any) -> FloatArray:
        designs = case.designs.take(index)
        count = 1 + len(designs) * case.programme.table.centre.size * rule.nodes.size // SECTION_POINTS
        blocks = np.array_split(np.arange(len(designs)), count)
        return np.concatenate([integrals(case, designs.take(block), rule) for block in blocks], axis=1)

    return integrate_with_rising_order(integrate_designs, error_scale, len(case.designs), case.setup.relative_error)


def section_integrals(
    case: EvaluationBlock, designs: Designs, rule: GaussRule, side: float = INNER_SIDE
) -> FloatArray:
    """Integrals (5, designs) of ``integrate_section`` within the wall on a side; side 0 is the pitch curve."""
    table, sense = case.programme.table, designs.sense
    angles = table.centre[:, None] + table.half_width[:, None] * rule.nodes
    travel = case.setup.mechanism.trace_and_normal(designs.as_columns(), case.programme, angles.ravel())
    across = (len(designs), *angles.shape)
    normal = travel.normal.reshape(-1, *angles.shape)
    reach = side * case.setup.pitch_to_flank_distance(designs)
    point = travel.trace.reshape(across) + reach[:, None, None] * normal
    along = matrix_product(point, rule.derivative.T) - 1j * sense * table.half_width[:, None] * point
    total = _profile_integrals(sense, rule, point, normal, along, np.exp(-1j * sense * angles))
    for corner in _profile_parts_at_corners(case, designs, rule, reach):
        total += _profile_integrals(sense, rule, *corner)
    return total


def _profile_integrals(
    sense: float,
    rule: GaussRule,
    point: ComplexArray,
    normal: ComplexArray,
    point_derivative: ComplexArray,
    frame_rotation: ComplexArray,
) -> FloatArray:
    """Integrals (5, designs) over parts of profiles, from points, normals, derivatives (designs, parts, nodes)."""
    length = matrix_product((point_derivative * np.conj(-1j * sense * normal)).real, rule.weights)
    rate = -sense * (np.conj(point) * point_derivative).imag
    moment = matrix_product(frame_rotation * point * rate, rule.weights) / 3.0
    polar = matrix_product((np.square(point.real) + np.square(point.imag)) * rate, rule.weights) / 4.0
    parts = [length, matrix_product(rate, rule.weights) / 2.0, moment.real, moment.imag, polar]
    return np.array([part.sum(axis=1) for part in parts])


def _profile_parts_at_corners(
    case: EvaluationBlock, designs: Designs, rule: GaussRule, wall_distance: FloatArray
) -> Iterator[tuple[Any, ...]]:
    """Parts of profiles at corners of the motion: arcs about the trace point, or edges along a flat face."""
    share = 0.5 * (1.0 + rule.nodes)
    for corner in case.programme.corners:
        angles = np.mod(corner.at + JUMP_SIDE * np.array([-1.0, 1.0]), 2.0 * pi)
        trace, normal = (
            np.broadcast_to(each, (len(designs), 2))
            for each in case.setup.mechanism.trace_and_normal(designs.as_columns(), case.programme, angles)
        )
        step, sweep = np.diff(trace, axis=1), np.angle(normal[:, 1:] / normal[:, :1])
        face = normal[:, :1] * np.exp(1j * sweep * share)
        radius = -wall_distance[:, None]
        point = trace[:, :1] + step * share - radius * face
        along = 0.5 * (step - 1j * sweep * radius * face)
        turn = np.full(rule.nodes.size, np.exp(-1j * designs.sense * corner.at))
        yield point[:, None], face[:, None], along[:, None], turn


def integrate_groove(case: EvaluationBlock) -> Integrals:
    """Integrals of ``cylinder_groove_integrals``, or ``face_groove_integrals`` for a face groove (3, designs)."""
    if case.setup.mechanism.body.developed:
        return _integrate_in_blocks(case, cylinder_groove_integrals, np.abs)
    return _integrate_in_blocks(case, face_groove_integrals, _section_error_scales)


def face_groove_integrals(case: EvaluationBlock, designs: Designs, rule: GaussRule) -> FloatArray:
    """Length, area, moments and polar moment (5, designs) of a groove in the face of a disc."""
    inner, middle, outer = (section_integrals(case, designs, rule, side) for side in (INNER_SIDE, 0.0, -INNER_SIDE))
    return np.concatenate([middle[:1], (outer - inner)[1:]])


def cylinder_groove_integrals(case: EvaluationBlock, designs: Designs, rule: GaussRule) -> FloatArray:
    """L(R_m), ∫L dr and ∫r²·L dr of a cylinder's groove of depth d, with the length L(r) of the pitch curve.

    The integrals are from R_m − d/2 to R_m + d/2. At the radius r the pitch curve has the same length along the
    axis, and r/R_m of its length round it. The same formulas are for a flank of a rib of the height d. Both
    integrals are by the same rule, so that the difference between two orders is the error of both.
    """
    table, depth, mean = case.programme.table, case.setup.solid.groove_depth_or_rib_height or 0.0, designs.size
    angles = table.centre[:, None] + table.half_width[:, None] * rule.nodes
    trace = case.setup.mechanism.trace_and_normal(designs.as_columns(), case.programme, angles.ravel()).trace
    along = matrix_product(trace.reshape(-1, *angles.shape), rule.derivative.T)

    def length_at_radius(radius_ratio: FloatArray) -> FloatArray:
        speed = np.hypot(radius_ratio[:, None, None] * along.real, along.imag)
        return np.asarray(matrix_product(speed, rule.weights).sum(axis=1))

    total = np.array([length_at_radius(np.ones(len(designs))), 0.0 * mean, 0.0 * mean])
    for place, weight in zip(rule.nodes, rule.weights, strict=True):
        radius = mean + place * depth / 2.0
        part = weight * depth / 2.0 * length_at_radius(radius / mean)
        total[1:] += part, np.square(radius) * part
    return total


def means(setup: Setup) -> dict[str, Mean]:
    path = setup.mechanism.path if GROOVE_LENGTH in applicable_quantities(setup) else None
    return {} if path is None else {GROOVE_LENGTH: Mean(((path, ALL_STROKES),), 1, TurnIntegralScale())}


def necessary_conditions(setup: Setup, quantity_name: str, bound: float) -> NecessaryConditions:
    """The largest base radius for a bound on the area: every profile goes round the base circle."""
    return (
        NecessaryConditions(most_size=sqrt(bound / pi) * JUST_ABOVE)
        if quantity_name == AREA
        else NecessaryConditions()
    )


EFFECT = Effect(
    "section",
    applicable_quantities,
    evaluate_columns,
    means=means,
    necessary_conditions=necessary_conditions,
    is_single_disc=True,
)
