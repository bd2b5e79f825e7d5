"""Sliding, rolling, wear and film thickness at the contact of a disc cam.

All speeds are by the cam angle, in mm/rad. The contact moves over the cam at c and over the follower at c_f; the
follower slides over the cam at v = c − c_f. q is the rate at which the follower turns relative to the cam: 1, or
1 ± ψ' with an arm. N_p is the speed of the trace point (``Mechanism.sliding``).

    knife edge, spherical face:  v = N_p − q·R_s,          c = N_p·(1 − κ·R_s)
    roller that does not slip:   v = 0,                    c = N_p·(1 − κ·R_r),    spins at N_p/R_r − q
    flat face:                   v = R_b + y (swinging: q·f + c·sin ψ),            c = q·ρ

The entrainment speed, at which the surfaces carry in the lubricant, is u = (c + c_f)/2 = c − v/2. By Archard's law
a point of the profile wears by the depth k_w·(N/L)·|v|/c in each turn. The least film of line contact, by Dowson
and Higginson, is

    h = 2.65·R·(α·E')^0.54·U^0.7·W^−0.13,    U = η·u/(E'·R),    W = N/(E'·R·L),    E' = 2·E*

It is computed at each cam angle as for steady motion: 0 where u passes through 0, although squeezing leaves a thin
film there. It is valid for stiff surfaces and oils that thicken under pressure. Point contacts have neither wear
nor film here, and a knife edge has no film.

On the outer wall of a groove a roller spins the other way, at N_p/R_r + q. Grooves have the largest spin on either
wall, but no entrainment and no film. On a cylinder q − 1 takes the place of q, because its surface does not turn
below the roller.

Sources: Archard, J. Appl. Phys. 24 (1953); Dowson and Higginson, Elasto-hydrodynamic Lubrication, ch. 7.
"""

from functools import partial
from math import pi
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, Curve, FloatArray, Number
from camopt.core.numerics.curves import curve_type_from_formula
from camopt.core.numerics.jet import power_of_number
from camopt.core.numerics.state import State
from camopt.model.effects import force
from camopt.model.effects.effect import (
    Effect,
    EvaluationBlock,
    Setup,
    multiple_scale,
    scale_per_design_if_varied,
)
from camopt.model.effects.loads import (
    can_bear_load,
    contact_load_curve,
    curve_variants_by_friction,
    flank_path_curvature_curve,
    input_quantities_of_loads,
    normal_force_curve,
)
from camopt.model.effects.peak import (
    InverseScale,
    Peak,
    PerRollerRadiusScale,
    Scale,
    Variant,
    is_infinite_by_velocity_jumps,
    never_infinite_by_jumps,
)
from camopt.model.effects.peak_columns import (
    DesignExtremes,
    column_from_extremes,
    largest_and_least_columns,
    peak_column,
    peak_extremes,
)
from camopt.model.mechanisms.design import Designs, Mechanism
from camopt.model.mechanisms.elements import INNER_SIDE
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES

SLIDING_SPEED, ROLLER_SPEED = "sliding_speed_max_m_s", "roller_speed_max_rpm"
FASTEST_ENTRAINMENT, SLOWEST_ENTRAINMENT = "entrainment_speed_max_m_s", "entrainment_speed_min_m_s"
WEAR_DEPTH, FILM_THICKNESS, FILM_RATIO = "wear_depth_max_um", "film_thickness_min_um", "film_ratio_min"
LUBRICANT = ("viscosity", "pressure_viscosity")
FILM_SPEED_POWER, FILM_LOAD_POWER, FILM_RADIUS_POWER = 0.7, 0.13, 0.43  # exponents of u, 1/N and R in the film
REPORTED_TURNS = 1e6


@curve_type_from_formula
def trace_point_sliding_speed(
    state: State, trace_point_speed: Number, roller_radius: Number, turns: Number, turn_per_velocity: Number
) -> Number:
    """Sliding speed of a trace point, N_p − q·R [mm/rad], with q = turns + turning·y'."""
    return trace_point_speed - roller_radius * (turns + turn_per_velocity * state.y1)


