"""Crossings in the clearance of a positive drive, where the follower changes from one flank to the other.

Where the force along the motion changes its sign, the follower flies across the gap and strikes the other flank
(``effects.flight``). The clearance j leaves the gap g = j/(l·cos β) along the motion; at a rib between swinging
rollers it is ½·j/l·(1/cos β₁ + 1/cos β₂). The flight starts with the jerk J of F/m, or with the acceleration A if F
jumps. For small g its time t and its landing speed v are

    t = (6·g/J)^⅓,  v = ½·J·t²        t = √(2·g/A),  v = √(2·A·g)

For an arm the speed of its end is l times v.

A roller in a groove spins at ω·(N_p/R_r − q) on the inner wall, and the other way at ω·(N_p/R_r + q) on the outer
one, with N_p and q of ``effects.surface``; on a cylinder q − 1 takes the place of q. So the roller lands with the
wrong spin. It slips at 2·ω·N_p at first, and skids until the friction μ·N of the wall has changed its spin:

    μ·R_r·∫N dt = J_r·2·ω·N_p/R_r

J_r is the inertia of the roller about its pin, and N the normal force of the prescribed motion. A roller that does
not slip has the angular acceleration ω²·(N_p'/R_r ∓ q').

Assumptions: the impact of the landing and the friction of the guide have no effect. Followers that drive a train
are not computed.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 1 (form-closed cams: crossover shock); the rest follows
from Newton's law.
"""

from functools import partial
from math import inf, pi
from typing import Any

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import BISECTIONS, LARGEST_MAGNITUDE, FloatArray, IntArray
from camopt.core.numerics.curves import curve_value
from camopt.core.numerics.panel_series import integrate_series
from camopt.model.effects import force
from camopt.model.effects.contacts import all_follower_contacts
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup, scale_per_design_if_varied
from camopt.model.effects.flight import (
    Flights,
    Followers,
    HalfGap,
    Landings,
    find_flank_crossings,
    motion_state_on_panels,
    simulate_flights,
)
from camopt.model.effects.peak import Peak, PerRollerRadiusScale, is_infinite_by_velocity_jumps
from camopt.model.effects.peak_columns import peak_column
from camopt.model.effects.preload import INTERFERENCE_KEY
from camopt.model.effects.surface import spin_acceleration_curve
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import ALL_STROKES

CROSSING_COUNT, CROSSING_ANGLE = "crossing_count", "crossing_at_deg"
CROSSING_SPEED, LEADING_SPEED, CROSSING_TIME = (
    "crossing_speed_max_m_s",
    "crossing_speed_leading_m_s",
    "crossing_time_max_ms",
)
SLIP_SPEED, SPIN_CHANGE, SKIDDING_TIME = "slip_speed_max_m_s", "roller_spin_change_max_rpm", "skidding_time_max_ms"
ROLLER_ACCELERATION = "roller_angular_acceleration_max_rad_s2"
FLIGHT_QUANTITIES, ROLLER_QUANTITIES = (
    (CROSSING_SPEED, LEADING_SPEED, CROSSING_TIME, CROSSING_ANGLE),
    (SLIP_SPEED, SPIN_CHANGE, SKIDDING_TIME),
)


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
    mechanism, preloaded = setup.mechanism, bool(setup.given[INTERFERENCE_KEY])
    if "clearance" not in mechanism.drive.keys or setup.train is not None or preloaded:
        return ()
    rolls = setup.rolls and mechanism.has_flanks_on_both_sides
    return (CROSSING_COUNT, *FLIGHT_QUANTITIES, *((*ROLLER_QUANTITIES, ROLLER_ACCELERATION) if rolls else ()))


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    loads, drive = force.missing_force_keys(setup), setup.given.drive
    gap = () if drive.clearance is not None else ("drive.clearance",)
    roller = (("drive.roller_inertia", drive.roller_inertia), ("drive.friction", drive.friction))
    turned = tuple(key for key, value in roller if value is None)
    needs = dict.fromkeys(FLIGHT_QUANTITIES, (*loads, *gap)) | {
        CROSSING_COUNT: loads,
        CROSSING_ANGLE: loads,
        SLIP_SPEED: loads,
        SPIN_CHANGE: loads,
    }
    needs |= {
        SKIDDING_TIME: (*loads, *turned),
        ROLLER_ACCELERATION: () if setup.omega is not None else ("cam.rpm",),
    }
    return {name: needs[name] for name in applicable_quantities(setup) if needs[name]}


