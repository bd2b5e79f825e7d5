"""The torque of the camshaft, and its demands on the drive and the flywheel.

    T = F·y',    F = m·ω²·y'' + c·ω·y' + k·y + F₀ + F_ext            (oscillating: M·ψ' with moments)

It depends on the motion and the speed alone, and is a polynomial on each panel: extremes and integrals are exact.
Springs, masses and constant loads give back over a turn what they took; damping and a load F_ext that changes over
the turn (``motion.load``) do not, so that ∮T dθ = ∮(c·ω·y' + F_ext)·y' dθ. With

    W(θ) = ∫(T − T_mean)dθ = m·ω²·y'²/2 + k·y²/2 + F₀·y + ∫(c·ω·y' + F_ext)·y' dθ − T_mean·θ

up to a constant, the fluctuation of energy is ΔE = max W − min W and the flywheel I = ΔE/(C_f·ω²).

A follower that rubs in its guide asks for more: T = G·y' with the force G that the cam gives along the motion
(``effects.loads``), whose work over a turn is greater by what the guide takes. It depends on the design then; its
extremes and means are found as those of other curves (``effects.peak``, ``effects.mean``), and its fluctuation from
panel polynomials (``effects.guided``). It is infinite where the follower jams, and none of it is known at a corner.

At a corner of the motion y' passes from one value to the other at once: T is infinite, upwards where |y'| grows,
downwards where it falls; W is not. With masses that a train carries, what depends on energy is infinite then too.

Source: Norton, Design of Machinery, ch. 15 (camshaft torque) and 11 (flywheel).
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import inf, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import LARGEST, LARGEST_MAGNITUDE, LEAST, FloatArray
from camopt.core.numerics.curves import Linear
from camopt.core.numerics.piecewise import carried_series, load_series
from camopt.model.effects import force
from camopt.model.effects.case import Bounded, Case, Effect, Setup, of_setting
from camopt.model.effects.force import with_load
from camopt.model.effects.given import GivenDynamics
from camopt.model.effects.guided import guided_torque, smooth_parts
from camopt.model.effects.loads import drag_of, driven, has_guide_friction, shaft_torque, torque_curve, ways
from camopt.model.effects.mean import Mean
from camopt.model.effects.mean_columns import mean_column
from camopt.model.effects.peak import AS_IT_IS, Peak, Scale, Times, at_corners
from camopt.model.effects.peak_columns import extreme_of
from camopt.model.effects.settings import by_setting
from camopt.model.effects.work import WORK_ERROR, added, derivative, integral, largest_of_series, product, total
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
EXTREMES = frozenset(("torque_max_N_m", "torque_min_N_m", "torque_peak_N_m", "power_peak_W"))
FLYWHEEL = "flywheel_inertia_kg_m2"
FLUCTUATING = frozenset(("energy_fluctuation_J", FLYWHEEL))


def offers(setup: Setup) -> tuple[str, ...]:
    return (*TORQUE_NAMES, FLYWHEEL)


def lacks(setup: Setup) -> dict[str, tuple[str, ...]]:
    keys = force.missing(setup)
    wheel = () if setup.dynamics.fluctuation is not None else ("follower.dynamics.fluctuation",)
    wanted = {**dict.fromkeys(TORQUE_NAMES, keys), FLYWHEEL: (*keys, *wheel)}
    return {name: lacking for name, lacking in wanted.items() if lacking}


class TorqueExtremes(NamedTuple):
    """Extremes of the torque and its fluctuation, N·mm: numbers, or arrays where it depends on the design."""

    largest: Any
    least: Any
    fluctuation: Any
    room: Any
    """By how much the largest magnitude may be above."""


class TorqueOverTurn(NamedTuple):
    """Extremes and means of the torque over a turn, whatever the sizes, N·mm."""

    largest: Any
    least: Any
    mean: Any
    rms: Any
    fluctuation: Any
    room: Any

    @property
    def span(self) -> TorqueExtremes:
        return TorqueExtremes(self.largest, self.least, self.fluctuation, self.room)


def torque_series(programme: Programme, factors: Sequence[Any]) -> FloatArray:
    """T on the panels, N·mm, from the factors of F (``force.factors_of``); impulses at corners are apart."""
    return product(force.force_series(programme, factors), derivative(programme.table, 1)[:, None])


@by_setting
def torque_over_turn(programme: Programme, *factors: FloatArray) -> TorqueOverTurn:
    """Extremes, mean, root mean square and fluctuation of energy of the torque, from the factors of F."""
    series, half_width = torque_series(programme, factors), programme.table.half_width
    mean = total(half_width, product(lasting(programme, factors), _speed(programme))) / (2.0 * pi)
    rms = np.sqrt(total(half_width, product(series, series)) / (2.0 * pi))
    upwards, downwards = _impulses(programme)
    unknown = inf if has_lost_energy(programme) else 0.0
    top, bottom = largest_of_series(series), -largest_of_series(-series)
    room = WORK_ERROR * np.maximum(top, -bottom)
    mean = np.where(np.abs(mean) <= room, 0.0, mean)  # of what comes back over the turn, rounding alone is left
    return TorqueOverTurn(
        top + inf if upwards else top,
        bottom - inf if downwards else bottom,
        mean + unknown,
        rms + inf if upwards or downwards else rms,
        _fluctuation(programme, factors, mean) + unknown,
        np.zeros_like(mean) if upwards or downwards else room,
    )


def _speed(programme: Programme) -> FloatArray:
    """y', the same for all settings."""
    return derivative(programme.table, 1)[:, None]


