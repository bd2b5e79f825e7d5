"""Vibration: the follower train as one mass that the cam drives through a spring and a damper.

    ẍ + 2ζω_n(ẋ − ẏ) + ω_n²(x − y) = 0,    y the cam's motion, x that of the mass, ω_n = 2π·f_n

The steady response over the turn is exact (``numerics.oscillator``). It depends only on the motion and the speed,
so all designs of a programme have the same. In a dwell z = x − y is a free vibration,

    z = A·e^{−ζω_n t}·cos(w·ω_n·t − ψ),    A² = z² + ((ż/ω_n + ζz)/w)² at its start,    w = √(1 − ζ²)

and A is the residual vibration. The contact force with the elastic train is

    F = m·ẍ + c·ẏ + k·y + F₀ + F_ext

The inertia acts at the mass, at x; the spring that keeps contact, its damper and the load act on the cam's side of
the train, at y. Contact is lost where F ≤ 0; the response is that of a train that stays on the cam, and so does not
describe the motion after the loss. Without damping, a whole number of free vibrations in a turn is resonance, and
the response is infinite.

Validity: 0 ≤ ζ < 1; ω_n/ω up to 1e10, where rounding of the phase shows in the sixth digit of a vibration.

Source: Norton, Cam Design and Manufacturing Handbook; Rothbart, Cam Design Handbook (one-mass follower models).
"""

from math import degrees, inf, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import FloatArray, Number
from camopt.core.numerics.oscillator import Wave, is_resonant, periodic_response
from camopt.core.numerics.piecewise import external_load_polynomials_by_panel
from camopt.core.numerics.wave_extremes import WaveExtreme, wave_minimum, wave_peak_magnitude
from camopt.model.effects.effect import Effect, EnclosedValue, EvaluationBlock, Setup
from camopt.model.effects.force import force_weights_and_constant, missing_force_keys
from camopt.model.effects.motion import motion_unit_factor
from camopt.model.effects.setting_cache import once_per_setting
from camopt.model.motion.programme import Programme, derivative_peak
from camopt.model.motion.stroke import ALL_STROKES, DWELL


class Vibration(NamedTuple):
    """The response of a follower train, in mm or rad per radⁿ; bounds are the far ends of enclosures."""

    overshoot: Any  # largest |z|
    overshoot_bound: Any
    acceleration: Any  # largest |x″|
    acceleration_bound: Any
    residual: Any  # largest amplitude in a dwell; 0 without a dwell


def applicable_quantities(setup: Setup) -> tuple[str, ...]:
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


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    speed = () if setup.omega is not None else ("cam.rpm",)
    train = () if setup.dynamics.natural_frequency is not None else ("follower.dynamics.natural_frequency",)
    keys = dict.fromkeys(applicable_quantities(setup), (*speed, *train))
    if "contact_force_elastic_min_N" in keys:
        keys["contact_force_elastic_min_N"] = (*missing_force_keys(setup), *train)
    return {name: wanting for name, wanting in keys.items() if wanting}


def steady_vibration_wave(programme: Programme, frequency_ratio: Any, damping_ratio: Any) -> Wave:
    """Steady z = x − y on the panels of the programme, for r = ω_n/ω and ζ (rows, 1) without resonance."""
    table = programme.table
    return periodic_response(
        table.coefficients.T, table.half_width, velocity_jump_by_panel(programme), frequency_ratio, damping_ratio
    )


def velocity_jump_by_panel(programme: Programme) -> FloatArray:
    """Jump of y′ at the start of each panel."""
    table = programme.table
    sizes = np.zeros(len(table.half_width))
    for jump in programme.corners:
        sizes[table.centre - table.half_width == jump.at] = jump.size
    return sizes


def mass_acceleration_wave(wave: Wave, frequency_ratio: Any) -> Wave:
    """Acceleration of the mass in a response, x″ = −r²z − 2ζr·z′."""
    return wave.times(-(frequency_ratio**2)).plus(wave.slope().times(-2.0 * wave.damping * frequency_ratio))