def peaks(setup: Setup) -> dict[str, Peak]:
    """Angular acceleration of a roller that does not slip, on either wall."""
    if ROLLER_ACCELERATION not in applicable_quantities(setup) or setup.omega is None:
        return {}
    curves = tuple(
        (partial(spin_acceleration_curve, setup, side=flank.side), ALL_STROKES) for flank in setup.mechanism.flanks
    )
    scale = scale_per_design_if_varied(
        setup, PerRollerRadiusScale(setup.omega**2), PerRollerRadiusScale(1.0), lambda each: each.omega**2
    )
    return {ROLLER_ACCELERATION: Peak(curves, LARGEST_MAGNITUDE, scale, is_infinite_by_velocity_jumps)}


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    known = peaks(case.setup)
    columns: dict[str, Any] = {name: peak_column(case, known[name]) for name in wanted_quantities & known.keys()}
    others = wanted_quantities - known.keys()
    if not others:
        return columns
    count = len(case.designs)
    if not count:
        return columns | dict.fromkeys(others, np.zeros(0))
    if case.programme.corners:
        infinite = np.full(count, inf)
        return columns | {
            name: np.zeros(count) if name in (CROSSING_COUNT, CROSSING_ANGLE) else infinite for name in others
        }
    return columns | {name: column for name, column in crossing_columns(case, others).items() if name in others}


def crossing_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    """The quantities of crossings: for each design the largest over its turn, 0 without crossings."""
    flights, followers = flights_and_followers_by_setting(case)
    setup, design, count = case.setup_per_design, flights.design, len(case.designs)
    omega = np.broadcast_to(setup.omega, count)[design]

    def largest_per_design(values: FloatArray) -> FloatArray:
        maxima = np.zeros(count)
        np.maximum.at(maxima, design, values)
        return maxima

    columns: dict[str, Any] = {}
    # without a clearance each flight lands where it begins
    zeros = np.zeros(design.size)
    ends, speed = Landings(flights.angle, flights.panel, zeros, zeros, zeros == 0.0), -flights.side * flights.slope
    if setup.given.drive.clearance is not None:
        ends, speed = find_landings_and_speeds(case, flights, followers)
        columns |= {
            CROSSING_SPEED: largest_per_design(speed),
            CROSSING_TIME: largest_per_design((speed > 0.0) * ends.length / omega * 1e3),
        }
        if LEADING_SPEED in wanted_quantities:
            columns[LEADING_SPEED] = largest_per_design(
                _small_gap_landing_speeds(case, followers, flights, half_clearance_along_motion(case))
            )
    columns[CROSSING_COUNT] = np.bincount(design, weights=ends.crosses, minlength=count)
    if CROSSING_ANGLE in wanted_quantities:
        columns[CROSSING_ANGLE] = _fastest_crossing_angles_deg(speed, flights, count)
    if case.setup.rolls and case.setup.mechanism.has_flanks_on_both_sides:
        slip = ends.crosses * (2.0 * omega * _landing_speeds_per_radian(case, flights, ends))
        radius = case.designs.roller_radius[design]
        columns |= {
            SLIP_SPEED: largest_per_design(slip / 1e3),
            SPIN_CHANGE: largest_per_design(slip / radius * 30.0 / pi),
        }
        if SKIDDING_TIME in wanted_quantities:
            columns[SKIDDING_TIME] = largest_per_design(
                skidding_times_after_landing(case, followers, flights, ends, slip) * 1e3
            )
    return columns


