"""Contact stress by Hertz: line contact of rollers and flat faces, point contact of spherical faces.

    line:   p₀ = √(E*/(π·L)·max N/R),    b = 2·√(N·R/(π·L·E*)),    largest shear 0.30028·p₀ at the depth 0.78615·b
    point:  p₀ = ∛(E*²·max N·h/R_s²)

R is the relative radius of ``effects.loads``, b the half-width of the contact, L the face width. The ellipse of a
point contact has the relative radius R_s·(1 − κ·R_s) in the plane of the cam, and R_s across it, where the cam is a
cylinder. Its h and half-axes are those of ``numerics.point_contact``.

Validity: b must be small against R_r; the half-axes of a point contact must be small against the radii and the
cam's width. On a concave flank that nearly conforms to the roller, R grows without limit and the stress falls to
zero. A knife edge has no width, and its stress no bound.

In a groove the roller bears on the flank that pushes it outward where N > 0, and on the one that pulls it back
where N < 0. The contact stress is the larger of both. With clearance the roller may also strike the unloaded flank:
``contact_stress_either_MPa`` is the stress if |N| acts on the sharper of both. With a clearance j the flanks are
R_r + j/2 from the pitch curve and the centre of the roller is j/2 beside it, so κ/(1 ∓ κ·j/2) takes the place of κ.

Source: Johnson, Contact Mechanics, ch. 4.
"""

from functools import partial
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, FloatArray, Number
from camopt.core.numerics.curves import curve_value
from camopt.core.numerics.point_contact import carlson_integrals, contact_half_axis_ratio
from camopt.model.effects import force
from camopt.model.effects.bearing_radii import sure_and_possible_radii_for_load
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup, scale_per_design_if_varied
from camopt.model.effects.loads import (
    can_bear_load,
    contact_load_curve,
    friction_signs_by_stroke_kind,
    has_guide_friction,
    input_quantities_of_loads,
    normal_force_curve,
)
from camopt.model.effects.peak import LoadRootScale, Peak, Scale, Variant, is_infinite_by_velocity_jumps
from camopt.model.effects.peak_columns import DesignExtremes, column_from_extremes, peak_column, peak_extremes
from camopt.model.mechanisms.design import Designs
from camopt.model.mechanisms.elements import Flank

SHEAR_SHARE, SHEAR_DEPTH = 0.3002831060007776, 0.7861513777574233  # largest shear over p₀, and its depth over b
STRESS, HALF_WIDTH, HALF_LENGTH = "contact_stress_max_MPa", "contact_half_width_mm", "contact_half_length_mm"
SHEAR_STRESS = "contact_shear_max_MPa"
LINE_CONTACT = (STRESS, HALF_WIDTH, SHEAR_STRESS, "contact_shear_depth_mm")
POINT_CONTACT = (STRESS, HALF_WIDTH, HALF_LENGTH)
FLANK_SIGNS = {"contact_stress_push_MPa": 1.0, "contact_stress_pull_MPa": -1.0}
"""The sign of the normal force on the flank of each quantity, for mechanisms with a flank that pulls."""
EITHER_FLANK_STRESS = "contact_stress_either_MPa"


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    if setup.is_knife:
        return (STRESS,)
    flanks = (*FLANK_SIGNS, EITHER_FLANK_STRESS) if setup.mechanism.can_pull_follower else ()
    return (*(POINT_CONTACT if setup.spherical else LINE_CONTACT), *flanks)


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    keys = force.missing_force_keys(setup)
    if not setup.bodies.modulus:
        keys += ("materials.cam", "materials.follower")
    if not setup.bodies.face_width and not setup.spherical:
        keys += ("materials.face_width",)
    return {name: keys for name in applicable_quantities(setup) if keys and not setup.is_knife}


def load_curves_by_flank_and_friction(setup: Setup) -> list[tuple[Flank, float, Variant]]:
    """The loads of the stress by flank and direction of the guide's friction: (flank, way, variant)."""
    return [
        (flank, way, (partial(contact_load_curve, setup, flank=flank, velocity_sign=way), kinds))
        for flank in setup.mechanism.flanks
        for way, kinds in friction_signs_by_stroke_kind(setup)
    ]


def stress_scale(setup: Setup, factor: float = 1.0) -> Scale:
    """The scale from the load, N/R [N/mm] or N·h/R_s² [N/mm²], to a multiple of the stress [MPa]."""
    degree = 3 if setup.spherical else 2
    root, unit = LoadRootScale(degree, load_of_unit_stress(setup), factor), LoadRootScale(degree, 1.0, factor)
    return scale_per_design_if_varied(setup, root, unit, lambda numbers: 1.0 / load_of_unit_stress(numbers))


def load_of_unit_stress(setup: Setup) -> Number:
    """Load at which the stress is 1 MPa."""
    bodies = setup.bodies
    return 1.0 / bodies.modulus**2 if setup.spherical else np.pi * bodies.face_width / bodies.modulus


