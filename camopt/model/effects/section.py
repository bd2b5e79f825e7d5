"""The section of a disc cam: area, length of the profile, centroid, polar moment; of a groove its length, and more.

The contact point is z in the ground frame, and moves along the cam by dz/dθ − iσz, with σ = 1 for a ccw cam. By
Green's theorem, with the rate w = −σ·Im(z̄·(dz/dθ − iσz)) at which the radius to it sweeps twice the area,

    A = ½∮w dθ,    ∫(x + iy) dA = ⅓∮e^{−iσθ}·z·w dθ,    ∫r² dA = ¼∮|z|²·w dθ

in the cam's own frame, in which x and y are those of the ground at cam angle 0. A corner of the pitch curve adds an
arc of the roller about it, one of the motion of a flat face a straight edge. Where a profile is undercut, or
crosses itself, all are those of the curve as it is drawn, whose loops count with their sign.

A groove in the face of a disc is the band between its outer and its inner wall, z + w·n and z − w·n, with z the
trace point and w half the width of the groove, R_r and half the clearance; it is as long as its pitch curve.

Integrals are by Gauss's rule on each panel of the motion (``numerics.quadrature``).
Source: Bronshtein et al., Handbook of Mathematics, ch. 8 (line integrals).
"""

from collections.abc import Iterator
from functools import partial
from math import pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import ComplexArray, FloatArray
from camopt.core.numerics.quadrature import GaussRule, Integrals, gauss_rule, integrate_by_orders
from camopt.core.numerics.stable_functions import matrix_product
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup
from camopt.model.effects.mean import Mean
from camopt.model.effects.necessary_conditions import NecessaryConditions
from camopt.model.effects.peak import TurnIntegral
from camopt.model.mechanisms.design import Designs
from camopt.model.mechanisms.elements import INNER_SIDE
from camopt.model.motion.programme import JUMP_SIDE
from camopt.model.motion.stroke import ALL_STROKES

AREA, PROFILE_LENGTH, POLAR_MOMENT = "area_mm2", "profile_length_mm", "polar_moment_mm4"
CENTROID = ("centroid_x_mm", "centroid_y_mm")
GROOVE_LENGTH = "groove_length_mm"
SECTION_POINTS = 2**15  # points of all designs of a block
JUST_ABOVE = 1.0 + 1e-12  # of a size, for rounding
RADIAL_NODES = 6  # points along the depth of a groove, over which integrands hardly change


def offers(setup: Setup) -> tuple[str, ...]:
    if setup.mechanism.body.bounded:
        return AREA, PROFILE_LENGTH, *CENTROID, POLAR_MOMENT
    return (GROOVE_LENGTH,) if setup.mechanism.two_sided else ()


def run(case: EvaluationBlock, wanted: frozenset[str]) -> dict[str, Any]:
    if not case.setup.mechanism.body.bounded:
        groove = integrate_groove(case)
        return {GROOVE_LENGTH: EnclosedValue(groove.value[0], groove.error[0], groove.value[0])}
    found = integrate_section(case)
    (length, area, *_, polar), size = found.value, found.size
    columns = {
        PROFILE_LENGTH: EnclosedValue(length, found.error[0], length),
        AREA: EnclosedValue(area, found.error[1], area),
        POLAR_MOMENT: EnclosedValue(polar, found.error[4], polar),
    }
    for name, moment, error in zip(CENTROID, found.value[2:4], found.error[2:4], strict=True):
        off = (error + np.abs(moment / area) * found.error[1]) / area
        columns[name] = EnclosedValue(moment / area, off, size)
    return columns


class SectionIntegrals(NamedTuple):
    """Length, area, first moments by x and y, polar moment (5, designs); errors; the radius of a disc as large."""

    value: FloatArray
    error: FloatArray
    size: FloatArray


def integrate_section(case: EvaluationBlock) -> SectionIntegrals:
    """The integrals over the sections of disc cams, or over what is within a flank of a rib, mm."""
    side = case.setup.mechanism.flanks[0].side
    found = integrate_by_orders(
        *_integration_arguments(case, partial(section_integrals, side=side), _section_scale)
    )
    return SectionIntegrals(*found, np.sqrt(np.abs(found.value[1]) / pi))


def _section_scale(found: FloatArray) -> FloatArray:
    """The scale of errors; for first moments, that of the area at the radius of a disc of the same area."""
    length, area, *_, polar = np.abs(found)
    moment = area * np.sqrt(area / pi)
    return np.stack([length, area, moment, moment, polar])


def _integration_arguments(case: EvaluationBlock, integrals: Any, scale: Any) -> tuple[Any, Any, int, float]:
    """The arguments of ``integrate_by_orders``: designs are taken a block at a time, so that memory is bounded."""

    def integrate_designs(rule: GaussRule, index: Any) -> FloatArray:
        designs = case.designs.take(index)
        count = 1 + len(designs) * case.programme.table.centre.size * rule.nodes.size // SECTION_POINTS
        blocks = np.array_split(np.arange(len(designs)), count)
        return np.concatenate([integrals(case, designs.take(block), rule) for block in blocks], axis=1)

    return integrate_designs, scale, len(case.designs), case.setup.relative_error


def _design_columns(designs: Designs) -> Designs:
    """Designs as columns (n, 1), so that formulas give them at many cam angles."""
    return designs.with_values({name: values[:, None] for name, values in designs.values.items()})


