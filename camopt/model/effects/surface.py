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

from collections.abc import Mapping
from functools import partial
from math import pi
from typing import Any

import numpy as np

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, FloatArray
from camopt.core.numerics.curves import curve_type
from camopt.core.numerics.jet import to_power
from camopt.model.effects import force
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup, scale_by_setting
from camopt.model.effects.loads import (
    contact_load,
    flank_path_curvature,
    friction_ways,
    has_guide_friction,
    is_sound,
    normal_curve,
)
from camopt.model.effects.peak import (
    IDENTITY_SCALE,
    InverseScale,
    Multiple,
    Peak,
    PerRollerRadius,
    Scale,
    Variant,
    jumps_at_corners,
    never_jumps,
)
from camopt.model.effects.peak_columns import as_column, peak_column, peak_extremes, range_columns
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


@curve_type
def trace_sliding(at, speed, radius, turns, turning):
    """Sliding speed of a trace point, N_p − q·R [mm/rad], with q = turns + turning·y'."""
    return speed - radius * (turns + turning * at.y1)


@curve_type
def spin_rate(at, speed, radius, turning):
    """Change of the spin's speed, N_p' − R·q' [mm/rad²], with q = 1 + turning·y'; ``speed`` is N_p'."""
    return speed - radius * turning * at.y2


@curve_type
def trace_entrainment(at, speed, curvature, radius, turning, slip):
    """Entrainment speed, N_p·(1 − κ·R) − slip·(N_p − q·R)/2 [mm/rad]; ``slip`` is 0 for a roller, else 1."""
    half = 0.5 * slip
    return speed * ((1.0 - half) - radius * curvature) + half * radius * (1.0 + turning * at.y1)


@curve_type
def face_entrainment(at, radius, sliding, turning):
    """Entrainment speed of a flat face, q·ρ − v/2 [mm/rad]."""
    return (1.0 + turning * at.y1) * radius - 0.5 * sliding


@curve_type(loaded=True)
def face_wear(at, load, sliding, turning):
    """Wear load of a flat face, N·|v|/(q·ρ) [N]; ``load`` is N/ρ."""
    return load * np.abs(sliding) / (1.0 + turning * at.y1)


@curve_type
def relative_radius(at, curvature, roller_radius):
    """Relative radius, R = R_r·(1 − κ·R_r) [mm]."""
    return roller_radius - roller_radius * roller_radius * curvature


@curve_type(loaded=True)
def film_thinness(at, normal, entrainment, radius):
    """Inverse of the film up to a factor, N^0.13·u^−0.7·R^−0.43, from N, mm/rad and mm."""
    spread = to_power(np.square(entrainment), -0.5 * FILM_SPEED_POWER) * to_power(radius, -FILM_RADIUS_POWER)
    return to_power(normal, FILM_LOAD_POWER) * spread


def offers(setup: Setup) -> tuple[str, ...]:
    if speed_over_cam(setup.mechanism) is None:
        return ()
    if setup.mechanism.two_sided:
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


def lacks(setup: Setup) -> dict[str, tuple[str, ...]]:
    bodies, speed = setup.bodies, () if setup.omega is not None else ("cam.rpm",)
    loads = force.missing_force_keys(setup)
    needs = {WEAR_DEPTH: ("wear_rate", "face_width"), FILM_THICKNESS: ("face_width", *LUBRICANT)}
    needs[FILM_RATIO] = (*needs[FILM_THICKNESS], "roughness")
    missing = {}
    for name in offers(setup):
        keys = tuple(f"materials.{key}" for key in needs.get(name, ()) if not getattr(bodies, key))
        if name in (FILM_THICKNESS, FILM_RATIO) and not bodies.modulus:
            keys = ("materials.cam", "materials.follower", *keys)
        if absent := (*(loads if name in needs else speed), *keys):
            missing[name] = absent
    return missing


def reads(setup: Setup) -> tuple[str, ...]:
    return (*(() if setup.is_knife else ("undercut",)), *(("jamming_margin",) if has_guide_friction(setup) else ()))


def speed_over_cam(mechanism: Mechanism) -> Any:
    """Curve of the speed of the trace point or the flat face over the cam [mm/rad]."""
    return mechanism.sliding or mechanism.path


