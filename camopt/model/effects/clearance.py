"""Clearance of a positive drive: what happens where the follower crosses from one flank to the other.

Where the force along the motion changes its sign, the follower flies over the gap that the clearance j leaves along
the motion, g = j/(l·cos β), of a rib between swinging rollers ½·j/l·(1/cos β₁ + 1/cos β₂) (``effects.flight``), and
strikes the other flank. With the jerk J of F/m there, or the acceleration A to which it jumps, and small g,

    t = (6·g/J)^⅓,  v = ½·J·t²        t = √(2·g/A),  v = √(2·A·g)

times l for the speed of an arm's end. A roller in a groove spins at ω·(N_p/R_r − q) on the inner wall, and the
other way at ω·(N_p/R_r + q) on the outer one, with N_p and q of ``effects.surface`` (over a cylinder, which does
not turn below it, q − 1 in place of q). So it comes with the wrong spin: it slips at first at 2·ω·N_p, and skids
until the friction μ·N of the wall has turned it,

    μ·R_r·∫N dt = J_r·2·ω·N_p/R_r

with its inertia J_r about its pin, N the normal force of the motion as prescribed. On a wall it does not slip, and
is turned with the angular acceleration ω²·(N_p'/R_r ∓ q'). Neither the blow of the landing nor the friction of the
guide counts, and no follower with a train beyond it is asked.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 1 (form-closed cams: crossover shock); the rest follows
from Newton's law.
"""

from functools import partial
from math import inf, pi
from typing import Any

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import BISECTIONS, LARGEST_MAGNITUDE, FloatArray, IntArray
from camopt.core.numerics.curves import value_of
from camopt.model.effects import force
from camopt.model.effects.contacts import follower_contacts
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup, scale_by_setting
from camopt.model.effects.flight import (
    FlankCrossings,
    Flights,
    Followers,
    HalfGap,
    Landings,
    find_flank_crossings,
    panel_state,
    simulate_flights,
)
from camopt.model.effects.panel_series import integrate_series
from camopt.model.effects.peak import Peak, PerRollerRadius, jumps_at_corners
from camopt.model.effects.peak_columns import peak_column
from camopt.model.effects.preload import INTERFERENCE
from camopt.model.effects.surface import spin_rate_curve
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


def offers(setup: Setup) -> tuple[str, ...]:
    mechanism, preloaded = setup.mechanism, bool(setup.given[INTERFERENCE])
    if "clearance" not in mechanism.drive.keys or setup.train is not None or preloaded:
        return ()
    rolls = setup.rolls and mechanism.two_sided
    return (CROSSING_COUNT, *FLIGHT_QUANTITIES, *((*ROLLER_QUANTITIES, ROLLER_ACCELERATION) if rolls else ()))


def lacks(setup: Setup) -> dict[str, tuple[str, ...]]:
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
    return {name: needs[name] for name in offers(setup) if needs[name]}


def peaks(setup: Setup) -> dict[str, Peak]:
    """The angular acceleration of a roller that does not slip, on either wall."""
    if ROLLER_ACCELERATION not in offers(setup) or setup.omega is None:
        return {}
    curves = tuple(
        (partial(spin_rate_curve, setup, side=flank.side), ALL_STROKES) for flank in setup.mechanism.flanks
    )
    scale = scale_by_setting(
        setup, PerRollerRadius(setup.omega**2), PerRollerRadius(1.0), lambda each: each.omega**2
    )
    return {ROLLER_ACCELERATION: Peak(curves, LARGEST_MAGNITUDE, scale, jumps_at_corners)}


def run(case: EvaluationBlock, wanted: frozenset[str]) -> dict[str, Any]:
    known = peaks(case.setup)
    columns: dict[str, Any] = {name: peak_column(case, known[name]) for name in wanted & known.keys()}
    left = wanted - known.keys()
    if not left:
        return columns
    count = len(case.designs)
    if not count:
        return columns | dict.fromkeys(left, np.zeros(0))
    if case.programme.corners:
        infinite = np.full(count, inf)
        return columns | {
            name: np.zeros(count) if name in (CROSSING_COUNT, CROSSING_ANGLE) else infinite for name in left
        }
    return columns | {name: column for name, column in crossing_columns(case, left).items() if name in left}