def contact_stress(setup: Setup, load: Any, designs: Designs) -> Number:
    """Contact stress at a load [MPa]; 0 for a load below 0."""
    return stress_scale(setup).quantity_from_extreme(load, designs)


def peaks(setup: Setup) -> dict[str, Peak]:
    if setup.is_knife or missing_keys_by_quantity(setup):
        return {}
    curves, stress = tuple(variant for *_, variant in load_curves_by_flank_and_friction(setup)), stress_scale(setup)
    bodies = None if setup.spherical or has_guide_friction(setup) else sure_and_possible_radii_for_load
    stresses = {STRESS: Peak(curves, LARGEST, stress, is_infinite_by_velocity_jumps, bodies=bodies)}
    if not setup.spherical:
        stresses[SHEAR_STRESS] = stresses[STRESS]._replace(scale=stress_scale(setup, SHEAR_SHARE))
    if setup.mechanism.can_pull_follower:
        stresses[EITHER_FLANK_STRESS] = Peak(curves, LARGEST_MAGNITUDE, stress, is_infinite_by_velocity_jumps)
        for name, sign in FLANK_SIGNS.items():
            loads = load_curves_by_flank_and_friction(setup)
            signed_curves = tuple(variant for flank, _, variant in loads if flank.pressing == sign)
            stresses[name] = Peak(signed_curves, LARGEST, stress, is_infinite_by_velocity_jumps)
    return stresses


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    setup = case.setup
    if setup.is_knife:
        return {STRESS: np.inf}
    known, sound = peaks(setup), can_bear_load(case)
    columns: dict[str, Any] = {
        name: peak_column(case, known[name], sound)
        for name in wanted_quantities & known.keys() - {STRESS, SHEAR_STRESS}
    }
    patch_wanted = bool(wanted_quantities - known.keys())
    top = peak_extremes(case, known[STRESS], sound, exact_angles=patch_wanted)
    columns |= {
        name: column_from_extremes(case, known[name], top) for name in (STRESS, SHEAR_STRESS) if name in known
    }
    if patch_wanted:
        load, (width, length) = np.maximum(top.value, 0.0), np.zeros((2, len(case.designs)))
        width[~np.isfinite(load)] = length[~np.isfinite(load)] = np.inf
        for number, (flank, way, (make, _)) in enumerate(load_curves_by_flank_and_friction(setup)):
            here = np.flatnonzero(np.isfinite(load) & (load > 0.0) & (top.number == number))
            if here.size:
                width[here], length[here] = _half_axes_at_largest_stress(case, make, flank, way, here, top)
        columns[HALF_WIDTH] = width
        columns |= {HALF_LENGTH: length} if setup.spherical else {"contact_shear_depth_mm": SHEAR_DEPTH * width}
    return columns


def _half_axes_at_largest_stress(
    case: EvaluationBlock,
    load_curve: Any,
    flank: Flank,
    velocity_sign: float,
    index: Any,
    stress_extremes: DesignExtremes,
) -> tuple[FloatArray, FloatArray]:
    """Half-axes of the contact at the largest stress, in the plane of the cam and across it [mm].

    Line contact: 2·N/(π·L·p₀), and half the face width. Point contact: a = 2·R_s·p₀·B/(μ·E*), and b = μ·a.
    """
    setup, designs, programme = case.setup, case.designs.take(index), case.programme
    load, normal = load_curve(designs, programme), normal_force_curve(setup, designs, programme, velocity_sign)
    curved = setup.mechanism.curvature(designs, programme) if setup.mechanism.curvature else None
    values = []
    for turn in (-1e-12, 1e-12):  # to both sides of a jump
        motion = programme.state(np.mod(stress_extremes.where[index] + turn, 2 * np.pi))
        bend = curve_value(curved, ..., motion) if curved else 0.0
        values.append(np.broadcast_arrays(curve_value(load, ..., motion), curve_value(normal, ..., motion), bend))
    nearer = np.abs(values[0][0] - stress_extremes.value[index]) < np.abs(
        values[1][0] - stress_extremes.value[index]
    )
    _, force, bend = (np.where(nearer, one, two) for one, two in zip(*values, strict=True))
    bodies = setup.with_design_numbers(designs).bodies
    stress = contact_stress(setup, stress_extremes.value[index], designs)
    if setup.spherical:
        mu = contact_half_axis_ratio(1.0 - flank.bulge * designs.roller_radius * bend)
        b, _ = carlson_integrals(mu)
        across = np.asarray(2.0 * designs.roller_radius * stress * b / bodies.modulus)
        return across / mu, across
    return 2.0 * np.abs(force) / (np.pi * bodies.face_width * stress), np.full_like(force, 0.5 * bodies.face_width)


EFFECT = Effect(
    "hertz",
    applicable_quantities,
    evaluate_columns,
    missing_keys_by_quantity,
    lambda setup: () if setup.is_knife else input_quantities_of_loads(setup),
    is_of_motion=lambda setup: setup.is_knife,
    peaks=peaks,
    is_per_contact=True,
)
