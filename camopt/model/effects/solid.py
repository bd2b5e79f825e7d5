"""The cam as a solid: its mass, its balance, its inertia, and the wall about its bore.

A disc cam is a plate as its section (``effects.section``), with a hub on one side; bore and keyway go through both.

    m = ρ·(t·A + (L − t)·A_hub),    unbalance ρ·|∫(x + iy) dV|,    J = ρ·∫r² dV

A conjugate pair is both plates, t·(A₁ + A₂), and on a hub that includes them and their gap (L − 2t)·A_hub. The
second section is seen in the mirror, x + iy as x − iy. The balance is that in one plane: the couple of both discs,
which are a distance apart along the axis, does not count.

A cylindrical cam is a cylinder of radius R_m + d/2 less bore, keyway and a groove of depth d about R_m. At each
radius r a cutter as wide as the roller leaves a band of the width 2R_r along a curve of the length L(r), with the
area 2·R_r·L(r) (Steiner: what a band gains on one side of a bend it loses on the other), so that

    V_groove = 2·R_r·∫L dr,    ∫r² dV = 2·R_r·∫r²·L dr

A rib leaves a cylinder of R_m − d/2, and on it at each radius r the band between the pitch curves of both rollers
less a strip of the width R_r along each: with the distance b(θ) of these curves along the axis, mm,

    V_rib = ∫ r dr·∫b dθ − R_r·∫(L₁ + L₂) dr

b is the distance of the rollers, times cos ψ of arms that swing (what else of it is in the area, adds up to nothing
over a turn).

A disc cam with a groove in its face is a plate of its outer diameter, less bore, keyway and the band of the groove
to its depth. With a rib on its face it is a plate, thinner than the whole by the height of the rib, and on it the
band between both flanks. The bottom of the groove of a cylinder is taken as a cylinder, and the cutter as narrow
beside it: its wall, parallel to its axis, is nowhere further than R_r²/(2·R_m) from that. Edges are sharp, and what
is undercut counts as in ``effects.section``.
"""

from collections.abc import Callable
from functools import reduce
from math import pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from camopt.core.numerics.quadrature import GAUSS_ORDERS, gauss
from camopt.core.numerics.stable import matrix_product
from camopt.model.effects.case import Bounded, Case, Effect, Setup, SolidGiven
from camopt.model.effects.contacts import at_contact, contacts_of
from camopt.model.effects.figures import Figure, disc, keyway
from camopt.model.effects.implied import Implied
from camopt.model.effects.section import JUST_ABOVE, groove_integrals_of, section_of
from camopt.model.mechanisms.elements import CYLINDER, DISC, FACE_GROOVE, RIBBED_CYLINDER, RIBBED_DISC

MASS, INERTIA = "cam_mass_kg", "cam_inertia_kg_m2"
BALANCE = ("unbalance_g_mm", "centre_of_gravity_mm")
KG, KG_M2, G_MM = 1e3, 1e-3, 1e6  # of t, t·mm², t·mm


def offers(setup: Setup) -> tuple[str, ...]:
    """Nothing at one flank of a rib: its body lies between both."""
    mechanism = setup.mechanism
    return () if mechanism.at_rib and not mechanism.ribbed else BODY_FORMULAS[mechanism.body].offers


def lacks(setup: Setup) -> dict[str, tuple[str, ...]]:
    sizes = setup.mechanism.body.solid
    keys = tuple(f"part.{key}" for key in (*sizes, "density") if getattr(setup.solid, key) is None)
    found = dict.fromkeys(offers(setup), keys)
    if BALANCE[1] in found:
        found[BALANCE[1]] = tuple(key for key in keys if key != "part.density")
    return {name: keys for name, keys in found.items() if keys}


def implies(setup: Setup, name: str, bound: float) -> Implied:
    """The base radius above which no disc cam has as little: its profile goes round the base circle."""
    if not setup.mechanism.body.bounded or name not in (MASS, INERTIA):
        return Implied()
    return Implied(most_size=_most_size(setup, name, bound))