def crossing_columns(case: EvaluationBlock, wanted: frozenset[str]) -> dict[str, Any]:
    """The quantities of the crossings of all designs: the largest of each over their turns, 0 without crossings."""
    flights, followers = design_flights(case)
    own, design, count = case.setup_per_design, flights.design, len(case.designs)
    omega = np.broadcast_to(own.omega, count)[design]

    def largest(values: FloatArray) -> FloatArray:
        found = np.zeros(count)
        np.maximum.at(found, design, values)
        return found

    columns: dict[str, Any] = {}
    ends, speed, crosses = None, -flights.side * flights.slope, np.ones(design.size, dtype=bool)
    if own.given.drive.clearance is not None:
        ends, speed = land_flights(case, flights, followers)
        crosses = ends.crosses
        columns |= {
            CROSSING_SPEED: largest(speed),
            CROSSING_TIME: largest((speed > 0.0) * ends.length / omega * 1e3),
        }
        if LEADING_SPEED in wanted:
            columns[LEADING_SPEED] = largest(_leading_speeds(case, followers, flights, half_gap(case)))
    columns[CROSSING_COUNT] = np.bincount(design, weights=crosses, minlength=count)
    if CROSSING_ANGLE in wanted:
        columns[CROSSING_ANGLE] = _fastest_crossing_angle(speed, flights, count)
    if case.setup.rolls and case.setup.mechanism.two_sided:
        slip = crosses * (2.0 * omega * _trace_speeds(case, flights, ends))
        radius = case.designs.roller_radius[design]
        columns |= {SLIP_SPEED: largest(slip / 1e3), SPIN_CHANGE: largest(slip / radius * 30.0 / pi)}
        if SKIDDING_TIME in wanted:
            columns[SKIDDING_TIME] = largest(skidding_times(case, followers, flights, ends, slip) * 1e3)
    return columns


def land_flights(case: EvaluationBlock, flights: Flights, followers: Followers) -> tuple[Landings, FloatArray]:
    """Where flights end, and the speeds at which they do along the motion, m/s; 0 of those that never begin."""
    ends = simulate_flights(case.programme, followers, flights, half_gap(case))
    count = flights.design.size
    begun = ~np.isin(np.arange(count), _following_crossing_index(flights)[ends.length > _angle_to_next(flights)])
    omega = followers.omega[flights.setting]
    ends = ends._replace(crosses=ends.crosses & begun)
    return ends, begun * ends.speed * omega * _motion_lever(case)[flights.design] / 1e3


def design_flights(case: EvaluationBlock) -> tuple[Flights, Followers]:
    """All flights of the designs of a case over a turn, and the followers that fly, by setting."""
    own, count = case.setup_per_design, len(case.designs)
    factors = np.array(np.broadcast_arrays(*force.force_factors(own.dynamics, own.omega), np.zeros(count))[:-1])
    mass = np.broadcast_to(own.dynamics.mass, count)
    settings, which = np.unique(np.vstack([factors, mass]), axis=1, return_inverse=True)
    rows = settings[:-1]
    found = [find_flank_crossings(case.programme, tuple(rows[:, k].tolist())) for k in range(rows.shape[1])]
    numbers = np.array([each.angle.size for each in found], dtype=int)[which.reshape(-1)]
    design = np.repeat(np.arange(count), numbers)
    parts = [found[k] for k in which.reshape(-1)]
    each = FlankCrossings(
        *(np.concatenate([getattr(part, name) for part in parts]) for name in FlankCrossings._fields)
    )
    flights = Flights(design, which.reshape(-1)[design], each.angle, each.panel, each.side, each.slope, each.jump)
    speed = np.sqrt(rows[4])
    series = force.force_series(case.programme, [*rows])
    return flights, Followers(settings[-1], rows[1] / speed, rows[0], speed, series)


def half_gap(case: EvaluationBlock) -> HalfGap:
    """Half the clearance along the motion, of the designs of a case."""
    clearance = np.broadcast_to(case.setup_per_design.given.drive.clearance, len(case.designs))
    pressures = tuple(
        contact.mechanism.pressure(contact.local_designs(case.designs), case.programme)
        for contact in follower_contacts(case.setup)
    )
    return HalfGap(pressures, 0.5 * clearance / _motion_lever(case), case.programme)


def _motion_lever(case: EvaluationBlock) -> FloatArray:
    """The length of the arm that a motion turns, or 1."""
    return case.designs.arm_length if case.setup.angular else np.ones(len(case.designs))