def turning_factor(setup: Setup, designs: Designs) -> FloatArray:
    """Factor of y' in q."""
    way = -1.0 if setup.mechanism.reverses else 1.0
    return np.full(len(designs), way * designs.sense if setup.angular else 0.0)


def sliding_curve(setup: Setup, designs: Designs, programme: Programme, side: float = INNER_SIDE) -> Any:
    """Curve of the sliding speed v on the wall on one side [mm/rad]; for a roller, its speed if it did not turn."""
    sliding = speed_over_cam(setup.mechanism)(designs, programme)
    if setup.mechanism.curvature is None:
        return sliding
    turns = np.full(len(designs), 0.0 if setup.mechanism.body.developed else 1.0)
    return trace_sliding(sliding, -side * designs.roller_radius, turns, turning_factor(setup, designs))


def spin_rate_curve(setup: Setup, designs: Designs, programme: Programme, side: float) -> Any:
    """Curve of N_p' − R·q' on the wall on one side of the trace point [mm/rad²]."""
    assert setup.mechanism.speeding is not None
    speed = setup.mechanism.speeding(designs, programme)
    return spin_rate(speed, -side * designs.roller_radius, turning_factor(setup, designs))


def entrainment_curve(setup: Setup, designs: Designs, programme: Programme) -> Any:
    """Curve of the entrainment speed u [mm/rad]."""
    mechanism = setup.mechanism
    sliding, turns = speed_over_cam(mechanism)(designs, programme), turning_factor(setup, designs)
    if mechanism.curvature is None:
        assert mechanism.profile_radius is not None
        return face_entrainment(mechanism.profile_radius(designs, programme), sliding, turns)
    slip = np.full(len(designs), 0.0 if setup.rolls else 1.0)
    return trace_entrainment(sliding, mechanism.curvature(designs, programme), designs.roller_radius, turns, slip)


def wear_curve(setup: Setup, designs: Designs, programme: Programme, way: float = 0.0) -> Any:
    """Curve of N·|v|/c [N]; a knife edge has v = c."""
    if setup.is_knife:
        return normal_curve(setup, designs, programme, way)
    load, sliding = contact_load(setup, designs, programme), sliding_curve(setup, designs, programme)
    return face_wear(load, sliding, turning_factor(setup, designs))


def thinness_curve(setup: Setup, designs: Designs, programme: Programme, way: float = 0.0) -> Any:
    """Curve of ``film_factor`` over the film."""
    mechanism = setup.mechanism
    normal = normal_curve(setup, designs, programme, way)
    entrainment = entrainment_curve(setup, designs, programme)
    if mechanism.curvature:
        curvature = flank_path_curvature(setup, designs, programme, mechanism.flanks[0])
        return film_thinness(normal, entrainment, relative_radius(curvature, designs.roller_radius))
    assert mechanism.profile_radius is not None
    return film_thinness(normal, entrainment, mechanism.profile_radius(designs, programme))


def wear_variants(name: str, setup: Setup) -> tuple[Variant, ...]:
    """The curves of wear or film, by direction of the guide's friction."""
    make = wear_curve if name == WEAR_DEPTH else thinness_curve
    return tuple((partial(make, setup, way=way), kinds) for way, kinds in friction_ways(setup))


def wear_factor(setup: Setup) -> Any:
    """Depth of wear in a million turns [µm] over N·v/c."""
    bodies = setup.bodies
    assert bodies.wear_rate is not None
    assert bodies.face_width is not None
    return REPORTED_TURNS * 1e3 * bodies.wear_rate / bodies.face_width


def film_factor(setup: Setup) -> Any:
    """Film [mm] over u^0.7·R^0.43/N^0.13."""
    bodies, omega = setup.bodies, setup.omega
    assert bodies.modulus is not None
    assert bodies.viscosity is not None
    assert bodies.pressure_viscosity is not None
    assert bodies.face_width is not None
    assert omega is not None
    modulus = 2.0 * bodies.modulus
    speed = (bodies.viscosity * omega / modulus) ** FILM_SPEED_POWER
    load = (modulus * bodies.face_width) ** FILM_LOAD_POWER
    return 2.65 * (bodies.pressure_viscosity * modulus) ** 0.54 * speed * load


