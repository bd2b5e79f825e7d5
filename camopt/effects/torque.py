"""The torque that the camshaft gives, free of friction, and what it asks of the drive and the flywheel.

    T = F·y',    F = m·ω²·y'' + c·ω·y' + k·y + F₀ + F_ext            (oscillating: M·ψ' with moments)

It depends on the motion and the speed alone, and is a polynomial on each panel: extremes and integrals are exact.
Springs, masses and constant loads give back over a turn what they took; damping and a load F_ext that changes over
the turn (``motion.load``) do not, so that ∮T dθ = ∮(c·ω·y' + F_ext)·y' dθ. With

    W(θ) = ∫(T − T_mean)dθ = m·ω²·y'²/2 + k·y²/2 + F₀·y + ∫(c·ω·y' + F_ext)·y' dθ − T_mean·θ

up to a constant, the fluctuation of energy is ΔE = max W − min W and the flywheel I = ΔE/(C_f·ω²).

At a corner of the motion y' passes from one value to the other at once: T is infinite, upwards where |y'| grows,
downwards where it falls; W is not.

Source: Norton, Design of Machinery, ch. 15 (camshaft torque) and 11 (flywheel).
"""

from functools import lru_cache
from math import inf, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.effects import force
from camopt.effects.case import Bounded, Case, Dynamics, Effect, Subject
from camopt.effects.work import ROUNDED, added, derivative, integral, largest, product, total
from camopt.motion.programme import SAME, Programme
from camopt.numerics import FloatArray
from camopt.numerics.piecewise import load_series

NAMES = (
    "torque_max_N_m",
    "torque_min_N_m",
    "torque_peak_N_m",
    "torque_mean_N_m",
    "torque_rms_N_m",
    "power_peak_W",
    "power_mean_W",
    "energy_fluctuation_J",
)
FLYWHEEL = "flywheel_inertia_kg_m2"


def offers(subject: Subject) -> tuple[str, ...]:
    return (*NAMES, FLYWHEEL)


def lacks(subject: Subject) -> dict[str, tuple[str, ...]]:
    keys = force.missing(subject)
    wheel = () if subject.dynamics.fluctuation is not None else ("follower.dynamics.fluctuation",)
    wanted = {**dict.fromkeys(NAMES, keys), FLYWHEEL: (*keys, *wheel)}
    return {name: lacking for name, lacking in wanted.items() if lacking}


class Turn(NamedTuple):
    """What the torque amounts to over a turn, N·mm."""

    largest: float
    least: float
    mean: float
    rms: float
    fluctuation: float


def torque_series(programme: Programme, dynamics: Dynamics, omega: float) -> FloatArray:
    """T on the panels, N·mm; impulses at corners are apart."""
    table = programme.table
    *factors, constant = force.weights(dynamics, omega)
    along = added(*(factor * derivative(table, order) for order, factor in enumerate(factors)), load_series(table))
    along[0] += constant
    return product(along, derivative(table, 1))


@lru_cache(maxsize=4096)
def turn_of(programme: Programme, dynamics: Dynamics, omega: float) -> Turn:
    """Extremes, mean, root mean square and fluctuation of energy of the torque."""
    series = torque_series(programme, dynamics, omega)
    speed = derivative(programme.table, 1)
    mean = total(programme.table, product(lasting(programme, dynamics, omega), speed)) / (2.0 * pi)
    rms = sqrt(total(programme.table, product(series, series)) / (2.0 * pi))
    upwards, downwards = _impulses(programme)
    return Turn(
        inf if upwards else largest(series),
        -inf if downwards else -largest(-series),
        mean,
        inf if upwards or downwards else rms,
        _fluctuation(programme, dynamics, omega, mean),
    )


def lasting(programme: Programme, dynamics: Dynamics, omega: float) -> FloatArray:
    """The part of F that does not give back what it took, on the panels: damping, and a load that changes."""
    return added(dynamics.damping * omega * derivative(programme.table, 1), load_series(programme.table))


def _impulses(programme: Programme) -> tuple[bool, bool]:
    """Whether corners make the torque infinite upwards, and downwards."""
    shares = [corner.after / corner.size for corner in programme.corners]
    return any(share > SAME for share in shares), any(1.0 - share > SAME for share in shares)


def _fluctuation(programme: Programme, dynamics: Dynamics, omega: float, mean: float) -> float:
    """Largest minus least W. Where a corner turns the motion round, y' passes through 0 within it."""
    table = programme.table
    stiffness, _, mass, constant = force.weights(dynamics, omega)
    y, speed = derivative(table, 0), derivative(table, 1)
    angle, spent = np.array([table.centre, table.half_width]), product(lasting(programme, dynamics, omega), speed)
    kinetic = 0.5 * mass * product(speed, speed)
    rest = added(0.5 * stiffness * product(y, y), constant * y, integral(table, spent), -mean * angle)
    turned = [corner.at for corner in programme.corners if 0.0 < corner.after / corner.size < 1.0]
    within = np.asarray(polynomial.polyval(-1.0, rest))[np.searchsorted(table.centre, turned)]
    work = added(rest, kinetic)
    return largest(work) - min([-largest(-work), *map(float, within)])


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    dynamics, omega = case.subject.dynamics, case.subject.omega
    assert omega is not None
    turn = turn_of(case.programme, dynamics, omega)
    unit, power = 1e-3, 1e-3 * omega  # to N·m from N·mm, to W from N·mm
    peak = max(turn.largest, -turn.least)
    room = 0.0 if peak == inf else ROUNDED * peak
    columns: dict[str, Any] = {
        "torque_max_N_m": turn.largest * unit,
        "torque_min_N_m": turn.least * unit,
        "torque_peak_N_m": Bounded(peak * unit, room * unit, peak * unit),
        "torque_mean_N_m": turn.mean * unit,
        "torque_rms_N_m": turn.rms * unit,
        "power_peak_W": Bounded(peak * power, room * power, peak * power),
        "power_mean_W": turn.mean * power,
        "energy_fluctuation_J": turn.fluctuation * unit,
    }
    if dynamics.fluctuation is not None:
        columns[FLYWHEEL] = turn.fluctuation * unit / (dynamics.fluctuation * omega**2)
    return columns


EFFECT = Effect("torque", offers, run, lacks, of_motion=True)
