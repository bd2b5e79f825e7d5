"""The cam as a solid: its mass, balance and inertia.

A disc cam is a plate with the shape of its section (``effects.section``) and a hub on one side. Bore and keyway go
through both.

    m = ρ·(t·A + (L − t)·A_hub),    unbalance ρ·|∫(x + iy) dV|,    J = ρ·∫r² dV

A conjugate pair has both plates, t·(A₁ + A₂), and a hub that includes them and their gap, (L − 2t)·A_hub. The
second section is mirrored, x − iy in place of x + iy. The balance is that in one plane, without the couple of the
two discs.

A cylindrical cam is a cylinder of radius R_m + d/2 without bore, keyway and a groove of depth d about R_m. At each
radius r a cutter of the roller's width removes a band of the width 2R_r along a curve of the length L(r). The area
of the band is 2·R_r·L(r) (Steiner: it gains on one side of a bend what it loses on the other), so

    V_groove = 2·R_r·∫L dr,    ∫r² dV = 2·R_r·∫r²·L dr

A cylindrical cam with a rib is a cylinder of radius R_m − d/2. On it, at each radius r, is the band between the
pitch curves of both rollers, without a strip of the width R_r along each. With the distance b(θ) of these curves
along the axis [mm],

    V_rib = ∫ r dr·∫b dθ − R_r·∫(L₁ + L₂) dr

b is the distance of the rollers, on swinging arms times cos ψ; the other terms of the area add up to 0 over a turn.

A disc cam with a groove in its face is a plate of its outer diameter without bore, keyway and the band of the
groove to its depth. With a rib on its face, the plate is thinner by the height of the rib, and carries the band
between both flanks.

Approximations: the bottom of a cylinder's groove is a cylinder, and the cutter is narrow beside it; the true wall,
parallel to the cutter's axis, is at most R_r²/(2·R_m) from it. Edges are sharp. An undercut profile counts as in
``effects.section``.
"""

from collections.abc import Callable
from functools import reduce
from math import pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics.quadrature import GAUSS_ORDERS, gauss_rule
from camopt.core.numerics.stable_functions import matrix_product
from camopt.model.effects.area_moments import AreaMoments, disc_moments, keyway_moments
from camopt.model.effects.contacts import all_follower_contacts, block_at_contact
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup, SolidSizes
from camopt.model.effects.necessary_conditions import NecessaryConditions
from camopt.model.effects.section import JUST_ABOVE, integrate_groove, integrate_section
from camopt.model.mechanisms.elements import CYLINDER, DISC, FACE_GROOVE, RIBBED_CYLINDER, RIBBED_DISC

MASS, INERTIA = "cam_mass_kg", "cam_inertia_kg_m2"
BALANCE = ("unbalance_g_mm", "centre_of_gravity_mm")
KG, KG_M2, G_MM = 1e3, 1e-3, 1e6  # per t, t·mm², t·mm


def offered_quantities(setup: Setup) -> tuple[str, ...]:
    """Nothing for one flank of a rib, because the body is between both flanks."""
    mechanism = setup.mechanism
    return (
        () if mechanism.touches_rib and not mechanism.has_rib else BODY_FORMULAS[mechanism.body].offered_quantities
    )


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    sizes = setup.mechanism.body.solid
    keys = tuple(f"part.{key}" for key in (*sizes, "density") if getattr(setup.solid, key) is None)
    missing = dict.fromkeys(offered_quantities(setup), keys)
    if BALANCE[1] in missing:
        missing[BALANCE[1]] = tuple(key for key in keys if key != "part.density")
    return {name: keys for name, keys in missing.items() if keys}


def necessary_conditions(setup: Setup, quantity_name: str, bound: float) -> NecessaryConditions:
    """The largest base radius for a bound on mass or inertia: every profile goes round the base circle."""
    if not setup.mechanism.body.bounded or quantity_name not in (MASS, INERTIA):
        return NecessaryConditions()
    return NecessaryConditions(most_size=_largest_base_radius_within_bound(setup, quantity_name, bound))


