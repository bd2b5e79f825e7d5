"""The torque of the camshaft, and the requirements on drive and flywheel that follow from it.

    T = F·y',    F = m·ω²·y'' + c·ω·y' + k·y + F₀ + F_ext            (oscillating: M·ψ' with moments)

It depends only on the motion and the speed, and is a polynomial on each panel: extremes and integrals are exact.
Over a turn, springs, masses and constant loads give back their work. Damping and a load F_ext that changes over the
turn (``motion.load``) do not, so ∮T dθ = ∮(c·ω·y' + F_ext)·y' dθ. Up to a constant, the work beyond the mean is

    W(θ) = ∫(T − T_mean)dθ = m·ω²·y'²/2 + k·y²/2 + F₀·y + ∫(c·ω·y' + F_ext)·y' dθ − T_mean·θ

The fluctuation of energy is ΔE = max W − min W, and the flywheel's inertia I = ΔE/(C_f·ω²).

With friction in the guide the torque is T = G·y', with the force G along the motion (``effects.loads``); its work
over a turn includes that of the friction. It then depends on the design. Its extremes and means are computed as
those of other curves (``effects.peak``, ``effects.mean``), and its fluctuation from polynomials on parts of panels
(``effects.guided_torque``). It is infinite if the follower jams or the motion has a corner.

At a corner of the motion y' jumps, and T is infinite: positive where |y'| grows, negative where it falls; W is
finite. With masses of a train, quantities that depend on energy are infinite too.

Source: Norton, Design of Machinery, ch. 15 (camshaft torque) and 11 (flywheel).
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import inf, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, Curve, FloatArray
from camopt.core.numerics.curves import Linear
from camopt.core.numerics.panel_series import (
    WORK_ERROR,
    derivative_polynomials_by_panel,
    integrate_series,
    largest_value_of_series,
    multiply_series,
    sum_series,
    turn_integral,
)
from camopt.core.numerics.piecewise import external_load_polynomials_by_panel, train_inertia_polynomials_by_panel
from camopt.model.effects import force
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup, multiple_scale
from camopt.model.effects.effect_numbers import FollowerDynamics
from camopt.model.effects.force import add_changing_load_and_train_inertia
from camopt.model.effects.guided_torque import guided_torque_polynomials, panel_parts_with_smooth_torque
from camopt.model.effects.loads import (
    curve_variants_by_friction,
    has_guide_friction,
    jamming_ratio_curve,
    jamming_stroke_kinds,
    shaft_torque,
    torque_curve,
)
from camopt.model.effects.mean import Mean
from camopt.model.effects.mean_columns import mean_column
from camopt.model.effects.peak import MultipleScale, Peak, Scale, is_infinite_by_velocity_jumps
from camopt.model.effects.peak_columns import peak_extremes
from camopt.model.effects.setting_cache import once_per_setting
from camopt.model.mechanisms.design import Designs
from camopt.model.motion.load import TrainLoad
from camopt.model.motion.programme import LEAST_JUMP, Programme
from camopt.model.motion.stroke import ALL_STROKES, INWARD, OUTWARD

TORQUE_NAMES = (
    "torque_max_N_m",
    "torque_min_N_m",
    "torque_peak_N_m",
    "torque_mean_N_m",
    "torque_rms_N_m",
    "power_peak_W",
    "power_mean_W",
    "energy_fluctuation_J",
)
EXTREME_QUANTITIES = frozenset(("torque_max_N_m", "torque_min_N_m", "torque_peak_N_m", "power_peak_W"))
FLYWHEEL = "flywheel_inertia_kg_m2"
FLUCTUATION_QUANTITIES = frozenset(("energy_fluctuation_J", FLYWHEEL))


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    keys = force.missing_force_keys(setup)
    wheel = () if setup.dynamics.fluctuation is not None else ("follower.dynamics.fluctuation",)
    wanted = {**dict.fromkeys(TORQUE_NAMES, keys), FLYWHEEL: (*keys, *wheel)}
    return {name: lacking for name, lacking in wanted.items() if lacking}


class TorqueOverTurn(NamedTuple):
    """Extremes, fluctuation of energy and means of the torque [N·mm]; arrays if they depend on the design."""

    largest: Any
    least: Any
    fluctuation: Any
    room: Any
    """By how much the true largest magnitude may exceed the computed one."""
    mean: Any = None
    """None, as ``rms``, where the means are those of curves (``means``)."""
    rms: Any = None


def torque_polynomials_by_panel(programme: Programme, factors: Sequence[Any]) -> FloatArray:
    """T on the panels [N·mm], from ``force.force_factors_with_train``, without impulses at corners."""
    return multiply_series(
        force.force_polynomials_by_panel(programme, factors), _velocity_polynomials_by_panel(programme)
    )


@once_per_setting
def torque_over_turn(programme: Programme, *factors: FloatArray) -> TorqueOverTurn:
    """Extremes, mean, root mean square and fluctuation of energy of the torque, from the factors of F."""
    series, half_width = torque_polynomials_by_panel(programme, factors), programme.table.half_width
    mean = turn_integral(
        half_width,
        multiply_series(
            dissipative_force_polynomials(programme, factors), _velocity_polynomials_by_panel(programme)
        ),
    ) / (2.0 * pi)
    rms = np.sqrt(turn_integral(half_width, multiply_series(series, series)) / (2.0 * pi))
    shares = [corner.after / corner.size for corner in programme.corners]  # there the torque is infinite
    upwards, downwards = any(share > LEAST_JUMP for share in shares), any(1.0 - s > LEAST_JUMP for s in shares)
    unknown = inf if has_unknown_energy_fluctuation(programme) else 0.0
    top, bottom = largest_value_of_series(series), -largest_value_of_series(-series)
    room = WORK_ERROR * np.maximum(top, -bottom)
    mean = np.where(np.abs(mean) <= room, 0.0, mean)  # rounding of work that is given back over the turn
    return TorqueOverTurn(
        top + inf if upwards else top,
        bottom - inf if downwards else bottom,
        _energy_fluctuation(programme, factors, mean) + unknown,
        np.zeros_like(mean) if upwards or downwards else room,
        mean + unknown,
        rms + inf if upwards or downwards else rms,
    )


def _velocity_polynomials_by_panel(programme: Programme) -> FloatArray:
    """The series of y', the same for all settings."""
    return derivative_polynomials_by_panel(programme.table, 1)[:, None]