@curve_type_from_formula
def roller_spin_acceleration(
    state: State, trace_point_acceleration: Number, roller_radius: Number, turn_per_velocity: Number
) -> Number:
    """Change of the spin's speed, N_p' − R·q' [mm/rad²]; q = 1 + turn_per_velocity·y', N_p' the acceleration."""
    return trace_point_acceleration - roller_radius * turn_per_velocity * state.y2


@curve_type_from_formula
def trace_point_entrainment_speed(
    state, trace_point_speed, curvature, roller_radius, turn_per_velocity, slip_factor
):
    """Entrainment speed, N_p·(1 − κ·R) − slip·(N_p − q·R)/2 [mm/rad]; ``slip_factor`` is 0 for a roller, else 1."""
    half = 0.5 * slip_factor
    return trace_point_speed * ((1.0 - half) - roller_radius * curvature) + half * roller_radius * (
        1.0 + turn_per_velocity * state.y1
    )


@curve_type_from_formula
def flat_face_entrainment_speed(
    state: State, profile_radius: Number, sliding_speed: Number, turn_per_velocity: Number
) -> Number:
    """Entrainment speed of a flat face, q·ρ − v/2 [mm/rad]."""
    return (1.0 + turn_per_velocity * state.y1) * profile_radius - 0.5 * sliding_speed


@curve_type_from_formula(reads_load=True)
def flat_face_wear_load(
    state: State, load_per_radius: Number, sliding_speed: Number, turn_per_velocity: Number
) -> Number:
    """Wear load of a flat face, N·|v|/(q·ρ) [N]; ``load_per_radius`` is N/ρ."""
    return load_per_radius * np.abs(sliding_speed) / (1.0 + turn_per_velocity * state.y1)


@curve_type_from_formula
def roller_relative_radius(state: State, curvature: Number, roller_radius: Number) -> Number:
    """Relative radius, R = R_r·(1 − κ·R_r) [mm]."""
    return roller_radius - roller_radius * roller_radius * curvature


@curve_type_from_formula(reads_load=True)
def inverse_film_thickness(
    state: State, normal_force: Number, entrainment_speed: Number, relative_radius: Number
) -> Number:
    """Inverse of the film up to a factor, N^0.13·u^−0.7·R^−0.43, from N, mm/rad and mm."""
    spread = power_of_number(np.square(entrainment_speed), -0.5 * FILM_SPEED_POWER) * power_of_number(
        relative_radius, -FILM_RADIUS_POWER
    )
    return power_of_number(normal_force, FILM_LOAD_POWER) * spread


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    if speed_over_cam_curve_maker(setup.mechanism) is None:
        return ()
    if setup.mechanism.has_flanks_on_both_sides:
        return (ROLLER_SPEED,) if setup.rolls else ()
    worn = () if setup.spherical or setup.rolls else (WEAR_DEPTH,)
    carried = () if setup.spherical or setup.is_knife else (FILM_THICKNESS, FILM_RATIO)
    return (
        ROLLER_SPEED if setup.rolls else SLIDING_SPEED,
        FASTEST_ENTRAINMENT,
        SLOWEST_ENTRAINMENT,
        *worn,
        *carried,
    )


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    bodies, speed = setup.bodies, () if setup.omega is not None else ("cam.rpm",)
    loads = force.missing_force_keys(setup)
    needs = {WEAR_DEPTH: ("wear_rate", "face_width"), FILM_THICKNESS: ("face_width", *LUBRICANT)}
    needs[FILM_RATIO] = (*needs[FILM_THICKNESS], "roughness")
    missing = {}
    for name in applicable_quantities(setup):
        keys = tuple(f"materials.{key}" for key in needs.get(name, ()) if not getattr(bodies, key))
        if name in (FILM_THICKNESS, FILM_RATIO) and not bodies.modulus:
            keys = ("materials.cam", "materials.follower", *keys)
        if absent := (*(loads if name in needs else speed), *keys):
            missing[name] = absent
    return missing


def speed_over_cam_curve_maker(mechanism: Mechanism) -> Any:
    """Curve of the speed of the trace point or the flat face over the cam [mm/rad]."""
    return mechanism.sliding or mechanism.path


def relative_turn_per_velocity(setup: Setup, designs: Designs) -> FloatArray:
    """Factor of y' in q."""
    way = -1.0 if setup.mechanism.reverses else 1.0
    return np.full(len(designs), way * designs.sense if setup.angular else 0.0)


