"""Lash: the speed of the follower where it takes up the play of a valve train, and where it gives it back.

Between the follower and the valve there is a clearance (lash), which heat and wear change. The valve opens where
the displacement rises through the lash, and closes where it falls through it: at these speeds the parts meet, and
the valve meets its seat. A ramp makes both small, wherever within lash ± variation that is.

Loads know no lash: the spring presses on the cam from displacement 0. One on the valve's side presses from the lash
on, F = F₀ + c·(y − lash) with its preload F₀: it is given as a preload of F₀ − c·lash, and loads at lifts below the
lash are then those of a follower that it would still press on.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 17 (valve trains; ramps).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from camopt.core.numerics import BISECTIONS, FloatArray
from camopt.core.numerics.piecewise import sign_changes
from camopt.core.numerics.stable_functions import matrix_product
from camopt.model.effects.effect import Effect, EvaluationBlock, Setup
from camopt.model.effects.motion import motion_scale
from camopt.model.effects.setting_cache import once_per_setting
from camopt.model.motion.programme import Programme
from camopt.model.motion.stroke import INWARD, OUTWARD, WAYS

LASH_OPEN = "lash_open_deg"


def _lash_speed_names(setup: Setup) -> dict[str, int]:
    """The names of the speeds, and the direction of motion of each."""
    unit = "rad_s" if setup.tool_turns else "m_s"
    ways = {"opening": OUTWARD, "closing": INWARD, "lash": OUTWARD | INWARD}
    return {f"{name}_speed_max_{unit}": way for name, way in ways.items()}


def offers(setup: Setup) -> tuple[str, ...]:
    return (*_lash_speed_names(setup), LASH_OPEN)


def lacks(setup: Setup) -> dict[str, tuple[str, ...]]:
    lash = () if setup.dynamics.lash is not None else ("follower.dynamics.lash",)
    speed = () if setup.omega is not None else ("cam.rpm",)
    keys = {**dict.fromkeys(_lash_speed_names(setup), (*speed, *lash)), LASH_OPEN: lash}
    return {name: wanting for name, wanting in keys.items() if wanting}


class LashSpeeds(NamedTuple):
    """Largest |y'| on the way out and on the way back; 0 where there is no such motion."""

    opening: Any
    closing: Any


@once_per_setting
def lash_speeds(programme: Programme, low: FloatArray, high: FloatArray) -> LashSpeeds:
    """The speeds at displacements from ``low`` to ``high``."""
    return LashSpeeds(*(_largest_speed(programme, low[:, None], high[:, None], way) for way in (OUTWARD, INWARD)))


def _largest_speed(programme: Programme, low: FloatArray, high: FloatArray, way: int) -> FloatArray:
    """Largest |y'| of motion one way at displacements between two levels (settings, 1)."""
    y, half_width = _moving_panels(programme, way)
    slope = polynomial.polyder(y) / half_width
    ends = polynomial.polyval(np.array([-1.0, 1.0]), y).T
    met = (ends.max(axis=0) >= low) & (ends.min(axis=0) <= high)
    first, last = np.sort([_level_places(y, low), _level_places(y, high)], axis=0)
    found = np.maximum(*(np.abs(polynomial.polyval(place, slope, tensor=False)) for place in (first, last)))
    for panel, u in sign_changes(np.asarray(polynomial.polyder(slope))):
        inside = (first[:, panel] < u) & (u < last[:, panel])
        peak = np.where(inside, abs(polynomial.polyval(u, slope[:, panel])), 0.0)
        found[:, panel] = np.maximum(found[:, panel], peak)
    return np.asarray(np.where(met, found, 0.0).max(axis=1, initial=0.0))


@once_per_setting
def angle_above(programme: Programme, level: FloatArray) -> FloatArray:
    """The range of cam angle over which the displacement is above a level, rad."""
    y, half_width = _moving_panels(programme, WAYS)
    (start, end), place = polynomial.polyval(np.array([-1.0, 1.0]), y).T, _level_places(y, level[:, None])
    moving = np.where(end > start, 1.0 - place, place + 1.0)
    return matrix_product(np.where(start == end, 2.0 * (start > level[:, None]), moving), half_width)


def _moving_panels(programme: Programme, ways: int) -> tuple[FloatArray, FloatArray]:
    """Powers (powers, panels) and half-widths of the panels on which the follower moves some ways."""
    table, chosen = programme.table, programme.panels_of(ways)
    return table.coefficients[chosen].T, table.half_width[chosen]


def _level_places(y: FloatArray, level: FloatArray) -> FloatArray:
    """The place u in each panel where a monotone displacement reaches a level (settings, 1): (settings, panels).

    The nearer end if it does not.
    """
    start, end = polynomial.polyval(np.array([-1.0, 1.0]), y).T
    nearer = np.where(np.abs(end - level) < np.abs(start - level), 1.0, -1.0)
    setting, panel = np.nonzero((np.minimum(start, end) < level) & (level < np.maximum(start, end)))
    below, above = np.where(end > start, 1.0, -1.0)[panel] * np.array([[-1.0], [1.0]])
    for _ in range(BISECTIONS):
        middle = 0.5 * (below + above)
        under = polynomial.polyval(middle, y[:, panel], tensor=False) < level[setting, 0]
        below, above = np.where(under, middle, below), np.where(under, above, middle)
    nearer[setting, panel] = 0.5 * (below + above)
    return nearer


def run(case: EvaluationBlock, wanted: frozenset[str]) -> dict[str, Any]:
    programme, own = case.programme.tool, case.setup_per_design
    lash, variation = own.dynamics.lash, own.dynamics.lash_variation
    columns: dict[str, Any] = {LASH_OPEN: np.degrees(angle_above(programme, lash))}
    if own.omega is not None:
        found = lash_speeds(programme, lash - variation, lash + variation)
        largest = {OUTWARD: found.opening, INWARD: found.closing, OUTWARD | INWARD: np.maximum(*found)}
        columns |= {
            name: largest[ways] * motion_scale(own, 1) for name, ways in _lash_speed_names(case.setup).items()
        }
    return {name: column for name, column in columns.items() if name in wanted}


EFFECT = Effect("lash", offers, run, lacks, is_of_motion=lambda setup: True)