def peaks(setup: Setup) -> dict[str, Peak]:
    if not offers(setup) or setup.omega is None:
        return {}
    return _speed_peaks(setup) | _load_peaks(setup)


def _speed_peaks(setup: Setup) -> dict[str, Peak]:
    sliding = tuple(
        (partial(sliding_curve, setup, side=flank.side), ALL_STROKES) for flank in setup.mechanism.flanks
    )
    carrying = partial(entrainment_curve, setup), ALL_STROKES
    jumps = never_jumps if setup.is_knife else jumps_at_corners
    speed = scale_by_setting(setup, Multiple(setup.omega / 1e3), IDENTITY_SCALE, lambda each: each.omega / 1e3)
    scale = speed
    if setup.rolls:
        turns = 30.0 / pi * setup.omega
        scale = scale_by_setting(
            setup, PerRollerRadius(turns), PerRollerRadius(1.0), lambda each: 30.0 / pi * each.omega
        )
    speeds = {
        ROLLER_SPEED if setup.rolls else SLIDING_SPEED: Peak(sliding, LARGEST_MAGNITUDE, scale),
        FASTEST_ENTRAINMENT: Peak((carrying,), LARGEST, speed, jumps),
        SLOWEST_ENTRAINMENT: Peak((carrying,), LEAST, speed, jumps),
    }
    return {name: speeds[name] for name in speeds if name in offers(setup)}


def _load_peaks(setup: Setup) -> dict[str, Peak]:
    """Wear and film, if the scene gives the values that they need."""
    missing = lacks(setup)
    return {
        name: Peak(wear_variants(name, setup), LARGEST, _wear_scale(name, setup), jumps_at_corners)
        for name in offers(setup)
        if name in (WEAR_DEPTH, FILM_THICKNESS, FILM_RATIO) and name not in missing
    }


def _wear_scale(name: str, setup: Setup) -> Scale:
    """The scale from the extreme of a curve to wear or film."""
    if name == WEAR_DEPTH:
        return scale_by_setting(setup, Multiple(wear_factor(setup)), IDENTITY_SCALE, wear_factor)

    def film(setup: Setup) -> Any:
        unit: Any = 1e3 if name == FILM_THICKNESS else 1.0 / setup.bodies.roughness
        return film_factor(setup) * unit

    return scale_by_setting(setup, InverseScale(film(setup)), InverseScale(1.0), lambda each: 1.0 / film(each))


def run(case: EvaluationBlock, wanted: frozenset[str]) -> dict[str, Any]:
    known, sound = peaks(case.setup), is_sound(case)
    columns: dict[str, Any] = {
        name: peak_column(case, known[name]) for name in wanted & {SLIDING_SPEED, ROLLER_SPEED}
    }
    if wanted & {FASTEST_ENTRAINMENT, SLOWEST_ENTRAINMENT, FILM_THICKNESS, FILM_RATIO}:
        ends = range_columns(case, known[FASTEST_ENTRAINMENT], known[SLOWEST_ENTRAINMENT])
        columns |= zip((FASTEST_ENTRAINMENT, SLOWEST_ENTRAINMENT), ends, strict=True)
    if wanted & {FILM_THICKNESS, FILM_RATIO}:
        columns |= _film_columns(case, known, sound & _carries_film(*ends))
    if WEAR_DEPTH in wanted:
        columns[WEAR_DEPTH] = peak_column(case, known[WEAR_DEPTH], sound)
    return columns


def _carries_film(fastest: EnclosedValue, slowest: EnclosedValue) -> Any:
    """Mask of designs whose surfaces carry the lubricant in one direction over the whole turn."""
    return (slowest.value + slowest.outward > 0.0) | (fastest.value + fastest.outward < 0.0)


def _film_columns(case: EvaluationBlock, known: Mapping[str, Peak], carried: Any) -> dict[str, Any]:
    """Columns of the least film; 0 for designs whose bodies lose contact."""
    pressed = force.keeps_contact(case)
    thinnest = peak_extremes(case, known[FILM_THICKNESS], carried & pressed)
    return {name: as_column(case, known[name], thinnest) for name in (FILM_THICKNESS, FILM_RATIO) if name in known}


EFFECT = Effect("surface", offers, run, lacks, reads, peaks=peaks, is_per_contact=True)