def sliding_speed_curve(setup: Setup, designs: Designs, programme: Programme, side: float = INNER_SIDE) -> Curve:
    """Curve of the sliding speed v on the wall on one side [mm/rad]; for a roller, its speed if it did not turn."""
    sliding = speed_over_cam_curve_maker(setup.mechanism)(designs, programme)
    if setup.mechanism.curvature is None:
        return sliding
    turns = np.full(len(designs), 0.0 if setup.mechanism.body.developed else 1.0)
    return trace_point_sliding_speed(
        sliding, -side * designs.roller_radius, turns, relative_turn_per_velocity(setup, designs)
    )


def spin_acceleration_curve(setup: Setup, designs: Designs, programme: Programme, side: float) -> Curve:
    """Curve of N_p' − R·q' on the wall on one side of the trace point [mm/rad²]."""
    assert setup.mechanism.speeding is not None
    speed = setup.mechanism.speeding(designs, programme)
    return roller_spin_acceleration(
        speed, -side * designs.roller_radius, relative_turn_per_velocity(setup, designs)
    )


def entrainment_speed_mm_per_rad_curve(setup: Setup, designs: Designs, programme: Programme) -> Curve:
    """Curve of the entrainment speed u [mm/rad]."""
    mechanism = setup.mechanism
    sliding, turns = (
        speed_over_cam_curve_maker(mechanism)(designs, programme),
        relative_turn_per_velocity(setup, designs),
    )
    if mechanism.curvature is None:
        assert mechanism.profile_radius is not None
        return flat_face_entrainment_speed(mechanism.profile_radius(designs, programme), sliding, turns)
    slip = np.full(len(designs), 0.0 if setup.rolls else 1.0)
    return trace_point_entrainment_speed(
        sliding, mechanism.curvature(designs, programme), designs.roller_radius, turns, slip
    )


def wear_load_curve(setup: Setup, designs: Designs, programme: Programme, velocity_sign: float = 0.0) -> Curve:
    """Curve of N·|v|/c [N]; a knife edge has v = c."""
    if setup.is_knife:
        return normal_force_curve(setup, designs, programme, velocity_sign)
    load, sliding = contact_load_curve(setup, designs, programme), sliding_speed_curve(setup, designs, programme)
    return flat_face_wear_load(load, sliding, relative_turn_per_velocity(setup, designs))


def inverse_film_curve(setup: Setup, designs: Designs, programme: Programme, velocity_sign: float = 0.0) -> Curve:
    """Curve of ``film_thickness_factor`` over the film."""
    normal = normal_force_curve(setup, designs, programme, velocity_sign)
    entrainment = entrainment_speed_mm_per_rad_curve(setup, designs, programme)
    if setup.mechanism.profile_radius:
        relative_radius = setup.mechanism.profile_radius(designs, programme)
    else:
        curvature = flank_path_curvature_curve(setup, designs, programme, setup.mechanism.flanks[0])
        relative_radius = roller_relative_radius(curvature, designs.roller_radius)
    return inverse_film_thickness(normal, entrainment, relative_radius)


def wear_or_film_curve_variants(name: str, setup: Setup) -> tuple[Variant, ...]:
    """The curves of wear or film, by direction of the guide's friction."""
    return curve_variants_by_friction(wear_load_curve if name == WEAR_DEPTH else inverse_film_curve, setup)


def wear_depth_factor(setup: Setup) -> Number:
    """Depth of wear in a million turns [µm] over N·v/c."""
    return REPORTED_TURNS * 1e3 * setup.bodies.wear_rate / setup.bodies.face_width


def film_thickness_factor(setup: Setup) -> Number:
    """Film [mm] over u^0.7·R^0.43/N^0.13."""
    bodies = setup.bodies
    modulus = 2.0 * bodies.modulus
    speed = (bodies.viscosity * setup.omega / modulus) ** FILM_SPEED_POWER
    load = (modulus * bodies.face_width) ** FILM_LOAD_POWER
    return 2.65 * (bodies.pressure_viscosity * modulus) ** 0.54 * speed * load