def _most_size(setup: Setup, name: str, most: float) -> float:
    """Of the first disc of a pair, where the second one is no larger than the bore."""
    solid = setup.solid
    assert solid.thickness is not None
    assert solid.density is not None
    rest = _beside(solid, _count(setup)).without(_hollow(solid).times(solid.thickness))
    sought = most / (KG if name == MASS else KG_M2) / solid.density
    square = max(sought - rest.area, 0.0) / (pi * solid.thickness)
    if name == INERTIA:
        square = sqrt(2.0 * max(sought - rest.polar, 0.0) / (pi * solid.thickness))
    return max(sqrt(square) * JUST_ABOVE, solid.bore_reach)  # a hub too heavy by itself leaves no size


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    solid, size = case.setup.solid, case.designs.size
    assert solid.thickness is not None
    density = 1.0 if solid.density is None else solid.density
    body, off = BODY_FORMULAS[case.setup.mechanism.body].volume(case)
    mass, inertia = density * body.area, density * body.polar
    columns = {
        MASS: Bounded(mass * KG, density * off.area * KG, np.abs(mass) * KG),
        INERTIA: Bounded(inertia * KG_M2, density * off.polar * KG_M2, np.abs(inertia) * KG_M2),
    }
    if BALANCE[0] not in offers(case.setup):
        return columns
    moment, scale = np.abs(body.moment), np.abs(body.area) * size
    columns[BALANCE[0]] = Bounded(density * moment * G_MM, density * off.moment * G_MM, density * scale * G_MM)
    away = moment / body.area
    columns[BALANCE[1]] = Bounded(away, (off.moment + away * off.area) / body.area, size)
    return columns


def _hollow(solid: SolidGiven) -> Figure:
    """Bore and keyway."""
    slot = keyway(solid.bore_radius, solid.keyway_width, solid.keyway_depth, solid.keyway_angle)
    return disc(solid.bore_radius).and_(slot)


def _plates(case: Case) -> tuple[Figure, Figure]:
    """The volume of the plates and the hub with its moments, and the error of each."""
    solid, (first, *others) = case.setup.solid, contacts_of(case.setup)[: _count(case.setup)]
    assert solid.thickness is not None
    sections = [_section(at_contact(case, first))]
    sections += [_section(at_contact(case, other), mirror=-1.0) for other in others]
    body, off = (reduce(Figure.and_, each).times(solid.thickness) for each in zip(*sections, strict=True))
    hollow = _hollow(solid).times(len(sections) * solid.thickness)
    return body.without(hollow).and_(_beside(solid, len(sections))), off


def _count(setup: Setup) -> int:
    """How many discs there are."""
    return 1 + bool(setup.mechanism.second_keys)


def _section(case: Case, mirror: float = 1.0) -> tuple[Figure, Figure]:
    """The section of a disc, or its mirror image in the x axis, and the error of each of its integrals."""
    found = section_of(case)
    _, area, x, y, polar = found.value
    _, off_area, off_x, off_y, off_polar = found.error
    return Figure(area, x + 1j * mirror * y, polar), Figure(off_area, np.hypot(off_x, off_y), off_polar)


def _beside(solid: SolidGiven, plates: int) -> Figure:
    """The volume of the hub beside the plates, less bore and keyway, and its moments."""
    assert solid.thickness is not None
    beside = max(solid.hub_length - plates * solid.thickness, 0.0)
    return disc(solid.hub_radius).without(_hollow(solid)).times(beside)


def _cylinder(case: Case) -> tuple[Figure, Figure]:
    """The volume of a cylinder with its groove, its moments except the first, and the error of each."""
    solid, designs, groove = case.setup.solid, case.designs, groove_integrals_of(case)
    assert solid.thickness is not None
    assert solid.groove_depth is not None
    cylinder = disc(designs.size + solid.groove_depth / 2.0).without(_hollow(solid)).times(solid.thickness)
    (_, *band), (_, *off) = (2.0 * case.setup.half_width(designs) * rows for rows in groove)
    return cylinder.without(Figure(band[0], 0.0, band[1])), Figure(off[0], 0.0, off[1])


