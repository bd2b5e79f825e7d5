"""Loads on the contact as curves over the turn: normal force, side thrust, torque, and the load of contact stress.

F is the force along the motion (``effects.force``), t = tan β, and a guide has the length b and the overhang
a = a₀ − y. The contact gives the force G along the motion: F plus the friction at both ends of the guide, μ·q·|S|,
which acts against the motion.

    G = F/D,    D = 1 − sgn(F·y')·μ·q·|t|,    q = (2a + b)/b,    N = G·√(1 + t²),    S = G·t,    T = G·y'

An open cam cannot pull: where F < 0, contact is lost, and N and S are 0. The torque T is that of the prescribed
motion. At rest friction may act either way, up to its limit; it is taken as 0, so D = 1. For an oscillating
follower F/l takes the place of F; an oscillating flat face touches at the distance r from the pivot, N = F/r. Line
contact has the load

    N/R,    roller: 1/R = κ/(1 − κ·R_r) + 1/R_r = 1/(R_r·(1 − κ·R_r)),    flat face: R = ρ

and a spherical face N·h(1 − κ·R_s)/R_s² (``numerics.point_contact``).

All curves are built from the mechanism's curves of pressure angle, curvature, radius and reach.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from camopt.core.numerics import Curve, Number
from camopt.core.numerics.curves import curve_type_from_formula
from camopt.core.numerics.point_contact import pressure_factor_and_derivative, pressure_factor_coefficients
from camopt.core.numerics.state import State
from camopt.model.effects.effect import EvaluationBlock, Setup
from camopt.model.effects.effect_numbers import FollowerDynamics
from camopt.model.effects.force import contact_force_curve, follower_force_curve
from camopt.model.effects.peak import Variant
from camopt.model.mechanisms.design import Designs
from camopt.model.mechanisms.elements import Flank
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES, INWARD, OUTWARD, RESTING


@curve_type_from_formula(reads_load=True)
def pushing_force(state: State, force: Number) -> Number:
    """Force that an open cam bears [N]; 0 where it would have to pull."""
    return np.maximum(force, 0.0)


@curve_type_from_formula(reads_load=True)
def preloaded_contact_force(state: State, force: Number, preload: Number) -> Number:
    """Force on one of two preloaded contacts, F/2 + max(|F|/2, P) [N] (``effects.preload``)."""
    alone = np.maximum(0.5 * force - preload, 0.0)
    return np.maximum(0.5 * force + preload + alone, 0.0)  # exactly 0 where F < −2·P, without cancellation


@curve_type_from_formula(reads_load=True)
def force_with_guide_friction(
    state: State, force: Number, pressure_tangent: Number, friction_intercept: Number, friction_slope: Number
) -> Number:
    """Force along the motion with friction in the guide, G [N]; D = 1 − sgn(F)·(drag + slide·y)·|t|."""
    return force / (
        1.0 - np.sign(force) * (friction_intercept + friction_slope * state.y) * np.abs(pressure_tangent)
    )


@curve_type_from_formula(reads_load=True)
def normal_force(state: State, force_along_motion: Number, pressure_tangent: Number) -> Number:
    """Normal force of a follower with a trace point, N [N]."""
    return force_along_motion * np.sqrt(np.square(pressure_tangent) + 1.0)


@curve_type_from_formula(reads_load=True)
def side_thrust_times_lever(
    state: State, force_along_motion: Number, pressure_tangent: Number, lever_intercept: Number, lever_slope: Number
) -> Number:
    """Side thrust times a lever, S·(arm + reach·y) [N, or N·mm if the lever is a length]."""
    return force_along_motion * pressure_tangent * (lever_intercept + lever_slope * state.y)


@curve_type_from_formula
def jamming_ratio(
    state: State, pressure_tangent: Number, friction_intercept: Number, friction_slope: Number
) -> Number:
    """μ·q·t; at 1 the follower jams in its guide."""
    return (friction_intercept + friction_slope * state.y) * pressure_tangent


@curve_type_from_formula(reads_load=True)
def swinging_face_normal_force(state: State, moment: Number, distance_from_pivot: Number) -> Number:
    """Normal force on an oscillating flat face [N]: the moment over the distance of the contact from the pivot."""
    return moment / distance_from_pivot


@curve_type_from_formula(reads_load=True)
def roller_load_per_relative_radius(
    state: State,
    normal: Number,
    curvature: Number,
    roller_radius: Number,
    pressing_sign: Number,
    bulge_sign: Number,
) -> Number:
    """Load of a roller, N/R [N/mm]; positive where N presses the roller on the flank.

    ``pressing_sign`` is the sign of such an N. ``bulge_sign`` is 1 if κ > 0 bends the flank towards the roller,
    else −1.
    """
    return pressing_sign * normal / (roller_radius - bulge_sign * roller_radius * roller_radius * curvature)


@curve_type_from_formula
def parallel_curve_curvature(state: State, curvature: Number, distance: Number) -> Number:
    """Curvature of a parallel of the pitch curve [1/mm], ``distance`` [mm] to the side that κ > 0 makes hollow."""
    return curvature / (1.0 - distance * curvature)


@curve_type_from_formula(reads_load=True)
def spherical_face_load_per_square_radius(
    state, normal, curvature, face_radius, pressing_sign, bulge_sign, pressure_factor_table=None
):
    """Load of a spherical face, N·h/R_s² [N/mm²], with a table of h.

    Other arguments as of ``roller_load_per_relative_radius``.
    """
    h, _ = pressure_factor_and_derivative(1.0 - bulge_sign * face_radius * curvature, pressure_factor_table)
    return pressing_sign / (face_radius * face_radius) * (normal * h)


@curve_type_from_formula(reads_load=True)
def flat_face_load_per_radius(state: State, normal: Number, profile_radius: Number) -> Number:
    """Load of a flat face, N/ρ [N/mm]."""
    return normal / profile_radius


@curve_type_from_formula(reads_load=True)
def shaft_torque(state: State, force_along_motion: Number) -> Number:
    """Torque of the camshaft, T = G·y' [N·mm]."""
    return force_along_motion * state.y1