def dissipative_force_polynomials(programme: Programme, factors: Sequence[FloatArray]) -> FloatArray:
    """Part of F whose work is not given back over a turn, on the panels; it includes the whole load of a train."""
    _, damping, _, _, carried = (each[:, None] for each in factors)
    table = programme.table
    load = sum_series(
        external_load_polynomials_by_panel(table)[:, None],
        carried * train_inertia_polynomials_by_panel(table)[:, None],
    )
    return sum_series(damping * _velocity_polynomials_by_panel(programme), load)


def has_unknown_energy_fluctuation(programme: Programme) -> bool:
    """Whether the energy is unknown: at a corner the masses of a train take up energy at once."""
    return bool(programme.corners) and isinstance(programme.load, TrainLoad) and programme.load.train.has_mass


def _energy_fluctuation(programme: Programme, factors: Sequence[FloatArray], mean: FloatArray) -> FloatArray:
    """Largest minus least W; at a corner that reverses the motion, y' passes through 0."""
    table = programme.table
    stiffness, _, mass, constant, _, mean = (each[:, None] for each in (*factors, mean))
    y, speed = derivative_polynomials_by_panel(table, 0)[:, None], _velocity_polynomials_by_panel(programme)
    angle = np.array([table.centre, table.half_width])[:, None]
    losses = integrate_series(
        table.half_width, multiply_series(dissipative_force_polynomials(programme, factors), speed)
    )
    kinetic = 0.5 * mass * multiply_series(speed, speed)
    rest = sum_series(0.5 * stiffness * multiply_series(y, y), constant * y, losses, -mean * angle)
    reversals = [corner.at for corner in programme.corners if 0.0 < corner.after / corner.size < 1.0]
    within = np.asarray(polynomial.polyval(-1.0, rest))[:, np.searchsorted(table.centre, reversals)]
    work = sum_series(rest, kinetic)
    least = np.minimum(-largest_value_of_series(-work), within.min(axis=1, initial=inf))
    return np.asarray(largest_value_of_series(work) - least)


