"""Residual vibration of free laws: a second-order cone, since the response is linear in the motion.

The steady response of a linear train depends linearly on the motion, and so on the coefficients of free splines.
At the start of a dwell its free vibration has the amplitude A = √(a² + b²), with a and b linear in the
coefficients (``effects.vibration``). The largest A over the dwells is convex.

The rows of a and b come from the response itself, one coefficient raised at a time: no second model of the train,
and exact at any speed. No motion has less than none: the bound over all motions is 0.
"""

from dataclasses import replace
from functools import lru_cache
from math import pi

import numpy as np

from camopt.effects.case import Setup
from camopt.effects.vibration import response
from camopt.motion.programme import Programme
from camopt.motion.stroke import Stroke
from camopt.motion.table import DWELL
from camopt.numerics import FloatArray
from camopt.numerics.oscillator import is_resonant
from camopt.synthesis.splines import Splines

TERM = "residual_vibration"


def train_of(setup: Setup) -> tuple[float, float] | None:
    """ω_n/ω and the damping ratio of the follower train; None if the scene lacks either, or the train resonates."""
    frequency, damping = setup.dynamics.natural_frequency, setup.dynamics.damping_ratio
    if frequency is None or setup.omega is None:
        return None
    ratio = 2.0 * pi * frequency / setup.omega
    return None if is_resonant(ratio, damping) else (ratio, damping)


@lru_cache(maxsize=8)
def left_over(
    strokes: tuple[Stroke, ...], splines: Splines, ratio: float, damping: float
) -> tuple[FloatArray, ...]:
    """a and b at the start of each dwell, mm, by the coefficients of each moving stroke.

    For each moving stroke an array (dwells, 2, coefficients); the sum over strokes is that of the turn. Motions
    start at the first coefficient, 0, and end at the last, 1: what these two add is in the last column.
    """
    moving = [number for number, stroke in enumerate(strokes) if stroke.kind != DWELL]
    none = np.zeros(splines.count)
    whole = _states(strokes, splines, dict.fromkeys(moving, none), ratio, damping)
    rows = np.zeros((len(moving), *whole.shape, splines.count))
    for place, number in enumerate(moving):
        for column in range(1, splines.count - 1):
            raised = dict.fromkeys(moving, none) | {number: np.eye(splines.count)[column]}
            rows[place, ..., column] = _states(strokes, splines, raised, ratio, damping) - whole
    rows[0, ..., -1] = whole
    return tuple(rows)


def _states(
    strokes: tuple[Stroke, ...], splines: Splines, coefficients: dict[int, FloatArray], ratio: float, damping: float
) -> FloatArray:
    """a and b at the start of each dwell (dwells, 2)."""
    laws = {number: splines.law("", values) for number, values in coefficients.items()}
    turn = Programme(tuple(replace(s, law=laws.get(n)) for n, s in enumerate(strokes)))
    wave, table = response(turn, ratio, damping), turn.table
    dwells = table.first_panel[:-1][(table.kind & DWELL) != 0]
    return np.stack([wave.cosine[0, dwells], wave.sine[0, dwells]], axis=1)