def has_guide_friction(setup: Setup) -> bool:
    """Whether the follower runs in a guide with friction."""
    dynamics = setup.dynamics
    sizes_given = dynamics.guide_length is not None and dynamics.overhang is not None
    return bool(sizes_given and dynamics.friction and not setup.angular and not setup.mechanism.flat_faced)


def guide_friction_line_coefficients(
    dynamics: FollowerDynamics, design_count: int, velocity_sign: float
) -> tuple[Any, Any]:
    """Intercept and slope of the line way·μ·q by y."""
    q = 1.0 + 2.0 * dynamics.overhang / dynamics.guide_length
    slide = -2.0 * dynamics.friction / dynamics.guide_length
    ones = np.ones(design_count)
    return velocity_sign * dynamics.friction * q * ones, velocity_sign * slide * ones


def force_along_motion_curve(
    setup: Setup, designs: Designs, programme: Programme, velocity_sign: float = 0.0, *, can_pull: bool = False
) -> Curve:
    """Curve of the force along the motion, G [N]; on an oscillating flat face the moment [N·mm].

    ``velocity_sign`` is the sign of the follower's velocity: 1, −1, or 0 at rest. With ``can_pull`` the cam gives F
    < 0 too.
    """
    force = contact_force_curve(setup, designs, programme)
    dynamics = setup.with_design_numbers(designs).dynamics
    if not (can_pull or setup.mechanism.can_pull_follower):
        if dynamics.pair_preload is None:
            force = pushing_force(force)
        else:
            lever = designs.arm_length if setup.angular and setup.mechanism.curvature else 1.0
            force = preloaded_contact_force(force, dynamics.pair_preload / lever * np.ones(len(designs)))
    if not has_guide_friction(setup):
        return force
    pressure = setup.mechanism.pressure(designs, programme)
    friction_line = guide_friction_line_coefficients(dynamics, len(designs), velocity_sign)
    return force_with_guide_friction(force, pressure, *friction_line)


def normal_force_curve(setup: Setup, designs: Designs, programme: Programme, velocity_sign: float = 0.0) -> Curve:
    """Curve of the normal force [N] while the follower moves in one direction."""
    along = force_along_motion_curve(setup, designs, programme, velocity_sign)
    if setup.mechanism.curvature:
        return normal_force(along, setup.mechanism.pressure(designs, programme))
    if setup.angular and setup.mechanism.reach:
        return swinging_face_normal_force(along, setup.mechanism.reach(designs, programme))
    return along


