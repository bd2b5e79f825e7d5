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
from math import asin, cos, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics import FloatArray, Number
from camopt.core.numerics.quadrature import GAUSS_ORDERS, gauss_rule
from camopt.core.numerics.stable_functions import matrix_product
from camopt.model.effects.contacts import all_follower_contacts, block_at_contact
from camopt.model.effects.effect import (
    Effect,
    EnclosedValue,
    EvaluationBlock,
    NecessaryConditions,
    Setup,
    SolidSizes,
)
from camopt.model.effects.section import JUST_ABOVE, integrate_groove, integrate_section
from camopt.model.mechanisms.elements import CYLINDER, DISC, FACE_GROOVE, RIBBED_CYLINDER, RIBBED_DISC

MASS, INERTIA = "cam_mass_kg", "cam_inertia_kg_m2"
BALANCE = ("unbalance_g_mm", "centre_of_gravity_mm")
KG, KG_M2, G_MM = 1e3, 1e-3, 1e6  # per t, t·mm², t·mm
ROUNDING = 2e-15  # relative rounding error of closed forms, and of sums and products with them


class AreaMoments(NamedTuple):
    """Area [mm²], first moment (complex x + iy) [mm³] and polar moment about the axis [mm⁴]; numbers or arrays."""

    area: Any
    moment: Any
    polar: Any

    def subtract(self, other: "AreaMoments") -> "AreaMoments":
        """The figure without another one inside it."""
        return AreaMoments(*(a - b for a, b in zip(self, other, strict=True)))

    def add(self, other: "AreaMoments") -> "AreaMoments":
        """Both figures together; they do not overlap."""
        return AreaMoments(*(a + b for a, b in zip(self, other, strict=True)))

    def times(self, factor: float) -> "AreaMoments":
        """The moments times a factor, as a thickness or a density."""
        return AreaMoments(*(factor * each for each in self))


def disc_moments(radius: Any) -> AreaMoments:
    return AreaMoments(pi * radius**2, 0.0, pi * radius**4 / 2.0)


def keyway_moments(bore_radius: float, width: float, depth: float, angle: float) -> AreaMoments:
    """Moments of a keyway in the direction of an angle [rad], without the bore; all 0 if its width is 0.

    A keyway of width w runs from the bore (radius r) to a flat bottom at the distance r + t from the axis. It is
    the rectangle |v| ≤ a = w/2, 0 ≤ u ≤ r + t, without the part of the bore inside it. With c = √(r² − a²) and
    φ = arcsin(a/r) that part has

        area = a·c + r²·φ,    ∫u dA = a·r² − a³/3,    ∫(u² + v²) dA = a·c·(r² + 2a²)/6 + r⁴·φ/2

    Source: integrals of Bronshtein et al., Handbook of Mathematics, table 21.7 (√(a² − x²)).
    """
    r, a, u = bore_radius, width / 2.0, bore_radius + depth
    if not a:
        return AreaMoments(0.0, 0.0, 0.0)
    c, phi = sqrt((r - a) * (r + a)), asin(a / r)
    area = 2.0 * a * u - (a * c + r**2 * phi)
    along = a * u**2 - (a * r**2 - a**3 / 3.0)
    polar = 2.0 * a * u * (u**2 + a**2) / 3.0 - (a * c * (r**2 + 2.0 * a**2) / 6.0 + r**4 * phi / 2.0)
    return AreaMoments(area, along * complex(cos(angle), sin(angle)), polar)


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    """Nothing for one flank of a rib, because the body is between both flanks."""
    mechanism = setup.mechanism
    if mechanism.touches_rib and not mechanism.has_rib:
        return ()
    return BODY_FORMULAS[mechanism.body].applicable_quantities


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    needed = (*setup.mechanism.body.solid, "density")
    keys = tuple(f"part.{key}" for key in needed if getattr(setup.solid, key) is None)
    missing = dict.fromkeys(applicable_quantities(setup), keys)
    if BALANCE[1] in missing:
        missing[BALANCE[1]] = tuple(key for key in keys if key != "part.density")
    return {name: keys for name, keys in missing.items() if keys}


def necessary_conditions(setup: Setup, quantity_name: str, bound: float) -> NecessaryConditions:
    """The largest base radius for a bound on mass or inertia: every profile goes round the base circle."""
    if not setup.mechanism.body.bounded or quantity_name not in (MASS, INERTIA):
        return NecessaryConditions()
    # the first disc of a pair; the second one is no larger than the bore
    solid = setup.solid
    rest = _hub_moments(solid, _disc_count(setup)).subtract(_bore_moments(solid).times(solid.thickness))
    allowed = bound / (KG if quantity_name == MASS else KG_M2) / solid.density
    square = max(allowed - rest.area, 0.0) / (pi * solid.thickness)
    if quantity_name == INERTIA:
        square = sqrt(2.0 * max(allowed - rest.polar, 0.0) / (pi * solid.thickness))
    # if the hub alone is too heavy, no size is left
    return NecessaryConditions(most_size=max(sqrt(square) * JUST_ABOVE, solid.bore_reach))


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    solid, size = case.setup.solid, case.designs.size
    density = 1.0 if solid.density is None else solid.density
    body, error = BODY_FORMULAS[case.setup.mechanism.body].volume(case)
    # rounding of the closed forms is less than that of a cylinder round all their parts
    radius = np.maximum(size + (solid.groove_depth_or_rib_height or 0.0) / 2.0, (solid.outer_diameter or 0.0) / 2.0)
    blank = disc_moments(radius).times(ROUNDING * max(solid.thickness, solid.hub_length))
    error = error.add(AreaMoments(blank.area, blank.area * radius, blank.polar))
    mass, inertia = density * body.area, density * body.polar
    columns = {
        MASS: EnclosedValue(mass * KG, density * error.area * KG, np.abs(mass) * KG),
        INERTIA: EnclosedValue(inertia * KG_M2, density * error.polar * KG_M2, np.abs(inertia) * KG_M2),
    }
    if BALANCE[0] not in applicable_quantities(case.setup):
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
    sections = [_section_moments(*integrate_section(block_at_contact(case, first))[:2])]
    for other in others:
        section = integrate_section(block_at_contact(case, other))
        sections.append(_section_moments(section.value, section.error, mirror_sign=-1.0))
    body, error = (reduce(AreaMoments.add, parts).times(solid.thickness) for parts in zip(*sections, strict=True))
    hollow = _bore_moments(solid).times(len(sections) * solid.thickness)
    return body.subtract(hollow).add(_hub_moments(solid, len(sections))), error