def _largest_base_radius_within_bound(setup: Setup, quantity_name: str, bound: float) -> float:
    """Largest base radius of a disc, or of the first disc of a pair whose second one is no larger than the bore."""
    solid = setup.solid
    assert solid.thickness is not None
    assert solid.density is not None
    rest = _hub_moments(solid, _disc_count(setup)).subtract(_bore_moments(solid).times(solid.thickness))
    allowed = bound / (KG if quantity_name == MASS else KG_M2) / solid.density
    square = max(allowed - rest.area, 0.0) / (pi * solid.thickness)
    if quantity_name == INERTIA:
        square = sqrt(2.0 * max(allowed - rest.polar, 0.0) / (pi * solid.thickness))
    return max(sqrt(square) * JUST_ABOVE, solid.bore_reach)  # if the hub alone is too heavy, no size is left


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    solid, size = case.setup.solid, case.designs.size
    assert solid.thickness is not None
    density = 1.0 if solid.density is None else solid.density
    body, error = BODY_FORMULAS[case.setup.mechanism.body].volume(case)
    mass, inertia = density * body.area, density * body.polar
    columns = {
        MASS: EnclosedValue(mass * KG, density * error.area * KG, np.abs(mass) * KG),
        INERTIA: EnclosedValue(inertia * KG_M2, density * error.polar * KG_M2, np.abs(inertia) * KG_M2),
    }
    if BALANCE[0] not in offered_quantities(case.setup):
        return columns
    moment, scale = np.abs(body.moment), np.abs(body.area) * size
    columns[BALANCE[0]] = EnclosedValue(
        density * moment * G_MM, density * error.moment * G_MM, density * scale * G_MM
    )
    away = moment / body.area
    columns[BALANCE[1]] = EnclosedValue(away, (error.moment + away * error.area) / body.area, size)
    return columns


def _bore_moments(solid: SolidSizes) -> AreaMoments:
    """Moments of bore and keyway."""
    slot = keyway_moments(solid.bore_radius, solid.keyway_width, solid.keyway_depth, solid.keyway_angle)
    return disc_moments(solid.bore_radius).add(slot)


def _plates_and_hub_moments(case: EvaluationBlock) -> tuple[AreaMoments, AreaMoments]:
    """Volume and moments of plates and hub, and their errors."""
    solid, (first, *others) = case.setup.solid, all_follower_contacts(case.setup)[: _disc_count(case.setup)]
    assert solid.thickness is not None
    sections = [_section_moments(block_at_contact(case, first))]
    sections += [_section_moments(block_at_contact(case, other), mirror_sign=-1.0) for other in others]
    body, error = (reduce(AreaMoments.add, parts).times(solid.thickness) for parts in zip(*sections, strict=True))
    hollow = _bore_moments(solid).times(len(sections) * solid.thickness)
    return body.subtract(hollow).add(_hub_moments(solid, len(sections))), error


def _disc_count(setup: Setup) -> int:
    return 1 + bool(setup.mechanism.second_contact_size_keys)


def _section_moments(case: EvaluationBlock, mirror_sign: float = 1.0) -> tuple[AreaMoments, AreaMoments]:
    """Moments of a disc's section, or of its mirror image (``mirror_sign`` −1), and their errors."""
    section = integrate_section(case)
    _, area, x, y, polar = section.value
    _, *errors = section.error
    body = AreaMoments(area, x + 1j * mirror_sign * y, polar)
    return body, AreaMoments(errors[0], np.hypot(errors[1], errors[2]), errors[3])


def _hub_moments(solid: SolidSizes, plate_count: int) -> AreaMoments:
    """Volume and moments of the hub beside the plates, without bore and keyway."""
    assert solid.thickness is not None
    beside = max(solid.hub_length - plate_count * solid.thickness, 0.0)
    return disc_moments(solid.hub_radius).subtract(_bore_moments(solid)).times(beside)


def _grooved_cylinder_moments(case: EvaluationBlock) -> tuple[AreaMoments, AreaMoments]:
    """Volume and polar moment of a cylinder with its groove, and their errors."""
    solid, designs, groove = case.setup.solid, case.designs, integrate_groove(case)
    assert solid.thickness is not None
    assert solid.groove_depth is not None
    cylinder = (
        disc_moments(designs.size + solid.groove_depth / 2.0).subtract(_bore_moments(solid)).times(solid.thickness)
    )
    (_, *band), (_, *errors) = (2.0 * case.setup.pitch_to_flank_distance(designs) * rows for rows in groove)
    return cylinder.subtract(AreaMoments(band[0], 0.0, band[1])), AreaMoments(errors[0], 0.0, errors[1])