def torque_curve(setup: Setup, designs: Designs, programme: Programme, velocity_sign: float = 0.0) -> Curve:
    """Curve of the camshaft's torque [N·mm] while the follower moves in one direction.

    Without friction it is the same for all designs.
    """
    if has_guide_friction(setup):
        return shaft_torque(force_along_motion_curve(setup, designs, programme, velocity_sign, can_pull=True))
    return shaft_torque(follower_force_curve(setup, designs, programme))


def contact_load_curve(
    setup: Setup, designs: Designs, programme: Programme, flank: Flank | None = None, velocity_sign: float = 0.0
) -> Curve:
    """Curve of the load of contact stress on a flank: N/R [N/mm], at a spherical face N·h/R_s² [N/mm²].

    Without a flank, it is the load on the first flank, which pushes.
    """
    flank = flank or setup.mechanism.flanks[0]
    normal = normal_force_curve(setup, designs, programme, velocity_sign)
    if setup.mechanism.profile_radius:
        return flat_face_load_per_radius(normal, setup.mechanism.profile_radius(designs, programme))
    curvature = flank_path_curvature_curve(setup, designs, programme, flank)
    pressing, bent = (np.full(len(designs), sign) for sign in (flank.pressing, flank.bulge))
    if setup.spherical:
        return spherical_face_load_per_square_radius(
            normal, curvature, designs.roller_radius, pressing, bent, pressure_factor_coefficients()
        )
    return roller_load_per_relative_radius(normal, curvature, designs.roller_radius, pressing, bent)


def flank_path_curvature_curve(setup: Setup, designs: Designs, programme: Programme, flank: Flank) -> Curve:
    """Curve of the curvature of the trace point's path on a flank; a clearance puts it beside the pitch curve."""
    assert setup.mechanism.curvature is not None
    curvature = setup.mechanism.curvature(designs, programme)
    if setup.given.drive.clearance is None:
        return curvature
    return parallel_curve_curvature(
        curvature, flank.bulge * (setup.pitch_to_flank_distance(designs) - designs.roller_radius)
    )


def friction_signs_by_stroke_kind(setup: Setup) -> tuple[tuple[float, int], ...]:
    """The directions of the guide's friction, each with the kinds of pieces on which it acts."""
    return ((1.0, OUTWARD), (-1.0, INWARD), (0.0, RESTING)) if has_guide_friction(setup) else ((0.0, ALL_STROKES),)


def curve_variants_by_friction(make_curve: Callable[..., Any], setup: Setup) -> tuple[Variant, ...]:
    """A curve for each direction of the guide's friction, which it takes as ``velocity_sign``."""
    return tuple(
        (partial(make_curve, setup, velocity_sign=way), kinds)
        for way, kinds in friction_signs_by_stroke_kind(setup)
    )


def jamming_stroke_kinds(setup: Setup) -> int:
    """The kinds of pieces on which the cam works against the guide's friction, where the follower may jam."""
    return OUTWARD | INWARD if setup.mechanism.can_pull_follower else OUTWARD


def jamming_ratio_curve(setup: Setup, designs: Designs, programme: Programme) -> Curve:
    drag = guide_friction_line_coefficients(setup.with_design_numbers(designs).dynamics, len(designs), 1.0)
    return jamming_ratio(setup.mechanism.pressure(designs, programme), *drag)


def input_quantities_of_loads(setup: Setup) -> tuple[str, ...]:
    """The quantities that ``can_bear_load`` reads; a knife edge has no undercut."""
    undercut = () if setup.is_knife else ("undercut",)
    return (*undercut, *(("jamming_margin",) if has_guide_friction(setup) else ()))


def can_bear_load(case: EvaluationBlock) -> Any:
    """Mask of designs whose contact bears loads: without undercut, and with a follower that does not jam."""
    undercut = np.broadcast_to(case.columns.get("undercut", False), len(case.designs))
    return ~undercut & (np.asarray(case.columns.get("jamming_margin", 1.0)) > 0.0)