def guided_torque_extremes(
    case: EvaluationBlock, jam_free: Any, wanted_quantities: frozenset[str]
) -> TorqueOverTurn:
    """Extremes for followers with guide friction, arrays (designs,); infinite for designs that may jam."""
    count, index = len(case.designs), np.flatnonzero(jam_free)
    ends = TorqueOverTurn(np.full(count, inf), np.full(count, -inf), np.full(count, inf), np.zeros(count))
    if not index.size:
        return ends
    running = replace(case, designs=case.designs.take(index))
    known = peaks(case.setup)
    most, least = (peak_extremes(running, known[name]) for name in ("torque_max_N_m", "torque_min_N_m"))
    ends.largest[index], ends.least[index] = most.value, least.value
    ends.room[index] = np.maximum(most.width, least.width)
    for number in index if wanted_quantities & FLUCTUATION_QUANTITIES else ():
        half_width, series = guided_torque_polynomials(
            *case.setup.absorb_design_numbers(case.designs.take([number])), case.programme
        )
        mean = turn_integral(half_width, series) / (2.0 * pi)
        work = integrate_series(half_width, sum_series(series, np.full((1, half_width.size), -mean)))
        ends.fluctuation[number] = float(largest_value_of_series(work) + largest_value_of_series(-work))
    return ends


def _is_jam_free(case: EvaluationBlock) -> Any:
    """Mask of designs that surely do not jam, on a motion without corners; inward only if F becomes negative."""
    least, _ = force.least_and_largest_contact_force(case)
    pulled, smooth = (least.value if isinstance(least, EnclosedValue) else least) < 0.0, not case.programme.corners

    def is_jam_free_on_kinds(kinds: int) -> Any:
        drag = case.extremes(partial(jamming_ratio_curve, case.setup), [(kinds, LARGEST_MAGNITUDE)])
        return (drag.value[0] + drag.width[0] < 1.0) & smooth

    if np.ndim(pulled) == 0:
        return is_jam_free_on_kinds(OUTWARD | INWARD if pulled else jamming_stroke_kinds(case.setup))
    return np.where(
        pulled, is_jam_free_on_kinds(OUTWARD | INWARD), is_jam_free_on_kinds(jamming_stroke_kinds(case.setup))
    )


def peaks(setup: Setup) -> dict[str, Peak]:
    if setup.omega is None:
        return {}
    curves = curve_variants_by_friction(torque_curve, setup)
    goals = {"torque_max_N_m": LARGEST, "torque_min_N_m": LEAST}
    goals |= dict.fromkeys(("torque_peak_N_m", "power_peak_W"), LARGEST_MAGNITUDE)
    in_newton_metres = MultipleScale(1e-3)
    units: dict[str, Scale] = dict.fromkeys(goals, in_newton_metres) | {
        "power_peak_W": _torque_to_power_scale(setup)
    }
    return {name: Peak(curves, goal, units[name], is_infinite_by_velocity_jumps) for name, goal in goals.items()}


def _torque_to_power_scale(setup: Setup) -> Scale:
    """The scale from a torque [N·mm] to the power [W]."""
    return multiple_scale(setup, lambda numbers: 1e-3 * numbers.omega)