def extremes_of_turn(case: Case) -> TorqueExtremes:
    """The extremes only, for designs with numbers of their own; the motion has no corners."""
    known, unknown = peaks(case.setup), np.full(len(case.designs), inf)
    most, least = (extreme_of(case, known[name]) for name in ("torque_max_N_m", "torque_min_N_m"))
    return TorqueExtremes(most.value, least.value, unknown, np.maximum(most.width, least.width))


def lasting(programme: Programme, factors: Sequence[FloatArray]) -> FloatArray:
    """The part of F whose energy is not returned, on the panels, with all that comes from a train."""
    _, damping, _, _, carried = (each[:, None] for each in factors)
    table = programme.table
    load = added(load_series(table)[:, None], carried * carried_series(table)[:, None])
    return added(damping * _speed(programme), load)


def has_lost_energy(programme: Programme) -> bool:
    """Whether corners of the motion leave the energy unknown: that of what a train carries passes there at once."""
    return bool(programme.corners) and isinstance(programme.load, TrainLoad) and programme.load.train.has_mass


def _impulses(programme: Programme) -> tuple[bool, bool]:
    """Whether corners make the torque infinite upwards, and downwards."""
    shares = [corner.after / corner.size for corner in programme.corners]
    return any(share > LEAST_JUMP for share in shares), any(1.0 - share > LEAST_JUMP for share in shares)


def _fluctuation(programme: Programme, factors: Sequence[FloatArray], mean: FloatArray) -> FloatArray:
    """Largest minus least W. At a corner that reverses the motion, y' passes through 0."""
    table = programme.table
    stiffness, _, mass, constant, _, taken = (each[:, None] for each in (*factors, mean))
    y, speed = derivative(table, 0)[:, None], _speed(programme)
    angle = np.array([table.centre, table.half_width])[:, None]
    spent = integral(table.half_width, product(lasting(programme, factors), speed))
    kinetic = 0.5 * mass * product(speed, speed)
    rest = added(0.5 * stiffness * product(y, y), constant * y, spent, -taken * angle)
    turned = [corner.at for corner in programme.corners if 0.0 < corner.after / corner.size < 1.0]
    within = np.asarray(polynomial.polyval(-1.0, rest))[:, np.searchsorted(table.centre, turned)]
    work = added(rest, kinetic)
    least = np.minimum(-largest_of_series(-work), within.min(axis=1, initial=inf))
    return np.asarray(largest_of_series(work) - least)


def guided_span(case: Case, runs: Any, wanted: frozenset[str]) -> TorqueExtremes:
    """The extremes for followers with guide friction, arrays (designs,); infinite for those that jam."""
    count, index = len(case.designs), np.flatnonzero(runs)
    span = TorqueExtremes(np.full(count, inf), np.full(count, -inf), np.full(count, inf), np.zeros(count))
    if not index.size:
        return span
    some = replace(case, designs=case.designs.take(index))
    known = peaks(case.setup)
    most, least = (extreme_of(some, known[name]) for name in ("torque_max_N_m", "torque_min_N_m"))
    span.largest[index], span.least[index] = most.value, least.value
    span.room[index] = np.maximum(most.width, least.width)
    for number in index if wanted & FLUCTUATING else ():
        torque = guided_torque(*case.setup.alone(case.designs.take([number])), case.programme)
        span.fluctuation[number] = _fluctuation_of(*torque)
    return span


def _runs_free(case: Case) -> Any:
    """Designs that surely do not jam, for a motion without corners; only outward if the cam cannot pull."""
    least, _ = force.least_and_largest(case)
    pulled, smooth = (least.value if isinstance(least, Bounded) else least) < 0.0, not case.programme.corners

    def free(kinds: int) -> Any:
        drag = drag_of(case, kinds)
        return (drag.value[0] + drag.width[0] < 1.0) & smooth

    if np.ndim(pulled) == 0:
        return free(OUTWARD | INWARD if pulled else driven(case.setup))
    return np.where(pulled, free(OUTWARD | INWARD), free(driven(case.setup)))