def _disc_count(setup: Setup) -> int:
    return 1 + bool(setup.mechanism.second_contact_size_keys)


def _section_moments(
    value: FloatArray, error: FloatArray, mirror_sign: float = 1.0
) -> tuple[AreaMoments, AreaMoments]:
    """Moments of a section from its integrals, or of its mirror image (``mirror_sign`` −1), and their errors."""
    (_, area, x, y, polar), (_, *errors) = value, error
    body = AreaMoments(area, x + 1j * mirror_sign * y, polar)
    return body, AreaMoments(errors[0], np.hypot(errors[1], errors[2]), errors[3])


def _hub_moments(solid: SolidSizes, plate_count: int) -> AreaMoments:
    """Volume and moments of the hub beside the plates, without bore and keyway."""
    beside = max(solid.hub_length - plate_count * solid.thickness, 0.0)
    return disc_moments(solid.hub_radius).subtract(_bore_moments(solid)).times(beside)


def _grooved_cylinder_moments(case: EvaluationBlock) -> tuple[AreaMoments, AreaMoments]:
    """Volume and polar moment of a cylinder with its groove, and their errors."""
    solid, designs, groove = case.setup.solid, case.designs, integrate_groove(case)
    cylinder = (
        disc_moments(designs.size + solid.groove_depth / 2.0).subtract(_bore_moments(solid)).times(solid.thickness)
    )
    (_, *band), (_, *errors) = (2.0 * case.setup.pitch_to_flank_distance(designs) * rows for rows in groove)
    return cylinder.subtract(AreaMoments(band[0], 0.0, band[1])), AreaMoments(errors[0], 0.0, errors[1])


def _ribbed_cylinder_moments(case: EvaluationBlock) -> tuple[AreaMoments, AreaMoments]:
    """Volume and polar moment of a cylinder with a rib, and their errors."""
    solid, designs = case.setup.solid, case.designs
    core, top = (designs.size + side * solid.rib_height / 2.0 for side in (-1.0, 1.0))
    distance = designs.roller_spacing * _axial_share_integral(case) / (2.0 * pi)
    band = disc_moments(top).subtract(disc_moments(core)).times(distance)
    flanks = [integrate_groove(block_at_contact(case, contact)) for contact in all_follower_contacts(case.setup)]
    (_, *strips), (_, *errors) = (
        case.setup.pitch_to_flank_distance(designs) * sum(rows) for rows in zip(*flanks, strict=True)
    )
    body = disc_moments(core).subtract(_bore_moments(solid)).times(solid.thickness).add(band)
    return body.subtract(AreaMoments(strips[0], 0.0, strips[1])), AreaMoments(errors[0], 0.0, errors[1])


def _axial_share_integral(case: EvaluationBlock) -> Number:
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
    plate = disc_moments(solid.outer_diameter / 2.0).subtract(_bore_moments(solid)).times(solid.thickness)
    band, error = (moments.times(solid.groove_depth) for moments in _section_moments(groove.value, groove.error))
    return plate.subtract(band), error


def _ribbed_plate_moments(case: EvaluationBlock) -> tuple[AreaMoments, AreaMoments]:
    """Volume and moments of a plate with a rib on its face, and their errors."""
    solid, contacts = case.setup.solid, all_follower_contacts(case.setup)
    outer, inner = (integrate_section(block_at_contact(case, contact)) for contact in contacts)
    plate = (
        disc_moments(solid.outer_diameter / 2.0)
        .subtract(_bore_moments(solid))
        .times(solid.thickness - solid.rib_height)
    )
    section = _section_moments(outer.value - inner.value, outer.error + inner.error)
    band, error = (moments.times(solid.rib_height) for moments in section)
    return plate.add(band), error


class BodyFormula(NamedTuple):
    """The formula of a body's volume and moments, and its quantities."""

    volume: Callable[[EvaluationBlock], tuple[AreaMoments, AreaMoments]]
    """Volume and moments, and their errors."""
    applicable_quantities: tuple[str, ...]


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
    applicable_quantities,
    evaluate_columns,
    missing_keys_by_quantity,
    necessary_conditions=necessary_conditions,
)