def find_landings_and_speeds(
    case: EvaluationBlock, flights: Flights, followers: Followers
) -> tuple[Landings, FloatArray]:
    """The landings of flights and their speeds along the motion [m/s].

    A flight that would begin while the follower still flies does not take place; its speed is 0.
    """
    ends = simulate_flights(case.programme, followers, flights, half_clearance_along_motion(case))
    begun = ~np.isin(
        np.arange(flights.design.size),
        _following_crossing_index(flights)[ends.length > _angle_to_next_crossing(flights)],
    )
    omega = followers.omega[flights.setting]
    ends = ends._replace(crosses=ends.crosses & begun)
    return ends, begun * ends.speed * omega * _arm_length_or_one(case)[flights.design] / 1e3


def flights_and_followers_by_setting(case: EvaluationBlock) -> tuple[Flights, Followers]:
    """All flights of a block's designs over a turn, and the followers of each setting."""
    setup, count = case.setup_per_design, len(case.designs)
    factors = np.array(
        np.broadcast_arrays(*force.force_factors_with_train(setup.dynamics, setup.omega), np.zeros(count))[:-1]
    )
    mass = np.broadcast_to(setup.dynamics.mass, count)
    settings, which = np.unique(np.vstack([factors, mass]), axis=1, return_inverse=True)
    rows = settings[:-1]
    crossings = [find_flank_crossings(case.programme, tuple(rows[:, k].tolist())) for k in range(rows.shape[1])]
    numbers = np.array([part.angle.size for part in crossings], dtype=int)[which.reshape(-1)]
    design = np.repeat(np.arange(count), numbers)
    parts = [crossings[k] for k in which.reshape(-1)]
    flights = Flights(design, which.reshape(-1)[design], *map(np.concatenate, zip(*parts, strict=True)))
    speed = np.sqrt(rows[4])
    series = force.force_polynomials_by_panel(case.programme, [*rows])
    return flights, Followers(settings[-1], rows[1] / speed, rows[0], speed, series)


def half_clearance_along_motion(case: EvaluationBlock) -> HalfGap:
    """Half the clearance along the motion, of a block's designs."""
    clearance = np.broadcast_to(case.setup_per_design.given.drive.clearance, len(case.designs))
    pressures = tuple(
        contact.mechanism.pressure(contact.local_designs(case.designs), case.programme)
        for contact in all_follower_contacts(case.setup)
    )
    return HalfGap(pressures, 0.5 * clearance / _arm_length_or_one(case), case.programme)


def _arm_length_or_one(case: EvaluationBlock) -> FloatArray:
    """Length of the arm [mm] if the follower oscillates, else 1."""
    return case.designs.arm_length if case.setup.angular else np.ones(len(case.designs))


def _small_gap_landing_speeds(
    case: EvaluationBlock, followers: Followers, flights: Flights, gap: HalfGap
) -> FloatArray:
    """Landing speeds by the formulas for small gaps [m/s]."""
    table = case.programme.table
    place = (flights.angle - table.centre[flights.panel]) / table.half_width[flights.panel]
    way = sum(
        gap.value_and_slope(flights.design, flights.panel, place, side)[0] for side in (flights.side, -flights.side)
    )
    mass, omega = (each[flights.setting] for each in (followers.mass, followers.omega))
    jerk = np.maximum(-flights.side * flights.slope, 0.0) * omega / mass
    stepped = np.sqrt(2.0 * np.abs(flights.jump) / mass * way)
    speed = np.where(flights.jump != 0.0, stepped, 0.5 * np.cbrt(36.0 * jerk * np.square(way)))
    return np.asarray(speed * _arm_length_or_one(case)[flights.design] / 1e3)


def _fastest_crossing_angles_deg(landing_speeds: FloatArray, flights: Flights, design_count: int) -> FloatArray:
    """Cam angle of the fastest crossing of each design [deg]; 0 without a crossing."""
    angles = np.zeros(design_count)
    order = np.argsort(landing_speeds, kind="stable")
    angles[flights.design[order]] = np.degrees(flights.angle[order])
    return angles