def means(setup: Setup) -> dict[str, Mean]:
    if setup.omega is None:
        return {}
    whole = curve_variants_by_friction(torque_curve, setup)
    units: dict[str, Scale] = {
        "torque_mean_N_m": MultipleScale(1e-3),
        "power_mean_W": _torque_to_power_scale(setup),
    }
    if has_guide_friction(setup):
        smooth = partial(panel_parts_with_smooth_torque, setup)
        guided = {name: Mean(whole, 1, unit, is_infinite_by_velocity_jumps, smooth) for name, unit in units.items()}
        return guided | {
            "torque_rms_N_m": Mean(whole, 2, MultipleScale(1e-3), is_infinite_by_velocity_jumps, smooth)
        }
    losses = ((partial(dissipative_torque_curve, setup), ALL_STROKES),)
    return {name: Mean(losses, 1, unit, has_unknown_energy_fluctuation) for name, unit in units.items()} | {
        "torque_rms_N_m": Mean(whole, 2, MultipleScale(1e-3), is_infinite_by_velocity_jumps)
    }


def dissipative_torque_curve(setup: Setup, designs: Designs, programme: Programme) -> Curve:
    """Curve of the torque of ``dissipative_force_polynomials`` [N·mm], without impulses at corners."""
    numbers, ones = setup.with_design_numbers(designs), np.ones(len(designs))
    damping = Linear(0.0 * ones, numbers.dynamics.damping * numbers.omega * ones, 0.0 * ones, 0.0 * ones)
    return shaft_torque(add_changing_load_and_train_inertia(damping, ones, numbers.omega**2 * ones, programme))


def evaluate_pitch_curve_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    dynamics, omega = case.setup_per_design.dynamics, case.setup_per_design.omega
    if has_guide_friction(case.setup):
        runs, averages = _is_jam_free(case), means(case.setup)
        columns = {name: mean_column(case, averages[name], runs) for name in wanted_quantities & averages.keys()}
        return (
            _torque_extreme_columns(guided_torque_extremes(case, runs, wanted_quantities), dynamics, omega)
            | columns
        )
    differ = bool(case.designs.numbers and wanted_quantities & EXTREME_QUANTITIES) and not case.programme.corners
    ends = None
    if differ:  # always the same way, so that a bound has the same digits whatever else is wanted
        known, unknown = peaks(case.setup), np.full(len(case.designs), inf)
        most, least = (peak_extremes(case, known[name]) for name in ("torque_max_N_m", "torque_min_N_m"))
        ends = TorqueOverTurn(most.value, least.value, unknown, np.maximum(most.width, least.width))
        if wanted_quantities <= EXTREME_QUANTITIES:
            return _torque_extreme_columns(ends, dynamics, omega)
    turn, unit = torque_over_turn(case.programme, *force.force_factors_with_train(dynamics, omega)), 1e-3
    ends = ends._replace(fluctuation=turn.fluctuation) if ends else turn
    return _torque_extreme_columns(ends, dynamics, omega) | {
        "torque_mean_N_m": turn.mean * unit,
        "torque_rms_N_m": turn.rms * unit,
        "power_mean_W": turn.mean * (unit * omega),
    }


def _torque_extreme_columns(extremes: TorqueOverTurn, dynamics: FollowerDynamics, omega: Any) -> dict[str, Any]:
    """The columns of the extremes and of the fluctuation."""
    unit, power = 1e-3, 1e-3 * omega  # from N·mm to N·m, and to W
    peak, room = np.maximum(extremes.largest, -extremes.least), extremes.room
    columns: dict[str, Any] = {
        "torque_max_N_m": extremes.largest * unit,
        "torque_min_N_m": extremes.least * unit,
        "torque_peak_N_m": EnclosedValue(peak * unit, room * unit, peak * unit),
        "power_peak_W": EnclosedValue(peak * power, room * power, peak * power),
        "energy_fluctuation_J": extremes.fluctuation * unit,
    }
    if dynamics.fluctuation is not None:
        columns[FLYWHEEL] = extremes.fluctuation * unit / (dynamics.fluctuation * omega**2)
    return columns


EFFECT = Effect(
    "torque",
    lambda setup: (*TORQUE_NAMES, FLYWHEEL),
    missing_keys_by_quantity=missing_keys_by_quantity,
    evaluate_pitch_curve_columns=evaluate_pitch_curve_columns,
    is_of_motion=lambda setup: not has_guide_friction(setup),
    peaks=peaks,
    means=means,
)