def _ribbed_cylinder(case: Case) -> tuple[Figure, Figure]:
    """The volume of a cylinder with a rib, its moments except the first, and the error of each."""
    solid, designs = case.setup.solid, case.designs
    assert solid.thickness is not None
    assert solid.rib_height is not None
    core, top = (designs.size + side * solid.rib_height / 2.0 for side in (-1.0, 1.0))
    apart = designs.roller_spacing * _share_along_axis(case) / (2.0 * pi)
    band = disc(top).without(disc(core)).times(apart)
    flanks = [groove_integrals_of(at_contact(case, contact)) for contact in contacts_of(case.setup)]
    (_, *less), (_, *off) = (case.setup.half_width(designs) * sum(rows) for rows in zip(*flanks, strict=True))
    body = disc(core).without(_hollow(solid)).times(solid.thickness).and_(band)
    return body.without(Figure(less[0], 0.0, less[1])), Figure(off[0], 0.0, off[1])


def _share_along_axis(case: Case) -> Any:
    """The integral over the turn of the share along the axis of the line through both rollers."""
    table, lift = case.programme.table, case.programme.lift
    if not case.setup.angular:
        return 2.0 * pi
    rule = gauss(GAUSS_ORDERS[-1])
    angles = table.centre[:, None] + table.half_width[:, None] * rule.nodes
    y, *_ = case.programme.at(angles.ravel())
    shares = matrix_product(np.cos(y - lift / 2.0).reshape(angles.shape), rule.weights)
    return float(matrix_product(shares, table.half_width))


def _grooved_plate(case: Case) -> tuple[Figure, Figure]:
    """The volume of a plate with a groove in its face, with its moments, and the error of each."""
    solid, groove = case.setup.solid, groove_integrals_of(case)
    assert solid.thickness is not None
    assert solid.groove_depth is not None
    assert solid.outer_diameter is not None
    plate = disc(solid.outer_diameter / 2.0).without(_hollow(solid)).times(solid.thickness)
    (_, area, x, y, polar), (_, *off) = groove
    band = Figure(area, x + 1j * y, polar).times(solid.groove_depth)
    return plate.without(band), Figure(off[0], np.hypot(off[1], off[2]), off[3]).times(solid.groove_depth)


def _ribbed_plate(case: Case) -> tuple[Figure, Figure]:
    """The volume of a plate with a rib on its face, with its moments, and the error of each."""
    solid, (beyond, before) = (
        case.setup.solid,
        (section_of(at_contact(case, each)) for each in contacts_of(case.setup)),
    )
    assert solid.thickness is not None
    assert solid.rib_height is not None
    assert solid.outer_diameter is not None
    plate = disc(solid.outer_diameter / 2.0).without(_hollow(solid)).times(solid.thickness - solid.rib_height)
    (_, area, x, y, polar), (_, *off) = beyond.value - before.value, beyond.error + before.error
    band = Figure(area, x + 1j * y, polar).times(solid.rib_height)
    return plate.and_(band), Figure(off[0], np.hypot(off[1], off[2]), off[3]).times(solid.rib_height)


class BodyFormula(NamedTuple):
    """The formula of a body's volume and moments, with the error of each."""

    volume: Callable[[Case], tuple[Figure, Figure]]
    offers: tuple[str, ...]


BODY_FORMULAS = {
    DISC: BodyFormula(_plates, (MASS, *BALANCE, INERTIA)),
    FACE_GROOVE: BodyFormula(_grooved_plate, (MASS, *BALANCE, INERTIA)),
    CYLINDER: BodyFormula(_cylinder, (MASS, INERTIA)),
    RIBBED_CYLINDER: BodyFormula(_ribbed_cylinder, (MASS, INERTIA)),
    RIBBED_DISC: BodyFormula(_ribbed_plate, (MASS, *BALANCE, INERTIA)),
}
"""By body."""

EFFECT = Effect("solid", offers, run, lacks, implies=implies)
