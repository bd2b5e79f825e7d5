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

from math import degrees, inf, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import FloatArray
from camopt.core.numerics.oscillator import Wave, is_resonant, periodic_response
from camopt.core.numerics.piecewise import load_series
from camopt.core.numerics.wave_extremes import WaveExtreme, wave_minimum, wave_peak_magnitude
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup
from camopt.model.effects.force import force_weights, missing_force_keys
from camopt.model.effects.motion import motion_scale
from camopt.model.effects.setting_cache import once_per_setting
from camopt.model.motion.programme import Programme, derivative_peak
from camopt.model.motion.stroke import ALL_STROKES, DWELL


class Vibration(NamedTuple):
    """The response of a follower train: mm (rad) by cam angle, each a value and its outer bound."""

    overshoot: Any  # largest |z|
    overshoot_bound: Any
    acceleration: Any  # largest |x″|
    acceleration_bound: Any
    residual: Any  # amplitude left over in a dwell, the largest; 0 without a dwell


ENDLESS = Vibration(*[inf] * 5)


def offers(setup: Setup) -> tuple[str, ...]:
    length, second = ("deg", "rad_s2") if setup.tool_turns else ("mm", "m_s2")
    moving = (
        f"overshoot_max_{length}",
        f"acceleration_elastic_max_{second}",
        f"residual_vibration_max_{length}",
        "dynamic_factor",
    )
    flat_swing = setup.angular and setup.mechanism.flat_faced  # its lever changes over the turn
    without = flat_swing or setup.train or setup.mechanism.further_contacts
    return moving if without else (*moving, "contact_force_elastic_min_N")


def lacks(setup: Setup) -> dict[str, tuple[str, ...]]:
    speed = () if setup.omega is not None else ("cam.rpm",)
    train = () if setup.dynamics.natural_frequency is not None else ("follower.dynamics.natural_frequency",)
    keys = dict.fromkeys(offers(setup), (*speed, *train))
    if "contact_force_elastic_min_N" in keys:
        keys["contact_force_elastic_min_N"] = (*missing_force_keys(setup), *train)
    return {name: wanting for name, wanting in keys.items() if wanting}


def steady_response(programme: Programme, ratio: Any, damping: Any) -> Wave:
    """The steady z = x − y on the panels of the programme, for r = ω_n/ω and ζ (rows, 1) that do not resonate."""
    table = programme.table
    return periodic_response(table.coefficients.T, table.half_width, corner_sizes(programme), ratio, damping)


def corner_sizes(programme: Programme) -> FloatArray:
    """The jump of y′ at the start of each panel."""
    table = programme.table
    sizes = np.zeros(len(table.half_width))
    for jump in programme.corners:
        sizes[table.centre - table.half_width == jump.at] = jump.size
    return sizes


def mass_acceleration(wave: Wave, ratio: Any) -> Wave:
    """x″ = −r²z − 2ζr·z′ of a response."""
    return wave.times(-(ratio**2)).plus(wave.slope().times(-2.0 * wave.damping * ratio))


@once_per_setting
def vibration(programme: Programme, ratio: Any, damping: Any) -> Vibration:
    """The extremes of the steady response."""
    found = np.full((len(Vibration._fields), ratio.size), inf)
    calm = ~is_resonant(ratio, damping)
    if calm.any():
        ratio, damping = ratio[calm, None], damping[calm, None]
        wave = steady_response(programme, ratio, damping)
        dwells = programme.table.first_panel[:-1][(programme.table.kind & DWELL) != 0]
        moved, driven = wave_peak_magnitude(wave), wave_peak_magnitude(mass_acceleration(wave, ratio))
        found[:, calm] = *moved, *driven, wave.amplitude[:, dwells].max(axis=1, initial=0.0)
    return Vibration(*found)


@once_per_setting
def least_elastic_force(
    programme: Programme, stiffness: Any, damping: Any, mass: Any, constant: Any, ratio: Any, damping_ratio: Any
) -> WaveExtreme:
    """The least F over the turn with its factors (``force.force_weights``), N (N·mm), and its lower bound."""
    found = np.full((2, ratio.size), -inf)
    calm = ~is_resonant(ratio, damping_ratio)
    if calm.any():
        parts = (each[calm, None] for each in (stiffness, damping, mass, constant))
        found[:, calm] = wave_minimum(
            contact_wave(programme, tuple(parts), ratio[calm, None], damping_ratio[calm, None])
        )
    return WaveExtreme(*found)


def contact_wave(programme: Programme, factors: tuple[Any, ...], ratio: Any, damping_ratio: Any) -> Wave:
    """Contact force of the elastic train over the turn [N or N·mm], from its factors, each (rows, 1)."""
    stiffness, damping, mass, constant = factors
    table = programme.table
    y = table.coefficients.T[:, None]
    held: FloatArray = stiffness * y + np.zeros_like(mass)
    held[:-1] += damping * polynomial.polyder(y) / table.half_width
    held[0] += constant
    held[:2] += load_series(table)[:, None]
    return (
        mass_acceleration(steady_response(programme, ratio, damping_ratio), ratio).times(mass).plus_polynomial(held)
    )


def dynamic_factor(elastic: Any, rigid: float) -> Any:
    """Largest |ẍ| over largest |ÿ|: 0 where ÿ is an impulse and ẍ is not, 1 where nothing moves."""
    endless = np.isinf(elastic)
    over = 1.0 if rigid == 0.0 else np.where(endless, 0.0, elastic) / rigid
    return np.where(endless, inf, over)[()]


def run(case: EvaluationBlock, wanted: frozenset[str]) -> dict[str, Any]:
    setup, programme, own = case.setup, case.programme.tool, case.setup_per_design
    train = frequency_ratio(own), own.dynamics.damping_ratio
    found = vibration(programme, *train)
    length, second = ("deg", "rad_s2") if setup.tool_turns else ("mm", "m_s2")
    unit = degrees(1.0) if setup.tool_turns else 1.0
    columns: dict[str, Any] = {
        f"overshoot_max_{length}": _enclose_scaled(found.overshoot, found.overshoot_bound, unit),
        f"acceleration_elastic_max_{second}": _enclose_scaled(
            found.acceleration, found.acceleration_bound, motion_scale(own, 2)
        ),
        f"residual_vibration_max_{length}": found.residual * unit,
        "dynamic_factor": dynamic_factor(found.acceleration, derivative_peak(programme, 2, ALL_STROKES)),
    }
    if "contact_force_elastic_min_N" in wanted:
        lever = case.designs.arm_length if setup.angular else 1.0
        force = least_elastic_force(programme, *force_weights(own.dynamics, own.omega), *train)
        columns["contact_force_elastic_min_N"] = _enclose_scaled(force.value, force.bound, 1.0 / lever)
    return columns


def frequency_ratio(setup: Setup) -> Any:
    """r = ω_n/ω."""
    return 2.0 * pi * setup.dynamics.natural_frequency / setup.omega


def _enclose_scaled(value: Any, bound: Any, unit: Any) -> EnclosedValue:
    with np.errstate(invalid="ignore"):
        outward = np.where(value == bound, 0.0, np.subtract(bound, value))  # ∞ − ∞ is no width
    return EnclosedValue(value * unit, outward * unit, np.abs(value) * unit)


EFFECT = Effect("vibration", offers, run, lacks, is_of_motion=lambda setup: True)