def _leading_speeds(case: EvaluationBlock, followers: Followers, flights: Flights, gap: HalfGap) -> FloatArray:
    """The speeds of landing of small gaps, m/s."""
    table = case.programme.table
    place = (flights.angle - table.centre[flights.panel]) / table.half_width[flights.panel]
    way = sum(
        gap.value_and_slope(flights.design, flights.panel, place, side)[0] for side in (flights.side, -flights.side)
    )
    mass, omega = (each[flights.setting] for each in (followers.mass, followers.omega))
    jerk = np.maximum(-flights.side * flights.slope, 0.0) * omega / mass
    stepped = np.sqrt(2.0 * np.abs(flights.jump) / mass * way)
    speed = np.where(flights.jump != 0.0, stepped, 0.5 * np.cbrt(36.0 * jerk * np.square(way)))
    return np.asarray(speed * _motion_lever(case)[flights.design] / 1e3)


def _fastest_crossing_angle(speed: FloatArray, flights: Flights, count: int) -> FloatArray:
    """The cam angle, deg, of the fastest crossing of each design; 0 without one."""
    found = np.zeros(count)
    order = np.argsort(speed, kind="stable")
    found[flights.design[order]] = np.degrees(flights.angle[order])
    return found


def _trace_speeds(case: EvaluationBlock, flights: Flights, ends: Landings | None) -> FloatArray:
    """N_p where flights end, or where they begin if there is no clearance, mm/rad."""
    made = case.setup.mechanism.trace_speed
    assert made is not None
    table = case.programme.table
    panel, angle = (flights.panel, flights.angle) if ends is None else (ends.panel, ends.angle)
    place = np.clip((angle - table.centre[panel]) / table.half_width[panel], -1.0, 1.0)
    return np.asarray(
        value_of(made(case.designs, case.programme), flights.design, panel_state(case.programme, panel, place))
    )


def skidding_times(
    case: EvaluationBlock, followers: Followers, flights: Flights, ends: Landings | None, slip: FloatArray
) -> FloatArray:
    """How long friction takes to turn the roller after a landing, s; infinite if not before the next crossing."""
    drive, designs, table = case.setup_per_design.given.drive, case.designs, case.programme.table
    count, design = len(designs), flights.design
    inertia, friction = (np.broadcast_to(each, count)[design] for each in (drive.roller_inertia, drive.friction))
    radius, omega = designs.roller_radius[design], followers.omega[flights.setting]
    panel, angle = (flights.panel, flights.angle) if ends is None else (ends.panel, ends.angle)
    place = (angle - table.centre[panel]) / table.half_width[panel]
    tangent = value_of(
        case.setup.mechanism.pressure(designs, case.programme), design, panel_state(case.programme, panel, place)
    )
    turned = inertia * slip / np.square(radius) / friction  # ∫N dt
    needed = turned * omega / np.sqrt(1.0 + np.square(tangent)) * _motion_lever(case)[design]  # ∫|F| dθ
    return _skidding_angle(case.programme, followers, flights, (angle, needed)) / omega


def _skidding_angle(
    programme: Programme, followers: Followers, flights: Flights, asked: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """The cam angle over which the force on the other flank gives ∫|F| dθ, N·rad (N·mm·rad), from an angle on."""
    table, (start, needed) = programme.table, asked
    impulse = integrate_series(table.half_width, followers.force)
    whole = np.asarray(polynomial.polyval(1.0, impulse))[:, -1]

    def impulse_since_start(angle: FloatArray) -> FloatArray:
        """∫F from the start of the turn to cam angles, which may be beyond its end."""
        turns, here = np.divmod(angle, 2.0 * pi)
        panel = np.maximum(np.searchsorted(table.centre - table.half_width, here, side="right") - 1, 0)
        u = (here - table.centre[panel]) / table.half_width[panel]
        rows = impulse[:, flights.setting, panel]
        return np.asarray(polynomial.polyval(u, rows, tensor=False) + turns * whole[flights.setting])

    begun = impulse_since_start(start)
    low, high = start.copy(), start + np.mod(flights.angle + _angle_to_next(flights) - start, 2.0 * pi)

    def is_spun_up(angle: FloatArray) -> Any:
        return -flights.side * (impulse_since_start(angle) - begun) >= needed

    late = ~is_spun_up(high)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        enough = is_spun_up(middle)
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    return np.where(late, inf, high - start)


def _following_crossing_index(flights: Flights) -> IntArray:
    """The number of the crossing after each one; that after the last of a turn is its first."""
    found = np.arange(1, flights.design.size + 1)
    last = np.flatnonzero(np.diff(flights.design, append=-1))
    found[last] = np.flatnonzero(np.diff(flights.design, prepend=-1))
    return found


def _angle_to_next(flights: Flights) -> FloatArray:
    """The cam angle from each crossing to the next, rad."""
    return np.asarray(np.mod(flights.angle[_following_crossing_index(flights)] - flights.angle, 2.0 * pi))


EFFECT = Effect("clearance", offers, run, lacks, peaks=peaks)