def _ribbed_cylinder_moments(case: EvaluationBlock) -> tuple[AreaMoments, AreaMoments]:
    """Volume and polar moment of a cylinder with a rib, and their errors."""
    solid, designs = case.setup.solid, case.designs
    assert solid.thickness is not None
    assert solid.rib_height is not None
    core, top = (designs.size + side * solid.rib_height / 2.0 for side in (-1.0, 1.0))
    distance = designs.roller_spacing * _axial_share_integral(case) / (2.0 * pi)
    band = disc_moments(top).subtract(disc_moments(core)).times(distance)
    flanks = [integrate_groove(block_at_contact(case, contact)) for contact in all_follower_contacts(case.setup)]
    (_, *strips), (_, *errors) = (
        case.setup.pitch_to_flank_distance(designs) * sum(rows) for rows in zip(*flanks, strict=True)
    )
    body = disc_moments(core).subtract(_bore_moments(solid)).times(solid.thickness).add(band)
    return body.subtract(AreaMoments(strips[0], 0.0, strips[1])), AreaMoments(errors[0], 0.0, errors[1])


def _axial_share_integral(case: EvaluationBlock) -> Any:
    """Integral over the turn of cos ψ, the axial share of the line through both rollers; 2π without arms."""
    table, lift = case.programme.table, case.programme.lift
    if not case.setup.angular:
        return 2.0 * pi
    rule = gauss_rule(GAUSS_ORDERS[-1])
    angles = table.centre[:, None] + table.half_width[:, None] * rule.nodes
    y, *_ = case.programme.motion_at(angles.ravel())
    shares = matrix_product(np.cos(y - lift / 2.0).reshape(angles.shape), rule.weights)
    return float(matrix_product(shares, table.half_width))


def _grooved_plate_moments(case: EvaluationBlock) -> tuple[AreaMoments, AreaMoments]:
    """Volume and moments of a plate with a groove in its face, and their errors."""
    solid, groove = case.setup.solid, integrate_groove(case)
    assert solid.thickness is not None
    assert solid.groove_depth is not None
    assert solid.outer_diameter is not None
    plate = disc_moments(solid.outer_diameter / 2.0).subtract(_bore_moments(solid)).times(solid.thickness)
    (_, area, x, y, polar), (_, *errors) = groove
    band = AreaMoments(area, x + 1j * y, polar).times(solid.groove_depth)
    error = AreaMoments(errors[0], np.hypot(errors[1], errors[2]), errors[3]).times(solid.groove_depth)
    return plate.subtract(band), error


def _ribbed_plate_moments(case: EvaluationBlock) -> tuple[AreaMoments, AreaMoments]:
    """Volume and moments of a plate with a rib on its face, and their errors."""
    solid, contacts = case.setup.solid, all_follower_contacts(case.setup)
    outer, inner = (integrate_section(block_at_contact(case, contact)) for contact in contacts)
    assert solid.thickness is not None
    assert solid.rib_height is not None
    assert solid.outer_diameter is not None
    plate = (
        disc_moments(solid.outer_diameter / 2.0)
        .subtract(_bore_moments(solid))
        .times(solid.thickness - solid.rib_height)
    )
    (_, area, x, y, polar), (_, *errors) = outer.value - inner.value, outer.error + inner.error
    band = AreaMoments(area, x + 1j * y, polar).times(solid.rib_height)
    error = AreaMoments(errors[0], np.hypot(errors[1], errors[2]), errors[3]).times(solid.rib_height)
    return plate.add(band), error


class BodyFormula(NamedTuple):
    """The formula of a body's volume and moments, and its quantities."""

    volume: Callable[[EvaluationBlock], tuple[AreaMoments, AreaMoments]]
    """Volume and moments, and their errors."""
    offered_quantities: tuple[str, ...]


BODY_FORMULAS = {
    DISC: BodyFormula(_plates_and_hub_moments, (MASS, *BALANCE, INERTIA)),
    FACE_GROOVE: BodyFormula(_grooved_plate_moments, (MASS, *BALANCE, INERTIA)),
    CYLINDER: BodyFormula(_grooved_cylinder_moments, (MASS, INERTIA)),
    RIBBED_CYLINDER: BodyFormula(_ribbed_cylinder_moments, (MASS, INERTIA)),
    RIBBED_DISC: BodyFormula(_ribbed_plate_moments, (MASS, *BALANCE, INERTIA)),
}
"""The formula of each body."""

EFFECT = Effect(
    "solid",
    offered_quantities,
    evaluate_columns,
    missing_keys_by_quantity,
    necessary_conditions=necessary_conditions,
)