def section_integrals(
    case: EvaluationBlock, designs: Designs, rule: GaussRule, side: float = INNER_SIDE
) -> FloatArray:
    """As of ``SectionIntegrals``, (5, designs), within the wall on a side; within the pitch curve of side 0."""
    table, sense = case.programme.table, designs.sense
    angles = table.centre[:, None] + table.half_width[:, None] * rule.nodes
    travel = case.setup.mechanism.travel(_design_columns(designs), case.programme, angles.ravel())
    across = (len(designs), *angles.shape)
    normal = travel.normal.reshape(-1, *angles.shape)
    reach = side * case.setup.half_width(designs)
    point = travel.trace.reshape(across) + reach[:, None, None] * normal
    along = matrix_product(point, rule.derivative.T) - 1j * sense * table.half_width[:, None] * point
    total = _profile_integrals(sense, rule, point, normal, along, np.exp(-1j * sense * angles))
    for corner in _corner_parts(case, designs, rule, reach):
        total += _profile_integrals(sense, rule, *corner)
    return total


def _profile_integrals(
    sense: float,
    rule: GaussRule,
    point: ComplexArray,
    normal: ComplexArray,
    along: ComplexArray,
    turn: ComplexArray,
) -> FloatArray:
    """The integrals (5, designs) over parts of profiles: points, normals, derivatives, (designs, parts, nodes)."""
    length = matrix_product((along * np.conj(-1j * sense * normal)).real, rule.weights)
    rate = -sense * (np.conj(point) * along).imag
    moment = matrix_product(turn * point * rate, rule.weights) / 3.0
    polar = matrix_product((np.square(point.real) + np.square(point.imag)) * rate, rule.weights) / 4.0
    parts = [length, matrix_product(rate, rule.weights) / 2.0, moment.real, moment.imag, polar]
    return np.array([part.sum(axis=1) for part in parts])


def _corner_parts(
    case: EvaluationBlock, designs: Designs, rule: GaussRule, reach: FloatArray
) -> Iterator[tuple[Any, ...]]:
    """The part of profiles at corners of the motion: an arc about the trace point, or an edge along a flat face."""
    share, half = 0.5 * (1.0 + rule.nodes), 0.5
    for corner in case.programme.corners:
        angles = np.mod(corner.at + JUMP_SIDE * np.array([-1.0, 1.0]), 2.0 * pi)
        trace, normal = (
            np.broadcast_to(each, (len(designs), 2))
            for each in case.setup.mechanism.travel(_design_columns(designs), case.programme, angles)
        )
        moved, turned = np.diff(trace, axis=1), np.angle(normal[:, 1:] / normal[:, :1])
        face = normal[:, :1] * np.exp(1j * turned * share)
        radius = -reach[:, None]
        point = trace[:, :1] + moved * share - radius * face
        along = half * (moved - 1j * turned * radius * face)
        turn = np.full(rule.nodes.size, np.exp(-1j * designs.sense * corner.at))
        yield point[:, None], face[:, None], along[:, None], turn


def integrate_groove(case: EvaluationBlock) -> Integrals:
    """The integrals of ``groove_integrals`` (3, designs); of a groove in a face those of ``band_integrals``."""
    developed = case.setup.mechanism.body.developed
    return integrate_by_orders(
        *(
            _integration_arguments(case, groove_integrals, np.abs)
            if developed
            else _integration_arguments(case, band_integrals, _section_scale)
        )
    )


def band_integrals(case: EvaluationBlock, designs: Designs, rule: GaussRule) -> FloatArray:
    """Of a groove in the face of a disc, (5, designs): its length; of its band area, moments and polar moment."""
    inner, middle, outer = (section_integrals(case, designs, rule, side) for side in (INNER_SIDE, 0.0, -INNER_SIDE))
    return np.concatenate([middle[:1], (outer - inner)[1:]])


def groove_integrals(case: EvaluationBlock, designs: Designs, rule: GaussRule) -> FloatArray:
    """Of the pitch curve of a groove of depth d, as long as L(r) at the radius r: L(R_m), ∫L dr, ∫r²·L dr.

    Or of that of a flank of a rib of the height d. From R_m − d/2 to R_m + d/2. At a radius r the curve is as long
    along the axis, and r/R_m as long round it.
    """
    table, depth, mean = case.programme.table, case.setup.solid.flank_height or 0.0, designs.size
    angles = table.centre[:, None] + table.half_width[:, None] * rule.nodes
    trace = case.setup.mechanism.travel(_design_columns(designs), case.programme, angles.ravel()).trace
    along = matrix_product(trace.reshape(-1, *angles.shape), rule.derivative.T)

    def length(share: FloatArray) -> FloatArray:
        speed = np.hypot(share[:, None, None] * along.real, along.imag)
        return np.asarray(matrix_product(speed, rule.weights).sum(axis=1))

    total = np.array([length(np.ones(len(designs))), 0.0 * mean, 0.0 * mean])
    for place, weight in zip(*gauss_rule(RADIAL_NODES)[:2], strict=True):
        radius = mean + place * depth / 2.0
        part = weight * depth / 2.0 * length(radius / mean)
        total[1:] += part, np.square(radius) * part
    return total


def means(setup: Setup) -> dict[str, Mean]:
    path = setup.mechanism.path if GROOVE_LENGTH in offers(setup) else None
    return {} if path is None else {GROOVE_LENGTH: Mean(((path, ALL_STROKES),), 1, TurnIntegral())}


def implies(setup: Setup, name: str, bound: float) -> NecessaryConditions:
    """The base radius above which no profile encloses as little: it goes round the base circle."""
    return NecessaryConditions(most_size=sqrt(bound / pi) * JUST_ABOVE) if name == AREA else NecessaryConditions()


EFFECT = Effect("section", offers, run, means=means, implies=implies, is_single_disc=True)