def peaks(setup: Setup) -> dict[str, Peak]:
    if not applicable_quantities(setup) or setup.omega is None:
        return {}
    missing = missing_keys_by_quantity(setup)
    return _speed_peaks(setup) | {
        name: Peak(
            wear_or_film_curve_variants(name, setup),
            LARGEST,
            _wear_or_film_scale(name, setup),
            is_infinite_by_velocity_jumps,
            forces=()
            if name == WEAR_DEPTH
            else curve_variants_by_friction(normal_force_curve, setup),  # no film without contact
        )
        for name in applicable_quantities(setup)
        if name in (WEAR_DEPTH, FILM_THICKNESS, FILM_RATIO) and name not in missing
    }


def _speed_peaks(setup: Setup) -> dict[str, Peak]:
    sliding = tuple(
        (partial(sliding_speed_curve, setup, side=flank.side), ALL_STROKES) for flank in setup.mechanism.flanks
    )
    carrying = partial(entrainment_speed_mm_per_rad_curve, setup), ALL_STROKES
    jumps = never_infinite_by_jumps if setup.is_knife else is_infinite_by_velocity_jumps
    scale = speed = multiple_scale(setup, lambda each: each.omega / 1e3)
    if setup.rolls:
        turns = 30.0 / pi * setup.omega
        scale = scale_per_design_if_varied(
            setup, PerRollerRadiusScale(turns), PerRollerRadiusScale(1.0), lambda each: 30.0 / pi * each.omega
        )
    speeds = {
        ROLLER_SPEED if setup.rolls else SLIDING_SPEED: Peak(sliding, LARGEST_MAGNITUDE, scale),
        FASTEST_ENTRAINMENT: Peak((carrying,), LARGEST, speed, jumps),
        SLOWEST_ENTRAINMENT: Peak((carrying,), LEAST, speed, jumps),
    }
    return {name: speeds[name] for name in speeds if name in applicable_quantities(setup)}


def _wear_or_film_scale(name: str, setup: Setup) -> Scale:
    """The scale from the extreme of a curve to wear or film."""
    if name == WEAR_DEPTH:
        return multiple_scale(setup, wear_depth_factor)

    def film_scale_factor(setup: Setup) -> Number:
        unit: Any = 1e3 if name == FILM_THICKNESS else 1.0 / setup.bodies.roughness
        return film_thickness_factor(setup) * unit

    return scale_per_design_if_varied(
        setup, InverseScale(film_scale_factor(setup)), InverseScale(1.0), lambda each: 1.0 / film_scale_factor(each)
    )


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    known, sound = peaks(case.setup), can_bear_load(case)
    columns: dict[str, Any] = {
        name: peak_column(case, known[name]) for name in wanted_quantities & {SLIDING_SPEED, ROLLER_SPEED}
    }
    if wanted_quantities & {FASTEST_ENTRAINMENT, SLOWEST_ENTRAINMENT, FILM_THICKNESS, FILM_RATIO}:
        fastest, slowest = largest_and_least_columns(case, known[FASTEST_ENTRAINMENT], known[SLOWEST_ENTRAINMENT])
        columns |= {FASTEST_ENTRAINMENT: fastest, SLOWEST_ENTRAINMENT: slowest}
    if wanted_quantities & {FILM_THICKNESS, FILM_RATIO}:
        one_way = (slowest.value + slowest.outward > 0.0) | (fastest.value + fastest.outward < 0.0)
        kept, idle = (sound & one_way & each for each in force.contact_kept_and_never_made(case))
        thinnest = peak_extremes(case, known[FILM_THICKNESS], kept)
        thinnest = DesignExtremes(*(np.where(idle, 0.0, each) for each in thinnest))  # no load: an infinite film
        columns |= {
            name: column_from_extremes(case, known[name], thinnest)
            for name in (FILM_THICKNESS, FILM_RATIO)
            if name in known
        }
    if WEAR_DEPTH in wanted_quantities:
        columns[WEAR_DEPTH] = peak_column(case, known[WEAR_DEPTH], sound)
    return columns


EFFECT = Effect(
    "surface",
    applicable_quantities,
    evaluate_columns,
    missing_keys_by_quantity,
    input_quantities_of_loads,
    peaks=peaks,
    is_per_contact=True,
)
