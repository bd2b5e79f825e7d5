"""Lash: the speed of the follower where a valve train takes up its lash, and where the valve returns to its seat.

The lash is a clearance between follower and valve, which heat and wear change. The valve opens where the
displacement rises through the lash, and closes where it falls through it. The follower's speed there is the speed
at which the parts meet, and the valve meets its seat. A ramp keeps both speeds small everywhere within lash ±
variation.

Loads do not include the lash: the spring acts on the follower from displacement 0. A spring on the valve's side
acts only above the lash, F = F₀ + c·(y − lash) with its preload F₀. Give it as a preload of F₀ − c·lash; below the
lash the loads are then those of a spring that still acts.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 17 (valve trains; ramps).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import BISECTIONS, FloatArray
from camopt.core.numerics.piecewise import sign_changes
from camopt.core.numerics.stable_functions import matrix_product
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup
from camopt.model.effects.motion import motion_unit_factor
from camopt.model.effects.setting_cache import once_per_setting
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import INWARD, OUTWARD, WAYS

LASH_OPEN = "lash_open_deg"


def _lash_speed_directions(setup: Setup) -> dict[str, int]:
    """The names of the speeds, with the direction of motion of each."""
    unit = "rad_s" if setup.tool_turns else "m_s"
    ways = {"opening": OUTWARD, "closing": INWARD, "lash": OUTWARD | INWARD}
    return {f"{name}_speed_max_{unit}": way for name, way in ways.items()}


def missing_keys_by_quantity(setup: Setup) -> dict[str, tuple[str, ...]]:
    lash = () if setup.dynamics.lash is not None else ("follower.dynamics.lash",)
    speed = () if setup.omega is not None else ("cam.rpm",)
    keys = {**dict.fromkeys(_lash_speed_directions(setup), (*speed, *lash)), LASH_OPEN: lash}
    return {name: wanting for name, wanting in keys.items() if wanting}


class LashSpeeds(NamedTuple):
    """Largest |y'| on the way out and on the way back; 0 without such a motion."""

    opening: Any
    closing: Any


@once_per_setting
def lash_speeds(programme: Programme, least_lash: FloatArray, largest_lash: FloatArray) -> LashSpeeds:
    """Largest speeds at displacements from ``least_lash`` to ``largest_lash``."""
    return LashSpeeds(
        *(
            _largest_lash_speed(programme, least_lash[:, None], largest_lash[:, None], way)
            for way in (OUTWARD, INWARD)
        )
    )


def _largest_lash_speed(programme: Programme, low: FloatArray, high: FloatArray, direction_bit: int) -> FloatArray:
    """Largest |y'| in one direction at displacements between two levels (settings, 1)."""
    y, half_width = _polynomials_of_moving_panels(programme, direction_bit)
    slope = polynomial.polyder(y) / half_width
    ends = polynomial.polyval(np.array([-1.0, 1.0]), y).T
    overlaps = (ends.max(axis=0) >= low) & (ends.min(axis=0) <= high)
    first, last = np.sort([_places_reaching_level(y, low), _places_reaching_level(y, high)], axis=0)
    speed = np.maximum(*(np.abs(polynomial.polyval(place, slope, tensor=False)) for place in (first, last)))
    for panel, u in sign_changes(np.asarray(polynomial.polyder(slope))):
        inside = (first[:, panel] < u) & (u < last[:, panel])
        peak = np.where(inside, abs(polynomial.polyval(u, slope[:, panel])), 0.0)
        speed[:, panel] = np.maximum(speed[:, panel], peak)
    return np.asarray(np.where(overlaps, speed, 0.0).max(axis=1, initial=0.0))


@once_per_setting
def angle_span_above_level(programme: Programme, level: FloatArray) -> FloatArray:
    """Range of cam angle over which the displacement is above a level [rad]."""
    y, half_width = _polynomials_of_moving_panels(programme, WAYS)
    (start, end), place = polynomial.polyval(np.array([-1.0, 1.0]), y).T, _places_reaching_level(y, level[:, None])
    moving = np.where(end > start, 1.0 - place, place + 1.0)
    return matrix_product(np.where(start == end, 2.0 * (start > level[:, None]), moving), half_width)


def _polynomials_of_moving_panels(programme: Programme, direction_bits: int) -> tuple[FloatArray, FloatArray]:
    """Coefficients (powers, panels) and half-widths of the panels with some directions of motion."""
    table, panels = programme.table, programme.panels_with_kinds(direction_bits)
    return table.coefficients[panels].T, table.half_width[panels]


def _places_reaching_level(displacement_polynomials: FloatArray, level: FloatArray) -> FloatArray:
    """Place u in each panel where a monotone displacement reaches a level (settings, 1): (settings, panels).

    If it does not reach the level, the place is the nearer end.
    """
    start, end = polynomial.polyval(np.array([-1.0, 1.0]), displacement_polynomials).T
    nearer = np.where(np.abs(end - level) < np.abs(start - level), 1.0, -1.0)
    setting, panel = np.nonzero((np.minimum(start, end) < level) & (level < np.maximum(start, end)))
    below, above = np.where(end > start, 1.0, -1.0)[panel] * np.array([[-1.0], [1.0]])
    for _ in range(BISECTIONS):
        middle = 0.5 * (below + above)
        under = polynomial.polyval(middle, displacement_polynomials[:, panel], tensor=False) < level[setting, 0]
        below, above = np.where(under, middle, below), np.where(under, above, middle)
    nearer[setting, panel] = 0.5 * (below + above)
    return nearer


def evaluate_columns(case: EvaluationBlock, wanted_quantities: frozenset[str]) -> dict[str, Any]:
    programme, setup = case.programme.tool, case.setup_per_design
    lash, variation = setup.dynamics.lash, setup.dynamics.lash_variation
    columns: dict[str, Any] = {LASH_OPEN: np.degrees(angle_span_above_level(programme, lash))}
    if setup.omega is not None:
        speeds = lash_speeds(programme, lash - variation, lash + variation)
        largest = {OUTWARD: speeds.opening, INWARD: speeds.closing, OUTWARD | INWARD: np.maximum(*speeds)}
        columns |= {
            name: largest[ways] * motion_unit_factor(setup, 1)
            for name, ways in _lash_speed_directions(case.setup).items()
        }
    return {name: column for name, column in columns.items() if name in wanted_quantities}


EFFECT = Effect(
    "lash",
    lambda setup: (*_lash_speed_directions(setup), LASH_OPEN),
    evaluate_columns,
    missing_keys_by_quantity,
    is_of_motion=lambda setup: True,
    holds_between_speeds=True,
)