def _landing_speeds_per_radian(case: EvaluationBlock, flights: Flights, landings: Landings) -> FloatArray:
    """Speed of the trace point N_p at the landings [mm/rad]."""
    make = case.setup.mechanism.trace_speed_curve_maker
    assert make is not None
    table, panel, angle = case.programme.table, landings.panel, landings.angle
    place = np.clip((angle - table.centre[panel]) / table.half_width[panel], -1.0, 1.0)
    return np.asarray(
        curve_value(
            make(case.designs, case.programme), flights.design, motion_state_on_panels(case.programme, panel, place)
        )
    )


def skidding_times_after_landing(
    case: EvaluationBlock,
    followers: Followers,
    flights: Flights,
    landings: Landings,
    slip_speed_mm_s: FloatArray,
) -> FloatArray:
    """Time in which friction turns the roller after a landing [s]; infinite if not before the next crossing."""
    drive, designs, table = case.setup_per_design.given.drive, case.designs, case.programme.table
    count, design = len(designs), flights.design
    inertia, friction = (np.broadcast_to(each, count)[design] for each in (drive.roller_inertia, drive.friction))
    radius, omega = designs.roller_radius[design], followers.omega[flights.setting]
    panel, angle = landings.panel, landings.angle
    place = (angle - table.centre[panel]) / table.half_width[panel]
    tangent = curve_value(
        case.setup.mechanism.pressure(designs, case.programme),
        design,
        motion_state_on_panels(case.programme, panel, place),
    )
    turned = inertia * slip_speed_mm_s / np.square(radius) / friction  # ∫N dt
    needed = turned * omega / np.sqrt(1.0 + np.square(tangent)) * _arm_length_or_one(case)[design]  # ∫|F| dθ
    return _skidding_angle(case.programme, followers, flights, (angle, needed)) / omega


def _skidding_angle(
    programme: Programme,
    followers: Followers,
    flights: Flights,
    start_and_needed_impulse: tuple[FloatArray, FloatArray],
) -> FloatArray:
    """Cam angle from a start over which the force on the other flank gives an impulse [rad].

    The impulse is ∫|F| dθ [N·rad or N·mm·rad].
    """
    table, (start, needed) = programme.table, start_and_needed_impulse
    impulse = integrate_series(table.half_width, followers.force)
    whole = np.asarray(polynomial.polyval(1.0, impulse))[:, -1]

    def impulse_since_start(angle: FloatArray) -> FloatArray:
        """∫F dθ from the start of the turn to cam angles, which may be beyond its end."""
        turns, here = np.divmod(angle, 2.0 * pi)
        panel = np.maximum(np.searchsorted(table.centre - table.half_width, here, side="right") - 1, 0)
        u = (here - table.centre[panel]) / table.half_width[panel]
        rows = impulse[:, flights.setting, panel]
        return np.asarray(polynomial.polyval(u, rows, tensor=False) + turns * whole[flights.setting])

    begun = impulse_since_start(start)
    low, high = start.copy(), start + np.mod(flights.angle + _angle_to_next_crossing(flights) - start, 2.0 * pi)

    def is_spun_up(angle: FloatArray) -> Any:
        return -flights.side * (impulse_since_start(angle) - begun) >= needed

    late = ~is_spun_up(high)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        enough = is_spun_up(middle)
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    return np.where(late, inf, high - start)


def _following_crossing_index(flights: Flights) -> IntArray:
    """Index of the crossing after each one; after the last of a turn comes the first."""
    following = np.arange(1, flights.design.size + 1)
    last = np.flatnonzero(np.diff(flights.design, append=-1))
    following[last] = np.flatnonzero(np.diff(flights.design, prepend=-1))
    return following


def _angle_to_next_crossing(flights: Flights) -> FloatArray:
    """Cam angle from each crossing to the next [rad]."""
    return np.asarray(np.mod(flights.angle[_following_crossing_index(flights)] - flights.angle, 2.0 * pi))


EFFECT = Effect(
    "clearance", applicable_quantities, evaluate_columns, missing_keys_by_quantity, peaks=peaks, work=400.0
)