@once_per_setting
def vibration_extremes(programme: Programme, frequency_ratio: Any, damping_ratio: Any) -> Vibration:
    """Extremes of the steady response; infinite at resonance."""
    response = np.full((len(Vibration._fields), frequency_ratio.size), inf)
    calm = ~is_resonant(frequency_ratio, damping_ratio)
    if calm.any():
        frequency_ratio, damping_ratio = frequency_ratio[calm, None], damping_ratio[calm, None]
        wave = steady_vibration_wave(programme, frequency_ratio, damping_ratio)
        dwells = programme.table.first_panel[:-1][(programme.table.kind & DWELL) != 0]
        overshoot, acceleration = (
            wave_peak_magnitude(wave),
            wave_peak_magnitude(mass_acceleration_wave(wave, frequency_ratio)),
        )
        response[:, calm] = *overshoot, *acceleration, wave.amplitude[:, dwells].max(axis=1, initial=0.0)
    return Vibration(*response)


@once_per_setting
def least_elastic_contact_force(
    programme: Programme,
    stiffness: Any,
    damping: Any,
    mass: Any,
    constant: Any,
    frequency_ratio: Any,
    damping_ratio: Any,
) -> WaveExtreme:
    """Least F over the turn [N or N·mm], from ``force.force_weights_and_constant``, with its lower bound."""
    least = np.full((2, frequency_ratio.size), -inf)
    calm = ~is_resonant(frequency_ratio, damping_ratio)
    if calm.any():
        factors = tuple(factor[calm, None] for factor in (stiffness, damping, mass, constant))
        least[:, calm] = wave_minimum(
            elastic_contact_force_wave(programme, factors, frequency_ratio[calm, None], damping_ratio[calm, None])
        )
    return WaveExtreme(*least)


def elastic_contact_force_wave(
    programme: Programme, factors: tuple[Any, ...], frequency_ratio: Any, damping_ratio: Any
) -> Wave:
    """Contact force of the elastic train over the turn [N or N·mm], from its factors, each (rows, 1)."""
    stiffness, damping, mass, constant = factors
    table = programme.table
    y = table.coefficients.T[:, None]
    held: FloatArray = stiffness * y + np.zeros_like(mass)
    held[:-1] += damping * polynomial.polyder(y) / table.half_width
    held[0] += constant
    held[:2] += external_load_polynomials_by_panel(table)[:, None]
    return (
        mass_acceleration_wave(steady_vibration_wave(programme, frequency_ratio, damping_ratio), frequency_ratio)
        .times(mass)
        .plus_polynomial(held)
    )


def dynamic_factor(elastic_acceleration: Any, rigid_acceleration: float) -> Number:
    """Largest |ẍ| over largest |ÿ|; 0 if only ÿ is an impulse, 1 without motion."""
    endless = np.isinf(elastic_acceleration)
    over = 1.0 if rigid_acceleration == 0.0 else np.where(endless, 0.0, elastic_acceleration) / rigid_acceleration
    return np.where(endless, inf, over)[()]


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    setup, programme, numbers = case.setup, case.programme.tool, case.setup_per_design
    frequency_ratio = 2.0 * pi * numbers.dynamics.natural_frequency / numbers.omega
    train = frequency_ratio, numbers.dynamics.damping_ratio
    response = vibration_extremes(programme, *train)
    length, second = ("deg", "rad_s2") if setup.tool_turns else ("mm", "m_s2")
    unit = degrees(1.0) if setup.tool_turns else 1.0
    columns: dict[str, Any] = {
        f"overshoot_max_{length}": _enclosed_value_times_unit(response.overshoot, response.overshoot_bound, unit),
        f"acceleration_elastic_max_{second}": _enclosed_value_times_unit(
            response.acceleration, response.acceleration_bound, motion_unit_factor(numbers, 2)
        ),
        f"residual_vibration_max_{length}": response.residual * unit,
        "dynamic_factor": dynamic_factor(response.acceleration, derivative_peak(programme, 2, ALL_STROKES)),
    }
    if "contact_force_elastic_min_N" in wanted_quantities:
        lever = case.designs.arm_length if setup.angular else 1.0
        force = least_elastic_contact_force(
            programme, *force_weights_and_constant(numbers.dynamics, numbers.omega), *train
        )
        columns["contact_force_elastic_min_N"] = _enclosed_value_times_unit(force.value, force.bound, 1.0 / lever)
    return columns


def _enclosed_value_times_unit(value: Any, bound: Any, unit: Any) -> EnclosedValue:
    with np.errstate(invalid="ignore"):
        outward = np.where(value == bound, 0.0, np.subtract(bound, value))  # ∞ − ∞ is no width
    return EnclosedValue(value * unit, outward * unit, np.abs(value) * unit)


EFFECT = Effect(
    "vibration", applicable_quantities, evaluate_columns, missing_keys_by_quantity, is_of_motion=lambda setup: True
)
