"""Lash: the speed of the follower where it takes up the play of a valve train, and where it gives it back.

Between the follower and the valve there is a clearance (lash), which heat and wear change. The valve opens where
the displacement rises through the lash, and closes where it falls through it: at these speeds the parts meet, and
the valve meets its seat. A ramp makes both small, wherever within lash ± variation that is.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 17 (valve trains; ramps).
"""

from collections.abc import Iterator
from functools import lru_cache, partial
from math import degrees
from typing import Any

import numpy as np
from numpy.polynomial import polynomial

from camopt.effects.case import Case, Effect, Setup
from camopt.effects.motion import scale
from camopt.motion.programme import Programme
from camopt.motion.table import INWARD, OUTWARD, WAYS
from camopt.numerics import FloatArray
from camopt.numerics.piecewise import sign_changes

LASH_OPEN = "lash_open_deg"


def _speeds(setup: Setup) -> dict[str, int]:
    """The names of the speeds, and the direction of motion of each."""
    unit = "rad_s" if setup.angular else "m_s"
    ways = {"opening": OUTWARD, "closing": INWARD, "lash": OUTWARD | INWARD}
    return {f"{name}_speed_max_{unit}": way for name, way in ways.items()}


def offers(setup: Setup) -> tuple[str, ...]:
    return (*_speeds(setup), LASH_OPEN)


def lacks(setup: Setup) -> dict[str, tuple[str, ...]]:
    lash = () if setup.dynamics.lash is not None else ("follower.dynamics.lash",)
    speed = () if setup.omega is not None else ("cam.rpm",)
    keys = {**dict.fromkeys(_speeds(setup), (*speed, *lash)), LASH_OPEN: lash}
    return {name: wanting for name, wanting in keys.items() if wanting}


@lru_cache(maxsize=4096)
def speed_within(programme: Programme, low: float, high: float, ways: int) -> float:
    """Largest |y'| of motion in given directions at displacements from ``low`` to ``high``; 0 if there is none."""
    largest = 0.0
    for y, half_width in _panels(programme, ways):
        ends = polynomial.polyval(np.array([-1.0, 1.0]), y)
        if ends.max() < low or ends.min() > high:
            continue
        first, last = sorted((_place(y, low), _place(y, high)))
        slope = polynomial.polyder(y) / half_width
        places = [first, last, *(u for u in _roots(polynomial.polyder(slope)) if first < u < last)]
        largest = max(largest, float(np.abs(polynomial.polyval(np.array(places), slope)).max()))
    return largest


@lru_cache(maxsize=4096)
def angle_above(programme: Programme, level: float) -> float:
    """The range of cam angle over which the displacement is above a level, rad."""
    above = 0.0
    for y, half_width in _panels(programme, WAYS):
        start, end = polynomial.polyval(np.array([-1.0, 1.0]), y)
        if start == end:
            above += 2 * half_width * (start > level)
        else:
            above += half_width * (1.0 - _place(y, level) if end > start else _place(y, level) + 1.0)
    return float(above)


def _panels(programme: Programme, ways: int) -> Iterator[tuple[FloatArray, float]]:
    """Powers and half-width of each panel on which the follower moves some ways."""
    table = programme.table
    for k in np.flatnonzero(programme.panels_of(ways)):
        yield table.coefficients[k], table.half_width[k]


def _place(y: FloatArray, level: float) -> float:
    """The place u in a panel where a monotone displacement reaches a level; the nearer end if it does not."""
    start, end = polynomial.polyval(np.array([-1.0, 1.0]), y)
    nearer = 1.0 if abs(end - level) < abs(start - level) else -1.0
    if not min(start, end) < level < max(start, end):
        return nearer
    return next(iter(_roots(np.array([y[0] - level, *y[1:]]))), nearer)


def _roots(powers: FloatArray) -> list[float]:
    """The roots of a polynomial inside a panel where its sign may change."""
    return [u for _, u in sign_changes(np.asarray(powers, dtype=float)[:, None])]


def run(case: Case, wanted: frozenset[str]) -> dict[str, Any]:
    setup, programme = case.setup, case.programme

    def fastest(each: Setup, ways: int) -> float:
        lash, variation = each.dynamics.lash, each.dynamics.lash_variation
        return speed_within(programme, lash - variation, lash + variation, ways)

    columns: dict[str, Any] = {
        LASH_OPEN: case.by_setting(lambda each: degrees(angle_above(programme, each.dynamics.lash)))
    }
    for name, ways in _speeds(setup).items() if setup.omega is not None else ():
        columns[name] = case.by_setting(partial(fastest, ways=ways)) * scale(case.each, 1)
    return {name: column for name, column in columns.items() if name in wanted}


EFFECT = Effect("lash", offers, run, lacks, of_motion=lambda setup: True)
