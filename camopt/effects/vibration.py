"""Vibration: the follower train as one mass on a spring and a damper, driven by the cam through them.

    ẍ + 2ζω_n(ẋ − ẏ) + ω_n²(x − y) = 0,    y the cam's motion, x that of the mass, ω_n = 2π·f_n

The steady response over the turn is exact (``numerics.oscillator``). It depends on the motion and the speed alone:
one value holds for all designs of a programme. A dwell starts with a free vibration,

    z = A·e^{−ζω_n t}·cos(w·ω_n·t − ψ),    A² = z² + ((ż/ω_n + ζz)/w)² at its start,    w = √(1 − ζ²),

and A is the residual vibration. The contact force with the elastic train,

    F = m·ẍ + c·ẏ + k·y + F₀ + F_ext,

takes the inertia from the mass, at x; the spring that keeps contact, its damper and the load act on the cam's side
of the train, at y. Contact is lost where F ≤ 0. The response is that of a train that stays on the cam: it says that
contact is lost, not what follows. Without damping a whole number of free vibrations in a turn is resonance, and the
response infinite. 0 ≤ ζ < 1; ω_n/ω up to 1e10, where rounding of the phase shows in the sixth digit of a vibration.

Source: Norton, Cam Design and Manufacturing Handbook; Rothbart, Cam Design Handbook (one-mass follower models).
"""

from functools import lru_cache
from math import degrees, inf, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.effects.case import Bounded, Case, Effect, Setup
from camopt.effects.force import missing, weights
from camopt.effects.given import GivenDynamics
from camopt.effects.motion import scale
from camopt.motion.programme import Programme, peak
from camopt.motion.table import ALL_STROKES, DWELL
from camopt.numerics import FloatArray
from camopt.numerics.oscillator import Wave, is_resonant, steady
from camopt.numerics.piecewise import load_series
from camopt.numerics.wave_extremes import Enclosed, largest_magnitude, least


class Vibration(NamedTuple):
    """The response of a follower train: mm (rad) by cam angle, each a value and its outer bound."""

    overshoot: Any  # largest |z|
    overshoot_bound: Any
    acceleration: Any  # largest |x″|
    acceleration_bound: Any
    residual: Any  # amplitude left over in a dwell, the largest; 0 without a dwell


ENDLESS = Vibration(*[inf] * 5)


def offers(setup: Setup) -> tuple[str, ...]:
    length, second = ("deg", "rad_s2") if setup.angular else ("mm", "m_s2")
    moving = (
        f"overshoot_max_{length}",
        f"acceleration_elastic_max_{second}",
        f"residual_vibration_max_{length}",
        "dynamic_factor",
    )
    flat_swing = setup.angular and setup.mechanism.curvature is None  # its lever changes over the turn
    return moving if flat_swing else (*moving, "contact_force_elastic_min_N")


def lacks(setup: Setup) -> dict[str, tuple[str, ...]]:
    speed = () if setup.omega is not None else ("cam.rpm",)
    train = () if setup.dynamics.natural_frequency is not None else ("follower.dynamics.natural_frequency",)
    keys = dict.fromkeys(offers(setup), (*speed, *train))
    if "contact_force_elastic_min_N" in keys:
        keys["contact_force_elastic_min_N"] = (*missing(setup), *train)
    return {name: wanting for name, wanting in keys.items() if wanting}


def response(programme: Programme, ratio: float, damping: float) -> Wave:
    """The steady z = x − y over the turn, on the panels of the programme; r = ω_n/ω, not resonant."""
    table = programme.table
    return steady(table.coefficients.T, table.half_width, corners(programme), ratio, damping)


def corners(programme: Programme) -> FloatArray:
    """The jump of y′ at the start of each panel."""
    table = programme.table
    sizes = np.zeros(len(table.half_width))
    for jump in programme.corners:
        sizes[table.centre - table.half_width == jump.at] = jump.size
    return sizes


def mass_acceleration(wave: Wave, ratio: Any) -> Wave:
    """x″ = −r²z − 2ζr·z′ of a response."""
    return wave.times(-(ratio**2)).plus(wave.slope().times(-2.0 * wave.damping * ratio))