def _fluctuation_of(half_width: FloatArray, series: FloatArray) -> float:
    """The fluctuation of energy of a torque on panels of these half-widths."""
    mean = total(half_width, series) / (2.0 * pi)
    work = integral(half_width, added(series, np.full((1, half_width.size), -mean)))
    return float(largest_of_series(work) + largest_of_series(-work))


def peaks(setup: Setup) -> dict[str, Peak]:
    if setup.omega is None:
        return {}
    curves = tuple((partial(torque_curve, setup, way=way), kinds) for way, kinds in ways(setup))
    goals = {"torque_max_N_m": LARGEST, "torque_min_N_m": LEAST}
    goals |= dict.fromkeys(("torque_peak_N_m", "power_peak_W"), LARGEST_MAGNITUDE)
    in_newton_metres = Times(1e-3)
    units: dict[str, Scale] = dict.fromkeys(goals, in_newton_metres) | {"power_peak_W": _in_watts(setup)}
    return {name: Peak(curves, goal, units[name], at_corners) for name, goal in goals.items()}


def _in_watts(setup: Setup) -> Scale:
    """From a torque in N·mm to the power."""
    return of_setting(setup, Times(1e-3 * setup.omega), AS_IT_IS, lambda each: 1e-3 * each.omega)


def means(setup: Setup) -> dict[str, Mean]:
    if setup.omega is None:
        return {}
    whole = tuple((partial(torque_curve, setup, way=way), kinds) for way, kinds in ways(setup))
    units: dict[str, Scale] = {"torque_mean_N_m": Times(1e-3), "power_mean_W": _in_watts(setup)}
    if has_guide_friction(setup):
        smooth = partial(smooth_parts, setup)
        found = {name: Mean(whole, 1, unit, at_corners, smooth) for name, unit in units.items()}
        return found | {"torque_rms_N_m": Mean(whole, 2, Times(1e-3), at_corners, smooth)}
    spent = ((partial(spent_curve, setup), ALL_STROKES),)
    return {name: Mean(spent, 1, unit, has_lost_energy) for name, unit in units.items()} | {
        "torque_rms_N_m": Mean(whole, 2, Times(1e-3), at_corners)
    }


def spent_curve(setup: Setup, designs: Designs, programme: Programme) -> Any:
    """The torque of forces whose energy is not returned (``lasting``), without impulses at corners."""
    each, ones = setup.at(designs), np.ones(len(designs))
    damped = Linear(0.0 * ones, each.dynamics.damping * each.omega * ones, 0.0 * ones, 0.0 * ones)
    return shaft_torque(with_load(damped, ones, each.omega**2 * ones, programme))


def of_pitch(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    dynamics, omega = case.each.dynamics, case.each.omega
    assert omega is not None
    if has_guide_friction(case.setup):
        runs, known = _runs_free(case), means(case.setup)
        found = {name: mean_column(case, known[name], runs) for name in wanted & known.keys()}
        return _of_span(guided_span(case, runs, wanted), dynamics, omega) | found
    own = bool(case.designs.numbers and wanted & EXTREMES) and not case.programme.corners
    span = extremes_of_turn(case) if own else None  # whatever else is wanted: a bound is of the same digits
    if span and wanted <= EXTREMES:
        return _of_span(span, dynamics, omega)
    turn, unit = torque_over_turn(case.programme, *force.factors_of(dynamics, omega)), 1e-3
    span = span._replace(fluctuation=turn.fluctuation) if span else turn.span
    columns = _of_span(span, dynamics, omega)
    columns |= {"torque_mean_N_m": turn.mean * unit, "torque_rms_N_m": turn.rms * unit}
    return columns | {"power_mean_W": turn.mean * (unit * omega)}


def _of_span(span: TorqueExtremes, dynamics: GivenDynamics, omega: Any) -> dict[str, Any]:
    """The columns of extremes and of the fluctuation."""
    unit, power = 1e-3, 1e-3 * omega  # to N·m from N·mm, to W from N·mm
    peak, room = np.maximum(span.largest, -span.least), span.room
    columns: dict[str, Any] = {
        "torque_max_N_m": span.largest * unit,
        "torque_min_N_m": span.least * unit,
        "torque_peak_N_m": Bounded(peak * unit, room * unit, peak * unit),
        "power_peak_W": Bounded(peak * power, room * power, peak * power),
        "energy_fluctuation_J": span.fluctuation * unit,
    }
    if dynamics.fluctuation is not None:
        columns[FLYWHEEL] = span.fluctuation * unit / (dynamics.fluctuation * omega**2)
    return columns


EFFECT = Effect(
    "torque",
    offers,
    lacks=lacks,
    of_pitch=of_pitch,
    is_of_motion=lambda setup: not has_guide_friction(setup),
    peaks=peaks,
    means=means,
)