@lru_cache(maxsize=4096)
def vibration(programme: Programme, ratio: float, damping: float) -> Vibration:
    """The extremes of the steady response."""
    if is_resonant(ratio, damping):
        return ENDLESS
    wave = response(programme, ratio, damping)
    dwells = programme.table.first_panel[:-1][(programme.table.kind & DWELL) != 0]
    residual = float(wave.amplitude[0, dwells].max(initial=0.0))
    return Vibration(
        *_pair(largest_magnitude(wave)), *_pair(largest_magnitude(mass_acceleration(wave, ratio))), residual
    )


@lru_cache(maxsize=4096)
def contact(programme: Programme, dynamics: GivenDynamics, omega: float, ratio: float) -> tuple[float, float]:
    """The least F over the turn, N (N·mm), and its lower bound."""
    if is_resonant(ratio, dynamics.damping_ratio):
        return -inf, -inf
    return _pair(least(contact_wave(programme, dynamics, omega, ratio)))


def contact_wave(programme: Programme, dynamics: GivenDynamics, omega: float, ratio: float) -> Wave:
    """F over the turn with the elastic train, N (N·mm)."""
    stiffness, damping, mass, constant = weights(dynamics, omega)
    table = programme.table
    y = table.coefficients.T
    held: FloatArray = stiffness * y
    held[:-1] += damping * polynomial.polyder(y) / table.half_width
    held[0] += constant
    held[:2] += load_series(table)
    inertia = mass_acceleration(response(programme, ratio, dynamics.damping_ratio), ratio).times(mass)
    return inertia.over(held)


def _pair(found: Enclosed) -> tuple[float, float]:
    return float(found.value[0]), float(found.bound[0])


def dynamic_factor(elastic: Any, rigid: float) -> Any:
    """Largest |ẍ| over largest |ÿ|: 0 where ÿ is an impulse and ẍ is not, 1 where nothing moves."""
    endless = np.isinf(elastic)
    over = 1.0 if rigid == 0.0 else np.where(endless, 0.0, elastic) / rigid
    return np.where(endless, inf, over)[()]


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    setup, programme = case.setup, case.programme
    found: Vibration = case.by_setting(
        lambda each: vibration(programme, train_ratio(each), each.dynamics.damping_ratio)
    )
    length, second = ("deg", "rad_s2") if setup.angular else ("mm", "m_s2")
    unit = degrees(1.0) if setup.angular else 1.0
    columns: dict[str, Any] = {
        f"overshoot_max_{length}": _bounded(found.overshoot, found.overshoot_bound, unit),
        f"acceleration_elastic_max_{second}": _bounded(
            found.acceleration, found.acceleration_bound, scale(case.each, 2)
        ),
        f"residual_vibration_max_{length}": found.residual * unit,
        "dynamic_factor": dynamic_factor(found.acceleration, peak(programme, 2, ALL_STROKES)),
    }
    if "contact_force_elastic_min_N" in wanted:
        lever = case.designs.arm_length if setup.angular else 1.0
        force: Enclosing = case.by_setting(
            lambda each: Enclosing(*contact(programme, each.dynamics, each.omega, train_ratio(each)))
        )
        columns["contact_force_elastic_min_N"] = _bounded(force.value, force.bound, 1.0 / lever)
    return columns


class Enclosing(NamedTuple):
    """A value and its outer bound."""

    value: Any
    bound: Any


def train_ratio(setup: Setup) -> float:
    """r = ω_n/ω."""
    return float(2.0 * pi * setup.dynamics.natural_frequency / setup.omega)


def _bounded(value: Any, bound: Any, unit: Any) -> Bounded:
    with np.errstate(invalid="ignore"):
        outward = np.where(value == bound, 0.0, np.subtract(bound, value))  # ∞ − ∞ is no width
    return Bounded(value * unit, outward * unit, np.abs(value) * unit)


EFFECT = Effect("vibration", offers, run, lacks, of_motion=lambda setup: True)
